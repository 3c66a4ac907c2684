// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/trapezoidal_move.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace plumb {

// The infeed of a stroke by another axis. Its offset is 0 where the program left that axis. Inward is away
// from 0, by the sign of the amount; outward is towards 0.
//
// - A start takes it back to 0, after machine off outward by the clearance. The strokes wait for it.
// - A dead point takes it inward by the amount, while all conditions hold. The stroke waits for it.
// - The total or a limit ends the strokes, after the spark-out strokes.
// - The end takes it outward to 0 at once, as an abort, a lost permit and a fault do.
// - Machine off lets it stand. It stays until a start, or an order to go to the end.
//
// Only a dead point moves inward. An offset that the stage does not apply is given up, so that it cannot be
// applied later. All lengths are in mu.
class Infeed {
public:
    enum Place : std::int32_t { nowhere, lower, upper, both };  // a dead point is a bit
    static constexpr double farthest = 1e6;
    static constexpr hal::Range lengths{0, farthest};

    struct Settings : hal::Settings {
        using hal::Settings::Settings;

        double amount = pin(amount, "infeed-amount", 0, "mu",
                            "Infeed at a dead point; its sign is the direction inward, 0 is none.",
                            hal::machine({-farthest, farthest}));
        double total = pin(total, "infeed-total", 0, "mu",
                           "Infeed from the start; spark-out strokes and the end of the strokes follow it.",
                           hal::machine(lengths));
        std::int32_t clear = pin(clear, "infeed-clear", nowhere,
                                 "The dead points at which the wheel is clear of the work, and the infeed "
                                 "acts: 0 none, 1 lower, 2 upper, 3 both.",
                                 hal::machine({nowhere, both}));
        double most_amount = pin(most_amount, "infeed-max-amount", 0.05, "mu",
                                 "Largest infeed at a dead point.", hal::machine(lengths));
        double most =
            pin(most, "infeed-max-offset", 1, "mu", "Largest infeed from the start.", hal::machine(lengths));
        double rate = pin(rate, "infeed-max-rate", 1, "mu/s", "Largest speed of the infeed.",
                          hal::machine({1e-3, 1e6}));
        double acceleration = pin(acceleration, "infeed-max-accel", 50, "mu/s2",
                                  "Largest acceleration of the infeed.", hal::machine({1e-3, 1e9}));
        double lowest = pin(lowest, "infeed-min-limit", 0, "mu", "Lower soft limit of this joint.",
                            hal::must({-farthest, farthest}));
        double highest = pin(highest, "infeed-max-limit", 0, "mu", "Upper soft limit of this joint.",
                             hal::must({-farthest, farthest}));
        double tolerance =
            pin(tolerance, "infeed-tolerance", 0.002, "mu",
                "The stroke goes on when this joint is as near to its position.", hal::machine(lengths));
        double clearance =
            pin(clearance, "infeed-clearance", 0.1, "mu",
                "A start after machine off first takes back so much of the infeed.", hal::machine(lengths));
        std::int32_t at = nowhere;  // dead points that the program chose; nowhere: all that are clear
        double taper = 1;           // distance from the soft limits, in offsets

        bool wanted() const noexcept { return amount != 0 && total != 0; }
        std::int32_t places() const noexcept { return at == nowhere ? clear : at & clear; }
        // How deep the soft limits permit, from a position.
        double room(double position) const noexcept {
            return std::max(amount < 0 ? position - lowest : highest - position, 0.0) / std::max(taper, 1.0);
        }
        // Whether strokes may begin.
        bool possible(double position) const noexcept {
            return !wanted() || (in_range && clear != nowhere && (at & ~clear) == 0 && total > 0 &&
                                 std::abs(amount) <= most_amount && total <= most && total <= room(position));
        }
    };

    // Of a period.
    struct Now {
        bool on = false;                    // the machine
        bool starts = false;                // strokes begin
        bool returns = false;               // an order to go to the end
        bool aborts = false;                // of the program
        bool strokes = false;               // strokes and spark-out strokes, and nothing has ended them
        bool permitted = false;             // nothing forbids the infeed
        bool runs = false, upward = false;  // a stroke, towards its dead point
        bool arrived = false;               // at this dead point, by a stroke with infeed
        bool stands = false;                // the stroking axis is there
        bool ends = false;                  // by a gauge
        double position = 0, measured = 0;  // of the axis, both without the offset or both with it
        double applied = 0;                 // offset, by its stage
    };

    void step(const Now& now, const Settings& given, double dt) noexcept {
        if (given.in_range && !moves()) its_ = given;
        position_ = usable(now.position, farthest, position_);
        applied_ = usable(now.applied, farthest, applied_);
        if (!now.on) stand();
        if (now.starts) begin();
        done_ |= now.aborts && its_.wanted();
        if (now.on && (now.returns || now.aborts || (!now.strokes && !stands_))) retract();
        give_up();
        if (now.strokes) stroke(now);
        if (now.on && (moves() || move_.velocity() != 0))
            move_.step(target_, its_.rate, its_.acceleration, dt);
        arrive(now, dt);
    }

    double value() const noexcept { return move_.position(); }
    bool waits() const noexcept { return waits_; }  // the stroke has to
    bool done() const noexcept { return done_; }    // since the start
    bool moves() const noexcept { return value() != target_; }
    bool idle() const noexcept { return value() == 0 && !moves() && !waits_ && !done_; }
    bool cut() const noexcept { return cut_; }               // a soft limit, since the start
    bool late() const noexcept { return late_ > patience; }  // the axis does not come to its infeed

private:
    enum class Visit { none, due, feeds };  // of a dead point

    static constexpr double nothing = 1e-6;
    static constexpr double patience = 0.5;  // s

    bool feeds() const noexcept { return visit_ == Visit::feeds; }

    void stand() noexcept {
        stands_ = true;
        visit_ = Visit::none;
        target_ = value();
        move_ = TrapezoidalMove(target_);
    }
    // The stroke still waits until the axis stands.
    void stop_feeding() noexcept {
        if (!feeds()) visit_ = Visit::none;
        if (feeds()) target_ = value();
        ends_ = false;
    }

    void begin() noexcept {
        const double deep = std::abs(value());
        const bool goes_on = stands_ && its_.wanted() && value() * its_.amount > 0;
        target_ = goes_on ? std::copysign(std::max(deep - its_.clearance, 0.0), value()) : 0;
        begins_ = moves();
        stands_ = done_ = cut_ = fed_ = false;
        visit_ = Visit::none;
    }

    void retract() noexcept {
        stands_ = begins_ = false;
        visit_ = Visit::none;
        target_ = 0;
    }

    // The part that the stage does not apply, and that is not on its way.
    void give_up() noexcept {
        const double deep = std::max(std::copysign(1, value()) * applied_, 0.0);
        const double last = std::exchange(last_deep_, deep);
        if (feeds() || deep > last || deep >= std::abs(value()) - nothing) return;
        move_ = TrapezoidalMove(std::copysign(deep, value()));
        if (deep < std::abs(target_)) target_ = value();
    }

    void stroke(const Now& now) noexcept {
        if (now.ends && its_.wanted() && !begins_) done_ = true;
        const bool may = now.permitted && its_.wanted() && !done_ && !begins_ && !(value() * its_.amount < 0);
        const bool here = (its_.places() & (now.upward ? upper : lower)) != 0;
        if (now.runs) fed_ = false;
        if (now.arrived && may && here && !fed_) visit_ = Visit::due;
        if (!may) stop_feeding();
        if (visit_ == Visit::due && now.stands) feed();
        waits_next_ = may && here && now.runs;
    }

    void feed() noexcept {
        const double deep = std::abs(value()), room = std::min(its_.room(position_), its_.most),
                     step = std::min(std::abs(its_.amount), its_.most_amount);
        const double next = std::min({deep + step, its_.total, room});
        cut_ |= room < std::min(deep + step, its_.total);
        visit_ = Visit::feeds;
        ends_ = next >= std::min(its_.total, room) - nothing;
        target_ = std::copysign(std::max(next, deep), its_.amount);
    }

    // Whether the axis itself is where its offset is.
    void arrive(const Now& now, double dt) noexcept {
        const bool there = !moves() && std::abs(applied_ - value()) <= nothing &&
                           std::abs(now.measured - now.position) <= its_.tolerance;
        if (feeds() && there) {
            visit_ = Visit::none;
            fed_ = true;
            done_ |= ends_;
        }
        begins_ = begins_ && now.strokes && !there;
        late_ = moves() || (!feeds() && !begins_) ? 0 : std::min(late_ + dt, 2 * patience);
        waits_ = now.strokes && (begins_ || visit_ != Visit::none || waits_next_);
        waits_next_ = false;
    }

    Settings its_;  // the last good ones, since it last stood
    TrapezoidalMove move_;
    double target_ = 0, position_ = 0, applied_ = 0;
    double last_deep_ = 0, late_ = 0;  // mu, s
    Visit visit_ = Visit::none;
    bool stands_ = false;  // since machine off
    bool begins_ = false;  // goes out before the first stroke
    bool fed_ = false;     // at this dead point
    bool ends_ = false;    // with the infeed of this dead point
    bool done_ = false, cut_ = false, waits_ = false, waits_next_ = false;
};

}  // namespace plumb
