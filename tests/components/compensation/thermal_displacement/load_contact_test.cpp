// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

namespace plumb {
namespace {

using Event = LoadContact::Event;

constexpr double um = 1e-3;  // mm

DisplacementSettings settings() {
    DisplacementSettings s;
    s.smoothing = 0;
    return s;
}

// The report of a drive of a spindle that idles at 5 % and cuts: a first-order lag, noise, and all events
// on the way, sample by sample.
struct Drive {
    double dt = 0.001;
    double lag = 0.03;
    double noise = 0;
    double idle = 5;

    LoadContact detector{};
    DisplacementSettings used = settings();
    std::mt19937 generator{1};
    double time = 0;
    double cutting = 0;  // %, behind the lag
    double speed = 3000;
    std::vector<Event> events{};  // contacts, blanked ones too
    std::vector<double> times{};  // s, of each

    double sample(double step) {
        cutting += (step - cutting) * -std::expm1(-dt / lag);
        return idle + cutting + (noise > 0 ? std::normal_distribution<double>(0, noise)(generator) : 0);
    }

    // Runs with a load step of so many percent.
    void run(double seconds, Travel travel, double step = 0) {
        for (int i = 0; i < std::lround(seconds / dt); ++i) feed(sample(step), travel);
    }
    void feed(double load, Travel travel) {
        time += dt;
        const Event event = detector.step(load, speed, travel, used, dt);
        if (event == Event::rise) rise_at = time - detector.since_rise();
        if (event != Event::contact && event != Event::blanked) return;
        events.push_back(event);
        times.push_back(rise_at);
    }
    double rise_at = 0;

    void settle() {
        run(3, Travel::other);
        run(0.5, Travel::clear);
        run(1, Travel::towards_work);
    }
    // Seconds from the true contact to the reported one.
    double delay(double step) {
        settle();
        const double contact = time;
        run(0.3, Travel::towards_work, step);
        return times.empty() ? std::numeric_limits<double>::quiet_NaN() : times.back() - contact;
    }
};

TEST(LoadContact, IsFoundWhereTheLaggedStepCrossesTheThreshold) {
    Drive drive;
    EXPECT_NEAR(drive.delay(8), -0.03 * std::log(1 - 1 / 8.0), 1e-3);
    EXPECT_EQ(drive.events, std::vector<Event>{Event::contact});
}

TEST(LoadContact, IsInterpolatedBetweenSamples) {
    for (const double dt : {0.0005, 0.001, 0.002, 0.004}) {
        Drive drive{dt};
        EXPECT_NEAR(drive.delay(8), -0.03 * std::log(1 - 1 / 8.0), 0.3e-3) << dt;
    }
}

TEST(LoadContact, DependsLessOnTheLoadThanAtMidHeight) {
    const auto shift = [](double threshold) {
        Drive usual, soft;
        usual.used.threshold = soft.used.threshold = threshold;
        return soft.delay(6.4) - usual.delay(8);
    };
    const double feed = 100.0 / 60;  // mm/s
    EXPECT_NEAR(feed * shift(4), 14 * um, 3 * um) << "the disease";
    EXPECT_LT(feed * shift(1), 2.5 * um);
}

// Trap: a level test counts one cut hundreds of times.
TEST(LoadContact, LevelTestCountsACutHundredsOfTimesOursOnce) {
    Drive drive;
    drive.noise = 0.3;
    drive.settle();
    int literal = 0;
    for (int i = 0; i < 1000; ++i) {
        const double load = drive.sample(8);
        literal += load > 5 + 4;
        drive.feed(load, Travel::towards_work);
    }
    EXPECT_GT(literal, 900);
    EXPECT_EQ(drive.events, std::vector<Event>{Event::contact});
}

TEST(LoadContact, ACutThatComesAndGoesInOneApproachCountsOnce) {
    Drive drive;
    drive.settle();
    for (int i = 0; i < 5; ++i) {
        drive.run(0.3, Travel::towards_work, 8);
        drive.run(0.3, Travel::towards_work, 0);
    }
    EXPECT_EQ(drive.events.size(), 1u);
    drive.run(0.2, Travel::clear);
    drive.run(0.5, Travel::towards_work);
    drive.run(0.3, Travel::towards_work, 8);
    EXPECT_EQ(drive.events.size(), 2u);
}

TEST(LoadContact, ARiseShorterThanTheDebounceTimeIsNone) {
    Drive drive;
    drive.lag = 0.001;
    drive.settle();
    drive.run(0.01, Travel::towards_work, 8);
    drive.run(0.5, Travel::towards_work);
    EXPECT_TRUE(drive.events.empty());
    drive.run(0.3, Travel::towards_work, 8);
    EXPECT_EQ(drive.events.size(), 1u) << "and does not spend the approach";
}

TEST(LoadContact, NoiseAloneIsNone) {
    Drive drive;
    for (const double noise : {0.1, 0.3, 1.0}) {
        drive.noise = noise;
        drive.run(600, Travel::towards_work);
        EXPECT_NEAR(drive.detector.noise(), noise, 0.1 * noise);
    }
    EXPECT_TRUE(drive.events.empty());
}

TEST(LoadContact, ADrillThatEntersSlowlyDoesNotHideTheNextCut) {
    Drive drive;
    drive.noise = 0.05;
    drive.run(5, Travel::towards_work);
    for (const double rate : {1.2, 6.0}) {  // %/s
        for (int ms = 0; ms < 2500; ++ms) drive.run(0.001, Travel::towards_work, rate * ms / 1000);
        drive.run(0.5, Travel::other);
        drive.run(3, Travel::clear);
        drive.run(3, Travel::towards_work);
    }
    drive.events.clear();
    drive.run(0.5, Travel::towards_work, 1.25);
    EXPECT_EQ(drive.events, std::vector{Event::contact});
}

TEST(LoadContact, CountsOnlyWhileZFeedsTowardsTheWork) {
    for (const Travel travel : {Travel::other, Travel::clear}) {
        Drive drive;
        drive.settle();
        drive.run(1, travel, 8);
        EXPECT_TRUE(drive.events.empty());
    }
}

TEST(LoadContact, ACutEnteredFromTheSideIsNoContactWhenZFeedsLater) {
    Drive drive;
    drive.settle();
    drive.run(2, Travel::other, 8);
    drive.run(2, Travel::towards_work, 8);
    EXPECT_TRUE(drive.events.empty());
}

// Trap: a contact that falls into the blanking window is reported when the window ends.
TEST(LoadContact, GatingTheOutputReportsABlankedContactLateOursNever) {
    Drive drive;
    drive.settle();
    drive.speed = 4000;
    const double command = drive.time;
    const double contact = command + 1.5;
    double literal = 0;
    for (int i = 0; i < 4000; ++i) {
        const double load = drive.sample(drive.time < contact ? 0 : 8);
        const bool blanked = drive.time < command + settings().blanking_time;
        if (literal == 0 && !blanked && load > 5 + 1) literal = drive.time;
        drive.feed(load, Travel::towards_work);
    }
    EXPECT_NEAR(literal - contact, 1, 0.01) << "1 s late: 1.7 mm at 100 mm/min";
    EXPECT_EQ(drive.events, std::vector<Event>{Event::blanked});
}

TEST(LoadContact, AContactThatIsBlankedInPartIsBlanked) {
    Drive early;
    early.settle();
    early.speed += 100;
    early.run(settings().blanking_time - 0.01, Travel::towards_work);
    early.run(0.3, Travel::towards_work, 8);
    EXPECT_EQ(early.events, std::vector<Event>{Event::blanked}) << "it began within the window";
    Drive late;
    late.settle();
    late.run(0.01, Travel::towards_work, 8);
    late.speed += 100;
    late.run(0.3, Travel::towards_work, 8);
    EXPECT_EQ(late.events, std::vector<Event>{Event::blanked}) << "the window began before it was confirmed";
}

TEST(LoadContact, AfterBlankingTheNewIdleLoadIsTheBaseline) {
    Drive drive;
    drive.settle();
    drive.speed = 6000;
    drive.idle = 80;  // acceleration
    drive.run(1.5, Travel::other);
    drive.idle = 13;
    drive.run(1.5, Travel::other);
    drive.run(1, Travel::towards_work);
    EXPECT_TRUE(drive.events.empty());
    const double contact = drive.time;
    drive.run(0.3, Travel::towards_work, 8);
    ASSERT_EQ(drive.events, std::vector<Event>{Event::contact});
    EXPECT_NEAR(drive.times[0] - contact, 0.004, 1e-3);
}

TEST(LoadContact, ABaselineThatWandersIsFollowed) {
    Drive drive;
    drive.settle();
    for (int minute = 0; minute < 10; ++minute) {
        drive.idle -= 0.3;
        drive.run(60, Travel::towards_work);
    }
    EXPECT_TRUE(drive.events.empty());
    EXPECT_NEAR(drive.delay(8), 0.004, 1e-3);
}

TEST(LoadContact, CoolantSwitchedOnAboveTheWorkIsNotACut) {
    Drive drive;
    drive.settle();
    drive.idle += 2;
    drive.run(0.5, Travel::clear);
    EXPECT_FALSE(drive.detector.in_work());
    EXPECT_NEAR(drive.delay(8), 0.004, 1e-3);
    EXPECT_EQ(drive.events.size(), 1u);
}

TEST(LoadContact, TheToolIsInTheWorkUntilTheLoadFallsOrZIsClear) {
    for (const bool retracts : {true, false}) {
        Drive drive;
        drive.settle();
        EXPECT_FALSE(drive.detector.in_work());
        drive.run(0.3, Travel::towards_work, 8);
        EXPECT_TRUE(drive.detector.in_work());
        drive.run(300, Travel::other, 8);
        EXPECT_TRUE(drive.detector.in_work()) << "the baseline must not creep up to a long cut";
        drive.run(0.2, retracts ? Travel::clear : Travel::other, retracts ? 8 : 0);
        EXPECT_FALSE(drive.detector.in_work());
    }
}

TEST(LoadContact, AChangeOfSpeedInTheWorkDoesNotHideTheCut) {
    Drive drive;
    drive.settle();
    drive.run(0.3, Travel::towards_work, 8);
    drive.speed = 3500;
    drive.run(20, Travel::other, 8);
    EXPECT_TRUE(drive.detector.in_work());
    drive.run(0.1, Travel::clear);
    EXPECT_FALSE(drive.detector.in_work());
}

TEST(LoadContact, SpinningUpIsNotACut) {
    Drive drive;
    drive.settle();
    drive.speed = 6000;
    drive.idle = 100;
    drive.run(1, Travel::other);
    EXPECT_FALSE(drive.detector.in_work());
}

TEST(LoadContact, AfterALostLoadContactsAreBlankedForAWhile) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e308, -1e308}) {
        Drive drive;
        drive.settle();
        drive.feed(bad, Travel::towards_work);
        drive.run(0.3, Travel::towards_work, 8);
        EXPECT_EQ(drive.events, std::vector<Event>{Event::blanked}) << bad;
        drive.run(3, Travel::clear);
        EXPECT_NEAR(drive.delay(8), 0.004, 1e-3);
        EXPECT_EQ(drive.events.back(), Event::contact);
        EXPECT_TRUE(std::isfinite(drive.detector.noise()));
    }
}

TEST(LoadContact, ARiseEndsWithALostLoad) {
    Drive drive;
    drive.settle();
    drive.run(0.01, Travel::towards_work, 8);
    drive.feed(std::numeric_limits<double>::quiet_NaN(), Travel::towards_work);
    drive.run(0.3, Travel::other, 8);
    EXPECT_TRUE(drive.events.empty());
}

TEST(LoadContact, ALoadThatIsLostInTheWorkLeavesTheToolThere) {
    Drive drive;
    drive.settle();
    drive.run(0.3, Travel::towards_work, 8);
    drive.feed(std::numeric_limits<double>::quiet_NaN(), Travel::other);
    drive.run(10, Travel::other, 8);
    EXPECT_TRUE(drive.detector.in_work());
    drive.feed(std::numeric_limits<double>::quiet_NaN(), Travel::clear);
    EXPECT_FALSE(drive.detector.in_work());
}

}  // namespace
}  // namespace plumb
