// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"
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

    // The log with the highest number, if it is of a test that has not stopped. A log without a number is the
    // last one only if it is the only one. Throws if one of them is damaged at its number: it may be the last
    // one.
    std::optional<GrowthLog> unfinished() const {
        const Logs logs = all();
        if (!logs.damaged.empty()) {
            read_growth_log(logs.damaged);  // which names line and reason
            throw std::runtime_error(logs.damaged.string() + ": its number is damaged");
        }
        if (logs.last.empty()) return std::nullopt;
        if (!logs.same_number.empty() && logs.number == 0) return std::nullopt;
        if (!logs.same_number.empty())
            throw std::runtime_error(logs.last.string() + " and " + logs.same_number.string() +
                                     " have the same number, " + std::to_string(logs.number) +
                                     ": move one of them out of the folder");
        GrowthLog log = read_growth_log(logs.last);
        for (const GrowthRecord& r : log.records)
            if (r.kind == GrowthRecord::event && r.item == 5) return std::nullopt;
        return log;
    }

    // Seconds since the log of this number was last written. Nothing if the computer was started since: its
    // clock need not have gone on.
    std::optional<double> since_last_write(int number) const { return last_write_.since(number); }

    // A new file, named by the date, with the next number.
    void begin(GrowthLog head) {
        number_ = head.number = all().number + 1;
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
    struct Logs {
        int number = 0;                           // the highest
        std::filesystem::path last, same_number;  // that have it; empty without one
        std::filesystem::path damaged;            // one whose number cannot be trusted
    };

    Logs all() const {
        Logs logs;
        for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
            const std::string name = entry.path().filename().string();
            if (name.rfind("growth-", 0) != 0 || entry.path().extension() != ".csv") continue;
            if (!entry.is_regular_file()) continue;
            std::string start(growth_log_file::identity_bytes, '\0');
            std::ifstream file(entry.path());
            file.read(start.data(), static_cast<std::streamsize>(start.size()));
            start.resize(static_cast<std::size_t>(file.gcount()));
            const growth_log_file::Identity its = growth_log_file::identity_of(start);
            if (its.damaged) logs.damaged = entry.path();
            if (its.number > logs.number || logs.last.empty()) {
                logs.last = entry.path();
                logs.same_number.clear();
            } else if (its.number == logs.number) {
                logs.same_number = entry.path();
            }
            logs.number = std::max(logs.number, its.number);
        }
        return logs;
    }

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
