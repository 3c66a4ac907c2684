// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/oscillation.hpp"

#include "components/math/blocks/random.hpp"
#include "tests/math/oscillation/watched_oscillation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb {
namespace {

TEST(Oscillation, StartsAtPointRAndTakesUpTheRealDeadPointAtTheOppositeEnd) {
    Watched watched(usual());
    watched.run(5);
    const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
    EXPECT_EQ(*high, 50);
    EXPECT_NEAR(*low, 10, 1000 * dt * dt / 8);
    ASSERT_GE(watched.arrivals.size(), 3u);
    EXPECT_FALSE(watched.arrivals[0].upper);
    EXPECT_EQ(watched.arrivals[1].bound, 40);
    const double later = *std::max_element(watched.samples.begin() + 2000, watched.samples.end());
    EXPECT_LE(later, 40);
    EXPECT_NEAR(later, 40, 1000 * dt * dt / 8);
    EXPECT_LE(watched.hardest, 1000 * 1.01);
    EXPECT_FALSE(watched.late);
}

TEST(Oscillation, StartsAnywhereInTheDirectionThatIsSet) {
    for (const bool upward : {true, false})
        for (const double place : {10.0, 10.001, 25.0, 39.999, 40.0, 0.0, 60.0}) {
            Oscillation::Settings settings = usual();
            settings.upward_first = upward;
            Watched watched(settings, place);
            watched.run(3);
            ASSERT_FALSE(watched.arrivals.empty());
            const bool first = place <= 10 ? true : place >= 40 ? false : upward;
            EXPECT_EQ(watched.arrivals[0].upper, first) << place;
            EXPECT_LE(watched.hardest, 1000 * 1.01) << place;
            const auto [low, high] =
                std::minmax_element(watched.samples.begin() + 1500, watched.samples.end());
            EXPECT_GE(*low, 10);
            EXPECT_LE(*high, 40);
        }
}

TEST(Oscillation, AFirstWayThatIsShorterThanItsInsetIsLeftOut) {
    for (const bool upward : {false, true}) {
        Oscillation::Settings settings = usual();
        settings.upward_first = upward;
        Watched axis(settings, upward ? 39.5 : 10.5);  // farther out than where its first stroke would end
        axis.offset[0] = axis.offset[1] = -1;
        axis.until([&] { return !axis.arrivals.empty(); });
        EXPECT_EQ(axis.arrivals[0].upper, !upward) << "it goes the other way first";
        EXPECT_NEAR(axis.it.position(), upward ? 11 : 39, 0.01);
        axis.run(3);
        EXPECT_LE(*std::max_element(axis.samples.begin(), axis.samples.end()), 39.5);
        EXPECT_GE(axis.lowest, 10.5);
    }
}

// Also while the speed rises, without a caution: a weak drive that has given a stroke up goes on from its
// middle.
TEST(Oscillation, AFirstWayOfALearnedStrokeIsNoQuickerThanAStroke) {
    for (const double caution : {0.1, 0.0}) {
        Oscillation::Settings settings = usual();
        settings.learned = 1;
        settings.caution = caution;
        Watched axis(settings, 34);
        axis.until([&] { return axis.it.position() > 39.99 - caution; });
        EXPECT_LE(axis.hardest, 1000 * (6 - caution) / 30 * 1.01) << "w^2 = 2 a / S is that of the stroke";
        axis.run(2);
        EXPECT_NEAR(axis.arrivals[0].offset, -caution, 1e-9);
        EXPECT_GT(axis.hardest, 600);
    }
}

TEST(Oscillation, AStrokeTellsFromWhichDeadPointItCame) {
    Watched axis(usual());
    axis.until([&] { return axis.arrivals.size() == 2; });
    EXPECT_EQ(axis.arrivals[1].opposite, axis.arrivals[0].bound);
    axis.settings.upper = 35;
    axis.until([&] { return axis.arrivals.size() == 5; });
    EXPECT_EQ(axis.arrivals[4].opposite, axis.arrivals[4].upper ? 10 : 35);
}

// An hour; scripts/bench grinder has a day of the component.
TEST(Oscillation, CycleTimeIsThatOfThePlanAndNeverDrifts) {
    Watched watched(usual());
    watched.until([&] { return watched.arrivals.size() == 2 && watched.it.velocity() < -99; });
    const double cycle = watched.it.stroke_time(true) + watched.it.stroke_time(false);
    EXPECT_NEAR(cycle, pi * 30 / 100, 1e-4);
    const double z = watched.it.position();
    const double periods = std::floor(3600 / cycle) * cycle / dt;
    const auto whole = static_cast<int>(periods);
    for (int i = 0; i < whole; ++i) watched.it.step(dt, Stop::none, nodes, [](auto...) { return 0.0; });
    const double before = watched.it.position(), part = periods - whole;
    watched.step();
    // Where it is fast, at 100 mm/s: 1 nm is 10 ns.
    const double now = before + part * (watched.it.position() - before);
    EXPECT_NEAR(now, z, 1000 * dt * dt / 8 + nm);
}

TEST(Oscillation, DwellsAtEachDeadPointForItsTime) {
    Oscillation::Settings settings = usual();
    settings.lower_dwell = 0.25;
    settings.upper_dwell = 0.1;
    Watched watched(settings, 25);
    watched.run(4);
    int low = 0, high = 0;
    std::size_t strokes = 0;
    for (std::size_t i = 1; i < watched.samples.size(); ++i) {
        low += watched.samples[i] == 10 && watched.samples[i - 1] == 10;
        high += watched.samples[i] == 40 && watched.samples[i - 1] == 40;
        strokes += watched.samples[i] == 40 && watched.samples[i - 1] != 40;
    }
    EXPECT_NEAR(high / static_cast<double>(strokes), 100, 2);
    EXPECT_NEAR(low / static_cast<double>(strokes), 250, 60);
}

// An axis that comes to a dead point 30 ms after its command.
TEST(Oscillation, AnExactStopCountsTheDwellFromWhenTheAxisIsThere) {
    for (const double dwell : {0.0, 0.02, 0.25}) {
        Oscillation::Settings settings = usual();
        settings.lower_dwell = settings.upper_dwell = dwell;
        settings.exact_stop = 0.2;
        Watched watched(settings, 25);
        int standing = 0, longest = 0;
        watched.there = [&] { return standing >= 30; };
        for (int i = 0; i < 4000; ++i) {
            watched.step();
            standing = watched.it.state() == State::waiting ? standing + 1 : 0;
            longest = std::max(longest, standing);
        }
        EXPECT_NEAR(longest, 31 + dwell / dt, 2) << dwell;
        EXPECT_GT(watched.arrivals.size(), 4u);
        EXPECT_FALSE(watched.late || watched.it.impatient());
        EXPECT_LE(watched.hardest, 1000 * 1.01);
    }
}

TEST(Oscillation, AnExactStopWaitsNoLongerThanItsTimeForAnAxisThatDoesNotCome) {
    Oscillation::Settings settings = usual();
    settings.lower_dwell = settings.upper_dwell = 0.1;
    settings.exact_stop = 0.2;
    Watched watched(settings, 25);
    watched.there = [] { return false; };
    int standing = 0, longest = 0;
    for (int i = 0; i < 5000; ++i) {
        watched.step();
        standing = watched.it.state() == State::waiting ? standing + 1 : 0;
        longest = std::max(longest, standing);
    }
    EXPECT_NEAR(longest, 300, 2);
    EXPECT_TRUE(watched.it.impatient());
    EXPECT_GT(watched.arrivals.size(), 4u);

    watched.until([&] { return watched.it.state() == State::waiting; });
    watched.stop(Stop::withdraw);
    watched.until([&] { return watched.it.state() != State::waiting; });
    const auto left = static_cast<double>(watched.samples.size());
    watched.until([&] { return watched.it.state() == State::rest; });
    EXPECT_LT((static_cast<double>(watched.samples.size()) - left) * dt, 2) << "a withdrawal waits nowhere";
    EXPECT_EQ(watched.it.position(), 50);
}

// Whatever the moment, and also as the end after a number of strokes.
TEST(Oscillation, AStopAtTheUpperOrTheLowerDeadPointRestsThere) {
    for (const auto& [stop, place] : {std::pair{Stop::upper, 40.0}, std::pair{Stop::lower, 10.0}})
        for (const int sparks : {0, 1, 2})
            for (double when = 0; when < 2; when += 0.0377) {
                Oscillation::Settings settings = usual();
                settings.spark_out = sparks;
                Watched watched(settings);
                watched.run(when);
                watched.hold = when > 1.5 ? Stop::at_once : Stop::none;
                if (when > 1.5) watched.run(0.3);
                const int before = watched.it.strokes();
                watched.stop(stop);
                watched.hold = Stop::none;
                watched.until([&] { return watched.it.state() == State::rest; });
                if (watched.it.position() == 50)  // it had not left R, which is beyond
                    EXPECT_EQ(when, 0);
                else
                    EXPECT_EQ(watched.it.position(), place) << when;
                EXPECT_LE(watched.it.strokes() - before, sparks + 3) << "one more in the last moment of one";
                EXPECT_LE(watched.hardest, 1000 * 1.01);
            }
    for (const int strokes : {3, 4}) {
        Oscillation::Settings settings = usual();
        settings.strokes = strokes;
        settings.ending = Stop::lower;
        Watched watched(settings);
        watched.until([&] { return watched.it.state() == State::rest; });
        EXPECT_EQ(watched.it.position(), 10);
        EXPECT_EQ(watched.it.strokes(), 4);
    }
}

TEST(Oscillation, StopsAfterItsStrokesAndSparkOutAtTheEndPosition) {
    Oscillation::Settings settings = usual();
    settings.strokes = 6;
    settings.spark_out = 3;
    Watched watched(settings);
    watched.until([&] { return watched.it.state() == State::rest; });
    EXPECT_EQ(watched.it.strokes(), 9);
    EXPECT_EQ(watched.it.position(), 50);
    int infeeds = 0;
    for (const auto& arrival : watched.arrivals) infeeds += arrival.infeed;
    EXPECT_EQ(infeeds, 7) << "the first arrival and those of six strokes";
    EXPECT_LE(watched.hardest, 1000 * 1.01);
}

TEST(Oscillation, AStopAtTheDeadPointStaysThere) {
    for (double when = 1; when < 2; when += 0.0377) {
        Watched watched(usual());
        watched.run(when);
        watched.stop(Stop::dead_point);
        watched.until([&] { return watched.it.state() == State::rest; });
        const double place = watched.it.position();
        EXPECT_TRUE(place == 10 || place == 40) << place;
        watched.run(1);
        EXPECT_EQ(watched.it.position(), place);
        EXPECT_LE(watched.hardest, 1000 * 1.01);
    }
}

TEST(Oscillation, AStopAtOnceBrakesWithTheLargestAcceleration) {
    for (double when = 1; when < 2; when += 0.0377) {
        Watched watched(usual());
        watched.run(when);
        const double speed = watched.it.velocity(), from = watched.it.position();
        watched.stop(Stop::at_once);
        watched.until([&] { return watched.it.state() == State::rest; });
        EXPECT_NEAR(watched.it.position(), from + speed * std::abs(speed) / 2000, 0.15) << when;
        EXPECT_LE(watched.hardest, 1000 * 1.01);
    }
}

// A correction that has the command end 0.2 mm outside: the axis lags behind, and must not come to rest
// there.
TEST(Oscillation, NoStopOrHoldEndsBeyondADeadPointThatIsCommandedOutside) {
    for (const Stop kind : {Stop::dead_point, Stop::at_once, Stop::none})
        for (double when = 1; when < 3; when += 0.0131) {
            Watched watched(usual(), 25);
            watched.offset[0] = watched.offset[1] = 0.2;
            watched.run(when);
            if (kind == Stop::none)
                watched.hold = Stop::at_once;
            else
                watched.stop(kind);
            watched.until([&] { return watched.it.state() == State::rest || watched.it.held(); });
            ASSERT_GE(watched.it.position(), 10 - 1e-9) << when;
            ASSERT_LE(watched.it.position(), 40 + 1e-9) << when;
            if (kind == Stop::dead_point) {
                ASSERT_TRUE(std::abs(watched.it.position() - 10) < nm ||
                            std::abs(watched.it.position() - 40) < nm);
            }
            ASSERT_LE(watched.hardest, 1000 * 1.01) << when;
        }
}

TEST(Oscillation, AHeldStrokeGoesOnInItsDirection) {
    for (double when = 1; when < 2; when += 0.0377) {
        Watched watched(usual());
        watched.run(when);
        watched.hold = Stop::at_once;
        watched.until([&] { return watched.it.held(); });
        const double place = watched.it.position();
        const bool upward = watched.it.upward();
        watched.run(0.5);
        EXPECT_EQ(watched.it.position(), place);
        watched.hold = Stop::none;
        const std::size_t before = watched.arrivals.size();
        watched.until([&] { return watched.arrivals.size() > before; });
        if (place > 10.001 && place < 39.999) {
            EXPECT_EQ(watched.arrivals.back().upper, upward);
        }
        EXPECT_LE(watched.hardest, 1000 * 1.01);
    }
}

TEST(Oscillation, FrozenItRestsUntilStarted) {
    Watched watched(usual());
    watched.run(1.234);
    const double place = watched.it.position();
    watched.it.freeze(place);
    watched.run(1);
    EXPECT_EQ(watched.it.position(), place);
    watched.it.start(watched.settings, place);
    watched.hardest = 0;
    watched.run(2);
    EXPECT_GE(watched.arrivals.size(), 4u);
    EXPECT_LE(watched.hardest, 1000 * 1.01);
}

// The new upper dead point comes with an upward stroke, the new lower one with a downward stroke; between
// them the position is that of the plan to the nanometre: the same samples as without any shift.
TEST(Oscillation, ARegionShiftChangesNothingBeforeItsDeadPoint) {
    for (const auto& [lower, upper] :
         {std::pair{5.0, 35.0}, {20.0, 60.0}, {60.0, 90.0}, {-50.0, -20.0}, {15.0, 35.0}}) {
        Watched shifted(usual(), 10), same(usual(), 10);
        for (Watched* each : {&shifted, &same}) each->run(1.5);
        shifted.settings.lower = lower;
        shifted.settings.upper = upper;
        const std::size_t count = shifted.arrivals.size();
        const std::size_t from = shifted.samples.size();
        shifted.until([&] { return shifted.arrivals.size() >= count + 6; });
        same.run(5);
        std::size_t i = from;
        while (i < shifted.samples.size() && std::abs(shifted.samples[i] - same.samples[i]) < nm) ++i;
        const double there = shifted.samples[i - 1];  // the last that is the same is at a dead point
        EXPECT_LT(std::min(std::abs(there - 10), std::abs(there - 40)), 0.01);
        EXPECT_LE(shifted.hardest, 1000 * 1.01);
        const auto [low, high] = std::minmax_element(shifted.samples.begin(), shifted.samples.end());
        EXPECT_GE(*low, std::min(lower, 10.0));
        EXPECT_LE(*high, std::max(upper, 40.0));
        EXPECT_EQ(shifted.arrivals.back().bound, shifted.arrivals.back().upper ? upper : lower);
        EXPECT_EQ(shifted.arrivals[shifted.arrivals.size() - 2].bound,
                  shifted.arrivals.back().upper ? lower : upper);
    }
}

// What was learned holds for a whole stroke of one region, at one speed.
TEST(Oscillation, AStrokeBetweenTwoRegionsOrSpeedsEndsInside) {
    Watched watched(usual(), 10);
    watched.offset[0] = watched.offset[1] = 0.2;
    Random random(11);
    for (int i = 0; i < 30; ++i) {
        if (i % 2 == 0) watched.settings.lower = random.uniform(0, 20);
        if (i % 3 == 0) watched.settings.speed = random.uniform(50, 150);
        watched.run(random.uniform(0.2, 1.5));
    }
    int mixed = 0, regular = 0;
    for (const auto& arrival : watched.arrivals) {
        (arrival.regular ? regular : mixed) += 1;
        if (!arrival.regular) {
            EXPECT_EQ(arrival.offset, 0);
        }
    }
    EXPECT_GT(mixed, 5);
    EXPECT_GT(regular, 5);
}

// The continuous motion that the arrivals describe: each stroke from rest to rest, where and when the one
// before it ended. Planned here by itself, from `start` in the period `begin`.
class Continuous {
public:
    Continuous(const Watched& watched, double start) : end_(start) {
        for (const Oscillation::Arrival& arrival : watched.arrivals) add(watched.settings, arrival);
    }

    std::size_t samples() const { return static_cast<std::size_t>(time_ / dt); }
    double position(std::size_t sample) const {
        const double time = static_cast<double>(sample) * dt;
        const auto after = std::upper_bound(begins_.begin(), begins_.end(), time);
        const auto i = static_cast<std::size_t>(after - begins_.begin()) - 1;
        return plans_[i].at(time - begins_[i]).position;
    }

private:
    void add(const Oscillation::Settings& settings, const Oscillation::Arrival& arrival) {
        const double to = arrival.bound + (arrival.upper ? arrival.offset : -arrival.offset);
        StrokeRequest request;
        request.from = end_;
        request.to = to;
        request.shape = {std::min(end_, to), std::max(end_, to), arrival.speed};
        request.largest_speed = settings.largest_speed;
        request.acceleration = settings.acceleration;
        request.spans = SpeedSections::spans(settings.sections, request.shape, arrival.upper);
        plans_.emplace_back();
        planner_.begin(request, plans_.back());
        planner_.step(StrokePlanner::most_work);
        begins_.push_back(time_);
        time_ += plans_.back().duration();
        end_ = to;
    }

    StrokePlanner planner_;
    std::vector<StrokePlan> plans_;
    std::vector<double> begins_;
    double time_ = 0, end_;
};

// At any moment, in any direction, with sections, another speed and learned ends.
TEST(Oscillation, IsWithinANanometreOfTheContinuousMotionAtEveryShift) {
    Random random(12);
    int late = 0;  // a shift made a stroke that takes less time than its plan, which is reported
    for (int run = 0; run < 60; ++run) {
        SCOPED_TRACE(run);
        Oscillation::Settings settings = usual();
        if (run % 2 == 1) {
            settings.sections[0] = {SpeedSection::height, 15, random.uniform(16, 30), random.uniform(0.2, 3)};
            settings.sections[1] = {SpeedSection::phase, 5.5, random.uniform(0, 0.5), random.uniform(0.2, 2)};
        }
        Watched watched(settings, 10);
        if (run % 3 == 0) watched.offset[0] = watched.offset[1] = random.uniform(-0.3, 0.3);
        // The first stroke begins a period before its first sample.
        while (watched.it.state() != State::stroke) watched.step();
        watched.samples = {10, 10, 10, watched.it.position()};
        for (int i = 0; i < 25; ++i) {
            watched.settings.lower = random.uniform(-60, 60);
            watched.settings.upper = watched.settings.lower + random.uniform(5, 40);
            if (run % 4 == 0) watched.settings.speed = random.uniform(20, 200);
            watched.run(random.uniform(0, 1.5));
        }
        EXPECT_LE(watched.hardest, 1000 * 1.01);
        late += watched.late;
        if (watched.late) continue;
        const Continuous continuous(watched, 10);
        ASSERT_GT(continuous.samples(), 5000u);
        for (std::size_t i = 1; i < continuous.samples(); ++i)
            ASSERT_NEAR(watched.samples[i + 2], continuous.position(i), nm) << i;
    }
    EXPECT_LE(late, 3);
}

// Samples around a dead point are those of the continuous motion: what is left of a period after it belongs
// to the next stroke.
TEST(Oscillation, TheSampleWithTheDeadPointIsSplitThere) {
    Watched watched(usual(), 10);
    watched.until([&] { return watched.arrivals.size() == 1 && watched.it.velocity() != 0; });
    const double v = watched.it.velocity(), a = watched.it.acceleration(), t = v / a;
    EXPECT_LT(t, dt + 1e-12);
    EXPECT_NEAR(watched.it.position(), 40 + a * t * t / 2, nm);
}

TEST(Oscillation, AnOverrideComesWithAStrokeAndKeepsTheRegion) {
    Watched watched(usual(), 10);
    Random random(4);
    for (int i = 0; i < 60; ++i) {
        watched.settings.speed = 100 * random.uniform(0.1, 2);
        watched.run(random.uniform(0, 1));
    }
    const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
    EXPECT_GE(*low, 10);
    EXPECT_LE(*high, 40);
    EXPECT_LE(watched.hardest, 1000 * 1.01);
    EXPECT_FALSE(watched.late);
}

// With ends inside, at and outside of the dead points.
TEST(Oscillation, AHoldAtADeadPointStandsThereWithinOneStrokeAndGoesOn) {
    Random random(11);
    for (const double offset : {-0.1, 0.0, 0.2})
        for (double when = 0.5; when < 3; when += 0.0131) {
            SCOPED_TRACE(when);
            Watched watched(usual());
            watched.offset[0] = watched.offset[1] = offset;
            watched.run(when);
            watched.hold = Stop::dead_point;
            watched.run(3 * pi * 30 / (2 * 100) + 0.05);  // the last moment of a stroke, and the next one
            ASSERT_TRUE(watched.it.held());
            const double place = watched.it.position();
            const double inside = std::min(place - 10, 40 - place);
            ASSERT_NEAR(inside, std::max(-offset, 0.0), 1e-9);
            watched.run(random.uniform(0, 0.3));
            ASSERT_EQ(watched.it.position(), place);
            watched.hold = Stop::none;
            const std::size_t before = watched.arrivals.size();
            watched.until([&] { return watched.arrivals.size() > before + 1; });
            ASSERT_EQ(watched.arrivals[before].upper, place < 25);
            ASSERT_LE(watched.hardest, 1000 * 1.01);
        }
}

TEST(Oscillation, AHoldAtTheEndStandsThereAndTheStrokesGoOnAfterIt) {
    for (const double end : {50.0, 5.0, 40.0, 30.0})
        for (double when = 0.003; when < 3; when += 0.0131) {
            SCOPED_TRACE(when);
            Oscillation::Settings settings = usual();
            settings.end_position = end;
            Watched watched(settings, end);
            watched.run(when);
            watched.hold = Stop::end_position;
            watched.until([&] { return watched.it.held(); });
            ASSERT_EQ(watched.it.position(), end);
            watched.run(0.2);
            ASSERT_EQ(watched.it.position(), end);
            watched.hold = Stop::none;
            const std::size_t before = watched.arrivals.size();
            watched.until([&] { return watched.arrivals.size() > before + 3; });
            ASSERT_LE(watched.hardest, 1000 * 1.01);
            ASSERT_LE(watched.samples.size() * dt, 5 + when);
        }
}

// Each phase of the way, each time that it lasts, and one that changes its kind.
TEST(Oscillation, AHoldThatEndsAnywhereLeavesNothingBehind) {
    Random random(12);
    const Stop kinds[] = {Stop::dead_point, Stop::end_position, Stop::at_once};
    for (int run = 0; run < 600; ++run) {
        SCOPED_TRACE(run);
        Watched watched(usual());
        watched.offset[0] = watched.offset[1] = random.uniform(-0.2, 0.2);
        for (int i = 0; i < 4; ++i) {
            watched.run(random.uniform(0, 2));
            for (int changes = random.index(3); changes >= 0; --changes) {
                watched.hold = kinds[random.index(3)];
                watched.run(random.uniform(0, 1));
            }
            watched.hold = Stop::none;
        }
        const std::size_t before = watched.arrivals.size();
        watched.run(4);
        ASSERT_GE(watched.arrivals.size(), before + 4);
        const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
        ASSERT_GE(*low, 10 - 0.2 - 1e-9);
        ASSERT_LE(*high, 50 + 1e-9);
        ASSERT_LE(watched.hardest, 1000 * 1.01);
    }
}

// As from an analogue input.
TEST(Oscillation, ASpeedThatChangesInEachPeriodDelaysNoStroke) {
    Watched watched(usual(), 10);
    Random random(9);
    for (int i = 0; i < 5000; ++i) {
        watched.settings.speed = 100 * random.uniform(0.99, 1.01);
        watched.step();
    }
    EXPECT_EQ(watched.arrivals.size(), static_cast<std::size_t>(5 / (pi * 0.15)));
    EXPECT_FALSE(watched.late);
}

// Everything at once, drawn: nothing breaks the acceleration or leaves all regions.
TEST(Oscillation, NoSequenceOfCommandsBreaksALimitOrLeavesItsRegions) {
    Random random(7);
    for (int run = 0; run < 150; ++run) {
        SCOPED_TRACE(run);
        Oscillation::Settings settings = usual();
        settings.sections[0] = {SpeedSection::height, 15, random.uniform(16, 30), random.uniform(0.2, 3)};
        settings.sections[1] = {SpeedSection::phase, 5.5, random.uniform(0, 0.5), random.uniform(0.2, 2)};
        Watched watched(settings, random.uniform(0, 50));
        double lowest = watched.it.position(), highest = std::max(lowest, settings.end_position);
        const auto widen = [&] {
            lowest = std::min(lowest, watched.settings.lower);
            highest = std::max(highest, watched.settings.upper);
        };
        widen();
        for (int i = 0; i < 40; ++i) {
            switch (random.index(8)) {
                case 0: {
                    const Stop kinds[] = {Stop::at_once, Stop::dead_point, Stop::end_position};
                    watched.hold = kinds[random.index(3)];
                    break;
                }
                case 1: watched.hold = Stop::none; break;
                case 2: watched.settings.speed = random.uniform(10, 300); break;
                case 3:
                    watched.settings.lower = random.uniform(-20, 30);
                    watched.settings.upper = watched.settings.lower + random.uniform(5, 40);
                    break;
                case 4: watched.settings.upper_dwell = random.uniform(0, 0.1); break;
                case 5: watched.settings.sections[0].ratio = random.uniform(0.2, 3); break;
                case 6:
                    if (random.uniform() < 0.3) {
                        const Stop kinds[] = {Stop::at_once, Stop::dead_point, Stop::withdraw, Stop::lower,
                                              Stop::upper};
                        watched.stop(kinds[random.index(5)]);
                    }
                    break;
                case 7: {
                    const double share = random.uniform();
                    watched.settings.exact_stop = random.uniform(0, 0.1);
                    watched.there = [&random, share] { return random.uniform() < share; };
                    break;
                }
            }
            widen();
            if (watched.it.state() == State::rest) watched.it.start(watched.settings, watched.it.position());
            watched.run(random.uniform(0, 0.6));
        }
        EXPECT_LE(watched.hardest, 1000 * 1.01);
        const auto [low, high] = std::minmax_element(watched.samples.begin(), watched.samples.end());
        EXPECT_GE(*low, lowest - 1e-9);
        EXPECT_LE(*high, highest + 1e-9);
    }
}

// Else an infeed would act on it before the first stroke.
TEST(Oscillation, AStartForgetsTheLastArrival) {
    Watched its(usual());
    its.until([&] { return its.it.arrival().happened; });
    its.it.freeze(its.it.position());
    its.it.start(usual(), its.it.position());
    EXPECT_FALSE(its.it.arrival().happened);
}

}  // namespace
}  // namespace plumb
