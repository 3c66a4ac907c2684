// SPDX-License-Identifier: GPL-2.0-or-later
// Waiting for a device, in such a way that the end of the program never waits for it.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <system_error>
#include <utility>

namespace plumb {

// Seconds of a clock that never goes back.
inline double seconds_now() noexcept {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// A file descriptor that is closed with its owner.
class Descriptor {
public:
    explicit Descriptor(int number = -1) noexcept : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() { close(); }

    int number() const noexcept { return number_; }
    explicit operator bool() const noexcept { return number_ >= 0; }
    void close() noexcept {
        if (number_ >= 0) ::close(std::exchange(number_, -1));
    }

private:
    int number_;
};

// The pauses of a thread that talks to a device. Another thread ends them all, once and for good, by stop().
class Pauses {
public:
    enum class Woken { ready, time, stopped };

    Pauses() : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
        if (!event_) throw std::system_error(errno, std::generic_category(), "eventfd");
    }

    void stop() noexcept {
        stopped_ = true;
        const std::uint64_t one = 1;
        [[maybe_unused]] const auto written = write(event_.number(), &one, sizeof one);
    }
    bool stopped() const noexcept { return stopped_; }

    // Until the descriptor has these events, or an error, or the time has come. Descriptor -1 is none.
    Woken wait(int descriptor, short events, double until) noexcept {
        for (;;) {
            ++turns_;
            if (stopped_) return Woken::stopped;
            const double left = until - seconds_now();
            pollfd waiting[2] = {{event_.number(), POLLIN, 0}, {descriptor, events, 0}};
            // A moment longer than the time that is left: a shorter one would poll again and again.
            const double slice = std::clamp(left * 1000 + 1, 0.0, 100.0);
            const int found = poll(waiting, 2, left > 0 ? static_cast<int>(slice) : 0);
            if (found > 0 && waiting[1].revents != 0) return Woken::ready;
            if (left <= 0) return stopped_ ? Woken::stopped : Woken::time;
        }
    }
    Woken wait(double until) noexcept { return wait(-1, 0, until); }

    // Grows ten times a second or faster while the thread is alive.
    std::uint32_t turns() const noexcept { return turns_; }

private:
    Descriptor event_;
    std::atomic<bool> stopped_{false};
    std::atomic<std::uint32_t> turns_{0};
};

}  // namespace plumb
