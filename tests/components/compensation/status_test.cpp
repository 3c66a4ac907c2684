// SPDX-License-Identifier: GPL-2.0-or-later
// Each status of each function, the bad ones first: what is seen gives one status, whatever else is true.
#include "components/compensation/axis_growth/axis_growth_codes.hpp"
#include "components/compensation/chopping/chopping_status.hpp"
#include "components/compensation/squareness/squareness_codes.hpp"
#include "components/compensation/thermal_displacement/displacement_status.hpp"
#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "components/stages/interlock/functions.hpp"
#include "tests/support/status_cases.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace plumb {
namespace {

using hal::Common;
using hal::Kind;
using support::expect_all;
using support::expect_in_order;
using support::of;

constexpr Sum retain = 1, link = 2, task = 16, function = 1;

// Function 0, and the services that it misses.
struct FunctionSeen {
    FunctionSums its;
    Sum lost_services = 0, late_services = 0;
};

TEST(FunctionStatus, NamesTheFirstThatKeepsAFunctionFromActing) {
    struct Case {
        const char* what;
        std::function<void(FunctionSeen&)> change;
        Common status;
    };
    const auto withdrawn = [](Sum services) {
        return [services](FunctionSeen& seen) {
            seen.its.enabled = 0;
            seen.its.lost = function;
            seen.lost_services = services;
        };
    };
    const Case cases[] = {
        {"the operator has it off, whatever is lost",
         [&](FunctionSeen& seen) {
             withdrawn(retain)(seen);
             seen.its.on = 0;
         },
         Common::off},
        {"retain has died", withdrawn(retain | task), hal::of_service(Common::lost, 0)},
        {"task has died", withdrawn(task), hal::of_service(Common::lost, 4)},
        {"retain has died, and the program goes on",
         [&](FunctionSeen& seen) {
             withdrawn(retain)(seen);
             seen.its.enabled = function;
         },
         hal::of_service(Common::ending, 0)},
        {"linuxcnc_link is not ready, and the program goes on",
         [&](FunctionSeen& seen) {
             seen.its.lost = function;
             seen.late_services = link;
         },
         hal::of_service(Common::ending, 1)},
        {"linuxcnc_link is not ready",
         [](FunctionSeen& seen) {
             seen.its.enabled = 0;
             seen.late_services = link;
         },
         hal::of_service(Common::late, 1)},
        {"a lost service is back", withdrawn(0), Common::renew},
        {"functions are in a wrong order", [](FunctionSeen& seen) { seen.its.in_order = 0; }, Common::order},
        {"it is not heard",
         [](FunctionSeen& seen) {
             seen.its.silent = seen.its.suspended = function;
             seen.its.enabled = 0;
         },
         Common::unpermitted},
        {"a stage is not heard",
         [](FunctionSeen& seen) {
             seen.its.silent_stages = seen.its.suspended = function;
             seen.its.enabled = 0;
         },
         Common::stage_fault},
        {"the program suspends it",
         [](FunctionSeen& seen) {
             seen.its.enabled = seen.its.machine_on = 0;
             seen.its.suspended = function;
         },
         Common::suspended},
        {"the tool is not clear",
         [](FunctionSeen& seen) {
             seen.its.leaves = function;
             seen.its.machine_on = 0;
         },
         Common::leaves},
        {"it waits for commissioning",
         [](FunctionSeen& seen) {
             seen.its.held = function;
             seen.its.enabled = 0;
         },
         Common::uncommissioned},
        {"a stage waits for commissioning",
         [](FunctionSeen& seen) {
             seen.its.held = seen.its.held_stages = function;
             seen.its.enabled = 0;
         },
         Common::stage_uncommissioned},
        {"the machine is off",
         [](FunctionSeen& seen) {
             seen.its.machine_on = seen.its.homed = 0;
             seen.its.stages_with_fault = function;
         },
         Common::machine_off},
        {"the machine is not homed",
         [](FunctionSeen& seen) {
             seen.its.homed = 0;
             seen.its.stages_that_lack = function;
         },
         Common::not_homed},
        {"the switch was turned on in a probing move", [](FunctionSeen& seen) { seen.its.enabled = 0; },
         Common::probing},
        {"a stage has a fault",
         [](FunctionSeen& seen) { seen.its.stages_with_fault = seen.its.stages_that_lack = function; },
         Common::stage_fault},
        {"an axis lacks its offset",
         [](FunctionSeen& seen) { seen.its.stages_that_lack = seen.its.stages_limited = function; },
         Common::stage_lacks},
        {"a stroke that its position lacks", [](FunctionSeen& seen) { seen.its.at_point_r = function; },
         Common::at_point_r},
        {"a soft limit", [](FunctionSeen& seen) { seen.its.stages_limited = function; },
         Common::stage_limited},
        {"nobody", [](FunctionSeen&) {}, Common::none},
    };
    for (const Case& each : cases) {
        FunctionSeen seen;
        seen.its.on = seen.its.enabled = function;
        each.change(seen);
        EXPECT_EQ(reason(seen.its, 0, seen.lost_services, seen.late_services), each.status) << each.what;
    }
}

TEST(CommonStatus, HasASentenceForEachServiceAndNoneElsewhere) {
    for (const Common kind : {Common::late, Common::lost, Common::ending})
        for (std::int32_t number = 0; number < hal::services; ++number) {
            const hal::Said its = said(hal::of_service(kind, number));
            EXPECT_NE(std::string(its.sentence).find("ervice " + std::to_string(number)), std::string::npos);
            EXPECT_STRNE(its.remedy, "");
        }
    for (const std::int32_t number : {-2147483647 - 1, -1, 0, 40, 98, 100, 2147483647})
        EXPECT_FALSE(hal::is_common(number)) << number;
}

SquarenessSeen correcting() {
    SquarenessSeen its;
    its.set = its.enabled = its.homed = true;
    return its;
}

TEST(SquarenessStatus, SaysThatItCorrectsOnlyWhileItDoes) {
    using S = SquarenessStatus;
    expect_all(expect_in_order<SquarenessSeen, S>(
        correcting(),
        {{"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"no angle", [](auto& its) { its.set = false; }, S::nothing_set, Kind::off},
         {"off in the emergency stop",
          [](auto& its) {
              its.interlock = of<S>(Common::machine_off);
              its.homed = false;
          },
          of<S>(Common::machine_off), Kind::wait},
         {"off without interlock", [](auto& its) { its.enabled = false; }, of<S>(Common::off), Kind::off},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"tilts that displace nothing", [](auto& its) { its.without_effect = true; }, S::without_effect,
          Kind::warn},
         {"a bound", [](auto& its) { its.bounded = true; }, S::bounded, Kind::warn},
         {"a cut in doubt", [](auto& its) { its.cut_in_doubt = true; }, S::cut_in_doubt, Kind::warn},
         {"the way", [](auto& its) { its.ramping = true; }, S::ramping, Kind::wait},
         {"settling ended too early", [](auto& its) { its.unsettled = true; }, S::unsettled, Kind::warn},
         {"a doubtful direction", [](auto& its) { its.doubtful = true; }, S::doubtful, Kind::wait},
         {"nothing", [](auto&) {}, S::corrects, Kind::good}}));
}

AxisGrowthSeen growing() {
    AxisGrowthSeen its;
    its.has_law = its.enabled = its.homed = its.temperatures_known = true;
    return its;
}

TEST(AxisGrowthStatus, SaysThatItCorrectsOnlyWhileItDoes) {
    using S = AxisGrowthStatus;
    expect_all(expect_in_order<AxisGrowthSeen, S>(
        growing(),
        {{"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"no law", [](auto& its) { its.has_law = false; }, S::no_law, Kind::off},
         {"task has died", [](auto& its) { its.interlock = of<S>(hal::of_service(Common::lost, 4)); },
          of<S>(hal::of_service(Common::lost, 4)), Kind::bad},
         {"off without interlock", [](auto& its) { its.enabled = false; }, of<S>(Common::off), Kind::off},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"a sensor never was valid", [](auto& its) { its.temperatures_known = false; }, S::no_temperature,
          Kind::bad},
         {"a sensor is lost for long", [](auto& its) { its.returns = true; }, S::returns, Kind::bad},
         {"a sensor is lost", [](auto& its) { its.held = true; }, S::held, Kind::warn},
         {"a bound", [](auto& its) { its.bounded = true; }, S::bounded, Kind::warn},
         {"the way", [](auto& its) { its.ramping = true; }, S::ramping, Kind::wait},
         {"a revoked law", [](auto& its) { its.revoked = true; }, S::revoked, Kind::warn},
         {"a bore that may have moved", [](auto& its) { its.moved = true; }, S::moved, Kind::warn},
         {"a large sigma", [](auto& its) { its.uncertain = true; }, S::uncertain, Kind::warn},
         {"nothing", [](auto&) {}, S::corrects, Kind::good}}));
}

DisplacementSeen working() {
    DisplacementSeen its;
    its.enabled = its.has_reference = its.has_rows = its.known = true;
    return its;
}

TEST(DisplacementStatus, SaysThatItWorksOnlyWhileItDoes) {
    using S = DisplacementStatus;
    expect_all(expect_in_order<DisplacementSeen, S>(
        working(),
        {{"a fault", [](auto& its) { its.fault = DisplacementDetail::load; }, of<S>(Common::fault), Kind::bad},
         {"retain has died",
          [](auto& its) {
              its.interlock = of<S>(hal::of_service(Common::lost, 0));
              its.enabled = false;
          },
          of<S>(hal::of_service(Common::lost, 0)), Kind::bad},
         {"retain is late",
          [](auto& its) {
              its.interlock = of<S>(hal::of_service(Common::late, 0));
              its.enabled = false;
          },
          of<S>(hal::of_service(Common::late, 0)), Kind::warn},
         {"a lost service is back",
          [](auto& its) {
              its.interlock = of<S>(Common::renew);
              its.enabled = false;
          },
          of<S>(Common::renew), Kind::bad},
         {"off",
          [](auto& its) {
              its.interlock = of<S>(Common::off);
              its.enabled = false;
          },
          of<S>(Common::off), Kind::off},
         {"off without interlock",
          [](auto& its) {
              its.interlock = S{};
              its.enabled = false;
          },
          of<S>(Common::off), Kind::off},
         {"no load",
          [](auto& its) {
              its.enabled = true;
              its.load_valid = false;
          },
          S::load_lost, Kind::bad},
         {"learning",
          [](auto& its) {
              its.enabled = true;
              its.learning = true;
          },
          S::learning, Kind::good},
         {"nothing was learned, and the next part is learned from", [](auto& its) { its.learns_again = true; },
          S::learns_again, Kind::wait},
         {"learning is requested", [](auto& its) { its.will_learn = true; }, S::will_learn, Kind::wait},
         {"nothing was learned", [](auto& its) { its.learning_fault = LearningFault::poor; }, S::learning_failed,
          Kind::warn},
         {"a refused reference", [](auto& its) { its.refusal = Refusal::feed; }, S::refused, Kind::bad},
         {"no reference", [](auto& its) { its.has_reference = its.has_rows = false; }, S::no_reference,
          Kind::warn},
         {"kept rows in the morning",
          [](auto& its) {
              its.has_reference = its.cycle_running = false;
              its.has_rows = true;
              its.interlock = of<S>(Common::machine_off);
          },
          S::kept, Kind::wait},
         {"rows of another program",
          [](auto& its) {
              its.has_reference = false;
              its.has_rows = its.cycle_running = true;
          },
          S::other_program, Kind::warn},
         {"not homed",
          [](auto& its) {
              its.has_reference = true;
              its.interlock = of<S>(Common::not_homed);
          },
          of<S>(Common::not_homed), Kind::wait},
         {"a change of the origin without a reason", [](auto& its) { its.asks_origin = true; },
          S::asks_origin, Kind::warn},
         {"a shift without an answer", [](auto& its) { its.shift = Shift::all; }, S::asks, Kind::warn},
         {"of the only tool", [](auto& its) { its.shift = Shift::only_tool; }, S::asks, Kind::warn},
         {"of one tool", [](auto& its) { its.shift = Shift::one_tool; }, S::asks_of_tool, Kind::warn},
         {"of feeds", [](auto& its) { its.shift = Shift::by_feed; }, S::asks_of_feeds, Kind::warn},
        {"it waits at a doubt", [](auto& its) { its.waits = true; }, S::waits, Kind::warn},
         {"contacts do not come", [](auto& its) { its.doubt = Doubt::missed; }, S::missed, Kind::warn},
         {"none for long", [](auto& its) { its.doubt = Doubt::old; }, S::old, Kind::warn},
         {"a withdrawn operation", [](auto& its) { its.doubt = Doubt::program_event; }, S::program_event,
          Kind::warn},
         {"a poor reference", [](auto& its) { its.doubt = Doubt::poor_reference; }, S::poor_reference,
          Kind::warn},
         {"an uncertain growth", [](auto& its) { its.doubt = Doubt::uncertain; }, S::uncertain, Kind::warn},
         {"a part is held back", [](auto& its) { its.doubt = Doubt::held_back; }, S::held_back, Kind::warn},
         {"dry run",
          [](auto& its) {
              its.doubt = Doubt::none;
              its.dry_run = true;
          },
          S::dry_run, Kind::off},
         {"no contact since the start", [](auto& its) { its.doubt = Doubt::unknown; }, S::no_contact,
          Kind::wait},
         {"no contact yet", [](auto& its) { its.known = false; }, S::no_contact, Kind::wait},
         {"a bound", [](auto& its) { its.bounded = true; }, S::bounded, Kind::warn},
         {"nothing", [](auto&) {}, S::works, Kind::good}}));
}

TEST(DisplacementStatus, ADoubtThatAnotherStatusExplainsHasNone) {
    DisplacementSeen its = working();
    for (const Doubt doubt : {Doubt::load, Doubt::origin, Doubt::shift, Doubt::contradiction}) {
        its.doubt = doubt;
        EXPECT_EQ(status_of(its), DisplacementStatus::works);
    }
}

// The most urgent one, and never one that its status does not mean.
TEST(DisplacementDetail, AFaultThenLearningThenARefusalThenTheLastContact) {
    const auto number_of = [](const DisplacementSeen& its) { return static_cast<int>(detail_of(its)); };
    DisplacementSeen its = working();
    EXPECT_EQ(number_of(its), 0);
    its.rejection = Rejection::beyond_gate;
    EXPECT_EQ(number_of(its), 38);
    its.doubt = Doubt::missed;
    EXPECT_EQ(number_of(its), 38) << "why they do not count";
    its.refusal = Refusal::program;
    EXPECT_EQ(number_of(its), 21);
    its.learning_fault = LearningFault::poor;
    EXPECT_EQ(number_of(its), 14);
    its.fault = DisplacementDetail::lost_track;
    EXPECT_EQ(number_of(its), 7);
    its.fault = {};
    its.refusal = {};
    its.learning = true;
    EXPECT_EQ(number_of(its), 38) << "of a contact that is not learned";
}

TEST(DisplacementDetail, OneSentenceForEachCauseThatIsTheSame) {
    EXPECT_EQ(detail(LearningFault::no_clock), detail(Rejection::no_clock));
    EXPECT_EQ(detail(LearningFault::rises_twice), detail(Rejection::rises_twice));
    EXPECT_EQ(detail(Refusal::feed), detail(Rejection::feed_differs));
    std::set<std::string> sentences;
    for (std::int32_t number = -1; number < 100; ++number)
        if (const char* const text = sentence(static_cast<DisplacementDetail>(number))) {
            EXPECT_TRUE(sentences.insert(text).second) << text;
        }
    EXPECT_EQ(sentences.size(), 29u);
}

TEST(DisplacementStatus, KeptRowsSendNobodyToLearn) {
    const hal::Said its = said(DisplacementStatus::kept);
    EXPECT_EQ(its.button, hal::Button::none);
    EXPECT_NE(std::string(its.remedy).find("Do not learn again"), std::string::npos);
}

TEST(ChoppingStatus, StrokesHeldAwayAndAtRestAreFour) {
    using S = ChoppingStatus;
    ChoppingSeen strokes, rests;
    strokes.on = strokes.homed = strokes.permitted = strokes.moves = true;
    rests.on = rests.homed = rests.permitted = true;
    std::set<S> found = expect_in_order<ChoppingSeen, S>(
        strokes,
        {{"the encoder has failed", [](auto& its) { its.place_known = false; }, S::place_lost, Kind::bad},
         {"held",
          [](auto& its) {
              its.place_known = true;
              its.held = its.hold_ordered = true;
          },
          S::held, Kind::warn},
         {"held by the speed",
          [](auto& its) {
              its.held = its.speed_zero = true;
              its.hold_ordered = false;
          },
          S::held_by_speed, Kind::warn},
         {"the way to R", [](auto& its) { its.returns = true; }, S::returns, Kind::warn},
         {"the end of strokes", [](auto& its) { its.ends = true; }, S::ends, Kind::warn},
         {"a fault", [](auto& its) { its.fault = true; }, S::with_fault, Kind::bad},
         {"a hold is ordered", [](auto& its) { its.hold_ordered = true; }, S::hold_ordered, Kind::warn},
         {"retain has died", [](auto& its) { its.interlock = of<S>(hal::of_service(Common::ending, 0)); },
          of<S>(hal::of_service(Common::ending, 0)), Kind::warn},
         {"a bound", [](auto& its) { its.bounded = true; }, S::bounded, Kind::warn},
         {"nothing", [](auto&) {}, S::strokes, Kind::good}});
    found.merge(expect_in_order<ChoppingSeen, S>(
        rests,
        {{"the encoder has failed", [](auto& its) { its.place_known = false; }, S::place_lost, Kind::bad},
         {"a fault away from R",
          [](auto& its) {
              its.place_known = true;
              its.away = its.fault = true;
          },
          S::stopped, Kind::bad},
         {"off and away from R",
          [](auto& its) {
              its.away = true;
              its.on = its.fault = false;
          },
          S::away_off, Kind::warn},
         {"away from R",
          [](auto& its) {
              its.away = its.on = true;
              its.fault = false;
          },
          S::away, Kind::warn},
         {"a fault", [](auto& its) { its.fault = true; }, of<S>(Common::fault), Kind::bad},
         {"where machine off ended a stroke", [](auto& its) { its.stands_off = its.on = true; },
          S::stands_off, Kind::warn},
         {"task has died", [](auto& its) { its.interlock = of<S>(hal::of_service(Common::lost, 4)); },
          of<S>(hal::of_service(Common::lost, 4)), Kind::bad},
         {"off", [](auto& its) { its.on = false; }, of<S>(Common::machine_off), Kind::wait},
         {"not homed", [](auto& its) { its.homed = false; }, of<S>(Common::not_homed), Kind::wait},
         {"not permitted", [](auto& its) { its.permitted = false; }, of<S>(Common::off), Kind::off},
         {"nothing", [](auto&) {}, S::at_rest, Kind::off}}));
    expect_all(found);
}

TEST(GrowthTestStatus, AProgramThatDiedIsNoPassAndOnlyAWarmMachineIsASuccess) {
    using namespace growth_test;
    Seen runs;
    runs.state = State::warming;
    runs.running = true;
    expect_all(expect_in_order<Seen, Status>(
        runs,
        {{"its program is gone", [](auto& its) { its.program_gone = its.running = true; },
          Status::program_lost, Kind::bad},
         {"a fault",
          [](auto& its) {
              its.program_gone = false;
              its.fault = true;
          },
          of<Status>(Common::fault), Kind::bad},
         {"task has died", [](auto& its) { its.interlock = of<Status>(hal::of_service(Common::lost, 4)); },
          of<Status>(hal::of_service(Common::lost, 4)), Kind::bad},
         {"warm",
          [](auto& its) {
              its.stop = Stop::stable;
              its.state = State::stopped;
          },
          Status::warm, Kind::good},
         {"the time is over",
          [](auto& its) {
              its.stop = Stop::maximum_time;
              its.state = State::stopped;
          },
          Status::time_over, Kind::warn},
         {"given back",
          [](auto& its) {
              its.stop = Stop::none;
              its.state = State::interrupted;
              its.resumable = true;
          },
          Status::resumable, Kind::warn},
         {"interrupted now",
          [](auto& its) {
              its.state = State::interrupted;
              its.resumable = false;
          },
          Status::interrupted, Kind::warn},
         {"idle",
          [](auto& its) {
              its.state = State::idle;
              its.running = false;
          },
          Status::idle, Kind::off},
         {"paused",
          [](auto& its) {
              its.state = State::probing;
              its.paused = true;
          },
          Status::paused, Kind::warn},
         {"nothing", [](auto& its) { its.interlock = of<Status>(Common::off); }, Status::runs, Kind::good}}));
}

}  // namespace
}  // namespace plumb
