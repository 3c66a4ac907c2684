// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plumb {

// How often a process has gone to sleep of its own accord: the count of a program with a loop that sleeps
// advances while the loop runs, and stands still in a process that is stopped, hangs, or is gone.
class ProcessWakes {
public:
    // A process that gets the same number later is not taken for this one.
    explicit ProcessWakes(int process)
        : folder_(open(("/proc/" + std::to_string(process)).c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {}
    ProcessWakes(const ProcessWakes&) = delete;
    ProcessWakes& operator=(const ProcessWakes&) = delete;
    ~ProcessWakes() {
        if (folder_ >= 0) close(folder_);
    }

    // Nothing if the process is gone.
    std::optional<std::uint64_t> count() const noexcept {
        const int file = openat(folder_, "status", O_RDONLY | O_CLOEXEC);
        if (file < 0) return std::nullopt;
        std::array<char, 8192> content;
        std::size_t size = 0;
        for (ssize_t got; (got = read(file, content.data() + size, content.size() - size)) > 0;)
            size += static_cast<std::size_t>(got);
        close(file);
        return number_behind("\nvoluntary_ctxt_switches:\t", {content.data(), size});
    }

private:
    static std::optional<std::uint64_t> number_behind(std::string_view key, std::string_view text) noexcept {
        const std::size_t place = text.find(key);
        if (place == std::string_view::npos) return std::nullopt;
        std::uint64_t number = 0;
        const char* const begin = text.data() + place + key.size();
        const bool good = std::from_chars(begin, text.data() + text.size(), number).ec == std::errc{};
        return good ? std::optional(number) : std::nullopt;
    }

    const int folder_;
};

}  // namespace plumb
