// SPDX-License-Identifier: GPL-2.0-or-later
// Ends the host when a realtime function does not return, or a module does not come back from its loading:
// nothing else could. A thread looks once a second, so a host that is stopped meanwhile, as by Ctrl-Z, loses
// no time.
#pragma once

#include <chrono>
#include <string>

namespace plumb::host {

class Watchdog {
public:
    static constexpr std::chrono::seconds function_patience{5};
    static constexpr std::chrono::seconds load_patience{60};

    // Watches each realtime function that runs while this lives.
    Watchdog();
    // Watches the loading of a module while this lives.
    explicit Watchdog(const std::string& module);
    ~Watchdog();
    Watchdog(const Watchdog&) = delete;
};

}  // namespace plumb::host
