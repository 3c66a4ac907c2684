// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/waiting.hpp"

#include <pthread.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

namespace plumb {

// Writes a line to standard error. Called by threads.
using Say = std::function<void(const std::string&)>;

// A thread that talks to a device: Talk(State&).run() returns soon after state.pauses.stop(). Should the
// device hold it in a system call, the thread is left behind with its state, and the program ends without it.
template <class State, class Talk>
class Worker {
public:
    template <class... Arguments>
    explicit Worker(Arguments&&... arguments)
        : shared_(std::make_shared<Shared>(std::forward<Arguments>(arguments)...)) {}
    Worker(Worker&&) = default;
    ~Worker() {
        if (shared_) stop(0.5);
    }

    State& state() { return shared_->state; }

    void start() {
        // Signals are for the program's first thread.
        sigset_t all, before;
        sigfillset(&all);
        pthread_sigmask(SIG_BLOCK, &all, &before);
        shared_->running = true;
        std::thread([shared = shared_] {
            try {
                Talk(shared->state).run();
            } catch (const std::exception& error) {
                shared->state.say(error.what());
            }
            shared->running = false;
        }).detach();
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
    }

    void ask_to_stop() { shared_->state.pauses.stop(); }

    // Returns when the thread has ended, or the time is over.
    void stop(double seconds) {
        ask_to_stop();
        for (const double until = seconds_now() + seconds; shared_->running && seconds_now() < until;)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }

private:
    struct Shared {
        template <class... Arguments>
        explicit Shared(Arguments&&... arguments) : state(std::forward<Arguments>(arguments)...) {}

        State state;
        std::atomic<bool> running{false};
    };

    std::shared_ptr<Shared> shared_;
};

// Ends the workers of all links of a deque, each in at most half a second from now.
template <class Links>
void stop_all(Links& links) {
    for (auto& link : links) link.worker.ask_to_stop();
    const double until = seconds_now() + 0.5;
    for (auto& link : links) link.worker.stop(until - seconds_now());
}

}  // namespace plumb
