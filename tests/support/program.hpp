// SPDX-License-Identifier: GPL-2.0-or-later
// A program as a user meets it: its output and its end.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

struct Outcome {
    int status;  // exit status, or 128 + the signal
    std::string output;
    std::string errors;
};

// Runs a program to its end; arguments.front() is its path. Calls `meanwhile` with its number once it runs;
// if that throws, the program is asked to end.
Outcome run_program(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                    const std::function<void(pid_t)>& meanwhile = {});

// Runs it on a terminal of its own: both streams are in `output`. `keys` are typed once it has shown `cue`.
Outcome run_on_terminal(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                        const std::string& cue = "", const std::string& keys = "");

// The lines of a program's output that load and set something in HAL.
std::string hal_lines(const std::string& output);

}  // namespace plumb
