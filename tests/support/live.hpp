// SPDX-License-Identifier: GPL-2.0-or-later
// How to bring a component that moves an axis to life: enabled, fed, its offset not zero.
//
// A disabled component passes every test of bad inputs. So the test file of each component that declares a
// hal::Offset registers one of these, at namespace scope:
//
//     const Live live{{"rod_growth", "z"}, [](Bench& bench) { ... }, 10, 60};
#pragma once

#include "tests/support/bench.hpp"

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

struct Live {
    struct Part {
        std::string module, instance;
    };
    // A pin of the machine around it, and the values that it may take there, the first one at rest.
    struct Knob {
        std::string pin;
        std::vector<double> values;
        bool smooth = false;  // its change of the offset obeys the acceleration that the component declares
    };

    // For random attacks.
    struct Around {
        std::vector<Knob> knobs;
        std::set<std::string> smooth_inputs;  // no value of theirs breaks a declared acceleration
        // Brings motion to rest once all is given back, and returns the errors there.
        std::function<std::vector<std::string>(Bench&)> rest;
    };

    Live(std::vector<Part> its_parts, std::function<void(Bench&)> bring_to_life, double seconds_of_life,
         double seconds_to_recover, Around machine = {}, std::function<void(Bench&, long)> bring_beyond = {})
        : parts(std::move(its_parts)),
          start(std::move(bring_to_life)),
          span(seconds_of_life),
          recovery(seconds_to_recover),
          around(std::move(machine)),
          start_beyond(std::move(bring_beyond)) {
        all().push_back(this);
    }
    Live(const Live&) = delete;
    Live& operator=(const Live&) = delete;

    // The one of a module alone, or null.
    static const Live* of(const std::string& module) {
        for (const Live* live : all())
            if (live->parts.size() == 1 && live->parts[0].module == module) return live;
        return nullptr;
    }
    // The one of several modules in one HAL.
    static const Live* together() {
        for (const Live* live : all())
            if (live->parts.size() > 1) return live;
        return nullptr;
    }

    const std::vector<Part> parts;
    const std::function<void(Bench&)> start;  // on a bench without threads
    const double span;      // seconds from there in which all happens that can happen, outputs in motion, too
    const double recovery;  // seconds after which a bad value must be forgotten
    const Around around;
    // For an output with an acceleration of its own: starts it in a thread of this period, ns, with a target
    // that leaves its bound at speed.
    const std::function<void(Bench&, long)> start_beyond;

private:
    static std::vector<const Live*>& all() {
        static std::vector<const Live*> list;
        return list;
    }
};

}  // namespace plumb
