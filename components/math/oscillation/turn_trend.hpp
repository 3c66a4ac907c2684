// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// How far an axis turns beyond one commanded end of a stroke, by its last two turns there:
//
//     beyond = b + g (E - E1)
//
// E is the mean length of the strokes before and after the turn: the axis turns by the acceleration of both.
// After one turn g is a guess that errs inward for longer strokes: a lag falls with 1 / E at most, an
// overshoot does not fall. After two turns it is the slope between them, in which are also the vibrations
// behind a section, in which the turn moves.
class TurnTrend {
public:
    struct Turn {
        double beyond = 0;  // mu, of the commanded end
        double length = 1;  // mu, mean of both strokes, above 0
    };

    void begin() noexcept {
        slope_ = 0;
        turns_ = 0;
    }

    // `power` is that with which the acceleration goes with the length; `least` the smallest change of the
    // length that shows a slope, mu.
    void add(const Turn& turn, int power, double least) noexcept {
        const double longer = turn.length - last_.length;
        if (turns_ == 0)
            slope_ = guess(turn, power);
        else if (std::abs(longer) > least)
            slope_ = std::clamp((turn.beyond - last_.beyond) / longer, -0.05, 0.3);
        before_ = turns_ > 0 ? last_.length : turn.length;
        last_ = turn;
        if (turns_ < 2) ++turns_;
    }

    // The end, mu outward, from which the axis turns at its dead point between strokes that are `others` long
    // without it. Requires a turn.
    double end(double others) const noexcept {
        return -(last_.beyond + slope_ * (others - last_.length)) / (1 + slope_);
    }

    // Mu, that it may be wrong by, where a part of the slope is doubtful: a turn has its own proportion of
    // the strokes before and after it.
    double doubt(double length, double part) const noexcept {
        return part * std::abs(slope_) *
               std::min(std::abs(length - last_.length), std::abs(length - before_));
    }

    // Mu, by which a turn differs from what the turns before predict; 0 for the first one.
    double surprise(const Turn& turn) const noexcept {
        return turns_ > 0 ? std::abs(turn.beyond - last_.beyond - slope_ * (turn.length - last_.length)) : 0;
    }

    // Whether a turn is one of the same axis, give or take some mu: with a turn before.
    bool explains(const Turn& turn, double slack) const noexcept {
        const double longer = std::abs(turn.length - last_.length) / last_.length;
        return std::abs(turn.beyond - last_.beyond) <= slack + 1.5 * longer * std::abs(last_.beyond);
    }

    double slope() const noexcept { return slope_; }
    bool guesses() const noexcept { return turns_ < 2; }

    // For longer strokes.
    static double guess(const Turn& turn, int power) noexcept {
        const double falls = (turn.beyond < 0 ? 0.5 : -0.5) - 0.5 * power;
        return -falls * turn.beyond / turn.length;
    }
    // For shorter ones, too: the overshoot of a loop near instability grows fast.
    static double careful(const Turn& turn, int power) noexcept {
        return turn.beyond < 0 ? guess(turn, power) : -3 * turn.beyond / turn.length;
    }

private:
    Turn last_;
    double before_ = 1;  // mu, the length of the turn before
    double slope_ = 0;
    int turns_ = 0;
};

}  // namespace plumb
