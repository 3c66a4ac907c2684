// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

struct Machine {
    ProgramOrigin origin{};
    ProgramOrigin::Now now{-250, 62, 2, OriginReason::none, 0, 0};

    void wait(double seconds) {
        for (double t = 0; t < seconds; t += dt) origin.step(now, dt);
    }
    void step() { origin.step(now, dt); }
};

TEST(ProgramOrigin, TheFirstOneIsNoChange) {
    Machine machine;
    machine.step();
    EXPECT_FALSE(machine.origin.offset_changed());
    EXPECT_FALSE(machine.origin.length_changed());
    machine.now.work_offset = -249;
    machine.step();
    EXPECT_TRUE(machine.origin.offset_changed());
    EXPECT_EQ(machine.origin.offset_before(), -250);
    machine.step();
    EXPECT_FALSE(machine.origin.offset_changed());
}

TEST(ProgramOrigin, AnotherToolIsNoChangeOfALengthNorIsAToolWithoutOne) {
    Machine machine;
    machine.step();
    machine.now.tool = 3;
    machine.now.tool_length = 80;
    machine.step();
    EXPECT_FALSE(machine.origin.length_changed());
    machine.now.tool_length = 0;
    machine.step();
    EXPECT_FALSE(machine.origin.length_changed());
    machine.now.tool_length = 80.1;
    machine.step();
    EXPECT_TRUE(machine.origin.length_changed());
}

TEST(ProgramOrigin, AReasonHoldsForAWhileBecauseTheChangeMayComeLate) {
    Machine machine;
    machine.now.reason = OriginReason::zero;
    machine.step();
    EXPECT_TRUE(machine.origin.reason_given());
    machine.step();
    EXPECT_FALSE(machine.origin.reason_given());
    machine.now.reason = OriginReason::none;
    machine.wait(0.9 * ProgramOrigin::patience);
    EXPECT_EQ(machine.origin.reason(), OriginReason::zero);
    machine.wait(0.2 * ProgramOrigin::patience);
    EXPECT_EQ(machine.origin.reason(), OriginReason::none);
}

TEST(ProgramOrigin, RemembersTheOffsetBeforeChangesWithoutAReason) {
    Machine machine;
    machine.step();
    for (const double offset : {-249.0, -248.0}) {
        machine.now.work_offset = offset;
        machine.step();
        EXPECT_EQ(machine.origin.offset_root(), -250);
    }
    machine.now.reason = OriginReason::zero;
    machine.now.work_offset = -247;
    machine.step();
    EXPECT_EQ(machine.origin.offset_root(), -250);
    machine.now.work_offset = -246;
    machine.step();
    EXPECT_EQ(machine.origin.offset_root(), -247) << "the zero replaces them";
    machine.now.reason = OriginReason::none;
    machine.wait(2 * ProgramOrigin::patience);
    for (const double offset : {-245.0, -246.0}) machine.now.work_offset = offset, machine.step();
    machine.now.work_offset = -240;
    machine.step();
    EXPECT_EQ(machine.origin.offset_root(), -246) << "it was taken back";
}

TEST(ProgramOrigin, AChangeTakesInTheGrowthThatIsNotCompensated) {
    Machine machine;
    machine.step();
    machine.now.growth = 0.02;
    machine.now.applied_offset = 0.015;
    machine.now.work_offset = -249;
    machine.step();
    EXPECT_NEAR(machine.origin.in_offset(-249), 0.005, 1e-12);
    machine.now.applied_offset = 0.02;
    machine.now.tool_length = 63;
    machine.step();
    EXPECT_NEAR(machine.origin.in_offset(-249), 0.005, 1e-12);
    EXPECT_NEAR(machine.origin.in_length(2, 63), 0, 1e-12);
}

TEST(ProgramOrigin, EachZeroAndEachToolKeepsTheGrowthAtWhichItWasSet) {
    Machine machine;
    machine.step();
    machine.now.growth = 0.02;
    machine.now.tool_length = 62.3;
    machine.step();
    machine.now.growth = 0.005;
    machine.now.tool = 3;  // measured in a rack, and then taken into the spindle
    machine.now.tool_length = 80;
    machine.step();
    machine.now.work_offset = -200;  // G55, set now
    machine.step();
    machine.now.growth = 0.03;
    machine.now.work_offset = -250;  // G54, which was there before all
    machine.step();
    machine.now.work_offset = -200;
    machine.now.tool = 2;
    machine.now.tool_length = 62.3;
    machine.step();
    EXPECT_NEAR(machine.origin.in_length(2, 62.3), 0.02, 1e-12);
    EXPECT_NEAR(machine.origin.in_length(3, 80), 0.005, 1e-12);
    EXPECT_NEAR(machine.origin.in_offset(-200), 0.005, 1e-12) << "it came back, and was not set anew";
    EXPECT_NEAR(machine.origin.in_length(3, 62.3), 0, 1e-12) << "of another tool";
}

}  // namespace
}  // namespace plumb
