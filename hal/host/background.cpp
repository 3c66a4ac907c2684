// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/background.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace plumb::host {

namespace {

using Work = std::pair<void (*)(void*), void*>;

std::vector<Work> registered;

}  // namespace

bool has_background_work() {
    return !registered.empty();
}

void work_in_background() {
    for (std::size_t i = 0; i < registered.size(); ++i) registered[i].first(registered[i].second);
}

}  // namespace plumb::host

void plumb_host_register_background(void (*work)(void*), void* argument) {
    plumb::host::registered.emplace_back(work, argument);
}

void plumb_host_unregister_background(void (*work)(void*), void* argument) {
    auto& works = plumb::host::registered;
    const auto found = std::find(works.begin(), works.end(), plumb::host::Work{work, argument});
    if (found != works.end()) works.erase(found);
}
