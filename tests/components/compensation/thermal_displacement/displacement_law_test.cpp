// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

// A tool that is fed to the work from 3 mm above it.  +Z points away from the work.
struct Approach {
    double growth = 0;
    double offset = 0;
    double feed = -10;  // mm/s

    static constexpr double top = -20;           // mm, of the work
    static constexpr double start_height = -17;  // mm, where the clock starts, without offset

    Contact contact() const {
        Contact c;
        c.coordinate = top + growth;
        c.time = (start_height + offset - c.coordinate) / -feed;
        c.feed = feed;
        c.applied_offset = offset;
        return c;
    }
    double tip_error() const { return offset - growth; }  // of the cut; 0 in a reference made cold
};

const Contact cold = Approach{}.contact();

TEST(DisplacementLaw, AWarmSpindleReachesTheWorkHigherAndEarlier) {
    const Contact warm = Approach{30 * um}.contact();
    EXPECT_GT(warm.coordinate, cold.coordinate);
    EXPECT_LT(warm.time, cold.time);
}

TEST(DisplacementLaw, EitherMethodGivesAnOffsetThatLeavesNoError) {
    for (const Method method : {Method::coordinate, Method::time}) {
        for (const double g : {30 * um, -12 * um}) {
            Approach warm{g};
            for (int cycle = 0; cycle < 5; ++cycle) {
                warm.offset = growth(method, warm.contact(), cold);
                EXPECT_NEAR(warm.tip_error(), 0, 1e-6 * um);
            }
        }
    }
}

TEST(DisplacementLaw, AnOffsetUnderTheReferenceIsAccountedFor) {
    const Contact reference = Approach{10 * um, 4 * um}.contact();
    const Contact now = Approach{25 * um, 7 * um}.contact();
    EXPECT_NEAR(growth(Method::coordinate, now, reference), 15 * um, 1e-9);
    EXPECT_NEAR(growth(Method::time, now, reference), 15 * um, 1e-9);
}

TEST(DisplacementLaw, AStageThatDoesNotFollowDoesNotMakeTheTimeMethodRunAway) {
    const Approach warm{15 * um, 0};
    for (int cycle = 0; cycle < 5; ++cycle)
        EXPECT_NEAR(growth(Method::time, warm.contact(), cold), 15 * um, 1e-9);
}

// Trap: the flow chart of the source is drawn for a machine whose + points to the work.
TEST(DisplacementLaw, SignOfTheFlowChartDoublesTheErrorOursRemovesIt) {
    Approach literal{30 * um};
    const double rate = 10;  // mm/s, a magnitude as in the flow chart
    literal.offset += rate * (literal.contact().time - cold.time);
    EXPECT_NEAR(literal.tip_error(), -60 * um, 1e-9);

    Approach ours{30 * um};
    ours.offset += displacement_by_time(ours.contact(), cold);
    EXPECT_NEAR(ours.tip_error(), 0, 1e-9);
}

// Trap: the displacement has its sign from the signed feed, and is then subtracted once more.
TEST(DisplacementLaw, SignedAndThenSubtractedDoublesTheErrorOursRemovesIt) {
    Approach literal{30 * um};
    const double displacement = literal.feed * (literal.contact().time - cold.time);
    literal.offset -= displacement;
    EXPECT_NEAR(literal.tip_error(), -60 * um, 1e-9);

    Approach ours{30 * um};
    ours.offset = growth(Method::time, ours.contact(), cold);
    EXPECT_NEAR(ours.tip_error(), 0, 1e-9);
}

// Trap: the source multiplies ms by mm/s; the product is um, and a metre too long as mm.
TEST(DisplacementLaw, MillisecondsGiveMicrometresOursTakesSeconds) {
    Approach literal{30 * um};
    const double milliseconds = 1000 * (literal.contact().time - cold.time);
    literal.offset += literal.feed * milliseconds;
    EXPECT_NEAR(literal.tip_error(), 30 - 30 * um, 1e-6);

    EXPECT_NEAR(displacement_by_time(Approach{30 * um}.contact(), cold), 30 * um, 1e-9);
}

// Trap: a machine coordinate contains the offset, so that each cycle measures all of the growth again.
TEST(DisplacementLaw, AddingCoordinatesRunsAwayOursStays) {
    Approach literal{15 * um};
    Approach ours{15 * um};
    for (int cycle = 1; cycle <= 10; ++cycle) {
        literal.offset += literal.contact().coordinate - cold.coordinate;
        EXPECT_NEAR(literal.offset, cycle * 15 * um, 1e-9);

        ours.offset = displacement_by_coordinate(ours.contact(), cold);
        EXPECT_NEAR(ours.offset, 15 * um, 1e-9);
    }
}

}  // namespace
}  // namespace plumb
