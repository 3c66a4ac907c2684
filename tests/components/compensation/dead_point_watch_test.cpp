// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/dead_point_watch.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace plumb {
namespace {

using Event = DeadPointWatch::Event;
constexpr double um = 1e-3;
constexpr DeadPointLearning::Stroke stroke{10, 40, 100, 1000, 0}, with_section{10, 40, 100, 1000, 1};

DeadPointLearning::Settings usual() {
    return {0.3, 0.7, 1, 2 * um, 5 * um, 600};
}

// Strokes of an axis between 10 and 40, as cosines, and what the watch makes of them.
struct Strokes {
    static constexpr double dt = 0.001;  // s

    DeadPointWatch watch;
    std::function<double(double)> axis = [](double command) { return command; };  // where it is

    Strokes() {
        watch.learning().select(stroke, usual());
        watch.begin();
    }

    // The next one, planned at its begin. Returns all events.
    std::set<Event> next() {
        DeadPointLearning& learning = watch.learning();
        const double k = learning.speed_factor(), speed = 100 * k, a = 600 * k * k;
        OscillationSettings planned;
        learning.restrain(planned);
        DeadPointWatch::Arrival end;
        end.happened = end.regular = true;
        end.upper = upward_;
        end.bound = upward_ ? 40 : 10;
        end.opposite = upward_ ? 10 : 40;
        end.offset = learning.offset(upward_, a, speed);
        end.learned = planned.learned;
        end.acceleration = end.turning = a;
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
            events.insert(watch.step(now, {true, true, 100 * learning.speed_factor()}));
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
    it.watch.learning().select(with_section, usual());
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

}  // namespace
}  // namespace plumb
