// SPDX-License-Identifier: GPL-2.0-or-later
// A stage acts by the word of interlock alone: each part of it, and each way in which it may be wrong.
#include "components/stages/stage_permit.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace plumb {
namespace {

constexpr std::int32_t row = 3;

struct Stage {
    explicit Stage(const std::string& options = "") {
        bench.command("loadrt joint_offset names=it" + options);
        for (const char* setting : {"min-limit -100", "max-limit 100", "joint-acceleration 2000",
                                    "offset-acceleration 1000", "homed true", "motion-enabled true"})
            bench.command(std::string("setp it.") + setting);
        bench.set("it.row", row);
        bench.command("addf it.update-feedback servo-thread");
        bench.command("addf it.update servo-thread");
        bench.set("it.offset-0", 0.02);
    }

    // Periods with a word each.
    double run(int periods, const std::function<std::int32_t(std::int32_t beat)>& word) {
        for (int i = 0; i < periods; ++i) {
            bench.set("it.permit", word(++beat_));
            bench.run(0.001);
        }
        return applied();
    }
    double run(const Permit& permit, int periods = 1000) {
        return run(periods, [&](std::int32_t beat) { return PermitWord::of(row, beat, permit); });
    }
    double applied() { return bench.get("it.applied-offset"); }

    Bench bench;

private:
    std::int32_t beat_ = 0;
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
    EXPECT_THROW(bench.command("loadrt joint_offset names=it interlock=maybe"), std::runtime_error);
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

TEST(StagePermit, AWordThatIsVoidHoldsTheOffset) {
    const std::pair<const char*, std::function<std::int32_t(std::int32_t)>> words[] = {
        {"stale", [](std::int32_t) { return PermitWord::of(row, 5, go); }},
        {"missing", [](std::int32_t) { return PermitWord::none; }},
        {"zero", [](std::int32_t) { return 0; }},
        {"of another row", [](std::int32_t beat) { return PermitWord::of(row + 1, beat, go); }},
        {"a counter", [](std::int32_t beat) { return beat; }},
        {"a large counter", [](std::int32_t beat) { return (1 << 29) + 77 * beat; }},
    };
    for (const auto& [name, word] : words) {
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
    for (int bit = 0; bit < 31; ++bit) {
        int taken = 0;
        for (std::int32_t beat = 0; beat < PermitWord::beats; ++beat)
            for (const Permit& permit : {go, hold, Permit{}, Permit{true, true, false, 4}})
                taken += PermitWord::is_for(PermitWord::of(row, beat, permit) ^ 1 << bit, row) ? 1 : 0;
        EXPECT_EQ(taken, 0) << bit;
    }
}

TEST(StagePermit, ItsRowMustBeSet) {
    Stage stage;
    stage.bench.set("it.row", -1);
    EXPECT_EQ(stage.run(go), 0);
    EXPECT_EQ(stage.run(1000, [](std::int32_t beat) { return PermitWord::of(-1, beat, go); }), 0);
}

}  // namespace
}  // namespace plumb
