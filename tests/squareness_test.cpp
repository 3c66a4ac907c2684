// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/bench.hpp"
#include "tests/live.hpp"

#include <cmath>

namespace plumb {
namespace {

constexpr double urad = 1e-6;

// A portal at rest whose tool is changed each second: the correction is under way again and again.
void bring_to_life(Bench& bench) {
    bench.command("loadrt threads name1=servo-thread period1=1000000");
    bench.command("loadrt squareness names=square chain=w-X.b-W-Y-Z-C-t");
    bench.command("loadrt siggen names=tools");
    bench.command("addf tools.update servo-thread");
    bench.command("addf square.update servo-thread");
    bench.command("setp tools.frequency 0.5");
    bench.command("setp tools.amplitude 50");
    bench.command("setp tools.offset 250");
    bench.command("net tool-length tools.square => square.z-tool-offset");
    for (const auto& [pin, value] : std::map<std::string, double>{{"x-position", 200},
                                                                  {"y-position", 300},
                                                                  {"z-position", -100},
                                                                  {"w-position", 400},
                                                                  {"ea0w", 400 * urad},
                                                                  {"eb0w", -300 * urad},
                                                                  {"ea0z", -200 * urad},
                                                                  {"eb0z", 100 * urad},
                                                                  {"radial-offset", 30},
                                                                  {"max-rate", 0.5},
                                                                  {"all-homed", 1},
                                                                  {"enable", 1}})
        bench.set("square." + pin, value);
    bench.command("start");
    bench.run(2);
}

const Live live{"squareness",
                "square",
                bring_to_life,
                {{"square.x-correction", "square.max-rate"},
                 {"square.y-correction", "square.max-rate"},
                 {"square.z-correction", "square.max-rate"}},
                3.6,
                3.3};

TEST(Squareness, WorkedExampleHasItsError) {
    Bench bench;
    bench.command("loadrt squareness names=square chain=w-Z.b-X-Y-C-t");
    bench.command("addf square.update servo-thread");
    for (const auto& [pin, value] : std::map<std::string, double>{{"y-position", 800},
                                                                  {"ea0y", 60 * urad},
                                                                  {"ec0y", -80 * urad},
                                                                  {"y-tool-offset", -25},
                                                                  {"z-tool-offset", -250},
                                                                  {"all-homed", 1},
                                                                  {"enable", 1}})
        bench.set("square." + pin, value);
    bench.run(2);
    EXPECT_NEAR(bench.get("square.x-error"), 65.999 * um, 0.001 * um);
    EXPECT_NEAR(bench.get("square.y-error"), -15.004 * um, 0.03 * um);
    EXPECT_NEAR(bench.get("square.z-error"), 49.4995 * um, 0.001 * um);
    EXPECT_NEAR(bench.get("square.x-correction"), -65.999 * um, 0.02 * um);
    EXPECT_FALSE(bench.get("square.ramping"));
}

}  // namespace
}  // namespace plumb
