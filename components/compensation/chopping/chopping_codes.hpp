// SPDX-License-Identifier: GPL-2.0-or-later
// Faults and bounds, with their sentences, and which of several is shown.
#pragma once

#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    not_ready,
    position,
    settings,
    region,
    speed,
    sections,
    acceleration,
    lead,
    soft_limit,
    following,
    feedback,
    scale,
    beyond,
    not_learned,
    weak,
    drift,
    bound,
    withdrawing,
    slips,
    lost,
    lags,
    weak_drive,
    last_good,
    passed_end,
    unhomed,
    place_lost,
    wheel_stands,
    wheel_lost,
    infeed
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::not_ready:
            return "The stroke was refused: the machine is off, the joint is not homed, enable is false, or "
                   "stop is true.";
        case Fault::position: return "The position is invalid or beyond 1e6; its last good value is used.";
        case Fault::settings:
            return "A setting is out of range, see the pins; the stroke was refused, or the last good set "
                   "stays in force.";
        case Fault::region:
            return "The upper dead point is not above the lower one; the stroke or the shift was refused.";
        case Fault::speed:
            return "The speed of the stroke is not above 0, or above max-feed; the stroke was refused, or "
                   "the last good set stays in force.";
        case Fault::sections:
            return "A section is impossible, or two overlap; the stroke was refused, or the last good set "
                   "stays in force.";
        case Fault::acceleration:
            return "The stroke needs more than max-acceleration at its dead points, and refuse-slower is "
                   "true; it was refused, or the last good set stays in force.";
        case Fault::lead:
            return "The lead is above max-lead, or jerk-time is too short for it and max-output-accel; the "
                   "stroke was refused, or the last good set stays in force.";
        case Fault::soft_limit:
            return "A dead point, its correction and the taper of the stage do not fit between the soft "
                   "limits, or within max-offset; the stroke or the shift was refused.";
        case Fault::following:
            return "The axis was farther from its command than max-following-error; the stroke was stopped.";
        case Fault::feedback:
            return "The joint-feedback or the applied-offset is invalid; dead points are not learned.";
        case Fault::scale:
            return "A measured dead point is farther from the commanded one than the lag explains, by more "
                   "than a tenth of the stroke: wrong scale, wrong wiring, or the axis is stuck; the stroke "
                   "was stopped.";
        case Fault::beyond:
            return "The axis passed a dead point by more than max-beyond; learning begins again, at reduced "
                   "speed.";
        case Fault::not_learned:
            return "The dead points are not within tolerance after 30 cycles at full speed.";
        case Fault::weak:
            return "The axis does not keep the stroke: the correction of a dead point is at max-correction.";
        case Fault::drift:
            return "The correction of a dead point differs from the one first learned for this stroke by "
                   "more than max-drift: look at guides, drive and lubrication.";
        case Fault::bound:
            return "The max-offset is below the present offset; the last good one stays in force until the "
                   "offset is within the new one.";
        case Fault::withdrawing:
            return "The stroke was refused: the last strokes had not ended, or the axis was on its way to "
                   "position. Set run false, and start again.";
        case Fault::slips:
            return "The scale slips: its reading jumped, or both measured dead points moved the same way. "
                   "Check the scale, and home the joint again; nothing was learned, and no stroke begins "
                   "before.";
        case Fault::lost:
            return "The axis did not turn at a dead point: drive or scale has failed; the stroke was "
                   "stopped.";
        case Fault::lags:
            return "The axis follows later than in its last strokes, or runs ahead: it jams, the drive has "
                   "lost force, or the scale does not follow; the stroke was stopped.";
        case Fault::weak_drive:
            return "The drive lacks the force for this speed: the axis strokes at the largest speed that it "
                   "has followed, until learn is set false and true.";
        case Fault::last_good:
            return "The axis passed a dead point by more than max-beyond twice: the last good speed stays "
                   "until learn is set false and true.";
        case Fault::passed_end:
            return "The axis passed position, point R, by more than max-beyond: the next way there is "
                   "slower.";
        case Fault::unhomed:
            return "The joint lost homed while the axis stroked: the stroke was stopped. Home the joint.";
        case Fault::place_lost:
            return "The place of the axis is unknown: its feedback jumped, failed or did not follow the "
                   "strokes. Check encoder and supply, turn the machine off, unhome the joint, and home it.";
        case Fault::wheel_stands:
            return "The stroke was refused: the spindle does not turn at its speed. Start the spindle, or "
                   "set without-wheel.";
        case Fault::wheel_lost:
            return "The spindle stopped, or lost its speed for longer than at-speed-time: the axis leaves "
                   "the work. Check the spindle, then start again.";
        case Fault::infeed:
            return "The infeed is impossible: above its largest amount or offset, beyond a soft limit of its "
                   "axis, or at a dead point that infeed-clear does not declare; the stroke was refused.";
        default: return nullptr;
    }
}

enum class Bound : std::int32_t {
    none,
    speed,
    learning,
    soft_limit,
    stage,
    offset,
    plan,
    arrival,
    infeed_late,
    infeed_cut
};
constexpr const char* sentence(Bound bound) {
    switch (bound) {
        case Bound::speed:
            return "A section or the stroke does not reach its speed within max-acceleration and max-feed.";
        case Bound::learning: return "The speed is reduced until the dead points are learned.";
        case Bound::soft_limit: return "A soft limit keeps a correction from the end of the stroke.";
        case Bound::stage: return "The stage does not apply the whole offset.";
        case Bound::offset: return "The max-offset or the max-rate keeps the axis from its stroke.";
        case Bound::arrival:
            return "The axis was not within exact-stop of a dead point in exact-stop-time; its dwell began "
                   "all the same.";
        case Bound::plan: return "A stroke began late, because it was changed in its last moment.";
        case Bound::infeed_late:
            return "The stroke waits at a dead point until the axis of the infeed has its offset, and is "
                   "within infeed-tolerance.";
        case Bound::infeed_cut: return "The infeed ended at a soft limit of its axis, short of its total.";
        default: return nullptr;
    }
}

// The faults of a stroke. One that happened stays until the next start.
class StrokeFaults {
public:
    // Those that are there as long as their cause.
    struct Lasting {
        bool position = false;  // it is invalid
        Fault settings = Fault::none;
        bool bound = false;  // a bound below the present offset
        Fault supervised = Fault::none;
    };

    // Also of a start: none, or why it was refused.
    void happen(Fault reason) noexcept { happened_ = reason; }

    // A program asks whether a stroke may begin. The refusal of the stroke stays until the next start, since
    // the program is aborted before anybody has read the reason. It does not stay where another fault is
    // shown.
    void check(bool asked, Fault reason, bool lasts = true) noexcept {
        checked_ = asked ? reason : Fault::none;
        if (asked && lasts) happened_ = reason;
    }

    // The one to show: the first that has a cause.
    Fault first(const Lasting& now) const noexcept {
        return happened_ != Fault::none      ? happened_
               : now.position                ? Fault::position
               : now.settings != Fault::none ? now.settings
               : now.bound                   ? Fault::bound
                                             : now.supervised;
    }

    Fault checked() const noexcept { return checked_; }

private:
    Fault happened_ = Fault::none, checked_ = Fault::none;
};

// Why an axis does less than its stroke asks for. A stroke that began late counts until the axis rests.
class StrokeBounds {
public:
    // The bounds that are active in a period.
    struct Active {
        bool offset = false;  // by its largest value or rate
        bool stage = false, soft_limit = false, learning = false, speed = false, arrival = false;
        bool late = false;  // a plan was not ready at a dead point
        bool infeed_cut = false, infeed_late = false;
    };

    // `runs`: the axis moves.
    void step(const Active& now, bool runs) noexcept {
        late_ = runs && (late_ || now.late);
        bound_ = now.offset        ? Bound::offset
                 : !runs           ? Bound::none
                 : now.stage       ? Bound::stage
                 : now.soft_limit  ? Bound::soft_limit
                 : now.learning    ? Bound::learning
                 : now.speed       ? Bound::speed
                 : late_           ? Bound::plan
                 : now.arrival     ? Bound::arrival
                 : now.infeed_late ? Bound::infeed_late
                 : now.infeed_cut  ? Bound::infeed_cut
                                   : Bound::none;
    }

    Bound bound() const noexcept { return bound_; }
    // A stroke that began late is over.
    bool hinders_infeed() const noexcept {
        return bound_ != Bound::none && bound_ != Bound::plan && bound_ < Bound::infeed_late;
    }

private:
    Bound bound_ = Bound::none;
    bool late_ = false;
};

}  // namespace plumb
