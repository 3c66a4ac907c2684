// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/commands/installation.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>

#include "hal/identity.hpp"

namespace plumb::commands {

namespace fs = std::filesystem;

namespace {

std::string contents(const fs::path& file) {
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    return bytes.str();
}

std::string version_in(const std::string& bytes) {
    const std::string_view line = identity;
    const std::string_view key = line.substr(0, line.rfind(' ') + 1);
    const std::size_t at = bytes.find(key);
    if (at == std::string::npos) return "";
    const std::string rest =
        bytes.c_str() + at + key.size();  // to the end of the text, in a script of the line
    return rest.substr(0, rest.find('\n'));
}

// The linker's build identifier: a note with a header that is always the same, and 20 bytes.
std::string build_identifier(const std::string& bytes) {
    using namespace std::string_view_literals;
    constexpr auto header = "\4\0\0\0\24\0\0\0\3\0\0\0GNU\0"sv;  // lengths of name and value, kind, name
    const std::size_t at = bytes.find(header);
    return at == std::string::npos ? bytes : bytes.substr(at + header.size(), 20);
}

}  // namespace

std::string version_of(const fs::path& file) {
    return version_in(contents(file));
}

bool same_build(const fs::path& one, const fs::path& other) {
    return build_identifier(contents(one)) == build_identifier(contents(other));
}

Comparison compare(const fs::path& folder, const Texts& names, const std::string& ending,
                   const fs::path& originals) {
    Comparison result;
    for (const std::string& name : names) {
        const fs::path file = folder / (name + ending);
        if (!fs::exists(file)) {
            result.missing.push_back(name);
            continue;
        }
        const std::string version = version_of(file);
        if (version != PLUMB_VERSION)
            result.wrong.push_back(name +
                                   (version.empty() ? " (not Plumb's)" : " (of Plumb " + version + ")"));
        else if (!originals.empty() && !same_build(file, originals / (name + ending)))
            result.wrong.push_back(name + " (of another build)");
        else
            result.right.push_back(name);
    }
    return result;
}

Texts stale_modules(const fs::path& folder, const Texts& names) {
    Texts stale;
    std::error_code unreadable;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, unreadable)) {
        const std::string name = entry.path().stem();
        const bool ours = std::find(names.begin(), names.end(), name) != names.end();
        if (!ours && entry.path().extension() == ".so" && !version_of(entry.path()).empty())
            stale.push_back(name);
    }
    std::sort(stale.begin(), stale.end());
    return stale;
}

fs::path program_in_path(const std::string& name) {
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const fs::path candidate = fs::path(folder) / name;
        if (access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    return {};
}

}  // namespace plumb::commands
