// SPDX-License-Identifier: GPL-2.0-or-later
// The realtime functions that modules export, and the one that runs.
#pragma once

#include <string>

namespace plumb::host {

struct Function {
    using Code = void (*)(void* argument, long period);

    std::string name;
    Code code;
    void* argument;
};

// The function that was called last. Null before the first one. Any thread may ask.
const Function* last_called();

}  // namespace plumb::host
