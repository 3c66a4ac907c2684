// SPDX-License-Identifier: GPL-2.0-or-later
// Where libfaketime is, which lets the clock of user-space programs go faster or slower.
#pragma once

#include <filesystem>
#include <system_error>

namespace plumb::host {

// Empty when it is not installed. Debian keeps it in a folder that is named for the architecture.
inline std::filesystem::path faketime_library() {
    const std::filesystem::path name = "faketime/libfaketimeMT.so.1";
    std::error_code error;
    for (const std::filesystem::path folder : {"/usr/lib", "/usr/local/lib"}) {
        if (std::filesystem::exists(folder / name, error)) return folder / name;
        for (const auto& entry : std::filesystem::directory_iterator(folder, error))
            if (std::filesystem::exists(entry.path() / name, error)) return entry.path() / name;
    }
    return {};
}

}  // namespace plumb::host
