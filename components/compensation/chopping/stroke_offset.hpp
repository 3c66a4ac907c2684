// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/guarded_offset.hpp"
#include "components/compensation/chopping/homed_watch.hpp"

#include <cmath>

namespace plumb {

// The offset of an axis from its position: it follows the stroke, and rests where a motion has ended. All
// positions are in mu.
class StrokeOffset {
public:
    static constexpr double nothing = 1e-9;

    struct Period {
        bool moves = false, ends = false;  // ends: the motion has ended in this period
        double command = 0, mean = 0;      // of the motion, from the position; mean: without the lead
        bool on = false, homed = false;    // the machine, the joint
        bool ramps = false;                // a stage takes the offset of a joint that is not homed away
    };

    void allow(const GuardedOffset::Limits& limits, bool moves, double farthest, double dt) noexcept {
        guarded_.allow(limits, moves, farthest, dt);
    }

    // Stays where it is.
    void freeze() noexcept { rest_ = value(); }
    // Is at a place at once: the axis has been moved there.
    void put(double place) noexcept {
        guarded_.put(place);
        rest_ = place;
    }
    // It has become a part of the position.
    void release() noexcept {
        rest_ = 0;
        guarded_.release();
    }

    void step(const Period& now, double dt) noexcept {
        if (now.ends) rest_ = std::abs(now.mean) <= nothing ? 0 : now.mean;
        switch (homed_watch_.step(now.homed, now.ramps, dt)) {
            case HomedWatch::Offset::as_applied: rest_ = value(); break;
            case HomedWatch::Offset::none: rest_ = 0; break;
            case HomedWatch::Offset::stays: break;
        }
        // Where a bound has stopped it, a larger one must not move it later.
        if (!now.moves && guarded_.kept_back() && guarded_.stands()) rest_ = value();
        guarded_.step(now.moves ? now.command : rest_, !now.on && now.homed, dt);
    }

    double value() const noexcept { return guarded_.value(); }
    double rest() const noexcept { return rest_; }
    bool kept_back() const noexcept { return guarded_.kept_back(); }
    bool refused() const noexcept { return guarded_.refused(); }  // a bound below the present offset

private:
    GuardedOffset guarded_;
    HomedWatch homed_watch_;
    double rest_ = 0;
};

}  // namespace plumb
