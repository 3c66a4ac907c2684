// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/reciprocation.hpp"
#include "components/math/oscillation/speed_sections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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
    // mu/s2, at least 0, before the dead point at its end.
    double last_acceleration() const noexcept { return std::abs(acceleration_[count_ - 2]); }
    bool limited() const noexcept { return limited_; }  // a section, or the rest, does not reach its speed

    // At `time` s from the start; before and after it the stroke rests.
    Moment at(double time) const noexcept {
        if (time <= 0) return {from_, 0, 0};
        if (time >= duration_) return {to_, 0, 0};
        const auto after = std::upper_bound(time_.begin(), time_.begin() + count_, time);
        const std::size_t i = static_cast<std::size_t>(after - time_.begin()) - 1;
        const double t = time - time_[i], a = acceleration_[i], v = speed_[i] + a * t;
        const double s = way_[i] + (speed_[i] + v) / 2 * t, sign = upward() ? 1 : -1;
        return {from_ + sign * s, sign * v, sign * a};
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
        const double s = std::sin(pi / 2 * static_cast<double>(phase_) / StrokePlan::phases);
        const double even = phase_ == StrokePlan::phases ? length_ : length_ * s * s;
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
    std::array<double, StrokePlan::most_nodes> square_{}, ratio_{};
    std::array<double, 4 * SpeedSections::most_spans> marks_{};
    std::size_t marks_count_ = 0, mark_ = 0, phase_ = 0, next_ = 0;
    double length_ = 0, sign_ = 1, reached_ = 0;
};

}  // namespace plumb
