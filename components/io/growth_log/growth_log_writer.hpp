// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_logs.hpp"
#include "components/io/growth_log/last_write.hpp"
#include "hal/regular_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
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
