// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/authority.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

const Authority::Settings settings{1, 2, 0, 100};

double part(const Authority::Evidence& evidence) {
    return Authority().step(evidence, false, settings);
}

TEST(Authority, IsWholeWhenSureAndNothingWhenNot) {
    EXPECT_EQ(part({50, 1, 0, 1}), 1);
    EXPECT_EQ(part({50, 0, 0, 1}), 1);
    EXPECT_EQ(part({50, 30, 0, 1}), 0);  // 0.8 standard deviations from harm
    EXPECT_EQ(part({50, 1, 200, 1}), 0);
    EXPECT_EQ(part({50, 1, 0, 0.1}), 0);
}

TEST(Authority, IsContinuousInEachDoubt) {
    Authority by_sigma, by_age, by_agreement;
    double last[] = {1, 1, 1};
    for (int i = 0; i <= 10000; ++i) {
        const double x = i / 10000.0;
        const double now[] = {by_sigma.step({50, 1 + 60 * x, 0, 1}, false, settings),
                              by_age.step({50, 1, 250 * x, 1}, false, settings),
                              by_agreement.step({50, 1, 0, 1 - x}, false, settings)};
        for (int j = 0; j < 3; ++j) {
            EXPECT_LE(now[j], last[j]);
            EXPECT_LT(last[j] - now[j], 0.01);
            last[j] = now[j];
        }
    }
    for (const double end : last) EXPECT_EQ(end, 0);
}

TEST(Authority, NoiseAtAnEdgeDoesNotMoveIt) {
    Authority authority;
    authority.step({50, 16.0, 0, 1}, false, settings);
    authority.step({50, 16.5, 0, 1}, false, settings);
    const double before = authority.part();
    ASSERT_GT(before, 0.1);
    ASSERT_LT(before, 0.9);
    for (int i = 0; i < 100; ++i) authority.step({50, i % 2 ? 16.0 : 16.5, 0, 1}, false, settings);
    EXPECT_EQ(authority.part(), before);
}

TEST(Authority, InTheWorkItRisesAndNeverFalls) {
    Authority authority;
    authority.step({50, 18, 0, 1}, false, settings);
    const double before = authority.part();
    EXPECT_EQ(authority.step({50, 60, 500, 0}, true, settings), before);
    EXPECT_EQ(authority.step({50, 1, 0, 1}, true, settings), 1);
    EXPECT_EQ(authority.step({50, 60, 500, 0}, true, settings), 1);
    EXPECT_EQ(authority.step({50, 60, 500, 0}, false, settings), 0);
}

TEST(Authority, ValuesThatAreNotFiniteCountForNothing) {
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e308}) {
        EXPECT_EQ(part({50, bad, 0, 1}), 0) << bad;
        EXPECT_EQ(part({50, 1, bad, 1}), 0) << bad;
        EXPECT_EQ(part({50, 1, 0, -bad}), 0) << bad;
        Authority after;
        after.step({bad, bad, bad, bad}, false, settings);
        EXPECT_EQ(after.step({50, 1, 0, 1}, false, settings), 1) << "it recovers from " << bad;
    }
}

}  // namespace
}  // namespace plumb
