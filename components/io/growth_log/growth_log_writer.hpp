// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/crc_32.hpp"
#include "components/io/files/growth_logs.hpp"
#include "hal/regular_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
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

// The logs of one folder. One writer at a time; a log is only ever appended to, and each batch of lines is on
// the disk before append() returns. All throw std::system_error or std::runtime_error with the file and the
// reason.
class GrowthLogWriter {
public:
    explicit GrowthLogWriter(std::filesystem::path folder)
        : folder_(std::move(folder)), lock_(locked(folder_)), last_write_(folder_) {}

    const std::filesystem::path& path() const { return path_; }  // of the log that is written

    // The last log, if it is of a test that has not stopped.
    std::optional<GrowthLog> unfinished() const {
        const auto last = last_growth_log(folder_);
        if (!last) return std::nullopt;
        GrowthLog log = read_growth_log(*last);
        for (const GrowthRecord& r : log.records)
            if (r.kind == GrowthRecord::event && r.item == 5) return std::nullopt;
        return log;
    }

    // Seconds since the log of this number was last written. Nothing if the computer was started since: its
    // clock need not have gone on.
    std::optional<double> since_last_write(int number) const { return last_write_.since(number); }

    // A new file, named by the date, with the next number.
    void begin(GrowthLog head) {
        number_ = head.number = growth_logs_in(folder_).number + 1;
        const std::time_t now = std::time(nullptr);
        std::tm utc{};
        gmtime_r(&now, &utc);
        char date[32], stamp[32];
        std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", &utc);
        std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &utc);
        head.begun = date;
        for (int copy = 0;; ++copy) {
            path_ = folder_ /
                    ("growth-" + std::string(stamp) + (copy > 0 ? "_" + std::to_string(copy) : "") + ".csv");
            try {
                file_.emplace(path_, O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_NOFOLLOW, 0644);
                break;
            } catch (const std::system_error& error) {
                if (error.code() == std::errc::file_exists && copy < 99) continue;
                if (error.code() != std::errc::file_exists) unlink(path_.c_str());
                throw;
            }
        }
        checksums_ = {};
        try {
            append(growth_log_file::head(head));
        } catch (...) {
            unlink(path_.c_str());
            throw;
        }
        const int folder = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder >= 0) {
            fsync(folder);
            close(folder);
        }
    }

    // Goes on with a log that is not complete. A torn last line is cut off; it never was a record. Throws if
    // the log is no more what was read of it.
    void resume(const GrowthLog& log) {
        file_.emplace(log.file, O_RDWR | O_APPEND | O_NOFOLLOW);
        path_ = log.file;
        number_ = log.number;
        const std::string text = file_->read();
        const std::size_t whole = text.rfind('\n') + 1;
        checksums_ = growth_log_file::checksums_of(text.substr(0, whole), log.file);
        if (whole < text.size() && ftruncate(file_->number(), static_cast<off_t>(whole)) != 0) file_->fail();
    }

    // All of the lines or, if it throws, none.
    void append(const std::string& lines) {
        LineChecksums after = checksums_;
        const std::string text = after.added(lines);
        const off_t before = file_->state().st_size;
        try {
            std::string_view rest = text;
            while (!rest.empty()) {
                const ssize_t n = ::write(file_->number(), rest.data(), rest.size());
                if (n >= 0)
                    rest.remove_prefix(static_cast<std::size_t>(n));
                else if (errno != EINTR)
                    file_->fail();
            }
            if (fsync(file_->number()) != 0) file_->fail();
        } catch (...) {
            if (ftruncate(file_->number(), before) != 0) {
                // The reader leaves a torn line out.
            }
            throw;
        }
        checksums_ = after;
        last_write_.note(number_);
    }

private:
    static hal::RegularFile locked(const std::filesystem::path& folder) {
        std::filesystem::create_directories(folder);
        hal::RegularFile lock(folder / ".growth_log.lock", O_RDONLY | O_CREAT | O_NOFOLLOW, 0644);
        if (flock(lock.number(), LOCK_EX | LOCK_NB) != 0)
            throw std::runtime_error(folder.string() + " is written by another growth_log");
        return lock;
    }

    std::filesystem::path folder_;
    hal::RegularFile lock_;
    LastWrite last_write_;
    std::optional<hal::RegularFile> file_;
    std::filesystem::path path_;
    int number_ = 0;
    LineChecksums checksums_;
};

}  // namespace plumb
