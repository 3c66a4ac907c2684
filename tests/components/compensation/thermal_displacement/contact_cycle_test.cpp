// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_cycle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr double largest_sigma = 15 * um;
constexpr MachiningSetup setup{7, 3};
constexpr MachiningSetup other_program{8, 3}, other_tools{7, 4};

ContactReference reference(const ContactKey& key, double coordinate) {
    ContactReference r;
    r.key = key;
    r.contact.coordinate = coordinate;
    r.contact.feed = -2;
    r.contact.time_constant = 0.03;
    r.setup = setup;
    return r;
}

struct Cut {
    std::int32_t operation;
    std::int32_t tool;
    double coordinate;
};

// Three operations with two tools; the last one plunges twice.
const std::vector<Cut> part{{10, 1, -20}, {20, 2, -40}, {30, 1, -20}, {30, 1, -25}};

void begin(ContactCycle& cycle) {
    cycle.begin(false, setup);
}

ContactCycle::Ended end(ContactCycle& cycle, bool complete = true) {
    return cycle.end(complete, Method::coordinate, 1, largest_sigma);
}

// A learning cycle, one of `wanted`. Contacts within 0.1 mm of their partner agree with it.
ContactCycle::Ended learn(ContactCycle& cycle, const std::vector<Cut>& cuts, bool complete = true,
                          std::int32_t wanted = 1, const MachiningSetup& with = setup) {
    cycle.begin(true, with);
    for (const Cut& cut : cuts) {
        ContactReference now = reference(cycle.approach(cut.operation, cut.tool), cut.coordinate);
        now.setup = with;
        const ContactReference* partner = cycle.partner(now.key);
        cycle.learn(now, partner && std::abs(partner->contact.coordinate - cut.coordinate) <= 0.1);
    }
    return cycle.end(complete, Method::coordinate, wanted, largest_sigma);
}

TEST(ContactCycle, FindsThePartnerOfEachContact) {
    ContactCycle cycle;
    learn(cycle, part);
    begin(cycle);
    for (const Cut& cut : part) {
        const ContactReference* partner = cycle.partner(cycle.approach(cut.operation, cut.tool));
        ASSERT_TRUE(partner);
        EXPECT_EQ(partner->contact.coordinate, cut.coordinate);
    }
    EXPECT_EQ(end(cycle).missed, 0);
}

// Trap: with a running index one missed contact turns into a correction of 20 mm.
TEST(ContactCycle, RunningIndexTurnsAMissedContactInto20MillimetresOursIntoAMissedOne) {
    ContactCycle ours;
    learn(ours, part);
    begin(ours);
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
    EXPECT_EQ(end(ours).missed, 1);
}

TEST(ContactCycle, EachCycleMissesForItself) {
    ContactCycle cycle;
    learn(cycle, part);
    begin(cycle);
    for (const Cut& cut : part) cycle.partner(cycle.approach(cut.operation, cut.tool));
    EXPECT_EQ(end(cycle).missed, 0);
    begin(cycle);
    EXPECT_EQ(end(cycle).missed, 4);
}

TEST(ContactCycle, AContactThatWasNotLearntHasNoPartner) {
    ContactCycle cycle;
    learn(cycle, part);
    begin(cycle);
    EXPECT_FALSE(cycle.partner(cycle.approach(10, 3))) << "another tool";
    EXPECT_FALSE(cycle.partner(cycle.approach(40, 1))) << "another operation";
    EXPECT_TRUE(cycle.partner(cycle.approach(10, 1)));
    EXPECT_FALSE(cycle.partner(cycle.approach(10, 1))) << "once more than learned";
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
        begin(ours);
        literal_ended = false;
        const bool cycle_running_after_the_contact = true;
        ++literal_index;
        literal_ended = !cycle_running_after_the_contact;
        ours.partner(ours.approach(10, 1));
        EXPECT_EQ(end(ours, false).missed, 0) << "the rest of an aborted cycle is unknown";
        EXPECT_FALSE(ours.running());
    }
    EXPECT_FALSE(literal_ended);
    EXPECT_EQ(literal_index, 2) << "the first contact of a cycle is paired with the second of the reference";
    begin(ours);
    EXPECT_EQ(ours.approach(10, 1).occurrence, 1);
}

// Trap: ... and the contacts of an aborted learning cycle count as a reference.
TEST(ContactCycle, LearningInPlaceLeavesHalfAReferenceOursNone) {
    std::vector<Cut> literal;
    ContactCycle ours;
    ours.begin(true, setup);
    for (int i = 0; i < 2; ++i) {
        literal.push_back(part[i]);
        ours.learn(reference(ours.approach(part[i].operation, part[i].tool), part[i].coordinate), false);
    }
    end(ours, false);
    EXPECT_EQ(literal.size(), 2u) << "half a reference";
    EXPECT_FALSE(ours.references().made_with(setup));
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
    cycle.begin(true, setup);
    cycle.learn(reference(cycle.approach(10, 1), -20), false);
    cycle.spoil();
    end(cycle);
    EXPECT_FALSE(cycle.references().made_with(setup));
    learn(cycle, part);
    EXPECT_TRUE(cycle.references().made_with(setup));
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
    EXPECT_FALSE(cycle.references().made_with(setup));
    learn(cycle, part);
    EXPECT_TRUE(cycle.references().made_with(setup));
    EXPECT_FALSE(cycle.references().made_with(other_program));
}

std::vector<Cut> shifted(double height) {
    std::vector<Cut> cuts = part;
    for (Cut& cut : cuts) cut.coordinate += height;
    return cuts;
}

TEST(ContactCycle, AReferenceOfSeveralCyclesIsTheirMean) {
    ContactCycle cycle;
    learn(cycle, shifted(4 * um), true, 3);
    EXPECT_EQ(cycle.learnt(), 1);
    learn(cycle, shifted(0), true, 3);
    EXPECT_EQ(cycle.learnt(), 2);
    EXPECT_EQ(cycle.references().size(), 0) << "not complete yet";
    learn(cycle, shifted(8 * um), true, 3);
    EXPECT_EQ(cycle.learnt(), 0);
    ASSERT_EQ(cycle.references().size(), 4);
    for (std::int32_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(cycle.references()[i].contact.coordinate, part[i].coordinate + 4 * um, 1e-12);
        EXPECT_NEAR(cycle.references()[i].scatter, 4 * um, 1e-12);
        EXPECT_EQ(cycle.references()[i].cycles, 3);
    }
}

TEST(ContactCycle, TheNextReferenceBeginsAgain) {
    ContactCycle cycle;
    for (int n = 0; n < 2; ++n) learn(cycle, part, true, 2);
    learn(cycle, shifted(50 * um), true, 2);
    EXPECT_EQ(cycle.references()[0].contact.coordinate, -20)
        << "that before stays until the next is complete";
    learn(cycle, shifted(50 * um), true, 2);
    EXPECT_NEAR(cycle.references()[0].contact.coordinate, -20 + 50 * um, 1e-12);
}

TEST(ContactCycle, AnAbortedCycleAddsNothingToTheMeanAndTakesNothingAway) {
    ContactCycle cycle;
    learn(cycle, part, true, 2);
    EXPECT_EQ(learn(cycle, {{10, 1, -20 + 90 * um}}, false, 2).fault, LearningFault::aborted);
    EXPECT_EQ(cycle.learnt(), 1);
    learn(cycle, part, true, 2);
    ASSERT_EQ(cycle.references().size(), 4);
    EXPECT_EQ(cycle.references()[0].contact.coordinate, -20);
    EXPECT_EQ(cycle.references()[0].scatter, 0);
}

TEST(ContactCycle, AMeanKeepsWhatAllCyclesHadAndWhatAgreed) {
    ContactCycle cycle;
    learn(cycle, part, true, 3);
    EXPECT_EQ(learn(cycle, {part[0], part[2], part[3], {50, 1, -30}}, true, 3).missed, 1);
    learn(cycle, {part[0], part[1], {30, 1, -20 + 0.2}, part[3]}, true, 3);
    ASSERT_EQ(cycle.references().size(), 2);
    EXPECT_EQ(cycle.references()[0].key, (ContactKey{10, 1, 1}));
    EXPECT_EQ(cycle.references()[1].key, (ContactKey{30, 1, 2}));
    EXPECT_EQ(cycle.references()[1].contact.coordinate, -25);
}

TEST(ContactCycle, ACycleThatAgreesInNothingBeginsANewMean) {
    ContactCycle cycle;
    learn(cycle, part, true, 2);
    EXPECT_EQ(learn(cycle, shifted(0.2), true, 2).fault, LearningFault::none);
    EXPECT_EQ(cycle.learnt(), 1);
    learn(cycle, shifted(0.2), true, 2);
    ASSERT_EQ(cycle.references().size(), 4);
    EXPECT_NEAR(cycle.references()[0].contact.coordinate, -19.8, 1e-12);
}

TEST(ContactCycle, AnotherSetupACycleWithoutLearningOrForgettingEndsTheMean) {
    for (const MachiningSetup& other : {other_program, other_tools}) {
        ContactCycle cycle;
        learn(cycle, part, true, 2);
        learn(cycle, part, true, 2, other);
        EXPECT_EQ(cycle.learnt(), 1);
        EXPECT_EQ(cycle.references().size(), 0);
    }
    ContactCycle interrupted;
    learn(interrupted, part, true, 2);
    begin(interrupted);
    end(interrupted);
    EXPECT_EQ(interrupted.learnt(), 0);

    ContactCycle forgotten;
    learn(forgotten, part, true, 2);
    forgotten.begin(true, setup);
    for (const Cut& cut : part) {
        const ContactReference now =
            reference(forgotten.approach(cut.operation, cut.tool), cut.coordinate - 50 * um);
        forgotten.learn(now, forgotten.partner(now.key) != nullptr);
    }
    forgotten.forget();
    EXPECT_EQ(forgotten.end(true, Method::coordinate, 2, largest_sigma).fault, LearningFault::none);
    EXPECT_EQ(forgotten.learnt(), 1) << "it begins with the cycle in which it was forgotten";
}

TEST(ContactCycle, RestoresWhatItShowed) {
    ContactCycle first, second;
    learn(first, part);
    for (std::int32_t i = 0; i < first.references().size(); ++i)
        EXPECT_TRUE(second.restore(first.references()[i]));
    EXPECT_TRUE(second.references().made_with(setup));
    begin(second);
    for (const Cut& cut : part) {
        const ContactReference* partner = second.partner(second.approach(cut.operation, cut.tool));
        ASSERT_TRUE(partner);
        EXPECT_EQ(partner->contact.coordinate, cut.coordinate);
    }
}

TEST(ContactCycle, RestoresEightProgramsAndRefusesANinth) {
    ContactCycle cycle;
    ContactReference row = reference({10, 1, 1}, -20);
    for (std::int32_t i = 0; i < 9; ++i) {
        row.setup = {100 + i / 2, i % 2};
        EXPECT_EQ(cycle.restore(row), i < 8) << i;
    }
    EXPECT_EQ(cycle.rows(), 8);
    for (std::int32_t i = 0; i < 8; ++i) EXPECT_EQ(cycle.row(i).setup.program, 100 + i / 2);
}

TEST(ContactCycle, RefusesToRestoreWhatCannotBeRight) {
    ContactCycle cycle;
    const ContactReference good = reference({10, 1, 1}, -20);
    EXPECT_TRUE(cycle.restore(good));
    EXPECT_FALSE(cycle.restore(good)) << "doubled";
    ContactReference bad = reference({20, 1, 1}, -20);
    bad.key.occurrence = 0;
    EXPECT_FALSE(cycle.restore(bad));
    bad = reference({20, 1, 1}, -20);
    bad.common_sigma = -1;
    EXPECT_FALSE(cycle.restore(bad));
    bad = reference({20, 1, 1}, -20);
    bad.cycles = 0;
    EXPECT_FALSE(cycle.restore(bad)) << "the mean of nothing";
    bad = reference({20, 1, 1}, -20);
    bad.date = -1;
    EXPECT_FALSE(cycle.restore(bad));
    bad = reference({20, 1, 1}, -20);
    bad.contact.feed = 2;
    EXPECT_FALSE(cycle.restore(bad)) << "fed away from the work";
    bad = reference({20, 1, 1}, -20);
    bad.contact.time_constant = 0;
    EXPECT_FALSE(cycle.restore(bad)) << "not fitted";
    for (double Contact::*field :
         {&Contact::coordinate, &Contact::time, &Contact::lost_time, &Contact::feed, &Contact::feed_override,
          &Contact::applied_offset, &Contact::sigma, &Contact::time_constant})
        for (const double value : {std::numeric_limits<double>::quiet_NaN(), -1e308}) {
            bad = reference({20, 1, 1}, -20);
            bad.contact.*field = value;
            EXPECT_FALSE(cycle.restore(bad));
        }
    for (double ContactReference::*field :
         {&ContactReference::speed_history, &ContactReference::temperature, &ContactReference::scatter}) {
        bad = reference({20, 1, 1}, -20);
        bad.*field = std::numeric_limits<double>::quiet_NaN();
        EXPECT_FALSE(cycle.restore(bad));
    }
    cycle.begin(true, setup);
    EXPECT_FALSE(cycle.restore(reference({20, 1, 1}, -20))) << "while learning";
    EXPECT_EQ(cycle.references().size(), 1);
}

}  // namespace
}  // namespace plumb
