// SPDX-License-Identifier: GPL-2.0-or-later
// plumb bench: runs .hal files in virtual time.
#pragma once

#include <CLI/App.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/host/client.hpp"
#include "hal/host/command_manual.hpp"

namespace plumb::host {

struct BenchOptions {
    std::vector<std::string> files;
    std::string ini;
    std::optional<Time> duration;  // of the run; without one, that of the replay
    std::vector<std::pair<std::string, double>> settings;
    Replay replay;                    // of no file: none
    std::vector<std::string> expect;  // statements
    std::vector<std::string> record;  // names
    Time every{};
    std::string output;
    std::vector<std::string> modules;
    bool namespaces = true;
};

// Declares the arguments of the command, which are parsed into `options`.
void declare_bench(CLI::App& command, BenchOptions& options);

CommandPage bench_page();

// Returns the exit status: 0, or 128 + N when signal N ended the run. Throws std::runtime_error.
int bench(const BenchOptions& options);

}  // namespace plumb::host
