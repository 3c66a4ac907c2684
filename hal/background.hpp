// SPDX-License-Identifier: GPL-2.0-or-later
// Runs the background() of a module's instances: on a thread of the module, or, in the virtual-time host,
// between two periods, so that a bench stays deterministic.
#pragma once

#include "hal/component.hpp"
#include "hal/message.hpp"

#include <pthread.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <exception>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

// Exported by the virtual-time host; null everywhere else.
extern "C" {
__attribute__((weak)) void plumb_host_register_background(void (*work)(void*), void* argument);
__attribute__((weak)) void plumb_host_unregister_background(void (*work)(void*), void* argument);
}

namespace plumb::hal {

class Background {
public:
    // The longest time that a request waits before the work begins. update() cannot wake the thread: that is
    // a system call.
    static constexpr std::chrono::milliseconds longest_pause{100};
    // rtapi_app locks all of it in memory. Reading three tables of 4096 rows takes 12 KiB.
    static constexpr std::size_t stack_size = 256 * 1024;

    // Null if no instance has work. Throws std::system_error if there is no thread for it.
    static std::unique_ptr<Background> of(const std::vector<std::unique_ptr<Component>>& instances,
                                          std::chrono::nanoseconds pause = longest_pause) {
        std::vector<Component*> working;
        for (const auto& instance : instances)
            if (instance->has_background()) working.push_back(instance.get());
        return working.empty() ? nullptr
                               : std::unique_ptr<Background>(new Background(std::move(working), pause));
    }
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;

    ~Background() {
        if (plumb_host_unregister_background) {
            plumb_host_unregister_background(&Background::work, this);
        } else {
            stopping_ = true;
            pthread_join(thread_, nullptr);
        }
    }

private:
    Background(std::vector<Component*> instances, std::chrono::nanoseconds pause)
        : instances_(std::move(instances)), pause_(std::min<std::chrono::nanoseconds>(pause, longest_pause)) {
        if (plumb_host_register_background)
            plumb_host_register_background(&Background::work, this);
        else
            start_thread();
    }

    void start_thread() {
        // The program's own threads take the signals. This one takes only the signals of its own failures.
        sigset_t blocked, before;
        sigfillset(&blocked);
        for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT})
            sigdelset(&blocked, number);
        pthread_attr_t attributes;
        pthread_attr_init(&attributes);
        pthread_attr_setstacksize(&attributes, stack_size);
        pthread_sigmask(SIG_BLOCK, &blocked, &before);
        const int error = pthread_create(&thread_, &attributes, &Background::run, this);
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
        pthread_attr_destroy(&attributes);
        if (error != 0) throw std::system_error(error, std::generic_category(), "thread for the background");
    }

    static void* run(void* self) {
        const auto& background = *static_cast<Background*>(self);
        for (; !background.stopping_; std::this_thread::sleep_for(background.pause_)) work(self);
        return nullptr;
    }

    // A lack of memory here must not end the program in which realtime runs.
    static void work(void* self) noexcept {
        auto& background = *static_cast<Background*>(self);
        bool failed = false;
        for (Component* const instance : background.instances_) {
            try {
                instance->background();
                continue;
            } catch (const std::exception& error) {
                if (!background.failed_) report_error(error.what());
            } catch (...) {
                if (!background.failed_) report_error("unknown exception");
            }
            failed = true;
        }
        background.failed_ = failed;  // reported once: the work is tried again at once
    }

    const std::vector<Component*> instances_;
    const std::chrono::nanoseconds pause_;
    bool failed_ = false;  // of the thread
    std::atomic<bool> stopping_{false};
    pthread_t thread_{};
};

}  // namespace plumb::hal
