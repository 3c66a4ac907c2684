// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/crc_32.hpp"
#include "hal/regular_file.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb {

// Identifies a program and its version: the CRC-32 of all its files, in this order, as an int32.
class ProgramIdentity {
public:
    explicit ProgramIdentity(std::vector<std::string> files) : files_(std::move(files)) {}

    // Reads the files again if one has changed. Returns 0 for no files, and only then. Throws
    // std::system_error with the file that cannot be read.
    std::int32_t look() {
        std::vector<Stamp> stamps;
        for (const std::string& file : files_) stamps.push_back(stamp(file));
        if (stamps != stamps_) {
            stamps_.clear();  // so that the next call reads the files again
            identity_ = identity();
            stamps_ = std::move(stamps);
        }
        return identity_;
    }

private:
    // Another one after each write: the time of the content alone can be set back, by touch or cp -p.
    using Stamp = std::tuple<dev_t, ino_t, off_t, time_t, long, time_t, long>;

    [[noreturn]] static void fail(const std::string& file) {
        throw std::system_error(errno, std::generic_category(), file);
    }

    static Stamp stamp(const std::string& file) {
        struct stat s {};
        if (stat(file.c_str(), &s) != 0) fail(file);
        return {s.st_dev,          s.st_ino,         s.st_size,        s.st_mtim.tv_sec,
                s.st_mtim.tv_nsec, s.st_ctim.tv_sec, s.st_ctim.tv_nsec};
    }

    std::int32_t identity() const {
        if (files_.empty()) return 0;
        std::string all;
        for (const std::string& name : files_) all += hal::RegularFile(name, O_RDONLY).read();
        const auto crc = static_cast<std::int32_t>(crc_32(all));
        return crc == 0 ? 1 : crc;
    }

    const std::vector<std::string> files_;
    std::vector<Stamp> stamps_;
    std::int32_t identity_ = 0;
};

}  // namespace plumb
