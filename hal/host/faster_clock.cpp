// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/faster_clock.hpp"

#include <cstdlib>
#include <stdexcept>

#include "hal/host/decimal.hpp"
#include "hal/host/faketime_library.hpp"

namespace plumb::host {

FasterClock::FasterClock(double speed) {
    const std::string library = faketime_library();
    if (library.empty()) throw std::runtime_error("libfaketime is not installed");
    const char* const others = std::getenv("LD_PRELOAD");
    std::string factor = "+0 x";
    append_number(factor, speed);
    set("LD_PRELOAD", others == nullptr || *others == '\0' ? library : library + ":" + others);
    set("FAKETIME", factor);
}

FasterClock::~FasterClock() {
    for (const auto& [variable, value] : before_) {
        if (value)
            setenv(variable, value->c_str(), 1);
        else
            unsetenv(variable);
    }
}

void FasterClock::set(const char* variable, const std::string& value) {
    const char* const before = std::getenv(variable);
    before_[variable] = before == nullptr ? std::nullopt : std::optional<std::string>(before);
    setenv(variable, value.c_str(), 1);
}

}  // namespace plumb::host
