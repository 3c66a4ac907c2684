// SPDX-License-Identifier: GPL-2.0-or-later
// The threads of the HAL that runs, and the places of Plumb's functions in them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/thread_order.hpp"

namespace plumb::commands {

struct RunningThreads {
    std::vector<hal::ThreadFunctions> threads;
    std::vector<hal::PlacedFunction> idle;  // functions that no thread has
    std::vector<std::string> undeclared;    // files of declarations that are missing or damaged
};

// threads, functions: the output of `halcmd -s show thread` and `halcmd -s show funct`; declarations: the
// folder with NAME.json of each of these modules.
RunningThreads running_threads(const std::string& threads, const std::string& functions,
                               const std::filesystem::path& declarations,
                               const std::vector<std::string>& modules);

}  // namespace plumb::commands
