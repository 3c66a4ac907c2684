// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/length_unit.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

namespace plumb::hal {

// The value of a line `NAME = value` in a section of an INI file; "" without one.
inline std::string ini_value(const std::string& file, const std::string& section, const std::string& name) {
    const auto trimmed = [](const std::string& text) {
        const std::size_t first = text.find_first_not_of(" \t\r");
        return first == std::string::npos ? ""
                                          : text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
    };
    std::ifstream lines(file);
    bool inside = false;
    for (std::string line; std::getline(lines, line);) {
        line = trimmed(line);
        if (!line.empty() && line.front() == '[') inside = line.compare(0, section.size(), section) == 0;
        const std::size_t equals = line.find('=');
        if (inside && equals != std::string::npos && trimmed(line.substr(0, equals)) == name)
            return trimmed(line.substr(equals + 1));
    }
    return "";
}

// Throws where the LinuxCNC that loads a component has another unit than this, "" for none given. It names
// its INI file in the environment; without one, as in halrun, nothing is known.
inline void compare_with_linuxcnc(const std::string& unit) {
    const char* const file = std::getenv("INI_FILE_NAME");
    if (!file) return;
    const std::string machine = ini_value(file, "[TRAJ]", "LINEAR_UNITS");
    const auto its = millimetres_of(machine);
    if (!its || std::abs(*its / millimetres_of_option(unit.empty() ? "mm" : unit) - 1) < 1e-3) return;
    const std::string fact = "[TRAJ]LINEAR_UNITS is " + machine + " in " + file;
    if (unit.empty())
        throw std::invalid_argument(fact +
                                    ", and the defaults are in mm: add unit=[TRAJ]LINEAR_UNITS to the loadrt "
                                    "line");
    throw std::invalid_argument("unit=" + unit + ", but " + fact);
}

}  // namespace plumb::hal
