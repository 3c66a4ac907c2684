// SPDX-License-Identifier: GPL-2.0-or-later
// Which files of Plumb's lie in a folder, and whether they are of this Plumb.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumb::commands {

using Texts = std::vector<std::string>;

// The release of Plumb that a module or program is of, without running it; empty when it is none of Plumb's.
std::string version_of(const std::filesystem::path& file);

// Whether two files come from the same run of the linker, whether or not `cmake --install` has stripped one
// of them; files that were not linked, whether their contents are the same.
bool same_build(const std::filesystem::path& one, const std::filesystem::path& other);

// Files as they should be in a folder.
struct Comparison {
    Texts right;    // names
    Texts missing;  // names
    Texts wrong;    // names, each with what is wrong
};

// Compares files of a folder, names with an ending, with this Plumb; with those in `originals`, too, unless
// that is empty.
Comparison compare(const std::filesystem::path& folder, const Texts& names, const std::string& ending,
                   const std::filesystem::path& originals = {});

// Names of modules in a folder that are Plumb's, but none of `names`.
Texts stale_modules(const std::filesystem::path& folder, const Texts& names);

// The first program of this name in PATH; empty without one.
std::filesystem::path program_in_path(const std::string& name);

}  // namespace plumb::commands
