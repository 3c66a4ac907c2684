// SPDX-License-Identifier: GPL-2.0-or-later
// How a stroke is planned: OscillationLeg makes a StrokeRequest, StrokePlanner a StrokePlan of it, in steps
// of bounded work. StrokePlan::at() is the motion at each moment, Braking a stop from one.
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/oscillation_settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace plumb {

// What a stroke is planned from. It begins and ends at rest, so that no stroke depends on its neighbours.
struct StrokeRequest {
    double from = 0, to = 0;     // mu
    Reciprocation shape;         // its speed at each position bounds that of the stroke; contains from and to
    double largest_speed = 0;    // mu/s, above 0
    double acceleration = 0;     // mu/s2, above 0
    double braking = 1;          // part of the acceleration by which it brakes, least_braking to 1
    SpeedSections::Spans spans;  // of the direction from `from` to `to`

    bool operator==(const StrokeRequest& other) const noexcept {
        return from == other.from && to == other.to && shape.lower == other.shape.lower &&
               shape.upper == other.shape.upper && shape.speed == other.shape.speed &&
               largest_speed == other.largest_speed && acceleration == other.acceleration &&
               braking == other.braking && spans == other.spans;
    }
};

// A stroke from rest to rest: constant acceleration from node to node, so that each moment is exact.
class StrokePlan {
public:
    static constexpr std::size_t phases = 240;  // of half a cycle
    static constexpr std::size_t most_nodes = phases + 1 + 4 * SpeedSections::most_spans;

    struct Moment {
        double position, velocity, acceleration;  // mu, mu/s, mu/s2
    };

    double from() const noexcept { return from_; }
    double to() const noexcept { return to_; }
    bool upward() const noexcept { return to_ > from_; }
    double duration() const noexcept { return duration_; }  // s
    const Reciprocation& shape() const noexcept { return shape_; }
    bool limited() const noexcept { return limited_; }  // a section, or the rest, does not reach its speed

    // At `time` s from the start; before and after it the stroke rests. `node` is where the last moment was,
    // and where the search for the next one begins.
    Moment at(double time, std::size_t& node) const noexcept {
        if (time <= 0) return {from_, 0, 0};
        if (time >= duration_) return {to_, 0, 0};
        if (node + 1 >= count_ || time_[node] > time) node = 0;
        while (time_[node + 1] <= time) ++node;
        const std::size_t i = node;
        const double t = time - time_[i], a = acceleration_[i], v = speed_[i] + a * t;
        const double s = way_[i] + (speed_[i] + v) / 2 * t, sign = upward() ? 1 : -1;
        return {from_ + sign * s, sign * v, sign * a};
    }
    Moment at(double time) const noexcept {
        std::size_t node = 0;
        return at(time, node);
    }

private:
    friend class StrokePlanner;

    std::array<double, most_nodes> way_{}, speed_{}, acceleration_{}, time_{};  // mu from `from`, ..., s
    std::size_t count_ = 2;
    double from_ = 0, to_ = 0, duration_ = 0;
    Reciprocation shape_;
    bool limited_ = false;
};

// Plans a stroke, time-optimal, in steps of bounded work. With v^2 as a function of the way, an acceleration
// a is a slope of 2 a: the fastest v^2 under the bound r^2 F^2 sin^2(phase) is the largest function below it
// whose slope stays within 2 a, a pass forward and one backward. Nodes are even in phase, with one at each
// end of a section and one where a change of speed there is complete; v^2 is linear between them, below the
// bound, which is concave.
class StrokePlanner {
public:
    static constexpr std::size_t passes = 3;
    static constexpr double least_braking = 0.5;
    static constexpr std::size_t most_work = passes * StrokePlan::most_nodes;  // nodes of a plan

    StrokePlanner() noexcept {
        for (std::size_t i = 0; i < sine_.size(); ++i)
            sine_[i] = std::sin(pi / 2 * static_cast<double>(i) / StrokePlan::phases);
    }

    // from != to.
    void begin(const StrokeRequest& request, StrokePlan& plan) noexcept {
        request_ = request;
        plan_ = &plan;
        plan.from_ = request.from;
        plan.to_ = request.to;
        plan.shape_ = request.shape;
        plan.limited_ = false;
        plan.count_ = 0;
        length_ = std::abs(request.to - request.from);
        sign_ = request.to > request.from ? 1 : -1;
        phase_ = mark_ = 0;
        next_ = 0;
        work_ = Work::place;
        sort_marks();
    }

    // Does the work of so many nodes; returns whether the plan is complete.
    bool step(std::size_t nodes) noexcept {
        for (; nodes > 0 && work_ != Work::none; --nodes) {
            switch (work_) {
                case Work::place: place(); break;
                case Work::backward: backward(); break;
                case Work::time: time(); break;
                case Work::none: break;
            }
        }
        return work_ == Work::none;
    }

    bool busy() const noexcept { return work_ != Work::none; }
    const StrokeRequest& request() const noexcept { return request_; }

private:
    enum class Work { none, place, backward, time };

    double where(double way) const noexcept { return request_.from + sign_ * way; }

    // The ends of the spans and of the changes of speed there, as ways from the start, ascending.
    void sort_marks() noexcept {
        marks_count_ = 0;
        for (const SpeedSpan& span : request_.spans)
            for (const double height : {span.from, span.to}) {
                const double way = sign_ * (height - request_.from);
                add_mark(way);
                const double before = wanted(way, ratio_at(way - 2 * nothing()));
                const double after = wanted(way, ratio_at(way + 2 * nothing()));
                const double slope = after < before ? braking() : request_.acceleration;
                add_mark(way + (after - before) / (2 * slope));
            }
        std::sort(marks_.begin(), marks_.begin() + marks_count_);
    }

    void add_mark(double way) noexcept {
        if (way > nothing() && way < length_ - nothing()) marks_[marks_count_++] = way;
    }

    double nothing() const noexcept { return 1e-12 * length_; }

    // The next node, its largest v^2, and the forward pass.
    void place() noexcept {
        StrokePlan& plan = *plan_;
        const std::size_t i = plan.count_;
        double way = 0;
        const double s = sine_[phase_], even = phase_ == StrokePlan::phases ? length_ : length_ * s * s;
        if (mark_ < marks_count_ && marks_[mark_] <= even) {
            way = marks_[mark_++];
            if (even - way <= nothing()) ++phase_;
        } else {
            way = even;
            ++phase_;
        }
        if (i > 0 && way - plan.way_[i - 1] <= nothing() && way < length_) return;
        plan.way_[i] = way;
        square_[i] = bound(i, way);
        if (i > 0) {
            const double reachable = square_[i - 1] + 2 * request_.acceleration * (way - plan.way_[i - 1]);
            square_[i] = std::min(square_[i], reachable);
        }
        ++plan.count_;
        if (way >= length_) {
            next_ = plan.count_ - 1;
            work_ = Work::backward;
        }
    }

    double ratio_at(double way) const noexcept {
        const double inside = where(way);
        for (const SpeedSpan& span : request_.spans)
            if (inside >= span.from && inside < span.to) return span.ratio;
        return 1;
    }

    // The largest v^2 at a position with a ratio.
    double wanted(double way, double ratio) const noexcept {
        return std::min(chord * request_.shape.speed_squared(where(way)) * ratio * ratio * eased(way),
                        request_.largest_speed * request_.largest_speed);
    }

    double braking() const noexcept { return request_.acceleration * request_.braking; }

    // The square of the speed falls from a quarter of the way to three quarters to what the braking needs. So
    // the deceleration is nowhere above that at the end, for least_braking and more.
    double eased(double way) const noexcept {
        const double part = std::clamp(2 * way / length_ - 0.5, 0.0, 1.0);
        return 1 + part * (request_.braking - 1);
    }

    // The largest v^2 at a node: that of the slower of its two neighbours. ratio_ is that of the interval
    // behind it.
    double bound(std::size_t i, double way) noexcept {
        const double before = i > 0 ? ratio_[i - 1] : ratio_at(2 * nothing());
        ratio_[i] = way >= length_ ? before : ratio_at(way + 2 * nothing());
        return i == 0 || way >= length_ ? 0 : wanted(way, std::min(before, ratio_[i]));
    }

    void backward() noexcept {
        const std::size_t i = --next_;
        const double d = plan_->way_[i + 1] - plan_->way_[i];
        square_[i] = std::min(square_[i], square_[i + 1] + 2 * braking() * d);
        plan_->speed_[i + 1] = std::sqrt(square_[i + 1]);
        if (i > 0) return;
        plan_->speed_[0] = 0;
        plan_->time_[0] = 0;
        reached_ = 0;
        work_ = Work::time;
    }

    void time() noexcept {
        StrokePlan& plan = *plan_;
        const std::size_t i = next_++;
        const double d = plan.way_[i + 1] - plan.way_[i];
        plan.acceleration_[i] = (square_[i + 1] - square_[i]) / (2 * d);
        plan.time_[i + 1] = plan.time_[i] + 2 * d / (plan.speed_[i] + plan.speed_[i + 1]);
        watch(i);
        if (i + 2 < plan.count_) return;
        plan.duration_ = plan.time_[i + 1];
        work_ = Work::none;
    }

    // A section that is nowhere at its speed is limited; the middle of the interval tells.
    void watch(std::size_t i) noexcept {
        const double middle = (plan_->way_[i] + plan_->way_[i + 1]) / 2;
        const double wanted = request_.shape.speed_squared(where(middle)) * ratio_[i] * ratio_[i];
        if (wanted > 0) reached_ = std::max(reached_, (square_[i] + square_[i + 1]) / 2 / wanted);
        if (wanted > 1.02 * request_.largest_speed * request_.largest_speed) plan_->limited_ = true;
        const bool last = i + 2 == plan_->count_;
        if (!last && ratio_[i + 1] == ratio_[i]) return;
        if (reached_ < 0.99) plan_->limited_ = true;
        reached_ = 0;
    }

    // Between nodes d apart in phase a chord lies below the bound, and takes tan(d/2) / (d/2) of the time: 1
    // + 14.3e-6. The nodes lie higher by the square of that, so that each interval takes its own time. The
    // acceleration stays within that of the bound.
    static constexpr double half = pi / 2 / StrokePlan::phases, chord = 1 + 2 * half * half / 3;

    StrokeRequest request_;
    StrokePlan* plan_ = nullptr;
    Work work_ = Work::none;
    std::array<double, StrokePlan::phases + 1> sine_;  // of half of each phase
    std::array<double, StrokePlan::most_nodes> square_{}, ratio_{};
    std::array<double, 4 * SpeedSections::most_spans> marks_{};
    std::size_t marks_count_ = 0, mark_ = 0, phase_ = 0, next_ = 0;
    double length_ = 0, sign_ = 1, reached_ = 0;
};

// A stop from a moment of a stroke, with a constant deceleration.
class Braking {
public:
    Braking() = default;
    // The deceleration is above 0, mu/s2.
    Braking(const StrokePlan::Moment& begin, double deceleration) noexcept
        : begin_(begin), deceleration_(deceleration) {}

    double duration() const noexcept { return std::abs(begin_.velocity) / deceleration_; }  // s
    double end() const noexcept {
        return begin_.position + begin_.velocity * std::abs(begin_.velocity) / (2 * deceleration_);
    }

    // At `time` s from its begin; behind its end it rests.
    StrokePlan::Moment at(double time) const noexcept {
        const double sign = begin_.velocity > 0 ? 1 : -1, speed = std::abs(begin_.velocity);
        const double t = std::min(time, duration());
        const double position = begin_.position + sign * (speed - deceleration_ * t / 2) * t;
        if (time >= duration()) return {position, 0, 0};
        return {position, sign * (speed - deceleration_ * t), -sign * deceleration_};
    }

    // The deceleration that ends in a way, mu, from a speed, mu/s; infinite without a way.
    static double needed(double way, double speed) noexcept {
        return way > 0 ? speed * speed / (2 * way) : std::numeric_limits<double>::infinity();
    }

private:
    StrokePlan::Moment begin_{};
    double deceleration_ = 1;
};

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
