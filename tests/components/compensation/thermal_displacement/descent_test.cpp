// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

// A tool of one operation that moves along Z in steps of a hundredth of a millimetre.
struct Tool {
    void feed(double to) { move(to, true); }
    void retract(double to) { move(to, false); }
    void rest() { descent.step(z, false, false, operation, 1); }

    Descent descent;
    double z = 3;
    int operation = 10;

private:
    void move(double to, bool feeds) {
        while (std::abs(to - z) > 1e-6) {
            z += std::copysign(std::min(0.01, std::abs(to - z)), to - z);
            descent.step(z, feeds && to < z + 0.01, !feeds, operation, 1);
        }
    }
};

TEST(Descent, LastsUntilTheToolIsBackWhereItBegan) {
    Tool tool;
    EXPECT_FALSE(tool.descent.under_way());
    tool.feed(-3);
    tool.rest();
    EXPECT_TRUE(tool.descent.under_way());
    tool.retract(2.5);
    EXPECT_TRUE(tool.descent.under_way());
    tool.retract(3);
    EXPECT_FALSE(tool.descent.under_way());
}

TEST(Descent, NoiseOfTheFeedbackAtTheRetractHeightDoesNotKeepIt) {
    Tool tool;
    tool.feed(-3);
    tool.retract(3 - 2 * um);
    EXPECT_FALSE(tool.descent.under_way());
}

TEST(Descent, EndsAtTheHeightOfTheLastFeedDown) {
    Tool tool;
    tool.z = 20;
    tool.feed(-3);
    tool.retract(2);
    EXPECT_TRUE(tool.descent.under_way());
    tool.feed(-3);
    tool.retract(2);
    EXPECT_FALSE(tool.descent.under_way()) << "programs stay low between the holes of a row";
}

TEST(Descent, AFeedThatGoesOnAfterARestIsStillTheSame) {
    Tool tool;
    tool.feed(-1);
    tool.rest();
    tool.feed(-3);
    tool.retract(0);
    EXPECT_TRUE(tool.descent.under_way());
}

TEST(Descent, EndsInAnotherOperationAsTheToolMovesAway) {
    Tool tool;
    tool.feed(-3);
    tool.operation = 20;
    tool.rest();
    EXPECT_TRUE(tool.descent.under_way());
    tool.retract(-2);
    EXPECT_FALSE(tool.descent.under_way());
}

TEST(Descent, AnInvalidPositionKeepsTheLastOne) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Tool tool;
        tool.rest();
        tool.descent.step(bad, true, false, 10, 1);
        tool.feed(-3);
        tool.descent.step(bad, false, true, 10, 1);
        EXPECT_TRUE(tool.descent.under_way());
        tool.retract(3);
        EXPECT_FALSE(tool.descent.under_way());
    }
}

}  // namespace
}  // namespace plumb
