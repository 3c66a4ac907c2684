// SPDX-License-Identifier: GPL-2.0-or-later
// From the sum of the sources to the offset of a joint: mathematics without pins. In mu, s.
//
//     TaperedOffset::take     settings and soft limits, each as far as the present offset allows
//     TaperedOffset::follow   once in each period: the sum, ramped (source_), then within the soft limits and
//                             with limited acceleration (applied_)
//     SoftLimits              the largest offset and speed at a place of the joint, by tapered()
//
// Both steps are an AccelerationLimit. The taper has the offset end at a soft limit without a stop: beside it
// the sources have a quarter of the acceleration, and motion the rest.
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// The part of an offset that may be applied before a soft limit, so that joint and offset together neither
// pass the limit nor stop dead at it:
//
//     f(d) = share (d - 2/3 d^1.5 / length^0.5)   for 0 < d < length = 3 offset / share
//     f(d) = offset                               for d >= length
//     f(d) = 0                                    for d <= 0
//
// d is the distance of the joint from the limit. The slope f' = share (1 - (d / length)^0.5) is at most
// share <= 1, so f <= d. A joint that can still stop before the limit, v² <= 2 a d, by |acceleration| <= a,
// gives
//
//     |f"| = |f'' v² + f' acceleration| <= share a
//
// because  2 d |f''| + f' = share  everywhere: the offset adds at most share times the joint's own
// acceleration, on the way to the limit and away from it, at any speed.
//
// offset, distance: mu; 0 < share <= 1. The offset is positive towards the limit; an offset away from it
// needs no taper.
inline double taper_length(double offset, double share) noexcept {
    return 3 * offset / share;
}

inline double tapered(double offset, double distance, double share) noexcept {
    if (offset <= 0) return offset;
    if (distance <= 0) return 0;
    const double length = taper_length(offset, share);
    if (distance >= length) return offset;
    return std::min(share * distance * (1 - std::sqrt(distance / length) * (2.0 / 3)), offset);
}

// The soft limits of a joint that also carries an offset, and the largest offset and speed that respect them.
// Lengths are in mu, speeds in mu/s, accelerations in mu/s2. A direction is any number with its sign. All
// functions but valid() require valid limits.
struct SoftLimits {
    static constexpr double farthest = 1e9;                 // mu
    static constexpr double softest = 1e-3, hardest = 1e9;  // mu/s2

    double min = 0, max = 0;         // of the joint
    double joint_acceleration = 0;   // largest of the joint by motion
    double offset_acceleration = 0;  // largest that the offset adds to it

    // One period of the joint.
    struct Step {
        double from, to;  // places of the joint
        double moved;     // distance by motion, at least 0; 0 after a jump of the place
        double dt;        // s, above 0
    };

    // False for NaN too.
    bool valid() const noexcept {
        const auto possible = [](double acceleration) {
            return acceleration >= softest && acceleration <= hardest;
        };
        return min < max && std::abs(min) <= farthest && std::abs(max) <= farthest &&
               possible(joint_acceleration) && possible(offset_acceleration);
    }

    // The largest slope of the taper. It leaves the rest of offset_acceleration for all but motion.
    double share() const noexcept { return std::min(0.75 * offset_acceleration / joint_acceleration, 1.0); }

    // From a place to the limit in this direction; below 0 beyond it.
    double distance(double direction, double place) const noexcept {
        return direction > 0 ? max - place : place - min;
    }

    // The part of an offset that may be applied at a place.
    double allowed(double offset, double place) const noexcept {
        return std::copysign(tapered(std::abs(offset), distance(offset, place), share()), offset);
    }

    // Whether motion may change the part of an offset that is allowed, in this period or as the joint brakes.
    bool tapers(double offset, const Step& joint) const noexcept {
        return room_at_rest(offset, joint) < taper_length(std::abs(offset), share());
    }

    // The largest speed at which an offset may grow in this direction: it stops, with a quarter of
    // offset_acceleration, before the taper at the place where the joint can stop. As the joint leaves the
    // limit, the offset may go with it.
    double largest_speed(double direction, double offset, const Step& joint) const noexcept {
        const double leaves = speed_away(direction, joint), stops = room_at_rest(direction, joint);
        const double way = std::max(share() * std::max(stops, 0.0) - direction_of(direction) * offset, 0.0);
        return share() * std::max(leaves, 0.0) +
               AccelerationLimit::stopping_speed(way, offset_acceleration / 4, joint.dt);
    }

    // The largest |offset|, so that motion takes the drive no further beyond a limit than it was, however
    // late motion brakes. `before` is the offset of the last period.
    double largest_offset(double offset, double before, const Step& joint) const noexcept {
        const double last = offset * before > 0 ? std::abs(before) : 0;
        const double beyond = std::max(last - distance_left(offset, joint.from), 0.0);
        return std::max(distance_left(offset, joint.to) + beyond, last - joint.moved);
    }

private:
    // mu/s, from the limit in this direction.
    double speed_away(double direction, const Step& joint) const noexcept {
        return bounded(distance_left(direction, joint.to) - distance_left(direction, joint.from),
                       joint.moved) /
               joint.dt;
    }
    // The distance from the limit where the joint can stop.
    double room_at_rest(double direction, const Step& joint) const noexcept {
        const double room = distance_left(direction, joint.to), leaves = speed_away(direction, joint);
        return leaves < 0 ? room - leaves * leaves / (2 * joint_acceleration) : room;
    }
    static double direction_of(double direction) noexcept { return direction > 0 ? 1 : -1; }
    double distance_left(double direction, double place) const noexcept {
        return std::max(distance(direction, place), 0.0);
    }
};

// The offset of a joint: it follows the sum of its sources at limited rates and accelerations, within
// max_offset and, tapered, within the soft limits of the joint.
class TaperedOffset {
public:
    static constexpr double slack = 1e-9;  // mu, without meaning

    struct Settings {
        double max_offset, ramp_rate, max_rate;  // mu, mu/s
    };

    // The joint in a period.
    struct Joint {
        double from, to;  // mu, its last position and this one
        double moved;     // mu, the distance that motion moves it
        bool guarded;     // the soft limits are in force: homed, and they are valid
    };

    explicit TaperedOffset(const Settings& settings) noexcept : settings_(settings) {}

    // False if max_offset is too small for the present offset; the last one stays in force.
    bool take(const Settings& given, double dt) noexcept {
        const double most = settings_.max_offset;
        settings_ = given;
        if (given.max_offset >= most || stops_within(given.max_offset, acceleration(), dt)) return true;
        settings_.max_offset = most;
        return false;
    }

    // A smaller offset_acceleration waits until the offset can stop within max_offset by it.
    void take(const SoftLimits& given, double dt) noexcept {
        const double before = limits_.offset_acceleration;
        limits_ = given;
        if (given.offset_acceleration < before &&
            !stops_within(settings_.max_offset, given.offset_acceleration, dt))
            limits_.offset_acceleration = before;
    }

    const Settings& settings() const noexcept { return settings_; }
    bool knows_limits() const noexcept { return limits_.valid(); }
    double value() const noexcept { return applied_.value(); }
    double sum() const noexcept { return source_.value(); }  // of the sources, bounded and ramped
    bool ramping() const noexcept { return ramping_; }
    // A soft limit, or a rate beside a ramp, keeps the offset from this sum.
    bool falls_short(double possible) const noexcept {
        return tapered_ || (!ramping_ && std::abs(possible - applied_.value()) > slack);
    }

    // The way to the sum is not caused by motion: it is gone at ramp_rate.
    void ramp() noexcept { ramping_ = begins_ = true; }

    // In the command of the drive, motion has the rest of it.
    void move_to(double place, double dt) noexcept {
        source_.move_to(place, acceleration(), dt);
        applied_.move_to(place, acceleration(), dt);
        hold();
    }

    void hold() noexcept {
        source_.hold();
        applied_.hold();
    }

    // The sources, then the soft limits, then the drive.
    void follow(double possible, const Joint& motion, double dt) noexcept {
        const double most = settings_.max_offset, rate = settings_.max_rate;
        const double acceleration = this->acceleration();
        if (guarded_ && !motion.guarded) {  // the rest of the sum must not come at once
            source_.move_to(applied_.value(), acceleration, dt);
            source_.hold();
        }
        guarded_ = motion.guarded;
        const double source = source_.value(), applied = applied_.value();
        const SoftLimits::Step joint{motion.from, motion.to, motion.moved, dt};
        share_out(guarded_ && (limits_.tapers(std::max(source, possible), joint) ||
                               limits_.tapers(std::min(source, possible), joint)),
                  acceleration, dt);
        AccelerationLimit::Limits speeds{
            ramping_ ? settings_.ramp_rate : rate, rate, acceleration * source_share(), rate, rate, most};
        if (guarded_) {
            speeds.down = limits_.largest_speed(-1, source, joint);
            speeds.up = limits_.largest_speed(1, source, joint);
        }
        if (begins_) source_.aim(possible);
        begins_ = false;
        source_.step(possible, speeds, dt);
        const bool held = (possible > source ? speeds.up : speeds.down) * dt <= slack;  // by a soft limit
        ramping_ = ramping_ && source_.value() != possible && !held;

        const double now = source_.value();
        const double allowed = guarded_ ? limits_.allowed(now, motion.to) : now;
        tapered_ = allowed != now;
        // At most share(), so that the offset brakes in time when motion does.
        const double by_motion = guarded_ ? std::min(std::abs(allowed - limits_.allowed(now, motion.from)),
                                                     limits_.share() * motion.moved)
                                          : 0;
        const double fastest = rate + by_motion / dt;
        applied_.step(allowed, {rate, fastest, acceleration, fastest, fastest, most}, dt);
        if (!guarded_) return;
        const double within = limits_.largest_offset(applied_.value(), applied, joint);
        if (std::abs(applied_.value()) > within)
            applied_.move_to(std::copysign(within, applied_.value()), acceleration, dt);
    }

private:
    static constexpr double gentle = 100;    // mu/s2, without valid limits
    static constexpr double quarter = 0.25;  // of the acceleration, for sources, beside a taper

    bool stops_within(double bound, double acceleration, double dt) const noexcept {
        return source_.stops_within(bound, acceleration * source_share(), dt) &&
               applied_.stops_within(bound, acceleration, dt);
    }

    // While the taper may act, it needs all of the acceleration but a quarter. The sources have all of it
    // elsewhere; they give it back when they do not need it to stop within max_offset.
    void share_out(bool tapers, double acceleration, double dt) noexcept {
        const double rest = acceleration * quarter;
        if (!tapers)
            shares_ = false;
        else if (source_.settled(rest, dt) && source_.stops_within(settings_.max_offset, rest, dt))
            shares_ = true;
    }

    double acceleration() const noexcept { return limits_.valid() ? limits_.offset_acceleration : gentle; }
    double source_share() const noexcept { return shares_ ? quarter : 1; }

    Settings settings_;  // the last good ones
    SoftLimits limits_{};
    AccelerationLimit source_;   // the sum, bounded and ramped
    AccelerationLimit applied_;  // source_ within the soft limits; the last command contains it
    bool ramping_ = false, begins_ = false;  // the ramp
    bool guarded_ = false, tapered_ = false;  // by the soft limits
    bool shares_ = true;                      // the acceleration, with the taper
};

}  // namespace plumb
