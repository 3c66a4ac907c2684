// SPDX-License-Identifier: GPL-2.0-or-later
// The order of functions in threads, and the commands that mend a wrong one.
#include "hal/thread_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace plumb::hal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const PlacedFunction feedback{"x-stage.update-feedback", Place::feedback},
    handler{"motion-command-handler", Place::none}, motion{"motion-controller", Place::motion},
    square{"square.update", Place::source}, chop{"chop.update", Place::source},
    x_stage{"x-stage.update", Place::stage}, y_stage{"y-stage.update", Place::stage},
    guard{"interlock.update", Place::interlock}, test{"growth-test.update", Place::measurement},
    reads{"hm2.read", Place::none}, writes{"hm2.write", Place::none},
    program{"program.update", Place::program}, mill{"mill.update", Place::machine},
    load{"drive.update", Place::load};

using Functions = std::vector<PlacedFunction>;

const Functions right{reads, handler, feedback, motion, test, chop, square, x_stage, y_stage, guard, writes};

std::vector<std::string> names(const Functions& functions) {
    std::vector<std::string> result;
    for (const PlacedFunction& one : functions) result.push_back(one.name);
    return result;
}

// What halcmd does.
void carry_out(const std::string& command, std::vector<ThreadFunctions>& threads, Functions& idle) {
    std::istringstream words(command);
    std::string verb, name, thread_name;
    words >> verb >> name >> thread_name;
    const auto thread = std::find_if(threads.begin(), threads.end(),
                                     [&](const ThreadFunctions& one) { return one.name == thread_name; });
    ASSERT_NE(thread, threads.end()) << command;
    const auto called = [&](const PlacedFunction& one) { return one.name == name; };
    Functions& from = verb == "delf" ? thread->functions : idle;
    Functions& to = verb == "delf" ? idle : thread->functions;
    const auto found = std::find_if(from.begin(), from.end(), called);
    ASSERT_NE(found, from.end()) << command;
    const PlacedFunction function = *found;
    from.erase(found);
    std::size_t place = to.size() + 1;
    if (verb == "addf" && words >> place) {
        ASSERT_GE(place, 1) << command;
    }
    ASSERT_LE(place, to.size() + 1) << command << ": the place is too high";
    to.insert(to.begin() + static_cast<std::ptrdiff_t>(place - 1), function);
}

std::vector<std::string> commands(const std::vector<Misplaced>& wrong) {
    std::vector<std::string> result;
    for (const Misplaced& one : wrong) result.insert(result.end(), one.commands.begin(), one.commands.end());
    return result;
}

// The only finding in one thread.
Misplaced only(const Functions& functions, const Functions& idle = {}) {
    const auto wrong = misplaced({{"servo-thread", functions}}, idle);
    EXPECT_THAT(wrong, SizeIs(1));
    return wrong.empty() ? Misplaced{} : wrong.front();
}

TEST(ThreadOrder, RightOrderHasNoFinding) {
    EXPECT_THAT(misplaced({{"servo-thread", right}}, {}), IsEmpty());
    EXPECT_THAT(misplaced({{"servo-thread", {program, mill, load, square, x_stage}}}, {}), IsEmpty());
    EXPECT_THAT(misplaced({}, {square}), IsEmpty()) << "nothing runs";
}

TEST(ThreadOrder, StageBeforeMotionControllerIsNamedAndGoesBehindTheSources) {
    const Misplaced wrong = only({x_stage, handler, motion, square, writes});
    EXPECT_EQ(wrong.sentence,
              "x-stage.update runs before motion-controller and square.update in servo-thread; it belongs "
              "after them.");
    EXPECT_THAT(wrong.commands,
                ElementsAre("delf x-stage.update servo-thread", "addf x-stage.update servo-thread 4"));
}

TEST(ThreadOrder, EachWrongOrderOfTwoHasItsSentence) {
    const auto sentence = [](const PlacedFunction& first, const PlacedFunction& second) {
        return only({first, reads, second}).sentence;
    };
    EXPECT_EQ(sentence(motion, feedback),
              "x-stage.update-feedback runs after motion-controller in "
              "servo-thread; it belongs before it.");
    EXPECT_EQ(sentence(square, motion),
              "square.update runs before motion-controller in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(x_stage, square),
              "x-stage.update runs before square.update in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(guard, y_stage),
              "interlock.update runs before y-stage.update in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(guard, chop),
              "interlock.update runs before chop.update in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(x_stage, feedback),
              "x-stage.update runs before x-stage.update-feedback in "
              "servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(test, motion),
              "growth-test.update runs before motion-controller in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(mill, program),
              "mill.update runs before program.update in servo-thread; it belongs after it.");
    EXPECT_EQ(sentence(load, mill),
              "drive.update runs before mill.update in servo-thread; it belongs after it.");
}

TEST(ThreadOrder, FeedbackGoesRightBeforeMotionController) {
    const Misplaced wrong = only({reads, handler, motion, square, x_stage, feedback, guard});
    EXPECT_EQ(wrong.sentence,
              "x-stage.update-feedback runs after motion-controller, square.update and x-stage.update in "
              "servo-thread; it belongs before them.");
    EXPECT_THAT(wrong.commands, ElementsAre("delf x-stage.update-feedback servo-thread",
                                            "addf x-stage.update-feedback servo-thread 3"));
}

TEST(ThreadOrder, AFunctionOnTheWrongSideOfSeveralNamesSome) {
    EXPECT_EQ(
        only({x_stage, feedback, {"y-stage.update-feedback", Place::feedback}, motion, square}).sentence,
        "x-stage.update runs before motion-controller, x-stage.update-feedback and 2 more in "
        "servo-thread; it belongs after them.");
    EXPECT_EQ(only({guard, motion, chop, square, x_stage, y_stage}).sentence,
              "interlock.update runs before motion-controller, chop.update and 3 more in servo-thread; it "
              "belongs after them.");
}

TEST(ThreadOrder, TwoInstancesAreTwoFindings) {
    const auto wrong = misplaced({{"servo-thread", {y_stage, x_stage, motion, square, guard}}}, {});
    ASSERT_THAT(wrong, SizeIs(2));
    EXPECT_THAT(commands(wrong),
                ElementsAre("delf y-stage.update servo-thread", "addf y-stage.update servo-thread 4",
                            "delf x-stage.update servo-thread", "addf x-stage.update servo-thread 3"));
}

// What is right beside motion-controller stays, though others are on the wrong side of it, too.
TEST(ThreadOrder, OnlyWrongFunctionsMoveTheFirstOfTheThreadFirst) {
    EXPECT_THAT(commands(misplaced({{"servo-thread", {x_stage, guard, motion, square, feedback}}}, {})),
                ElementsAre("delf x-stage.update-feedback servo-thread",
                            "addf x-stage.update-feedback servo-thread 3", "delf x-stage.update servo-thread",
                            "addf x-stage.update servo-thread", "delf interlock.update servo-thread",
                            "addf interlock.update servo-thread"));
}

TEST(ThreadOrder, FunctionsOfOthersAreIgnoredWhereverTheyAre) {
    Functions functions;
    for (const PlacedFunction& one : right) {
        functions.push_back({"other." + std::to_string(functions.size()), Place::none});
        functions.push_back(one);
    }
    EXPECT_THAT(misplaced({{"servo-thread", functions}}, {{"spare", Place::none}}), IsEmpty());
}

TEST(ThreadOrder, AStageInAnotherThreadThanMotionControllerIsWrongAndASourceIsNot) {
    const auto wrong =
        misplaced({{"servo-thread", {motion, x_stage}}, {"slow-thread", {square, y_stage}}}, {});
    ASSERT_THAT(wrong, SizeIs(1));
    EXPECT_EQ(wrong.front().sentence,
              "y-stage.update is in slow-thread; it belongs in servo-thread, with motion-controller.");
    EXPECT_THAT(wrong.front().commands,
                ElementsAre("delf y-stage.update slow-thread", "addf y-stage.update servo-thread 2"));
}

TEST(ThreadOrder, WithoutMotionControllerTheStagesBelongToInterlock) {
    const auto wrong = misplaced({{"one", {x_stage}}, {"two", {square, y_stage, guard}}}, {});
    ASSERT_THAT(wrong, SizeIs(1));
    EXPECT_EQ(wrong.front().sentence, "x-stage.update is in one; it belongs in two, with interlock.update.");
}

TEST(ThreadOrder, FunctionsOfTwoThreadsHaveNoOrderAmongEachOther) {
    EXPECT_THAT(misplaced({{"base-thread", {square}}, {"servo-thread", {motion, x_stage, guard}}}, {}),
                IsEmpty());
}

TEST(ThreadOrder, AFunctionThatNoThreadHasIsNamed) {
    const Misplaced wrong = only({handler, motion, square, guard, writes}, {x_stage, feedback, test, mill});
    EXPECT_EQ(wrong.sentence,
              "x-stage.update is in no thread, so it is never called; it belongs in servo-thread.");
    EXPECT_THAT(wrong.commands, ElementsAre("addf x-stage.update servo-thread 4"));
}

TEST(ThreadOrder, CommandsMendAnyOrderAndMoveNothingThatIsRight) {
    const Functions all{reads,   handler, feedback, motion, test,    chop, square,
                        x_stage, y_stage, guard,    writes, program, mill, load};
    for (unsigned seed = 0; seed < 3000; ++seed) {
        std::mt19937 random(seed);
        Functions functions = all;
        std::shuffle(functions.begin(), functions.end(), random);
        std::vector<ThreadFunctions> threads{{"base", {}}, {"servo", {}}, {"slow", {}}};
        Functions idle;
        for (const PlacedFunction& one : functions) {
            const unsigned where = random() % 10;
            if (where == 0)
                idle.push_back(one);
            else
                threads[where < 3 ? where - 1 : 2].functions.push_back(one);
        }
        const auto before = threads;
        const auto wrong = misplaced(threads, idle);
        for (const std::string& command : commands(wrong)) {
            EXPECT_EQ(command.find("motion-controller"), std::string::npos);
            carry_out(command, threads, idle);
            if (testing::Test::HasFatalFailure()) return;
        }
        EXPECT_THAT(misplaced(threads, idle), IsEmpty()) << "seed " << seed;
        for (const Misplaced& one : wrong) EXPECT_LT(one.sentence.size(), 250) << one.sentence;
        // The functions of others stand in the same order as before.
        for (std::size_t t = 0; t < threads.size(); ++t) {
            const auto others = [](const Functions& list) {
                Functions result;
                std::copy_if(list.begin(), list.end(), std::back_inserter(result),
                             [](const PlacedFunction& one) { return one.place == Place::none; });
                return names(result);
            };
            EXPECT_EQ(others(threads[t].functions), others(before[t].functions)) << "seed " << seed;
        }
    }
}

TEST(ThreadOrder, PlacesAreWrittenAsSentences) {
    EXPECT_EQ(order_of(Place::stage),
              "After motion-controller and all sources of offsets, before interlock, in the thread of "
              "motion-controller.");
    EXPECT_EQ(order_of(Place::source), "After motion-controller, before all stages and interlock.");
    EXPECT_EQ(order_of(Place::program), "Before the simulated machine and the simulated load.");
    EXPECT_EQ(order_of(Place::measurement), "After motion-controller.");
    EXPECT_EQ(order_of(Place::none), "");
    for (const PlaceInfo& one : places) EXPECT_EQ(place_named(one.name), one.place);
    EXPECT_EQ(place_named("nowhere"), Place::none);
}

}  // namespace
}  // namespace plumb::hal
