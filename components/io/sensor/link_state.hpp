// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/reading.hpp"
#include "components/io/sensor/worker.hpp"

#include <cstdint>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

namespace plumb {

// What the thread of any link shares with others.
struct LinkState {
    template <class Channels>
    LinkState(const Channels& channels, Say its_say) : say(std::move(its_say)) {
        for (const auto& channel : channels) judges.emplace_back(channel.limits, seconds_now());
    }

    // The rest is guarded by the mutex, which is held for moments.
    void count_error() noexcept {
        if (errors < std::numeric_limits<std::int32_t>::max()) ++errors;
    }

    const Say say;
    Pauses pauses;
    std::mutex mutex;
    std::vector<Judge> judges;  // one a channel
    bool connected = false;
    double round_trip = 0;  // s, of the last request that was answered
    std::int32_t errors = 0;
};

}  // namespace plumb
