// SPDX-License-Identifier: GPL-2.0-or-later
// CLI11's checks, without their words in the help.
#pragma once

#include <CLI/Validators.hpp>

namespace plumb::host {

inline CLI::Validator existing_file() {
    return CLI::Validator(CLI::ExistingFile).description("");
}

inline CLI::Validator existing_folder() {
    return CLI::Validator(CLI::ExistingDirectory).description("");
}

}  // namespace plumb::host
