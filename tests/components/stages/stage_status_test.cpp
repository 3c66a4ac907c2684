// SPDX-License-Identifier: GPL-2.0-or-later
// Each status of each stage, the bad ones first.
#include "components/stages/axis_offset/axis_offset_status.hpp"
#include "components/stages/interlock/interlock_status.hpp"
#include "components/stages/joint_offset/joint_offset_status.hpp"
#include "tests/support/status_cases.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

using hal::Common;
using hal::Kind;
using support::expect_all;
using support::expect_in_order;
using support::of;

TEST(JointOffsetStatus, IsGoodOnlyWhileTheJointHasItsOffset) {
    using S = JointOffsetStatus;
    JointOffsetSeen applies;
    applies.enabled = applies.on = applies.homed = applies.asked = true;
    expect_all(expect_in_order<JointOffsetSeen, S>(
        applies,
        {{"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"off", [](auto& its) { its.enabled = false; }, of<S>(Common::off), Kind::off},
         {"the machine is off", [](auto& its) { its.on = false; }, of<S>(Common::machine_off), Kind::wait},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"a soft limit", [](auto& its) { its.limited = true; }, S::limited, Kind::warn},
         {"the way", [](auto& its) { its.ramping = true; }, S::ramping, Kind::wait},
         {"no source", [](auto& its) { its.asked = false; }, S::nothing, Kind::off},
         {"nothing", [](auto&) {}, S::applies, Kind::good}}));
}

TEST(AxisOffsetStatus, IsGoodOnlyWhileTheAxisHasItsOffset) {
    using S = AxisOffsetStatus;
    AxisOffsetSeen applies;
    applies.enabled = applies.on = applies.homed = applies.armed = applies.asked = true;
    expect_all(expect_in_order<AxisOffsetSeen, S>(
        applies,
        {{"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"a probing move with the offset in force", [](auto& its) { its.refused = true; }, S::refused,
          Kind::warn},
         {"the machine is off", [](auto& its) { its.on = false; }, of<S>(Common::machine_off), Kind::wait},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"the way back", [](auto& its) { its.takes_back = its.asked = true; }, S::takes_back, Kind::wait},
         {"off",
          [](auto& its) {
              its.enabled = its.ramping = false;
              its.takes_back = false;
          },
          of<S>(Common::off), Kind::off},
         {"no cycle since the machine was turned on",
          [](auto& its) {
              its.enabled = its.lacks = true;
              its.armed = false;
          },
          S::waits, Kind::wait},
         {"a probing move", [](auto& its) { its.armed = its.lacks = its.probing = true; },
          of<S>(Common::probing), Kind::wait},
         {"a soft limit",
          [](auto& its) {
              its.limited = true;
              its.probing = false;
          },
          S::limited, Kind::warn},
         {"the way", [](auto& its) { its.ramping = true; }, S::ramping, Kind::wait},
         {"no source", [](auto& its) { its.asked = false; }, S::nothing, Kind::off},
         {"nothing", [](auto&) {}, S::applies, Kind::good}}));
}

TEST(InterlockStatus, IsGoodOnlyWhileAllCompensate) {
    using S = InterlockStatus;
    InterlockSeen permits;
    permits.on = permits.machine_on = permits.homed = true;
    expect_all(expect_in_order<InterlockSeen, S>(
        permits,
        {{"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"the feed is held", [](auto& its) { its.holds = true; }, S::holds, Kind::warn},
         {"all off", [](auto& its) { its.on = false; }, S::nothing_on, Kind::off},
         {"a service is missing", [](auto& its) { its.withholds = its.on = true; }, S::withholds, Kind::warn},
         {"the machine is off", [](auto& its) { its.machine_on = false; }, of<S>(Common::machine_off),
          Kind::wait},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"a fault of a stage", [](auto& its) { its.stage_fault = true; }, S::stage_fault, Kind::bad},
         {"suspended", [](auto& its) { its.suspended = true; }, of<S>(Common::suspended), Kind::wait},
         {"a probing move", [](auto& its) { its.probing = true; }, of<S>(Common::probing), Kind::wait},
         {"the way", [](auto& its) { its.settles = true; }, S::settles, Kind::wait},
         {"an axis lacks its offset", [](auto& its) { its.stage_lacks = true; }, S::stage_lacks, Kind::wait},
         {"a soft limit", [](auto& its) { its.stage_limited = true; }, S::stage_limited, Kind::warn},
         {"nothing", [](auto&) {}, S::permits, Kind::good}}));
}

TEST(StageStatus, HasNoneThatInterlockGivesAFunction) {
    for (std::int32_t number = -1; number < hal::first_own; ++number) {
        const char* const its = said(static_cast<JointOffsetStatus>(number)).sentence;
        EXPECT_STREQ(its, said(static_cast<AxisOffsetStatus>(number)).sentence);
        EXPECT_STREQ(its, said(static_cast<InterlockStatus>(number)).sentence);
        EXPECT_FALSE(its && hal::is_of_service(number)) << number;
    }
}

}  // namespace
}  // namespace plumb
