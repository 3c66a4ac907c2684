// SPDX-License-Identifier: GPL-2.0-or-later
// How to bring a compensation to life for the conformance test: enabled, fed, its output not zero.
//
// A disabled component passes every test of bad inputs.  So the test file of each component that drives an
// axis registers one of these, at namespace scope:
//
//     const Live live{"rod_growth", "z", [](Bench& bench) { ... }, {{"z.offset", "z.max-rate"}}, 10, 60};
#pragma once

#include "tests/bench.hpp"

#include <functional>
#include <string>
#include <vector>

namespace plumb {

struct Live {
    // An output that moves an axis, and the setting that limits its change per second.
    struct Ramp {
        std::string output;
        std::string max_rate;
    };

    Live(std::string module_name, std::string instance_name, std::function<void(Bench&)> bring_to_life,
         std::vector<Ramp> limited, double seconds_of_life, double seconds_to_recover)
        : module(std::move(module_name)),
          instance(std::move(instance_name)),
          start(std::move(bring_to_life)),
          ramps(std::move(limited)),
          span(seconds_of_life),
          recovery(seconds_to_recover) {
        all().push_back(this);
    }
    Live(const Live&) = delete;
    Live& operator=(const Live&) = delete;

    // The one of a module, or null.
    static const Live* of(const std::string& module) {
        for (const Live* live : all())
            if (live->module == module) return live;
        return nullptr;
    }

    const std::string module;
    const std::string instance;
    const std::function<void(Bench&)> start;  // on a bench without threads
    const std::vector<Ramp> ramps;
    const double span;      // seconds from there in which all happens that can happen, outputs in motion, too
    const double recovery;  // seconds after which a bad value must be forgotten

private:
    static std::vector<const Live*>& all() {
        static std::vector<const Live*> list;
        return list;
    }
};

}  // namespace plumb
