// SPDX-License-Identifier: GPL-2.0-or-later
// Spans of time as people write them.
#pragma once

#include <string>

#include "hal/client/client.hpp"

namespace plumb::client {

// A number and a unit, ns, us, ms, s, min, h or d; without a unit it is in seconds: 600, 250ms, 10min,
// 1.5h. Throws std::invalid_argument with any other text, and with a negative one.
Time parse_duration(const std::string& text);

// In the one or two units that suit: 250 ms, 12.5 s, 10 min, 1 h 30 min.
std::string describe_duration(Time duration);

}  // namespace plumb::client
