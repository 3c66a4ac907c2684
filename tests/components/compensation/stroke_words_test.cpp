// SPDX-License-Identifier: GPL-2.0-or-later
// The words of a program in chopping: alone, and on the simulated axis.
#include "components/compensation/chopping/stroke_orders.hpp"

#include "tests/support/chopping_axis.hpp"
#include "tests/support/place.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <string>
#include <tuple>

namespace plumb {

// By all that a word replaces.
bool operator==(const StrokeSettings& one, const StrokeSettings& other) {
    const auto all = [](const StrokeSettings& its) {
        return std::tie(its.upper_dwell, its.lower_dwell, its.exact_stop, its.spark_out, its.stop_kind,
                        its.override_, its.section);
    };
    return all(one) == all(other);
}

namespace {

StrokeSettings with(const StrokeWords& words, StrokeSettings settings) {
    words.replace(settings);
    return settings;
}

struct Words : testing::Test {
    StrokeWords it;

    // As G-code gives it: the value first, and no number afterwards.
    bool give(double number, double value, bool moves = false) {
        it.step(number, value, moves);
        const bool taken = !it.refused();
        it.step(0, value, moves);
        return taken;
    }
    void give_section(double from, double to, double ratio, double kind) {
        give(StrokeWords::section_from, from);
        give(StrokeWords::section_to, to);
        give(StrokeWords::section_ratio, ratio);
        EXPECT_TRUE(give(StrokeWords::section, kind));
    }
};

TEST_F(Words, GoBeforeTheSettingsAndLeaveAllOthersAsTheyAre) {
    StrokeSettings settings;
    settings.lower_dwell = 0.5;
    settings.spark_out = 7;
    settings.section[3] = {SpeedSection::height, 1, 2, 0.5};
    EXPECT_EQ(with(it, settings), settings);

    EXPECT_TRUE(give(StrokeWords::upper_dwell, 0.25));
    EXPECT_TRUE(give(StrokeWords::spark_out, 0));
    EXPECT_TRUE(give(StrokeWords::exact_stop, 0.01));
    EXPECT_TRUE(give(StrokeWords::stop_place, 2));
    StrokeSettings wanted = settings;
    wanted.upper_dwell = 0.25;
    wanted.spark_out = 0;
    wanted.exact_stop = 0.01;
    wanted.stop_kind = StrokeSettings::at_upper;
    EXPECT_EQ(with(it, settings), wanted);
    EXPECT_EQ(wanted.stop(), Oscillation::Stop::upper);
}

TEST_F(Words, HaveTheNumbersThatProgramsGive) {
    std::ifstream file(source_folder() + "/configs/functions/chopping/chop_numbers.ngc");
    std::map<std::string, int> given;
    const std::regex assignment("#<_chop_([a-z_]+)> *= ([0-9]+).*");
    std::smatch found;
    for (std::string line; std::getline(file, line);)
        if (std::regex_match(line, found, assignment) &&
            !std::regex_match(found.str(1), std::regex(".*_output")))
            given[found[1]] = std::stoi(found[2]);
    EXPECT_THAT(given, testing::ContainerEq(std::map<std::string, int>{
                           {"upper_dwell", StrokeWords::upper_dwell},
                           {"lower_dwell", StrokeWords::lower_dwell},
                           {"exact_stop", StrokeWords::exact_stop},
                           {"spark_out", StrokeWords::spark_out},
                           {"stop_place", StrokeWords::stop_place},
                           {"overrides", StrokeWords::overrides},
                           {"section_from", StrokeWords::section_from},
                           {"section_to", StrokeWords::section_to},
                           {"section_ratio", StrokeWords::section_ratio},
                           {"section", StrokeWords::section},
                           {"without_sections", StrokeWords::without_sections},
                           {"check", StrokeWords::check},
                           {"forget", StrokeWords::forget},
                           {"abort", StrokeWords::abort},
                           {"infeed_amount", StrokeWords::infeed_amount},
                           {"infeed_total", StrokeWords::infeed_total},
                           {"infeed_at", StrokeWords::infeed_at},
                           {"go_to_end", StrokeWords::go_to_end},
                           {"new_region", StrokeWords::shift},
                       }));
}

TEST_F(Words, EachNewNumberOfAShiftOrdersOne) {
    it.step(StrokeWords::shift, 0, true);
    EXPECT_TRUE(it.shifts());
    EXPECT_FALSE(it.refused());
    it.step(StrokeWords::shift, 0, true);
    EXPECT_FALSE(it.shifts()) << "the same one";
    it.step(StrokeWords::shift + 1, 0, true);
    EXPECT_TRUE(it.shifts());
    it.step(0, 0, true);
    EXPECT_FALSE(it.shifts());
    for (const double number : {99.0, 100.5, std::nan("")}) {
        it.step(number, 0, true);
        EXPECT_TRUE(it.refused()) << number;
        EXPECT_FALSE(it.shifts()) << number;
        it.step(0, 0, true);
    }
}

TEST_F(Words, TheNumberOfAShiftThatStaysKeepsNoWordOverTheEndOfItsProgram) {
    const auto program = [&](bool runs, double seconds) {
        for (int i = 0; i < seconds / 0.001; ++i) {
            it.watch_program(runs, 0.001);
            it.step(StrokeWords::shift, 0, false);
        }
    };
    give(StrokeWords::upper_dwell, 0.25);
    program(true, 1);
    StrokeSettings settings;
    ASSERT_EQ(with(it, settings).upper_dwell, 0.25);
    program(false, 0.01);
    EXPECT_EQ(with(it, settings).upper_dwell, 0);
}

TEST_F(Words, AnOverrideOfThePanelActsOrNotAndAHoldAlways) {
    StrokeSettings settings;
    settings.override_ = 0.4;
    EXPECT_TRUE(give(StrokeWords::overrides, 0));
    EXPECT_EQ(with(it, settings).override_, 1);
    settings.override_ = 0;
    EXPECT_EQ(with(it, settings).override_, 0);
    settings.override_ = 0.4;
    EXPECT_TRUE(give(StrokeWords::overrides, 1));
    EXPECT_EQ(with(it, settings).override_, 0.4);
}

TEST_F(Words, SectionsTakeThePlaceOfAllThoseOfSettings) {
    StrokeSettings settings;
    settings.section[0] = {SpeedSection::height, 1, 2, 0.5};
    give_section(-10, -5, 0.25, SpeedSection::height_upward);
    const SpeedSections::Table given = with(it, settings).section;
    EXPECT_EQ(given[0], (SpeedSection{SpeedSection::height_upward, -10, -5, 0.25}));
    EXPECT_EQ(given[1], SpeedSection{});
    for (const double from : {0.0, 10.0, 20.0}) give_section(from, from + 1, 2, SpeedSection::height);
    EXPECT_EQ(it.sections(), 4u);
    EXPECT_FALSE(give(StrokeWords::section, 2)) << "a fifth one";
    EXPECT_TRUE(give(StrokeWords::without_sections, 0));
    EXPECT_EQ(with(it, settings).section, SpeedSections::Table{});
}

TEST_F(Words, InvalidOnesAreRefusedAndChangeNothing) {
    const StrokeSettings settings, none = with(it, settings);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    for (const double value : {-1.0, 3601.0, nan, inf, -inf, 1e308}) {
        EXPECT_FALSE(give(StrokeWords::upper_dwell, value)) << value;
        EXPECT_FALSE(give(StrokeWords::lower_dwell, value)) << value;
        EXPECT_FALSE(give(StrokeWords::stop_place, value)) << value;
        EXPECT_FALSE(give(StrokeWords::overrides, value)) << value;
        EXPECT_FALSE(give(StrokeWords::section, value)) << value;
    }
    for (const double value : {-1.0, 1.5, 2e6, nan})
        EXPECT_FALSE(give(StrokeWords::spark_out, value)) << value;
    for (const double value : {-1.0, 0.5, 4.0, nan})
        EXPECT_FALSE(give(StrokeWords::infeed_at, value)) << value;
    for (const double value : {nan, inf, 1e308})
        EXPECT_FALSE(give(StrokeWords::infeed_amount, value)) << value;
    EXPECT_FALSE(give(StrokeWords::infeed_total, -1));
    for (const double value : {-1.0, nan, inf}) EXPECT_FALSE(give(StrokeWords::exact_stop, value)) << value;
    for (const double value : {nan, inf, 1e308})
        EXPECT_FALSE(give(StrokeWords::section_from, value)) << value;
    for (const double number : {-1.0, 0.5, 19.0, 1e308, inf}) EXPECT_FALSE(give(number, 1)) << number;
    EXPECT_FALSE(give(nan, 1));
    EXPECT_FALSE(give(StrokeWords::section, 2)) << "from 0 to 0";
    EXPECT_EQ(with(it, settings), none);
}

TEST_F(Words, AreForgottenWhenTheAxisRestsOrByOrderButNeverWhileItMoves) {
    const StrokeSettings settings, none = with(it, settings);
    give(StrokeWords::upper_dwell, 0.25);
    it.step(0, 0, true);
    EXPECT_FALSE(with(it, settings) == none);
    EXPECT_TRUE(give(StrokeWords::forget, 0, true));
    EXPECT_FALSE(with(it, settings) == none);
    it.step(0, 0, false);
    EXPECT_EQ(with(it, settings), none);
    give(StrokeWords::upper_dwell, 0.25);
    give(StrokeWords::forget, 0);
    EXPECT_EQ(with(it, settings), none);
}

TEST_F(Words, EndWithTheirProgramUnlessTheyAreNewer) {
    const StrokeSettings settings, none = with(it, settings);
    const auto program = [&](bool runs, double seconds) {
        for (int i = 0; i < seconds / 0.001; ++i) {
            it.watch_program(runs, 0.001);
            it.step(0, 0, false);
        }
    };
    program(true, 0.1);
    give(StrokeWords::upper_dwell, 0.25);
    program(true, 1);
    EXPECT_FALSE(with(it, settings) == none);
    program(false, 0.01);
    EXPECT_EQ(with(it, settings), none);

    program(true, 1);
    it.step(StrokeWords::upper_dwell, 0.25, false);
    it.watch_program(true, 0.001);
    it.step(0, 0, false);
    program(true, 0.1);
    program(false, 2);
    EXPECT_FALSE(with(it, settings) == none) << "given in MDI, after the end";
}

struct ChoppingWords : ChoppingAxis {
    void give(StrokeWords::Number number, double value) {
        set("program-value", value);
        set("program-word", number);
        bench.run(0.001);
        set("program-word", 0);
        bench.run(0.001);
    }
    void give_section(double from, double to, double ratio) {
        give(StrokeWords::section_from, from);
        give(StrokeWords::section_to, to);
        give(StrokeWords::section_ratio, ratio);
        give(StrokeWords::section, SpeedSection::height);
    }
};

TEST_F(ChoppingWords, ASectionOfTheProgramSlowsItsStrokesOnly) {
    give_section(-16, -12, 0.25);
    start();
    bench.run(2);
    EXPECT_EQ(get("program-sections"), 1);
    EXPECT_GT(get("planned-cycle-time"), 1);
    set("run", 0);
    bench.run(3);
    EXPECT_EQ(get("at-end"), 1);
    EXPECT_EQ(get("program-sections"), 0);
    start();
    bench.run(2);
    EXPECT_LT(get("planned-cycle-time"), 0.7);
}

TEST_F(ChoppingWords, AStopAtTheLowerDeadPointStaysThereAndTheNextStrokesReturnToR) {
    start();
    bench.run(1.3);
    give(StrokeWords::stop_place, 1);
    set("run", 0);
    bench.run(2);
    EXPECT_EQ(get("active"), 0);
    EXPECT_NEAR(get("command"), -20, 1e-9);
    start();
    bench.run(2);
    set("run", 0);
    bench.run(2);
    EXPECT_EQ(get("at-end"), 1);

    start();
    bench.run(1.3);
    give(StrokeWords::stop_place, 2);
    set("run", 0);
    bench.run(2);
    EXPECT_NEAR(get("command"), -8, 1e-9);
    give(StrokeWords::go_to_end, 0);
    bench.run(2);
    EXPECT_EQ(get("at-end"), 1);
}

// The check moves nothing, and gives the reason as long as it is asked for.
TEST_F(ChoppingWords, AStrokeIsCheckedBeforeAnythingMoves) {
    const auto checked = [&](double end) {
        set("program-value", end);
        set("program-word", StrokeWords::check);
        bench.run(0.002);
        const double refused = get("program-refused"), code = get("fault-code");
        set("program-word", 0);
        bench.run(0.002);
        EXPECT_EQ(get("program-refused"), 0);
        EXPECT_EQ(get("fault-code"), code) << "a program that was aborted still says why";
        EXPECT_EQ(get("command"), 0);
        return refused == 0 ? 0 : static_cast<int>(code);
    };
    EXPECT_EQ(checked(0), 0);
    set("taper", 3);
    EXPECT_EQ(checked(0), 0);
    EXPECT_EQ(checked(70), static_cast<int>(Fault::soft_limit)) << "3 times 90 mm below";
    set("feed", 600);
    EXPECT_EQ(checked(0), static_cast<int>(Fault::speed));
    set("feed", 60);
    set("enable", 0);
    EXPECT_EQ(checked(0), static_cast<int>(Fault::not_ready));
}

// Its drive follows 31 ms behind: without a wait the dwell is over before the axis is there.
TEST_F(ChoppingWords, AnExactStopBeginsTheDwellWhereTheAxisIs) {
    give(StrokeWords::lower_dwell, 0.05);
    give(StrokeWords::exact_stop, 0.005);
    set("exact-stop-time", 1);
    start();
    bench.run(2);
    const auto seen = bench.trace(3, {"chop.command", "axis.truth-position"});
    const std::vector<double> command = seen.column("chop.command"),
                              axis = seen.column("axis.truth-position");
    int standing = 0, there = 0, least = 1000, strokes = 0;
    for (std::size_t i = 1; i < command.size(); ++i) {
        const bool stands = command[i] == -20 && command[i - 1] == -20;
        standing += stands;
        there += stands && std::abs(axis[i] + 20) <= 0.006;
        if (!stands && standing > 0) {
            least = std::min(least, there);
            standing = there = 0;
            ++strokes;
        }
    }
    EXPECT_GE(strokes, 3);
    EXPECT_GE(least, 49) << "ms at the dead point";
    EXPECT_LT(least, 60);
    EXPECT_EQ(get("limited"), 0);
}

TEST_F(ChoppingWords, AnExactStopGoesOnWhereTheAxisDoesNotCome) {
    set("exact-stop", 0.0001);
    set("exact-stop-time", 0.1);
    bench.set("axis.resolution", 1);  // never as near
    start();
    bench.run(2);
    EXPECT_EQ(get("limited-code"), static_cast<int>(Bound::arrival));
    const double strokes = get("stroke-count");
    bench.run(2);
    EXPECT_GT(get("stroke-count"), strokes + 3);
}

}  // namespace
}  // namespace plumb
