// SPDX-License-Identifier: GPL-2.0-or-later
// chopping on the simulated axis, as an extra joint.
#pragma once

#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace plumb {

inline constexpr double dt = 0.001;  // s
inline constexpr double nm = 1e-6;   // mm

// A stroke from -20 to -8 mm below R, which is 0.
inline void wire(Bench& bench, const std::string& plant = "sim_grinder",
                 const std::string& interlock = "no") {
    bench.command("loadrt " + plant + " names=axis");
    bench.command("loadrt chopping names=chop sections=4 infeed=1 interlock=" + interlock);
    for (const char* line :
         {"setp chop.upper            -8", "setp chop.lower           -20",
          "setp chop.feed             60", "setp chop.max-acceleration 1000", "setp chop.min-limit      -100",
          "setp chop.max-limit       100", "setp chop.homed             1", "setp chop.motion-enabled    1",
          "setp axis.resolution        0.0001", "net command chop.command => axis.position-cmd",
          "net feedback axis.position => chop.joint-feedback", "addf chop.update servo-thread",
          "addf axis.update servo-thread"})
        bench.command(line);
}

struct ChoppingAxis : testing::Test {
    Bench bench;

    ChoppingAxis() { wire(bench); }

    void set(const std::string& pin, double value) { bench.set("chop." + pin, value); }
    double get(const std::string& pin) { return bench.get("chop." + pin); }
    void start() { set("run", 1); }
    std::vector<double> commands(double seconds) {
        return bench.trace(seconds, {"chop.command"}).column("chop.command");
    }
    // From now on: the acceleration of the command, and its place.
    void bound_all_periods(double low, double high) {
        for (const char* line :
             {"loadrt ddt names=speed,growth", "net command => speed.in", "net v speed.out growth.in",
              "addf speed servo-thread", "addf growth servo-thread"})
            bench.command(line);
        bench.run(0.01);
        bench.expect("abs(a) <= 1010", {{"a", "growth.out"}});
        bench.expect("z >= " + std::to_string(low) + " && z <= " + std::to_string(high),
                     {{"z", "chop.command"}});
    }
    double highest() {
        const std::vector<double> z = commands(1);
        return *std::max_element(z.begin(), z.end());
    }
    double hardest(const std::vector<double>& z) {
        double result = 0;
        for (std::size_t i = 2; i < z.size(); ++i)
            result = std::max(result, std::abs(z[i] - 2 * z[i - 1] + z[i - 2]) / (dt * dt));
        return result;
    }
};

}  // namespace plumb
