// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/dead_point_watch.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double dt = 0.001, amplitude = 20;  // s, mm

// Strokes of a crank; the lag has a part by velocity, one by acceleration, and friction.
struct Strokes {
    LagModel model;
    double time = 0, largest = 0;

    // One; returns the largest difference from the last ones.
    double stroke(double w, double extra = 0) {
        model.stroke(true, waits, amplitude * w, 2 * amplitude);
        largest = 0;
        for (double phase = 0; phase < pi; phase += w * dt, time += dt) {
            const double sign = up ? 1 : -1, v = sign * amplitude * w * std::sin(phase),
                         a = sign * amplitude * w * w * std::cos(phase),
                         at = -sign * amplitude * std::cos(phase);
            const double lag = 0.03 * v + 0.0004 * a + sign * 0.01 + extra * sign;
            largest = std::max(largest, std::abs(model.step(at, v, a, at - lag)));
        }
        up = !up;
        return largest;
    }
    bool up = true, waits = false;
};

TEST(LagModel, PredictsAFasterStrokeFromSlowOnes) {
    Strokes strokes;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(strokes.stroke(1), 0) << "not known yet";
    strokes.stroke(1);
    EXPECT_TRUE(strokes.model.known());
    EXPECT_LT(strokes.stroke(3), 0.02) << "of a lag of 1.9 mm; friction turns";
}

TEST(LagModel, AJamShowsWithinTheStroke) {
    Strokes strokes;
    for (int i = 0; i < 6; ++i) strokes.stroke(2);
    EXPECT_LT(strokes.stroke(2), 0.02);
    EXPECT_GT(strokes.stroke(2, 0.5), 0.45);
}

// So the stroke in which a force drops explains neither itself nor the next one.
TEST(LagModel, AStrokeThatEndsWrongTeachesNothing) {
    for (const bool right : {false, true}) {
        Strokes strokes;
        for (int i = 0; i < 6; ++i) strokes.stroke(2);
        strokes.waits = true;
        strokes.stroke(2);
        strokes.model.judge(true);
        const double band = strokes.model.band(), peak = strokes.model.peak();
        strokes.stroke(2, 0.2);
        strokes.stroke(2);  // which begins before the last one is judged
        EXPECT_EQ(strokes.model.band(), band);
        strokes.model.judge(right);
        if (right) {
            EXPECT_GT(strokes.model.band(), 0.15);
            EXPECT_NEAR(strokes.model.peak(), peak + 0.2, 0.01);
        } else {
            EXPECT_EQ(strokes.model.band(), band);
            EXPECT_EQ(strokes.model.peak(), peak);
        }
    }
}

TEST(LagModel, AStrokeThatWasNotWholeIsLeftOut) {
    Strokes strokes;
    for (int i = 0; i < 6; ++i) strokes.stroke(2);
    const int strokes_before = strokes.model.strokes();
    strokes.model.stroke(false, false, 40, 40);
    strokes.model.judge(true);
    EXPECT_EQ(strokes.model.strokes(), strokes_before);
}

// The axis lags, and follows up to an acceleration.
double shown_by(double strongest, double lag, bool upward) {
    ShownAcceleration its;
    const double w = 4, sign = upward ? 1 : -1, hardest = amplitude * w * w;
    its.begin(upward, pi / w, dt);
    double v = 0, place = 0, ended = 0;
    for (double time = 0; time < pi / w; time += dt) {
        const double late = std::max(time - lag, 0.0);
        const double a = std::min(hardest * std::cos(w * late), strongest) * (time >= lag);
        v += a * dt;
        place += v * dt;
        if (its.step(sign * amplitude * (1 - std::cos(w * time)), sign * place)) ++ended;
    }
    EXPECT_EQ(ended, 1);
    EXPECT_NEAR(its.commanded(), hardest, 0.06 * hardest);
    return its.done() / its.commanded();
}

TEST(ShownAcceleration, IsThatOfTheAxisInItsAcceleratingHalf) {
    for (const bool upward : {true, false})
        for (const double lag : {0.0, 0.03}) {
            EXPECT_NEAR(shown_by(1e9, lag, upward), 1, 0.02);
            EXPECT_NEAR(shown_by(240, lag, upward), 240.0 / 320 / 0.96, 0.03) << "of 320";
            EXPECT_NEAR(shown_by(100, lag, upward), 100.0 / 320 / 0.96, 0.03);
        }
}

// The axis turns late, and brakes before that by more than it can accelerate with.
TEST(ShownAcceleration, BrakingIsNoAcceleration) {
    ShownAcceleration its;
    its.begin(true, 1, dt);
    double v = -40, place = 0;
    for (double time = 0; time < 1; time += dt) {
        v += (v < 0 ? 1000 : 200) * dt;
        place += v * dt;
        its.step(250 * time * time, place);
    }
    EXPECT_NEAR(its.commanded(), 500, 1);
    EXPECT_NEAR(its.done(), 200, 5);
}

}  // namespace
}  // namespace plumb
