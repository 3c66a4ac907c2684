// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/folder.hpp"

#include "hal/folder_lock.hpp"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace plumb {

Folder::Folder() {
    const auto pattern = (std::filesystem::temp_directory_path() / "plumb-temporary-XXXXXX").string();
    std::optional<int> lock;
    while (!lock) {
        std::string drawn = pattern;
        if (!mkdtemp(drawn.data())) throw std::runtime_error("cannot make a folder like " + pattern);
        lock = hal::lock_new_folder(drawn);
        path_ = drawn;
    }
    lock_ = *lock;
}

Folder::~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    if (lock_ >= 0) close(lock_);
}

std::filesystem::path Folder::write(const std::string& name, const std::string& text) const {
    std::ofstream out(path_ / name);
    out << text;
    if (!out.flush()) throw std::runtime_error("cannot write " + (path_ / name).string());
    return path_ / name;
}

std::string contents(const std::filesystem::path& file) {
    std::ostringstream text;  // takes whole blocks
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

}  // namespace plumb
