// SPDX-License-Identifier: GPL-2.0-or-later
// The same .hal file in stock LinuxCNC, in real time, and in the virtual-time host.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumb {

// Runs a .hal file for so many seconds in both, with our modules among LinuxCNC's, and expects that the
// records of the named pins and signals (at most 20) agree bit for bit, by index from the first pass on. The
// file may start its thread; nothing is set after that. Each recorded value must change, so that there is
// something to compare.
void expect_same_records(const std::filesystem::path& hal_file, const std::vector<std::string>& names,
                         double seconds, const std::string& thread = "servo-thread");

}  // namespace plumb
