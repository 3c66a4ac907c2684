// SPDX-License-Identifier: GPL-2.0-or-later
// A module as its tests see it without HAL: its declarations, and the path of its file.
#pragma once

#include "hal/manual.hpp"
#include "tests/support/place.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

class Module {
public:
    // Throws std::runtime_error when the file is not one of our modules.
    explicit Module(const std::filesystem::path& so) : file(so), library_(open(so)) {}
    ~Module() { dlclose(library_); }
    Module(const Module&) = delete;
    Module& operator=(const Module&) = delete;

    const std::filesystem::path file;

    const hal::Model& model() const { return *function<const hal::Model*>("plumb_model")(); }
    std::string options() const { return function<const char*>("plumb_options")(); }

private:
    static void* open(const std::filesystem::path& so) {
        void* const library = dlopen(so.c_str(), RTLD_LAZY | RTLD_LOCAL);  // lazily: no HAL is here
        if (!library) throw std::runtime_error(dlerror());
        return library;
    }

    template <class Result>
    Result (*function(const char* name) const)() {
        void* const symbol = dlsym(library_, name);
        if (!symbol) throw std::runtime_error(file.string() + " has no " + name);
        return reinterpret_cast<Result (*)()>(symbol);
    }

    void* const library_;
};

// The names of all modules in the build, sorted.
inline std::vector<std::string> built_modules() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(build_folder() + "/modules"))
        names.push_back(entry.path().stem());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace plumb
