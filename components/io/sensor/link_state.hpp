// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/reading.hpp"
#include "components/io/sensor/worker.hpp"

#include <cstdint>
#include <limits>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// The values that the thread of a link shares with others.
template <class Settings, class Fault>
struct LinkState {
    LinkState(Settings its, Say its_say) : settings(std::move(its)), say(std::move(its_say)) {
        for (const auto& channel : settings.channels) judges.emplace_back(channel.limits, seconds_now());
    }

    const Settings settings;
    const Say say;
    Pauses pauses;
    std::mutex mutex;

    // The rest is guarded by the mutex, which is held for moments.
    void count_error() noexcept {
        if (errors < std::numeric_limits<std::int32_t>::max()) ++errors;
    }
    void disconnect(Fault cause) noexcept {
        for (Judge& judge : judges) judge.fail(SensorFault::disconnected);
        connected = false;
        fault = cause;
        count_error();
    }

    std::vector<Judge> judges;  // one a channel
    bool connected = false;
    double round_trip = 0;  // s, of the last request that was answered
    std::int32_t errors = 0;
    Fault fault = Fault::none;
};

// The cause of a failure, which is reported once until it is over.
class Cause {
public:
    bool is_new(const std::string& text) { return std::exchange(reported_, text) != text; }
    void over() noexcept { reported_.clear(); }

private:
    std::string reported_;
};

}  // namespace plumb
