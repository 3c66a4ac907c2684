// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/pace.hpp"

#include <algorithm>
#include <cmath>

#include "hal/clock_speed.hpp"

namespace plumb::host {

namespace {

constexpr std::chrono::milliseconds max_arrears{100};  // by the computer's clock

double clock_speed = 1;

}  // namespace

void set_clock_speed(double speed) {
    clock_speed = speed;
}

Pace::Pace(double speed) : speed_(speed), origin_(Clock::now()) {}

bool Pace::free() const {
    return std::isinf(speed_);
}

Nanoseconds Pace::instant(Clock::time_point now) const {
    if (free()) return never;
    const double passed = std::chrono::duration<double, std::nano>(now - origin_).count();
    return origin_instant_ + static_cast<Nanoseconds>(passed * speed_);
}

Nanoseconds Pace::due(Clock::time_point now, Nanoseconds reached) {
    if (free()) return never;
    const auto arrears = -until(reached, now);
    if (arrears > max_arrears) {
        given_up_ += arrears - max_arrears;
        origin_ = now - max_arrears;
        origin_instant_ = reached;
    }
    return instant(now);
}

std::chrono::nanoseconds Pace::until(Nanoseconds instant, Clock::time_point now) const {
    const double span = std::min(static_cast<double>(instant - origin_instant_) / speed_, 1e18);  // 30 years
    return origin_ + std::chrono::nanoseconds(static_cast<std::int64_t>(std::ceil(span))) - now;
}

}  // namespace plumb::host

double plumb_host_clock_speed() noexcept {
    return plumb::host::clock_speed;
}
