// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/faster_clock.hpp"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "hal/host/decimal.hpp"

namespace plumb::host {

namespace {

namespace files = std::filesystem;

// Debian keeps it in a folder that is named for the architecture.
std::string find_library() {
    const files::path name = "faketime/libfaketimeMT.so.1";
    std::error_code error;
    for (const files::path folder : {"/usr/lib", "/usr/local/lib"}) {
        if (files::exists(folder / name, error)) return folder / name;
        for (const files::directory_entry& entry : files::directory_iterator(folder, error))
            if (files::exists(entry.path() / name, error)) return entry.path() / name;
    }
    throw std::runtime_error("libfaketime is not installed");
}

}  // namespace

FasterClock::FasterClock(double speed) {
    const std::string library = find_library();
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
