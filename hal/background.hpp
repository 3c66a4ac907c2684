// SPDX-License-Identifier: GPL-2.0-or-later
// Runs the background() of a module's instances: on a thread of the module, or, in the virtual-time host,
// between two periods, so that a bench stays deterministic.
#pragma once

#include "hal/component.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

// Exported by the virtual-time host; null everywhere else.
extern "C" {
__attribute__((weak)) void plumb_host_register_background(void (*work)(void*), void* argument);
__attribute__((weak)) void plumb_host_unregister_background(void (*work)(void*), void* argument);
}

namespace plumb::hal {

class Background {
public:
    static constexpr std::chrono::milliseconds pause{10};  // what a request waits at most, besides the work

    explicit Background(const std::vector<std::unique_ptr<Component>>& instances) : instances_(instances) {
        if (plumb_host_register_background)
            plumb_host_register_background(&Background::work, this);
        else
            thread_ = std::thread([this] {
                for (; !stopping_; std::this_thread::sleep_for(pause)) work(this);
            });
    }
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;

    ~Background() {
        if (thread_.joinable()) {
            stopping_ = true;
            thread_.join();
        } else if (plumb_host_unregister_background) {
            plumb_host_unregister_background(&Background::work, this);
        }
    }

private:
    static void work(void* self) {
        for (const auto& instance : static_cast<Background*>(self)->instances_) instance->background();
    }

    const std::vector<std::unique_ptr<Component>>& instances_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

}  // namespace plumb::hal
