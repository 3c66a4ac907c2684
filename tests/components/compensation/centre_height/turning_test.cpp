// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

const double degree = std::acos(-1.0) / 180;

TEST(BeamArea, IsInvertedForBothBeams) {
    Random random(1);
    for (int i = 0; i < 5000; ++i) {
        const double radius = random.uniform(0.5, 20), a = random.uniform(0.001, 0.999) * radius;
        const double emitted = std::acos(-1.0) * radius * radius;
        const double received = emitted - covered_of_circle(a, radius);
        const double rounding = 1e-14 * radius / std::sqrt(1 - a * a / (radius * radius));
        EXPECT_NEAR(diameter_in_circle(emitted, received, radius), 2 * a, 1e-9 * a + rounding);
        EXPECT_NEAR(diameter_in_rectangle(40, 40 - 2 * a * 0.5, 0.5), 2 * a, 1e-9 * a);
    }
}

// The integral of the strip, by a sum.
TEST(BeamArea, CoveredAreaIsThatOfTheStrip) {
    double sum = 0;
    for (int i = 0; i < 100000; ++i) sum += 2 * std::sqrt(25 - std::pow(3 * (i + 0.5) / 1e5, 2)) * 3 / 1e5;
    EXPECT_NEAR(covered_of_circle(3, 5), 2 * sum, 1e-6);
}

TEST(BeamArea, WorkThatIsNotInTheBeamHasNoDiameter) {
    for (const double received : {-1.0, 0.0, 40.0, 41.0, std::nan("")}) {
        EXPECT_TRUE(std::isnan(diameter_in_rectangle(40, received, 2))) << received;
        EXPECT_TRUE(std::isnan(diameter_in_circle(40, received, std::sqrt(40 / std::acos(-1.0)))))
            << received;
    }
    EXPECT_TRUE(std::isnan(diameter_in_rectangle(40, 20, 0)));
    EXPECT_TRUE(std::isnan(diameter_in_circle(40, 20, 0)));
    EXPECT_TRUE(std::isnan(diameter_in_circle(100, 1, 3))) << "more than the beam is covered";
}

TEST(LandPair, TakesTheClearanceThatItsFigureSays) {
    EXPECT_FALSE(LandPair::clears(0.2, 0.5, 23.5 * degree, 1));
    EXPECT_TRUE(LandPair::clears(0.2, 0.5, 23.6 * degree, 1));
    EXPECT_FALSE(LandPair::clears(1, 5, 11.5 * degree, 1));
    EXPECT_TRUE(LandPair::clears(1, 5, 11.54 * degree, 1));
    EXPECT_TRUE(LandPair::clears(-1, 5, 7 * degree, 1)) << "below, it does not rub";
    EXPECT_FALSE(LandPair::clears(-1, 5, 7 * degree, -1)) << "upside down, it does";
    EXPECT_TRUE(LandPair::clears(1, 5, 0, 1)) << "nobody checks";
}

TEST(LandPair, AvoidsTheSideThatRubs) {
    const LandPair about = LandPair::of(0.2, 0.5, 0, 1);
    EXPECT_EQ(about.first, 0.2);
    EXPECT_EQ(about.second, -0.2);
    for (const double rubbing : {1.0, -1.0}) {
        const LandPair aside = LandPair::of(0.2, 0.5, 7 * degree, rubbing);
        EXPECT_FALSE(aside.about);
        EXPECT_LE(aside.first * rubbing, 0);
        EXPECT_LE(aside.second * rubbing, 0);
        EXPECT_NEAR(aside.half(), 0.9 * 0.5 * std::sin(7 * degree), 1e-12);
        EXPECT_GT(aside.first, aside.second);
    }
    EXPECT_NEAR(LandPair::of(0.01, 0.5, 0.5 * degree, 1).half(), 0.9 * 0.5 * std::sin(0.5 * degree), 1e-12);
}

TEST(SkewedAxes, TravelAndCorrectionAreThoseOfTheirAngle) {
    const SkewedAxes axes(80 * degree);
    const double travel = axes.travel_for(-0.3);
    EXPECT_NEAR(travel, -0.3 / std::sin(80 * degree), 1e-15);
    EXPECT_NEAR(axes.x_of(travel), -0.3 / std::tan(80 * degree), 1e-15);
    EXPECT_NEAR(axes.height_of(travel), -0.3, 1e-15);
}

TEST(EntrySlip, NamesTheSlip) {
    EXPECT_EQ(slip_of(5.1, 5), EntrySlip::none);
    EXPECT_EQ(slip_of(3.8, 5), EntrySlip::none);
    EXPECT_EQ(slip_of(2.5, 5), EntrySlip::radius);
    EXPECT_EQ(slip_of(10, 5), EntrySlip::doubled);
    EXPECT_EQ(slip_of(5 / 25.4, 5), EntrySlip::inch);
    EXPECT_EQ(slip_of(5 * 25.4, 5), EntrySlip::metric);
    EXPECT_EQ(slip_of(2.5, 0), EntrySlip::none) << "nobody knows the programmed radius";
    for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
        EXPECT_EQ(slip_of(bad, 5), EntrySlip::not_positive);
}

}  // namespace
}  // namespace plumb
