// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/coverage_factor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

// Readings of an axis at one of its positions, after motion to its + end (up) and to its - end (down), in
// mm: the actual position less the nominal one, or the reading of an indicator that counts up as the axis
// moves to its + end.
struct BothWays {
    double position = 0;  // mm
    std::vector<double> up, down;
};

// The result at one position: E+ = mean + half, E- = mean - half. The lost motion is -2 half.
struct ReversalRow {
    double position = 0;        // mm
    double mean = 0, half = 0;  // mm
    double uncertainty = 0;     // mm, standard, of half
};

struct ReversalResult {
    std::vector<ReversalRow> rows;
    double repeatability = 0;  // mm, standard deviation of a reading, from all positions
    int freedom = 0;           // degrees of freedom of the repeatability
    double lost_motion = 0;    // mm, mean over the positions
    double uncertainty = 0;    // mm, standard, of the lost motion
    double drift = 0;          // mm from one run to the next; 0 if the scatter hides it
};

// The change from one run to the next, of all places and both directions together: a line through the means
// of the runs. 0 unless the line is at least three times as steep as its own uncertainty.
inline double drift_of(const std::vector<BothWays>& places, double repeatability) {
    const std::size_t runs = places.front().up.size();
    if (runs < 3) return 0;
    for (const BothWays& place : places)
        if (place.up.size() != runs || place.down.size() != runs) return 0;
    const double middle = static_cast<double>(runs - 1) / 2, count = 2 * static_cast<double>(places.size());
    double sum = 0, squares = 0;
    for (std::size_t r = 0; r < runs; ++r) {
        double mean = 0;
        for (const BothWays& place : places) mean += (place.up[r] + place.down[r]) / count;
        const double at = static_cast<double>(r) - middle;
        sum += at * mean;
        squares += at * at;
    }
    const double drift = sum / squares;
    return std::abs(drift) > 3 * repeatability / std::sqrt(count * squares) ? drift : 0;
}

// `reading` is the standard uncertainty of a reading if no position was read twice, `own` the standard
// uncertainty of a difference up - down that repeating does not show, as the hysteresis of the indicator.
// Throws std::invalid_argument with the position and the reason.
inline ReversalResult reversal_of(std::vector<BothWays> places, double reading = 0, double own = 0) {
    const auto number = [](double value) {
        std::string text = std::to_string(value);
        text.erase(text.find_last_not_of('0') + 1);
        return text.back() == '.' ? text.substr(0, text.size() - 1) : text;
    };
    if (places.empty()) throw std::invalid_argument("there are no readings");
    std::sort(places.begin(), places.end(),
              [](const BothWays& a, const BothWays& b) { return a.position < b.position; });
    ReversalResult result;
    double squares = 0;
    const auto mean = [](const std::vector<double>& all) {
        double sum = 0;
        for (const double one : all) sum += one;
        return sum / static_cast<double>(all.size());
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
        const BothWays& place = places[i];
        if (place.up.empty() || place.down.empty())
            throw std::invalid_argument("position " + number(place.position) + " was not reached " +
                                        (place.up.empty() ? "from the - side" : "from the + side"));
        if (i > 0 && !(place.position - places[i - 1].position >= 1e-3))
            throw std::invalid_argument("position " + number(place.position) + " is there twice");
        for (const std::vector<double>* side : {&place.up, &place.down}) {
            const double middle = mean(*side);
            for (const double one : *side) squares += (one - middle) * (one - middle);
            result.freedom += static_cast<int>(side->size()) - 1;
        }
    }
    if (result.freedom == 0 && !(reading > 0))
        throw std::invalid_argument(
            "each position was read once in each direction, so the scatter is "
            "unknown: read again, or give the uncertainty of a reading");
    result.repeatability = result.freedom > 0 ? std::sqrt(squares / result.freedom) : reading;
    if (!(result.repeatability >= 1e-8 || reading > 0))
        throw std::invalid_argument(
            "the readings do not scatter at all: give the uncertainty of a reading, "
            "such as a third of a division of the indicator");
    result.drift = drift_of(places, result.repeatability);
    // Between up and down there is up to one run, with any part of its drift.
    own = std::hypot(own, result.drift / std::sqrt(3));
    // Few readings show the repeatability less well.
    const double widening = result.freedom > 0 ? coverage_factor(result.freedom) / 2 : 1;
    const double one = std::max(result.repeatability * widening, reading);
    double variance = 0;
    for (const BothWays& place : places) {
        const double up = mean(place.up), down = mean(place.down);
        const double of_difference =
            one * one *
            (1 / static_cast<double>(place.up.size()) + 1 / static_cast<double>(place.down.size()));
        result.rows.push_back(
            {place.position, (up + down) / 2, (up - down) / 2, std::sqrt(of_difference + own * own) / 2});
        result.lost_motion -= (up - down) / static_cast<double>(places.size());
        variance += of_difference / static_cast<double>(places.size() * places.size());
    }
    result.uncertainty = std::sqrt(variance + own * own);
    return result;
}

// Readings after motion to one end alone: the mean of each place, the half is 0, and the lost motion stays
// unknown.
inline ReversalResult one_way_of(std::vector<BothWays> places, double reading = 0) {
    for (BothWays& place : places)
        (place.up.empty() ? place.up : place.down) = place.up.empty() ? place.down : place.up;
    ReversalResult result = reversal_of(places, reading);
    // Each reading counted twice.
    result.freedom /= 2;
    const double widened = result.freedom > 0 ? std::sqrt(2.0) * coverage_factor(result.freedom) /
                                                    coverage_factor(2 * result.freedom)
                                              : 1;
    for (ReversalRow& row : result.rows) row.uncertainty *= widened;
    return result;
}

}  // namespace plumb
