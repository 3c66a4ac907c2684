// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace plumb::hal {

// Why a file is not read: it is missing, or it is a device or pipe, which never ends, or ends only when a
// program writes into it. Empty for a regular file.
inline std::string irregularity(const std::filesystem::path& file) {
    using std::filesystem::file_type;
    std::error_code error;
    const file_type type = std::filesystem::status(file, error).type();
    const auto is = [](const std::string& what) { return "is a " + what + ", no regular file"; };
    switch (type) {
        case file_type::regular: return "";
        case file_type::not_found: return std::strerror(ENOENT);
        case file_type::directory: return is("folder");
        case file_type::block:
        case file_type::character: return is("device");
        case file_type::fifo: return is("pipe");
        case file_type::socket: return is("socket");
        default: return error ? error.message() : "is no regular file";
    }
}

// Throws std::runtime_error with the file and that reason.
inline void require_regular_file(const std::filesystem::path& file) {
    const std::string why = irregularity(file);
    if (!why.empty()) throw std::runtime_error(file.string() + ": " + why);
}

// A regular file that is open. All throw std::system_error, which names the file.
class RegularFile {
public:
    // Does not wait, as it would for the writer of a pipe. Flags as for open().
    RegularFile(std::filesystem::path path, int flags, mode_t mode = 0) : path_(std::move(path)) {
        number_ = ::open(path_.c_str(), flags | O_NONBLOCK | O_CLOEXEC, mode);
        if (number_ < 0 && errno == ELOOP && (flags & O_NOFOLLOW) != 0)
            throw std::system_error(errno, std::generic_category(), path_.string() + " is a link");
        if (number_ < 0) fail();
        struct stat state {};
        const bool known = fstat(number_, &state) == 0;
        if (known && S_ISREG(state.st_mode)) return;
        const int error = !known ? errno : S_ISDIR(state.st_mode) ? EISDIR : EINVAL;
        close(std::exchange(number_, -1));
        errno = error;
        if (!known) fail();
        if (errno == EISDIR) fail();
        throw std::system_error(errno, std::generic_category(), path_.string() + " is no regular file");
    }
    RegularFile(RegularFile&& other) noexcept
        : path_(std::move(other.path_)), number_(std::exchange(other.number_, -1)) {}
    ~RegularFile() {
        if (number_ >= 0) close(number_);
    }

    int number() const { return number_; }

    struct stat state() const {
        struct stat state {};
        if (fstat(number_, &state) != 0) fail();
        return state;
    }

    std::string read() const {
        std::string text;
        char bytes[4096];
        for (ssize_t n = 0; (n = ::read(number_, bytes, sizeof bytes)) != 0;)
            if (n > 0)
                text.append(bytes, static_cast<std::size_t>(n));
            else if (errno != EINTR)
                fail();
        return text;
    }

    [[noreturn]] void fail() const {
        throw std::system_error(errno, std::generic_category(), path_.string());
    }

private:
    std::filesystem::path path_;
    int number_ = -1;
};

}  // namespace plumb::hal
