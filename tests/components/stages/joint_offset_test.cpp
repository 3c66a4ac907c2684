// SPDX-License-Identifier: GPL-2.0-or-later
// joint_offset between a model of LinuxCNC's motion and a drive; portal_linuxcnc_test.py has it in LinuxCNC
// itself.
#include "tests/support/bench.hpp"
#include "tests/support/live.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

namespace plumb {
namespace {

constexpr double nm = 1e-6;
constexpr double period = 0.001;                 // s
constexpr double ramp_rate = 0.1, max_rate = 1;  // mm/s, the defaults
constexpr double slope = 0.0005;                 // of the correction that grows with the position
constexpr double joint_acceleration = 2000, offset_acceleration = 1000;  // mm/s2

// Motion, x-stage and a drive with a lag of 3 ms. Its sources: a constant, and one that grows with the
// position.
void wire(Bench& bench) {
    for (const char* line : {"loadrt threads name1=servo-thread period1=1000000",
                             "loadrt joint_offset names=x-stage interlock=no",
                             "loadrt motion_joint names=motion",
                             "loadrt lowpass names=drive",
                             "loadrt scale names=tilt",
                             "setp x-stage.min-limit -1000",
                             "setp x-stage.max-limit 1000",
                             "setp x-stage.joint-acceleration 2000",
                             "setp x-stage.offset-acceleration 1000",
                             "setp drive.gain 0.283469",
                             "setp tilt.gain 0",
                             "net homed      motion.homed           => x-stage.homed",
                             "net enabled    motion.enabled         => x-stage.motion-enabled",
                             "net position   motion.command         => x-stage.position tilt.in",
                             "net command    motion.motor-command   => x-stage.joint-command",
                             "net correction tilt.out               => x-stage.offset-1",
                             "net to-drive   x-stage.drive-command  => drive.in",
                             "net from-drive drive.out              => x-stage.drive-feedback",
                             "net feedback   x-stage.joint-feedback => motion.motor-feedback",
                             "addf x-stage.update-feedback servo-thread",
                             "addf motion.update servo-thread",
                             "addf tilt servo-thread",
                             "addf x-stage.update servo-thread",
                             "addf drive servo-thread"})
        bench.command(line);
}

// The joint moves to and fro between limits that never bound it, with an offset that swings. Motion goes on
// after any following error of a bad command.
void bring_to_life(Bench& bench) {
    wire(bench);
    for (const char* line : {"loadrt siggen names=path,swing",
                             "loadrt limit1 names=room",
                             "setp room.min 10",
                             "setp room.max 30",
                             "addf path.update servo-thread",
                             "addf room servo-thread",
                             "addf swing.update servo-thread",
                             "setp path.frequency 0.5",
                             "setp path.amplitude 5",
                             "setp path.offset 20",
                             "setp swing.frequency 0.3",
                             "setp swing.amplitude 0.05",
                             "setp motion.speed 100",
                             "setp motion.acceleration 2000",
                             "setp motion.max-error 1e9",
                             "setp x-stage.max-rate 20",
                             "setp x-stage.min-limit 10",
                             "setp x-stage.max-limit 30",
                             "net path path.square room.in",
                             "net program room.out motion.program",
                             "net swing swing.sine x-stage.offset-0",
                             "setp motion.on 1",
                             "setp motion.home 1",
                             "start"})
        bench.command(line);
    bench.set("x-stage.offset-2", 0.1);
    bench.set("tilt.gain", slope);
    bench.run(3);
}

// The sum of its sources, unless the origin was set while an offset was in force, or the joint stands at a
// limit.
std::vector<std::string> complaints_at_rest(Bench& bench) {
    bench.set("path.amplitude", 0);
    bench.set("swing.amplitude", 0);
    bench.set("motion.home", 0);
    bench.run(4);
    bench.set("motion.home", 1);
    bench.run(6);
    double sum = 0;
    for (const char* pin : {"offset-0", "offset-1", "offset-2", "offset-3"})
        sum += bench.get(std::string("x-stage.") + pin);
    const double applied = bench.get("x-stage.applied-offset");
    std::vector<std::string> complaints;
    if (bench.get("x-stage.fault") != 0)
        complaints.push_back("fault " + std::to_string(bench.get("x-stage.fault-code")));
    else if (bench.get("x-stage.limited") == 0 && !(std::abs(applied - sum) <= 1e-9))
        complaints.push_back("offset " + std::to_string(applied) + " instead of " + std::to_string(sum));
    return complaints;
}

// The joint stands far from its limits; the offset swings beyond max-offset, at up to 251 mm/s.
void swing_beyond(Bench& bench, long period_ns) {
    bench.command("loadrt threads name1=servo-thread period1=" + std::to_string(period_ns));
    for (const char* line :
         {"loadrt joint_offset names=x-stage interlock=no", "loadrt siggen names=swing", "setp x-stage.min-limit -1000",
          "setp x-stage.max-limit 1000", "setp x-stage.joint-acceleration 2000",
          "setp x-stage.offset-acceleration 20000", "setp x-stage.max-offset 50", "setp x-stage.max-rate 500",
          "setp x-stage.ramp-rate 500", "setp x-stage.homed 1", "setp x-stage.motion-enabled 1",
          "setp swing.amplitude 80", "setp swing.frequency 0.5", "net swing swing.sine x-stage.offset-0",
          "addf swing.update servo-thread", "addf x-stage.update-feedback servo-thread",
          "addf x-stage.update servo-thread", "start"})
        bench.command(line);
    bench.run(0.1);
}

const Live live{{{"joint_offset", "x-stage"}},
                bring_to_life,
                3.5,
                5,
                {{{"motion.on", {1, 0}},
                  {"motion.home", {1, 0}},
                  {"path.offset", {20, 25, 15, 28, 12}, true},
                  {"path.amplitude", {5, 0, 30, 1}, true},
                  {"swing.amplitude", {0.05, 0, 2, 10}, true},
                  {"tilt.gain", {slope, 0, -slope}}},
                 {"enable", "offset-0", "offset-2", "offset-3", "ramp-rate", "max-rate", "max-offset"},
                 complaints_at_rest},
                swing_beyond};

struct Machine {
    Machine() {
        wire(bench);
        bench.command("start");
    }

    void set(const std::string& pin, double value) { bench.set("x-stage." + pin, value); }
    double get(const std::string& pin) { return bench.get("x-stage." + pin); }
    double applied() { return get("applied-offset"); }

    // Lets time pass, and returns how far the drive has moved meanwhile, there and back.
    double run(double seconds) {
        const std::vector<double> x = bench.trace(seconds, {"drive.out"}).column("drive.out");
        double travel = 0;
        for (std::size_t i = 1; i < x.size(); ++i) travel += std::abs(x[i] - x[i - 1]);
        return travel;
    }
    double turn(bool on) {
        bench.set("motion.on", on);
        return run(0.05);
    }
    double home(bool homed = true) {
        bench.set("motion.home", homed);
        return run(0.05);
    }
    double go(double to) {
        bench.set("motion.program", to);
        return run(std::abs(to - bench.get("motion.command")) / bench.get("motion.speed") + 0.1);
    }
    // On, homed, and with this offset in force.
    void apply(double value) {
        turn(true);
        home();
        set("offset-0", value);
        run(1);
        EXPECT_NEAR(applied(), value, 1e-12);
    }
    // From now on, the offset changes by no more.
    void expect_rate(double most) {
        bench.expect("abs(x_rate) <= " + std::to_string(most + 1e-6), {{"x", "x-stage.applied-offset"}});
    }

    Bench bench{Bench::Thread::none, with_specimens()};
};

// The largest change of the speed, per second.
double largest_acceleration(const std::vector<double>& x) {
    double most = 0;
    for (std::size_t i = 2; i < x.size(); ++i)
        most = std::max(most, std::abs(x[i] - 2 * x[i - 1] + x[i - 2]) / (period * period));
    return most;
}

// The largest change from one period to the next.
double largest_step(const std::vector<double>& x) {
    double most = 0;
    for (std::size_t i = 1; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - x[i - 1]));
    return most;
}

TEST(JointOffset, UnhomedItPassesCommandAndFeedbackThrough) {
    Machine machine;
    machine.set("offset-0", 50 * um);
    machine.bench.set("tilt.gain", slope);
    machine.turn(true);
    machine.bench.set("motion.program", 7);
    const Table table = machine.bench.trace(1, {"motion.motor-command", "x-stage.drive-command"});
    EXPECT_EQ(table.column("motion.motor-command"), table.column("x-stage.drive-command"));
    EXPECT_EQ(machine.get("joint-feedback"), machine.get("drive-feedback"));
    EXPECT_EQ(machine.get("fault-code"), 0);
}

TEST(JointOffset, SumOfTheSourcesReachesTheDriveAndNotMotion) {
    Machine machine;
    machine.apply(50 * um);
    machine.set("offset-2", 30 * um);
    machine.set("offset-3", -100 * um);
    machine.run(1);
    EXPECT_NEAR(machine.bench.get("drive.out"), -20 * um, 1e-12);
    EXPECT_NEAR(machine.get("joint-feedback"), 0, 1e-12);
    EXPECT_NEAR(machine.bench.get("motion.error"), 0, 1e-12);
    EXPECT_FALSE(machine.get("limited"));
    EXPECT_FALSE(machine.get("ramping"));
    EXPECT_FALSE(machine.get("fault"));
}

TEST(JointOffset, WhatMotionCausesIsFollowedWithoutLag) {
    Machine machine;
    machine.bench.set("motion.speed", 200);
    machine.bench.set("tilt.gain", slope);
    machine.apply(0);
    machine.bench.set("motion.program", 100);
    const Table table = machine.bench.trace(0.6, {"motion.command", "x-stage.applied-offset"});
    const std::vector<double> x = table.column("motion.command"), c = table.column("x-stage.applied-offset");
    for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(c[i], slope * x[i], 1e-12) << i;
    EXPECT_NEAR(c.back(), 50 * um, 1e-12);
}

// A pid with a feed-forward of the velocity takes drive-velocity for command-deriv.
TEST(JointOffset, DriveVelocityIsTheVelocityOfTheDriveCommand) {
    Machine machine;
    machine.bench.set("motion.speed", 200);
    machine.bench.set("tilt.gain", slope);
    machine.apply(0);
    for (const double joint_velocity : {0.0, 7.0, std::numeric_limits<double>::quiet_NaN()}) {
        machine.set("joint-velocity", joint_velocity);
        machine.bench.set("motion.program", machine.bench.get("motion.command") > 50 ? 0 : 100);
        const Table table = machine.bench.trace(0.4, {"x-stage.applied-offset", "x-stage.drive-velocity"});
        const std::vector<double> c = table.column("x-stage.applied-offset"),
                                  v = table.column("x-stage.drive-velocity");
        const double own = std::isnan(joint_velocity) ? 0 : joint_velocity;
        for (std::size_t i = 1; i < c.size(); ++i)
            ASSERT_NEAR(v[i], own + (c[i] - c[i - 1]) / period, 1e-9) << i;
        EXPECT_GT(largest_step(c), 0.09 * slope);
    }
    machine.turn(false);
    EXPECT_EQ(machine.get("drive-velocity"), 0);
}

// The command that the feedback answers is the last one: corrected by the new offset it would be off by its
// change.
TEST(JointOffset, FeedbackOfADriveWithoutLagIsTheLastCommandExactly) {
    Machine machine;
    machine.bench.set("drive.gain", 1);
    machine.bench.set("motion.speed", 200);
    machine.bench.set("tilt.gain", slope);
    machine.apply(0);
    machine.bench.set("motion.program", 100);
    const Table table = machine.bench.trace(0.4, {"motion.motor-command", "x-stage.joint-feedback"});
    const std::vector<double> command = table.column("motion.motor-command"),
                              feedback = table.column("x-stage.joint-feedback");
    for (std::size_t i = 1; i < command.size(); ++i) ASSERT_NEAR(feedback[i], command[i - 1], 1e-12) << i;
}

TEST(JointOffset, FollowingErrorGrowsByTheSpeedOfTheOffsetTimesTheLag) {
    const auto largest_error = [](bool enabled) {
        Machine machine;
        machine.bench.set("motion.speed", 200);
        machine.bench.set("tilt.gain", slope);
        machine.set("enable", enabled);
        machine.apply(0);
        machine.bench.set("motion.program", 100);
        const std::vector<double> errors = machine.bench.trace(0.6, {"motion.error"}).column("motion.error");
        return *std::max_element(errors.begin(), errors.end());
    };
    const double lag = period / 0.283469;  // s: of a ramp, behind this filter
    EXPECT_NEAR(largest_error(true) - largest_error(false), slope * 200 * (lag - period), 1 * nm);
}

TEST(JointOffset, EnableRampsBothWays) {
    Machine machine;
    machine.apply(50 * um);
    machine.expect_rate(ramp_rate);
    machine.set("enable", 0);
    machine.run(0.25);
    EXPECT_NEAR(machine.applied(), 25 * um, 0.2 * um);
    EXPECT_TRUE(machine.get("ramping"));
    machine.run(0.26);
    EXPECT_EQ(machine.applied(), 0);
    EXPECT_FALSE(machine.get("ramping"));
    machine.set("enable", 1);
    machine.run(0.25);
    EXPECT_NEAR(machine.applied(), 25 * um, 0.2 * um);
    machine.set("enable", 0);  // turns amid the ramp
    machine.run(0.1);
    EXPECT_NEAR(machine.applied(), 15 * um, 0.2 * um);
    machine.set("enable", 1);
    machine.run(0.5);
    EXPECT_NEAR(machine.applied(), 50 * um, 1e-12);
}

TEST(JointOffset, RampAddsToWhatMotionCausesAndTakesNoLonger) {
    Machine machine;
    machine.set("enable", 0);
    machine.apply(0);
    machine.bench.set("tilt.gain", slope);
    machine.go(60);
    machine.expect_rate(ramp_rate + slope * 20);
    machine.bench.set("motion.program", 0);
    machine.set("enable", 1);
    machine.run(0.31);
    EXPECT_FALSE(machine.get("ramping"));
    EXPECT_NEAR(machine.applied(), slope * machine.bench.get("motion.command"), 1e-12);
}

TEST(JointOffset, OffAndOnMovesNothing) {
    Machine machine;
    machine.bench.set("tilt.gain", slope);
    machine.apply(50 * um);
    machine.go(40);
    for (int n = 0; n < 20; ++n) EXPECT_LT(machine.turn(false) + machine.run(0.3) + machine.turn(true), 1e-9);
    EXPECT_NEAR(machine.applied(), 70 * um, 1 * nm);
    EXPECT_NEAR(machine.bench.get("drive.out"), 40 + 70 * um, 1 * nm);
}

TEST(JointOffset, WhatChangesWhileTheMachineIsOffComesByTheRamp) {
    for (const bool by_enable : {false, true}) {
        Machine machine;
        machine.apply(50 * um);
        machine.expect_rate(ramp_rate);
        machine.turn(false);
        by_enable ? machine.set("enable", 0) : machine.set("offset-0", 0);
        EXPECT_LT(machine.run(2), 1e-9);
        EXPECT_EQ(machine.applied(), 50 * um);
        EXPECT_FALSE(machine.get("limited"));
        machine.bench.set("motion.on", 1);
        machine.run(0.25);
        EXPECT_NEAR(machine.applied(), 25 * um, 0.2 * um);
        EXPECT_TRUE(machine.get("ramping"));
        machine.run(0.3);
        EXPECT_EQ(machine.applied(), 0);
    }
}

// Also a way that max-rate goes in one period: motion has not caused it.
TEST(JointOffset, AShortWayThatCameWhileTheMachineIsOffComesByTheRamp) {
    constexpr double way = 0.8 * max_rate * period;
    Machine machine;
    machine.apply(50 * um);
    machine.expect_rate(ramp_rate);
    machine.turn(false);
    machine.set("offset-0", 50 * um + way);
    EXPECT_LT(machine.run(2), 1e-9);
    machine.bench.set("motion.on", 1);
    machine.run(0.1);
    EXPECT_NEAR(machine.applied(), 50 * um + way, 1e-12);
}

TEST(JointOffset, OffAtASoftLimitItIsHeldToo) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(50 * um);
    machine.go(39.98);
    const double tapered = machine.applied();
    EXPECT_GT(tapered, 0);
    EXPECT_LT(tapered, 20 * um);
    machine.turn(false);
    for (const double limit : {30.0, 50.0}) {
        machine.set("max-limit", limit);
        EXPECT_LT(machine.run(1), 1e-9);
        EXPECT_EQ(machine.applied(), tapered);
    }
    machine.turn(true);
    machine.run(1);
    EXPECT_NEAR(machine.bench.get("drive.out"), 39.98 + 50 * um, 1 * nm);
}

TEST(JointOffset, TurnedOffAmidAMoveOrARampNothingSteps) {
    Machine machine;
    machine.bench.set("tilt.gain", slope);
    machine.expect_rate(ramp_rate + slope * 20 + 1e-3);
    machine.apply(0);
    machine.set("offset-0", 0);
    for (int n = 0; n < 20; ++n) {
        machine.bench.set("motion.program", n % 2 ? 0 : 50);
        machine.set("enable", n % 3 != 0);
        machine.run(0.3 + 0.003 * n);
        machine.turn(false);
        machine.turn(true);
    }
    EXPECT_FALSE(machine.get("fault"));
}

TEST(JointOffset, UnhomedItsOffsetIsReleasedByTheRamp) {
    for (const bool on : {true, false}) {
        Machine machine;
        machine.apply(50 * um);
        machine.expect_rate(ramp_rate);
        machine.turn(on);
        machine.bench.set("motion.home", 0);
        machine.run(0.25);
        EXPECT_NEAR(machine.applied(), 25 * um, 0.2 * um);
        machine.run(0.3);
        EXPECT_EQ(machine.applied(), 0);
        machine.home();
        EXPECT_EQ(machine.get("fault-code"), 0);
    }
}

// The origin is set at the switch, and the joint homed when its final move is done: by then the offset is 0.
TEST(JointOffset, OriginThatWasSetWithAnOffsetInForceIsAFaultUntilHomedAgain) {
    for (const double final_move : {0.0, 0.8}) {
        Machine machine;
        machine.apply(50 * um);
        machine.go(2);
        machine.bench.set("motion.final-move", final_move);
        machine.bench.set("motion.home", 0);
        machine.run(0.1);
        EXPECT_GT(machine.applied(), 30 * um);
        machine.home();
        machine.run(0.9);
        EXPECT_TRUE(machine.bench.get("motion.homed"));
        EXPECT_EQ(machine.applied(), 0) << final_move;
        EXPECT_EQ(machine.get("fault-code"), 6) << final_move;
        machine.home(false);
        EXPECT_EQ(machine.get("fault-code"), 0);
        machine.home();
        machine.run(final_move + 0.6);
        EXPECT_EQ(machine.get("fault-code"), 0);
        EXPECT_NEAR(machine.applied(), 50 * um, 1e-12);
    }
}

TEST(JointOffset, OriginThatStaysAsTheOffsetIsReleasedIsNoFault) {
    Machine machine;
    machine.apply(50 * um);
    machine.go(10);
    machine.home(false);
    machine.bench.set("motion.program", 0);  // in search of the switch
    machine.run(1);
    EXPECT_EQ(machine.applied(), 0);
    machine.bench.set("motion.program", -20);
    machine.run(0.5);
    machine.home();
    machine.run(1);
    EXPECT_EQ(machine.get("fault-code"), 0);
    EXPECT_NEAR(machine.applied(), 50 * um, 1e-12);
}

TEST(JointOffset, WhatIsNotKnownOfTheOriginIsNoFault) {
    Machine machine;
    machine.apply(50 * um);
    machine.go(10);
    machine.bench.command("unlinkp x-stage.position");
    machine.set("position", 10);
    machine.home(false);
    machine.set("position", std::nan(""));
    machine.bench.set("motion.program", 11);
    machine.run(0.2);
    machine.set("position", 11);
    machine.run(0.01);
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.set("position", 0);
    machine.run(0.01);
    EXPECT_EQ(machine.get("fault-code"), 6);
}

TEST(JointOffset, HomingIsInhibitedUntilTheOffsetIsReleased) {
    Machine machine;
    machine.turn(true);
    machine.home();
    EXPECT_FALSE(machine.get("inhibit-homing"));
    machine.bench.expect("x == 0 || inhibits > 0",
                         {{"x", "x-stage.applied-offset"}, {"inhibits", "x-stage.inhibit-homing"}});
    machine.set("offset-0", -50 * um);
    machine.run(1);
    EXPECT_TRUE(machine.get("inhibit-homing"));
    machine.home(false);
    EXPECT_TRUE(machine.get("inhibit-homing"));
    machine.run(0.5);
    EXPECT_EQ(machine.applied(), 0);
    EXPECT_FALSE(machine.get("inhibit-homing"));
}

TEST(JointOffset, SumIsBoundedAndASourceThatStepsIsFollowedByMaxRate) {
    Machine machine;
    machine.expect_rate(max_rate);
    machine.apply(0);
    machine.set("offset-0", 0.5);
    machine.run(0.25);
    EXPECT_NEAR(machine.applied(), 0.25, 2 * um);
    EXPECT_TRUE(machine.get("limited"));
    machine.run(0.3);
    EXPECT_NEAR(machine.applied(), 0.5, 1e-12);
    EXPECT_FALSE(machine.get("limited"));
    machine.set("offset-3", 0.7);
    machine.run(1);
    EXPECT_NEAR(machine.applied(), 1, 1e-12);
    EXPECT_TRUE(machine.get("limited"));
    EXPECT_FALSE(machine.get("fault"));
}

TEST(JointOffset, ABoundBelowItsOffsetIsRefusedAndMovesNothing) {
    Machine machine;
    machine.apply(0.5);
    for (const double bound : {0.3, 0.0, 0.4999999}) {
        machine.set("max-offset", bound);
        EXPECT_LT(machine.run(0.5), 1e-9) << bound;
        EXPECT_EQ(machine.applied(), 0.5);
        EXPECT_EQ(machine.get("fault-code"), 8) << bound;
        EXPECT_FALSE(machine.get("limited"));
    }
    machine.set("max-offset", 0.5);
    EXPECT_LT(machine.run(0.1), 1e-9);
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.set("max-offset", 1);
    machine.run(0.1);
    machine.set("max-offset", 0.3);
    machine.set("offset-0", 0.8);  // the last good one stays in force
    machine.run(1);
    EXPECT_NEAR(machine.applied(), 0.8, 1e-12);
    EXPECT_EQ(machine.get("fault-code"), 8);
    machine.set("offset-0", 0.2);
    machine.run(1);
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.set("offset-0", -0.8);
    machine.run(1.5);
    EXPECT_NEAR(machine.applied(), -0.3, 1e-12);
    EXPECT_TRUE(machine.get("limited"));
    EXPECT_FALSE(machine.get("fault"));
}

TEST(JointOffset, ABoundThatIsRefusedHoldsBackNoOtherSetting) {
    Machine machine;
    machine.apply(0.5);
    machine.set("max-offset", 0.3);
    machine.set("max-rate", 0.2);
    machine.expect_rate(0.2);
    machine.set("offset-0", 0.7);
    machine.run(1.1);
    EXPECT_NEAR(machine.applied(), 0.7, 1e-12);
}

TEST(JointOffset, OffOrHeldByTheInterlockABoundBelowItsOffsetMovesNothing) {
    for (const bool off : {true, false}) {
        Machine machine;
        machine.apply(0.5);
        off ? machine.turn(false) : (machine.set("heartbeat", 7), machine.run(0.1));
        machine.set("max-offset", 0.3);
        EXPECT_LT(machine.run(0.5), 1e-9);
        EXPECT_EQ(machine.get("fault-code"), off ? 8 : 7);
        off ? machine.turn(true) : (machine.set("heartbeat", -1), machine.run(0.1));
        EXPECT_LT(machine.run(0.5), 1e-9);
        EXPECT_EQ(machine.get("fault-code"), 8);
    }
}

// A soft limit takes most of the offset away. A smaller bound would change what is left.
TEST(JointOffset, ABoundBelowAnOffsetThatASoftLimitReducesIsRefused) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(0.5);
    machine.go(39.5);
    const double applied = machine.applied();
    EXPECT_GT(applied, 0.1);
    EXPECT_LT(applied, 0.35);
    machine.set("max-offset", 0.4);
    EXPECT_LT(machine.run(0.5), 1e-9);
    EXPECT_EQ(machine.applied(), applied);
    EXPECT_EQ(machine.get("fault-code"), 8);
}

// x-stage and its sources in a thread of any period; the joint stands far from its limits.
struct Swinging {
    Swinging(double its_period, double acceleration, double bound, double rate) : period(its_period) {
        bench.command("loadrt threads name1=servo-thread period1=" +
                      std::to_string(std::lround(period * 1e9)));
        for (const char* line : {"loadrt joint_offset names=x-stage interlock=no",
                                 "loadrt siggen names=swing",
                                 "loadrt chopping names=chop interlock=no sections=4",
                                 "setp x-stage.min-limit -1000",
                                 "setp x-stage.max-limit 1000",
                                 "setp x-stage.joint-acceleration 2000",
                                 "setp x-stage.homed 1",
                                 "setp x-stage.motion-enabled 1",
                                 "setp swing.amplitude 0",
                                 "setp chop.homed 1",
                                 "setp chop.motion-enabled 1",
                                 "setp chop.min-limit -1000",
                                 "setp chop.max-limit 1000",
                                 "setp chop.max-rate 1000",
                                 "setp chop.max-feed 1000",
                                 "net swing swing.sine x-stage.offset-0",
                                 "net stroke chop.offset x-stage.offset-1",
                                 "addf swing.update servo-thread",
                                 "addf chop.update servo-thread",
                                 "addf x-stage.update-feedback servo-thread",
                                 "addf x-stage.update servo-thread",
                                 "start"})
            bench.command(line);
        set("offset-acceleration", acceleration);
        set("max-offset", bound);
        set("max-rate", rate);
        set("ramp-rate", rate);
        bench.run(10 * period);
    }

    void set(const std::string& pin, double value) { bench.set("x-stage." + pin, value); }
    double get(const std::string& pin) { return bench.get("x-stage." + pin); }
    void swing(double amplitude, double frequency) {
        bench.set("swing.frequency", frequency);
        bench.set("swing.amplitude", amplitude);
    }
    void stroke(double upper, double lower, double feed, double acceleration) {
        bench.set("chop.upper", upper);
        bench.set("chop.lower", lower);
        bench.set("chop.feed", feed);
        bench.set("chop.max-acceleration", acceleration);
        bench.set("chop.run", true);
    }
    Table trace(double seconds) {
        return bench.trace(seconds, {"x-stage.offset-0", "x-stage.offset-1", "x-stage.applied-offset"},
                           period);
    }
    // From now on in each period.
    void expect_acceleration(double most) {
        bench.command("loadrt ddt names=speed");
        bench.command("net applied x-stage.applied-offset speed.in");
        bench.command("addf speed servo-thread");
        bench.run(3 * period);
        bench.expect("abs(v_rate) <= " + std::to_string(most * (1 + 1e-6) + 1e-4), {{"v", "speed.out"}});
    }

    const double period;
    Bench bench{Bench::Thread::none, with_specimens()};
};

constexpr std::initializer_list<double> periods{0.00025, 0.001, 0.004};  // s

TEST(JointOffset, AtMaxOffsetItBrakesWithinItsAcceleration) {
    struct Case {
        double acceleration, bound, rate, amplitude, frequency;
    };
    for (const double its_period : periods)
        for (const Case& each :
             {Case{20000, 50, 500, 80, 0.5}, Case{20000, 79.9, 500, 80, 0.5}, Case{1000, 50, 500, 80, 0.5},
              Case{500, 0.7, 5, 1, 0.6}, Case{500, 1, 5, 1.5, 0.5}}) {
            SCOPED_TRACE(testing::Message() << each.amplitude << " within " << each.bound << ", "
                                            << each.acceleration << ", " << its_period << " s");
            Swinging it(its_period, each.acceleration, each.bound, each.rate);
            it.expect_acceleration(each.acceleration);
            it.bench.expect("abs(x) <= " + std::to_string(each.bound), {{"x", "x-stage.applied-offset"}});
            it.swing(each.amplitude, each.frequency);
            const std::vector<double> x = it.trace(4).column("x-stage.applied-offset");
            EXPECT_EQ(*std::max_element(x.begin(), x.end()), each.bound);
            EXPECT_EQ(*std::min_element(x.begin(), x.end()), -each.bound);
        }
}

// The sources of the stage may have all of its acceleration, far from the soft limits.
TEST(JointOffset, AStrokeOfAmplitudeMaxOffsetPassesBitForBit) {
    for (const double its_period : periods)
        for (const double hardest : {1000.0, 4950.0, 19800.0}) {
            SCOPED_TRACE(testing::Message() << hardest << ", " << its_period << " s");
            Swinging it(its_period, 20000, 40, 1000);
            it.stroke(40, 0, 600, hardest);
            const Table table = it.trace(4);
            const std::vector<double> wanted = table.column("x-stage.offset-1"),
                                      applied = table.column("x-stage.applied-offset");
            EXPECT_GT(*std::max_element(wanted.begin(), wanted.end()), 40 - 20000 * its_period * its_period);
            for (std::size_t i = 0; i < wanted.size(); ++i) ASSERT_EQ(applied[i], wanted[i]) << i;
            EXPECT_EQ(it.bench.get("chop.fault-code"), 0);
            EXPECT_FALSE(it.get("limited"));
        }
}

TEST(JointOffset, AStrokeBeyondMaxOffsetBrakesThereWithinItsAcceleration) {
    for (const double its_period : periods)
        for (const double bound : {15.0, 19.9}) {
            SCOPED_TRACE(testing::Message() << bound << ", " << its_period << " s");
            Swinging it(its_period, 20000, bound, 1000);
            it.expect_acceleration(20000);
            it.bench.expect("abs(x) <= " + std::to_string(bound), {{"x", "x-stage.applied-offset"}});
            it.stroke(-8, -20, 300, 5000);
            it.bench.run(3);
            EXPECT_EQ(it.bench.get("chop.fault-code"), 0);
            EXPECT_GE(it.bench.get("chop.stroke-count"), 10);
        }
}

// At any moment of a swing. A bound that is within reach waits until the offset can stop within it.
TEST(JointOffset, NoMaxOffsetThatIsTypedAmidASwingBreaksItsAcceleration) {
    for (const double its_period : periods) {
        SCOPED_TRACE(its_period);
        Swinging it(its_period, 2000, 80, 500);
        it.expect_acceleration(2000);
        it.swing(60, 0.5);
        it.bench.run(2);
        int refused = 0;
        for (int i = 0; i < 60; ++i) {
            it.set("max-offset", i % 3 == 2 ? 80 : 3 + 17 * i % 50);
            it.bench.run(10 * its_period);
            refused += it.get("fault-code") == 8;
            it.bench.run(0.137);
        }
        EXPECT_GT(refused, 5);
        it.set("max-offset", 10);
        it.bench.run(1);
        it.bench.expect("abs(x) <= 10", {{"x", "x-stage.applied-offset"}});
        it.bench.run(3);
        EXPECT_EQ(it.get("fault-code"), 0);
    }
}

TEST(JointOffset, AnOffsetAccelerationThatIsTypedAmidASwingBreaksNeitherItNorTheBound) {
    Swinging it(period, 20000, 50, 500);
    it.expect_acceleration(20000);
    it.bench.expect("abs(x) <= 50", {{"x", "x-stage.applied-offset"}});
    it.swing(80, 0.5);
    for (int i = 0; i < 60; ++i) {
        it.set("offset-acceleration", i % 2 ? 20000 : 300 + 40 * i);
        it.bench.run(0.137);
    }
}

TEST(JointOffset, DriveStopsAtASoftLimitAndNothingSteps) {
    for (const double sign : {1.0, -1.0}) {
        Machine machine;
        machine.apply(sign * 50 * um);
        machine.set("min-limit", -40);
        machine.set("max-limit", 40);
        machine.bench.expect("abs(x) <= 40.0000000001", {{"x", "x-stage.drive-command"}});
        machine.bench.set("motion.program", sign * 40);
        std::vector<double> commands =
            machine.bench.trace(2.1, {"x-stage.drive-command"}).column("x-stage.drive-command");
        EXPECT_EQ(machine.bench.get("motion.command"), sign * 40);
        EXPECT_NEAR(commands.back(), sign * 40, 1e-12);
        EXPECT_LE(largest_step(commands), 20 * period * 1.000001);
        EXPECT_TRUE(machine.get("limited"));
        machine.bench.set("motion.program", sign * 39);
        commands = machine.bench.trace(0.2, {"x-stage.drive-command"}).column("x-stage.drive-command");
        EXPECT_LE(largest_step(commands), 20 * period * 1.000001);
        EXPECT_NEAR(commands.back(), sign * (39 + 50 * um), 1e-12);
        EXPECT_FALSE(machine.get("limited"));
    }
}

// To a limit and back again, with the speed and acceleration of a fast joint, jogged there by several
// targets.
TEST(JointOffset, BeforeASoftLimitItBrakesWithinItsAcceleration) {
    for (const double offset : {0.01, 0.1, 1.0})
        for (const double speed : {5.0, 50.0, 500.0}) {
            const double sign = speed < 10 ? -1 : 1;
            SCOPED_TRACE(testing::Message() << sign * offset << " at " << speed);
            Machine machine;
            machine.set("max-offset", 2);
            machine.bench.set("motion.speed", speed);
            machine.bench.set("motion.acceleration", joint_acceleration);
            machine.set("min-limit", -40);
            machine.set("max-limit", 40);
            machine.apply(0);
            machine.set("offset-0", sign * offset);
            machine.run(1 + offset);
            for (const double place : {39.0, 40.0, 39.5, 40.0, 30.0, 40.0, 39.99, 40.0, 35.0}) {
                const double way = std::abs(sign * place - machine.bench.get("motion.command"));
                machine.bench.set("motion.program", sign * place);
                const Table table = machine.bench.trace(
                    way / speed + 0.3, {"motion.command", "x-stage.drive-command", "x-stage.applied-offset"});
                const std::vector<double> motion = table.column("motion.command"),
                                          drive = table.column("x-stage.drive-command"),
                                          applied = table.column("x-stage.applied-offset");
                for (std::size_t i = 0; i < drive.size(); ++i) {
                    ASSERT_LE(std::abs(motion[i]), 40) << i << " to " << place;
                    ASSERT_LE(std::abs(drive[i]), 40 + 1e-12) << i << " to " << place;
                }
                EXPECT_LE(largest_acceleration(applied), offset_acceleration * 1.001) << place;
                EXPECT_LE(largest_acceleration(drive), (joint_acceleration + offset_acceleration) * 1.001)
                    << place;
                EXPECT_FALSE(machine.get("ramping"));
            }
        }
}

// The sum of the sources passes 0 while the joint stands at a limit, or near it: beyond 0 nothing is allowed.
TEST(JointOffset, AtASoftLimitAnOffsetThatTurnsRoundBrakesWithinItsAcceleration) {
    for (const double rate : {0.5, 1.0, 10.0})
        for (const double distance : {0.0, 0.001, 0.05}) {
            SCOPED_TRACE(testing::Message() << distance << " before the limit, at " << rate);
            Machine machine;
            machine.set("max-offset", 2);
            machine.set("max-rate", rate);
            machine.set("min-limit", -40);
            machine.set("max-limit", 40);
            machine.apply(0.3);
            machine.go(-40 + distance);
            machine.set("offset-0", -0.3);
            const Table table = machine.bench.trace(3, {"x-stage.applied-offset", "x-stage.drive-command"});
            EXPECT_LE(largest_acceleration(table.column("x-stage.applied-offset")),
                      offset_acceleration * 1.001);
            for (const double place : table.column("x-stage.drive-command")) ASSERT_GE(place, -40 - 1e-12);
            EXPECT_LE(machine.applied(), 0);
        }
}

// Far from the limits a source has all of the acceleration. Beside the taper it has a quarter.
TEST(JointOffset, ASourceThatSwingsBesideASoftLimitLeavesTheTaperItsAcceleration) {
    for (const double amplitude : {0.1, 1.0})
        for (const double part : {0.2, 0.6, 0.95}) {
            SCOPED_TRACE(testing::Message() << amplitude << " at " << part << " of the acceleration");
            Machine machine;
            machine.set("max-offset", 1.2 * amplitude);
            machine.set("max-rate", 100);
            machine.set("min-limit", -40);
            machine.set("max-limit", 40);
            machine.bench.set("motion.speed", 300);
            machine.bench.set("motion.acceleration", joint_acceleration);
            machine.bench.command("loadrt siggen names=swing");
            machine.bench.command("addf swing.update servo-thread 1");
            machine.bench.command("net swing swing.sine x-stage.offset-0");
            machine.bench.set("swing.amplitude", 0);
            machine.turn(true);
            machine.home();
            machine.bench.set("swing.frequency",
                              std::sqrt(part * offset_acceleration / amplitude) / (2 * 3.14159265));
            machine.bench.set("swing.amplitude", amplitude);
            machine.bench.expect("abs(x) <= 40.0000000001", {{"x", "x-stage.drive-command"}});
            for (const double place : {39.0, 40.0, 39.5, -40.0, 30.0, 40.0, 39.99, 40.0, -35.0, 0.0}) {
                const double way = std::abs(place - machine.bench.get("motion.command"));
                machine.bench.set("motion.program", place);
                const std::vector<double> applied =
                    machine.bench.trace(way / 300 + 0.4, {"x-stage.applied-offset"})
                        .column("x-stage.applied-offset");
                EXPECT_LE(largest_acceleration(applied), offset_acceleration * 1.001) << place;
            }
        }
}

// Settling waits for ramps: one that a soft limit holds must not keep the joint there.
TEST(JointOffset, ARampThatASoftLimitHoldsHasEnded) {
    Machine machine;
    machine.set("min-limit", -40);
    machine.set("max-limit", 40);
    machine.apply(0);
    machine.go(-40);
    machine.set("enable", false);
    machine.run(0.1);
    machine.set("offset-0", -0.1);
    machine.set("enable", true);
    machine.run(3);
    EXPECT_FALSE(machine.get("ramping"));
    EXPECT_TRUE(machine.get("limited"));
    EXPECT_NEAR(machine.applied(), 0, 1e-9);
}

// A wrong position takes the offset away at once while motion moves the joint; that is no speed to go on
// with.
TEST(JointOffset, APositionThatJumpsBeyondALimitTakesTheOffsetNoFurtherThanTo0) {
    Machine machine;
    machine.set("max-offset", 1);
    machine.set("min-limit", -40);
    machine.set("max-limit", 40);
    machine.apply(0.08);
    machine.bench.set("motion.speed", 200);
    machine.bench.set("motion.program", 30);
    machine.bench.run(0.1);
    machine.bench.command("unlinkp x-stage.position");
    machine.set("position", 7.5);
    machine.bench.run(0.01);
    machine.set("position", 150);
    for (const double applied :
         machine.bench.trace(0.5, {"x-stage.applied-offset"}).column("x-stage.applied-offset"))
        ASSERT_GE(applied, 0);
}

TEST(JointOffset, OffsetIsWholeAsSoonAsTheTaperEnds) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(50 * um);
    const double share = 0.75 * offset_acceleration / joint_acceleration;
    machine.go(40 - 3 * 50 * um / share - 1 * um);
    EXPECT_NEAR(machine.applied(), 50 * um, 1e-12);
    EXPECT_FALSE(machine.get("limited"));
    machine.go(40 - 3 * 50 * um / share + 10 * um);
    EXPECT_LT(machine.applied(), 50 * um);
    EXPECT_TRUE(machine.get("limited"));
}

TEST(JointOffset, ALimitThatIsNotSetIsAFaultAndNoOffsetIsApplied) {
    for (const char* pin : {"min-limit", "max-limit", "joint-acceleration", "offset-acceleration"}) {
        SCOPED_TRACE(pin);
        Machine machine;
        machine.bench.command("unloadrt joint_offset");
        machine.bench.command("loadrt joint_offset names=x-stage interlock=no");
        for (const char* line :
             {"net homed x-stage.homed", "net enabled x-stage.motion-enabled",
              "net position x-stage.position", "net command x-stage.joint-command",
              "net to-drive x-stage.drive-command", "net from-drive x-stage.drive-feedback",
              "net feedback x-stage.joint-feedback", "addf x-stage.update-feedback servo-thread 1",
              "addf x-stage.update servo-thread -2"})
            machine.bench.command(line);
        for (const auto& [name, value] : std::map<std::string, double>{{"min-limit", -1000},
                                                                       {"max-limit", 1000},
                                                                       {"joint-acceleration", 2000},
                                                                       {"offset-acceleration", 1000}})
            if (name != pin) machine.set(name, value);
        if (pin == std::string("min-limit")) machine.set("max-limit", 0);
        if (pin == std::string("max-limit")) machine.set("min-limit", 0);
        machine.turn(true);
        machine.home();
        machine.set("offset-0", 0.1);
        machine.run(1);
        EXPECT_EQ(machine.applied(), 0);
        EXPECT_EQ(machine.get("fault-code"), 5);
        machine.set("min-limit", -1000);
        machine.set("max-limit", 1000);
        machine.set("joint-acceleration", 2000);
        machine.set("offset-acceleration", 1000);
        machine.expect_rate(ramp_rate);
        machine.run(1.2);
        EXPECT_EQ(machine.get("fault-code"), 0);
        EXPECT_NEAR(machine.applied(), 0.1, 1e-12);
    }
}

// A source that another component gates by machine-on, which it sees a period late, is 0 as the ramp begins.
TEST(JointOffset, ASourceThatComesBackAfterTheRampBeganAddsNothing) {
    Machine machine;
    machine.bench.command("loadrt mux2 names=gate");
    machine.bench.command("addf gate servo-thread");
    machine.bench.set("gate.in1", 0.5);
    machine.bench.command("net enabled gate.sel");
    machine.bench.command("net gated gate.out x-stage.offset-0");
    machine.set("max-offset", 0.6);
    machine.turn(true);
    machine.home();
    machine.run(1);
    machine.bench.expect("abs(x) <= 0.5000000001", {{"x", "x-stage.applied-offset"}});
    for (int n = 0; n < 8; ++n) {
        machine.turn(false);
        machine.run(1);
        machine.turn(true);
        machine.run(0.2 * n);
    }
    machine.run(6);
    EXPECT_NEAR(machine.applied(), 0.5, 1e-12);
}

TEST(JointOffset, NoSequenceOfTogglesLeavesTheBound) {
    Machine machine;
    machine.bench.expect("abs(x) <= 1", {{"x", "x-stage.applied-offset"}});
    machine.apply(-0.9);
    for (int n = 0; n < 12; ++n) {
        machine.set("offset-0", -1);
        machine.set("enable", 0);
        machine.run(0.001 + 0.01 * n);
        machine.set("offset-0", 1);
        machine.set("enable", 1);
        machine.run(0.3);
    }
    machine.run(22);
    EXPECT_NEAR(machine.applied(), 1, 1e-12);
}

TEST(JointOffset, AtASoftLimitAnOffsetThatLeadsAwayFromItIsApplied) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(-50 * um);
    machine.go(40);
    EXPECT_NEAR(machine.bench.get("drive.out"), 40 - 50 * um, 1 * nm);
    EXPECT_FALSE(machine.get("limited"));
}

TEST(JointOffset, BeyondALimitTheDriveIsNotTakenBack) {
    for (const double sign : {1.0, -1.0}) {
        Machine machine;
        machine.apply(sign * 50 * um);
        machine.go(sign * 30);
        machine.set("min-limit", -20);
        machine.set("max-limit", 20);
        machine.run(0.5);
        EXPECT_NEAR(machine.bench.get("drive.out"), sign * 30, 1e-9);
        EXPECT_TRUE(machine.get("limited"));
    }
}

TEST(JointOffset, LimitsThatChangeMoveTheDriveByMaxRateAndNeverFurtherThanTheOffset) {
    Machine machine;
    machine.apply(0.5);
    machine.go(30);
    machine.expect_rate(max_rate);
    machine.set("max-limit", 20);  // motion stands beyond
    machine.run(0.25);
    EXPECT_NEAR(machine.applied(), 0.25, 2 * um);
    machine.run(0.5);
    EXPECT_EQ(machine.applied(), 0);
    machine.set("max-limit", 40);
    machine.run(1);
    EXPECT_NEAR(machine.applied(), 0.5, 1e-12);
}

TEST(JointOffset, LimitsThatChangeAmidAMoveMoveTheDriveByMaxRate) {
    for (const double sign : {1.0, -1.0}) {
        Machine machine;
        machine.bench.set("motion.speed", 200);
        machine.apply(sign * 0.5);
        machine.bench.set("motion.program", sign * 100);
        machine.run(0.2);
        machine.expect_rate(max_rate);
        const char* const limit = sign > 0 ? "max-limit" : "min-limit";
        machine.set(limit, sign * 20);
        machine.run(0.1);
        EXPECT_NEAR(sign * machine.applied(), 0.4, 2 * um);
        machine.set(limit, sign * 1000);
        machine.run(0.2);
        EXPECT_NEAR(sign * machine.applied(), 0.5, 1e-9);
    }
}

TEST(JointOffset, AnOffsetThatALimitAllowsAgainComesAtMaxRateHoweverMotionTakesItAway) {
    Machine machine;
    machine.apply(0.5);
    machine.set("max-limit", 20);
    machine.run(1);
    machine.go(39);
    EXPECT_EQ(machine.applied(), 0);
    machine.bench.set("motion.program", 40);
    machine.run(0.03);
    machine.set("max-limit", 40);
    machine.bench.expect("x_rate <= " + std::to_string(max_rate + 1e-6), {{"x", "x-stage.applied-offset"}});
    machine.bench.expect("x <= 40.000000001", {{"x", "x-stage.drive-command"}});
    machine.run(0.5);
    EXPECT_NEAR(machine.get("drive-command"), 40, 1e-9);
}

TEST(JointOffset, PositionThatJumpsAtALimitMovesTheDriveByMaxRateAndNoFasterThanTheJoint) {
    Machine machine;
    machine.apply(0.5);
    machine.bench.command("unlinkp x-stage.position");
    machine.set("max-limit", 40);
    machine.expect_rate(max_rate + 20);
    for (const double program : {30.0, -30.0}) {
        machine.bench.set("motion.program", program);
        for (const double place : {0.0, 39.9, 0.0, 39.7}) {
            machine.set("position", place);
            machine.run(0.1);
        }
    }
    EXPECT_EQ(machine.get("fault-code"), 0);  // homed, so it is not the origin that moves
}

TEST(JointOffset, PositionThatIsKnownAgainAtALimitMovesTheDriveByMaxRate) {
    Machine machine;
    machine.apply(0.5);
    machine.bench.command("unlinkp x-stage.position");
    machine.set("max-limit", 40);
    machine.expect_rate(max_rate);
    machine.bench.set("motion.program", 30);
    for (const double place : {0.0, std::nan(""), 39.9, std::nan(""), 0.0}) {
        machine.set("position", place);
        machine.run(0.1);
    }
    EXPECT_GT(machine.bench.get("motion.command"), 5);
}

// Released, it must not first be applied in full.
TEST(JointOffset, UnhomedAtASoftLimitItDoesNotLeadBeyond) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(50 * um);
    machine.go(40);
    EXPECT_LT(machine.applied(), 1e-9);
    EXPECT_LT(machine.home(false) + machine.run(1), 1e-9);
}

TEST(JointOffset, BadInputsAreNamedAndMoveNothing) {
    const double huge = 1e308, infinite = std::numeric_limits<double>::infinity();
    const double not_a_number = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::pair<std::string, int>> inputs{
        {"offset-0", 1},           {"offset-1", 1},       {"offset-3", 1},   {"joint-command", 2},
        {"position", 2},           {"drive-feedback", 3}, {"max-offset", 4}, {"ramp-rate", 4},
        {"max-rate", 4},           {"min-limit", 5},      {"max-limit", 5},  {"joint-acceleration", 5},
        {"offset-acceleration", 5}};
    Machine machine;
    machine.apply(50 * um);
    machine.go(10);
    for (const char* pin : {"offset-1", "joint-command", "position", "drive-feedback"})
        machine.bench.command(std::string("unlinkp x-stage.") + pin);
    for (const auto& [input, code] : inputs)
        for (const double bad : {not_a_number, huge, -huge, infinite, -infinite}) {
            const double good = machine.get(input);
            machine.set(input, bad);
            EXPECT_LT(machine.run(0.05), 1e-9) << input << " " << bad;
            EXPECT_EQ(machine.get("fault-code"), code) << input << " " << bad;
            EXPECT_TRUE(machine.get("fault"));
            EXPECT_TRUE(std::isfinite(machine.get("joint-feedback"))) << input << " " << bad;
            machine.set(input, good);
            EXPECT_LT(machine.run(0.05), 1e-9) << input << " " << bad;
            EXPECT_EQ(machine.get("fault-code"), 0) << input << " " << bad;
        }
    for (const double rate : {0.0, -1.0, 2e4}) {
        machine.set("max-rate", rate);
        EXPECT_LT(machine.run(0.01), 1e-9);
        EXPECT_EQ(machine.get("fault-code"), 4);
    }
}

TEST(JointOffset, LimitsThatContradictEachOtherLeaveTheLastOnes) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(50 * um);
    machine.go(40);
    for (const auto& [low, high] : std::vector<std::pair<double, double>>{
             {50, 45}, {100, 100}, {std::nan(""), 100}, {0, std::nan("")}}) {
        machine.set("min-limit", low);
        machine.set("max-limit", high);
        EXPECT_LT(machine.run(0.5), 1e-9) << low << " " << high;
        EXPECT_EQ(machine.get("fault-code"), 5);
    }
    EXPECT_NEAR(machine.get("drive-command"), 40, 1e-12);
}

TEST(JointOffset, FeedbackThatIsLostStopsMotion) {
    Machine machine;
    machine.apply(50 * um);
    machine.bench.command("unlinkp x-stage.drive-feedback");
    machine.set("drive-feedback", std::nan(""));
    EXPECT_LT(machine.run(1), 1e-9);
    machine.go(10);
    EXPECT_EQ(machine.get("fault-code"), 3);
    EXPECT_FALSE(machine.bench.get("motion.enabled"));
    EXPECT_LT(machine.bench.get("drive.out"), 2);
}

TEST(JointOffset, HeartbeatThatStandsStillHoldsTheOffset) {
    for (const std::string change : {"source", "enable", "unhomed", "off and on"}) {
        SCOPED_TRACE(change);
        Machine machine;
        machine.apply(50 * um);
        machine.expect_rate(ramp_rate);
        machine.set("heartbeat", 7);
        machine.run(0.01);
        if (change == "source") machine.set("offset-0", -80 * um);
        if (change == "enable") machine.set("enable", 0);
        if (change == "unhomed") machine.home(false);
        if (change == "off and on") machine.turn(false), machine.turn(true);
        EXPECT_LT(machine.run(5), 1e-9);
        EXPECT_EQ(machine.applied(), 50 * um);
        EXPECT_EQ(machine.get("fault-code"), 7);
        EXPECT_TRUE(machine.get("inhibit-homing"));
        EXPECT_FALSE(machine.get("limited"));

        machine.set("heartbeat", -1);  // which ends the hold, and the rest comes by the ramp
        machine.run(3);
        const double wanted = change == "source" ? -80 * um : change == "off and on" ? 50 * um : 0;
        EXPECT_NEAR(machine.applied(), wanted, 1e-12);
        EXPECT_EQ(machine.get("fault-code"), 0);
    }
}

TEST(JointOffset, HeartbeatThatStandsStillLetsNoOffsetBegin) {
    Machine machine;
    machine.set("heartbeat", 0);  // of an interlock that was never called
    machine.turn(true);
    machine.home();
    machine.set("offset-0", 50 * um);
    EXPECT_EQ(machine.run(5), 0);
    EXPECT_EQ(machine.applied(), 0);
    EXPECT_EQ(machine.get("fault-code"), 7);
    EXPECT_FALSE(machine.get("inhibit-homing"));
}

TEST(JointOffset, HeartbeatThatStopsInARampStopsItWithItsAcceleration) {
    Machine machine;
    const double softly = 250;  // mm/s2
    machine.set("offset-acceleration", softly);
    machine.apply(0);
    machine.set("ramp-rate", 1);
    machine.set("offset-0", 500 * um);
    machine.set("enable", 0);
    machine.run(0.01);
    machine.set("enable", 1);
    machine.run(0.2);
    const double before = machine.applied();
    machine.set("heartbeat", 7);
    const std::vector<double> x =
        machine.bench.trace(1, {"x-stage.applied-offset"}).column("x-stage.applied-offset");
    EXPECT_LE(largest_acceleration(x), softly * (1 + 1e-6));
    EXPECT_GT(x.back(), before);
    EXPECT_LT(x.back(), before + 15 * um);  // ten periods at 1 mm/s, and the braking
    EXPECT_EQ(x[50], x.back());
    EXPECT_FALSE(machine.get("ramping"));
}

TEST(JointOffset, HeldByTheInterlockItStillKeepsWithinTheSoftLimit) {
    Machine machine;
    machine.set("max-limit", 40);
    machine.apply(50 * um);
    machine.set("heartbeat", 7);
    machine.bench.expect("x <= 40 + 1e-9", {{"x", "x-stage.drive-command"}});
    machine.go(40);
    EXPECT_NEAR(machine.get("drive-command"), 40, 1e-9);
    machine.go(20);
    EXPECT_NEAR(machine.applied(), 50 * um, 1e-12);
}

}  // namespace
}  // namespace plumb
