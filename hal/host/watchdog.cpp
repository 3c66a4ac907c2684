// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/watchdog.hpp"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <thread>

#include "hal/host/functions.hpp"
#include "hal/host/scheduler.hpp"

namespace plumb::host {

namespace {

std::atomic<bool> armed{false};
std::atomic<unsigned long> turn{0};  // how often it was armed
std::mutex module_lock;
std::string module;  // that is being loaded; empty: realtime functions run

[[noreturn]] void end(const std::string& what, const char* deed, std::chrono::seconds patience) {
    std::fprintf(stderr, "plumb-host: %s has not %s for %lld s: the run ends\n", what.c_str(), deed,
                 static_cast<long long>(patience.count()));
    _exit(1);
}

void watch() {
    unsigned long seen_turn = 0;
    Nanoseconds seen_time = -1;
    std::chrono::seconds stuck{0};
    for (;;) {
        std::this_thread::sleep_for(std::chrono::seconds(1));
        const std::lock_guard lock(module_lock);
        const unsigned long now_turn = turn;
        const Nanoseconds now_time = scheduler().seen_time();
        const bool loads = !module.empty();
        const bool under_way = armed && (loads || scheduler().runs());
        if (!under_way || now_turn != seen_turn || now_time != seen_time) stuck = std::chrono::seconds(-1);
        ++stuck;
        seen_turn = now_turn;
        seen_time = now_time;
        if (loads && stuck >= Watchdog::load_patience) end(module, "been loaded", Watchdog::load_patience);
        if (loads || stuck < Watchdog::function_patience) continue;
        const std::string function = running_function();
        end(function.empty() ? "a realtime function" : function, "returned", Watchdog::function_patience);
    }
}

void arm() {
    static const bool started = [] {
        // Signals are for the first thread.
        sigset_t all, before;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before);
        std::thread(watch).detach();
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
        return true;
    }();
    static_cast<void>(started);
    ++turn;
    armed = true;
}

}  // namespace

Watchdog::Watchdog() {
    arm();
}

Watchdog::Watchdog(const std::string& its_module) {
    {
        const std::lock_guard lock(module_lock);
        module = its_module;
    }
    arm();
}

Watchdog::~Watchdog() {
    armed = false;
    const std::lock_guard lock(module_lock);
    module.clear();
}

}  // namespace plumb::host
