// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/rounds.hpp"
#include "tests/support/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumb {
namespace {

double mean(const std::vector<double>& x) {
    return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

double deviation(const std::vector<double>& x) {
    const double middle = mean(x);
    double squares = 0;
    for (const double value : x) squares += (value - middle) * (value - middle);
    return std::sqrt(squares / static_cast<double>(x.size()));
}

// A drive whose every impairment is off until a test wants it.
struct SimDriveLoad : testing::Test {
    Bench bench;

    SimDriveLoad() {
        bench.command("loadrt sim_drive_load names=drive,other");
        bench.command("addf drive.update servo-thread");
        bench.command("addf other.update servo-thread");
        for (const char* pin : {"warm-decline", "part-spread", "tooth-ripple", "runout-ripple", "lag",
                                "sample-time", "white-noise", "flicker-noise", "quantum"})
            bench.set(std::string("drive.") + pin, 0);
    }

    void turn(double speed) {
        bench.set("drive.spindle-speed-cmd", speed);
        bench.run(3);
    }
};

TEST_F(SimDriveLoad, IdlesWithThePowerOfItsSpeed) {
    EXPECT_EQ(bench.get("drive.load"), 0);
    turn(10000);
    EXPECT_NEAR(bench.get("drive.load"), 4 + 6, 1e-9);
    turn(2500);
    EXPECT_NEAR(bench.get("drive.load"), 4 + 6 * std::pow(0.25, 1.5), 1e-9);
    turn(-2500);
    EXPECT_NEAR(bench.get("drive.load"), 4 + 6 * std::pow(0.25, 1.5), 1e-9);
}

TEST_F(SimDriveLoad, IdleDeclinesAsTheSpindleWarms) {
    bench.set("drive.warm-decline", 0.2);
    bench.set("drive.warm-tau", 90);
    bench.set("drive.spindle-speed-cmd", 10000);
    bench.run(90);
    EXPECT_NEAR(bench.get("drive.load"), 10 * (1 - 0.2 * (1 - std::exp(-1))), 0.01);
    bench.run(900);
    EXPECT_NEAR(bench.get("drive.load"), 8, 0.01);
}

TEST_F(SimDriveLoad, PulsesWhileItChangesItsSpeed) {
    bench.set("drive.pulse", 120);
    bench.set("drive.pulse-time", 0.5);
    for (const double speed : {8000., 6000., 0.}) {
        const double change = std::abs(bench.get("drive.truth-speed") - speed);
        bench.set("drive.spindle-speed-cmd", speed);
        const std::vector<double> loads = bench.trace(2, {"drive.load"}).column("drive.load");
        const auto pulsing = std::count_if(loads.begin(), loads.end(), [](double load) { return load > 60; });
        EXPECT_NEAR(0.001 * static_cast<double>(pulsing), 0.5 * change / 10000, 0.0021) << speed;
        EXPECT_GE(*std::max_element(loads.begin(), loads.end()), 120);
    }
}

TEST_F(SimDriveLoad, OrientsAtAToolChange) {
    bench.set("drive.tool-number", 7);
    const std::vector<double> loads = bench.trace(1, {"drive.load"}).column("drive.load");
    EXPECT_NEAR(0.001 * static_cast<double>(std::count(loads.begin(), loads.end(), 100)), 0.2, 0.0021);
}

TEST_F(SimDriveLoad, CoolantAddsAStep) {
    turn(5000);
    const double before = bench.get("drive.load");
    bench.set("drive.coolant", 1);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("drive.load") - before, 1, 1e-9);
}

TEST_F(SimDriveLoad, CutIsItsPowerInPercentOfTheRating) {
    turn(5000);
    const double idle = bench.get("drive.load");
    bench.set("drive.cutting-power", 370);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("drive.load") - idle, 10, 1e-9);
    bench.set("drive.tool-wear", 1);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("drive.load") - idle, 13, 1e-9);
}

TEST_F(SimDriveLoad, PartGainIsEvenlySpreadFromCycleToCycle) {
    bench.set("drive.part-spread", 0.2);
    bench.set("drive.cutting-power", 3700);
    std::vector<double> gains;
    for (int cycle = 1; cycle <= 1000; ++cycle) {
        bench.set("drive.cycle", cycle);
        bench.run(0.002);
        gains.push_back(bench.get("drive.load") / 100);
    }
    EXPECT_GE(*std::min_element(gains.begin(), gains.end()), 0.8);
    EXPECT_LE(*std::max_element(gains.begin(), gains.end()), 1.2);
    EXPECT_NEAR(mean(gains), 1, 0.015);
    EXPECT_NEAR(deviation(gains), 0.2 / std::sqrt(3), 0.006);
}

TEST_F(SimDriveLoad, LagIsOfTheFirstOrder) {
    bench.set("drive.lag", 0.1);
    bench.set("drive.cutting-power", 3700);
    bench.run(0.1);
    EXPECT_NEAR(bench.get("drive.load"), 100 * (1 - std::exp(-1)), 1e-6);
    EXPECT_EQ(bench.get("drive.truth-load"), 100);
}

TEST_F(SimDriveLoad, WhiteNoiseHasItsRmsAtTheOutputAndIsFlat) {
    bench.set("drive.lag", 0.03);  // must not colour it
    bench.set("drive.white-noise", 0.3);
    const std::vector<double> loads = bench.trace(200, {"drive.load"}).column("drive.load");
    EXPECT_NEAR(deviation(loads), 0.3, 0.003);
    EXPECT_NEAR(slope_of(spectral_density(loads, 0.001, 1 << 14), 0.2, 400), 0, 0.05);
}

TEST_F(SimDriveLoad, FlickerNoiseHasItsRmsAtTheOutputAndFallsAsOneOverF) {
    bench.set("drive.flicker-noise", 0.5);
    const std::vector<double> loads =
        bench.trace(rounds(2000, 600), {"drive.load"}, 0.005).column("drive.load");
    EXPECT_NEAR(deviation(loads), 0.5, 0.08);
    EXPECT_NEAR(slope_of(spectral_density(loads, 0.005, 1 << 15), 0.05, 20), -1, 0.15);
}

TEST_F(SimDriveLoad, SampleAndHoldKeepsTheEnergyAndRunsByItsOwnClock) {
    bench.set("drive.white-noise", 0.3);
    bench.set("drive.sample-time", 0.0083);
    const std::vector<double> loads = bench.trace(100, {"drive.load"}).column("drive.load");
    EXPECT_NEAR(deviation(loads), 0.3, 0.008);
    int changes = 0;
    double product = 0;  // held noise is as correlated as the held times overlap
    for (std::size_t i = 4; i < loads.size(); ++i) {
        changes += loads[i] != loads[i - 1];
        product += loads[i] * loads[i - 4];
    }
    EXPECT_NEAR(changes, 100 / 0.0083, 2);
    EXPECT_NEAR(product / static_cast<double>(loads.size()) / (0.3 * 0.3), 1 - 4 / 8.3, 0.04);
}

TEST_F(SimDriveLoad, LoadComesInSteps) {
    bench.set("drive.white-noise", 0.7);
    bench.set("drive.quantum", 0.5);
    for (const double load : bench.trace(1, {"drive.load"}).column("drive.load"))
        EXPECT_EQ(load / 0.5, std::round(load / 0.5));
}

TEST_F(SimDriveLoad, TeethAndRunoutRippleAtTheirFrequencies) {
    bench.set("drive.tooth-ripple", 0.2);
    bench.set("drive.runout-ripple", 0.1);
    bench.set("drive.teeth", 4);
    turn(937.5);  // 15.625 turns a second: 64 periods a turn, 16 a tooth
    bench.set("drive.cutting-power", 3700);
    bench.run(0.001);
    const double idle = 4 + 6 * std::pow(0.09375, 1.5);
    const std::vector<double> loads = bench.trace(6.4, {"drive.truth-load"}).column("drive.truth-load");
    const auto amplitude = [&](double frequency) {
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < 6400; ++i)
            sum += loads[i] * std::polar(1.0, -2 * M_PI * frequency * 0.001 * static_cast<double>(i));
        return 2 * std::abs(sum) / 6400;
    };
    EXPECT_NEAR(mean({loads.begin(), loads.begin() + 6400}), 100 + idle, 0.01);
    EXPECT_NEAR(amplitude(62.5), 20, 0.2);  // less the mean over a period, sinc(1/16) = 0.994
    EXPECT_NEAR(amplitude(15.625), 10, 0.02);
}

TEST_F(SimDriveLoad, SameSeedGivesTheSameBitsAndAnotherOneAnotherMachine) {
    const auto record = [](int seed) {
        Bench fresh;
        fresh.command("loadrt sim_drive_load names=drive");
        fresh.command("addf drive.update servo-thread");
        fresh.set("drive.seed", seed);
        fresh.set("drive.spindle-speed-cmd", 6000);
        return fresh.trace(5, {"drive.load"}).rows;
    };
    EXPECT_EQ(record(3), record(3));
    EXPECT_NE(record(3), record(4));
    EXPECT_EQ(record(0), record(0));
}

TEST_F(SimDriveLoad, InstancesAreIndependent) {
    bench.set("other.seed", 5);
    turn(5000);
    EXPECT_NEAR(bench.get("drive.load"), 4 + 6 * std::pow(0.5, 1.5), 1e-9);
    EXPECT_EQ(bench.get("other.truth-speed"), 0);
}

TEST_F(SimDriveLoad, DrawnMachinesStayInTheirRanges) {
    std::vector<double> idles;
    bench.set("drive.idle-speed", 0);
    bench.set("drive.spindle-speed-cmd", 5000);
    bench.run(3);
    for (int seed = 1; seed <= 200; ++seed) {
        bench.set("drive.seed", seed);
        bench.run(0.002);
        idles.push_back(bench.get("drive.truth-load"));
    }
    EXPECT_GE(*std::min_element(idles.begin(), idles.end()), 3);
    EXPECT_LE(*std::max_element(idles.begin(), idles.end()), 6);
    EXPECT_NEAR(mean(idles), 4.5, 0.2);
    EXPECT_NEAR(deviation(idles), 3 / std::sqrt(12), 0.1);
}

TEST(SimDriveLoadPeriod, DoesNotMatter) {
    const auto loads = [](const std::string& period) {
        Bench bench(Bench::Thread::none);
        bench.command("loadrt threads name1=t period1=" + period);
        bench.command("loadrt sim_drive_load names=drive");
        bench.command("addf drive.update t");
        for (const char* pin : {"white-noise", "flicker-noise", "quantum"})
            bench.set(std::string("drive.") + pin, 0);
        bench.set("drive.lag", 0.1);
        bench.set("drive.spindle-speed-cmd", 6000);
        bench.set("drive.cutting-power", 500);
        bench.command("start");
        return bench.trace(20, {"drive.load"}, 0.02).column("drive.load");
    };
    const std::vector<double> fine = loads("500000"), coarse = loads("4000000");
    ASSERT_EQ(fine.size(), coarse.size());
    for (std::size_t i = 100; i < fine.size(); ++i) EXPECT_NEAR(fine[i], coarse[i], 0.5) << i;
    EXPECT_NEAR(mean(fine), mean(coarse), 0.2);
}

// Two drives on the same signals: the effect of an impossible value on one must soon be over.
TEST(SimDriveLoadPoison, IsForgotten) {
    for (const char* pin :
         {"cutting-power", "spindle-speed-cmd", "tool-wear", "rated-power", "idle", "warm-tau", "pulse",
          "pulse-time", "lag", "sample-time", "white-noise", "quantum"}) {
        SCOPED_TRACE(pin);
        Bench bench;
        bench.command("loadrt sim_drive_load names=drive,twin");
        bench.command("addf drive.update servo-thread");
        bench.command("addf twin.update servo-thread");
        for (const char* name : {"drive.", "twin."}) {
            bench.set(name + std::string("spindle-speed-cmd"), 6000);
            bench.set(name + std::string("cutting-power"), 500);
        }
        bench.run(2);
        bench.expect("finite(load) && finite(truth)",
                     {{"load", "drive.load"}, {"truth", "drive.truth-load"}});
        bench.poison(std::string("drive.") + pin, 0.1);
        bench.run(5);
        EXPECT_NEAR(mean(bench.trace(4, {"drive.load"}).column("drive.load")),
                    mean(bench.trace(4, {"twin.load"}).column("twin.load")), 0.2);
    }
}

}  // namespace
}  // namespace plumb
