// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/dead_point_watch.hpp"

#include "components/math/blocks/random.hpp"
#include "tests/math/oscillation/watched_oscillation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb {
namespace {

constexpr double degree = pi / 180, um = 1e-3;

// How far a phase is ahead of another one, -pi to pi.
double ahead(double phase, double other) {
    return std::remainder(phase - other, 2 * pi);
}

// An axis that is some samples behind its command, and reaches a part of each distance from a centre.
struct Follower {
    explicit Follower(const Oscillation::Settings& settings) : watched(settings) {
        phase.begin(watched.it.position());
    }

    void step() {
        watched.step();
        const std::size_t last = watched.samples.size() - 1;
        measured = centre + part * (watched.samples[last - std::min(last, behind)] - centre) + noise();
        phase.step(measured, watched.it.plan());
    }

    double noise() { return random.uniform(-scatter, scatter); }

    Watched watched;
    MeasuredPhase phase;
    std::size_t behind = 30;
    double part = 1, centre = 25, scatter = 0, measured = 0;
    Random random{1};
};

TEST(MeasuredPhase, IsLateByTheLagAtEachMomentAlsoWhereTheAxisEndsShortOrBeyond) {
    for (const double part : {1.0, 0.98, 1.01}) {
        SCOPED_TRACE(part);
        Follower axis(usual());
        axis.part = part;
        for (int i = 0; i < 3000; ++i) axis.step();
        const double lag = 2 * 100.0 / 30 * 0.030;  // 2 F / S times the delay
        for (int i = 0; i < 3000; ++i) {
            axis.step();
            ASSERT_NEAR(ahead(axis.watched.it.phase(), axis.phase.phase()), lag, 1.7 * degree) << i;
        }
    }
}

TEST(MeasuredPhase, NoiseOfTheScaleDoesNotTurnIt) {
    Follower axis(usual());
    axis.scatter = 1 * um;
    for (int i = 0; i < 3000; ++i) axis.step();
    double before = axis.phase.phase();
    for (int i = 0; i < 3000; ++i) {
        axis.step();
        ASSERT_GT(ahead(axis.phase.phase(), before), -1.2 * degree) << i;
        before = axis.phase.phase();
    }
}

TEST(MeasuredPhase, AnAxisThatSwingsAtAHoldKeepsItsDirection) {
    Follower axis(usual());
    for (int i = 0; i < 3000 || std::abs(axis.watched.it.phase() - 0.4 * pi) > 0.02; ++i) axis.step();
    axis.watched.hold = Stop::at_once;
    for (int i = 0; i < 400; ++i) axis.step();
    ASSERT_TRUE(axis.watched.it.held());
    const double stands = axis.watched.it.position(), command = axis.watched.it.phase();
    EXPECT_NEAR(axis.phase.phase(), command, 0.5 * degree);
    for (int i = 0; i < 200; ++i) {
        axis.phase.step(stands + 0.2 * std::sin(i / 10.0), axis.watched.it.plan());
        ASSERT_NEAR(axis.phase.phase(), command, 1.5 * degree);
    }
}

TEST(MeasuredPhase, AStrokeWithASlowSectionHasTheSamePhaseAtTheSamePosition) {
    Oscillation::Settings settings = usual();
    settings.sections[0] = {SpeedSection::height_upward, 20, 30, 0.25};
    Follower axis(settings);
    axis.behind = 0;
    for (int i = 0; i < 3000; ++i) axis.step();
    for (int i = 0; i < 3000; ++i) {
        axis.step();
        ASSERT_NEAR(ahead(axis.watched.it.phase(), axis.phase.phase()), 0, 1.2 * degree);
    }
}

// The ends move outward by more than the axis is late.
TEST(MeasuredPhase, AShiftOfTheRegionAndALearnedEndTakeTheEndsOfTheAxisAlong) {
    Follower axis(usual());
    axis.part = 0.98;
    for (int i = 0; i < 3000; ++i) axis.step();
    axis.watched.settings.upper = 45;
    axis.watched.offset[1] = axis.watched.offset[0] = 0.3;
    double before = axis.phase.phase();
    double most = 0;
    for (int i = 0; i < 3000; ++i) {
        axis.step();
        most = std::max(most, std::abs(ahead(axis.phase.phase(), before)));
        before = axis.phase.phase();
    }
    EXPECT_LT(most, 12 * degree);
}

TEST(MeasuredPhase, WithoutAMotionItIsANumber) {
    MeasuredPhase phase;
    phase.begin(10);
    for (const double place : {10.0, 5.0, 20.0}) {
        phase.step(place, StrokePlan());
        EXPECT_EQ(phase.phase(), 0);
    }
}

}  // namespace
}  // namespace plumb
