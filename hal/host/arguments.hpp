// SPDX-License-Identifier: GPL-2.0-or-later
// Checks of arguments: CLI11's without their words in the help, and our own.
#pragma once

#include <CLI/Validators.hpp>

#include <string>

#include "hal/host/decimal.hpp"
#include "hal/host/pace.hpp"
#include "hal/regular_file.hpp"

namespace plumb::host {

inline CLI::Validator existing_file() {
    const auto check = [](const std::string& name) {
        const std::string missing = CLI::ExistingFile(name);
        const std::string why = missing.empty() ? hal::irregularity(name) : missing;
        return missing.empty() && !why.empty() ? name + ": " + why : why;
    };
    return CLI::Validator(check, "");
}

inline CLI::Validator existing_folder() {
    return CLI::Validator(CLI::ExistingDirectory).description("");
}

// A speed at which virtual time may pass.
inline std::string speed_problem(const std::string& text) {
    const auto speed = number_of(text);
    if (speed && *speed >= least_speed && *speed <= most_speed) return "";
    return text + " is not a speed: a number from 0.01 to 1000";
}

}  // namespace plumb::host
