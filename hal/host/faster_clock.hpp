// SPDX-License-Identifier: GPL-2.0-or-later
// Lets the clock of user-space programs go as fast as the host's clock, by libfaketime.
#pragma once

#include <map>
#include <optional>
#include <string>

namespace plumb::host {

// While it lives, programs that this process starts, and all that they start, see the computer's clock pass
// `speed` times as fast, and sleep as much shorter. The clock is one for all of them, until this process ends.
class FasterClock {
public:
    // Throws std::runtime_error when libfaketime is not installed.
    explicit FasterClock(double speed);
    ~FasterClock();
    FasterClock(const FasterClock&) = delete;

private:
    void share();
    void set(const char* variable, const std::string& value);

    std::map<const char*, std::optional<std::string>> before_;  // the variables' values
};

}  // namespace plumb::host
