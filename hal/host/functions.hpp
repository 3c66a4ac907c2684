// SPDX-License-Identifier: GPL-2.0-or-later
// Names the realtime function that runs. HAL reads a clock before the first function of a period and after
// each: the readings by hal_lib since the task runs are the place of the function in its thread.
#pragma once

#include <cstdint>
#include <string>

#include "hal/host/scheduler.hpp"

namespace plumb::host {

// The code of hal_lib.
struct HalCode {
    std::uintptr_t begin = 0, size = 0;

    bool has(const void* place) const { return reinterpret_cast<std::uintptr_t>(place) - begin < size; }
};
extern HalCode hal_code;

// hal_lib has been loaded; `place` lies in its code.
void find_hal_code(const void* place);

// Somebody whose code lies at `caller` reads a clock.
inline void count_reading(const void* caller) {
    if (hal_code.has(caller)) scheduler().count_reading();
}

// Empty if it is not known. Any thread may ask.
std::string running_function();

}  // namespace plumb::host
