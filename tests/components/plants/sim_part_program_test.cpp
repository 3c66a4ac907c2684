// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/rounds.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace plumb {
namespace {

enum Event {
    none,
    air_cut,
    chip,
    stock,
    wrong_part,
    wrong_tool,
    feed_override,
    feed_hold,
    spindle_override,
    speed_change,
    abort_,
    edited
};

struct SimPartProgram : testing::Test {
    Bench bench;

    SimPartProgram() {
        bench.command("loadrt sim_part_program names=program");
        bench.command("addf program.update servo-thread");
    }

    double get(const std::string& pin) { return bench.get("program." + pin); }
    void set(const std::string& pin, double value) { bench.set("program." + pin, value); }

    Table trace(double seconds, const std::vector<std::string>& pins, double every = 0.001) {
        std::vector<std::string> names;
        for (const std::string& pin : pins) names.push_back("program." + pin);
        Table table = bench.trace(seconds, names, every);
        for (std::string& name : table.names)
            if (name != "time") name.erase(0, std::string("program.").size());
        return table;
    }

    // The second cycle, the first one that is not learned from, with an event in operation 10.
    Table upset_cycle(int event, const std::vector<std::string>& pins) {
        set("cycle-interval", 70);
        set("event", event);
        set("event-cycle", 2);
        set("event-operation", 10);
        bench.run(70.5);
        return trace(70, pins);
    }
};

TEST_F(SimPartProgram, MakesAPartOfSeveralOperationsAndToolsWithinAMinute) {
    const Table cycle =
        trace(60, {"cycle-running", "operation", "truth-occurrence", "tool-number", "motion-type"});
    std::set<std::tuple<double, double>> operations;
    std::set<double> tools;
    double start = -1, end = -1;
    for (const auto& row : cycle.rows) {
        if (row[1] && start < 0) start = row[0];
        if (row[1]) end = row[0];
        if (row[5] == 2 && row[2] != 0) {
            operations.insert({row[2], row[3]});
            tools.insert(row[4]);
        }
        if (!row[1]) {
            EXPECT_EQ(row[2], 0) << "no operation between parts, at " << row[0];
        }
    }
    EXPECT_EQ(operations.size(), 5u);
    EXPECT_EQ(tools.size(), 4u);
    EXPECT_NEAR(start, 1, 0.002);
    EXPECT_LT(end, 55);
    EXPECT_TRUE(get("cycle-complete"));
}

TEST_F(SimPartProgram, VelocityIsThatOfThePosition) {
    bench.run(0.01);
    bench.expect("abs(z_rate - v) < 3e-3",
                 {{"z", "program.z-position-cmd"}, {"v", "program.z-velocity-cmd"}});
    bench.expect("abs(v) <= 300.001 && abs(v_rate) < 2501", {{"v", "program.z-velocity-cmd"}});
    bench.run(60);
}

TEST_F(SimPartProgram, PlungesAtContactFeedFromAboveTheWorkToDepth) {
    const Table cycle = trace(
        60, {"operation", "motion-type", "z-position-cmd", "z-velocity-cmd", "work-top", "start-height"});
    double deepest = 100;
    for (const auto& row : cycle.rows) {
        const double operation = row[1], motion = row[2], z = row[3], v = row[4], top = row[5],
                     start = row[6];
        if (operation == 0) continue;
        EXPECT_NEAR(start, top + 2, 1e-9);
        if (v < 0 && z < top + 5.9) {
            EXPECT_EQ(motion, 2) << "no rapid near the work";
        }
        if (motion == 2 && z < top + 5 && z > top - 0.9) {
            EXPECT_NEAR(v, -100 / 60., 1e-4);
        }
        if (operation == 40) deepest = std::min(deepest, z);
    }
    EXPECT_NEAR(deepest, -4, 1e-9);
}

TEST_F(SimPartProgram, SpindleTurnsBetweenPartsAndIsUpToSpeedBeforeTheWayDown) {
    const Table cycle =
        trace(300, {"cycle-running", "spindle-speed-cmd", "motion-type", "z-velocity-cmd"}, 0.01);
    double turning = 0;
    for (const auto& row : cycle.rows) {
        turning += 0.01 * (row[2] > 0);
        if (row[3] == 2 && row[4] < 0) {
            EXPECT_GT(row[2], 0);
        }
        if (row[0] > 60) {
            EXPECT_EQ(row[2], 8000);
        }
        if (row[0] > 60) {
            EXPECT_EQ(row[4], 0);
        }
    }
    EXPECT_GT(turning, 285);
}

TEST_F(SimPartProgram, BetweenPartsItMillsSidesAndTouchesNoTop) {
    set("cycle-interval", 70);
    double milled = 0;
    for (const auto& row :
         trace(150, {"operation", "from-side", "side-entry", "z-position-cmd", "work-top"}, 0.01).rows) {
        if (row[0] > 0) {
            EXPECT_EQ(row[2], row[1] == 0 || row[1] == 30) << row[0];
        }
        if (row[1] == 0 && row[3] > 0) {
            EXPECT_LT(row[4], row[5]);
            milled += 0.01;
        }
    }
    EXPECT_NEAR(milled, 2 * (70 - 50), 4);
}

TEST_F(SimPartProgram, SidesMayHaveASpeedOfTheirOwnOrNone) {
    bench.run(60);
    for (const double speed : {2500.0, 0.0}) {
        set("sides-speed", speed);
        bench.run(1);
        EXPECT_FALSE(get("cycle-running"));
        EXPECT_EQ(get("spindle-speed-cmd"), speed);
        EXPECT_EQ(get("side-entry") > 0, speed > 0);
        EXPECT_EQ(get("coolant") > 0, speed > 0);
    }
    bench.run(248);
    EXPECT_TRUE(get("cycle-running"));
    EXPECT_EQ(get("spindle-speed-cmd"), 8000);
}

TEST_F(SimPartProgram, CyclesBeginEveryIntervalAndTheFirstOnesAreLearnt) {
    set("learning-cycles", 2);
    const Table table = trace(1000, {"cycle", "learn"}, 0.1);
    std::vector<double> starts;
    for (std::size_t i = 1; i < table.rows.size(); ++i) {
        if (table.rows[i][1] != table.rows[i - 1][1]) starts.push_back(table.rows[i][0]);
        if (table.rows[i][1] > 0) {
            EXPECT_EQ(table.rows[i][2], table.rows[i][1] <= 2);
        }
    }
    ASSERT_EQ(starts.size(), 4u);
    for (std::size_t i = 0; i < starts.size(); ++i)
        EXPECT_NEAR(starts[i], 1 + 300. * static_cast<double>(i), 0.11);
}

TEST_F(SimPartProgram, RelearnMakesTheNextCycleOneToLearnFrom) {
    set("event-rate", 1);
    bench.run(400);
    EXPECT_FALSE(get("learn"));
    set("relearn", 1);
    bench.run(150);
    EXPECT_FALSE(get("learn")) << "the present cycle does not change";
    bench.run(100);
    EXPECT_TRUE(get("learn"));
    set("relearn", 0);
    const Table table = trace(240, {"truth-event", "learn"}, 0.1);
    for (const auto& row : table.rows) {
        EXPECT_EQ(row[1], 0) << "nothing upsets it";
        EXPECT_EQ(row[2], 1);
    }
    bench.run(100);
    EXPECT_FALSE(get("learn"));
}

TEST_F(SimPartProgram, StandsWhenItIsNotToRun) {
    bench.run(100);
    set("run", 0);
    bench.run(400);
    EXPECT_EQ(get("cycle"), 1);
    EXPECT_EQ(get("spindle-speed-cmd"), 0);
    EXPECT_EQ(get("z-position-cmd"), 100);
    EXPECT_EQ(get("motion-type"), 0);
    set("run", 1);
    bench.run(1);
    EXPECT_EQ(get("cycle"), 2);
    EXPECT_TRUE(get("cycle-running"));
}

TEST_F(SimPartProgram, IsNotUpsetUnlessAsked) {
    bench.expect("event == 0 && present && chip == 0 && tool == 0 && override == 1 && abs(stock) < 0.0045",
                 {{"event", "program.truth-event"},
                  {"present", "program.work-present"},
                  {"chip", "program.chip-height"},
                  {"tool", "program.tool-deviation"},
                  {"override", "program.feed-override"},
                  {"stock", "program.stock-deviation"}});
    bench.run(3000);
}

TEST_F(SimPartProgram, BlanksScatterByTheirRepeatability) {
    set("cycle-interval", 0);
    set("blank-repeatability", 0.001);
    set("contact-feed", 100);  // makes a part in a third of the time
    const std::vector<double> tops =
        trace(rounds(6000, 1500), {"stock-deviation"}, 0.25).column("stock-deviation");
    std::vector<double> blanks;
    for (std::size_t i = 1; i < tops.size(); ++i)
        if (tops[i] != tops[i - 1]) blanks.push_back(tops[i]);
    ASSERT_GT(static_cast<int>(blanks.size()), rounds(700, 175));
    double squares = 0;
    for (const double blank : blanks) squares += blank * blank;
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(blanks.size())), 1 * um, 0.12 * um);
}

TEST_F(SimPartProgram, AirCutHasNoWork) {
    for (const auto& row :
         upset_cycle(air_cut, {"operation", "truth-occurrence", "work-present", "truth-event"}).rows) {
        const bool here = row[1] == 10 && row[2] == 1;
        EXPECT_EQ(row[3], !here);
        EXPECT_EQ(row[4], here ? air_cut : none);
    }
}

TEST_F(SimPartProgram, ChipLiesOnOneOperation) {
    for (const auto& row : upset_cycle(chip, {"operation", "truth-occurrence", "chip-height"}).rows) {
        if (row[1] == 10 && row[2] == 1) {
            EXPECT_GE(row[3], 0.1);
            EXPECT_LE(row[3], 0.5);
        } else {
            EXPECT_EQ(row[3], 0);
        }
    }
}

TEST_F(SimPartProgram, StockConcernsTheWholePartAndOnlyThat) {
    set("event-height", -0.2);
    set("blank-repeatability", 0);
    for (const auto& row :
         upset_cycle(stock, {"cycle", "operation", "stock-deviation", "work-top", "truth-event"}).rows) {
        EXPECT_EQ(row[3], row[1] == 2 && row[2] ? -0.2 : 0);
        EXPECT_EQ(row[5], row[1] == 2 && row[2] ? stock : none);
    }
}

TEST_F(SimPartProgram, WrongToolLengthConcernsEveryOperationOfTheTool) {
    set("event-height", 0.4);
    for (const auto& row : upset_cycle(wrong_tool, {"operation", "tool-deviation"}).rows)
        EXPECT_EQ(row[2], row[1] == 10 ? 0.4 : 0);  // both occurrences, with tool 1
}

TEST_F(SimPartProgram, FeedOverrideSlowsOneWayDown) {
    set("event-factor", 0.6);
    bool seen = false;
    for (const auto& row :
         upset_cycle(feed_override, {"operation", "truth-occurrence", "feed-override", "z-velocity-cmd",
                                     "motion-type", "work-top", "z-position-cmd"})
             .rows) {
        const bool here = row[1] == 10 && row[2] == 1;
        EXPECT_EQ(row[3], here ? 0.6 : 1);
        if (here && row[5] == 2 && std::abs(row[7] - row[6]) < 1) {
            EXPECT_NEAR(row[4], -0.6 * 100 / 60, 1e-4);
            seen = true;
        }
    }
    EXPECT_TRUE(seen);
}

TEST_F(SimPartProgram, FeedHoldStopsTheWayDownForThreeSeconds) {
    double held = 0;
    for (const auto& row : upset_cycle(feed_hold, {"operation", "truth-occurrence", "z-velocity-cmd",
                                                   "motion-type", "z-position-cmd", "work-top"})
                               .rows)
        if (row[1] == 10 && row[2] == 1 && row[4] == 2 && row[5] > row[6] - 1.9 && row[3] == 0) held += 0.001;
    EXPECT_NEAR(held, 3, 0.01);
}

TEST_F(SimPartProgram, SpindleOverrideChangesTheSpeedOfOneOperation) {
    set("event-factor", 0.8);
    for (const auto& row :
         upset_cycle(spindle_override, {"operation", "truth-occurrence", "motion-type", "spindle-speed-cmd"})
             .rows)
        if (row[1] == 10 && row[3] == 2) {
            EXPECT_NEAR(row[4], row[2] == 1 ? 6400 : 8000, 1e-9);
        }
}

TEST_F(SimPartProgram, SpeedChangesOnApproachAboveTheWork) {
    set("event-factor", 1.1);
    double changed_at = -100, top = 0, before = 0;
    for (const auto& row : upset_cycle(speed_change, {"operation", "truth-occurrence", "z-position-cmd",
                                                      "work-top", "spindle-speed-cmd", "motion-type"})
                               .rows) {
        if (row[1] == 10 && row[2] == 1 && row[6] == 2 && before == 8000 && std::abs(row[5] - 8800) < 1e-6) {
            changed_at = row[3];
            top = row[4];
        }
        before = row[5];
    }
    EXPECT_GT(changed_at, top + 0.19);
    EXPECT_LT(changed_at, top + 1);
}

TEST_F(SimPartProgram, AbortEndsTheCycleIncompleteUntilTheNext) {
    const Table cycle =
        upset_cycle(abort_, {"cycle", "cycle-running", "cycle-complete", "operation", "spindle-speed-cmd"});
    double running = 0;
    bool over = false;
    for (const auto& row : cycle.rows) {
        if (row[1] != 2) continue;
        if (row[2]) {
            EXPECT_FALSE(over) << "an aborted cycle does not go on";
            EXPECT_EQ(row[4] == 0 || row[4] == 10, true);
            running += 0.001;
        } else if (running > 0) {
            over = true;
            EXPECT_EQ(row[4], 0);
            EXPECT_EQ(row[5], 0) << "the spindle stops";
        }
        EXPECT_FALSE(row[3]);
    }
    EXPECT_GT(running, 3);
    EXPECT_LT(running, 15);
    bench.run(60);
    EXPECT_EQ(get("cycle"), 3);
    EXPECT_TRUE(get("cycle-complete"));
}

TEST_F(SimPartProgram, EditedProgramHasAnotherNumberAndOtherLevelsFromThenOn) {
    set("event-height", 0.7);
    const Table cycle = upset_cycle(edited, {"cycle", "program-id", "work-top", "operation"});
    double top_before = 0;
    for (const auto& row : cycle.rows) {
        EXPECT_EQ(row[2], row[1]) << "as the cycle, 1 and then 2";
        if (row[1] == 1) top_before = row[3];
    }
    bench.run(60);
    EXPECT_EQ(get("cycle"), 3);
    EXPECT_EQ(get("program-id"), 2);
    EXPECT_NEAR(get("work-top"), top_before + 0.7, 1e-9);
    EXPECT_EQ(get("truth-event"), edited);
}

TEST_F(SimPartProgram, EventsAreDrawnOfEveryKindAndLargeEnough) {
    set("event-rate", 1);
    set("cycle-interval", 0);
    set("contact-feed", 50);
    set("blank-repeatability", 0);
    const Table table = trace(
        8000, {"truth-event", "cycle", "learn", "chip-height", "stock-deviation", "tool-deviation"}, 0.2);
    std::set<int> kinds;
    for (const auto& row : table.rows) {
        const int event = static_cast<int>(row[1]);
        kinds.insert(event);
        if (row[3]) {
            EXPECT_EQ(event, none) << "learning cycles are undisturbed";
        }
        for (const std::size_t height : {4u, 5u, 6u})
            if (row[height] != 0) {
                EXPECT_GE(std::abs(row[height]), 0.1);
                EXPECT_LE(std::abs(row[height]), event == wrong_part   ? 5
                                                 : event == wrong_tool ? 2
                                                 : event == stock      ? 0.3
                                                                       : 0.5);
            }
    }
    for (int event = air_cut; event <= edited; ++event) EXPECT_EQ(kinds.count(event), 1u) << event;
}

TEST_F(SimPartProgram, EventRateIsTheShareOfCycles) {
    set("event-rate", 0.3);
    set("cycle-interval", 0);
    set("contact-feed", 100);
    set("event-smallest", 0.02);
    set("event-largest", 0.05);
    const Table table =
        trace(8000, {"cycle", "truth-event", "program-id", "chip-height", "tool-deviation"}, 0.2);
    std::set<double> cycles, upset;
    double id = 1;
    for (const auto& row : table.rows) {
        cycles.insert(row[1]);
        if ((row[2] != none && row[2] != edited) || row[3] != id) upset.insert(row[1]);
        id = row[3];
        for (const std::size_t height : {4u, 5u})
            if (row[height] != 0) {
                EXPECT_GE(std::abs(row[height]), 0.02);
                EXPECT_LE(std::abs(row[height]), 0.05);
            }
    }
    const double n = static_cast<double>(cycles.size());
    EXPECT_GT(n, 150);
    EXPECT_NEAR(static_cast<double>(upset.size()) / n, 0.3, 4 * std::sqrt(0.3 * 0.7 / n));
}

TEST(SimPartPrograms, SameSeedGivesTheSameBitsAndAnotherOneAnotherProgram) {
    const auto rows = [](int seed, const std::string& others = "") {
        Bench bench;
        bench.command("loadrt sim_part_program names=program" + others);
        if (!others.empty()) bench.command("addf other.update servo-thread");
        bench.command("addf program.update servo-thread");
        bench.set("program.seed", seed);
        bench.set("program.event-rate", 0.5);
        return bench
            .trace(700, {"program.z-position-cmd", "program.spindle-speed-cmd", "program.stock-deviation"},
                   0.1)
            .rows;
    };
    EXPECT_EQ(rows(3), rows(3));
    EXPECT_EQ(rows(3), rows(3, ",other")) << "another instance changes nothing";
    EXPECT_NE(rows(3), rows(4));
}

TEST(SimPartPrograms, DrawnOnesMillWithinTheirRangesInAMinute) {
    Bench bench;
    std::string names, separator;
    for (int seed = 1; seed <= 12; ++seed) {
        names += separator + "p" + std::to_string(seed);
        separator = ",";
    }
    bench.command("loadrt sim_part_program names=" + names);
    for (int seed = 1; seed <= 12; ++seed) {
        const std::string p = "p" + std::to_string(seed) + ".";
        bench.command("addf " + p + "update servo-thread");
        bench.set(p + "seed", seed);
        bench.expect(
            "top <= 0 && top >= -10 && diameter >= 8 && diameter <= 32 && speed >= 0 && speed <= 8000",
            {{"top", p + "work-top"}, {"diameter", p + "tool-diameter"}, {"speed", p + "spindle-speed-cmd"}});
    }
    bench.run(62);
    for (int seed = 1; seed <= 12; ++seed)
        EXPECT_TRUE(bench.get("p" + std::to_string(seed) + ".cycle-complete")) << seed;
}

TEST(SimPartPrograms, ThreadPeriodDoesNotMatter) {
    struct End {
        double time, deepest;
    };
    const auto end = [](const std::string& period) {
        Bench bench(Bench::Thread::none);
        bench.command("loadrt threads name1=t period1=" + period);
        bench.command("loadrt sim_part_program names=program");
        bench.command("addf program.update t");
        bench.command("start");
        double deepest = 0;
        const Table table = bench.trace(70, {"program.cycle-complete", "program.z-position-cmd"}, 0.004);
        for (const auto& row : table.rows) {
            if (row[1]) return End{row[0], deepest};
            deepest = std::min(deepest, row[2]);
        }
        return End{};
    };
    EXPECT_NEAR(end("1000000").time, end("4000000").time, 0.3);
    EXPECT_NEAR(end("1000000").deepest, end("4000000").deepest, 1e-9);
}

TEST_F(SimPartProgram, ImpossibleSettingsDoNotStopIt) {
    bench.expect("finite(z) && finite(v) && finite(s) && finite(h) && abs(v) <= 300.001",
                 {{"z", "program.z-position-cmd"},
                  {"v", "program.z-velocity-cmd"},
                  {"s", "program.stock-deviation"},
                  {"h", "program.tool-deviation"}});
    set("cycle-interval", 70);
    double cycle = 0;
    for (const char* pin : {"cycle-interval", "contact-feed", "blank-repeatability", "event-rate",
                            "event-height", "event-factor", "event-smallest", "event-largest"}) {
        bench.poison(std::string("program.") + pin, 23);
        bench.run(400);
        EXPECT_GT(get("cycle"), cycle + 2) << pin;
        cycle = get("cycle");
    }
}

}  // namespace
}  // namespace plumb
