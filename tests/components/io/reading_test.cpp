// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/sensor/reading.hpp"
#include "components/io/sensor/back_off.hpp"
#include "components/io/sensor/liveness.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

ReadingLimits limits() {
    ReadingLimits limits;
    limits.max_age = 1;
    limits.min = -40;
    limits.max = 120;
    limits.max_rate = 10;
    return limits;
}

TEST(Reading, NothingIsValidBeforeTheFirstValue) {
    const Reading reading = Judge(limits(), 5).at(7);
    EXPECT_FALSE(reading.valid);
    EXPECT_EQ(reading.fault, SensorFault::waiting);
    EXPECT_DOUBLE_EQ(reading.age, 2);
}

TEST(Reading, AValueIsValidUntilItIsTooOld) {
    Judge judge(limits());
    judge.take(10, 20);
    EXPECT_TRUE(judge.at(11).valid);
    EXPECT_EQ(judge.at(11).fault, SensorFault::none);
    EXPECT_FALSE(judge.at(11.001).valid);
    EXPECT_EQ(judge.at(11.001).fault, SensorFault::old);
    EXPECT_EQ(judge.at(11.001).value, 20);
}

TEST(Reading, AFailedRequestLeavesAFreshValueValid) {
    Judge judge(limits());
    judge.take(10, 20);
    judge.fail(SensorFault::silent);
    EXPECT_TRUE(judge.at(10.5).valid);
    EXPECT_EQ(judge.at(10.5).fault, SensorFault::silent);
    EXPECT_EQ(judge.at(10.5).errors, 1);
    EXPECT_FALSE(judge.at(11.5).valid);
    EXPECT_EQ(judge.at(11.5).fault, SensorFault::silent);
}

TEST(Reading, AnImpossibleValueIsInvalidAtOnceAndTheLastOneStays) {
    for (const double wrong :
         {120.1, -40.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Judge judge(limits());
        judge.take(10, 20);
        judge.take(10.1, wrong);
        EXPECT_FALSE(judge.at(10.1).valid) << wrong;
        EXPECT_EQ(judge.at(10.1).fault, SensorFault::range);
        EXPECT_EQ(judge.at(10.1).value, 20);
        judge.take(10.2, 21);
        EXPECT_TRUE(judge.at(10.2).valid) << wrong;
        EXPECT_EQ(judge.at(10.2).fault, SensorFault::none);
    }
}

TEST(Reading, AJumpIsInvalidUntilItsRateIsPossible) {
    Judge judge(limits());
    judge.take(10, 20);
    judge.take(10.1, 30);
    EXPECT_EQ(judge.at(10.1).fault, SensorFault::rate);
    EXPECT_FALSE(judge.at(10.1).valid);
    judge.take(10.9, 30);
    EXPECT_FALSE(judge.at(10.9).valid);
    judge.take(11.1, 30);
    EXPECT_TRUE(judge.at(11.1).valid);
    EXPECT_EQ(judge.at(11.1).value, 30);
}

TEST(Reading, ADistrustedValueIsInvalidThoughItIsFresh) {
    Judge judge(limits());
    judge.take(10, 20);
    judge.reject(SensorFault::damaged);
    EXPECT_FALSE(judge.at(10).valid);
    judge.fail(SensorFault::silent);
    EXPECT_FALSE(judge.at(10).valid);
}

TEST(BackOff, DoublesUpToItsLongestAndStartsAnewAfterSuccess) {
    BackOff back_off(0.5, 3);
    EXPECT_EQ(back_off.until(), 0);
    for (const double wait : {0.5, 1.0, 2.0, 3.0, 3.0}) {
        back_off.failed(100);
        EXPECT_DOUBLE_EQ(back_off.until(), 100 + wait);
    }
    back_off.succeeded();
    EXPECT_EQ(back_off.until(), 0);
    back_off.failed(200);
    EXPECT_DOUBLE_EQ(back_off.until(), 200.5);
}

TEST(Liveness, LivesWhileTheThreadTurnsAndForTwoSecondsMore) {
    Liveness liveness;
    for (std::uint32_t turn = 1; turn < 50; ++turn) EXPECT_TRUE(liveness.lives(turn, 0.1));
    for (int i = 0; i < 19; ++i) EXPECT_TRUE(liveness.lives(49, 0.1)) << i;
    for (int i = 0; i < 6; ++i) liveness.lives(49, 0.1);
    EXPECT_FALSE(liveness.lives(49, 0.1));
    EXPECT_TRUE(liveness.lives(50, 0.1));
}

}  // namespace
}  // namespace plumb
