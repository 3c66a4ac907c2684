// SPDX-License-Identifier: GPL-2.0-or-later
// The folder of the build that a test program belongs to, and the folder of the sources. Both are found when the program
// runs: a clone may be seen at another place than the one where it was built.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace plumb {

inline const std::string& build_folder() {
    static const std::string folder = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
    return folder;
}

inline const std::string& source_folder() {
    static const char* const elsewhere = std::getenv("PLUMB_SOURCE");
    static const std::string folder = elsewhere != nullptr ? elsewhere : SOURCE_DIR;
    return folder;
}

}  // namespace plumb
