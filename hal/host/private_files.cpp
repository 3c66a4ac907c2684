// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/private_files.hpp"

#include <fcntl.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace plumb::host {

namespace {

namespace files = std::filesystem;

constexpr const char* tmp = "/tmp";
constexpr const char* shared_memory_folder = "/dev/shm";
constexpr const char* lock_file = "linuxcnc.lock";

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

void bind(const std::string& from, const std::string& to) {
    if (mount(from.c_str(), to.c_str(), nullptr, MS_BIND | MS_REC, nullptr) != 0)
        fail("cannot show " + to + " to the program");
}

void mount_empty(const std::string& folder) {
    if (mount("plumb", folder.c_str(), "tmpfs", MS_NOSUID | MS_NODEV, "mode=1777") != 0)
        fail("cannot give the program a " + folder + " of its own");
}

}  // namespace

PrivateFiles::PrivateFiles() {
    std::error_code error;
    const files::path working_folder = files::current_path(error);
    real_tmp_ = open(tmp, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (real_tmp_ < 0) fail(tmp);
    furnish_tmp();
    if (files::is_directory(shared_memory_folder, error)) mount_empty(shared_memory_folder);
    hide_tool_table();
    // The working folder may lie in /tmp, and is then another one now.
    if (!working_folder.empty()) files::current_path(working_folder, error);
}

PrivateFiles::~PrivateFiles() {
    bring_back();
    umount2(tmp, MNT_DETACH);
    close(real_tmp_);
    if (placeholder_) umount2(tool_table_.c_str(), MNT_DETACH);
}

void PrivateFiles::furnish_tmp() {
    mount_empty(tmp);
    const std::string real = "/proc/self/fd/" + std::to_string(real_tmp_);
    for (const files::directory_entry& entry : files::directory_iterator(real)) {
        const std::string name = entry.path().filename();
        if (name == lock_file) continue;
        const files::path here = files::path(tmp) / name;
        std::error_code error;
        seen_.push_back(name);
        if (entry.is_symlink(error)) {
            files::copy_symlink(entry.path(), here, error);
            continue;
        }
        if (entry.is_directory(error))
            files::create_directory(here, error);
        else
            close(open(here.c_str(), O_CREAT | O_CLOEXEC | O_WRONLY, 0600));
        // What has just gone, or is another user's, the program could not have used either.
        mount(entry.path().c_str(), here.c_str(), nullptr, MS_BIND | MS_REC, nullptr);
    }
}

void PrivateFiles::hide_tool_table() {
    const char* const home = std::getenv("HOME");
    if (home == nullptr || *home != '/') return;
    tool_table_ = std::string(home) + "/.tool.mmap";
    leftovers().set_placeholder(tool_table_);
    placeholder_.emplace(tool_table_);
    if (!placeholder_->held()) return placeholder_.reset();  // LinuxCNC cannot make one there either
    const std::string cover = std::string(shared_memory_folder) + "/tool.mmap";
    close(open(cover.c_str(), O_CREAT | O_CLOEXEC | O_WRONLY, 0600));
    bind(cover, tool_table_);
    unlink(cover.c_str());
}

void PrivateFiles::bring_back() const {
    std::error_code error;
    for (const files::directory_entry& entry : files::directory_iterator(tmp, error)) {
        const std::string name = entry.path().filename();
        const bool file =
            entry.is_regular_file(error) || entry.is_directory(error) || entry.is_symlink(error);
        if (!file || name.rfind("linuxcnc.", 0) == 0 || name.rfind(".X", 0) == 0 ||
            std::find(seen_.begin(), seen_.end(), name) != seen_.end())
            continue;
        const files::path real = files::path("/proc/self/fd") / std::to_string(real_tmp_) / name;
        files::copy(entry.path(), real, files::copy_options::recursive | files::copy_options::copy_symlinks,
                    error);
        if (error)
            std::fprintf(stderr, "plumb run: /tmp/%s is lost: %s\n", name.c_str(), error.message().c_str());
    }
}

}  // namespace plumb::host
