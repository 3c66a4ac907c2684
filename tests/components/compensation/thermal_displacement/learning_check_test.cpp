// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_cycle.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

struct Learnt {
    int tool;
    double sigma, time_constant;
};

std::vector<bool> refused(const std::vector<Learnt>& contacts) {
    ContactReferences references;
    for (const Learnt& learnt : contacts) {
        ContactReference reference;
        reference.key = {10 * (references.size() + 1), learnt.tool, 1};
        reference.contact.sigma = learnt.sigma;
        reference.contact.time_constant = learnt.time_constant;
        references.add(reference);
    }
    const LearningCheck check(references, 15 * um);
    std::vector<bool> result;
    for (std::int32_t i = 0; i < references.size(); ++i) result.push_back(check.refuses(i));
    return result;
}

TEST(LearningCheck, ContactsOfAToolThatAgreeAreLearnt) {
    EXPECT_EQ(refused({{1, 2 * um, 0.02}, {1, 4 * um, 0.04}, {2, 1 * um, 0.005}}), std::vector<bool>(3));
}

TEST(LearningCheck, OfTwoThatDisagreeNeitherIsLearnt) {
    EXPECT_EQ(refused({{1, 2 * um, 0.084}, {1, 2 * um, 0.005}, {2, 1 * um, 0.02}}),
              (std::vector<bool>{true, true, false}));
}

TEST(LearningCheck, OfThreeTheOddOneIsNotLearnt) {
    EXPECT_EQ(refused({{1, 2 * um, 0.02}, {1, 2 * um, 0.09}, {1, 2 * um, 0.022}}),
              (std::vector<bool>{false, true, false}));
    EXPECT_EQ(refused({{1, 2 * um, 0.02}, {1, 9 * um, 0.02}, {1, 2 * um, 0.022}}),
              (std::vector<bool>{false, true, false}));
}

TEST(LearningCheck, APoorContactIsNotLearntEvenAlone) {
    EXPECT_EQ(refused({{1, 16 * um, 0.02}, {2, 14 * um, 0.02}}), (std::vector<bool>{true, false}));
}

}  // namespace
}  // namespace plumb
