// SPDX-License-Identifier: GPL-2.0-or-later
// A stage acts by the word of interlock alone: each part of it, and each way in which it may be wrong.
#include "components/stages/stage_permit.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace plumb {
namespace {

constexpr std::uint32_t row = 3;

std::uint32_t word_of(std::uint32_t its_row, std::uint32_t beat, const Permit& permit) {
    return hal::BusWord::of(hal::Party::stage, hal::Direction::from_interlock, its_row, beat,
                            permit.content());
}
bool fits(std::uint32_t word) {
    return hal::BusWord::fits(word, hal::Party::stage, hal::Direction::from_interlock);
}

struct Stage {
    explicit Stage(const std::string& options = "") {
        bench.command("loadrt joint_offset names=it" + options);
        for (const char* setting : {"min-limit -100", "max-limit 100", "joint-acceleration 2000",
                                    "offset-acceleration 1000", "homed true", "motion-enabled true"})
            bench.command(std::string("setp it.") + setting);
        bench.command("addf it.update-feedback servo-thread");
        bench.command("addf it.update servo-thread");
        bench.set("it.offset-0", 0.02);
    }

    // Periods with a word each.
    using Word = std::function<std::uint32_t(std::uint32_t beat)>;
    double run(int periods, const Word& word) {
        for (int i = 0; i < periods; ++i) {
            bench.set("it.permit", word(++beat_));
            bench.run(0.001);
        }
        return applied();
    }
    double run(const Permit& permit, int periods = 1000) {
        return run(periods, [&](std::uint32_t beat) { return word_of(row, beat, permit); });
    }
    double applied() { return bench.get("it.applied-offset"); }

    Bench bench;

private:
    std::uint32_t beat_ = 0;
};

constexpr Permit go{true, false, false, 0}, hold{true, false, true, 0};

TEST(StagePermit, WithoutAWordNothingIsAppliedAndTheStageReportsIt) {
    Stage stage;
    stage.bench.run(1);
    EXPECT_EQ(stage.applied(), 0);
    EXPECT_EQ(stage.bench.get("it.fault-code"), 7);
}

TEST(StagePermit, WithInterlockNoItActsByItself) {
    Stage stage(" interlock=no");
    stage.bench.run(1);
    EXPECT_NEAR(stage.applied(), 0.02, 1e-9);
    EXPECT_EQ(stage.bench.get("it.fault-code"), 0);
}

TEST(StagePermit, AnotherAnswerThanYesOrNoIsRefused) {
    Bench bench;
    EXPECT_THROW(bench.client().command("loadrt joint_offset names=it interlock=maybe"), std::runtime_error);
}

TEST(StagePermit, EachPartOfTheWordActs) {
    Stage stage;
    EXPECT_NEAR(stage.run(go), 0.02, 1e-9);
    stage.bench.set("it.offset-0", 0.05);
    EXPECT_NEAR(stage.run(hold), 0.02, 1e-9);
    EXPECT_NEAR(stage.run(go), 0.05, 1e-9);
    stage.bench.set("it.offset-1", 0.01);  // comes with the next word
    stage.run({true, false, false, 2}, 1);
    stage.bench.set("it.offset-0", -0.05);
    EXPECT_NEAR(stage.run({true, false, false, 2}), 0.06, 1e-9) << "source 2 alone, beside what was in force";
    EXPECT_EQ(stage.run({}), 0) << "without enable it returns";
    EXPECT_NEAR(stage.run({true, false, false, 2}), 0.01, 1e-9) << "source 2 alone";
}

TEST(StagePermit, ATrialMovesTheStageByItsPinTrialAlone) {
    Stage stage;
    stage.bench.set("it.trial", 0.04);
    EXPECT_NEAR(stage.run(go), 0.02, 1e-9) << "trial counts in a trial alone";
    stage.run({}, 1000);
    EXPECT_NEAR(stage.run({true, false, false, Permit::of_trial}), 0.04, 1e-9);
    for (const double poison : {std::nan(""), 1e308, -HUGE_VAL}) {
        stage.bench.set("it.trial", poison);
        EXPECT_NEAR(stage.run({true, false, false, Permit::of_trial}), 0.04, 1e-9) << poison;
        EXPECT_EQ(stage.bench.get("it.fault-code"), 1) << poison;
    }
    stage.bench.set("it.trial", 0);
    EXPECT_EQ(stage.run({false, false, false, 0}), 0);
}

using hal::BusWord, hal::Party, hal::Direction;

// Of a stage that has taken a row, and is at work.
const std::pair<const char*, Stage::Word> void_words[] = {
    {"stale", [](std::uint32_t) { return word_of(row, 5, go); }},
    {"missing", [](std::uint32_t) { return 0U; }},
    {"of another row", [](std::uint32_t beat) { return word_of(row + 1, beat, go); }},
    {"of no row", [](std::uint32_t beat) { return word_of(BusWord::no_row, beat, go); }},
    {"for a function",
     [](std::uint32_t beat) {
         return BusWord::of(Party::function, Direction::from_interlock, row, beat, go.content());
     }},
    {"a state",
     [](std::uint32_t beat) {
         return BusWord::of(Party::stage, Direction::to_interlock, row, beat, go.content());
     }},
    {"a counter", [](std::uint32_t beat) { return beat; }},
    {"a large counter", [](std::uint32_t beat) { return 0xA3800000U + 77 * beat; }},
};

TEST(StagePermit, AWordThatIsVoidHoldsTheOffset) {
    for (const auto& [name, word] : void_words) {
        Stage stage;
        EXPECT_NEAR(stage.run(go), 0.02, 1e-9) << name;
        stage.run(12, word);  // the time after which it is void
        stage.bench.set("it.offset-0", 0.05);
        const double held = stage.applied();
        EXPECT_NEAR(stage.run(1000, word), held, 1e-9) << name;
        EXPECT_EQ(stage.bench.get("it.fault-code"), 7) << name;
        EXPECT_NEAR(stage.run(go), 0.05, 1e-9) << name;
        EXPECT_EQ(stage.bench.get("it.fault-code"), 0) << name;
    }
}

TEST(StagePermit, AWordWithAnyBitTurnedIsVoid) {
    for (std::uint32_t bit = 0; bit < 32; ++bit)
        for (std::uint32_t beat = 0; beat < BusWord::beats; ++beat)
            for (const Permit& permit : {go, hold, Permit{}, Permit{true, true, false, 4}})
                EXPECT_FALSE(fits(word_of(row, beat, permit) ^ 1U << bit)) << bit;
}

TEST(StagePermit, AStageTakesTheRowOfItsFirstPermitAndSaysIt) {
    Stage stage;
    const auto row_said = [&] {
        return BusWord::row(static_cast<std::uint32_t>(stage.bench.get("it.state")));
    };
    stage.bench.run(0.1);
    EXPECT_EQ(row_said(), BusWord::no_row);
    stage.run(go);
    EXPECT_EQ(row_said(), row);
    stage.run(100, [](std::uint32_t beat) { return word_of(row + 1, beat, go); });
    EXPECT_EQ(row_said(), row);
}

// The single pins, and the bits of the word.
TEST(StagePermit, TheStateSaysWhatTheSinglePinsSay) {
    Stage stage;
    const char* const pins[] = {"inhibit-homing", "ramping", nullptr, nullptr, "fault", "limited"};
    const auto compare = [&](const char* when) {
        const auto word = static_cast<std::uint32_t>(stage.bench.get("it.state"));
        EXPECT_TRUE(BusWord::fits(word, Party::stage, Direction::to_interlock));
        for (std::size_t bit = 0; bit < 6; ++bit)
            EXPECT_EQ(BusWord::content(word) >> bit & 1,
                      pins[bit] ? stage.bench.get(std::string("it.") + pins[bit]) : 0)
                << bit << " " << when;
    };
    stage.bench.run(0.001);
    compare("at first");
    stage.run(go, 50);
    EXPECT_EQ(stage.bench.get("it.ramping"), 1);
    compare("while it ramps");
    stage.run(go);
    compare("with an offset");
    stage.bench.set("it.offset-0", 3);
    stage.run(go, 20000);
    EXPECT_EQ(stage.bench.get("it.limited"), 1);
    compare("at its limit");
    stage.bench.set("it.max-offset", -1);
    stage.run(go, 10);
    EXPECT_EQ(stage.bench.get("it.fault"), 1);
    compare("with a fault");
}

}  // namespace
}  // namespace plumb
