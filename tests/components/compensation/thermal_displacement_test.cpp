// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/live.hpp"
#include "tests/support/milling.hpp"
#include "tests/support/place.hpp"

#include <cmath>
#include <limits>
#include <sstream>

namespace plumb {
namespace {

// Of status-code
constexpr int fault = 1, works = 40, load_lost = 41, learning_failed = 44, no_contact = 51, asks = 53,
              asks_origin = 54, asks_of_tool = 56, program_event = 58, held_back = 62, waits = 63,
              learns_again = 64;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// On the simulated mill, a part a minute: the second one is being cut, and the offset is on its way.
void bring_to_life(Bench& bench) {
    bench.source(source_folder() + "/configs/mill/bench.hal");
    bench.set("program.cycle-interval", 60);
    bench.command("net refused growth.reference-refused => growth.acknowledge");  // as an operator does
    bench.command("start");
    bench.run(71);
}

// For as long as the rest of that part takes, and the start of the next; then that one, and another contact.
const Live live{{{"thermal_displacement", "growth"}}, bring_to_life, 50, 80};

// A mill that is seen by thermal_displacement, through its pins. The offset is applied between two cycles.
struct Mill {
    explicit Mill(double unit = 1, long period = 1000000) {
        milling.unit = unit;
        milling.dt = 0.004;  // of the rows that are replayed
        bench.command("loadrt threads name1=servo-thread period1=" + std::to_string(period));
        bench.command(std::string("loadrt thermal_displacement names=z interlock=no") +
                      (unit != 1 ? " unit=inch" : ""));
        bench.command("addf z.update servo-thread");
        bench.command("start");
        set("enable", 1);
        set("follow-speed", 0);  // it grows in steps, which do not depend on its speed
        set("max-growth-rate", 0.01 * unit);
    }

    void set(const std::string& pin, double value) { bench.set("z." + pin, value); }
    double get(const std::string& pin) { return bench.get("z." + pin); }
    double offset() { return get("z-offset") / milling.unit; }  // mm

    // Prepares the signals of a cycle. Returns how long it lasts.
    double prepare(double growth, std::map<int, Milling::Upset> upsets = {}) {
        milling.growth = growth;
        milling.upsets = std::move(upsets);
        milling.offset = stage(offset());
        cutting.clear();
        std::ostringstream csv;
        csv.precision(15);
        csv << "time";
        for (const char* pin : {"enable", "learn", "cycle-running", "cycle-complete", "program-id",
                                "tool-set-id", "motion-type", "tool-number", "operation", "load",
                                "spindle-speed-cmd", "z-position", "z-velocity-cmd", "feed-override",
                                "start-height", "applied-offset", "work-offset", "tool-length"})
            csv << ",z." << pin;
        csv << '\n';
        double time = 0;
        milling.cycle([&](const Milling::Sample& s) {
            csv << time << ',' << s.enable << ',' << s.learn << ',' << s.cycle_running << ','
                << s.cycle_complete << ',' << s.setup.program << ',' << s.setup.tool_set << ',' << s.motion
                << ',' << s.tool << ',' << s.operation << ',' << s.load << ',' << s.speed << ',' << s.z << ','
                << s.velocity << ',' << s.feed_override << ',' << s.start_height << ',' << s.applied_offset
                << ',' << s.work_offset << ',' << s.tool_length << '\n';
            cutting.push_back(milling.cutting && s.velocity <= 0);
            time += milling.dt;
            return milling.unit * milling.offset;
        });
        bench.client().replay({folder.write("cycle.csv", csv.str())});
        return time;
    }
    void cycle(double growth, std::map<int, Milling::Upset> upsets = {}) {
        bench.run(prepare(growth, std::move(upsets)) - milling.dt);
    }
    void learn(double growth = 0) {
        milling.learn = true;
        cycle(growth);
        milling.learn = false;
    }

    // The cycle is aborted in its third plunge.
    void abort(double growth = 0) {
        Milling::Upset upset;
        upset.abort = true;
        cycle(growth, {{2, upset}});
    }

    // Returns the offset that the stage applies, in mm.
    std::function<double(double)> stage = [](double offset) { return offset; };
    Milling milling{};
    Bench bench{Bench::Thread::none};
    Folder folder{};
    std::vector<bool> cutting{};  // row by row: in the work, and not on the way out
};

TEST(ThermalDisplacement, OffsetReachesTheGrowthByEitherMethod) {
    for (const bool by_time : {false, true}) {
        Mill mill;
        mill.set("by-time", by_time);
        mill.learn();
        EXPECT_TRUE(mill.get("reference-valid"));
        EXPECT_EQ(mill.get("z-offset"), 0);
        for (const double growth : {12 * um, 12 * um, 20 * um, 8 * um}) {
            mill.cycle(growth);
            EXPECT_NEAR(mill.offset(), growth, 1 * um) << by_time;
        }
        EXPECT_EQ(mill.get("contacts"), 20);
        EXPECT_EQ(mill.get("contacts-accepted"), 16);
        EXPECT_EQ(mill.get("contacts-missed"), 0);
    }
}

TEST(ThermalDisplacement, WorksInInchesAndAtOtherPeriods) {
    for (const long period : {500000, 2000000})
        for (const double unit : {1.0, 1 / 25.4}) {
            Mill mill(unit, period);
            mill.learn();
            for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
            EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << period << ' ' << unit;
        }
}

// Trap: the offset jumps while the tool cuts.
TEST(ThermalDisplacement, ApplyingAtTheContactStepsInTheWorkOursRampsAboveIt) {
    Mill mill;
    mill.learn();
    const double seconds = mill.prepare(12 * um);
    const Table seen =
        mill.bench.trace(seconds - mill.milling.dt, {"z.z-offset", "z.displacement", "z.contact"});
    const std::vector<double> ours = seen.column("z.z-offset");
    const std::vector<double> literal = seen.column("z.displacement");  // applied as soon as it is known
    double literal_step = 0, our_step = 0;
    for (std::size_t i = 1; i < ours.size(); ++i) {
        our_step = std::max(our_step, std::abs(ours[i] - ours[i - 1]));
        const std::size_t row = (i - 1) / 4;  // and the next one, towards which the signals move
        if (!mill.cutting.at(row) || !mill.cutting.at(row + 1)) continue;
        literal_step = std::max(literal_step, std::abs(literal[i] - literal[i - 1]));
        EXPECT_EQ(ours[i], ours[i - 1]) << i;
    }
    EXPECT_NEAR(literal_step, 12 * um, 1 * um) << "at once, and in the work";
    EXPECT_LE(our_step, 0.01 * 0.001 * (1 + 1e-9));
    EXPECT_NEAR(ours.back(), 12 * um, 1 * um);
    double pulses = 0;
    for (const double contact : seen.column("z.contact")) pulses += contact;
    EXPECT_EQ(pulses, 4);
}

TEST(ThermalDisplacement, OffsetNeverMovesFasterThanMaxRate) {
    Mill mill;
    mill.set("max-rate", 2 * um);
    mill.bench.expect("abs(offset_rate) <= 0.002 * (1 + 1e-6)", {{"offset", "z.z-offset"}});
    mill.learn();
    for (const double growth : {14 * um, 0 * um}) mill.cycle(growth);
    mill.set("enable", 0);
    mill.bench.run(5);
    mill.set("enable", 1);
    for (int n = 0; n < 2; ++n) mill.cycle(14 * um);
    EXPECT_NEAR(mill.offset(), 14 * um, 1 * um);
}

TEST(ThermalDisplacement, ASmallChangeIsLeft) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    const double before = mill.offset();
    mill.cycle(13 * um);
    EXPECT_EQ(mill.offset(), before);
    EXPECT_NEAR(mill.get("displacement"), 13 * um, 0.5 * um);
    mill.set("tolerance", 0.5 * um);
    mill.cycle(13 * um);
    EXPECT_NEAR(mill.offset(), 13 * um, 0.5 * um);
}

TEST(ThermalDisplacement, ByTimeATimeMayBeTooSmallToo) {
    Mill mill;
    mill.set("by-time", 1);
    mill.set("time-tolerance", 0.010);  // 20 um at 2 mm/s
    mill.learn();
    mill.cycle(12 * um);
    EXPECT_EQ(mill.offset(), 0);
    mill.set("time-tolerance", 0.002);
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
}

TEST(ThermalDisplacement, DryRunComparesAndAppliesNothing) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    mill.set("dry-run", 1);
    mill.bench.run(5);
    EXPECT_EQ(mill.get("z-offset"), 0);
    mill.cycle(20 * um);
    EXPECT_EQ(mill.get("z-offset"), 0);
    EXPECT_EQ(mill.get("contacts-accepted"), 8);
    EXPECT_NEAR(mill.get("displacement"), 20 * um, 1 * um);
}

TEST(ThermalDisplacement, DisablingReturnsTheOffsetAndEnablingWaitsForAPart) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    mill.set("enable", 0);
    mill.bench.run(5);
    EXPECT_EQ(mill.get("z-offset"), 0);
    mill.set("enable", 1);
    mill.bench.run(5);
    EXPECT_EQ(mill.get("z-offset"), 0);
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
}

TEST(ThermalDisplacement, AWarmMachineLearnsWithItsOffsetAndSubtractsTheGrowth) {
    for (const bool by_time : {false, true}) {
        Mill mill;
        mill.set("by-time", by_time);
        mill.learn();
        for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
        const double before = mill.offset();
        mill.bench.expect("abs(offset - " + std::to_string(before) + ") < 0.0005", {{"offset", "z.z-offset"}});
        for (int n = 0; n < 3; ++n) {  // learned again and again, it does not wander
            mill.learn(12 * um);
            EXPECT_FALSE(mill.get("learning-failed"));
        }
        for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
        EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << by_time;
    }
}

TEST(ThermalDisplacement, LearnsWhileAnotherSourceMovesTheStage) {
    for (const bool by_time : {false, true}) {
        Mill mill;
        mill.set("by-time", by_time);
        mill.stage = [](double) { return 12 * um; };  // does not follow
        mill.learn();
        EXPECT_FALSE(mill.get("learning-failed"));
        mill.stage = [](double offset) { return offset; };
        for (int n = 0; n < 2; ++n) mill.cycle(10 * um);
        EXPECT_NEAR(mill.offset(), 10 * um, 1 * um) << by_time;
    }
}

TEST(ThermalDisplacement, EightProgramsInTurnShareTheGrowth) {
    Mill mill;
    mill.learn();
    for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
    for (int program = 8; program < 15; ++program) {  // each on other work
        mill.milling.setup.program = program;
        mill.milling.program = {{10, 1, -20.0 - program}, {20, 2, -25}};
        mill.learn(12 * um);
        EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << "the part is good";
    }
    EXPECT_EQ(mill.get("rows"), 4 + 7 * 2);
    for (const double growth : {12 * um, 20 * um}) {
        for (int program = 8; program < 15; ++program) {
            mill.milling.setup.program = program;
            mill.milling.program = {{10, 1, -20.0 - program}, {20, 2, -25}};
            mill.cycle(growth);
            EXPECT_EQ(mill.get("detail-code"), 0) << program;
            EXPECT_NEAR(mill.offset(), growth, 2 * um) << program;
        }
    }
    mill.milling.setup.program = 7;
    mill.milling.program = Milling{}.program;
    mill.cycle(20 * um);
    EXPECT_NEAR(mill.offset(), 20 * um, 1 * um);
    EXPECT_EQ(mill.get("contacts-rejected"), 0);
    mill.milling.setup.program = 15;
    mill.learn(20 * um);  // a ninth, in place of the one that has not run for the longest time
    EXPECT_EQ(mill.get("rows"), 4 + 6 * 2 + 4);
    mill.milling.setup.program = 8;
    mill.cycle(20 * um);
    EXPECT_TRUE(mill.get("reference-refused"));
    EXPECT_EQ(mill.get("detail-code"), 21);
}

TEST(ThermalDisplacement, ALearningPartThatFailsChangesNothing) {
    Mill mill;
    mill.learn();
    for (int n = 0; n < 3; ++n) mill.cycle(34 * um);
    const double offset = mill.offset(), estimate = mill.get("growth-estimate");
    ASSERT_NEAR(offset, 34 * um, 1 * um);
    for (const int program : {7, 8}) {
        mill.milling.setup.program = program;
        mill.milling.learn = true;
        mill.abort(34 * um);
        mill.milling.learn = false;
        EXPECT_TRUE(mill.get("learning-failed"));
        EXPECT_NEAR(mill.get("growth-estimate"), estimate, 0.1 * um);
        EXPECT_EQ(mill.offset(), offset);
    }
    mill.milling.setup.program = 7;
    mill.cycle(34 * um);
    EXPECT_NEAR(mill.offset(), 34 * um, 1 * um);
}

TEST(ThermalDisplacement, AReferenceIsNoMoreCertainThanTheGrowthThatItSubtracts) {
    Mill mill;
    mill.set("follow-speed", 1);
    mill.learn();
    for (int n = 0; n < 4; ++n) mill.cycle(12 * um);
    const double known = mill.get("growth-sigma");
    mill.milling.setup.program = 8;
    mill.learn(12 * um);
    mill.set("row", 4);
    mill.bench.run(0.01);
    EXPECT_EQ(mill.get("row-program-id"), 8);
    const double common = mill.get("row-common-sigma");
    EXPECT_GE(common, 0.9 * known);
    for (int n = 0; n < 30; ++n) mill.cycle(12 * um);
    EXPECT_GE(mill.get("growth-sigma"), 0.8 * common) << "its own contacts do not know better";
    mill.set("row", 0);
    mill.bench.run(0.01);
    EXPECT_EQ(mill.get("row-common-sigma"), 0) << "the growth counts from there";
}

TEST(ThermalDisplacement, AnAbortedLearningCycleIsNoReference) {
    Mill mill;
    mill.milling.learn = true;
    mill.abort();
    EXPECT_FALSE(mill.get("reference-valid"));
    EXPECT_TRUE(mill.get("learning-failed"));
    EXPECT_EQ(mill.get("rows"), 0);
}

TEST(ThermalDisplacement, AfterAPartFromWhichNothingWasLearntTheNextOneIsLearntFromByItself) {
    Mill mill;
    mill.milling.learn = true;
    mill.abort();
    mill.milling.learn = false;
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("status-code"), learns_again);
    EXPECT_EQ(mill.get("detail-code"), 11);
    mill.cycle(0);
    EXPECT_TRUE(mill.get("reference-valid"));
    EXPECT_FALSE(mill.get("learning-failed"));
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << "and no other one";

    mill.milling.learn = true;
    mill.abort(12 * um);
    mill.milling.learn = false;
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << "the reference that there is stays";

    Mill other;
    other.milling.learn = true;
    other.abort();
    other.milling.learn = false;
    ++other.milling.setup.program;
    other.cycle(0);
    EXPECT_EQ(other.get("rows"), 0) << "of another program";
}

TEST(ThermalDisplacement, OnlyOnePartMoreIsLearntFromByItself) {
    Mill mill;
    mill.milling.learn = true;
    mill.abort();
    mill.milling.learn = false;
    mill.abort();
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("status-code"), learning_failed);
    mill.cycle(0);
    EXPECT_EQ(mill.get("rows"), 0);
}

TEST(ThermalDisplacement, SaysOnceThatAReferenceIsTooUncertainForTheWork) {
    for (const double tolerance : {10 * um, 0.5 * um}) {
        Mill mill;
        mill.set("work-tolerance", tolerance);
        mill.learn();
        EXPECT_EQ(mill.get("poor-load"), tolerance < 1 * um);
        EXPECT_NEAR(mill.get("reference-sigma"), 0.5 * um, 0.1 * um);
        mill.cycle(0);
        EXPECT_FALSE(mill.get("poor-load"));
    }
}

TEST(ThermalDisplacement, OfALoadFromWhichNothingIsLearntItSaysHowRoughItIs) {
    Mill mill;
    mill.milling.noise = 2;
    mill.set("gate-floor", 3 * um);
    mill.set("threshold", 5);
    mill.learn();
    EXPECT_EQ(mill.get("detail-code"), 14);
    EXPECT_GT(mill.get("displacement-sigma"), 3 * um);
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("status-code"), learning_failed) << "another part shows no more";
}

TEST(ThermalDisplacement, AnEventBeyondTheGateShiftsNothing) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    const double before = mill.offset();
    Milling::Upset chip;
    chip.height = 0.08;
    mill.cycle(12 * um, {{3, chip}});
    EXPECT_EQ(mill.offset(), before);
    EXPECT_EQ(mill.get("contacts-rejected"), 1);
    EXPECT_EQ(mill.get("detail-code"), 38);
}

TEST(ThermalDisplacement, OffsetIsBoundedAndReportsIt) {
    Mill mill;
    mill.set("max-offset", 5 * um);
    mill.learn();
    mill.cycle(12 * um);
    EXPECT_DOUBLE_EQ(mill.get("z-offset"), 5 * um);
    EXPECT_TRUE(mill.get("limited"));
    mill.cycle(0);
    EXPECT_NEAR(mill.offset(), 0, 0.5 * um);
    EXPECT_FALSE(mill.get("limited"));
}

TEST(ThermalDisplacement, AnOffsetOnItsWayNeverPassesABoundThatFalls) {
    Bench bench(Bench::Thread::none);
    bring_to_life(bench);
    const double bound = bench.get("growth.max-offset"), period = 0.001;
    for (int i = 0; i < 40; ++i) {
        bench.run(0.05 + period * i);
        double before = std::abs(bench.get("growth.z-offset"));
        ASSERT_GT(before, 0);
        bench.set("growth.max-offset", 0);
        for (int k = 0; k < 40; ++k) {
            bench.run(period);
            const double now = std::abs(bench.get("growth.z-offset"));
            EXPECT_LE(now, before) << i;
            before = now;
        }
        bench.set("growth.max-offset", bound);
    }
}

TEST(ThermalDisplacement, ALostSignalHoldsTheOffsetAndIsNamed) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    const double before = mill.get("z-offset");
    const std::map<std::string, double> codes{
        {"load", 1},           {"z-position", 2},    {"z-velocity-cmd", 2}, {"spindle-speed-cmd", 3},
        {"applied-offset", 4}, {"feed-override", 5}, {"start-height", 5}};
    for (const auto& [pin, code] : codes) {
        const double own = mill.get(pin);
        for (const double bad : {not_a_number, -1e308}) {
            mill.set(pin, bad);
            mill.bench.run(0.5);
            EXPECT_EQ(mill.get("detail-code"), code) << pin;
            EXPECT_TRUE(mill.get("fault"));
            EXPECT_EQ(mill.get("z-offset"), before) << pin;
        }
        mill.set(pin, own);
        mill.bench.run(0.5);
        EXPECT_FALSE(mill.get("fault")) << pin;
    }
    mill.set("load", not_a_number);
    mill.set("enable", 0);
    mill.bench.run(5);
    EXPECT_EQ(mill.get("z-offset"), 0) << "a lost signal does not keep an offset that is not wanted";
}

TEST(ThermalDisplacement, ALostSignalStopsTheOffsetOnItsWay) {
    Mill mill;
    mill.set("max-rate", 0.2 * um);
    mill.learn();
    mill.cycle(12 * um);
    const double on_its_way = mill.get("z-offset");
    EXPECT_GT(on_its_way, 0.5 * um);
    EXPECT_LT(on_its_way, 11 * um);
    const double position = mill.get("z-position"), load = mill.get("load");
    mill.set("z-position", not_a_number);
    mill.set("cycle-running", 1);
    mill.bench.run(5);
    EXPECT_NEAR(mill.get("z-offset"), on_its_way, 0.001 * um);
    mill.set("z-position", position);
    mill.bench.run(1);
    const double later = mill.get("z-offset");
    EXPECT_GT(later, on_its_way);
    mill.set("load", not_a_number);
    mill.bench.run(5);
    EXPECT_NEAR(mill.get("z-offset"), later, 0.001 * um);
    mill.set("load", load);
    mill.bench.run(100);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
}

TEST(ThermalDisplacement, ALoadThatIsNotValidHoldsInTheCycleAndFadesFromTheNextOnesOn) {
    for (const bool by_pin : {true, false}) {
        Mill mill;
        mill.set("hold-time", 60);
        mill.learn();
        for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
        const double before = mill.get("z-offset");
        ASSERT_NEAR(mill.offset(), 12 * um, 1 * um);
        EXPECT_FALSE(mill.get("doubt"));
        const double load = mill.get("load");
        const auto begin = [&] {
            mill.set("cycle-running", 0);
            mill.bench.run(0.1);
            mill.set("cycle-running", 1);
            mill.bench.run(2);
        };
        begin();
        if (by_pin)
            mill.set("load-valid", 0);
        else
            mill.set("load", not_a_number);
        mill.bench.run(200);
        EXPECT_EQ(mill.get("z-offset"), before) << "a cycle holds, however long";
        EXPECT_TRUE(mill.get("doubt"));
        EXPECT_EQ(mill.get("status-code"), by_pin ? load_lost : fault);
        begin();
        EXPECT_NEAR(mill.get("z-offset"), 0, 0.1 * um);
        mill.set("load-valid", 1);
        mill.set("load", load);
        for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
        EXPECT_FALSE(mill.get("doubt"));
        EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
    }
}

TEST(ThermalDisplacement, AVerifyingCycleDisplacesTheOffsetByVerifyStep) {
    Mill mill;
    mill.set("verify-step", 20 * um);
    mill.learn();
    for (int n = 0; n < 2; ++n) {
        mill.set("summary-time", n == 0 ? 28800 : 1);
        mill.cycle(12 * um);
    }
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << "not asked for";
    mill.set("verify", 1);
    mill.cycle(12 * um);
    mill.set("verify", 0);
    EXPECT_NEAR(mill.offset(), 32 * um, 1 * um);
    EXPECT_EQ(mill.get("summary-parts"), 2) << "its part does not count";
    EXPECT_FALSE(mill.get("doubt")) << "contacts of the work stay where they are";
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
    mill.set("verify-step", 70 * um);
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("detail-code"), 6) << "beyond gate-cap";
}

// Operation 20 switches its load on by the program: its contact moves with the offset, as the others do with
// the growth. Only a displacement on purpose shows it, and no work that stays is accused.
TEST(ThermalDisplacement, OnlyAVerifyingCycleAccusesAnOperation) {
    Mill mill;
    Milling::Upset event;
    event.by_program = true;
    const std::map<int, Milling::Upset> upsets{{1, event}};
    mill.set("verify-step", 20 * um);
    mill.milling.learn = true;
    mill.cycle(0, upsets);
    mill.milling.learn = false;
    for (int n = 1; n <= 12; ++n) {
        mill.cycle(std::min(n, 6) * um, upsets);
        EXPECT_NE(mill.get("status-code"), program_event) << n;
    }
    const double before = mill.offset();
    mill.set("verify", 1);
    for (int n = 0; n < 2; ++n) mill.cycle(6 * um, upsets);  // the stage applies it between them
    mill.set("verify", 0);
    EXPECT_EQ(mill.get("status-code"), program_event);
    EXPECT_EQ(mill.get("contacts-rejected"), 1) << "of the operation that was withdrawn";
    mill.cycle(6 * um, upsets);
    EXPECT_NEAR(mill.offset(), before, 2 * um);
    EXPECT_EQ(mill.get("contacts-rejected"), 2);
}

// A chilled spindle that does not grow or shrinks, and one whose growth another one takes back: its speed
// says that it should grow. That is no reason to doubt contacts that agree.
TEST(ThermalDisplacement, ASpindleThatDoesNotGrowAsItsSpeedSaysIsNotAccused) {
    const std::function<double(int)> growths[]{[](int n) { return (n % 2 ? 1 : -1) * um; },
                                               [](int n) { return -std::min(n, 12) * um; },
                                               [](int n) { return std::max(0, 6 - std::abs(n - 6)) * um; }};
    for (const auto& growth : growths) {
        Mill mill(1, 4000000);
        mill.set("follow-speed", 1);
        mill.set("max-growth-rate", 0.0002);
        mill.set("expected-growth", 0.05);
        mill.learn();
        mill.bench.expect("doubt == 0 && fault == 0", {{"doubt", "z.doubt"}, {"fault", "z.fault"}});
        for (int n = 1; n <= 20; ++n) mill.cycle(growth(n));
        EXPECT_EQ(mill.get("contacts-accepted"), 80);
        EXPECT_NEAR(mill.offset(), growth(20), 3 * um);
    }
}

// Twice the error to expect is tolerated, or half of it.
TEST(ThermalDisplacement, ADoubtIsAboutTheToleranceOfTheWork) {
    for (const double unit : {1.0, 1 / 25.4}) {
        Mill mill(unit);
        EXPECT_NEAR(mill.get("work-tolerance"), 10 * um * unit, 1e-9);
        mill.milling.noise = 0.5;
        mill.learn();
        for (int n = 0; n < 2; ++n) mill.cycle(12 * um);
        const double sigma = mill.get("offset-sigma");
        ASSERT_GT(sigma, 1 * um * unit);
        ASSERT_LT(sigma, 6 * um * unit);
        EXPECT_FALSE(mill.get("doubt"));
        mill.set("work-tolerance", sigma / 2);
        mill.bench.run(0.2);
        EXPECT_TRUE(mill.get("doubt"));
        mill.set("work-tolerance", sigma * 2);
        mill.bench.run(0.2);
        EXPECT_FALSE(mill.get("doubt"));
    }
}

TEST(ThermalDisplacement, AGrowthOfWhichOnlyAPartIsAppliedIsADoubt) {
    Mill mill;
    mill.set("contact-repeatability", 6 * um);  // seats and blanks
    mill.learn();
    for (int n = 1; n <= 3; ++n) mill.cycle(8 * n * um);
    EXPECT_NEAR(mill.get("displacement"), 24 * um, 1 * um);
    EXPECT_LT(mill.offset(), 12 * um);
    EXPECT_LT(mill.get("authority"), 0.5);
    EXPECT_TRUE(mill.get("doubt"));
    EXPECT_EQ(mill.get("status-code"), held_back);
    EXPECT_GT(mill.get("offset-sigma"), 12 * um);
}

TEST(ThermalDisplacement, BetweenCyclesTheOffsetStandsStillUnlessItIsTakenBack) {
    Mill mill;
    mill.set("max-rate", 0.2 * um);
    mill.learn();
    mill.cycle(12 * um);
    const double on_its_way = mill.get("z-offset");
    ASSERT_GT(on_its_way, 0.5 * um);
    mill.bench.run(100);
    EXPECT_EQ(mill.get("z-offset"), on_its_way);
    mill.set("dry-run", 1);
    mill.bench.run(1);
    EXPECT_NEAR(mill.get("z-offset"), on_its_way - 0.2 * um, 0.01 * um);
    mill.bench.run(100);
    EXPECT_EQ(mill.get("z-offset"), 0);
}

TEST(ThermalDisplacement, BadSettingsLeaveTheLastGoodOnesInForce) {
    const std::vector<std::pair<std::string, double>> bad{{"max-rate", 1e308},
                                                          {"max-rate", not_a_number},
                                                          {"max-offset", not_a_number},
                                                          {"gate-cap", 0},
                                                          {"release", 1000},
                                                          {"threshold", -1},
                                                          {"smoothing", not_a_number},
                                                          {"window", not_a_number},
                                                          {"tolerance", 1e308},
                                                          {"time-tolerance", -1},
                                                          {"load-latency", 1e308},
                                                          {"max-correction", -1},
                                                          {"reference-cycles", 0}};
    Mill mill;
    mill.bench.expect("abs(offset_rate) <= 0.01 * (1 + 1e-6)", {{"offset", "z.z-offset"}});
    mill.learn();
    double growth = 0;
    for (const auto& [pin, value] : bad) {
        SCOPED_TRACE(pin);
        const double own = mill.get(pin);
        mill.set(pin, value);
        growth = 12 * um - growth;
        mill.cycle(growth);
        EXPECT_EQ(mill.get("detail-code"), 6);
        EXPECT_NEAR(mill.offset(), growth, 1 * um);
        mill.set(pin, own);
        mill.bench.run(0.04);
        EXPECT_FALSE(mill.get("fault"));
    }
}

TEST(ThermalDisplacement, AShiftIsAskedAboutAndTheOffsetLeavesItOutUntilItIsAnswered) {
    for (const bool growth : {false, true}) {
        Mill mill;
        mill.set("max-growth-rate", 0.0002);
        mill.set("at-doubt", 1);
        mill.learn();
        for (int n = 0; n < 3; ++n) mill.cycle(1 * um);
        EXPECT_NEAR(mill.offset(), 0, 2 * um);
        EXPECT_FALSE(mill.get("doubt"));
        mill.bench.expect(growth ? "abs(offset) < 0.033" : "abs(offset) < 0.003", {{"offset", "z.z-offset"}});
        for (int n = 0; n < 4; ++n) mill.cycle(31 * um);  // blanks 30 um higher
        EXPECT_TRUE(mill.get("doubt"));
        EXPECT_NEAR(mill.get("shift-size"), 30 * um, 1 * um);
        EXPECT_TRUE(mill.get("wait"));
        EXPECT_NEAR(mill.offset(), 0, 2 * um);
        EXPECT_EQ(mill.get("status-code"), asks);
        mill.set("work-tolerance", 80 * um);  // half of it matters
        mill.bench.run(0.1);
        EXPECT_EQ(mill.get("shift-size"), 0);
        EXPECT_FALSE(mill.get("wait"));
        mill.set("work-tolerance", 10 * um);
        mill.set("row", 0);
        mill.bench.run(0.1);
        EXPECT_EQ(mill.get("status-code"), asks);
        const double reference = mill.get("row-coordinate");
        mill.set(growth ? "shift-is-growth" : "shift-is-not-growth", 1);
        mill.bench.run(0.04);
        EXPECT_FALSE(mill.get("doubt"));
        EXPECT_EQ(mill.get("shift-size"), 0);
        EXPECT_FALSE(mill.get("wait"));
        EXPECT_NEAR(mill.get("row-coordinate") - reference, growth ? 0 : 30 * um, 1 * um);
        for (int n = 0; n < 2; ++n) mill.cycle(31 * um);
        EXPECT_NEAR(mill.offset(), (growth ? 31 : 1) * um, 2 * um);
        EXPECT_FALSE(mill.get("doubt"));
    }
}

TEST(ThermalDisplacement, AtADoubtPartsGoOnOrTheNextOneWaitsOrItCalls) {
    for (const bool question : {false, true})
        for (const int choice : {0, 1, 2, 7}) {
            SCOPED_TRACE(testing::Message() << question << choice);
            Mill mill;
            mill.set("at-doubt", choice);
            mill.set("max-growth-rate", 0.0002);
            mill.learn();
            for (int n = 0; n < 3; ++n) mill.cycle(1 * um);
            const auto expect = [&](bool doubts) {
                mill.bench.run(0.1);
                EXPECT_EQ(mill.get("wait"), doubts && choice == 1);
                EXPECT_EQ(mill.get("call"), doubts && choice == 2);
            };
            expect(false);
            const double sigma = mill.get("offset-sigma");
            if (question)
                for (int n = 0; n < 2; ++n) mill.cycle(31 * um);
            else
                mill.set("work-tolerance", sigma / 2);
            expect(true);
            EXPECT_EQ(mill.get("unanswered-code"), !question ? 0 : choice == 7 ? 1 : choice + 1);
            if (choice == 1) {
                EXPECT_EQ(mill.get("status-code"), question ? asks : waits);
            }
            mill.set("acknowledge", 1);
            expect(false);
            mill.set("acknowledge", 0);
            expect(false);
            mill.cycle(question ? 31 * um : 1 * um);
            expect(true);  // one part was made
            mill.set(question ? "shift-is-growth" : "work-tolerance", 1);
            expect(false);
            EXPECT_EQ(mill.get("unanswered-code"), 0);
        }
}

TEST(ThermalDisplacement, AProbedFixedSurfaceAnswersAShift) {
    enum { none, unknown, first, growth, is_growth, is_no_growth };
    for (const bool grows : {false, true}) {
        Mill mill;
        mill.set("max-growth-rate", 0.0002);
        const auto check = [&](double grown) {
            mill.set("tool-number", 9);
            mill.set("surface", -200 + grown);
            mill.set("answer", 6);
            mill.bench.run(0.2);
            mill.set("answer", 0);
            mill.bench.run(0.1);
            return mill.get("check-code");
        };
        EXPECT_EQ(check(0), unknown);
        EXPECT_FALSE(mill.get("check-due"));
        mill.learn();
        EXPECT_TRUE(mill.get("check-due"));
        EXPECT_EQ(check(0), first);
        EXPECT_TRUE(mill.get("check-news"));
        EXPECT_FALSE(mill.get("check-due"));
        for (int n = 1; n <= 3; ++n) {
            mill.cycle(1 * um);
            EXPECT_EQ(mill.get("check-code"), none);
            EXPECT_FALSE(mill.get("check-due"));
        }
        EXPECT_EQ(check(1 * um), growth);
        EXPECT_FALSE(mill.get("check-news"));
        EXPECT_FALSE(mill.get("check-due"));
        for (int n = 0; n < 2; ++n) mill.cycle(31 * um);
        EXPECT_EQ(mill.get("status-code"), asks);
        EXPECT_TRUE(mill.get("check-due"));
        mill.set("row", 0);
        mill.bench.run(0.1);
        const double reference = mill.get("row-coordinate");
        EXPECT_EQ(check((grows ? 31 : 1) * um), grows ? is_growth : is_no_growth);
        EXPECT_TRUE(mill.get("check-news"));
        EXPECT_FALSE(mill.get("check-due"));
        EXPECT_FALSE(mill.get("doubt"));
        EXPECT_NEAR(mill.get("row-coordinate") - reference, grows ? 0 : 30 * um, 1 * um);
        mill.cycle(31 * um);
        EXPECT_NEAR(mill.offset(), (grows ? 31 : 1) * um, 2 * um);
        EXPECT_FALSE(mill.get("doubt"));
    }
}

TEST(ThermalDisplacement, AChangedZeroIsExplainedByAPinByM68OrAfterwardsByAnAnswer) {
    for (const int by : {0, 1, 2}) {
        Mill mill;
        mill.set("max-growth-rate", 0.0002);
        mill.set("at-doubt", 1);
        mill.learn();
        for (int n = 1; n <= 3; ++n) mill.cycle(3 * n * um);
        EXPECT_NEAR(mill.offset(), 9 * um, 1 * um);
        if (by == 0) mill.set("change-is-depth", 1);
        if (by == 1) mill.set("answer", 5);
        mill.milling.zero = -8 * um;
        mill.cycle(9 * um);
        EXPECT_NEAR(mill.offset(), 9 * um, 1 * um) << "it keeps the growth";
        EXPECT_EQ(mill.get("doubt"), by == 2);
        EXPECT_NEAR(mill.get("origin-change"), by == 2 ? -8 * um : 0, 0.01 * um);
        EXPECT_EQ(mill.get("wait"), by == 2);
        EXPECT_EQ(mill.get("status-code"), by == 2 ? asks_origin : works);
        if (by == 2) mill.set("answer", 5);
        mill.bench.run(0.1);
        for (const char* pin : {"change-is-depth", "answer"}) mill.set(pin, 0);
        EXPECT_FALSE(mill.get("doubt"));
        EXPECT_EQ(mill.get("origin-change"), 0);
        EXPECT_FALSE(mill.get("wait"));
        mill.cycle(9 * um);
        EXPECT_NEAR(mill.offset(), 9 * um, 1 * um);
        EXPECT_EQ(mill.get("contacts-rejected"), 0);
        mill.set("row", 0);
        mill.bench.run(0.04);
        EXPECT_NEAR(mill.get("row-work-offset"), -250 - 8 * um, 1e-9);
        EXPECT_EQ(mill.get("row-tool-length"), 62.5);
    }
}

// A part every 240 s on a machine that has grown; then the tool is longer and its length as well, or the
// table is higher and the zero as well. Without the offset in force, it was measured where no growth is.
TEST(ThermalDisplacement, AToolOrAZeroThatWasMeasuredAnewIsNotAskedAbout) {
    for (const double moved : {6 * um, 10 * um, 40 * um})
        for (const bool only_tool : {false, true})
            for (const bool table : {false, true})
                for (const bool dry : {false, true}) {
                    SCOPED_TRACE(std::to_string(1000 * moved) + (only_tool ? " one tool" : "") +
                                 (table ? " table" : "") + (dry ? " dry" : ""));
                    if (dry && std::abs(moved) < 15 * um) continue;  // as far as the growth
                    Mill mill;
                    mill.set("max-growth-rate", 0.0002);
                    mill.set("follow-speed", 1);
                    mill.set("dry-run", dry);
                    mill.milling.noise = 0.2;
                    if (only_tool) mill.milling.program = {{10, 1, -20}, {30, 1, -25}};
                    const auto part = [&](double growth) {
                        mill.cycle(growth);
                        mill.bench.run(180);
                    };
                    mill.learn();
                    for (const double growth : {4, 8, 11, 12, 12}) part(growth * um);
                    (table ? mill.milling.zero : mill.milling.lengths[1]) = moved;
                    (table ? mill.milling.table : mill.milling.tips[1]) = moved;
                    for (int n = 0; n < 3; ++n) {
                        part(12 * um);
                        EXPECT_NEAR(mill.get("growth-estimate"), 12 * um, 3 * um) << n;
                        EXPECT_NEAR(mill.offset(), dry ? 0 : 12 * um, 3 * um) << n;
                        EXPECT_EQ(mill.get("origin-change"), 0) << n;
                        EXPECT_EQ(mill.get("shift-size"), 0) << n;
                    }
                }
}

TEST(ThermalDisplacement, SaysWhichToolHasAnotherLengthSinceWhenAndWhetherItCutsDeeper) {
    for (const double longer : {30 * um, -30 * um}) {
        Mill mill;
        mill.set("max-growth-rate", 0.0002);
        mill.learn();
        for (int n = 0; n < 3; ++n) mill.cycle(1 * um);
        EXPECT_EQ(mill.get("shift-tool"), 0);
        mill.milling.tips[2] = longer;
        for (int n = 0; n < 3; ++n) mill.cycle(1 * um);
        EXPECT_EQ(mill.get("status-code"), asks_of_tool);
        EXPECT_EQ(mill.get("shift-tool"), 2);
        EXPECT_NEAR(mill.get("shift-size"), longer, 2 * um);
        EXPECT_EQ(mill.get("unanswered-code"), longer > 0 ? 4 : 7);
        const double age = mill.get("shift-age");
        EXPECT_GT(age, 60) << "from the first contact on, not from the question";
        mill.bench.run(100);
        EXPECT_NEAR(mill.get("shift-age") - age, 100, 0.1);
        mill.set("shift-is-not-growth", 1);
        mill.bench.run(0.1);
        EXPECT_EQ(mill.get("shift-tool"), 0);
        EXPECT_EQ(mill.get("shift-age"), 0);
    }
}

TEST(ThermalDisplacement, TheQuestionAboutAToolEndsAsTheToolIsMeasured) {
    for (const double longer : {12 * um, 30 * um, -30 * um})
        for (const bool told : {false, true}) {
            SCOPED_TRACE(std::to_string(1000 * longer) + (told ? " told" : ""));
            Mill mill;
            mill.set("max-growth-rate", 0.0002);
            mill.learn();
            for (int n = 0; n < 3; ++n) mill.cycle(3 * um);
            mill.milling.tips[2] = longer;
            for (int n = 0; n < 3; ++n) mill.cycle(3 * um);
            ASSERT_EQ(mill.get("status-code"), asks_of_tool);
            mill.milling.lengths[2] = longer;
            if (told) mill.set("answer", 3);
            for (int n = 0; n < 4; ++n) {
                mill.cycle(3 * um);
                mill.set("answer", 0);
                EXPECT_NEAR(mill.get("growth-estimate"), 3 * um, 2 * um) << n;
            }
            EXPECT_EQ(mill.get("status-code"), works);
            EXPECT_EQ(mill.get("shift-size"), 0);
            EXPECT_EQ(mill.get("origin-change"), 0);
        }
}

// Blanks 30 um higher, and then a depth 8 um lower.
TEST(ThermalDisplacement, OneQuestionIsAskedAtATimeAndTheOtherOneAfterItsAnswer) {
    Mill mill;
    mill.set("max-growth-rate", 0.0002);
    mill.learn();
    for (int n = 0; n < 3; ++n) mill.cycle(1 * um);
    for (int n = 0; n < 3; ++n) mill.cycle(31 * um);
    EXPECT_EQ(mill.get("status-code"), asks);
    mill.milling.zero = -8 * um;
    mill.cycle(31 * um);
    EXPECT_EQ(mill.get("status-code"), asks_origin);
    EXPECT_NEAR(mill.get("origin-change"), -8 * um, 0.01 * um);
    EXPECT_EQ(mill.get("shift-size"), 0) << "one at a time";
    mill.set("shift-is-growth", 1);
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("status-code"), asks_origin) << "an answer to another question";
    mill.set("answer", 5);
    mill.bench.run(0.1);
    mill.set("answer", 0);
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("origin-change"), 0);
    EXPECT_EQ(mill.get("status-code"), asks);
    EXPECT_NEAR(mill.get("shift-size"), 30 * um, 2 * um);
    mill.set("shift-is-not-growth", 1);
    for (int n = 0; n < 2; ++n) mill.cycle(31 * um);
    EXPECT_FALSE(mill.get("doubt"));
    EXPECT_NEAR(mill.offset(), 1 * um, 2 * um);
}

// Between the second and the third plunge somebody changes the zero; in the second program each cycle changes
// to another coordinate system and back, as it did when it was learned.
TEST(ThermalDisplacement, AZeroThatChangesWithinACycleIsADoubtAndAnotherCoordinateSystemIsNone) {
    for (const bool systems : {false, true}) {
        Mill mill;
        mill.set("max-growth-rate", 0.0002);
        if (systems) mill.milling.program = {{10, 1, -20}, {20, 2, -40, 4000, 0, 35}, {30, 1, -20}};
        mill.learn();
        for (int n = 1; n <= 3; ++n) mill.cycle(3 * n * um);
        EXPECT_FALSE(mill.get("doubt"));
        EXPECT_EQ(mill.get("contacts-rejected"), 0);
        EXPECT_NEAR(mill.offset(), 9 * um, 2.5 * um);
        if (systems) continue;
        Milling::Upset deeper;
        deeper.zero = -8 * um;
        const double seconds = mill.prepare(9 * um, {{2, deeper}});
        const Table seen = mill.bench.trace(
            seconds - mill.milling.dt, {"z.status-code", "z.origin-change", "z.cycle-running", "z.contacts"});
        const std::vector<double> status = seen.column("z.status-code"), contacts = seen.column("z.contacts");
        const std::vector<double> running = seen.column("z.cycle-running");
        double told = 0;  // contacts, until the question, in this cycle
        for (std::size_t i = 0; i < status.size() && told == 0; ++i)
            if (status[i] == asks_origin && running[i] == 1) told = contacts[i] - contacts[0];
        EXPECT_EQ(told, 3) << "with the first contact after the change";
        EXPECT_NEAR(mill.get("origin-change"), -8 * um, 0.01 * um);
        EXPECT_NEAR(mill.offset(), 9 * um, 1 * um);
    }
}

TEST(ThermalDisplacement, AShiftOfWorkIsSummedUpAtTheEndOfAPart) {
    Mill mill;
    mill.set("summary-time", 150);
    mill.learn();
    EXPECT_TRUE(mill.get("learnt"));
    EXPECT_GT(mill.get("reference-sigma"), 0);
    const double sigma = mill.get("reference-sigma");
    for (const double growth : {-12 * um, 5 * um, 5 * um}) {
        int parts = 0;
        double squares = 0, largest = 0;
        do {
            mill.set("work-tolerance", parts == 0 ? sigma / 10 : 1);  // the first part is in doubt
            const double seconds = mill.prepare(growth) - mill.milling.dt;
            const Table seen = mill.bench.trace(seconds, {"z.cycle-running", "z.z-offset"});
            const std::vector<double> running = seen.column("z.cycle-running");
            const std::vector<double> offset = seen.column("z.z-offset");
            for (std::size_t i = 0; i < running.size(); ++i)
                if (running[i] == 1 && std::abs(offset[i]) > std::abs(largest)) largest = offset[i];
            EXPECT_FALSE(mill.get("learnt"));
            squares += std::pow(mill.get("offset-sigma"), 2);
            ASSERT_LT(++parts, 20);
        } while (!mill.get("summary"));
        EXPECT_GT(parts, 2);
        EXPECT_EQ(mill.get("summary-parts"), parts);
        EXPECT_NEAR(mill.get("summary-offset"), largest, 0.1 * um);
        EXPECT_NEAR(mill.get("summary-sigma"), std::sqrt(squares / parts), 0.1 * um);
        EXPECT_NEAR(mill.get("summary-doubt"), 100.0 / parts, 1e-9);
    }
    mill.cycle(5 * um);
    EXPECT_FALSE(mill.get("summary")) << "it ends with the next part";
}

TEST(ThermalDisplacement, ConstantInPartChangesTheOffsetOnlyAtTheStartOfACycle) {
    Mill mill;
    mill.set("constant-in-part", 1);
    mill.learn();
    mill.cycle(12 * um);
    EXPECT_EQ(mill.offset(), 0) << "its contacts come after its start";
    mill.bench.expect("offset < 0.013", {{"offset", "z.z-offset"}});
    mill.cycle(20 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um) << "of the part before";
}

TEST(ThermalDisplacement, AfterARestartTheGrowthIsUnknownBeforeTheFirstCut) {
    Mill mill;
    mill.learn();
    mill.cycle(5 * um);
    EXPECT_FALSE(mill.get("doubt"));
    mill.set("row", 0);
    mill.bench.run(0.04);
    std::map<std::string, double> kept;
    for (const char* field :
         {"operation", "tool", "occurrence", "coordinate", "time", "lost-time", "feed", "feed-override",
          "applied-offset", "sigma", "time-constant", "program-id", "tool-set-id", "speed-history",
          "temperature", "date", "cycles", "scatter", "kink"})
        kept[field] = mill.get(std::string("row-") + field);
    EXPECT_GT(mill.offset(), 3 * um);
    mill.set("forget", 1);
    mill.bench.run(2);
    EXPECT_EQ(mill.offset(), 0) << "without a reference nothing is corrected";
    for (const auto& [field, value] : kept) mill.set("restore-" + field, value);
    mill.set("restore", 1);
    mill.bench.run(0.04);
    EXPECT_EQ(mill.get("restores"), 1);
    EXPECT_TRUE(mill.get("doubt"));
    EXPECT_EQ(mill.get("status-code"), no_contact);
    mill.set("constant-in-part", 1);
    mill.cycle(20 * um);
    EXPECT_EQ(mill.offset(), 0) << "no step in the first part";
    for (int n = 0; n < 2; ++n) mill.cycle(20 * um);  // one contact each: the second one decides
    EXPECT_NEAR(mill.offset(), 20 * um, 2 * um);
    EXPECT_FALSE(mill.get("doubt"));
}

TEST(ThermalDisplacement, EverySettingIsJudged) {
    Mill mill;
    for (const std::string pin : {"threshold",
                                  "release",
                                  "smoothing",
                                  "debounce",
                                  "blanking-time",
                                  "load-latency",
                                  "reference-cycles",
                                  "window",
                                  "max-growth-rate",
                                  "gate-floor",
                                  "gate-cap",
                                  "max-correction",
                                  "expected-growth",
                                  "unexplained-growth",
                                  "contact-repeatability",
                                  "surface-repeatability",
                                  "temperature-growth",
                                  "tolerance",
                                  "time-tolerance",
                                  "max-offset",
                                  "max-rate",
                                  "work-tolerance"}) {
        const double own = mill.get(pin);
        mill.set(pin, -1);
        mill.bench.run(0.04);
        EXPECT_EQ(mill.get("detail-code"), 6) << pin;
        mill.set(pin, own);
        mill.bench.run(0.04);
        EXPECT_FALSE(mill.get("fault")) << pin;
    }
}

TEST(ThermalDisplacement, EveryFieldOfAReferenceComesBackAsItWasRestored) {
    const std::map<std::string, double> reference{{"operation", 10},       {"tool", 2},
                                                  {"occurrence", 3},       {"coordinate", -1.25},
                                                  {"time", 4.5},           {"lost-time", 0.125},
                                                  {"feed", -1.5},          {"feed-override", 0.875},
                                                  {"sigma", 0.0625},       {"program-id", 7},
                                                  {"speed-history", 4000}, {"applied-offset", 0.03125},
                                                  {"tool-set-id", 5},      {"temperature", 21},
                                                  {"time-constant", 0.25}, {"date", 20261122},
                                                  {"cycles", 6},           {"scatter", 0.001953125},
                                                  {"work-offset", -42.5},  {"tool-length", 62.5},
                                                  {"kink", 0.00390625},    {"common-sigma", 0.0078125}};
    Mill mill;
    for (const auto& [field, value] : reference) mill.set("restore-" + field, value);
    mill.set("restore", 1);
    mill.bench.run(0.01);
    ASSERT_EQ(mill.get("restores"), 1);
    for (const auto& [field, value] : reference) EXPECT_EQ(mill.get("row-" + field), value) << field;
}

TEST(ThermalDisplacement, ReferencesAreWalkedRestoredAndRefused) {
    const std::vector<std::string> fields{
        "operation",   "tool",           "occurrence", "coordinate",    "time",       "lost-time",
        "feed",        "feed-override",  "sigma",      "speed-history", "program-id", "tool-set-id",
        "temperature", "applied-offset", "date",       "cycles",        "scatter",    "time-constant",
        "kink",        "work-offset",    "tool-length", "common-sigma"};
    Mill before;
    before.set("temperature", 21.5);
    before.set("date", 20261121);
    before.set("reference-cycles", 2);
    before.learn();
    EXPECT_EQ(before.get("cycles-learnt"), 1);
    EXPECT_FALSE(before.get("reference-valid"));
    before.milling.learn = true;
    before.cycle(4 * um);
    ASSERT_EQ(before.get("rows"), 4);
    EXPECT_EQ(before.get("cycles-learnt"), 0);
    before.bench.run(0.01);
    EXPECT_EQ(before.get("row-cycles"), 2);
    EXPECT_NEAR(before.get("row-scatter"), 4 * um / std::sqrt(2), 0.2 * um);
    EXPECT_EQ(before.get("row-temperature"), 21.5);
    EXPECT_EQ(before.get("row-date"), 20261121);
    EXPECT_EQ(before.get("row-tool-set-id"), 3);
    Mill after;  // which no program has been loaded into yet
    const auto restore = [&](int row) {
        before.set("row", row);
        before.bench.run(0.01);
        EXPECT_EQ(before.get("row-shown"), row);
        for (const std::string& field : fields) after.set("restore-" + field, before.get("row-" + field));
        after.set("restore", 1);
        after.bench.run(0.01);
        after.set("restore", 0);
        after.bench.run(0.01);
    };
    for (int row = 0; row < 4; ++row) {
        restore(row);
        after.set("row", row);
        after.bench.run(0.01);
        for (const std::string& field : fields)
            EXPECT_EQ(after.get("row-" + field), before.get("row-" + field)) << field;
    }
    EXPECT_EQ(after.get("restores"), 4);
    EXPECT_FALSE(after.get("reference-valid"));
    after.cycle(32 * um);
    EXPECT_TRUE(after.get("reference-valid"));
    EXPECT_FALSE(after.get("reference-refused"));
    EXPECT_NEAR(after.offset(), 30 * um, 1 * um);
    restore(0);
    EXPECT_EQ(after.get("restores-refused"), 1) << "twice";
    before.milling.setup.program = 8;
    before.set("reference-cycles", 1);
    before.cycle(0);
    before.set("row", before.get("rows") - 1);
    restore(static_cast<int>(before.get("rows")) - 1);
    EXPECT_EQ(after.get("restores"), 5) << "of another program";
    after.set("forget", 1);
    after.bench.run(0.01);
    EXPECT_FALSE(after.get("reference-valid"));
    EXPECT_EQ(after.get("rows"), 0);
    restore(0);
    EXPECT_EQ(after.get("restores"), 6);
}

TEST(ThermalDisplacement, AProgramWithoutAReferenceHasNoOffset) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    mill.milling.setup.program = 8;
    mill.bench.expect("abs(offset_rate) <= 0.01 * (1 + 1e-6)", {{"offset", "z.z-offset"}});
    mill.cycle(12 * um);
    EXPECT_TRUE(mill.get("reference-refused"));
    EXPECT_EQ(mill.get("detail-code"), 21);
    EXPECT_FALSE(mill.get("reference-valid"));
    EXPECT_EQ(mill.get("z-offset"), 0);
    EXPECT_FALSE(mill.get("fault"));
    mill.milling.setup = {7, 4};
    mill.cycle(12 * um);
    EXPECT_TRUE(mill.get("reference-refused"));
    EXPECT_EQ(mill.get("detail-code"), 22);
    EXPECT_EQ(mill.get("z-offset"), 0);
    mill.milling.setup = {7, 3};
    mill.cycle(12 * um);
    EXPECT_FALSE(mill.get("reference-refused"));
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
}

// Where nobody is to acknowledge, the refusal acknowledges itself and yet applies nothing.
TEST(ThermalDisplacement, ARefusalThatIsNettedToAcknowledgeIsJudgedAtEachStart) {
    Mill mill;
    mill.bench.command("net refused z.reference-refused => z.acknowledge");
    mill.learn();
    mill.cycle(12 * um);
    mill.milling.setup.program = 8;
    mill.cycle(12 * um);
    EXPECT_EQ(mill.get("z-offset"), 0);
    mill.milling.setup.program = 7;
    mill.cycle(12 * um);
    EXPECT_NEAR(mill.offset(), 12 * um, 1 * um);
}

// The simulated mill begins its first part from rest, and the later ones where it has milled the sides.
TEST(ThermalDisplacement, AClockFromProgramStartWantsCyclesThatBeginAlike) {
    for (const int learning_cycles : {1, 2}) {
        Bench bench(Bench::Thread::none);
        bench.source(source_folder() + "/configs/mill/bench.hal");
        bench.set("growth.by-time", 1);
        bench.set("growth.clock-from-program", 1);
        bench.set("program.cycle-interval", 60);
        bench.set("program.learning-cycles", learning_cycles);
        bench.command("start");
        bench.run(60 * (learning_cycles + 2));
        EXPECT_EQ(bench.get("growth.contacts-accepted"), learning_cycles == 1 ? 0 : 4);
        EXPECT_EQ(bench.get("growth.contacts-rejected"), learning_cycles == 1 ? 4 : 0);
        EXPECT_EQ(bench.get("growth.detail-code"), learning_cycles == 1 ? 35 : 0);
    }
}

// The same, with a mark as each plunge begins to feed: the first part, on the cold machine, is the reference.
TEST(ThermalDisplacement, AClockFromAMarkWantsNoCyclesThatBeginAlike) {
    Bench bench(Bench::Thread::none);
    bench.source(source_folder() + "/configs/mill/bench.hal");
    for (const char* line :
         {"loadrt conv_s32_float names=motion", "loadrt comp names=feeding", "setp feeding.in0 1.5",
          "net motion-type => motion.in", "net motion-number motion.out => feeding.in1",
          "net clock-start feeding.out => growth.clock-start", "addf motion servo-thread",
          "addf feeding servo-thread"})
        bench.command(line);
    bench.set("growth.by-time", 1);
    bench.set("growth.clock-from-program", 1);
    bench.set("program.cycle-interval", 60);
    bench.command("start");
    bench.run(60 * 5);
    EXPECT_EQ(bench.get("growth.contacts-accepted"), 8);
    EXPECT_EQ(bench.get("growth.contacts-rejected"), 0);
    const double growth = bench.get("mill.truth-contact-growth");
    EXPECT_GT(growth, 15 * um);
    EXPECT_NEAR(bench.get("growth.displacement"), growth, 5 * um);
    bench.command("unlinkp growth.clock-start");
    bench.run(60);
    EXPECT_EQ(bench.get("growth.contacts-accepted"), 8) << "without the mark the cycle is the start";
    EXPECT_EQ(bench.get("growth.detail-code"), 35);
}

TEST(ThermalDisplacement, ByTimeALearningCycleWithoutAClockNamesIt) {
    Bench bench(Bench::Thread::none);
    bench.source(source_folder() + "/configs/mill/bench.hal");
    bench.command("unlinkp growth.start-height");
    bench.set("growth.start-height", -1000);
    bench.set("growth.by-time", 1);
    bench.command("start");
    bench.run(60);
    EXPECT_FALSE(bench.get("growth.reference-valid"));
    EXPECT_TRUE(bench.get("growth.learning-failed"));
    EXPECT_EQ(bench.get("growth.detail-code"), 43);
}

TEST(ThermalDisplacement, ARejectionIsTheDetailUntilAContactCountsAndAFaultHidesIt) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    EXPECT_EQ(mill.get("detail-code"), 0);
    Milling::Upset chip;
    chip.height = 0.08;
    mill.cycle(12 * um, {{3, chip}});
    ASSERT_EQ(mill.get("contacts-rejected"), 1);
    EXPECT_EQ(mill.get("detail-code"), 38);
    EXPECT_EQ(mill.get("contact-tool"), 1);
    EXPECT_EQ(mill.get("contact-operation"), 30);
    const double load = mill.get("load");
    mill.set("load", not_a_number);
    mill.bench.run(0.1);
    EXPECT_EQ(mill.get("detail-code"), 1);
    mill.set("load", load);
    mill.bench.run(0.1);
    EXPECT_FALSE(mill.get("fault"));
    EXPECT_EQ(mill.get("detail-code"), 38);
    mill.cycle(12 * um);
    EXPECT_EQ(mill.get("detail-code"), 0);
}

TEST(ThermalDisplacement, ReportsThatNothingWasAcceptedForThreeCycles) {
    Mill mill;
    mill.learn();
    mill.cycle(12 * um);
    const double before = mill.offset();
    for (int n = 0; n < 3; ++n) {
        EXPECT_FALSE(mill.get("fault"));
        mill.cycle(-90 * um);
    }
    EXPECT_EQ(mill.get("detail-code"), 7);
    EXPECT_TRUE(mill.get("fault"));
    EXPECT_EQ(mill.offset(), before);
    mill.cycle(12 * um);
    EXPECT_FALSE(mill.get("fault"));
}

}  // namespace
}  // namespace plumb
