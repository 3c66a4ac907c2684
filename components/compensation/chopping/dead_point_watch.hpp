// SPDX-License-Identifier: GPL-2.0-or-later
// Where an axis turns, and whether it follows as it did. DeadPointMeter measures a turn, MeasuredPhase the
// phase between turns, SlipWatch judges the scale, LagModel the lag, ShownAcceleration the force of the
// drive. DeadPointWatch compares with the command, and learns.
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/stroke_plan.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace plumb {

// The farthest position of an axis around a reversal: the vertex of the parabola through the farthest sample
// and its neighbours.
class DeadPointMeter {
public:
    // Begins to look for the end of a motion upward or downward.
    void begin(bool upward) noexcept {
        sign_ = upward ? 1 : -1;
        samples_ = 0;
        after_ = false;
    }

    void step(double position) noexcept {
        const double y = sign_ * position;
        if (samples_ == 0 || y > top_) {
            before_top_ = samples_ > 0 ? last_ : y;
            top_ = y;
            after_ = false;
        } else if (!after_) {
            after_top_ = y;
            after_ = true;
        }
        last_ = y;
        if (samples_ < 1000000) ++samples_;
    }

    bool found() const noexcept { return after_ && samples_ >= 3; }  // the axis has turned

    // Requires found().
    double position() const noexcept {
        const double bend = before_top_ - 2 * top_ + after_top_, slope = after_top_ - before_top_;
        return sign_ * (bend < 0 ? top_ - slope * slope / (8 * bend) : top_);
    }

private:
    double sign_ = 1, top_ = 0, before_top_ = 0, after_top_ = 0, last_ = 0;
    int samples_ = 0;
    bool after_ = false;
};

// The phase of an axis that follows planned strokes, by its measured position: 0 at its own lower dead point,
// pi at its own upper one. An axis with a lag turns later than its command, and short of it or beyond.
//
// A stroke begins where the axis turned. It ends as far from its commanded end as the last stroke of its
// direction did. The axis turns where it comes back after the command has turned, by 1e-4 of the stroke: the
// phase stands meanwhile, for 1.2 degrees. So neither noise of a scale nor an axis that swings at a hold
// changes the direction.
class MeasuredPhase {
public:
    // A motion begins; the axis rests.
    void begin(double measured) noexcept {
        farthest_ = measured;
        turned_ = false;
    }

    // `plan`: the plan that the command follows in this period.
    void step(double measured, const StrokePlan& plan) noexcept {
        if (!(plan.shape().stroke() > 0)) return;  // none has run
        const double sign = upward_ ? 1 : -1;
        if (sign * (measured - farthest_) > 0) farthest_ = measured;
        bool turns = plan.upward() != upward_;
        if (turns && sign * (farthest_ - measured) > least_return * plan.shape().stroke()) {
            turn(measured, plan);
            turns = false;
        }
        if (!turns) follow(plan);
        if (ends_[0] < ends_[1])
            phase_ = Reciprocation{ends_[0], ends_[1], 1}.phase(turns ? farthest_ : measured, upward_);
    }

    double phase() const noexcept { return phase_ < 2 * pi ? phase_ : 0; }  // rad, 0 to 2 pi

private:
    void turn(double measured, const StrokePlan& plan) noexcept {
        if (turned_) beyond_[upward_] = farthest_ - to_;
        begin_ = farthest_;
        commanded_begin_ = plan.from();
        turned_ = true;
        upward_ = !upward_;
        farthest_ = measured;
    }

    // The ends of the plan, as far as the axis is to reach them.
    void follow(const StrokePlan& plan) noexcept {
        to_ = plan.to();
        const Reciprocation& shape = plan.shape();
        ends_[0] = shape.lower;
        ends_[1] = shape.upper;
        ends_[upward_] += beyond_[upward_];
        if (turned_ && plan.from() == commanded_begin_ && ends_[!upward_] == commanded_begin_)
            ends_[!upward_] = begin_;
    }

    static constexpr double least_return = 1e-4;  // of the stroke

    double ends_[2] = {0, 0};    // mu, lower and upper
    double beyond_[2] = {0, 0};  // mu, of the axis beyond the end of its command, where it last turned
    double to_ = 0;              // mu, commanded end of the present stroke
    double begin_ = 0, commanded_begin_ = 0, farthest_ = 0;
    double phase_ = 0;
    bool upward_ = true, turned_ = false;  // since begin()
};

// Whether a scale slips on an axis that strokes. A slip is a way of one period alone, d: larger than the ways
// d1 and d2 of the periods before and after it, or smaller than both.
//
//     spike = min(|d - d1|, |d - d2|)        if both differences have one sign, else 0
//
// A slip s gives s. An acceleration a changes the way by a T^2 in the same direction in each period, and a
// scale that stops changes it once: both give none. Steps q of the scale give 2 q at most. The largest spike
// of the strokes before, times a reserve, is the smallest slip that it finds. It finds one also where the
// position loop closes on this scale: that takes the jump away, and moves the load by it.
//
// With the encoder of the motor, the mean difference of both readings over two strokes finds a slower one:
// friction and backlash change it by as much upward as downward.
class SlipWatch {
public:
    // Of a period; mu, mu/s2.
    struct Sample {
        double measured = 0, motor = 0;
        double acceleration = 0;  // the largest of the stroke
    };

    void forget() noexcept { *this = {}; }

    // The readings before say nothing about the next one.
    void pause() noexcept {
        count_ = 0;
        suspects_ = false;
    }
    // The scale has another origin.
    void accept() noexcept {
        pause();
        means_ = {};
        last_ = difference_ = none;
    }

    // A stroke begins. True if the scale has slipped against the motor by more than `least`.
    bool stroke(double least) noexcept {
        strokes_ = std::min(strokes_ + 1, 1000);
        seen_ *= 0.9;
        const Means now = std::exchange(means_, {});
        const bool netted = now.samples > 20 && now.motor() > 0.5 * now.scale();
        const double before = std::exchange(last_, netted ? now.sum / now.samples : none);
        if (!netted || before == none) {
            difference_ = none;
            return false;
        }
        const double difference = (before + last_) / 2;
        if (difference_ == none) difference_ = difference;
        const double change = difference - difference_;
        difference_ += std::clamp(change, -least / 20, least / 20);  // heat
        return std::abs(change) > least;
    }

    // One period of a stroke. True if the scale has slipped by more than least().
    bool step(const Sample& now, double floor) noexcept {
        means_.add(now.measured, now.motor);
        const auto [x1, x2, x3] = past_;
        const double way = x1 - x2, up = way - (x2 - x3), down = way - (now.measured - x1);
        const double spike = up * down > 0 ? std::min(std::abs(up), std::abs(down)) : 0;
        past_ = {now.measured, x1, x2};
        suspects_ = count_ >= 2 && strokes_ >= first && std::abs(up + down) > least_;
        if (count_ < past_.size()) {
            ++count_;
            return false;
        }
        least_ = reserve * seen_ * std::max(now.acceleration / hardest_, 1.0) + floor;
        const bool slips = strokes_ >= first && spike > least_;
        if (slips) {
            count_ = 0;
            suspects_ = false;
            return true;
        }
        hardest_ = std::max(hardest_, now.acceleration);
        seen_ = std::max(seen_, spike);
        return false;
    }

    double least() const noexcept { return least_; }  // mu
    // The last way may be a slip, which the next one decides: it changed otherwise than by an acceleration.
    bool suspects() const noexcept { return suspects_; }

private:
    struct Means {
        double sum = 0, samples = 0;
        double low[2] = {far, far}, high[2] = {-far, -far};

        void add(double measured, double motor) noexcept {
            const double its[2] = {measured, motor};
            for (std::size_t i = 0; i < 2; ++i) {
                low[i] = std::min(low[i], its[i]);
                high[i] = std::max(high[i], its[i]);
            }
            sum += measured - motor;
            ++samples;
        }
        double scale() const noexcept { return high[0] - low[0]; }
        double motor() const noexcept { return high[1] - low[1]; }
    };

    static constexpr double far = 1e9, none = 1e12;
    static constexpr double reserve = 3;  // above the largest spike before
    static constexpr int first = 4;       // strokes that show what an axis does

    std::array<double, 3> past_{};
    std::size_t count_ = 0;
    bool suspects_ = false;
    int strokes_ = 0;
    double seen_ = 0, least_ = 0;  // mu
    double hardest_ = std::numeric_limits<double>::min();
    Means means_;
    double last_ = none, difference_ = none;  // mu, scale minus motor: of the last stroke; before any slip
};

// The lag of an axis behind its command, as it was in its last strokes:
//
//     lag = a velocity + b acceleration + c sign(velocity)
//
// by least squares, in which each stroke counts half as much as the next one. A sample is compared with the
// strokes before its own, so that a jam does not explain itself. Nor does the stroke in which a force drops
// explain the next one: once an axis has learned, a stroke counts only if its dead point is right.
class LagModel {
public:
    void begin() noexcept {
        past_ = {};
        coefficients_.setZero();
        band_ = peak_ = speed_ = length_ = 0;
        strokes_ = 0;
        now_ = last_ = {};
    }

    // A stroke with this peak speed and length begins. The last one is left out if it was not whole, and
    // waits for judge() if `waits`.
    void stroke(bool whole, bool waits, double speed, double length) noexcept {
        last_ = whole && now_.count > 20 ? now_ : Sums{};
        if (!waits) learn();
        now_ = {};
        now_.speed = speed;
        now_.length = length;
    }

    // Whether the dead point at the end of the stroke that waits is right.
    void judge(bool right) noexcept {
        if (right)
            learn();
        else
            last_ = {};
    }

    // Returns by how much the lag differs from that of the last strokes, mu.
    double step(double command, double velocity, double acceleration, double measured) noexcept {
        const double lag = command - measured, sign = velocity / (std::abs(velocity) + 1e-3 * speed_ + 1e-9);
        const Eigen::Vector3d row{velocity, acceleration, sign};
        now_.square += row * row.transpose();
        now_.product += row * lag;
        ++now_.count;
        now_.peak = std::max(now_.peak, std::abs(lag));
        const double rest = lag - coefficients_.dot(row);
        now_.band = std::max(now_.band, std::abs(rest));
        return known() ? rest : 0;
    }

    // Three strokes have been learned.
    bool known() const noexcept { return strokes_ >= 3; }
    int strokes() const noexcept { return strokes_; }
    double band() const noexcept { return band_; }      // mu, the largest difference in the last strokes
    double peak() const noexcept { return peak_; }      // mu, the largest lag in the last stroke
    double speed() const noexcept { return speed_; }    // mu/s, the peak of the last stroke
    double length() const noexcept { return length_; }  // mu, of the last stroke

private:
    struct Sums {
        Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
        Eigen::Vector3d product = Eigen::Vector3d::Zero();
        double speed = 0, length = 0, peak = 0, band = 0;
        int count = 0;
    };

    // From the last stroke.
    void learn() noexcept {
        const Sums its = std::exchange(last_, {});
        if (its.count == 0) return;
        past_.square = past_.square / 2 + its.square / its.count;
        past_.product = past_.product / 2 + its.product / its.count;
        const double faster = speed_ > 0 ? its.speed / speed_ : 1;
        band_ = strokes_ >= 2 ? std::max(its.band, 0.7 * band_ * faster * faster) : 0;
        peak_ = its.peak;
        speed_ = its.speed;
        length_ = its.length;
        if (strokes_ < 1000) ++strokes_;
        solve();
    }

    void solve() noexcept {
        Eigen::Matrix3d square = past_.square;
        square.diagonal() *= 1 + 1e-9;
        const Eigen::LDLT<Eigen::Matrix3d> solver(square);
        if (solver.vectorD().minCoeff() > 0) coefficients_ = solver.solve(past_.product);
    }

    Sums now_, last_, past_;  // of this stroke, of the last one, of those before
    Eigen::Vector3d coefficients_ = Eigen::Vector3d::Zero();
    double band_ = 0, peak_ = 0, speed_ = 0, length_ = 0;
    int strokes_ = 0;
};

// The largest inward acceleration of a command and of an axis in the accelerating half of a stroke, each
// after its own reversal: friction hinders there, and helps before. By second differences over a sixth of the
// stroke, so that noise of a scale and vibration hardly show.
class ShownAcceleration {
public:
    // A stroke begins that takes so many s.
    void begin(bool upward, double duration, double dt) noexcept {
        sign_ = upward ? 1 : -1;
        const double span = std::max(duration / dt / 12, 1.0);
        stride_ = static_cast<std::size_t>(std::ceil(span / most));
        span_ = static_cast<std::size_t>(std::lround(span / static_cast<double>(stride_)));
        span_ = std::clamp(span_, std::size_t{1}, most);
        step_ = static_cast<double>(span_ * stride_) * dt;
        left_ = static_cast<std::size_t>(std::ceil(0.6 * duration / dt));
        skipped_ = 0;
        command_ = axis_ = {};
        valid_ = true;
    }

    void cancel() noexcept { valid_ = false; }

    // Returns true once, when the accelerating half is over.
    bool step(double command, double measured) noexcept {
        if (!valid_) return false;
        if (skipped_++ % stride_ == 0) {
            command_.step(sign_ * command, span_);
            axis_.step(sign_ * measured, span_);
        }
        if (left_-- > 1) return false;
        valid_ = false;
        return command_.largest > 0;
    }

    double commanded() const noexcept { return command_.largest / (step_ * step_); }  // mu/s2
    double done() const noexcept { return axis_.largest / (step_ * step_); }

private:
    static constexpr std::size_t most = 16;  // samples of one difference

    struct Motion {
        void step(double inward, std::size_t span) noexcept {
            const std::size_t size = samples.size(), now = next;
            next = (next + 1) % size;
            samples[now] = inward;
            if (count == 0 || inward < farthest) {  // it has not turned yet
                farthest = inward;
                count = 1;
                return;
            }
            if (++count <= 2 * span) return;
            const double middle = samples[(now + size - span) % size];
            const double first = samples[(now + size - 2 * span) % size];
            largest = std::max(largest, inward - 2 * middle + first);
        }

        std::array<double, 2 * most + 1> samples{};
        std::size_t next = 0, count = 0;
        double farthest = 0, largest = 0;
    };

    Motion command_, axis_;
    std::size_t span_ = 1, stride_ = 1, skipped_ = 0, left_ = 0;
    double step_ = 1, sign_ = 1;
    bool valid_ = false;
};

// Watches the axis in each period: its lag, the acceleration that it shows, and its dead points. Compares
// them with the command, and learns from them.
class DeadPointWatch {
public:
    using Arrival = OscillationLeg::Arrival;
    using Verdict = DeadPointLearning::Verdict;

    // passes: the axis is beyond a dead point, which its turn decides.
    enum class Event { none, corrected, passes, beyond, wrong_scale, slips, lost, lags, falls_behind };

    // Of the strokes that are planned now.
    struct Present {
        bool learns = false;
        bool without_override = true;
        double speed = 0;              // mu/s
        std::array<double, 2> wait{};  // s, the longest one at the lower and the upper dead point
    };

    // Of this period; mu, mu/s, mu/s2, without the lead.
    struct Sample {
        double measured = 0, command = 0, velocity = 0, acceleration = 0;
        bool second_half = false, upward = false;
        double duration = 0, dt = 0.001;  // s, of the stroke, and of the period
        double length = 0;                // mu, of the stroke
        double speed = 0;                 // mu/s, peak of the stroke
        bool stands = false;              // the command
        double motor = 0;                 // mu, by its encoder
        double hardest = 0;               // mu/s2, of the stroke
    };

    const DeadPointLearning& learning() const noexcept { return learning_; }
    // Each call counts as a change of all that it permits and corrects.
    DeadPointLearning& change_learning() noexcept {
        ++changes_;
        return learning_;
    }
    std::uint32_t changes() const noexcept { return changes_; }

    // A motion begins.
    void begin() noexcept {
        arrival_[0] = arrival_[1] = {};
        doubts_[0] = doubts_[1] = 0;
        lag_.begin();
        pause();
    }

    // The next dead point is not that of a whole stroke.
    void pause() noexcept {
        metering_ = whole_ = false;
        paused_ = true;
        shown_.cancel();
        slip_.pause();
    }
    // The scale has another origin.
    void accept() noexcept { slip_.accept(); }
    // The axis or its scale is another one.
    void forget() noexcept {
        change_learning().forget();
        slip_.forget();
    }

    void arrive(const Arrival& arrival) noexcept { arrival_[arrival.upper] = arrival; }

    // A dead point is between the second halves of two strokes.
    Event step(const Sample& now, const Present& present) noexcept {
        const bool turned = !paused_ && now.upward != upward_now_;
        paused_ = false;
        upward_now_ = now.upward;
        const double least = learning_.most_beyond();
        bool slips = turned && slip_.stroke(2 * least);
        slips |= slip_.step({now.measured, now.motor, now.hardest}, least / 5);
        if (slips && present.learns) {
            change_learning().slipped();
            return Event::slips;
        }
        if (turned) {
            const bool upper = !now.upward;
            const double wait = std::exchange(wait_[upper], arrival_[upper].wait);
            if (wait_[upper] != wait || wait_[upper] != present.wait[upper])
                lag_.begin();  // a stroke from rest begins with another lag
            lag_.stroke(whole_, learning_.was_learned() && present.without_override, now.speed, now.length);
            whole_ = true;
            shown_.begin(now.upward, now.duration, now.dt);
        }
        Event event = lag(now, present);
        if (shown_.step(now.command, now.measured) && present.without_override &&
            now.speed == present.speed &&
            change_learning().shown(!now.upward, shown_.commanded(), shown_.done()) && event == Event::none)
            event = Event::corrected;
        if (now.second_half && (!metering_ || now.upward != upward_)) {
            const Event its = metering_ ? evaluate(upward_, now.length, present) : Event::none;
            if (event == Event::none) event = its;
            metering_ = true;
            upward_ = now.upward;
            passed_ = false;
            meter_.begin(now.upward);
        }
        if (event == Event::none && !slip_.suspects() && passes(now, present)) event = Event::passes;
        if (metering_) meter_.step(now.measured);
        return event;
    }

    // The last ones.
    const Arrival& arrival(bool upper) const noexcept { return arrival_[upper]; }
    double position(bool upper) const noexcept { return position_[upper]; }  // mu
    double error(bool upper) const noexcept { return error_[upper]; }        // mu, positive outside

private:
    // Whether the axis goes beyond the dead point where its command turned last. A stroke leads there, or the
    // first way from point R. True once for each dead point.
    bool passes(const Sample& now, const Present& present) noexcept {
        const Arrival& its = arrival_[upward_];
        const bool first = !arrival_[!upward_].happened;
        if (!metering_ || passed_ || now.upward == upward_ || !its.happened || !present.learns ||
            !(its.regular || first))
            return false;
        const double error = upward_ ? now.measured - its.bound : its.bound - now.measured;
        return passed_ = error > learning_.most_beyond();
    }

    // Whether the lag is far from that of the last strokes: a jam, or a drive without force. It grows at most
    // with the square of the speed.
    Event lag(const Sample& now, const Present& present) noexcept {
        const double sign = now.upward ? 1 : -1, lag = sign * (now.command - now.measured);
        if (now.stands) return Event::none;
        const double rest = sign * lag_.step(now.command, now.velocity, now.acceleration, now.measured);
        if (!present.learns || !whole_ || !lag_.known() || slip_.suspects()) return Event::none;
        const double faster = now.speed / std::max(lag_.speed(), 1e-9),
                     longer = now.length / std::max(lag_.length(), 1e-9);
        const bool rises = learning_.rising() && present.without_override;
        const bool like = std::abs(faster - 1) < 1e-6 && std::abs(longer - 1) < 0.05;
        const double part = lag_.strokes() < 6 ? 0.2 : 0.05;
        const double most = 10 * learning_.most_beyond() +
                            std::max(faster * faster, 1.0) * (2 * lag_.band() + part * lag_.peak());
        // Of a stroke with another frequency only the largest lag is known.
        const double largest =
            like || rises ? 0 : std::max(faster, 1.0) * std::max(longer, 1.0) * lag_.peak();
        // An axis that follows closer than it did is no fault, one that runs ahead of its command is. A
        // stroke begins ahead, by the lag of the stroke before.
        const double late = rises ? rest : std::min(rest, lag - largest);
        if (late <= most && std::min(-rest, -lag - largest) <= most) return Event::none;
        lag_.begin();
        if (!rises) return Event::lags;
        change_learning().fall_behind();
        return Event::falls_behind;
    }

    // `leaving` is the length of the stroke after it, mu.
    Event evaluate(bool upper, double leaving, const Present& present) noexcept {
        const Arrival& its = arrival_[upper];
        if (!its.happened) return Event::none;
        if (!meter_.found()) return present.learns && its.regular ? Event::lost : Event::none;
        position_[upper] = meter_.position();
        error_[upper] = upper ? position_[1] - its.bound : its.bound - position_[0];
        if (!present.learns || !its.regular) return Event::none;
        lag_.judge(std::abs(error_[upper]) <= learning_.most_beyond());
        const bool waits_as_now =
            its.wait == present.wait[upper] && arrival_[!upper].wait == present.wait[!upper];
        if (waits_as_now)
            change_learning().turned(upper, its.learned, its.speed, its.braking, {its.length, leaving},
                                     error_[upper] - its.offset);
        const bool plausible = learning_.plausible(upper, error_[upper], its.offset, its.speed);
        doubts_[upper] = plausible ? 0 : doubts_[upper] + 1;
        if (doubts_[upper] >= 2) return Event::wrong_scale;
        if (doubts_[0] + doubts_[1] > 0 || !present.without_override || its.speed != present.speed)
            return Event::none;
        if (!waits_as_now || its.braking != learning_.braking() ||
            !learning_.has(upper, its.bound, its.opposite, its.learned))
            return Event::none;
        switch (change_learning().measured(upper, error_[upper], its.offset, its.acceleration, its.speed,
                                           {its.length, leaving})) {
            case Verdict::passed: return Event::beyond;
            case Verdict::beyond: lag_.begin(); return Event::beyond;
            case Verdict::slips: return Event::slips;
            default: return Event::corrected;
        }
    }

    DeadPointLearning learning_;
    std::uint32_t changes_ = 0;  // of learning_
    DeadPointMeter meter_;
    LagModel lag_;
    ShownAcceleration shown_;
    SlipWatch slip_;
    Arrival arrival_[2];  // lower, upper
    double position_[2] = {0, 0}, error_[2] = {0, 0};
    int doubts_[2] = {0, 0};   // of the scale, in a row
    double wait_[2] = {0, 0};  // s, at the dead points before the last strokes
    bool passed_ = false;      // the dead point that is metered
    bool metering_ = false, upward_ = false, upward_now_ = false, whole_ = false, paused_ = true;
};

}  // namespace plumb
