// SPDX-License-Identifier: GPL-2.0-or-later
// Whole files, and pictures as PNG.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "hal/regular_file.hpp"

namespace plumb::commissioning {

// In the place of an older file, the whole file or none. Throws std::system_error with the file.
inline void write_file(const std::filesystem::path& path, const std::string& text) {
    const auto fail = [&] { throw std::system_error(errno, std::generic_category(), path.string()); };
    const std::filesystem::path fresh = path.string() + ".new";
    try {
        {
            const hal::RegularFile file(fresh, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0666);
            for (std::string_view rest = text; !rest.empty();) {
                const ssize_t n = ::write(file.number(), rest.data(), rest.size());
                if (n >= 0)
                    rest.remove_prefix(static_cast<std::size_t>(n));
                else if (errno != EINTR)
                    fail();
            }
            if (fsync(file.number()) != 0) fail();
        }
        if (std::rename(fresh.c_str(), path.c_str()) != 0) fail();
    } catch (...) {
        unlink(fresh.c_str());
        throw;
    }
}

// False if rsvg-convert is not installed, or fails.
inline bool to_png(const std::filesystem::path& svg, const std::filesystem::path& png) {
    const std::filesystem::path fresh = png.string() + ".new";
    std::string program = "rsvg-convert", option = "-o", to = fresh.string(), from = svg.string();
    char* words[] = {program.data(), option.data(), to.data(), from.data(), nullptr};
    pid_t child = 0;
    if (posix_spawnp(&child, "rsvg-convert", nullptr, nullptr, words, environ) != 0) return false;
    int status = 0;
    const bool drawn =
        waitpid(child, &status, 0) == child && status == 0 && std::rename(fresh.c_str(), png.c_str()) == 0;
    if (!drawn) unlink(fresh.c_str());
    return drawn;
}

}  // namespace plumb::commissioning
