// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "tests/support/bench.hpp"

#include <cmath>

namespace plumb {
namespace {

using growth_test::Fault;
using growth_test::State;
using growth_test::Stop;

constexpr double hour = 3600;

// The program of a test, and a probe that touches where it is told to.
struct ThermalGrowthTest : testing::Test {
    static constexpr double period = 0.1;  // s: the component does not mind, and hours pass sooner
    Bench bench{Bench::Thread::none};

    ThermalGrowthTest() {
        bench.command("loadrt threads name1=servo-thread period1=100000000");
        bench.command("loadrt thermal_growth_test names=it interlock=no sensors=2");
        bench.command("addf it.update servo-thread");
        bench.command("start");
        bench.set("it.minimum-time", 0);
    }

    void set(const std::string& pin, double value) { bench.set("it." + pin, value); }
    double get(const std::string& pin) { return bench.get("it." + pin); }
    int code(const std::string& pin) { return static_cast<int>(get(pin + "-code")); }
    Fault fault() { return static_cast<Fault>(code("fault")); }
    State state() { return static_cast<State>(code("state")); }
    void tick() { bench.run(period); }
    void pulse(const std::string& pin) {
        set(pin, 1);
        tick();
        set(pin, 0);
        tick();
    }
    void begin() {
        set("running", 1);
        tick();
    }

    void move(double x, double y, double z, int axis, double velocity) {
        const double at[] = {x, y, z};
        for (int i = 0; i < 3; ++i) {
            const std::string letter(1, "xyz"[i]);
            set(letter + "-position", at[i]);
            set(letter + "-velocity", i == axis ? velocity : 0);
        }
    }
    void touch(double x, double y, double z, int axis, double direction, bool hits = true) {
        set("measuring", 1);
        move(x - (axis == 0 ? direction : 0), y - (axis == 1 ? direction : 0),
             z - (axis == 2 ? direction : 0), axis, direction);
        tick();
        move(x, y, z, axis, direction / 2);
        set("probe", hits ? 1 : 0);
        tick();
        set("measuring", 0);
        set("probe", 0);
        tick();
    }
    void open(int number, bool turned = false) {
        set("bore-key", number);
        set("turned", turned);
        set("at-bore", 1);
        tick();
    }
    void close() {
        set("at-bore", 0);
        tick();
    }
    void probe_bore(int number, double x, double y, double z, double spoil = 0) {
        open(number);
        touch(x, y, z, 2, -1);
        touch(x + 12, y, z - 5, 0, 1);
        touch(x - 12, y, z - 5, 0, -1);
        touch(x, y + 12 + spoil, z - 5, 1, 1);
        touch(x, y - 12, z - 5, 1, -1);
        close();
    }
    void pass(double grown = 0) {
        set("pass-running", 1);
        tick();
        probe_bore(1, 50, 20, -100 + grown);
        set("pass-running", 0);
        tick();
    }
};

TEST_F(ThermalGrowthTest, HasTheRowsOfItsSensors) {
    for (const std::string stem :
         {"temperature-", "temperature-valid-", "temperature-age-", "temperature-decides-"}) {
        get(stem + "1");
        EXPECT_ANY_THROW(get(stem + "2")) << stem;
    }
}

TEST_F(ThermalGrowthTest, GivesTheBoreWithoutTheCompensation) {
    begin();
    set("x-offset", 0.004);
    set("z-offset", -0.030);
    probe_bore(3, 50.004, 20, -100.030);
    EXPECT_NEAR(get("bore-x"), 50, 1e-9);
    EXPECT_NEAR(get("bore-y"), 20, 1e-9);
    EXPECT_NEAR(get("bore-z"), -100, 1e-9);
    EXPECT_NEAR(get("bore-diameter"), 30, 1e-9);
    EXPECT_NEAR(get("bore-scatter"), 0, 1e-9);
    EXPECT_NEAR(get("touch-y"), 8, 1e-9);
    EXPECT_NEAR(get("touch-z-offset"), -0.030, 1e-9);
    EXPECT_EQ(get("touches"), 5);
    EXPECT_EQ(get("repeat"), 0);
    EXPECT_EQ(fault(), Fault::none);
    set("outside", 1);
    probe_bore(3, 50.004, 20, -100.030);
    EXPECT_NEAR(get("bore-diameter"), 18, 1e-9);
}

TEST_F(ThermalGrowthTest, LatchesThePeriodOfTheTouchAndItsDirection) {
    begin();
    open(1);
    touch(7, 8, 9, 0, -3);
    move(99, 99, 99, 1, 5);
    tick();
    EXPECT_EQ(get("touch-x"), 7);
    EXPECT_EQ(get("touches"), 1);
    const int last = static_cast<int>(get("rows")) - 1;
    set("row", last);
    tick();
    EXPECT_EQ(get("row-shown"), last);
    EXPECT_EQ(get("row-kind"), 1);
    EXPECT_EQ(get("row-item"), -1);
    EXPECT_EQ(get("row-x"), 7);
    set("probe", 1);  // not while measuring
    tick();
    EXPECT_EQ(get("touches"), 1);
}

TEST_F(ThermalGrowthTest, FindsAFalseTouchByTheFirstVisitOfTheBore) {
    set("max-scatter", 0.012);
    begin();
    probe_bore(1, 50, 20, -100, 0.003);  // the lobes of the probe
    EXPECT_EQ(fault(), Fault::none);
    probe_bore(1, 50.02, 20, -100.02, 0.003);  // the machine has grown
    EXPECT_EQ(fault(), Fault::none);
    probe_bore(1, 50, 20, -100, 0.003 + 0.0199);
    EXPECT_EQ(fault(), Fault::false_trigger);
    EXPECT_EQ(get("repeat"), 1);
    EXPECT_EQ(get("fault-bore"), 1);
    probe_bore(1, 50, 20, -100, 0.003);
    EXPECT_EQ(fault(), Fault::none);
    EXPECT_EQ(get("fault-bore"), 0);
    set("compensate", 1);  // the shape is the same in both states
    set("compensation-on", 1);
    probe_bore(1, 50, 20, -100, -0.015);
    EXPECT_EQ(fault(), Fault::false_trigger);
}

TEST_F(ThermalGrowthTest, FindsAFalseTouchThatTheScatterLetsPass) {
    set("max-scatter", 0.012);
    begin();
    probe_bore(1, 50, 20, -100);
    probe_bore(1, 50, 20, -100, -0.0199);
    EXPECT_EQ(fault(), Fault::false_trigger);
    set("max-shape-change", 0.02);
    probe_bore(1, 50, 20, -100, -0.0199);
    EXPECT_EQ(fault(), Fault::none);
}

TEST_F(ThermalGrowthTest, NamesTheBoreThatSlippedOrHasAnotherKey) {
    begin();
    set("pass-running", 1);
    tick();
    probe_bore(1, 50, 20, -100);
    probe_bore(2, 55, 20, -100);
    probe_bore(2, 50, 20, -100);  // bore 1 under the number of bore 2
    EXPECT_EQ(fault(), Fault::displaced);
    EXPECT_EQ(get("fault-bore"), 2);
    EXPECT_EQ(get("repeat"), 1);
    probe_bore(2, 55.02, 20, -100);
    EXPECT_EQ(fault(), Fault::none);
    probe_bore(1, 50, 20, -99.4);
    EXPECT_EQ(fault(), Fault::displaced);
    EXPECT_EQ(get("fault-bore"), 1);
    for (const char* pin : {"max-displacement", "max-step", "max-slip"}) set(pin, 1);
    probe_bore(1, 50, 20, -99.4);
    EXPECT_EQ(fault(), Fault::none);
}

TEST_F(ThermalGrowthTest, ASmallSlipOfTheArtifactIsToldFromGrowth) {
    set("range-floor", 1);
    const auto pass = [&](bool now) {
        set("pass-running", now);
        tick();
    };
    begin();
    pass(true);
    for (const int bore : {1, 2, 3}) probe_bore(bore, 50 * bore, 20, -100);
    pass(false);
    pass(true);  // the spindle has grown by 60 um
    for (const int bore : {1, 2, 3}) {
        probe_bore(bore, 50 * bore, 20, -99.94);
        EXPECT_EQ(fault(), Fault::none) << bore;
    }
    pass(false);
    pass(true);
    probe_bore(1, 50, 20.01, -99.92);
    probe_bore(2, 100, 20.05, -99.92);  // 40 um beyond its neighbour
    EXPECT_EQ(fault(), Fault::displaced);
    EXPECT_EQ(get("fault-bore"), 2);
    probe_bore(2, 100, 20.02, -99.92);
    EXPECT_EQ(fault(), Fault::none);
    probe_bore(1, 50, 20.05, -99.92);  // again in this pass
    EXPECT_EQ(fault(), Fault::displaced);
    EXPECT_EQ(get("fault-bore"), 1);
    probe_bore(1, 50, 20.01, -99.92);
    pass(false);
    pass(true);  // no machine grows as fast as this
    probe_bore(1, 50.12, 20.01, -99.92);
    EXPECT_EQ(fault(), Fault::displaced);
    EXPECT_EQ(get("fault-bore"), 1);
}

// Passes with work of equal length between them. The artifact lies at `slip` on its table, in X and Y.
struct SlippedArtifact : ThermalGrowthTest {
    bool both = true;
    double cooling = 0;  // of Z within a pass, mu

    SlippedArtifact() {
        set("minimum-time", 40000);
        set("sample-time", 60);
        begin();
    }
    void probe(int bore, bool turned, double x, double y, double z) {
        open(bore, turned);
        touch(x, y, z, 2, -1);
        touch(x + 12, y, z - 5, 0, 1);
        touch(x - 12, y, z - 5, 0, -1);
        touch(x, y + 12, z - 5, 1, 1);
        touch(x, y - 12, z - 5, 1, -1);
        close();
    }
    void pass(double grown, double slip_x = 0, double slip_y = 0) {
        set("pass-running", 1);
        tick();
        for (const int bore : {1, 2}) probe(bore, false, 50 * bore + slip_x, 20 + slip_y, -100 + grown);
        if (both)
            for (const int bore : {1, 2})
                probe(bore, true, -50 * bore - slip_x, 20 + slip_y, -100 + grown - cooling / 2);
        probe(1, false, 50 + slip_x, 20 + slip_y, -100 + grown - cooling);
        set("pass-running", 0);
        tick();
    }
    void work(double speed = 6000, double time = 600) {
        set("spindle-speed", speed);
        bench.run(time);
        set("spindle-speed", 0);
    }
    static double growth(int cycle) { return -0.040 * std::expm1(-0.5 * cycle); }
};

TEST_F(SlippedArtifact, ASlipThatTurnsWithTheTableIsAFaultAfterItsPass) {
    pass(0);
    work();
    pass(growth(1));
    EXPECT_EQ(fault(), Fault::none);
    work(0);  // unequal work does not matter here
    pass(growth(2), 0.008);
    EXPECT_EQ(fault(), Fault::none);  // below min-slip
    work();
    pass(growth(3), 0.020);
    EXPECT_EQ(fault(), Fault::slipped);
    EXPECT_EQ(get("fault-bore"), 0);
    EXPECT_EQ(get("repeat"), 0);
    set("row", get("rows") - 1);
    tick();
    EXPECT_EQ(get("row-item"), 8);  // it is in the log, too
    EXPECT_EQ(get("row-x"), 17);
    work();
    probe_bore(3, 50, 20, -100, 0.5);
    EXPECT_EQ(fault(), Fault::false_trigger);
    probe_bore(1, 50.02, 20, -99.97);
    EXPECT_EQ(fault(), Fault::slipped);  // a good visit does not end it
    pulse("acknowledge");
    EXPECT_EQ(fault(), Fault::none);
}

TEST_F(SlippedArtifact, AlongTheAxisOfTheTableAndWithoutASecondOrientationThePassAfterItShowsIt) {
    for (const bool two : {true, false}) {
        both = two;
        set("running", 0);
        tick();
        begin();
        for (int cycle = 0; cycle < 3; ++cycle) {
            pass(growth(cycle));
            work();
        }
        pass(growth(3), two ? 0 : 0.015, 0.015);
        EXPECT_EQ(fault(), Fault::none);
        work();
        pass(growth(4), two ? 0 : 0.015, 0.015);
        EXPECT_EQ(fault(), Fault::slipped);
        pulse("acknowledge");
        for (int cycle = 5; cycle < 9; ++cycle) {
            work();
            pass(growth(cycle), two ? 0 : 0.015, 0.015);
            EXPECT_EQ(fault(), Fault::none);  // once
        }
    }
}

// Quick growth from cold, another speed, a longer cycle, a break and the drift within a pass are no slip.
TEST_F(SlippedArtifact, GrowthIsNone) {
    both = false;
    double grown = 0;
    for (const double to : {0.0, 0.038, 0.0398, 0.04, 0.04}) {
        pass(grown = to);
        work();
    }
    EXPECT_EQ(fault(), Fault::none);
    pass(grown -= 0.03);  // after a rest instead of work
    work(0);
    pass(grown);
    work(0);
    pass(grown);
    EXPECT_EQ(fault(), Fault::none);
    work(0, 2400);
    pass(grown -= 0.02);
    work(0);
    pass(grown);
    work(0);
    EXPECT_EQ(fault(), Fault::none);
    set("running", 0);
    tick();
    set("resume", 1);
    set("gap", -1);  // its length is not known
    begin();
    pass(grown -= 0.02);
    work(0);
    pass(grown);
    EXPECT_EQ(fault(), Fault::none);
    set("running", 0);
    tick();
    set("resume", 0);
    begin();
    both = true;
    set("min-slip", 0.006);
    pass(0);
    cooling = 0.028;
    work();
    pass(0.03);
    EXPECT_EQ(fault(), Fault::none);
}

TEST_F(ThermalGrowthTest, GoesThroughItsStates) {
    tick();
    EXPECT_EQ(state(), State::idle);
    begin();
    EXPECT_EQ(state(), State::warming);
    set("pass-running", 1);
    tick();
    EXPECT_EQ(state(), State::probing_cold);
    set("pass-running", 0);
    tick();
    set("pass-running", 1);
    tick();
    EXPECT_EQ(state(), State::probing);
    EXPECT_EQ(get("pass"), 2);
    set("pass-running", 0);
    set("running", 0);
    tick();
    EXPECT_EQ(state(), State::interrupted);
}

TEST_F(ThermalGrowthTest, MissOutlierAndOrientationAskForAnotherVisit) {
    begin();
    open(1);
    touch(0, 0, 0, 2, -1, false);
    close();
    EXPECT_EQ(fault(), Fault::probe_miss);
    EXPECT_EQ(get("repeat"), 1);
    probe_bore(1, 50, 20, -100, 0.2);
    EXPECT_EQ(fault(), Fault::false_trigger);
    EXPECT_EQ(get("repeat"), 1);
    probe_bore(1, 50, 20, -100);
    EXPECT_EQ(fault(), Fault::none);
    EXPECT_EQ(get("repeat"), 0);
    open(1);
    touch(50, 20, -100, 2, -1);
    touch(50, 20, -99.9, 2, -1);
    close();
    EXPECT_EQ(fault(), Fault::false_trigger);
    set("table", 1);
    set("turned", 1);
    set("table-position", 179.5);
    open(1, true);
    touch(1, 1, 1, 2, -1);
    close();
    EXPECT_EQ(fault(), Fault::orientation);
    set("table-position", -180);
    open(1, true);
    touch(1, 1, 1, 2, -1);
    close();
    EXPECT_EQ(fault(), Fault::none);
    open(17);
    touch(1, 1, 1, 2, -1);
    close();
    EXPECT_EQ(fault(), Fault::bore);
    open(1);
    set("probe-overtravel", 1);
    touch(1, 1, 1, 2, -1);
    close();
    EXPECT_EQ(fault(), Fault::overtravel);
}

TEST_F(ThermalGrowthTest, BoreOfALaterPassNeedsItsReference) {
    begin();
    pass();
    pass();
    EXPECT_EQ(fault(), Fault::none);
    set("pass-running", 1);
    probe_bore(2, 90, 20, -100);
    EXPECT_EQ(fault(), Fault::no_reference);
    EXPECT_EQ(get("repeat"), 1);
}

TEST_F(ThermalGrowthTest, StateThatTheControlDoesNotConfirmIsAFault) {
    set("confirm-time", 2);
    begin();
    EXPECT_EQ(get("confirmed"), 1);
    set("compensate", 1);
    bench.run(1);
    EXPECT_EQ(get("compensation-request"), 1);
    EXPECT_EQ(get("confirmed"), 0);
    EXPECT_EQ(fault(), Fault::none);
    bench.run(1.5);
    EXPECT_EQ(fault(), Fault::unconfirmed);
    set("compensation-on", 1);
    tick();
    EXPECT_EQ(get("confirmed"), 1);
    EXPECT_EQ(fault(), Fault::none);
    set("cool", 1);
    tick();
    EXPECT_EQ(get("cooling-request"), 1);
    EXPECT_EQ(get("confirmed"), 0);
}

TEST_F(ThermalGrowthTest, StopsByTemperaturesTimeAndCyclesAlone) {
    set("by-displacement", 0);
    set("interval", 0);
    set("threshold", 5);
    set("temperature-0", 20);
    begin();
    EXPECT_EQ(code("advice"), 2);
    double warm = 20;
    for (const double rise : {12.0, 7.0, 4.0}) {
        warm += rise;
        set("temperature-0", warm);
        bench.run(70);
        EXPECT_EQ(get("done"), 0);
        pulse("cycle");
    }
    EXPECT_EQ(get("done"), 1);
    EXPECT_EQ(get("cycle-index"), 3);
    EXPECT_EQ(code("stop-reason"), static_cast<int>(Stop::stable));
    EXPECT_NEAR(get("temperature-change"), 4, 1e-9);
    EXPECT_EQ(fault(), Fault::none);
}

TEST_F(ThermalGrowthTest, NeverStopsBeforeTheMinimumTime) {
    set("by-displacement", 0);
    set("minimum-time", 3 * hour);
    begin();
    set("temperature-0", 25);
    bench.run(3 * hour - 1);
    EXPECT_EQ(get("done"), 0);
    bench.run(120);
    EXPECT_EQ(get("done"), 1);
}

TEST_F(ThermalGrowthTest, DisplacementsThatGoOnHoldTheEndBack) {
    set("minimum-time", 0.5 * hour);
    begin();
    set("temperature-0", 25);
    double grown = 0;
    for (int i = 0; i < 8; ++i) {
        pass(grown);
        grown += 0.01;
        bench.run(hour / 2);
        EXPECT_EQ(get("done"), 0) << i;
    }
    for (int i = 0; i < 3; ++i) {
        pass(grown);
        bench.run(hour / 2);
    }
    EXPECT_EQ(get("done"), 1);
}

TEST_F(ThermalGrowthTest, MaximumTimeAndAColdMachineAreReported) {
    set("maximum-time", hour);
    set("minimum-time", 0.5 * hour);
    begin();
    bench.run(hour + 70);
    EXPECT_EQ(code("stop-reason"), static_cast<int>(Stop::maximum_time));
    EXPECT_EQ(fault(), Fault::no_warm_up);
    pulse("acknowledge");
    EXPECT_EQ(fault(), Fault::none);
    set("running", 0);
    tick();
    EXPECT_EQ(state(), State::stopped);
    begin();
    bench.run(60);
    set("temperature-1", 30);
    bench.run(hour + 70);
    EXPECT_EQ(fault(), Fault::not_stable);
}

TEST_F(ThermalGrowthTest, SensorThatIsOldOrNotValidIsReportedAndDecidesNothing) {
    set("by-displacement", 0);
    set("interval", 600);
    begin();
    set("temperature-age-1", 31);
    tick();
    EXPECT_EQ(fault(), Fault::sensor);
    bench.run(0.4 * hour);
    EXPECT_EQ(get("done"), 0);
    set("temperature-decides-1", 0);
    bench.run(0.4 * hour);
    EXPECT_EQ(get("done"), 1);
    set("temperature-age-1", 0);
    tick();
    EXPECT_NE(fault(), Fault::sensor);
}

TEST_F(ThermalGrowthTest, ArtifactThatIsTooWarmIsReported) {
    set("artifact-sensor", 1);
    begin();
    set("temperature-1", 36);
    tick();
    EXPECT_EQ(fault(), Fault::artifact_temperature);
}

TEST_F(ThermalGrowthTest, SettingsOutOfRangeLeaveTheLastGoodOnes) {
    set("by-displacement", 0);
    tick();
    set("threshold", 0);
    begin();
    EXPECT_EQ(fault(), Fault::settings);
    set("temperature-0", 25);
    bench.run(1.2 * hour);
    EXPECT_EQ(get("done"), 1);
    set("threshold", 0.2);
    tick();
    EXPECT_EQ(code("advice"), 1);
}

TEST_F(ThermalGrowthTest, InterruptedPassGoesOnUnderItsNumber) {
    begin();
    set("pass-running", 1);
    probe_bore(1, 50, 20, -100);
    set("running", 0);
    set("pass-running", 0);
    tick();
    EXPECT_EQ(state(), State::interrupted);
    set("resume", 1);
    begin();
    set("pass-running", 1);
    probe_bore(2, 90, 20, -100);
    EXPECT_EQ(get("pass"), 1);
    EXPECT_EQ(fault(), Fault::none);
    EXPECT_EQ(get("repeat"), 0);
    set("pass-running", 0);
    tick();
    set("pass-running", 1);
    tick();
    EXPECT_EQ(get("pass"), 2);
}

TEST_F(ThermalGrowthTest, APassInWhichTheMachineStandsTooLongIsAFault) {
    begin();
    set("max-pass-time", 600);
    set("pass-running", 1);
    bench.run(590);
    EXPECT_EQ(fault(), Fault::none);
    bench.run(20);
    EXPECT_EQ(fault(), Fault::standstill);
    set("pass-running", 0);
    tick();
    set("acknowledge", 1);
    bench.run(900);
    EXPECT_EQ(fault(), Fault::none);
}

// The mean of the speed since the last row of temperatures.
TEST_F(ThermalGrowthTest, RecordsTheSpeedOfTheSpindleWithTheTemperatures) {
    set("sample-time", 60);
    begin();
    set("spindle-speed", -6000);
    bench.run(30);
    set("spindle-speed", 0);
    bench.run(40);
    std::vector<double> speeds;
    for (int row = 0; row < get("rows"); ++row) {
        set("row", row);
        tick();
        if (get("row-kind") == 4) speeds.push_back(get("row-x"));
    }
    ASSERT_EQ(speeds.size(), 2U);
    EXPECT_NEAR(speeds[1], 3000, 150);
}

// Its records give the same test: pass, visits, references and history go on where they were.
TEST_F(ThermalGrowthTest, RestoredRecordsContinueTheTest) {
    begin();
    pass();
    set("temperature-0", 28);
    bench.run(600);
    set("running", 0);
    tick();
    const int rows = static_cast<int>(get("rows"));
    const char* const fields[] = {"kind", "time",   "pass",        "visit",    "bore",
                                  "item", "turned", "compensated", "cooled",   "x",
                                  "y",    "z",      "x-offset",    "y-offset", "z-offset"};
    std::vector<std::map<std::string, double>> kept;
    for (int i = 0; i < rows; ++i) {
        set("row", i);
        tick();
        for (const char* const field : fields) {
            if (kept.size() <= static_cast<std::size_t>(i)) kept.emplace_back();
            kept.back()[field] = get(std::string("row-") + field);
        }
    }
    pulse("forget");
    EXPECT_EQ(get("rows"), 0);
    EXPECT_EQ(state(), State::idle);
    for (const auto& record : kept) {
        for (const auto& [field, value] : record) set("restore-" + field, value);
        pulse("restore");
    }
    EXPECT_EQ(get("rows"), rows);
    EXPECT_EQ(get("restores"), rows);
    EXPECT_EQ(state(), State::interrupted);
    set("restore-time", 0);  // older than the last one
    pulse("restore");
    EXPECT_EQ(get("restores-refused"), 1);

    set("resume", 1);
    set("gap", 5000);
    begin();
    set("row", rows);
    tick();
    EXPECT_EQ(get("row-item"), 6);  // resumed
    EXPECT_EQ(get("row-x"), 0);
    EXPECT_NEAR(get("elapsed"), 5600, 10);
    EXPECT_EQ(get("pass"), 1);
    pass(0.02);
    EXPECT_EQ(get("pass"), 2);
    EXPECT_EQ(get("visit"), 2);
    EXPECT_EQ(fault(), Fault::none);  // the reference is known
    set("running", 0);
    tick();
    const double elapsed = get("elapsed");
    for (const double unknown : {-1.0, static_cast<double>(NAN)}) {
        set("gap", unknown);
        set("row", get("rows"));
        begin();
        tick();
        EXPECT_EQ(get("row-item"), 6);
        EXPECT_EQ(get("row-x"), 1);
        EXPECT_NEAR(get("elapsed"), elapsed, 10);
        set("running", 0);
        tick();
    }
    set("resume", 0);
    begin();
    EXPECT_LT(get("rows"), 5);
    EXPECT_EQ(get("pass"), 0);
}

}  // namespace
}  // namespace plumb
