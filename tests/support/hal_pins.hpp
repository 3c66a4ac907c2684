// SPDX-License-Identifier: GPL-2.0-or-later
// The pins of a bench with their directions and signals, as `halcmd show pin` has them.
#pragma once

#include "tests/support/bench.hpp"

#include <map>
#include <sstream>
#include <string>

namespace plumb {

struct Wired {
    std::string owner;
    bool output;
    std::string signal;  // "" if none
};

inline std::map<std::string, Wired> wiring(Bench& bench) {
    std::map<std::string, Wired> result;
    std::istringstream lines(bench.client().halcmd({"-s", "show", "pin"}).output);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string owner, type, direction, value, name, arrow, signal;
        if (!(words >> owner >> type >> direction >> value >> name)) continue;
        words >> arrow >> signal;
        result[name] = {owner, direction == "OUT", signal};
    }
    return result;
}

}  // namespace plumb
