// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/program_lock.hpp"

#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

// Contacts of one gauge on a machine that grows; the offset follows the estimate by a filter of gain
// `weight`.
struct Machine {
    Random random{7};
    double noise = 0.8 * um, weight = 0.5;
    double growth = 0, drift = 0;  // mm, and mm a contact that the prediction does not know
    double estimate = 0, offset = 0;
    ProgramLock lock{};

    void contact(bool of_program) {
        growth += drift;
        const double displacement = (of_program ? offset : growth) + noise * random.gaussian();
        lock.add(displacement, estimate, offset, noise);
        estimate += weight * (displacement - estimate);
        if (std::abs(estimate - offset) > 2 * um) offset = estimate;  // the tolerance
    }
};

TEST(ProgramLock, KnowsAnEventOfTheProgramThatMovesTheOffset) {
    Machine machine;
    machine.noise = 2 * um;
    int contacts = 0;
    for (; !machine.lock.locked() && contacts < 400; ++contacts) machine.contact(true);
    EXPECT_LT(contacts, 300);
}

TEST(ProgramLock, AMachineThatWasOffShowsItInAFewContacts) {
    for (const bool of_program : {true, false}) {
        Machine machine;
        machine.growth = machine.offset = machine.estimate = 50 * um;
        for (int i = 0; i < 8; ++i) machine.contact(of_program);
        const double before = machine.estimate;
        machine.offset = 0;
        machine.contact(of_program);
        machine.offset = before;
        for (int i = 0; i < 3; ++i) machine.contact(of_program);
        EXPECT_EQ(machine.lock.locked(), of_program);
    }
}

TEST(ProgramLock, TakesNoContactForAnEvent) {
    for (const double drift : {0.0, 0.3 * um, 3 * um}) {
        for (const double noise : {0.3 * um, 1 * um, 5 * um}) {
            for (const double weight : {0.1, 0.5, 1.0}) {
                Machine machine;
                machine.noise = noise;
                machine.weight = weight;
                machine.drift = drift;
                for (int i = 0; i < 1000; ++i) {
                    machine.contact(false);
                    ASSERT_FALSE(machine.lock.locked()) << drift << " " << noise << " " << weight << " " << i;
                }
            }
        }
    }
}

TEST(ProgramLock, ADeliberateStepOfTheOffsetShowsItAtOnce) {
    const ProgramLock lock;
    EXPECT_TRUE(lock.follows(21 * um, 1 * um, 20 * um));
    EXPECT_FALSE(lock.follows(2 * um, 1 * um, 20 * um));
    EXPECT_FALSE(lock.follows(2 * um, 1 * um, 0)) << "there was no step";
}

}  // namespace
}  // namespace plumb
