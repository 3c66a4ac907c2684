// SPDX-License-Identifier: GPL-2.0-or-later
// The stop of Oscillation that takes the axis out of the work, at any moment of what it does.
#include "components/math/blocks/random.hpp"
#include "components/math/oscillation/oscillation.hpp"
#include "tests/math/oscillation/watched_oscillation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace plumb {
namespace {

constexpr double acceleration = 1000;                                                 // mm/s2, of usual()
constexpr std::size_t planning = (StrokePlanner::most_work + nodes - 1) / nodes + 3;  // periods
constexpr double nothing = 1e-9;                                                      // mm
constexpr double ends[] = {50, 0, 40, 10, 33, 12, 100};

// A withdrawal from the present moment on.
struct Withdrawal {
    explicit Withdrawal(Watched& its)
        : watched(its),
          begin(its.samples.size() - 1),
          arrivals(its.arrivals.size()),
          from(its.it.position()),
          resting(its.it.state() == State::rest) {
        watched.stop(Stop::withdraw);
    }

    void finish() {
        const auto rests = [this] { return watched.it.state() == State::rest; };
        watched.until([&] { return rests() || watched.arrivals.size() > arrivals; });
        in_time = watched.samples.size() - begin > planning;
        watched.until(rests);
    }

    std::vector<Oscillation::Arrival> arrived() const {
        return {watched.arrivals.begin() + static_cast<std::ptrdiff_t>(arrivals), watched.arrivals.end()};
    }

    std::vector<double> samples() const {
        return {watched.samples.begin() + static_cast<std::ptrdiff_t>(begin), watched.samples.end()};
    }

    // The longest rest before the end, in periods, of samples that `counts` selects.
    template <class Counts>
    std::size_t longest_rest(const Counts& counts) const {
        const std::vector<double> all = samples();
        std::size_t longest = 0, now = 0;
        for (std::size_t i = 1; i < all.size() && all[i] != watched.settings.end_position; ++i) {
            now = all[i] == all[i - 1] && counts(all[i]) ? now + 1 : 0;
            longest = std::max(longest, now);
        }
        return longest;
    }

    Watched& watched;
    const std::size_t begin, arrivals;
    const double from;
    const bool resting;
    bool in_time = false;  // for a plan before the first dead point
};

Oscillation::Settings drawn(Random& random) {
    Oscillation::Settings settings = usual();
    settings.end_position = ends[random.index(7)];
    settings.upward_first = random.index(2) == 1;
    settings.spark_out = random.index(4);
    settings.speed = random.uniform(30, 200);
    if (random.index(2) == 1) settings.lower_dwell = random.uniform(0, 0.5);
    if (random.index(2) == 1) settings.upper_dwell = random.uniform(0, 0.5);
    if (random.index(2) == 1) {
        settings.sections[0] = {SpeedSection::height, 15, random.uniform(16, 30), random.uniform(0.2, 3)};
        settings.sections[1] = {SpeedSection::phase, 5.5, random.uniform(0, 0.5), random.uniform(0.2, 2)};
    }
    return settings;
}

void draw_offsets(Random& random, Watched& watched) {
    if (random.index(2) == 0) return;
    for (double& offset : watched.offset) offset = random.uniform(-0.3, 0.3);
}

// At any moment from before the first stroke on, with sections, dwells and learned ends.
TEST(Withdrawal, GoesToTheEndByWayOfTheDeadPointNearestIt) {
    Random random(21);
    int strokes[5] = {}, cycles_more = 0;
    for (int run = 0; run < 1500; ++run) {
        SCOPED_TRACE(run);
        const Oscillation::Settings settings = drawn(random);
        const double end = settings.end_position;
        const double places[] = {end, random.uniform(10, 40), random.uniform(-20, 70)};
        Watched watched(settings, places[random.index(3)]);
        draw_offsets(random, watched);
        watched.run(random.uniform(0, run % 4 == 0 ? 0.5 : 4));
        Withdrawal withdrawal(watched);
        withdrawal.finish();
        ASSERT_NEAR(watched.it.position(), end, nothing);
        ASSERT_LE(watched.hardest, acceleration * 1.01);

        const bool upper = std::abs(40 - end) <= std::abs(10 - end);
        const auto arrived = withdrawal.arrived();
        const double outer = upper ? 40 + watched.offset[1] : 10 - watched.offset[0];
        const bool inward = upper ? end < outer : end > outer;
        ASSERT_LE(arrived.size(), inward ? 4u : 2u) << withdrawal.from;
        if (!arrived.empty()) {
            EXPECT_EQ(arrived.back().upper, upper);
        }
        for (const auto& arrival : arrived) EXPECT_FALSE(arrival.infeed);
        ++strokes[arrived.size()];
        cycles_more += arrived.size() > 2;

        const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
        EXPECT_GE(*low, std::min({9.7, end, watched.samples[0]}));
        EXPECT_LE(*high, std::max({40.3, end, watched.samples[0]}));
        EXPECT_LE(withdrawal.longest_rest([](double) { return true; }), planning);
        EXPECT_EQ(withdrawal.longest_rest(
                      [&](double z) { return z > 10.5 && z < 39.5 && z != watched.samples[0]; }),
                  0u);
    }
    EXPECT_GT(strokes[0], 20) << "from the return, or before the first stroke";
    EXPECT_GT(strokes[1], 100);
    EXPECT_GT(strokes[2], 100);
    EXPECT_GE(cycles_more, 1);
    EXPECT_LE(cycles_more, 40) << "of learned ends, in the last moment of a stroke";
}

// Without a jump of the plan, a pause, or a detour.
TEST(Withdrawal, TheStrokeGoesOnAsItWouldAndTheWayToTheEndIsTimeOptimal) {
    for (const double end : {50.0, 43.0, 4.0, 10.0, 40.0})
        for (double when = 0.1; when < 2; when += 0.0137) {
            SCOPED_TRACE(when);
            Oscillation::Settings settings = usual();
            settings.end_position = end;
            Watched watched(settings, 25), same(settings, 25);
            for (Watched* each : {&watched, &same}) each->run(when);
            Withdrawal withdrawal(watched);
            const bool upper = std::abs(40 - end) <= std::abs(10 - end);
            const double near = upper ? 40 : 10;
            while (watched.arrivals.size() == withdrawal.arrivals || watched.arrivals.back().upper != upper) {
                watched.step();
                same.step();
                if (!watched.it.arrival().happened || watched.arrivals.back().upper != upper) {
                    ASSERT_EQ(watched.it.position(), same.it.position());
                }
            }
            const std::size_t there = watched.samples.size();
            ASSERT_LE(watched.arrivals.size(), withdrawal.arrivals + 2);
            withdrawal.finish();
            const double way = std::abs(end - near), ramp = 100 * 100 / acceleration;
            const double time =
                way > ramp ? way / 100 + 100 / acceleration : 2 * std::sqrt(way / acceleration);
            const double taken = static_cast<double>(watched.samples.size() - there) * dt;
            const bool in_time = there - withdrawal.begin > planning;
            EXPECT_LE(taken, time + (in_time ? 3 : static_cast<double>(planning)) * dt);
            EXPECT_GE(taken, time - 3 * dt);
        }
}

TEST(Withdrawal, TheStrokeToTheDeadPointKeepsItsSections) {
    Oscillation::Settings settings = usual();
    settings.sections[0] = {SpeedSection::height, 15, 30, 0.2};
    Watched watched(settings, 40);
    watched.until([&] { return watched.it.velocity() < 0 && watched.it.position() < 20; });
    Withdrawal withdrawal(watched);
    withdrawal.finish();
    const std::vector<double> z = withdrawal.samples();
    double fastest = 0;
    for (std::size_t i = 1; i < z.size(); ++i)
        if (z[i] > 15 && z[i] < 30) fastest = std::max(fastest, (z[i] - z[i - 1]) / dt);
    EXPECT_GT(fastest, 18);
    EXPECT_LE(fastest, 20.001) << "mm/s, in contact";
}

// The region in force is the one that it leaves: a new one has not been entered.
TEST(Withdrawal, ANewRegionIsNotEnteredAnyMore) {
    Random random(22);
    int late = 0, shifted = 0;
    for (int run = 0; run < 600; ++run) {
        SCOPED_TRACE(run);
        Oscillation::Settings settings = drawn(random);
        Watched watched(settings, random.uniform(10, 40));
        draw_offsets(random, watched);
        watched.run(random.uniform(0.5, 3));
        watched.settings.lower = random.uniform(-60, 60);
        watched.settings.upper = watched.settings.lower + random.uniform(5, 40);
        if (run % 2 == 0) watched.run(random.uniform(0, 2));
        Withdrawal withdrawal(watched);
        withdrawal.finish();
        ASSERT_NEAR(watched.it.position(), settings.end_position, nothing);
        ASSERT_LE(watched.hardest, acceleration * 1.01);
        const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
        EXPECT_GE(*low, std::min({9.7, watched.settings.lower - 0.3, settings.end_position}));
        EXPECT_LE(*high, std::max({40.3, watched.settings.upper + 0.3, settings.end_position}));
        const auto arrived = withdrawal.arrived();
        late += !withdrawal.in_time;
        if (!withdrawal.in_time) continue;
        ASSERT_LE(arrived.size(), 2u);
        shifted += !arrived.empty() && arrived[0].bound != 10 && arrived[0].bound != 40;
        if (arrived.size() < 2) continue;
        // The stroke back is to a dead point in force at the begin.
        bool known = arrived[1].bound == 10 || arrived[1].bound == 40;
        for (std::size_t i = 0; i < withdrawal.arrivals; ++i)
            known |= watched.arrivals[i].bound == arrived[1].bound;
        EXPECT_TRUE(known) << arrived[1].bound;
    }
    EXPECT_LE(late, 150);
    EXPECT_GT(shifted, 30);
}

TEST(Withdrawal, GoesOnFromAStopOfAnotherKindButNotFromRest) {
    Random random(23);
    int rested = 0, went = 0;
    for (int run = 0; run < 900; ++run) {
        SCOPED_TRACE(run);
        const Oscillation::Settings settings = drawn(random);
        Watched watched(settings, random.uniform(10, 40));
        draw_offsets(random, watched);
        watched.run(random.uniform(0, 3));
        const Stop kinds[] = {Stop::dead_point, Stop::end_position, Stop::at_once};
        watched.stop(kinds[run % 3]);
        watched.run(random.uniform(0, run % 3 == 2 ? 0.15 : 0.6));
        Withdrawal withdrawal(watched);
        withdrawal.finish();
        ASSERT_LE(watched.hardest, acceleration * 1.01);
        (withdrawal.resting ? rested : went) += 1;
        ASSERT_NEAR(watched.it.position(), withdrawal.resting ? withdrawal.from : settings.end_position,
                    nothing);
        EXPECT_LE(withdrawal.arrived().size(), 4u);
        EXPECT_LE(withdrawal.longest_rest([](double) { return true; }), planning);
    }
    EXPECT_GT(rested, 50);
    EXPECT_GT(went, 300);
}

TEST(Withdrawal, ChangesNothingOnTheReturn) {
    for (double after = 0; after < 0.2; after += 0.007) {
        Watched watched(usual()), same(usual());
        for (Watched* each : {&watched, &same}) {
            each->run(1.3);
            each->stop(Stop::end_position);
            each->until([&] { return each->it.position() > 40 + nm; });
            each->run(after);
        }
        Withdrawal withdrawal(watched);
        withdrawal.finish();
        same.until([&] { return same.it.state() == State::rest; });
        EXPECT_EQ(watched.samples, same.samples) << after;
        EXPECT_EQ(watched.it.position(), 50);
    }
}

TEST(Withdrawal, MovesNothingAtTheEnd) {
    for (const double end : ends) {
        Oscillation::Settings settings = usual();
        settings.end_position = end;
        Watched watched(settings, end);
        Withdrawal withdrawal(watched);
        withdrawal.finish();
        watched.run(0.5);
        for (const double z : watched.samples) ASSERT_EQ(z, end);
        EXPECT_TRUE(watched.arrivals.empty());
    }
}

// A hold is one of its own: the caller knows whose.
TEST(Withdrawal, AHoldStandsAndThenItGoesOn) {
    Random random(24);
    int held = 0;
    for (int run = 0; run < 400; ++run) {
        SCOPED_TRACE(run);
        const Oscillation::Settings settings = drawn(random);
        Watched watched(settings, random.uniform(10, 40));
        watched.run(random.uniform(0, 3));
        const bool before = run % 2 == 0;
        watched.hold = before ? Stop::at_once : Stop::none;
        if (before) watched.run(random.uniform(0, 0.6));
        Withdrawal withdrawal(watched);
        if (!before) watched.run(random.uniform(0, 0.6));
        watched.hold = Stop::at_once;
        watched.run(1.5);
        if (watched.it.state() != State::rest) {
            held += watched.it.held();
            const double place = watched.it.position();
            watched.run(0.2);
            EXPECT_EQ(watched.it.position(), place);
        }
        watched.hold = Stop::none;
        withdrawal.finish();
        EXPECT_NEAR(watched.it.position(), settings.end_position, nothing);
        EXPECT_LE(watched.hardest, acceleration * 1.01);
    }
    EXPECT_GT(held, 200);
}

TEST(Withdrawal, OnlyAStopAtOnceChangesIt) {
    for (double after = 0; after < 1; after += 0.037)
        for (const Stop kind : {Stop::dead_point, Stop::end_position, Stop::at_once}) {
            Watched watched(usual(), 25);
            watched.run(1.234);
            Withdrawal withdrawal(watched);
            watched.run(after);
            const bool rests = watched.it.state() == State::rest;
            const double speed = std::abs(watched.it.velocity());
            const std::size_t then = watched.samples.size();
            watched.stop(kind);
            withdrawal.finish();
            EXPECT_LE(watched.hardest, acceleration * 1.01);
            if (kind != Stop::at_once || rests) {
                EXPECT_EQ(watched.it.position(), 50);
            } else {
                EXPECT_LE(watched.samples.size() - then, speed / acceleration / dt + 30) << after;
            }
        }
}

// The joint may move meanwhile, and point R with it.
TEST(Withdrawal, EndsWhereTheEndIsThen) {
    Random random(25);
    for (int run = 0; run < 200; ++run) {
        SCOPED_TRACE(run);
        Watched watched(usual(), 25);
        if (run % 2 == 0) watched.run(random.uniform(0, 2));
        if (run % 2 == 0)
            watched.stop(Stop::withdraw);
        else
            watched.it.go_to_end(watched.settings, 25);
        watched.run(random.uniform(0, 0.34));
        const double rate = random.uniform(-40, 40);
        for (int i = random.index(700); i > 0 && watched.it.state() != State::rest; --i) {
            watched.settings.end_position += rate * dt;
            watched.step();
        }
        watched.run(4);
        EXPECT_EQ(watched.it.state(), State::rest);
        EXPECT_EQ(watched.it.position(), watched.settings.end_position);
        EXPECT_LE(watched.hardest, acceleration * 1.01);
    }
}

TEST(Withdrawal, AnEndThatMovesInTheLastMomentOfTheWayIsReached) {
    Watched first(usual(), 25);
    first.it.go_to_end(first.settings, 25);
    first.until([&] { return first.it.state() == State::rest; });
    for (std::size_t left = 5; left < 50; ++left) {
        Watched watched(usual(), 25);
        watched.it.go_to_end(watched.settings, 25);
        while (watched.samples.size() + left < first.samples.size()) watched.step();
        watched.settings.end_position = 55;
        watched.run(2);
        EXPECT_EQ(watched.it.position(), 55) << left;
        EXPECT_LE(watched.hardest, acceleration * 1.01);
    }
}

TEST(Withdrawal, AnEndThatJumpsMakesNoFurtherStrokes) {
    Random random(26);
    for (int run = 0; run < 100; ++run) {
        SCOPED_TRACE(run);
        Watched watched(usual(), 25);
        watched.run(random.uniform(0, 2));
        Withdrawal withdrawal(watched);
        for (int i = 0; i < 20 && watched.it.state() != State::rest; ++i) {
            watched.settings.end_position = 50 - watched.settings.end_position;
            watched.run(random.uniform(0.02, 0.4));
        }
        withdrawal.finish();
        EXPECT_LE(withdrawal.arrived().size(), 3u);
        EXPECT_NEAR(watched.it.position(), watched.settings.end_position, nothing);
        EXPECT_LE(watched.hardest, acceleration * 1.01);
    }
}

TEST(Withdrawal, AHoldOnTheWayKeepsTheDeadPointInForce) {
    Watched watched(usual(), 25);
    watched.hold = Stop::at_once;
    watched.run(0.2);
    watched.settings.lower = 45;
    watched.settings.upper = 60;
    Withdrawal withdrawal(watched);
    watched.hold = Stop::none;
    watched.until([&] { return watched.it.position() > 30; });
    watched.hold = Stop::at_once;
    watched.run(0.5);
    EXPECT_LT(watched.it.position(), 40);
    watched.hold = Stop::none;
    withdrawal.finish();
    ASSERT_EQ(withdrawal.arrived().size(), 1u);
    EXPECT_EQ(withdrawal.arrived()[0].bound, 40);
    EXPECT_EQ(watched.it.position(), 50);
}

TEST(Withdrawal, FromRestItGoesStraightToTheEnd) {
    for (const double place : {10.0, 23.0, 40.0, 50.0, -30.0}) {
        Watched watched(usual(), place);
        watched.it.go_to_end(watched.settings, place);
        watched.until([&] { return watched.it.state() == State::rest; });
        EXPECT_EQ(watched.it.position(), 50);
        EXPECT_TRUE(watched.arrivals.empty());
        EXPECT_TRUE(std::is_sorted(watched.samples.begin(), watched.samples.end()));
        EXPECT_LE(watched.hardest, acceleration * 1.01);
    }
}

// An axis whose end is learned for a turn goes farther out where its command comes back later than in a
// stroke.
TEST(TheWayToTheEnd, LeavesALearnedEndAsQuicklyAsAStrokeAndEndsGently) {
    constexpr double gentle = 40;  // mm/s2
    for (const double place : {9.95, 10.0, 10.5, 24.0, 39.0, 70.0})
        for (const double offset : {2.0, -0.1}) {
            SCOPED_TRACE(testing::Message() << place << " " << offset);
            Oscillation::Settings settings = usual();
            settings.end_position = place;
            settings.end_acceleration = gentle;
            settings.caution = 0.2;
            Watched stroke(settings, 25), stops(settings, 25);
            for (Watched* its : {&stroke, &stops}) {
                its->offset[0] = its->offset[1] = offset;
                its->run(3);
                its->until([&] { return !its->it.upward() && its->it.velocity() < -50; });
            }
            stops.stop(Stop::end_position);
            stroke.until([&] { return stroke.it.upward() && stroke.it.velocity() > 50; });
            while (stops.samples.size() < stroke.samples.size()) stops.step();
            for (std::size_t i = 0; i < stroke.samples.size(); ++i)
                ASSERT_GE(stops.samples[i], stroke.samples[i] - nothing);
            stops.until([&] { return stops.it.state() == State::rest; });
            EXPECT_EQ(stops.it.position(), place);
            const std::vector<double>& all = stops.samples;
            const auto amid = [](double z) { return std::abs(z - 25) < 1e-4; };
            const auto last = std::find_if(all.begin() + static_cast<std::ptrdiff_t>(stroke.samples.size()),
                                           all.end(), amid);
            ASSERT_GT(all.end() - last, 5) << "it rests amid the region";
            for (auto z = last + 5; z + 2 < all.end(); ++z)
                ASSERT_LE(std::abs(z[2] - 2 * z[1] + z[0]) / (dt * dt), 1.001 * gentle);
        }
}

// Where an axis would stand too near to a dead point, its command turns before it brakes.
TEST(AStopAtOnce, RestsWhereTheAxisMayStand) {
    Oscillation::Settings settings = usual();
    settings.caution = 0.5;
    for (int i = 0; i < 120; ++i) {
        SCOPED_TRACE(i);
        Watched its(settings, 25);
        its.run(3 + 0.01 * i);
        its.hold = Stop::at_once;
        its.until([&] { return its.it.held(); });
        EXPECT_GE(its.it.position(), 11 - nothing);
        EXPECT_LE(its.it.position(), 39 + nothing);
    }
}

// The axis itself turns later than its command, and farther out where the command brakes before.
TEST(AStopAtOnce, WaitsUntilTheCommandIsBackFromAnEndThatIsLearnedOutside) {
    Oscillation::Settings settings = usual();
    settings.clear = Stop::lower;
    settings.caution = 0.2;
    for (const bool leaves : {true, false})
        for (double place = 8.1; place < 10.4; place += 0.2) {
            SCOPED_TRACE(testing::Message() << leaves << ' ' << place);
            Watched its(settings, 25);
            its.offset[0] = its.offset[1] = 2;
            its.run(3);
            its.until([&] { return its.it.upward() && its.it.second_half(); });
            its.until([&] { return its.it.upward() && its.it.position() < 9; });
            its.until([&] { return its.it.position() > place; });
            if (leaves)
                its.stop(Stop::leave);
            else
                its.hold = Stop::at_once;
            its.until([&] { return its.it.state() == State::braking; });
            EXPECT_GE(its.it.position(), 10.4 - nothing);
        }
}

// Also not for the few periods in which a withdrawal that came late is planned.
TEST(TheWayToTheEnd, NeverRestsAtAnEndThatIsLearnedForATurn) {
    Oscillation::Settings settings = usual();
    settings.end_position = 10.05;  // outside the end of the stroke, inside the dead point
    settings.caution = 0.2;
    for (int left = 1; left < 60; ++left) {
        SCOPED_TRACE(left);
        Watched its(settings, 25);
        its.offset[0] = its.offset[1] = -0.1;
        its.run(3);
        its.until([&] {
            return !its.it.upward() && its.it.plan().to() - 10.1 < nm &&
                   its.it.position() < 10.1 + 0.5e-3 * left * left * 0.6;
        });
        its.stop(Stop::withdraw);
        const std::size_t begin = its.samples.size();
        its.until([&] { return its.it.state() == State::rest; });
        for (std::size_t i = begin; its.samples[i] != settings.end_position; ++i)
            ASSERT_FALSE(its.samples[i] == its.samples[i - 1] && its.samples[i] < 11);
    }
}

// Straight on where it lies farther out than the axis turns; the stroke that ends there is as it was.
TEST(TheWayToTheEnd, GoesOnToAPlaceBeyondItsDeadPoint) {
    Oscillation::Settings settings = usual();
    settings.end_position = 50;
    settings.end_acceleration = 40;
    settings.caution = 0.2;
    Watched its(settings, 25);
    its.offset[0] = its.offset[1] = 2;
    its.run(3);
    its.until([&] { return its.it.upward() && its.it.velocity() > 50; });
    its.stop(Stop::end_position);
    const std::size_t begin = its.samples.size();
    its.until([&] { return its.it.state() == State::rest; });
    EXPECT_TRUE(std::is_sorted(its.samples.begin() + static_cast<std::ptrdiff_t>(begin), its.samples.end()));
    EXPECT_EQ(its.it.position(), 50);
}

}  // namespace
}  // namespace plumb
