// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/any_value.hpp"

#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

namespace plumb {

// The number of the process of LinuxCNC's io, as HAL has it: the owner of the component iocontrol. Nothing
// while HAL has none.
inline std::optional<int> find_io_process() {
    if (!hal::NamedPin::find("iocontrol.0.user-enable-out"))
        return std::nullopt;  // in place of a program each time
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(
        popen("exec halcmd -s show comp iocontrol", "re"), pclose);
    std::string text;
    for (int c; output && (c = std::fgetc(output.get())) != EOF;) text += static_cast<char>(c);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string number, kind, name;
        int process = 0;
        if (words >> number >> kind >> name >> process && kind == "User" &&
            (name == "iocontrol" || name == "iocontrol.0"))  // the name in LinuxCNC 2.9, and in later ones
            return process;
    }
    return std::nullopt;
}

}  // namespace plumb
