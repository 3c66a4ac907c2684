// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace plumb {

// A file that holds, after a crash at whatever moment, all that was written last or all that was written
// before. One program at a time has it.  All throw std::system_error, which names the file.
class AtomicFile {
public:
    // std::errc::device_or_resource_busy where another program has it.
    explicit AtomicFile(const std::filesystem::path& path)
        : path_(std::filesystem::weakly_canonical(path)),  // a link stays, and is no way round the lock
          lock_(open(beside(".lock"), O_RDWR | O_CREAT)) {
        if (flock(lock_.number, LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK) errno = EBUSY;
            fail(path_.string());
        }
        if (access(path_.c_str(), F_OK) == 0 && access(path_.c_str(), W_OK) != 0) fail(path_.string());
    }

    const std::filesystem::path& path() const { return path_; }

    // Nothing where there is no such file.
    std::optional<std::string> read() const {
        if (!std::filesystem::exists(path_)) return std::nullopt;
        const Descriptor file = open(path_, O_RDONLY);
        std::string text;
        char bytes[4096];
        for (ssize_t n; (n = ::read(file.number, bytes, sizeof bytes)) != 0;)
            if (n > 0)
                text.append(bytes, static_cast<std::size_t>(n));
            else if (errno != EINTR)
                fail(path_.string());
        return text;
    }

    void write(std::string_view text) const {
        const std::filesystem::path fresh = beside(".new");
        try {
            const Descriptor file = open(fresh, O_WRONLY | O_CREAT | O_TRUNC);
            while (!text.empty()) {
                const ssize_t n = ::write(file.number, text.data(), text.size());
                if (n >= 0)
                    text.remove_prefix(static_cast<std::size_t>(n));
                else if (errno != EINTR)
                    fail(fresh.string());
            }
            if (fsync(file.number) != 0) fail(fresh.string());
            if (rename(fresh.c_str(), path_.c_str()) != 0) fail(path_.string());
        } catch (...) {
            unlink(fresh.c_str());
            throw;
        }
        const Descriptor folder = open(path_.parent_path(), O_RDONLY | O_DIRECTORY);
        if (fsync(folder.number) != 0) fail(path_.parent_path().string());
    }

private:
    struct Descriptor {
        explicit Descriptor(int opened) : number(opened) {}
        Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
        ~Descriptor() {
            if (number >= 0) close(number);
        }
        int number;
    };

    [[noreturn]] static void fail(const std::string& what) {
        throw std::system_error(errno, std::generic_category(), what);
    }

    static Descriptor open(const std::filesystem::path& path, int how) {
        const int number = ::open(path.c_str(), how | O_CLOEXEC, 0644);
        if (number < 0) fail(path.string());
        return Descriptor(number);
    }

    std::filesystem::path beside(const char* ending) const { return path_.string() + ending; }

    const std::filesystem::path path_;
    const Descriptor lock_;  // on a file of its own, for a rename ends what is locked
};

}  // namespace plumb
