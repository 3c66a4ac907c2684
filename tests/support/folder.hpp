// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace plumb {

// A folder for a test's files, removed with all that is in it. It is named and locked as a TemporaryFolder of
// plumb_folder.py, which removes it after a kill.
class Folder {
public:
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }
    // Writes a file and returns its path.
    std::filesystem::path write(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path path_;
    int lock_ = -1;
};

// The bytes of a file; none where it cannot be read.
std::string contents(const std::filesystem::path& file);

}  // namespace plumb
