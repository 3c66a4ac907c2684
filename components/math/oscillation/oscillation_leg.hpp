// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/oscillation_settings.hpp"
#include "components/math/oscillation/reciprocation.hpp"
#include "components/math/oscillation/speed_sections.hpp"
#include "components/math/oscillation/stroke_plan.hpp"

#include <algorithm>

namespace plumb {

// A part of an oscillation from rest to rest: the first way to a dead point, a stroke, or the way to the end.
struct OscillationLeg {
    enum class Kind { none, first, regular, closing };

    static constexpr double nothing = 1e-9;  // mu

    // A dead point that was reached, and how.
    struct Arrival {
        bool happened = false, upper = false;
        bool infeed = false;      // no spark-out
        bool regular = false;     // it ends a stroke from one dead point to the other of the same region
        double bound = 0;         // the dead point
        double opposite = 0;      // the one from which its stroke comes
        int learned = 0;          // number of the stroke for which its end was learned
        double offset = 0;        // outward, of the commanded end
        double acceleration = 0;  // of the reversal
        double speed = 0;         // mu/s, peak
        double braking = 1;       // part of the acceleration
        double length = 0;        // of the stroke
        double turning = 0;       // mu/s2, of its last moment
        double wait = 0;          // s, the longest one after it
    };

    Kind kind = Kind::none;
    Arrival arrival;               // at its end
    double dwell = 0;              // s, after it
    double exact_stop = 0;         // s, the longest wait for the axis before the dwell
    bool sparks = false;           // without infeed
    bool homeward = false;         // a withdrawal goes by it to the dead point nearest the end
    bool pauses = false;           // to the end for a hold: strokes go on after it
    bool comes_in = false;         // closing: it begins where the end of a stroke was learned, outside
    bool clipped = false;          // by the soft limits
    bool near = false;             // it begins where it should end
    double acceleration = 0;       // mu/s2, the largest by which it was planned
    OscillationSettings settings;  // when it was planned

    // Mu, by which an axis must stand inside a dead point whose end is learned for a turn: it moves farther
    // out where the command stays, or leaves with less acceleration.
    double margin() const noexcept { return kind == Kind::regular ? settings.caution : 0; }
    // Where an axis may not stand, nor leave by another stroke.
    bool ends_outside() const noexcept {
        return kind != Kind::closing && arrival.offset > nothing - margin();
    }

    // Whether a position lies so far outside its dead point that an axis which goes on there passes neither.
    bool leads_to(double position) const noexcept {
        const double way = arrival.upper ? position - arrival.bound : arrival.bound - position;
        return way > margin() + std::max(arrival.offset, 0.0);
    }

    // Where it begins, and what is in force then.
    struct Begin {
        double position = 0, lower = 0, upper = 0;
        bool upward = false;
    };

    // Makes it one to a dead point, planned by `now` while the last settings are `latest`: an end that lies
    // outside was planned for the settings of then, and the next stroke leaves it by them.
    // learned(upper, acceleration of the reversal, speed, distance to the dead point or 0 where it is no
    // whole stroke) is where its end lies, outward.
    template <class Learned>
    StrokeRequest to_dead_point(const Begin& begin, const OscillationSettings& now,
                                const OscillationSettings& latest, const Learned& learned) noexcept {
        const double from = begin.position;
        const bool upward = begin.upward, whole = kind == Kind::regular;
        // With a new region that does not reach beyond this dead point the old one holds once more.
        double bound = upward ? now.upper : now.lower;
        if (upward ? bound <= from + nothing : bound >= from - nothing)
            bound = upward ? begin.upper : begin.lower;
        const bool regular = whole && begin.lower == latest.lower && begin.upper == latest.upper &&
                             now.speed == latest.speed && now.sections == latest.sections &&
                             now.lower_dwell == latest.lower_dwell && now.upper_dwell == latest.upper_dwell &&
                             now.exact_stop == latest.exact_stop;
        const double opposite = whole    ? upward ? begin.lower : begin.upper
                                : upward ? std::min(from, begin.lower)
                                         : std::max(from, begin.upper);
        const Reciprocation region{upward ? opposite : bound, upward ? bound : opposite, now.speed};
        const double at_turn = std::min(reversal(region, bound, now), reversal(region, bound, latest));
        double offset = learned(upward, at_turn, now.speed, whole ? std::abs(bound - from) : 0);
        if (!regular) offset = std::min(offset, 0.0) - now.caution;  // not learned for this stroke
        const double end = upward ? bound + offset : bound - offset;

        StrokeRequest request;
        request.from = from;
        request.largest_speed = now.largest_speed;
        request.acceleration = whole ? now.acceleration : now.acceleration * now.braking;
        request.braking = whole ? now.braking : 1;
        request.to = std::clamp(end, now.lowest, now.highest);
        near = upward ? request.to <= from + nothing : request.to >= from - nothing;
        if (near) request.to = from + (bound - from) / 10;
        // A first way is short, and without this quicker than all that the axis has shown.
        if (!whole && now.learned > 0)
            request.acceleration *= std::min(std::abs(request.to - from) / region.stroke(), 1.0);
        const double behind = whole    ? from
                              : upward ? std::min(from, latest.lower)
                                       : std::max(from, latest.upper);
        request.shape = {std::min(behind, request.to), std::max(behind, request.to), now.speed};
        if (now.timed && regular)
            request.shape.speed *=
                request.shape.stroke() / (upward ? bound - begin.lower : begin.upper - bound);
        request.spans = SpeedSections::spans(now.sections, request.shape, upward);

        clipped = request.to != end;
        dwell = upward ? now.upper_dwell : now.lower_dwell;
        exact_stop = now.exact_stop;
        arrival = {};
        arrival.upper = upward;
        arrival.regular = regular;
        arrival.bound = bound;
        arrival.opposite = opposite;
        arrival.learned = now.learned;
        arrival.offset = upward ? request.to - bound : bound - request.to;
        arrival.acceleration = at_turn;
        arrival.speed = now.speed;
        arrival.braking = now.braking;
        arrival.wait = dwell + exact_stop;
        return request;
    }

    // Makes it one to a position.
    static StrokeRequest to_position(double from, double to, const OscillationSettings& now) noexcept {
        StrokeRequest request;
        request.from = from;
        request.to = to;
        request.shape = {std::min(from, to), std::max(from, to), fastest};
        request.largest_speed = std::min(now.speed, now.largest_speed);
        request.acceleration = std::min(now.acceleration * now.braking, now.end_acceleration);
        return request;
    }

    // Makes it one that leaves a dead point as a stroke does, and ends amid the region: an axis whose end is
    // learned for a turn goes farther out where its command leaves otherwise.
    static StrokeRequest inward(const Begin& begin, const OscillationSettings& now) noexcept {
        StrokeRequest request;
        request.from = begin.position;
        request.to = (begin.lower + begin.upper) / 2;
        request.shape = {std::min(begin.position, begin.lower), std::max(begin.position, begin.upper),
                         now.speed};
        request.largest_speed = now.largest_speed;
        request.acceleration = now.acceleration;
        request.braking = 0.5;
        return request;
    }

    // The smaller acceleration of both strokes at a dead point.
    static double reversal(const Reciprocation& region, double position,
                           const OscillationSettings& its) noexcept {
        double least = its.acceleration;
        for (const bool upward : {true, false}) {
            const auto spans = SpeedSections::spans(its.sections, region, upward);
            const double speed = SpeedSections::ratio_at(spans, position) * its.speed;
            least = std::min(least, 2 * speed * speed / region.stroke());
        }
        return least;
    }

private:
    static constexpr double fastest = 1e6;  // mu/s, a bound that is none
};

}  // namespace plumb
