// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

struct SimTrialCuts : testing::Test {
    Bench bench;

    SimTrialCuts() {
        bench.command("loadrt sim_trial_cuts names=trial");
        bench.command("addf trial.update servo-thread");
        bench.run(0.01);
    }
    void set(const std::string& pin, double value) { bench.set("trial." + pin, value); }
    double get(const std::string& pin) { return bench.get("trial." + pin); }

    static double rounded(double length) { return std::round(length * 1e9) / 1e9; }

    // Diameter and Y of each trial cut, until the finishing land is turned. The gauge answers at once.
    std::vector<std::pair<double, double>> cut(int plan) {
        set("start", 0);
        set("plan", plan);
        bench.run(0.01);
        set("start", 1);
        bench.run(0.001);
        std::vector<std::pair<double, double>> cuts;
        for (int period = 0; period < 20000 && get("done") == 0; ++period) {
            const bool before = get("cut-done") != 0;
            const double diameter = 2 * get("x-position"), y = get("y-position");
            bench.run(0.001);
            if (!before && get("cut-done") != 0) cuts.emplace_back(rounded(diameter), rounded(y));
            set("measure", get("cut-done") != 0 && get("measure") == 0 ? 1 : 0);
        }
        EXPECT_EQ(get("done"), 1);
        return cuts;
    }
};

using Cuts = std::vector<std::pair<double, double>>;

TEST_F(SimTrialCuts, EachPlanCutsItsLandsInOrder) {
    EXPECT_EQ(cut(0), (Cuts{{10, 0}, {5, 0}}));
    EXPECT_EQ(cut(1), (Cuts{{10, 0.2}, {10, -0.2}, {10, -0.2}, {10, 0.2}}));
    EXPECT_EQ(cut(2), (Cuts{{10, 0}, {7.5, 0}, {5, 0.15}}));
    EXPECT_EQ(cut(3).size(), 8U);
}

TEST_F(SimTrialCuts, MovesYAndXOnlyIfTheyMayMove) {
    set("y-move", -0.1);
    set("x-correction", 0.02);
    cut(1);
    EXPECT_EQ(get("moved"), 0);
    EXPECT_EQ(get("x-zero"), 0);
    set("move-allowed", 1);
    cut(1);
    EXPECT_EQ(get("moved"), 1);
    EXPECT_DOUBLE_EQ(get("y-position"), -0.1);
    EXPECT_DOUBLE_EQ(get("x-zero"), 0.02);
    set("correct", 0);
    cut(1);
    EXPECT_EQ(get("moved"), 0);
    EXPECT_EQ(get("y-position"), 0);
}

TEST_F(SimTrialCuts, AFaultEndsTheCutsAndTurnsTheFinishingLand) {
    set("fault", 1);
    EXPECT_EQ(cut(1).size(), 1U);
}

}  // namespace
}  // namespace plumb
