// SPDX-License-Identifier: GPL-2.0-or-later
// A program as a user meets it: what it prints, and how it ends.
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

// Runs a program to its end; arguments.front() is its path. `meanwhile` is told its number once it runs;
// when that throws, the program is asked to end.
Outcome run_program(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                    const std::function<void(pid_t)>& meanwhile = {});

// Likewise on a terminal of its own: both streams are in `output`. `keys` are typed once it has shown `cue`.
Outcome run_on_terminal(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                        const std::string& cue = "", const std::string& keys = "");

// Of what a program has printed the lines that load and set something in HAL.
std::string hal_lines(const std::string& output);

}  // namespace plumb
