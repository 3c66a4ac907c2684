// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/contact_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Contact contact() {
    Contact c;
    c.coordinate = -20;
    c.time = 0.3;
    c.feed = -10;
    return c;
}

Rejection of(Method method, const Contact& now) {
    return comparison(method, now, contact(), DisplacementSettings());
}

TEST(ContactRejection, AcceptsTheSameFeedNearTheReference) {
    Contact now = contact();
    now.coordinate += 30 * um;
    now.time -= 0.003;
    EXPECT_EQ(of(Method::coordinate, now), Rejection::none);
    EXPECT_EQ(of(Method::time, now), Rejection::none);
}

TEST(ContactRejection, AnotherFeedOrOverrideIsRejectedByTimeAndFarOneByCoordinate) {
    for (const double part : {0.4, 0.9, 1.1, 1.6}) {
        const bool near = part > 0.5 && part < 1.5;
        Contact slow = contact(), overridden = contact();
        slow.feed *= part;
        overridden.feed_override = part;
        for (const Contact& now : {slow, overridden}) {
            EXPECT_EQ(of(Method::time, now), Rejection::feed_differs) << part;
            EXPECT_EQ(of(Method::coordinate, now), near ? Rejection::none : Rejection::feed_differs) << part;
        }
    }
}

TEST(ContactRejection, AnotherFeedCostsCertaintyByWhatTheLoadIsLate) {
    Contact reference = contact(), slow = contact();
    reference.time_constant = 0.02;
    EXPECT_EQ(feed_sigma(slow, reference), 0);
    slow.feed *= 0.7;
    EXPECT_NEAR(feed_sigma(slow, reference), 0.3 * std::abs(reference.feed) * 0.005, 1e-12);
}

TEST(ContactRejection, OutsideItsWindowItIsNotThatContact) {
    Contact deep = contact();
    deep.coordinate -= 0.51;
    EXPECT_EQ(of(Method::coordinate, deep), Rejection::outside_window);
    EXPECT_EQ(of(Method::time, deep), Rejection::outside_window);
}

TEST(ContactRejection, WithoutAClockThereIsNoTime) {
    Contact now = contact();
    now.time = 0;
    EXPECT_EQ(of(Method::time, now), Rejection::no_clock);
    EXPECT_EQ(comparison(Method::time, contact(), now, DisplacementSettings()), Rejection::no_clock);
    EXPECT_EQ(of(Method::coordinate, now), Rejection::none);
}

TEST(ContactRejection, WhatIsNotANumberIsRejected) {
    for (double Contact::*field : {&Contact::coordinate, &Contact::feed, &Contact::feed_override}) {
        Contact now = contact();
        now.*field = not_a_number;
        EXPECT_NE(of(Method::coordinate, now), Rejection::none);
    }
    for (double Contact::*field : {&Contact::time, &Contact::lost_time}) {
        Contact now = contact();
        now.*field = not_a_number;
        EXPECT_NE(of(Method::time, now), Rejection::none);
    }
}

// A plunge at 600 mm/min, seen by a clock from program start and by a literal reading of it. Before it
// there is `wait`, for example a tool change; on its way there may be a hold or an override.
struct Plunge {
    double wait = 5;      // s
    double hold = 0;      // s
    double override = 1;  // over half of the way

    Contact contact() const {
        constexpr double dt = 0.001;
        ApproachClock clock;
        clock.start();
        const auto run = [&](double seconds, double velocity) {
            for (int i = 0; i < std::lround(seconds / dt); ++i) clock.step(velocity, dt);
        };
        run(wait, 0);
        run(0.15 / override, -10 * override);
        run(hold, 0);
        run(0.15, -10);
        Contact c = plumb::contact();
        c.time = clock.time();
        c.lost_time = clock.lost_time(-10);
        return c;
    }
};

// Trap: from program start, every dwell, tool change, hold and override is taken for growth.
TEST(ContactRejection, ProgramClockTakesDelaysForGrowthOursRejectsThem) {
    const Contact reference = Plunge{}.contact();
    const auto literal = [&](const Contact& now) { return now.feed * (now.time - reference.time); };
    const auto ours = [&](const Contact& now) {
        return comparison(Method::time, now, reference, DisplacementSettings());
    };
    EXPECT_EQ(ours(Plunge{}.contact()), Rejection::none);

    EXPECT_NEAR(literal(Plunge{5.02}.contact()), -200 * um, 1e-9) << "20 ms of a tool change are 0.2 mm";
    EXPECT_EQ(ours(Plunge{5.02}.contact()), Rejection::time_differs);

    EXPECT_NEAR(literal(Plunge{5, 0.1}.contact()), -1000 * um, 1e-9) << "a feed hold";
    EXPECT_EQ(ours(Plunge{5, 0.1}.contact()), Rejection::time_differs);

    EXPECT_NEAR(literal(Plunge{5, 0, 0.75}.contact()), -500 * um, 1e-9) << "an override for half of the way";
    EXPECT_EQ(ours(Plunge{5, 0, 0.75}.contact()), Rejection::time_differs);
}

// Trap: an override that lasts must not be scaled away silently.
TEST(ContactRejection, OverrideAtTheContactIsGrowthToTheLiteralReadingOursRejectsIt) {
    Contact now = contact();
    now.feed = -9;
    now.time = 0.3 / 0.9;
    EXPECT_NEAR(contact().feed * (now.time - contact().time), -333 * um, 1 * um);
    EXPECT_NEAR(now.feed * (now.time - contact().time), -300 * um, 1 * um) << "nor does its own feed help";
    EXPECT_EQ(of(Method::time, now), Rejection::feed_differs);
}

}  // namespace
}  // namespace plumb
