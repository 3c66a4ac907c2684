// SPDX-License-Identifier: GPL-2.0-or-later
// What the simulated stroking axes share: a command that comes late, and the dead points of the load.
#pragma once

#include "hal/component.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

class LateCommand {
public:
    void fill(double command) noexcept { late_.fill(command); }
    void take(double command) noexcept {
        newest_ = (newest_ + 1) % late_.size();
        late_[newest_] = command;
    }
    // The command of `delay` s ago, between two periods of dt s.
    double at(double delay, double dt) const noexcept {
        const double periods = std::clamp(delay / dt, 0.0, static_cast<double>(late_.size() - 2));
        const auto whole = static_cast<std::size_t>(periods);
        const double part = periods - static_cast<double>(whole);
        const auto back = [this](std::size_t n) {
            return late_[(newest_ + late_.size() - n) % late_.size()];
        };
        return back(whole) * (1 - part) + back(whole + 1) * part;
    }

private:
    std::array<double, 64> late_{};
    std::size_t newest_ = 0;
};

class StrokedLoad final : public hal::Group {
public:
    using Group::Group;

    void start(double load) noexcept { farthest_ = load; }

    // Takes the position of the load after dt s. True in the period in which it has turned.
    bool step(double load, double dt) noexcept {
        time_ += dt;
        position_ = load;
        const double sign = upward_ ? 1 : -1, least = 0.05;  // mm, no reversal of its own
        if (sign * (load - farthest_) >= 0) {
            farthest_ = load;
            farthest_time_ = time_;
            return false;
        }
        if (!(sign * (farthest_ - load) > least)) return false;
        if (upward_) {
            upper_ = farthest_;
        } else {
            lower_ = farthest_;
            cycle_time_ = farthest_time_ - lower_time_;
            lower_time_ = farthest_time_;
        }
        upward_ = !upward_;
        farthest_ = load;
        return true;
    }

private:
    hal::Out<double> position_{this, "truth-position", "mu", "Position of the load."};
    hal::Out<double> upper_{this, "truth-upper", "mu", "Upper dead point of the last stroke."};
    hal::Out<double> lower_{this, "truth-lower", "mu", "Lower dead point of the last stroke."};
    hal::Out<double> cycle_time_{this, "truth-cycle-time", "s", "Time of the last cycle."};

    bool upward_ = true;
    double farthest_ = 0, farthest_time_ = 0, lower_time_ = 0, time_ = 0;
};

}  // namespace plumb
