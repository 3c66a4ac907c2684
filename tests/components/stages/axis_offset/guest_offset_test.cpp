// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/axis_offset/external_offset.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

using Given = GuestOffset::Given;
constexpr std::int32_t highest = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t lowest = std::numeric_limits<std::int32_t>::min();

TEST(GuestOffset, StepsCountWithTheScaleThatTheyComeWith) {
    GuestOffset guest;
    guest.listen({500, 0.01}, true, 0);  // where it begins is no step
    EXPECT_EQ(guest.request(), 0);
    guest.listen({600, 0.01}, true, 0);
    EXPECT_DOUBLE_EQ(guest.request(), 1);
    guest.listen({600, 5}, true, 0);
    EXPECT_DOUBLE_EQ(guest.request(), 1);
    guest.listen({602, -0.5}, true, 0);
    EXPECT_DOUBLE_EQ(guest.request(), 0);
}

TEST(GuestOffset, StepsThatAreNotTakenAreLost) {
    GuestOffset guest;
    guest.listen({0, 1}, true, 0);
    guest.listen({10, 1}, false, 0);
    guest.listen({11, 1}, true, 0);
    EXPECT_EQ(guest.request(), 1);
    guest.listen({20, 1, true, true}, true, 0);
    EXPECT_EQ(guest.request(), 0);
    guest.listen({22, 1}, true, 0);
    EXPECT_EQ(guest.request(), 2);
    guest.forget();
    EXPECT_EQ(guest.request(), 0);
}

TEST(GuestOffset, DisabledItIsWhereItStands) {
    GuestOffset guest;
    guest.listen({0, 1}, true, 0);
    guest.listen({10, 1}, true, 3);
    guest.listen({50, 1, false, true}, true, 3);  // nor does it listen to clear
    EXPECT_EQ(guest.request(), 3);
    EXPECT_TRUE(guest.held());
    guest.listen({51, 1}, true, 3);
    EXPECT_EQ(guest.request(), 4);
}

TEST(GuestOffset, AnUnhomedMachineIsCleared) {
    GuestOffset guest;
    guest.listen({0, 1}, true, 0);
    guest.listen({10, 1}, true, 0);
    guest.listen({10, 1, true, true}, false, 10);
    EXPECT_EQ(guest.request(), 0);
    guest.listen({10, 1}, true, 10);
    EXPECT_EQ(guest.request(), 0);
}

TEST(GuestOffset, CountsWrapAround) {
    GuestOffset guest;
    guest.listen({highest, 0.5}, true, 0);
    guest.listen({lowest, 0.5}, true, 0);
    EXPECT_EQ(guest.request(), 0.5);
    EXPECT_TRUE(guest.good());
}

TEST(GuestOffset, ABadStepWaits) {
    for (const Given& bad : {Given{11, 0}, Given{11, std::numeric_limits<double>::quiet_NaN()},
                             Given{11, 1e9}, Given{highest, 1}, Given{lowest, 1}}) {
        GuestOffset guest;
        guest.listen({0, 1}, true, 0);
        guest.listen({10, 1}, true, 0);
        guest.listen(bad, true, 0);
        EXPECT_FALSE(guest.good());
        EXPECT_EQ(guest.request(), 10);
        guest.listen({11, 1}, true, 0);
        EXPECT_TRUE(guest.good());
        EXPECT_EQ(guest.request(), 11);
    }
}

}  // namespace
}  // namespace plumb
