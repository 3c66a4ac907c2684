// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_settings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

// Strokes of 30 mm at 60 mm/s, from R at 50.
struct Values : testing::Test {
    StrokeSettings it;

    Values() {
        it.lower = 10;
        it.upper = 40;
        it.feed = 60;
        it.max_acceleration = 1000;
        it.max_feed = 200;
        it.min_limit = -100;
        it.max_limit = 100;
        it.max_offset = 500;
        it.max_lead = 0.02;
        it.max_output_acceleration = 3000;
        it.in_range = true;
    }
    Fault refusal() const { return it.refusal(it.lower, it.upper, 50, dt); }
};

TEST_F(Values, EachReasonRefusesTheStroke) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    using Change = std::function<void(StrokeSettings&)>;
    const std::vector<std::pair<Change, Fault>> reasons{
        {[](StrokeSettings&) {}, Fault::none},
        {[](StrokeSettings& its) { its.in_range = false; }, Fault::settings},
        {[](StrokeSettings& its) { its.jerk_time = 0.2; }, Fault::settings},
        {[](StrokeSettings& its) { its.max_feed = nan; }, Fault::settings},
        {[](StrokeSettings& its) { its.min_limit = 100; }, Fault::settings},
        {[](StrokeSettings& its) { its.override_ = 0.005; }, Fault::settings},
        {[](StrokeSettings& its) { its.override_ = 0; }, Fault::none},
        {[](StrokeSettings& its) { its.upper = 10; }, Fault::region},
        {[](StrokeSettings& its) { its.lower = nan; }, Fault::region},
        {[](StrokeSettings& its) { its.upper = 2e6; }, Fault::region},
        {[](StrokeSettings& its) { its.feed = 201; }, Fault::speed},
        {[](StrokeSettings& its) { its.feed = 0; }, Fault::speed},
        {[](StrokeSettings& its) { its.speed_kind = 5; }, Fault::speed},
        {[](StrokeSettings& its) {
             its.section[0] = {SpeedSection::height, 20, 30, 0};
         },
         Fault::sections},
        {[](StrokeSettings& its) {
             its.section[0] = {SpeedSection::height, 20, 30, 0.5};
             its.section[1] = {SpeedSection::height, 25, 35, 0.5};
         },
         Fault::sections},
        {[](StrokeSettings& its) {
             its.refuse_slower = true;
             its.max_acceleration = 239;  // 2 F^2 / S is 240
         },
         Fault::acceleration},
        {[](StrokeSettings& its) {
             its.refuse_slower = true;
             its.max_acceleration = 241;
         },
         Fault::none},
        {[](StrokeSettings& its) { its.lead = 0.01; }, Fault::lead},  // without a jerk-time
        {[](StrokeSettings& its) { its.max_limit = 39; }, Fault::soft_limit},
        {[](StrokeSettings& its) { its.min_limit = 11; }, Fault::soft_limit},
        {[](StrokeSettings& its) { its.max_offset = 39.9; },
         Fault::soft_limit},                                                // R to the lower dead point is 40
        {[](StrokeSettings& its) { its.taper = 3.8; }, Fault::soft_limit},  // R - 3.8 x 40 is below -100
        {[](StrokeSettings& its) { its.taper = 3.7; }, Fault::none},
    };
    const StrokeSettings good = it;
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        it = good;
        reasons[i].first(it);
        EXPECT_EQ(refusal(), reasons[i].second) << i;
    }
}

TEST_F(Values, ACorrectionNeedsItsPlaceWhileItLearns) {
    it.max_limit = 40.5;
    it.max_correction = 1;
    EXPECT_EQ(it.refusal(it.lower, it.upper, 40, dt), Fault::none);
    it.learn = true;
    EXPECT_EQ(it.refusal(it.lower, it.upper, 40, dt), Fault::soft_limit);
}

TEST_F(Values, ALeadAddsItsTimeTimesTheJerk) {
    it.lead = 0.01;
    it.jerk_time = 0.0101;  // 1000 (1 + 2 x 0.01 / 0.0101) is 2980
    EXPECT_TRUE(it.leads());
    it.jerk_time = 0.0099;
    EXPECT_FALSE(it.leads());
    EXPECT_TRUE(it.leads(0.01, 0.02)) << "by the command that runs";
    EXPECT_TRUE(it.leads(0, 0));
    it.jerk_time = 0.1;
    it.lead = 0.021;
    EXPECT_FALSE(it.leads()) << "above max-lead";
}

TEST_F(Values, EachKindOfSpeedGivesItsPeak) {
    constexpr double pi = 3.14159265358979;
    const std::vector<std::pair<double, double>> kinds{
        {60, 60}, {60, 30 * pi}, {0.5, 15 * pi}, {2, 15 * pi}, {2, 15 * pi}};
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
        it.speed_kind = static_cast<int>(kind);
        it.feed = it.frequency = it.cycle_time = kinds[kind].first;
        EXPECT_NEAR(it.peak_speed(30), kinds[kind].second, 1e-9) << kind;
    }
}

TEST_F(Values, TheEndAfterANumberOfStrokesIsNeverAtOnce) {
    it.stop_kind = StrokeSettings::at_once;
    EXPECT_EQ(it.stop(), Oscillation::Stop::at_once);
    EXPECT_EQ(it.ending(), Oscillation::Stop::dead_point);
    it.stop_kind = StrokeSettings::at_lower;
    EXPECT_EQ(it.ending(), Oscillation::Stop::lower);
}

TEST_F(Values, WhatChangesTheTurnOfTheAxisMakesAnotherLearnedStroke) {
    const StrokeSettings::Command command;
    const auto number = [&](const StrokeSettings& its) {
        return its.learned_stroke(10, 40, command).sections;
    };
    std::vector<StrokeSettings> all(6, it);
    all[1].section[0] = {SpeedSection::height, 20, 30, 0.5};
    all[2].section[0] = {SpeedSection::height, 20, 30, 0.6};
    all[3].lower_dwell = 0.1;
    all[4].upper_dwell = 0.1;
    all[5].exact_stop = 0.01;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) EXPECT_NE(number(all[i]), number(all[j])) << i << " " << j;
    EXPECT_NE(it.learned_stroke(10, 40, {0.01, 0.02}).sections, number(it));
    StrokeSettings other = it;
    other.spark_out = 3;
    other.override_ = 0.5;
    other.max_drift = 7;
    EXPECT_EQ(number(other), number(it));
}

TEST_F(Values, TheWayFromASectionToAnEndIsAShorterStroke) {
    const Reciprocation base{10, 40, 60};
    EXPECT_EQ(it.shortness(base, true), 1);
    it.section[0] = {SpeedSection::height, 20, 30, 0.5};
    EXPECT_NEAR(it.shortness(base, true), 3, 1e-9);
    EXPECT_NEAR(it.shortness(base, false), 3, 1e-9);
    it.section[0] = {SpeedSection::height_upward, 20, 34, 0.5};
    EXPECT_NEAR(it.shortness(base, true), 5, 1e-9);
    EXPECT_EQ(it.shortness(base, false), 1);
}

TEST_F(Values, DemandsItsPeakAccelerationOrAllBesideASection) {
    EXPECT_NEAR(it.demand(30), 240, 1e-9);
    it.feed = 190;
    EXPECT_EQ(it.demand(30), 1000);
    it.feed = 60;
    it.section[0] = {SpeedSection::height, 20, 30, 0.5};
    EXPECT_EQ(it.demand(30), 1000);
}

}  // namespace
}  // namespace plumb
