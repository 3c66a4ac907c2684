// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"
#include "hal/regular_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace plumb {

// The logs of one folder. One writer at a time; a log is only ever appended to, and each batch of lines is on
// the disk before append() returns. All throw std::system_error or std::runtime_error with the file and the
// reason.
class GrowthLogWriter {
public:
    explicit GrowthLogWriter(std::filesystem::path folder)
        : folder_(std::move(folder)), lock_(locked(folder_)) {}

    const std::filesystem::path& path() const { return path_; }

    // The youngest log, if it is of a test that has not stopped.
    std::optional<GrowthLog> unfinished() const {
        std::filesystem::path newest;
        for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
            const std::string name = entry.path().filename().string();
            if (name.rfind("growth-", 0) == 0 && entry.path().extension() == ".csv" && entry.path() > newest)
                newest = entry.path();
        }
        if (newest.empty()) return std::nullopt;
        GrowthLog log = read_growth_log(newest);
        for (const GrowthRecord& r : log.records)
            if (r.kind == GrowthRecord::event && r.item == 5) return std::nullopt;
        return log;
    }

    // Seconds since the log was last written.
    static double age(const std::filesystem::path& file) {
        struct stat state {};
        if (stat(file.c_str(), &state) != 0) return 0;
        return std::max(0.0, std::difftime(std::time(nullptr), state.st_mtime));
    }

    // A new file, named by the date.
    void begin(GrowthLog head) {
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
                if (error.code() != std::errc::file_exists || copy == 99) throw;
            }
        }
        append(growth_log_file::head(head));
        const int folder = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder >= 0) {
            fsync(folder);
            close(folder);
        }
    }

    // Goes on with a log that is not complete. A torn last line is cut off; it never was a record.
    void resume(const std::filesystem::path& file) {
        file_.emplace(file, O_RDWR | O_APPEND | O_NOFOLLOW);
        path_ = file;
        const std::string text = file_->read();
        const std::size_t whole = text.rfind('\n') + 1;
        if (whole < text.size() && ftruncate(file_->number(), static_cast<off_t>(whole)) != 0) file_->fail();
    }

    // All of the lines or, if it throws, none.
    void append(const std::string& lines) {
        const off_t before = file_->state().st_size;
        try {
            std::string_view rest = lines;
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
    std::optional<hal::RegularFile> file_;
    std::filesystem::path path_;
};

}  // namespace plumb
