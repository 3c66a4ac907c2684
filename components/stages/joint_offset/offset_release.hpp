// SPDX-License-Identifier: GPL-2.0-or-later
// Where an offset becomes a part of the position of a joint: by a release at machine off, which is wanted, or
// by homing, which is a fault.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// Turns a part of an offset into position when the machine is turned off. Motion copies the feedback into its
// command then. So the feedback contains that part from the next period on, and the command of the drive,
// which stays where it is, has it from motion. If the machine is on again in that period, all is as before.
//
// A source that was released counts as 0 until it has been 0.
template <std::size_t N>
class OffsetRelease {
public:
    using Which = std::array<bool, N>;

    struct Sums {
        double all = 0, others = 0;  // others: of the sources that are not to be released
    };

    // The sources that count, once in each period.
    template <class Sources>
    Sums sum(const Sources& sources, const Which& which) noexcept {
        Sums sums;
        any_ = ignores_ = strokes_ = false;
        which_ = which;
        for (std::size_t i = 0; i < N; ++i) {
            const double source = sources[i];
            released_[i] = released_[i] && which[i] && source != 0;
            any_ |= which[i];
            ignores_ |= released_[i];
            if (released_[i]) continue;
            sums.all += source;
            if (!which[i]) sums.others += source;
            strokes_ |= which[i] && source != 0;
        }
        return sums;
    }

    // What stays of an offset: all of it where no source to be released is in it, and the others where it
    // follows its sources; else as much of it as the others can explain.
    void note(double applied, double others, bool follows) noexcept {
        out_ = strokes_ || (out_ && !follows);
        stays_ = !out_     ? applied
                 : follows ? others
                           : std::clamp(applied, std::min(others, 0.0), std::max(others, 0.0));
    }

    // After motion. True if the offset becomes stays() in this period.
    bool step(bool on) noexcept {
        const bool falls = on_ && !on, ends = announced_ && shown_ && !on;
        on_ = on;
        announced_ = falls ? any_ : announced_ && !ends && !on;
        shown_ = false;
        done_ = !on && (done_ || ends);
        if (ends) {
            released_ = which_;
            out_ = false;
        }
        return ends;
    }

    // Before motion: the part of the offset that the feedback does not contain.
    double in_feedback(double applied) noexcept {
        shown_ = announced_;
        return announced_ ? stays_ : applied;
    }

    double stays() const noexcept { return stays_; }
    bool any() const noexcept { return any_; }            // source is to be released
    bool out() const noexcept { return any_ && out_; }    // and is in the offset
    bool pending() const noexcept { return announced_; }  // the offset must not change
    bool released() const noexcept { return done_ || shown_; }
    bool ignores() const noexcept { return ignores_; }  // a source that is not 0

private:
    Which which_{}, released_{};
    double stays_ = 0;
    bool any_ = false, ignores_ = false, strokes_ = false, out_ = false;
    bool on_ = false, announced_ = false, shown_ = false, done_ = false;
};

// Homing moves the origin of motion at the switch, long before the joint is homed, and by a feedback without
// the offset. Once the offset is released, the origin would be wrong by it.
class JointOrigin {
public:
    // The joint was homed with an offset in force, and not again since.
    bool wrong() const noexcept { return wrong_; }

    // `origin`: the command for the drive without the position of the joint; the last one if it is not known.
    void step(bool homed, double origin, bool has_offset, double slack) noexcept {
        if (homed_ && !homed) wrong_ = false;
        const bool homes = !homed_ || !homed;
        if (homes && has_offset && std::abs(origin - origin_) > slack) wrong_ = true;
        origin_ = origin;
        homed_ = homed;
    }
    double last() const noexcept { return origin_; }

private:
    double origin_ = 0;
    bool homed_ = false, wrong_ = false;
};

}  // namespace plumb
