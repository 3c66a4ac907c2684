// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/crc_32.hpp"
#include "hal/regular_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace plumb {

// When a folder's log was last written: by the number of the log, and by the kernel's time since the computer
// was started, which nobody sets. The note holds until the next start, so it need not be on the disk.
class LastWrite {
public:
    explicit LastWrite(const std::filesystem::path& folder) : path_(folder / ".growth_log.last") {}

    // Without a note the time is not known later; the log is more important.
    void note(int number) const {
        try {
            const hal::RegularFile file(path_, O_WRONLY | O_CREAT | O_NOFOLLOW, 0644);
            const std::string text = line(number, boot(), nanoseconds());
            if (pwrite(file.number(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()))
                ftruncate_to(file, text.size());
        } catch (const std::system_error&) {
        }
    }

    // Seconds since the note about this log, if it is of this start of the computer.
    std::optional<double> since(int number) const {
        if (number == 0) return std::nullopt;  // no log is known by it
        std::string text;
        try {
            text = hal::RegularFile(path_, O_RDONLY | O_NOFOLLOW).read();
        } catch (const std::system_error&) {
            return std::nullopt;
        }
        const std::size_t begin = text.find(' ') + 1, end = text.find(' ', begin);
        long long then = 0;
        if (end == std::string::npos || std::sscanf(text.c_str() + end, "%lld", &then) != 1)
            return std::nullopt;
        const std::string its_boot = boot();
        const std::int64_t now = nanoseconds();
        if (its_boot.empty() || text != line(number, its_boot, then) || then > now) return std::nullopt;
        return static_cast<double>(now - then) * 1e-9;
    }

private:
    static std::string line(int number, const std::string& boot, std::int64_t time) {
        const std::string text = std::to_string(number) + ' ' + boot + ' ' + std::to_string(time);
        char sum[10];
        std::snprintf(sum, sizeof sum, " %08x", static_cast<unsigned>(crc_32(text)));
        return text + sum + '\n';
    }

    static void ftruncate_to(const hal::RegularFile& file, std::size_t size) {
        if (ftruncate(file.number(), static_cast<off_t>(size)) != 0) file.fail();
    }

    // A new one at each start of the computer; "" where the kernel gives none.
    static std::string boot() {
        std::ifstream file("/proc/sys/kernel/random/boot_id");
        std::string id;
        file >> id;
        return id;
    }

    static std::int64_t nanoseconds() {
        timespec now{};
        clock_gettime(CLOCK_BOOTTIME, &now);
        return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
    }

    const std::filesystem::path path_;
};

}  // namespace plumb
