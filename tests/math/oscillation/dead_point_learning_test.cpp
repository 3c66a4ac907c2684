// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/compensation/chopping/dead_point_watch.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;
using Verdict = DeadPointLearning::Verdict;
constexpr DeadPointLearning::Stroke stroke{10, 40, 100, 1000, 0};

// The acceleration is the same whatever the length of the stroke.
DeadPointLearning::Settings usual() {
    DeadPointLearning::Settings its{0.3, 0.7, 1, 2 * um, 5 * um, 600};
    its.reversal = {600, 600};
    its.stretching = 0;
    return its;
}

int number_of(const DeadPointLearning& learning) {
    OscillationSettings planned;
    learning.restrain(planned);
    return planned.learned;
}

// A turn at full speed, of a stroke with this length.
Verdict turn_at(DeadPointLearning& learning, bool upper, double error, double used, double speed = 100,
                DeadPointLearning::Lengths lengths = {30, 30}) {
    learning.turned(upper, number_of(learning), speed, 1, lengths, error - used);
    return learning.measured(upper, error, used, 600, speed, lengths);
}

// An axis whose dead point lies `overshoot` (at full speed, grows with its square) and `constant` beyond
// the commanded end.
struct Axis {
    double overshoot = 0, constant = 0;
    double force = 1e9;  // mu/s2, inward
    double follows = 1;  // part of the acceleration, where the force suffices
    double length = 30;  // of its stroke

    // One cycle; returns the farthest error beyond a dead point.
    double cycle(DeadPointLearning& learning) const {
        Verdict verdict = Verdict::none;
        return cycle(learning, verdict);
    }
    double cycle(DeadPointLearning& learning, Verdict& verdict) const {
        const double k = learning.speed_factor(), acceleration = 600 * k * k;
        double farthest = -1e9;
        for (const bool upper : {false, true}) {
            const double used = learning.offset(upper, acceleration, 100 * k);
            const double turning = k * k * (1 + learning.braking()) / 2;
            const double error = used + overshoot * turning + constant;
            farthest = std::max(farthest, error);
            EXPECT_TRUE(learning.plausible(upper, error, used, 100 * k));
            // A stroke that was planned before the change is not measured.
            if (learning.shown(upper, acceleration, std::min(follows * acceleration, force))) continue;
            learning.turned(upper, number_of(learning), 100 * k, learning.braking(), {length, length},
                            error - used);
            verdict = learning.measured(upper, error, used, acceleration, 100 * k);
            if (verdict != Verdict::none) break;
        }
        return farthest;
    }
};

TEST(DeadPointLearning, LearnsWithoutEverGoingBeyond) {
    for (const double overshoot : {-0.5, -0.2, -0.01, 0.0, 0.05, 0.2, 0.6})
        for (const double constant : {-5 * um, 0.0, 2 * um}) {
            const Axis axis{overshoot, constant};
            DeadPointLearning learning;
            learning.select(stroke, usual());
            EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
            double farthest = -1e9;
            int cycles = 0;
            for (; learning.speed_factor() < 1 && cycles < 50; ++cycles)
                farthest = std::max(farthest, axis.cycle(learning));
            EXPECT_LT(cycles, 30) << overshoot;
            for (int i = 0; i < 8; ++i) farthest = std::max(farthest, axis.cycle(learning));
            EXPECT_LE(farthest, 5 * um) << overshoot;
            EXPECT_LE(std::abs(axis.cycle(learning)), 2 * um) << overshoot;
            EXPECT_TRUE(learning.learned());
        }
}

TEST(DeadPointLearning, AnAxisThatPassesADeadPointInItsFirstStrokePassesNoneAgain) {
    const Axis axis{0, 2};  // the first ends lie 5 % of the stroke inside, 1.5 mm
    DeadPointLearning learning;
    learning.select(stroke, usual());
    EXPECT_NEAR(axis.cycle(learning), 0.5, um);
    for (int i = 0; i < 50; ++i) EXPECT_LE(axis.cycle(learning), 5 * um);
    EXPECT_TRUE(learning.learned());
}

TEST(DeadPointLearning, RemembersTheStrokesThatItLearned) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    const double offset = learning.offset(true, 600, 100);
    EXPECT_NEAR(offset, 0.2, um);
    learning.select({10, 60, 100, 1000, 0}, usual());
    EXPECT_LT(learning.offset(true, 600, 100), offset - 0.01) << "of another region";
    learning.select(stroke, usual());
    EXPECT_EQ(learning.speed_factor(), 1);
    EXPECT_NEAR(learning.offset(true, 600, 100), offset, um);
    learning.forget();
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
}

// What another run of the program has learned about an axis.
DeadPointLearning::Learned learned_of(const Axis& axis) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    EXPECT_EQ(learning.strokes().size(), 1);
    return learning.strokes()[0];
}

// Restored, and selected.
struct Restored : DeadPointLearning {
    explicit Restored(const Learned& learned) {
        EXPECT_TRUE(restore(learned));
        EXPECT_FALSE(restore(learned)) << "twice";
        select(stroke, usual());
    }

    // To full speed; returns the farthest error beyond a dead point.
    double rise(const Axis& axis) {
        double farthest = -1e9;
        for (int i = 0; i < 50 && speed_factor() < 1; ++i) farthest = std::max(farthest, axis.cycle(*this));
        return farthest;
    }
};

TEST(DeadPointLearning, AnOldRecordIsLearnedAgainAtTheForceOfBefore) {
    for (const double overshoot : {-0.2, 0.1}) {
        const Axis axis{overshoot};
        DeadPointLearning::Learned old = learned_of(axis);
        old.slow = {};
        Restored learning(old);
        EXPECT_NEAR(learning.speed_factor(), std::sqrt(0.671), 1e-9);
        EXPECT_LT(learning.offset(true, 600, 100), -0.2) << "inside first";
        for (int i = 0; i < 8; ++i) EXPECT_LE(axis.cycle(learning), 1 * um);
        EXPECT_TRUE(learning.learned());
    }
}

TEST(DeadPointLearning, ARestoredAxisThatTurnsAsBeforeIsRightAfterItsSecondCycle) {
    for (const double overshoot : {-0.2, 0.1})
        for (const double constant : {-3 * um, 3 * um}) {
            const Axis axis{overshoot, constant};
            const DeadPointLearning::Learned learned = learned_of(axis);
            Restored learning(learned);
            EXPECT_NEAR(learning.speed_factor(), std::sqrt(0.671), 1e-9);
            EXPECT_LT(axis.cycle(learning), -0.1) << "confirms it";
            EXPECT_EQ(learning.speed_factor(), 1);
            EXPECT_LE(axis.cycle(learning), 1 * um) << "shows its force";
            EXPECT_FALSE(learning.rising());
            for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(axis.cycle(learning)), 1 * um);
            EXPECT_TRUE(learning.learned());
        }
}

TEST(DeadPointLearning, ARestoredCorrectionNeedsTheAxisAndTheForceOfBefore) {
    const DeadPointLearning::Learned learned = learned_of(Axis{-0.2});
    Restored other(learned), weaker(learned);
    for (int i = 0; i < 2; ++i) Axis{-0.1}.cycle(other);
    EXPECT_FALSE(other.rising());
    EXPECT_LT(other.offset(true, 600, 100), 0.1) << "turns elsewhere";
    for (int i = 0; i < 2; ++i) Axis{-0.2, 0, 540}.cycle(weaker);
    EXPECT_TRUE(weaker.rising()) << "lacks force";
    EXPECT_LT(weaker.offset(true, 600, 100), -0.2);
    EXPECT_LT(weaker.speed_factor(), 1) << "back to the force that it has shown";
}

// It lags where it accelerates, and friction helps it to brake.
TEST(DeadPointLearning, ADriveAtItsLimitThatHasLearnedAStrokeIsNotAccusedAfterARestart) {
    const Axis axis{-0.2, 0, 540, 0.97};
    const DeadPointLearning::Learned learned = learned_of(axis);
    EXPECT_NEAR(learned.shown[0], 540, 1e-9);
    Restored learning(learned), weaker(learned);
    for (int i = 0; i < 6; ++i) axis.cycle(learning);
    EXPECT_FALSE(learning.weak_drive());
    EXPECT_TRUE(learning.at_full_speed());
    EXPECT_TRUE(learning.learned());
    for (int i = 0; i < 2; ++i) Axis{-0.2, 0, 480, 0.97}.cycle(weaker);
    EXPECT_TRUE(weaker.rising());
    EXPECT_LT(weaker.speed_factor(), 0.9) << "rises again, carefully";
}

TEST(DeadPointLearning, ALargeLagOfARestoredStrokeIsPlausible) {
    Restored learning({stroke, {6, 6}, {6, 6}, 600, 600, {-4, -4}, {}});
    EXPECT_TRUE(learning.plausible(true, -4.3, -0.3, 82));
    EXPECT_FALSE(learning.plausible(true, -8, -0.3, 82));
}

TEST(DeadPointLearning, ARestoredStrokeKeepsItsFirstCorrection) {
    const Axis rougher{-0.23};
    Restored learning(learned_of(Axis{-0.2}));
    learning.rise(rougher);
    EXPECT_EQ(learning.drift(), 0) << "not measured yet";
    for (int i = 0; i < 10; ++i) rougher.cycle(learning);
    EXPECT_NEAR(learning.drift(), 0.03, um);
    EXPECT_NEAR(learning.strokes()[0].offset[1], 0.23, um);
    EXPECT_NEAR(learning.strokes()[0].first_offset[1], 0.2, um);
}

// A drive that was tuned, a scale that was changed: the record is of another axis.
TEST(DeadPointLearning, ARecordOfAnotherAxisNeverTakesItBeyond) {
    for (const double was : {-0.9, -0.2, 0.0, 0.2})
        for (const double is : {-0.5, -0.05, 0.0, 0.05, 0.4}) {
            const Axis axis{is};
            Restored learning(learned_of(Axis{was}));
            double farthest = learning.rise(axis);
            for (int i = 0; i < 12; ++i) farthest = std::max(farthest, axis.cycle(learning));
            EXPECT_LE(farthest, 5 * um) << was << " " << is;
            EXPECT_TRUE(learning.learned());
        }
}

TEST(DeadPointLearning, WhatTakesTheAxisBeyondIsNotTrustedAgain) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) Axis{-0.2}.cycle(learning);
    learning.restart();
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
    learning.select({10, 60, 100, 1000, 0}, usual());
    learning.select(stroke, usual());
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow) << "of the same region, later";
}

TEST(DeadPointLearning, ADeadPointIsPlausibleBetweenTheLastOneAndItsSquare) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    constexpr double slack = 0.1 * 30 + 0.3;
    EXPECT_TRUE(learning.plausible(true, -slack + um, 0, 20));
    EXPECT_FALSE(learning.plausible(true, -slack - um, 0, 20));
    EXPECT_FALSE(learning.plausible(true, slack + um, 0, 20));
    turn_at(learning, true, -1, 0, 50);
    EXPECT_TRUE(learning.plausible(true, -4 - slack + um, 0, 100));
    EXPECT_FALSE(learning.plausible(true, -4 - slack - um, 0, 100));
    EXPECT_FALSE(learning.plausible(true, -1 + slack + um, 0, 100));
    EXPECT_TRUE(learning.plausible(true, 0, 1, 50)) << "commanded 1 beyond";
}

TEST(DeadPointLearning, TheFirstDeadPointOfAnotherStrokeIsPlausible) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    EXPECT_FALSE(learning.plausible(true, -8, 0, 100)) << "nothing is known of the axis";
    for (int i = 0; i < 40; ++i) axis.cycle(learning);
    ASSERT_TRUE(learning.learned());
    learning.select({0, 20, 60, 1000, 0}, usual());
    EXPECT_TRUE(learning.plausible(true, -8, 0, 60));
}

// Also below the full speed an axis may not stand at an end that was learned for a turn.
TEST(DeadPointLearning, TheLastGoodSpeedHasAnInsetForAStand) {
    const Axis weak{-0.2, 0, 400};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 60; ++i) weak.cycle(learning);
    ASSERT_TRUE(learning.capped());
    ASSERT_FALSE(learning.rising());
    OscillationSettings planned;
    learning.restrain(planned);
    EXPECT_GE(planned.caution, 0.15);
}

TEST(DeadPointLearning, TheWayToTheEndRisesUntilTheAxisIsAnother) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    const auto learned = [&] {
        for (int i = 0; i < 40; ++i) axis.cycle(learning);
        OscillationSettings planned;
        learning.restrain(planned);
        return planned.end_acceleration;
    };
    EXPECT_NEAR(learned(), 0.04 * 600, 1e-9);
    EXPECT_FALSE(learning.ended(0));
    EXPECT_NEAR(learned(), 1.6 * 0.04 * 600, 1e-9);
    EXPECT_TRUE(learning.ended(6 * um));
    EXPECT_LT(learned(), 0.04 * 600);
    learning.restart();
    EXPECT_NEAR(learned(), 0.04 * 600, 1e-9);
}

TEST(DeadPointLearning, CountsTheCyclesInWhichItHasNotLearned) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    const auto strays = [&](int cycles) {
        for (int i = 0; i < cycles; ++i) Axis{-0.2, i % 2 == 0 ? 0 : -4.5 * um}.cycle(learning);
    };
    while (learning.speed_factor() < 1) Axis{-0.2}.cycle(learning);
    strays(10);
    EXPECT_GE(learning.cycles(), 5);
    for (int i = 0; i < 30; ++i) Axis{-0.2}.cycle(learning);
    ASSERT_TRUE(learning.learned());
    EXPECT_EQ(learning.cycles(), 0);
    strays(10);
    EXPECT_GE(learning.cycles(), 5);
    learning.select({0, 20, 60, 1000, 0}, usual());
    EXPECT_EQ(learning.cycles(), 0);
}

TEST(DeadPointLearning, AnImpossibleRecordIsRefused) {
    const DeadPointLearning::Learned good{stroke, {0.1, 0.1}, {0.1, 0.1}, 600};
    DeadPointLearning learning;
    for (int i = 0; i < 4; ++i) {
        DeadPointLearning::Learned bad = good;
        (i == 0 ? bad.offset[0] : i == 1 ? bad.reversal : i == 2 ? bad.stroke.speed : bad.stroke.upper) = NAN;
        EXPECT_FALSE(learning.restore(bad)) << i;
    }
    EXPECT_TRUE(learning.restore(good));
}

TEST(DeadPointLearning, TheNinthStrokeTakesThePlaceOfTheFirst) {
    const Axis axis{-0.1};
    DeadPointLearning learning;
    for (int i = 0; i <= LearnedStrokes::most; ++i) {
        learning.select({10.0 - i, 40, 100, 1000, 0}, usual());
        for (int k = 0; k < 20; ++k) axis.cycle(learning);
        ASSERT_TRUE(learning.learned()) << i;
    }
    EXPECT_EQ(learning.strokes().size(), LearnedStrokes::most);
    EXPECT_EQ(learning.strokes()[0].stroke.lower, 10.0 - LearnedStrokes::most);
    EXPECT_EQ(learning.strokes()[1].stroke.lower, 9);
}

TEST(DeadPointLearning, AnEndBeyondComesBackWithTheAcceleration) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    EXPECT_NEAR(learning.offset(true, 300, 100), 0.1, um);
    EXPECT_NEAR(learning.offset(true, 6000, 100), 0.2, um) << "never farther than learned";
}

TEST(DeadPointLearning, AboveFullSpeedAnAxisThatOvershootsEndsFartherInside) {
    const Axis axis{0.1};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    EXPECT_NEAR(learning.offset(true, 600, 100), -0.1, um);
    EXPECT_NEAR(learning.offset(true, 600, 150), -0.225, 2.25 * um);
    EXPECT_NEAR(learning.offset(true, 600, 50), -0.1, um);
}

TEST(DeadPointLearning, StaysWithinTheLargestCorrection) {
    const Axis axis{-3};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 60; ++i) axis.cycle(learning);
    EXPECT_EQ(learning.offset(true, 600, 100), 1);
    EXPECT_FALSE(learning.learned());
    EXPECT_GE(learning.cycles(), 20);
}

TEST(DeadPointLearning, GoesBackAtOnceFromFarBeyond) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    const double used = learning.offset(true, 600, 100);
    turn_at(learning, true, 0.05, used);
    EXPECT_LE(learning.offset(true, 600, 100), used - 0.05);
    EXPECT_EQ(turn_at(learning, false, 0, used), Verdict::beyond);
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
}

TEST(DeadPointLearning, BeginsAtFullSpeedBelowTheProvenAcceleration) {
    Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    DeadPointLearning::Settings settings = usual();
    for (const double demand : {100.0, 599.0, 600.0}) {
        axis.length = 50 + demand;
        settings.demand = demand;
        learning.select({10, 60 + demand, 100, 1000, 0}, settings);
        EXPECT_EQ(learning.speed_factor(), 1) << demand;
        double farthest = -1e9;
        for (int i = 0; i < 3; ++i) farthest = std::max(farthest, axis.cycle(learning));
        EXPECT_LE(farthest, 5 * um);
        EXPECT_LE(std::abs(axis.cycle(learning)), 2 * um) << "in its fourth cycle";
    }
    settings.demand = 900;
    learning.select({10, 90, 100, 1000, 0}, settings);
    EXPECT_NEAR(learning.speed_factor(), std::sqrt(1.1 * 600 / 900), 1e-9) << "a tenth more is proven, too";
}

// Such an axis can even turn beyond its command beside a section.
TEST(DeadPointLearning, BesideASectionItBeginsInsideWhereAnEvenStrokeLags) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    DeadPointLearning::Settings settings = usual();
    learning.select(stroke, settings);
    for (int i = 0; i < 30; ++i) {
        axis.cycle(learning);
        for (const bool upper : {false, true})
            learning.turned(upper, number_of(learning), 100, 1, {30, 30}, -0.2);
    }
    settings.even = false;
    learning.select({10, 40, 100, 1000, 1}, settings);
    EXPECT_EQ(learning.speed_factor(), 1);
    EXPECT_LE(learning.offset(false, 600, 100), 0.2 - 0.3 + um);
    EXPECT_GE(learning.offset(false, 600, 100), -0.3);
}

// An axis whose lag falls with a power of the mean length of the strokes before and after a turn.
struct LaggingAxis {
    double lag = 0, falls = 1;
    double ends[2] = {0, 0};

    // Returns the larger error of both dead points.
    double cycle(DeadPointLearning& learning) {
        double farthest = -1e9;
        for (const bool upper : {false, true}) {
            const double way = 30 + ends[!upper], k = learning.speed_factor();
            ends[upper] = learning.offset(upper, 600 * k * k, 100 * k, way);
            const double before = way + ends[upper],
                         after = 30 + ends[upper] + learning.offset(!upper, 600, 100);
            const double mean = (before + after) / 2;
            const double beyond = -lag * k * k * std::pow(30 / mean, falls), error = ends[upper] + beyond;
            farthest = std::max(farthest, error);
            learning.shown(upper, 600 * k * k, 600 * k * k);
            learning.turned(upper, number_of(learning), 100 * k, 1, {before, after}, beyond);
            learning.measured(upper, error, ends[upper], 600 * k * k, 100 * k, {before, after});
        }
        return farthest;
    }
};

TEST(DeadPointLearning, ALagBesideASectionIsRightInItsFourthCycle) {
    for (const double lag : {-1.5, 0.5, 1.5, 3.0})
        for (const double falls : {0.1, 0.5, 1.0}) {
            LaggingAxis axis{lag, falls};
            DeadPointLearning learning;
            DeadPointLearning::Settings settings = usual();
            settings.most = 5;
            learning.select(stroke, settings);
            for (int i = 0; i < 50; ++i) EXPECT_LE(axis.cycle(learning), 5 * um);
            EXPECT_TRUE(learning.learned());
            settings.even = false;
            learning.select({10, 40, 100, 1000, 1}, settings);
            axis.ends[0] = axis.ends[1] = -0.15;
            axis.lag *= 1.1;
            EXPECT_EQ(learning.speed_factor(), 1);
            for (int i = 0; i < 3; ++i) EXPECT_LE(axis.cycle(learning), 1 * um) << lag << " " << falls;
            // An overshoot, and a lag of a tenth of the stroke, lie inside by a little for two cycles more.
            const bool usual = lag > 0 && lag < 2;
            for (int i = 0; i < 9; ++i) {
                const double error = axis.cycle(learning);
                EXPECT_LE(std::abs(error), (usual || i > 1 ? 2 : 15) * um) << i << " " << lag << " " << falls;
                EXPECT_LE(error, 1 * um) << i << " " << lag << " " << falls;
            }
        }
}

TEST(DeadPointLearning, AStrokeFromAnotherDeadPointIsNoneThatItLearns) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    OscillationSettings planned;
    learning.restrain(planned);
    EXPECT_TRUE(learning.has(true, 40, 10, planned.learned));
    EXPECT_TRUE(learning.has(false, 10, 40, planned.learned));
    EXPECT_FALSE(learning.has(false, 10, 38, planned.learned)) << "of the region before";
    EXPECT_FALSE(learning.has(true, 38, 10, planned.learned));
}

TEST(DeadPointLearning, AStrokeThatWasPlannedWithOtherSectionsIsNoneThatItLearns) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    OscillationSettings planned;
    learning.restrain(planned);
    learning.select({10, 40, 100, 1000, 1}, usual());
    EXPECT_FALSE(learning.has(true, 40, 10, planned.learned));
    learning.restrain(planned);
    EXPECT_TRUE(learning.has(true, 40, 10, planned.learned));
    learning.select({10, 40, 100, 1000, 1}, usual());
    EXPECT_TRUE(learning.has(true, 40, 10, planned.learned)) << "selected again";
}

TEST(DeadPointLearning, ATurnOfAStrokeThatWasPlannedBeforeTheSectionTeachesNothing) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    DeadPointLearning::Settings settings = usual();
    learning.select(stroke, settings);
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    const int before = number_of(learning);
    settings.even = false;
    learning.select({10, 40, 100, 1000, 1}, settings);
    const double end = learning.offset(false, 600, 100);
    learning.turned(false, before, 100, 1, {30, 30}, -0.2);
    EXPECT_EQ(learning.offset(false, 600, 100), end);
    learning.turned(false, number_of(learning), 100, 1, {30, 30}, -0.2);
    EXPECT_GT(learning.offset(false, 600, 100), end);
}

// The shorter the way from the section to the end, the quicker the turn.
TEST(DeadPointLearning, AnOvershootBesideASectionGrowsWithTheSquareOfTheFrequency) {
    const Axis axis{0.02};
    for (const double shortness : {1.0, 5.0, 100.0}) {
        DeadPointLearning learning;
        DeadPointLearning::Settings settings = usual();
        settings.most = 5;
        learning.select(stroke, settings);
        for (int i = 0; i < 30; ++i) {
            axis.cycle(learning);
            for (const bool upper : {false, true})
                learning.turned(upper, number_of(learning), 100, 1, {30, 30}, 0.02);
        }
        settings.even = false;
        settings.shortness = {shortness, 1};
        learning.select({10, 40, 100, 1000, 1}, settings);
        const double grown = std::min(1.3 * 0.02 * (shortness * shortness - 1), 0.05 * 30);
        EXPECT_NEAR(learning.offset(false, 600, 100), -0.02 - std::max(0.31, grown), 2 * um) << shortness;
        EXPECT_NEAR(learning.offset(true, 600, 100), -0.02 - 0.3 - 0.01, 2 * um);
    }
}

TEST(DeadPointLearning, TheFirstTurnAfterAStartCorrectsLess) {
    LaggingAxis axis{0.1, 1};
    DeadPointLearning learning;
    DeadPointLearning::Settings settings = usual();
    settings.most = 5;
    learning.select(stroke, settings);
    for (int i = 0; i < 40; ++i) axis.cycle(learning);
    ASSERT_TRUE(learning.learned());
    learning.select({5, 35, 90, 1000, 0}, settings);
    EXPECT_EQ(learning.speed_factor(), 1);
    axis.lag = 0.107;  // in the start
    EXPECT_LE(axis.cycle(learning), 0);
    axis.lag = 0.1;
    EXPECT_LE(axis.cycle(learning), 5 * um);
    axis.cycle(learning);
    EXPECT_LE(std::abs(axis.cycle(learning)), 2 * um);
}

TEST(DeadPointLearning, TheShorterStrokeOfAStartCorrectsNoLearnedEnd) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    ASSERT_TRUE(learning.learned());
    const double end = learning.offset(true, 600, 100);
    turn_at(learning, true, -0.003, end, 100, {30.1, 30.4});
    EXPECT_EQ(learning.offset(true, 600, 100), end);
    turn_at(learning, true, -0.003, end, 100, {30.4, 30.4});
    EXPECT_NEAR(learning.offset(true, 600, 100), end + 0.7 * 0.003, 1e-9);
}

TEST(DeadPointLearning, AnEndGoesOnlyInwardBetweenStrokesOfAnotherLength) {
    for (const double lag : {2.0, -0.5}) {
        LaggingAxis axis{lag, 1};
        DeadPointLearning learning;
        DeadPointLearning::Settings settings = usual();
        settings.most = 5;
        learning.select(stroke, settings);
        for (int i = 0; i < 40; ++i) axis.cycle(learning);
        EXPECT_TRUE(learning.learned());
        const double steady = learning.offset(true, 600, 100, 30 + axis.ends[0]);
        EXPECT_NEAR(steady, axis.ends[1], um);
        for (const double other : {-1.0, 1.0}) {
            const double its = learning.offset(true, 600, 100, 30 + axis.ends[0] + other);
            EXPECT_LE(its, steady + um);
            if (other * lag > 0) {
                EXPECT_LT(its, steady - std::abs(lag) / 60 + um) << "turns farther out";
            }
        }
    }
}

TEST(DeadPointLearning, AWeakDriveKeepsTheSpeedThatItHasShown) {
    const Axis axis{-0.2, 0, 300};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 60; ++i) axis.cycle(learning);
    EXPECT_TRUE(learning.weak_drive());
    EXPECT_TRUE(learning.learned()) << "at this speed";
    EXPECT_EQ(learning.strokes().size(), 0) << "not learned for the full one";
    EXPECT_LE(600 * std::pow(learning.speed_factor(), 2), 300);
    EXPECT_GE(600 * std::pow(learning.speed_factor(), 2), 240);
    learning.select({10, 60, 100, 1000, 0}, usual());
    EXPECT_LE(600 * std::pow(learning.speed_factor(), 2), 300) << "in each region";
    learning.open();
    for (int i = 0; i < 60; ++i) Axis{-0.2}.cycle(learning);
    EXPECT_FALSE(learning.weak_drive());
}

// An axis that was good at each speed goes beyond at full speed, each time.
TEST(DeadPointLearning, AfterTheSecondTimeBeyondTheLastGoodSpeedStays) {
    DeadPointLearning learning;
    learning.select(stroke, usual());
    int times = 0;
    for (int i = 0; i < 200; ++i) {
        Verdict verdict = Verdict::none;
        Axis{learning.speed_factor() == 1 ? 0.6 : 0.0}.cycle(learning, verdict);
        times += verdict == Verdict::beyond;
        if (verdict == Verdict::beyond) {
            EXPECT_LT(learning.speed_factor(), 1);
        }
    }
    EXPECT_EQ(times, 2);
    EXPECT_TRUE(learning.capped());
    EXPECT_GT(learning.speed_factor(), 0.6);
    EXPECT_LT(learning.speed_factor(), 1);
    learning.open();
    EXPECT_FALSE(learning.capped());
}

bool undecided(Verdict verdict) {
    return verdict == Verdict::none || verdict == Verdict::passed;
}

TEST(DeadPointLearning, AScaleThatSlipsIsNamedAndNotLearned) {
    const Axis axis{-0.2};
    for (const double slip : {-0.03, 0.006, 0.5}) {
        DeadPointLearning learning;
        learning.select(stroke, usual());
        for (int i = 0; i < 30; ++i) axis.cycle(learning);
        ASSERT_TRUE(learning.learned());
        const double offset = learning.offset(true, 600, 100);
        Verdict verdict = Verdict::none;
        for (int i = 0; i < 8 && undecided(verdict); ++i) {
            const bool upper = i % 2 != 0;
            const double used = learning.offset(upper, 600, 100);
            verdict = turn_at(learning, upper, used - 0.2 + (upper ? slip : -slip), used);
        }
        EXPECT_EQ(verdict, Verdict::slips) << slip;
        EXPECT_NEAR(learning.offset(true, 600, 100), offset, 1e-9) << slip;
    }
}

// Where an end lies once it was corrected depends on the scale; where the axis turns beyond its command does
// not.
TEST(DeadPointLearning, AScaleThatSlipsTakesTheAxisNowhere) {
    for (const bool first : {false, true})
        for (const double slip : {-0.5, -0.03, 0.006, 0.5}) {
            const Axis axis{-0.2};
            DeadPointLearning learning;
            learning.select(stroke, usual());
            for (int i = 0; i < 30; ++i) axis.cycle(learning);
            ASSERT_TRUE(learning.learned());
            Verdict verdict = Verdict::none;
            double ends[2] = {learning.offset(false, 600, 100), learning.offset(true, 600, 100)};
            for (int i = 0; i < 8 && undecided(verdict); ++i) {
                const bool upper = first == (i % 2 == 0);
                verdict = turn_at(learning, upper, ends[upper] - 0.2 + (upper ? slip : -slip), ends[upper]);
                EXPECT_LE(learning.offset(upper, 600, 100) - 0.2, 1 * um) << slip << ", turn " << i;
                ends[!upper] = learning.offset(!upper, 600, 100);  // of the next stroke
            }
            EXPECT_EQ(verdict, Verdict::slips) << slip;
            for (int i = 0; i < 4; ++i) {
                const double used = learning.offset(i % 2, 600, 100);
                EXPECT_EQ(turn_at(learning, i % 2, used - 0.2, used), Verdict::none)
                    << "the scale is right again, " << slip;
            }
        }
}

// A drive that loses force goes beyond at an end, and short at the next one, as if its scale had slipped.
TEST(DeadPointLearning, APassedDeadPointIsToldAtOnceAndLearningBeginsAgain) {
    for (const bool first : {false, true})
        for (const double next : {0.0, -43 * um}) {
            const Axis axis{-0.2};
            DeadPointLearning learning;
            learning.select(stroke, usual());
            for (int i = 0; i < 30; ++i) axis.cycle(learning);
            ASSERT_TRUE(learning.learned());
            const auto turn = [&](bool upper, double elsewhere) {
                const double used = learning.offset(upper, 600, 100);
                return turn_at(learning, upper, used - 0.2 + elsewhere, used);
            };
            EXPECT_EQ(turn(first, 24 * um), Verdict::passed);
            EXPECT_FALSE(learning.rising()) << "the scale may have slipped";
            Verdict verdict = turn(!first, next);
            if (next != 0) {
                EXPECT_EQ(verdict, Verdict::none);
                verdict = turn(first, -68 * um);
            }
            EXPECT_EQ(verdict, Verdict::beyond) << next;
            EXPECT_TRUE(learning.rising());
        }
}

TEST(DeadPointMeter, FindsTheVertexBetweenSamples) {
    for (const bool upward : {true, false})
        for (double shift = 0; shift < 1; shift += 0.1) {
            DeadPointMeter meter;
            meter.begin(upward);
            const double sign = upward ? 1 : -1;
            for (int i = 0; i < 100; ++i) {
                const double t = (i - 50 + shift) * 0.001;
                meter.step(sign * (7 - 800 * t * t / 2));
                if (i < 50) {
                    EXPECT_FALSE(meter.found()) << i;
                }
            }
            ASSERT_TRUE(meter.found());
            EXPECT_NEAR(meter.position(), sign * 7, 1e-9);
        }
}

}  // namespace
}  // namespace plumb
