// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// A homed joint that stands at 50, commanded to 52 by its drive.
struct AxisPlaceTest : testing::Test {
    AxisPlace it;
    AxisPlace::Now now;
    double place = nan;  // the last one to which the command had to go

    AxisPlaceTest() { begin(50, 52); }
    void begin(double measured, double commanded) {
        it = {};
        now = {};
        now.on = now.homed = now.measurable = true;
        now.measured = now.commanded = measured;
        now.most = 10;
        run(1);
        now.commanded = commanded;
        run(1);
        place = nan;
    }
    bool step() {
        const bool goes = it.step(now, dt);
        if (goes) place = now.commanded = it.place();
        return goes;
    }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) step();
    }
    void read(double measured) {
        now.measured = measured;
        step();
    }
    void turn(bool on, double seconds = 0.1) {
        now.on = on;
        run(seconds);
    }
};

TEST_F(AxisPlaceTest, TheCommandFollowsTheAxisOnlyWhileTheDriveIsOff) {
    EXPECT_TRUE(std::isnan(place));
    turn(false);
    EXPECT_EQ(place, 50);
    for (int i = 0; i < 400; ++i) read(now.measured + 1.2);  // a hand pushes, at once with 1.2 m/s
    run(0.01);
    EXPECT_NEAR(place, 50 + 400 * 1.2, 1e-9);
    turn(true);
    const double stands = now.commanded;
    place = nan;
    for (int i = 0; i < 3000; ++i) read(now.measured - 0.001);
    EXPECT_TRUE(std::isnan(place)) << "with the drive on the measured position is not fed back";
    EXPECT_EQ(now.commanded, stands);
    EXPECT_TRUE(it.known());
}

TEST_F(AxisPlaceTest, OffAndOnInAPeriodHoldsWhereTheAxisWas) {
    now.on = false;
    EXPECT_TRUE(step());
    now.on = true;
    EXPECT_FALSE(step());
    EXPECT_EQ(place, 50);
}

TEST_F(AxisPlaceTest, AReadingThatJumpsWhileOffMovesNothingUntilTheJointIsHomedAgain) {
    for (const double to : {0.0, 49.9, 51.0, 1000.0}) {
        SCOPED_TRACE(to);
        begin(50, 52);
        turn(false);
        read(to);
        run(0.1);
        EXPECT_FALSE(it.known());
        EXPECT_EQ(place, 50) << "the last one before the jump";
        turn(true);
        read(50);
        run(2);
        EXPECT_FALSE(it.known()) << "also where it comes back";
        turn(false);
        now.homed = false;
        run(0.1);
        EXPECT_TRUE(it.known()) << "homing may drive it";
        turn(true);
        now.measured = 7;
        run(0.1);
        now.homed = true;
        EXPECT_TRUE(step());
        EXPECT_EQ(place, 7) << "where homing has left it";
        run(2);
        EXPECT_TRUE(it.known());
    }
}

TEST_F(AxisPlaceTest, AReadingThatFailsOrComesBackWithTheDriveMakesThePlaceUnknown) {
    turn(false);
    now.measurable = false;
    step();
    EXPECT_FALSE(it.known());
    begin(50, 52);
    turn(false);
    turn(true, 0.5);
    read(170);
    EXPECT_FALSE(it.known());
}

TEST_F(AxisPlaceTest, AReadingThatFailsJustBeforeTheDriveIsNotFollowed) {
    read(50.3);  // within the lag of a stroke
    read(50.3);
    turn(false);
    EXPECT_FALSE(it.known());
    EXPECT_TRUE(std::isnan(place));
}

TEST_F(AxisPlaceTest, AReadingFarFromTheCommandOrThatNeverAnsweredIsNone) {
    begin(39, 53);
    turn(false);
    EXPECT_FALSE(it.known()) << "14 mm apart, at most 10";
    begin(50, 50);
    now.moves = true;
    for (int i = 0; i < 60; ++i) {
        now.commanded += 0.05;
        step();
    }
    now.moves = false;
    turn(false);
    EXPECT_FALSE(it.known()) << "3 mm without an answer";
}

TEST_F(AxisPlaceTest, AHomedThatIsLostWithTheDriveOnMovesNothing) {
    now.homed = false;
    run(0.5);
    now.homed = true;
    run(0.5);
    now.homed = false;
    now.measured = 52;  // it comes to its command
    run(0.5);
    now.homed = true;
    run(0.5);
    EXPECT_TRUE(std::isnan(place));
}

TEST_F(AxisPlaceTest, AnotherOriginByHomingIsTheNewPlace) {
    now.homed = false;
    run(0.1);
    now.measured = 0;
    run(0.1);
    EXPECT_TRUE(std::isnan(place)) << "LinuxCNC commands it";
    now.homed = true;
    run(0.1);
    EXPECT_EQ(place, 0);
    EXPECT_TRUE(it.known());
}

}  // namespace
}  // namespace plumb
