// SPDX-License-Identifier: GPL-2.0-or-later
// axis_offset with a guest, beside an axis at which the same guest has LinuxCNC's external offsets to itself.
#include "tests/support/bench.hpp"
#include "tests/support/place.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace plumb {
namespace {

constexpr double count = 0.1 * um;  // of the stage

client::Start with_specimens() {
    client::Start start;
    start.modules = {build_folder() + "/specimens"};
    return start;
}

// z-axis has the stage and its guest, alone-axis the guest alone.
struct Machine {
    Machine() {
        bench.command("loadrt threads name1=servo-thread period1=1000000");
        bench.command("loadrt axis_offset names=z-stage interlock=no");
        bench.command("loadrt external_offset names=z-axis,alone-axis");
        for (const char* pins :
             {"request z-axis.request z-stage.offset-request", "offset z-axis.offset z-stage.offset-in-force",
              "limited z-axis.limited z-stage.offset-limited",
              "enabled z-axis.enabled z-stage.motion-enabled", "counts z-stage.counts z-axis.counts",
              "scale z-stage.counts-scale z-axis.scale", "enable z-stage.offset-enable z-axis.enable",
              "clear z-stage.offset-clear z-axis.clear"})
            bench.command("net " + std::string(pins));
        for (const char* signal : {"on bit", "homed bit", "joint-mode bit", "guest-counts s32",
                                   "guest-scale float", "guest-enable bit", "guest-clear bit"})
            bench.command("newsig " + std::string(signal));
        bench.command("net homed z-stage.all-homed");
        for (const char* pin : {"on", "homed", "joint-mode"})
            bench.command("net " + std::string(pin) + " z-axis." + pin + " alone-axis." + pin);
        for (const char* pin : {"counts", "scale", "enable", "clear"})
            bench.command("net guest-" + std::string(pin) + " z-stage.guest-" + pin + " alone-axis." + pin);
        for (const char* function : {"z-axis.update", "alone-axis.update", "z-stage.update"})
            bench.command("addf " + std::string(function) + " servo-thread");
        bench.set("guest-scale", 0.001);
        bench.set("guest-enable", 1);
        bench.command("start");
        bench.run(0.01);
    }

    void set(const std::string& pin, double value) { bench.set("z-stage." + pin, value); }
    double get(const std::string& pin) { return bench.get("z-stage." + pin); }
    double in_force() { return bench.get("z-axis.offset"); }
    double alone() { return bench.get("alone-axis.offset"); }
    void guest(double counts) { bench.set("guest-counts", counts); }
    void turn(const std::string& signal, bool value) {
        bench.set(signal, value);
        bench.run(0.01);
    }
    void start() {
        turn("on", true);
        turn("homed", true);
    }
    void arm() {
        set("arm", 1);
        bench.run(0.01);
        set("arm", 0);
        bench.run(0.01);
    }
    // At rest both parts are what they are to be, and their sum is in force.
    void expect_at_rest(double own, double guest) {
        EXPECT_NEAR(get("applied-offset"), own, 1.01 * count);
        EXPECT_NEAR(get("guest-applied"), guest, 1e-9);
        EXPECT_NEAR(get("guest-request"), guest, 1e-9);
        EXPECT_NEAR(in_force(), own + guest, 0.51 * count + 1e-8);
        EXPECT_EQ(get("guest-active"), std::abs(guest) > count);
        EXPECT_NEAR(alone(), guest, 1e-6);  // its planner stops there or thereabouts
    }

    Bench bench{Bench::Thread::none, with_specimens()};
};

TEST(AxisOffsetGuest, MovesAsItDoesAloneAPeriodLaterAndWithoutACycleStart) {
    Machine machine;
    machine.start();
    machine.guest(2000);
    const auto trace = machine.bench.trace(0.2, {"z-axis.offset", "alone-axis.offset"});
    const std::vector<double> z = trace.column("z-axis.offset"), alone = trace.column("alone-axis.offset");
    EXPECT_NEAR(alone.back(), 2, 1e-6);
    for (std::size_t i = 1; i < z.size(); ++i) ASSERT_NEAR(z[i], alone[i - 1], 1e-9) << i;
    machine.expect_at_rest(0, 2);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_FALSE(machine.get("uncompensated"));
    EXPECT_FALSE(machine.get("limited"));
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffsetGuest, GuestInMotionDoesNotDisturbTheOwnPartWithinItsRate) {
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.bench.run(1);
    machine.bench.expect("abs(own_rate) <= 0.1 * (1 + 1e-6) || abs(own - 0.06) < 0.012",
                         {{"own", "z-stage.applied-offset"}});
    for (int n = 0; n < 400; ++n) {  // a slow wave of 3 mm
        machine.guest(std::round(3000 * std::sin(0.05 * n)));
        if (n == 100) machine.set("offset-1", 20 * um);
        machine.bench.run(0.01);
        ASSERT_NEAR(machine.get("guest-applied"), machine.alone(), 0.05) << n;  // a period of its speed
        ASSERT_NEAR(machine.get("applied-offset") + machine.get("guest-applied"), machine.in_force(), 1e-9);
        if (n < 100) {
            ASSERT_NEAR(machine.get("applied-offset"), 50 * um, 1.1 * count) << n;
        }
        if (n > 130) {
            ASSERT_NEAR(machine.get("applied-offset"), 70 * um, 1.1 * count) << n;
            ASSERT_FALSE(machine.get("uncompensated")) << n;
        }
    }
    machine.bench.run(0.5);
    machine.expect_at_rest(70 * um, std::round(3000 * std::sin(0.05 * 399)) * 0.001);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffsetGuest, ScaleOfAnyFractionAddsNoRoundingErrors) {
    Machine machine;
    machine.start();
    const double scale = 0.00037e-1;  // 0.37 counts of the stage
    machine.bench.set("guest-scale", scale);
    machine.set("offset-0", 5 * um);
    machine.arm();
    machine.bench.run(0.2);
    std::mt19937 random(1);
    int counts = 0;
    for (int n = 0; n < 3000; ++n) {
        counts += static_cast<int>(random() % 7) - 2;
        machine.guest(counts);
        machine.bench.run(0.001);
    }
    machine.bench.run(0.1);
    EXPECT_GT(counts, 1000);
    machine.expect_at_rest(5 * um, counts * scale);
}

TEST(AxisOffsetGuest, StepsOfAMachineThatIsOffOrUnhomedAreLostAndNothingElseIs) {
    Machine machine;
    machine.guest(700);
    machine.turn("on", true);
    machine.guest(900);
    machine.bench.run(0.01);
    machine.turn("homed", true);
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.bench.run(1);
    machine.expect_at_rest(50 * um, 0);
    machine.guest(1900);
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, 1);

    machine.turn("on", false);
    machine.guest(5000);
    machine.bench.run(0.1);
    machine.turn("on", true);
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 0);
    EXPECT_TRUE(machine.get("uncompensated"));
    machine.guest(5500);  // before the next cycle starts
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 0.5);
    machine.arm();
    machine.bench.run(1);
    machine.expect_at_rest(50 * um, 0.5);

    machine.turn("homed", false);
    machine.guest(6000);
    machine.bench.run(0.1);
    machine.turn("homed", true);
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, 0.5);
    EXPECT_EQ(machine.get("fault-code"), 6);
    machine.guest(6100);  // with that fault, as well
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, 0.6);
}

TEST(AxisOffsetGuest, EitherIsClearedWithoutTheOther) {
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.guest(-3000);
    machine.bench.run(1);
    machine.expect_at_rest(50 * um, -3);

    machine.turn("guest-clear", true);
    machine.guest(-2000);  // is lost
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, 0);
    machine.turn("guest-clear", false);
    machine.guest(-2500);
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, -0.5);

    machine.set("clear", 1);
    machine.bench.run(1);
    machine.expect_at_rest(0, -0.5);
    EXPECT_FALSE(machine.get("offset-clear"));
    machine.guest(-2700);  // moves beside a clear that is held
    machine.bench.run(0.5);
    machine.expect_at_rest(0, -0.7);
    machine.guest(-2000);
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 0);
    EXPECT_TRUE(machine.get("offset-clear"));
    machine.guest(-1000);  // also once LinuxCNC has been cleared
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 1);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffsetGuest, ClearedWhileUnhomedItReturnsOnceTheMachineIsHomed) {
    Machine machine;
    machine.start();
    machine.guest(1000);
    machine.bench.run(0.5);
    machine.turn("homed", false);
    machine.turn("guest-clear", true);
    machine.turn("guest-clear", false);
    machine.turn("homed", true);
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 0);
}

TEST(AxisOffsetGuest, DisabledItStopsWhereItIsAndLosesSteps) {
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.bench.run(1);
    machine.guest(10000);
    machine.bench.run(0.15);
    const double before = machine.alone();
    machine.turn("guest-enable", false);
    machine.guest(0);
    machine.bench.run(0.5);
    EXPECT_GT(before, 2);
    EXPECT_LT(before, 8);
    EXPECT_NEAR(machine.get("guest-applied"), machine.alone(), 0.1);  // two periods of its speed
    EXPECT_NEAR(machine.get("guest-request"), machine.get("guest-applied"), 1e-9);
    EXPECT_NEAR(machine.get("applied-offset"), 50 * um, 1.1 * count);
    const double held = machine.in_force();
    machine.turn("guest-enable", true);
    machine.bench.run(0.5);
    EXPECT_NEAR(machine.in_force(), held, count);
    machine.guest(1000);
    machine.bench.run(0.5);
    EXPECT_NEAR(machine.in_force(), held + 1, count);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffsetGuest, InJointModeItWaits) {
    Machine machine;
    machine.start();
    machine.turn("joint-mode", true);
    machine.guest(1000);
    machine.bench.run(1);
    EXPECT_EQ(machine.in_force(), 0);
    machine.turn("joint-mode", false);
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 1);
}

TEST(AxisOffsetGuest, ProbingIsRefusedForTheOwnPartOnlyAndTheGuestGoesOn) {
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.guest(1000);
    machine.bench.run(0.5);
    machine.set("motion-type", 5);
    machine.arm();
    EXPECT_FALSE(machine.get("probing-refused"));
    machine.guest(2000);
    machine.bench.run(0.5);
    machine.expect_at_rest(0, 2);
    machine.set("motion-type", 2);
    machine.bench.run(1);
    machine.expect_at_rest(50 * um, 2);
    machine.set("motion-type", 5);
    machine.bench.run(0.01);
    EXPECT_TRUE(machine.get("probing-refused"));
}

TEST(AxisOffsetGuest, SoftLimitTakesFromTheOwnPartWhileTheGuestIsAtRest) {
    Machine machine;
    machine.bench.set("z-axis.limit", 100);
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.guest(1000);
    machine.bench.run(1);
    machine.bench.set("z-axis.program", 98.98);
    machine.bench.run(0.1);
    EXPECT_NEAR(machine.get("applied-offset"), 20 * um, count);
    EXPECT_NEAR(machine.get("guest-applied"), 1, 1e-9);
    EXPECT_TRUE(machine.get("uncompensated"));
    EXPECT_TRUE(machine.get("limited"));
    machine.bench.set("z-axis.program", 90);
    machine.bench.run(0.5);
    machine.expect_at_rest(50 * um, 1);
    EXPECT_FALSE(machine.get("uncompensated"));
}

TEST(AxisOffsetGuest, HomedWithTheGuestsOffsetInForceIsAFault) {
    Machine machine;
    machine.start();
    machine.guest(1000);
    machine.bench.run(0.5);
    machine.turn("homed", false);
    machine.turn("homed", true);
    machine.arm();
    EXPECT_EQ(machine.get("fault-code"), 6);
    EXPECT_FALSE(machine.get("armed"));
}

TEST(AxisOffsetGuest, StepsWithABadScaleOrBeyondAThousandAreNamedAndComeAfterwards) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.guest(1000);
    machine.bench.run(1);
    machine.bench.command("unlinkp z-stage.guest-scale");
    machine.bench.command("unlinkp z-stage.guest-counts");
    for (const double scale : {nan, 1e308, -1e308, 0.0}) {
        machine.set("guest-scale", scale);
        machine.bench.run(0.01);
        EXPECT_EQ(machine.get("fault-code"), 0) << scale;
        machine.set("guest-counts", 1500);
        machine.bench.run(0.2);
        EXPECT_EQ(machine.get("fault-code"), 7) << scale;
        EXPECT_NEAR(machine.in_force(), 1.05, count) << scale;
        machine.set("guest-scale", 0.001);
        machine.bench.run(0.2);
        EXPECT_EQ(machine.get("fault-code"), 0) << scale;
        EXPECT_NEAR(machine.in_force(), 1.55, count) << scale;
        machine.set("guest-counts", 1000);
        machine.bench.run(0.2);
    }
    for (const double far : {2147483647.0, -2147483648.0, 1.1e6}) {
        machine.set("guest-counts", far);
        machine.bench.run(0.2);
        EXPECT_EQ(machine.get("fault-code"), 7) << far;
        machine.set("guest-counts", 1000);
        machine.bench.run(0.2);
        EXPECT_EQ(machine.get("fault-code"), 0) << far;
        EXPECT_NEAR(machine.in_force(), 1.05, count) << far;
    }
}

TEST(AxisOffsetGuest, CountsWrapAroundAt32Bits) {
    Machine machine;
    machine.start();
    machine.bench.set("guest-scale", 1e-7);
    machine.guest(std::numeric_limits<std::int32_t>::max());
    machine.bench.run(10);
    machine.expect_at_rest(0, 1e-7 * std::numeric_limits<std::int32_t>::max());
    machine.bench.command("unlinkp alone-axis.counts");
    machine.guest(std::numeric_limits<std::int32_t>::min() + 9999);
    machine.bench.run(1);
    EXPECT_NEAR(machine.in_force(), 1e-7 * std::numeric_limits<std::int32_t>::max() + 0.001, count);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffsetGuest, StepsThatLinuxCncDoesNotTakeAreAFaultAndDoNotWindUp) {
    Machine machine;
    machine.start();
    machine.guest(1000);
    machine.bench.run(0.5);
    machine.bench.command("unlinkp z-axis.enable");
    machine.bench.set("z-axis.enable", 0);
    const double before = machine.get("counts");
    for (int n = 0; n < 100; ++n) {
        machine.guest(1000 + n);
        machine.bench.run(0.01);
    }
    EXPECT_EQ(machine.get("fault-code"), 4);
    EXPECT_LT(machine.get("counts"), before + 100);
    machine.bench.command("net enable z-axis.enable");
    machine.bench.run(0.5);
    machine.set("offset-0", 50 * um);
    machine.arm();
    EXPECT_FALSE(machine.get("fault"));
    machine.bench.run(1);
    EXPECT_NEAR(machine.get("applied-offset"), 50 * um, count);
    EXPECT_NEAR(machine.in_force() - machine.get("guest-applied"), 50 * um, count);
}

TEST(AxisOffsetGuest, OffsetsThatSomebodyElseHasClearedLeaveBothPartsZero) {
    Machine machine;
    machine.start();
    machine.set("offset-0", 50 * um);
    machine.arm();
    machine.guest(1000);
    machine.bench.run(1);
    machine.bench.command("unlinkp z-axis.clear");
    machine.bench.set("z-axis.clear", 1);
    machine.bench.run(0.5);
    EXPECT_EQ(machine.get("fault-code"), 4);
    machine.bench.command("net clear z-axis.clear");
    machine.arm();
    machine.bench.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
    EXPECT_NEAR(machine.get("guest-applied"), 0, 1e-9);
}

// Whatever happens in whichever order, the guest ends where it would be alone, and the own part where it
// belongs.
TEST(AxisOffsetGuest, EndsWhereItWouldBeAlone) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Machine machine;
        machine.start();
        machine.set("offset-0", 50 * um);
        const auto draw = [&](int below) {
            return static_cast<int>(random() % static_cast<unsigned>(below));
        };
        for (int n = 0; n < 60; ++n) {
            switch (draw(8)) {
                case 0: machine.turn("on", draw(2)); break;
                case 1: machine.turn("guest-clear", draw(2)); break;
                case 2: machine.turn("joint-mode", draw(2)); break;
                case 3: machine.arm(); break;
                case 4: machine.set("offset-1", draw(80) * um); break;
                case 5: machine.set("clear", draw(2)); break;
                default: machine.guest(draw(4000) - 2000); break;
            }
            machine.bench.run(0.001 * (1 + draw(60)));
        }
        machine.turn("joint-mode", false);
        machine.turn("guest-clear", false);
        machine.turn("on", true);
        machine.set("clear", 0);
        machine.set("offset-1", 0);
        machine.arm();
        machine.bench.run(3);
        EXPECT_NEAR(machine.get("guest-applied"), machine.alone(), 1e-5);
        EXPECT_NEAR(machine.get("applied-offset"), 50 * um, 1.1 * count);
        EXPECT_NEAR(machine.in_force(), machine.alone() + 50 * um, 1.1 * count);
        EXPECT_FALSE(machine.get("fault"));
    }
}

}  // namespace
}  // namespace plumb
