// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/atomic_file.hpp"
#include "components/io/files/error_table_file.hpp"

#include <filesystem>
#include <string>
#include <system_error>

namespace plumb {

// Writes into a file of error tables the seal of its present content. Throws std::runtime_error with file,
// line and reason if its tables are wrong, or std::system_error with the file; it is as before then.
inline void seal_error_table(const std::filesystem::path& path) {
    csv::text_of(path);  // a file that is none leaves no lock
    AtomicFile file(path);
    struct Unlock {
        const AtomicFile& its;
        ~Unlock() {
            std::error_code error;
            std::filesystem::remove(its.path().string() + ".lock", error);
        }
    } unlock{file};
    const std::string text = file.read().value_or("");
    const std::string sealed = error_table_file::Reader::sealed(path.string(), text);
    if (sealed != text) file.write(sealed);
}

}  // namespace plumb
