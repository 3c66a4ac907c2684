// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/folder.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace plumb {

Folder::Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "plumb-test-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("cannot make a folder like " + pattern);
    path_ = pattern;
}

Folder::~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
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
