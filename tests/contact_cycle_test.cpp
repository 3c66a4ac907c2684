// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact_cycle.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr std::int32_t program = 7;

ContactReference reference(const ContactKey& key, double coordinate) {
    ContactReference r;
    r.key = key;
    r.contact.coordinate = coordinate;
    r.contact.feed = -2;
    r.program = program;
    return r;
}

struct Cut {
    std::int32_t operation;
    std::int32_t tool;
    double coordinate;
};

// Three operations with two tools; the last one plunges twice.
const std::vector<Cut> part{{10, 1, -20}, {20, 2, -40}, {30, 1, -20}, {30, 1, -25}};

void learn(ContactCycle& cycle, const std::vector<Cut>& cuts, bool complete = true) {
    cycle.begin(true);
    for (const Cut& cut : cuts)
        cycle.learn(reference(cycle.approach(cut.operation, cut.tool), cut.coordinate));
    cycle.end(complete);
}

TEST(ContactCycle, FindsThePartnerOfEachContact) {
    ContactCycle cycle;
    learn(cycle, part);
    cycle.begin(false);
    for (const Cut& cut : part) {
        const ContactReference* partner = cycle.partner(cycle.approach(cut.operation, cut.tool));
        ASSERT_TRUE(partner);
        EXPECT_EQ(partner->contact.coordinate, cut.coordinate);
    }
    EXPECT_EQ(cycle.end(true).missed, 0);
}

// Trap: with a running index one missed contact turns into a correction of 20 mm.
TEST(ContactCycle, RunningIndexTurnsAMissedContactInto20MillimetresOursIntoAMissedOne) {
    ContactCycle ours;
    learn(ours, part);
    ours.begin(false);
    std::size_t index = 0;
    std::vector<double> literal_corrections, corrections;
    for (const Cut& cut : part) {
        if (cut.operation == 20) continue;  // an air cut
        const double now = cut.coordinate + 15 * um;
        literal_corrections.push_back(now - part[index++].coordinate);
        const ContactReference* partner = ours.partner(ours.approach(cut.operation, cut.tool));
        ASSERT_TRUE(partner);
        corrections.push_back(now - partner->contact.coordinate);
    }
    EXPECT_NEAR(literal_corrections[1], 20, 0.1);
    for (const double correction : corrections) EXPECT_NEAR(correction, 15 * um, 1e-9);
    EXPECT_EQ(ours.end(true).missed, 1);
}

TEST(ContactCycle, EachCycleMissesForItself) {
    ContactCycle cycle;
    learn(cycle, part);
    cycle.begin(false);
    for (const Cut& cut : part) cycle.partner(cycle.approach(cut.operation, cut.tool));
    EXPECT_EQ(cycle.end(true).missed, 0);
    cycle.begin(false);
    EXPECT_EQ(cycle.end(true).missed, 4);
}

TEST(ContactCycle, AContactThatWasNotLearntHasNoPartner) {
    ContactCycle cycle;
    learn(cycle, part);
    cycle.begin(false);
    EXPECT_FALSE(cycle.partner(cycle.approach(10, 3))) << "another tool";
    EXPECT_FALSE(cycle.partner(cycle.approach(40, 1))) << "another operation";
    EXPECT_TRUE(cycle.partner(cycle.approach(10, 1)));
    EXPECT_FALSE(cycle.partner(cycle.approach(10, 1))) << "once more than learnt";
}

// Trap: the source tests for the end of the program only after a contact.
TEST(ContactCycle, EndSeenOnlyAfterAContactCarriesOnIntoTheNextCycleOursEndsInAnyState) {
    ContactCycle ours;
    learn(ours, part);
    int literal_index = 0;
    bool literal_ended = false;
    for (int n = 0; n < 2; ++n) {
        // The program is aborted after its first contact; the literal reading does not notice before the
        // next.
        ours.begin(false);
        literal_ended = false;
        const bool cycle_running_after_the_contact = true;
        ++literal_index;
        literal_ended = !cycle_running_after_the_contact;
        ours.partner(ours.approach(10, 1));
        EXPECT_EQ(ours.end(false).missed, 0) << "what an aborted cycle would have met is not known";
        EXPECT_FALSE(ours.running());
    }
    EXPECT_FALSE(literal_ended);
    EXPECT_EQ(literal_index, 2) << "the first contact of a cycle is paired with the second of the reference";
    ours.begin(false);
    EXPECT_EQ(ours.approach(10, 1).occurrence, 1);
}

// Trap: ... and what an aborted learning cycle leaves counts as a reference.
TEST(ContactCycle, LearningInPlaceLeavesHalfAReferenceOursNone) {
    std::vector<Cut> literal;
    ContactCycle ours;
    ours.begin(true);
    for (int i = 0; i < 2; ++i) {
        literal.push_back(part[i]);
        ours.learn(reference(ours.approach(part[i].operation, part[i].tool), part[i].coordinate));
    }
    ours.end(false);
    EXPECT_EQ(literal.size(), 2u) << "half a reference";
    EXPECT_FALSE(ours.valid_for(program));
    EXPECT_EQ(ours.references().size(), 0);
}

TEST(ContactCycle, AnAbortedLearningCycleLeavesTheReferenceBeforeInForce) {
    ContactCycle cycle;
    learn(cycle, part);
    learn(cycle, {{10, 1, -99}}, false);
    EXPECT_EQ(cycle.references().size(), 4);
    EXPECT_EQ(cycle.references()[0].contact.coordinate, -20);
}

TEST(ContactCycle, ACompleteLearningCycleReplacesTheReference) {
    ContactCycle cycle;
    learn(cycle, part);
    learn(cycle, {{10, 1, -21}});
    ASSERT_EQ(cycle.references().size(), 1);
    EXPECT_EQ(cycle.references()[0].contact.coordinate, -21);
}

TEST(ContactCycle, WithoutAContactNothingIsLearnt) {
    ContactCycle cycle;
    learn(cycle, part);
    learn(cycle, {});
    EXPECT_EQ(cycle.references().size(), 4);
}

TEST(ContactCycle, ASpoiltLearningCycleGivesNothingTheNextOneDoes) {
    ContactCycle cycle;
    cycle.begin(true);
    cycle.learn(reference(cycle.approach(10, 1), -20));
    cycle.spoil();
    cycle.end(true);
    EXPECT_FALSE(cycle.valid_for(program));
    learn(cycle, part);
    EXPECT_TRUE(cycle.valid_for(program));
}

TEST(ContactCycle, MoreContactsThanFitGiveNoReference) {
    ContactCycle cycle;
    std::vector<Cut> many;
    for (int i = 0; i < ContactReferences::capacity; ++i) many.push_back({i, 1, -20});
    learn(cycle, many);
    EXPECT_EQ(cycle.references().size(), ContactReferences::capacity);
    cycle.forget();
    many.push_back({1000, 1, -20});
    learn(cycle, many);
    EXPECT_EQ(cycle.references().size(), 0);
}

TEST(ContactCycle, AnotherProgramInvalidatesTheReference) {
    ContactCycle cycle;
    EXPECT_FALSE(cycle.valid_for(program));
    learn(cycle, part);
    EXPECT_TRUE(cycle.valid_for(program));
    EXPECT_FALSE(cycle.valid_for(program + 1));
}

TEST(ContactCycle, RestoresWhatItShowed) {
    ContactCycle first, second;
    learn(first, part);
    for (std::int32_t i = 0; i < first.references().size(); ++i)
        EXPECT_TRUE(second.restore(first.references()[i], program));
    EXPECT_TRUE(second.valid_for(program));
    second.begin(false);
    for (const Cut& cut : part) {
        const ContactReference* partner = second.partner(second.approach(cut.operation, cut.tool));
        ASSERT_TRUE(partner);
        EXPECT_EQ(partner->contact.coordinate, cut.coordinate);
    }
}

TEST(ContactCycle, RefusesToRestoreWhatCannotBeRight) {
    ContactCycle cycle;
    const ContactReference good = reference({10, 1, 1}, -20);
    EXPECT_FALSE(cycle.restore(good, program + 1)) << "another program";
    EXPECT_TRUE(cycle.restore(good, program));
    EXPECT_FALSE(cycle.restore(good, program)) << "doubled";
    ContactReference bad = reference({20, 1, 1}, -20);
    bad.key.occurrence = 0;
    EXPECT_FALSE(cycle.restore(bad, program));
    bad = reference({20, 1, 1}, -20);
    bad.contact.feed = 2;
    EXPECT_FALSE(cycle.restore(bad, program)) << "fed away from the work";
    for (double Contact::*field : {&Contact::coordinate, &Contact::time, &Contact::lost_time, &Contact::feed,
                                   &Contact::feed_override, &Contact::applied_offset, &Contact::sigma})
        for (const double value : {std::numeric_limits<double>::quiet_NaN(), -1e308}) {
            bad = reference({20, 1, 1}, -20);
            bad.contact.*field = value;
            EXPECT_FALSE(cycle.restore(bad, program));
        }
    cycle.begin(true);
    EXPECT_FALSE(cycle.restore(reference({20, 1, 1}, -20), program)) << "while learning";
    EXPECT_EQ(cycle.references().size(), 1);
}

}  // namespace
}  // namespace plumb
