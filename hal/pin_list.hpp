// SPDX-License-Identifier: GPL-2.0-or-later
// All pins, with their directions, which only halcmd lists.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace plumb::hal {

struct ListedPin {
    std::string type;       // as halcmd writes it: bit, s32, u32, float, ...
    std::string direction;  // IN, OUT, I/O
};

// By name. Throws std::runtime_error if halcmd fails.
inline std::map<std::string, ListedPin> list_pins() {
    FILE* const pipe = popen("exec halcmd -s show pin", "r");
    if (!pipe) throw std::runtime_error("halcmd cannot be run");
    std::string text;
    char bytes[4096];
    for (std::size_t n; (n = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;) text.append(bytes, n);
    const int status = pclose(pipe);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error("halcmd show pin failed");
    std::map<std::string, ListedPin> pins;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string owner, value, name;
        ListedPin pin;
        if (words >> owner >> pin.type >> pin.direction >> value >> name) pins[name] = pin;
    }
    return pins;
}

}  // namespace plumb::hal
