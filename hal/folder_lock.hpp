// SPDX-License-Identifier: GPL-2.0-or-later
// The lock of a temporary folder shows in all namespaces that the program which made the folder lives. The
// next program may remove a folder whose lock is free.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string>

namespace plumb::hal {

inline bool same_file(const struct stat& one, const struct stat& other) {
    return one.st_ino == other.st_ino && one.st_dev == other.st_dev;
}

// In an open folder, or AT_FDCWD. Follows no link. Below 0 if it fails.
inline int open_folder(int where, const char* name) {
    return openat(where, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

// By flock(), whose words `kind` has. False if another program holds it, or the file system has no locks.
inline bool lock_folder(int folder, int kind) {
    int result = 0;
    do result = flock(folder, kind);
    while (result != 0 && errno == EINTR);
    return result == 0;
}

// For a folder that this program has just made. Returns the lock, which close() frees, or -1 if there is
// none. Returns nothing if another program has found the folder before it was locked, and removed it.
inline std::optional<int> lock_new_folder(const std::string& path) {
    const int folder = open_folder(AT_FDCWD, path.c_str());
    if (folder < 0) return errno == ENOENT ? std::nullopt : std::optional(-1);
    lock_folder(folder, LOCK_SH);
    struct stat state {};
    struct stat named {};
    if (fstat(folder, &state) == 0 && lstat(path.c_str(), &named) == 0 && same_file(state, named))
        return folder;
    close(folder);
    rmdir(path.c_str());
    return std::nullopt;
}

}  // namespace plumb::hal
