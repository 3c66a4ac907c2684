// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(StrokeFaults, OneThatHappenedLastsUntilTheNextStart) {
    StrokeFaults it;
    it.happen(Fault::region);
    EXPECT_EQ(it.first({}), Fault::region);
    it.happen(Fault::none);
    EXPECT_EQ(it.first({}), Fault::none);
}

TEST(StrokeFaults, ShowsWhatHappenedFirstThenWhatLasts) {
    StrokeFaults it;
    StrokeFaults::Lasting now;
    now.supervised = Fault::drift;
    EXPECT_EQ(it.first(now), Fault::drift);
    now.bound = true;
    EXPECT_EQ(it.first(now), Fault::bound);
    now.settings = Fault::lead;
    EXPECT_EQ(it.first(now), Fault::lead);
    now.position = true;
    EXPECT_EQ(it.first(now), Fault::position);
    it.happen(Fault::lags);
    EXPECT_EQ(it.first(now), Fault::lags);
    it.check(false, Fault::region);
    EXPECT_EQ(it.first(now), Fault::lags) << "nothing is asked for";
    it.check(true, Fault::region);
    EXPECT_EQ(it.checked(), Fault::region);
    it.check(false, Fault::none);
    EXPECT_EQ(it.checked(), Fault::none);
    EXPECT_EQ(it.first(now), Fault::region) << "somebody has to read it";
    it.check(true, Fault::not_ready, false);
    EXPECT_EQ(it.checked(), Fault::not_ready);
    EXPECT_EQ(it.first(now), Fault::region) << "another fault is shown, and this one is not told later";
    it.check(true, Fault::none);
    EXPECT_EQ(it.first(now), Fault::position) << "this stroke is possible";
}

}  // namespace
}  // namespace plumb
