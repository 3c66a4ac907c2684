// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/functions.hpp"

#include <dlfcn.h>

#include "hal/thread_list.hpp"

namespace plumb::host {

HalCode hal_code;

void find_hal_code(const void* place) {
    dl_find_object object{};
    if (_dl_find_object(const_cast<void*>(place), &object) != 0) return;
    hal_code.begin = reinterpret_cast<std::uintptr_t>(object.dlfo_map_start);
    hal_code.size = reinterpret_cast<std::uintptr_t>(object.dlfo_map_end) - hal_code.begin;
}

std::string running_function() {
    const int task = scheduler().running();
    const std::size_t readings = scheduler().readings();
    const auto list = hal::list_threads();
    if (!list || readings == 0) return "";
    for (const hal::ListedThread& thread : list->threads)
        if (thread.task == task && readings <= thread.functions.size())
            return list->functions[thread.functions[readings - 1]].name;
    return "";
}

}  // namespace plumb::host
