// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_supervision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <vector>

namespace plumb {
namespace {

constexpr double dt = 0.001, um = 1e-3;  // s, mu
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Strokes of 30 mm above point R, and an axis that follows its command, by default 5 ms late.
struct Supervision : testing::Test {
    StrokeSupervision it;
    StrokeInForce in_force;
    StrokeMotion motion;
    StrokeSettings values;
    StrokeMotion::Orders orders;
    std::function<double(double, double)> axis = [](double command, double at) {
        return at + (command - at) * dt / 0.005;
    };
    bool measurable = true;
    double place = 0;  // of the axis
    std::set<Fault> faults;
    bool stops = false, recovered = false;
    double time = 0;

    Supervision() {
        values.lower = 10;
        values.upper = 40;
        values.feed = 100;
        values.max_acceleration = 1000;
        values.max_feed = 500;
        values.min_limit = -100;
        values.max_limit = 100;
        values.max_offset = values.max_rate = 500;
        values.max_output_acceleration = 3000;
        values.max_drift = 0.1;
        values.inset = 0.3;
        values.in_range = true;
    }

    void start() {
        ASSERT_EQ(in_force.take(values, 0, dt), Fault::none);
        in_force.begin_strokes();
        it.select(in_force);
        it.begin({measurable, place, 0, 0.02});
        motion.start(settings(), 0, {});
    }
    StrokeMotion::Settings settings() {
        StrokeMotion::Settings its = in_force.stroke(it.part(values), 0);
        if (values.learn) it.learning().restrain(its);
        return its;
    }
    void step() {
        if (it.recovers()) orders.hold = StrokeMotion::Stop::at_once;
        motion.step(orders, settings(), dt, 64, [&](bool upper, double reversal, double speed, double way) {
            return values.learn ? it.learning().offset(upper, reversal, speed, way) : 0;
        });
        orders.hold = StrokeMotion::Stop::none;
        const double command = motion.leading().position();
        const StrokeSupervision::Findings found =
            it.step({measurable, measurable ? place : nan, command, 0.02}, motion, in_force, dt);
        place = axis(command, place);
        time += dt;
        if (found.fault != Fault::none) faults.insert(found.fault);
        stops |= found.stops;
        recovered |= it.recovers();
        if (found.corrected) motion.oscillation().refresh();
        if (found.stops) motion.fail();
    }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt - 0.5; ++i) step();
    }
    // Until it has learned.
    void learn() {
        values.learn = true;
        start();
        for (int i = 0; i < 60 / dt && !it.learning().learned(); ++i) step();
        ASSERT_TRUE(it.learning().learned());
        ASSERT_EQ(faults, std::set<Fault>{});
    }
};

TEST_F(Supervision, AnAxisThatIsTooFarFromItsCommandStopsTheStroke) {
    values.max_following_error = 2;
    start();
    run(3);
    EXPECT_EQ(faults, std::set<Fault>{}) << "0.5 mm late";
    axis = [](double, double at) { return at; };
    run(1);
    EXPECT_EQ(faults, std::set<Fault>{Fault::following});
    EXPECT_TRUE(stops);
    EXPECT_EQ(motion.state(), StrokeMotion::State::rest);
    faults.clear();
    run(1);
    EXPECT_EQ(faults, std::set<Fault>{}) << "at rest it may be moved";
}

TEST_F(Supervision, WithoutABoundOrAMeasurementTheFollowingErrorIsNotWatched) {
    axis = [](double, double at) { return at; };
    start();
    run(1);
    values.max_following_error = 2;
    measurable = false;
    start();
    run(1);
    EXPECT_EQ(faults, std::set<Fault>{});
}

TEST_F(Supervision, MeasuresTheDeadPointsAndTheTimeOfACycle) {
    start();
    run(5);
    const double cycle = 3.14159265 * 30 / 100;
    EXPECT_NEAR(it.clock().time(), cycle, dt);
    // The command is a cosine with w = 2 F / S, and the axis goes a fifth of its lag in each period.
    const double w = 2 * 100.0 / 30, inside = 15 * (1 - 0.2 / std::sqrt(1.64 - 1.6 * std::cos(w * dt)));
    EXPECT_NEAR(it.dead_points().position(true), 40 - inside, 0.3 * um);
    EXPECT_NEAR(it.dead_points().error(false), -inside, 0.3 * um);
    EXPECT_EQ(it.part(values), 1);
    EXPECT_EQ(it.fault(values, true), Fault::none) << "without learning nothing is missed";
}

TEST_F(Supervision, AnAxisThatPassesRIsToldWhereItLearns) {
    for (const bool learns : {true, false}) {
        SCOPED_TRACE(learns);
        if (learns) {
            learn();
        } else {
            values.learn = false;
            start();
            run(5);
        }
        orders.runs = false;
        axis = [](double command, double at) {
            return at + 0.2 * (command - 20 * um * std::clamp(5 - command, 0.0, 1.0) - at);
        };
        run(8);
        EXPECT_EQ(motion.state(), StrokeMotion::State::rest);
        EXPECT_EQ(faults, learns ? std::set<Fault>{Fault::passed_end} : std::set<Fault>{});
        faults.clear();
        orders.runs = true;
        axis = [](double command, double) { return command; };
    }
}

TEST_F(Supervision, GivesAPulseAtEachDeadPoint) {
    start();
    double seconds[2] = {0, 0};
    const int cycles = 4;
    run(2);
    for (int i = 0; i < cycles * 3.14159265 * 30 / 100 / dt; ++i) {
        step();
        for (const bool upper : {false, true}) seconds[upper] += it.clock().pulse(upper) ? dt : 0;
    }
    for (const double each : seconds) EXPECT_NEAR(each, cycles * 0.02, 0.021);
}

TEST_F(Supervision, ACycleTimeWithSectionsAndDwellsIsKept) {
    values.speed_kind = StrokeSettings::with_sections;
    values.cycle_time = 2;
    values.upper_dwell = 0.3;
    values.section[0] = {SpeedSection::height, 20, 30, 0.5};
    start();
    run(30);
    EXPECT_NEAR(it.clock().time(), 2, 0.005);
}

TEST_F(Supervision, LearnsTheDeadPointsAndWatchesNoneWhereAHoldEndsTheStroke) {
    learn();
    run(3);
    EXPECT_NEAR(it.dead_points().error(true), 0, 2 * um);
    EXPECT_NEAR(it.dead_points().error(false), 0, 2 * um);
    const double upper = it.dead_points().position(true), lower = it.dead_points().position(false);
    for (int i = 0; i < 2000; ++i) {
        orders.hold = StrokeMotion::Stop::at_once;
        step();
        if (motion.oscillation().held()) {
            EXPECT_EQ(it.dead_points().position(true), upper);
            EXPECT_EQ(it.dead_points().position(false), lower);
        }
    }
    ASSERT_TRUE(motion.oscillation().held());
    run(5);
    EXPECT_EQ(faults, std::set<Fault>{});
    EXPECT_TRUE(it.learning().learned());
}

TEST_F(Supervision, AnAxisThatJamsStopsTheStrokeInIt) {
    learn();
    run(3);
    const auto follows = axis;
    axis = [&](double command, double at) { return at > 25 ? at : follows(command, at); };
    const double begin = time;
    while (!stops && time < begin + 2) step();
    EXPECT_EQ(faults, std::set<Fault>{Fault::lags});
    EXPECT_LT(time - begin, 3.14159265 * 30 / 100);
}

TEST_F(Supervision, AnAxisThatFallsBehindWhileTheSpeedRisesIsHeldForHalfASecond) {
    values.learn = true;
    start();
    for (int i = 0; i < 60 / dt && it.learning().speed_factor() < 0.5; ++i) step();
    ASSERT_FALSE(it.learning().learned());
    while (std::abs(motion.leading().velocity()) < 0.9 * in_force.speed(it.part(values))) step();
    const auto follows = axis;
    axis = [](double, double at) { return at; };
    while (!it.recovers() && time < 60) step();
    EXPECT_FALSE(stops);
    axis = follows;
    const double begin = time;
    while (it.recovers()) step();
    EXPECT_NEAR(time - begin, 0.5, 0.01);
    EXPECT_EQ(faults, std::set<Fault>{});
    EXPECT_TRUE(motion.moves());
}

TEST_F(Supervision, AFaultThatLastsIsShownByTheFirstCause) {
    learn();
    EXPECT_EQ(it.fault(values, false), Fault::none);
    EXPECT_EQ(it.fault(values, true), Fault::feedback);
    values.max_drift = -1;
    EXPECT_EQ(it.fault(values, false), Fault::drift);
    values.learn = false;
    EXPECT_EQ(it.fault(values, true), Fault::none);
}

TEST_F(Supervision, DeadPointsThatDoNotConvergeAreReportedAfterThirtyCycles) {
    values.learn = true;
    double wander = 0;
    const auto follows = axis;
    axis = [&](double command, double at) { return follows(command, at) + wander; };
    start();
    int cycles = 0;
    bool upward = true;
    for (int i = 0; i < 400 / dt && it.fault(values, false) == Fault::none; ++i) {
        step();
        if (motion.oscillation().upward() && !upward) wander = ++cycles % 2 ? 0.0004 : -0.0004;
        upward = motion.oscillation().upward();
    }
    EXPECT_EQ(it.fault(values, false), Fault::not_learned);
    EXPECT_GE(cycles, 30);
}

TEST_F(Supervision, AScaleOfAnotherUnitStopsTheStroke) {
    values.learn = true;
    double at = 0;
    axis = [&](double command, double) {
        at += (command - at) * dt / 0.005;
        return at / 25.4;
    };
    start();
    run(30);
    EXPECT_EQ(faults, (std::set<Fault>{Fault::beyond, Fault::scale})) << "beyond, by this scale";
    EXPECT_TRUE(stops);
}

TEST_F(Supervision, AScaleThatIsInvalidForAMomentCorrectsNothing) {
    learn();
    run(3);
    const int rows = static_cast<int>(it.learning().strokes().size());
    for (int i = 0; i < 3000; ++i) {
        measurable = i % 100 > 10;
        step();
    }
    measurable = true;
    run(5);
    EXPECT_EQ(faults, std::set<Fault>{});
    EXPECT_EQ(static_cast<int>(it.learning().strokes().size()), rows);
    EXPECT_NEAR(it.dead_points().error(true), 0, 2 * um);
}

}  // namespace
}  // namespace plumb
