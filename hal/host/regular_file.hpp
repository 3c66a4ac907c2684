// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace plumb::host {

// Why a file is not read: it is not there, or is something that ends never, or only when somebody writes into
// it. Empty for a regular file.
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

}  // namespace plumb::host
