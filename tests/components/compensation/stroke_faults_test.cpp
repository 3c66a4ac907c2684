// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_faults.hpp"

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

TEST(StrokeFaults, ShowsTheCheckedStrokeFirstThenAnEventThenWhatLasts) {
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
    it.check(Fault::region);
    EXPECT_EQ(it.first(now), Fault::region);
    EXPECT_EQ(it.checked(), Fault::region);
    it.check(Fault::none);
    EXPECT_EQ(it.first(now), Fault::lags) << "nothing is asked for any more";
}

}  // namespace
}  // namespace plumb
