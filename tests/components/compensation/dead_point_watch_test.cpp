// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/dead_point_watch.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

namespace plumb {
namespace {

using Event = DeadPointWatch::Event;
constexpr double um = 1e-3;
constexpr DeadPointLearning::Stroke stroke{10, 40, 100, 1000, 0}, with_section{10, 40, 100, 1000, 1};

DeadPointLearning::Settings usual() {
    return {0.3, 0.7, 1, 2 * um, 5 * um, 600, {600, 600}};
}

// Strokes of an axis between 10 and 40, as cosines, and what the watch makes of them.
struct Strokes {
    static constexpr double dt = 0.001;  // s

    DeadPointWatch watch;
    std::function<double(double)> axis = [](double command) { return command; };  // where it is
    bool regular = true;                                                          // the strokes
    std::array<double, 2> wait{};  // s, at the lower and the upper dead point
    int passes = 0;                // events

    Strokes() {
        watch.change_learning().select(stroke, usual());
        watch.begin();
    }

    // The next one, planned at its begin. Returns all events.
    std::set<Event> next() {
        DeadPointLearning& learning = watch.change_learning();
        const double k = learning.speed_factor(), speed = 100 * k, a = 600 * k * k;
        OscillationSettings planned;
        learning.restrain(planned);
        DeadPointWatch::Arrival end;
        end.happened = true;
        end.regular = regular;
        end.wait = wait[upward_];
        end.upper = upward_;
        end.bound = upward_ ? 40 : 10;
        end.opposite = upward_ ? 10 : 40;
        end.offset = learning.offset(upward_, a, speed);
        end.learned = planned.learned;
        end.acceleration = a;
        end.speed = speed;
        end.braking = learning.braking();
        const double from = place_, to = end.bound + (upward_ ? end.offset : -end.offset);
        end.length = std::abs(to - from);
        const double duration = pi * end.length / (2 * speed), w = pi / duration;
        std::set<Event> events;
        for (int i = 1; i * dt <= duration; ++i) {
            const double phase = w * i * dt, command = from + (to - from) * (1 - std::cos(phase)) / 2;
            const DeadPointWatch::Sample now{axis(command),
                                             command,
                                             (to - from) / 2 * w * std::sin(phase),
                                             (to - from) / 2 * w * w * std::cos(phase),
                                             phase > pi / 2,
                                             upward_,
                                             duration,
                                             dt,
                                             end.length,
                                             speed};
            const Event event = watch.step(now, {true, true, 100 * learning.speed_factor(), wait});
            passes += event == Event::passes;
            events.insert(event);
        }
        watch.arrive(end);
        place_ = to;
        upward_ = !upward_;
        return events;
    }

    // Events of so many strokes.
    std::set<Event> next(int count) {
        std::set<Event> all;
        for (int i = 0; i < count; ++i) all.merge(next());
        return all;
    }

    void learn() {
        for (int i = 0; i < 100 && !watch.learning().learned(); ++i) next();
        ASSERT_TRUE(watch.learning().learned());
        next(6);
    }

    bool upward() const { return upward_; }  // the next one

    // From now on the axis is late amid each stroke by `late`, mu, which neither speed nor acceleration
    // explains, and `is_short` of the dead points.
    void come_late(double late, double is_short = 0) {
        axis = [this, late, is_short](double command) {
            const double from_middle = command - 25, sign = upward_ ? 1 : -1;
            const double amid = std::exp(-from_middle * from_middle / 4);
            return command - sign * late * amid -
                   (std::abs(from_middle) > 14 ? std::copysign(is_short, from_middle) : 0);
        };
    }

private:
    double place_ = 10;
    bool upward_ = true;
};

TEST(DeadPointWatch, LearnsTheEndsOfAnAxisThatEndsShort) {
    Strokes it;
    it.axis = [](double command) { return 25 + (command - 25) * 0.99; };
    it.learn();
    for (const bool upper : {false, true}) EXPECT_NEAR(it.watch.error(upper), 0, 2 * um);
    EXPECT_EQ(it.next(10).count(Event::lags), 0u);
}

TEST(DeadPointWatch, AStrokeThatWasPlannedWithOtherSectionsCorrectsNothing) {
    Strokes it;
    it.learn();
    EXPECT_EQ(it.next().count(Event::corrected), 1u);
    it.watch.change_learning().select(with_section, usual());
    EXPECT_EQ(it.next().count(Event::corrected), 0u) << "its dead point is that of the stroke before";
    EXPECT_EQ(it.next().count(Event::corrected), 1u);
}

TEST(DeadPointWatch, ADeadPointAtWhichTheAxisDoesNotTurnIsLost) {
    Strokes it;
    it.next(4);
    double farthest = 0;
    it.axis = [&](double command) { return farthest = std::max(farthest, command) + 1e-6; };
    EXPECT_EQ(it.next(3).count(Event::lost), 1u);
}

TEST(DeadPointWatch, AScaleThatSlipsIsNamed) {
    Strokes it;
    it.learn();
    it.axis = [](double command) { return command + 0.05; };
    EXPECT_EQ(it.next(6).count(Event::slips), 1u);
}

TEST(DeadPointWatch, ADeadPointThatIsPassedOnceIsToldThoughTheNextOnesAreShort) {
    Strokes it;
    double beyond[2] = {0, 0};  // mu, lower, upper
    it.axis = [&](double command) { return 25 + (command - 25) * (1 + beyond[command > 25] / 15); };
    it.learn();
    if (!it.upward()) it.next();
    beyond[1] = 24 * um;
    EXPECT_EQ(it.next().count(Event::beyond), 0u);
    beyond[0] = -43 * um;
    beyond[1] = -45 * um;
    EXPECT_EQ(it.next().count(Event::beyond), 1u) << "in the stroke after it";
    EXPECT_FALSE(it.watch.learning().rising());
    EXPECT_EQ(it.next(2).count(Event::beyond), 1u);
    EXPECT_TRUE(it.watch.learning().rising());
}

TEST(DeadPointWatch, AScaleOfAnotherUnitIsWrong) {
    Strokes it;
    it.axis = [](double command) { return 1.5 * command; };
    EXPECT_EQ(it.next(6).count(Event::wrong_scale), 1u);
}

TEST(DeadPointWatch, AJamIsToldInTheStroke) {
    Strokes it;
    it.learn();
    it.axis = [](double command) { return std::min(command, 20.0); };
    EXPECT_EQ(it.next(2).count(Event::lags), 1u);
}

TEST(DeadPointWatch, AWatchThatPausedJudgesNoStrokeThatIsNotWhole) {
    Strokes it;
    it.learn();
    it.axis = [](double command) { return std::min(command, 20.0); };
    it.watch.pause();
    EXPECT_EQ(it.next().count(Event::lags), 0u);
    EXPECT_EQ(it.watch.learning().learned(), true);
}

TEST(DeadPointWatch, AStrokeThatEndsWrongWidensNoBound) {
    Strokes it;
    it.learn();
    it.come_late(45 * um, 20 * um);
    EXPECT_EQ(it.next(2).count(Event::lags), 0u) << "within the bound";
    it.come_late(70 * um, 20 * um);
    EXPECT_EQ(it.next().count(Event::lags), 1u);
}

TEST(DeadPointWatch, ALagThatGrowsSlowlyIsNoJam) {
    Strokes it;
    it.learn();
    for (double late = 0; late < 0.2; late += 5 * um) {
        it.come_late(late);
        EXPECT_EQ(it.next().count(Event::lags), 0u) << late;
    }
    it.come_late(0.8);
    EXPECT_EQ(it.next().count(Event::lags), 1u);
}

TEST(DeadPointWatch, ANewMotionAndANewWaitBeginWithANewLag) {
    for (const bool waits : {false, true}) {
        SCOPED_TRACE(waits);
        Strokes it;
        it.learn();
        while (!it.upward()) it.next();
        if (waits) {
            it.wait[1] = 0.3;
            it.next();
        } else {
            it.watch.begin();
        }
        it.come_late(0.2);
        EXPECT_EQ(it.next(8).count(Event::lags), 0u);
        it.come_late(1.5);
        EXPECT_EQ(it.next().count(Event::lags), 1u);
    }
}

TEST(DeadPointWatch, AnAxisThatPassedADeadPointHasAnotherLag) {
    Strokes it;
    it.learn();
    it.axis = [](double command) { return 25 + (command - 25) * 1.002; };
    while (!it.watch.learning().rising()) it.next();
    it.come_late(0.2, 30 * um);
    EXPECT_EQ(it.next(8).count(Event::falls_behind), 0u);
}

TEST(DeadPointWatch, OneReadingThatNoAxisExplainsIsIgnored) {
    Strokes it;
    it.next(2);
    while (!it.upward()) it.next();
    it.axis = [](double command) { return std::min(command, 30.0); };
    std::set<Event> seen = it.next(2);
    it.axis = [](double command) { return command; };
    seen.merge(it.next(6));
    EXPECT_EQ(seen.count(Event::wrong_scale), 0u);
    EXPECT_EQ(seen.count(Event::lost), 0u);
}

TEST(DeadPointWatch, ADeadPointThatIsPassedIsToldOnceAndOnlyThatOfAStroke) {
    for (const bool regular : {true, false}) {
        SCOPED_TRACE(regular);
        Strokes it;
        it.learn();
        while (!it.upward()) it.next();
        it.axis = [](double command) { return command > 25 ? command + 24 * um : command; };
        it.regular = regular;
        it.passes = 0;
        it.next(2);
        EXPECT_EQ(it.passes, regular ? 1 : 0);
    }
}

TEST(DeadPointWatch, ADeadPointThatTheFirstWayPassesIsTold) {
    Strokes it;
    it.axis = [](double command) { return command > 25 ? command + 3 : command; };
    it.regular = false;
    it.next();
    it.regular = true;
    it.next();
    EXPECT_EQ(it.passes, 1);
}

}  // namespace
}  // namespace plumb
