// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/regular_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace plumb {

// A file that holds all of the last write or all of the one before, even after a crash. It keeps its owner
// and its rights, and one program at a time has it. It may lie in a folder that other users can write: no
// link of theirs is followed. All functions throw std::system_error, which names the file.
class AtomicFile {
public:
    // Throws std::errc::device_or_resource_busy if another program has the file.
    explicit AtomicFile(const std::filesystem::path& path)
        : path_(resolved(path)), lock_(open_lock(beside(".lock"))) {
        if (flock(lock_.number(), LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK) errno = EBUSY;
            fail(path_.string());
        }
        if (!exists()) return;
        hold();
        former_ = hal::RegularFile(path_, O_RDONLY | O_NOFOLLOW).state();
        // A write takes the file's place under one name; under the other name it would be another
        // program's.
        if (former_->st_nlink > 1) {
            errno = EMLINK;
            fail(path_.string() + " has another name, a hard link");
        }
        if (access(path_.c_str(), W_OK) != 0) fail(path_.string());
    }

    const std::filesystem::path& path() const { return path_; }

    // Nothing if there is no such file.
    std::optional<std::string> read() const {
        if (!exists()) return std::nullopt;
        return hal::RegularFile(path_, O_RDONLY | O_NOFOLLOW).read();
    }

    void write(std::string_view text) {
        if (exists()) hold();
        const std::filesystem::path fresh = beside(".new");
        struct stat state {};
        if (lstat(path_.c_str(), &state) == 0 && S_ISREG(state.st_mode)) former_ = state;
        // Left by a crash, or put there by another user.
        if (unlink(fresh.c_str()) != 0 && errno != ENOENT) fail(fresh.string());
        try {
            hal::RegularFile file(fresh, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, former_ ? 0600 : 0644);
            if (flock(file.number(), LOCK_EX | LOCK_NB) != 0) file.fail();
            if (former_) resemble(file);
            while (!text.empty()) {
                const ssize_t n = ::write(file.number(), text.data(), text.size());
                if (n >= 0)
                    text.remove_prefix(static_cast<std::size_t>(n));
                else if (errno != EINTR)
                    fail(fresh.string());
            }
            if (fsync(file.number()) != 0) fail(fresh.string());
            if (rename(fresh.c_str(), path_.c_str()) != 0) fail(path_.string());
            held_.emplace(std::move(file));
        } catch (...) {
            unlink(fresh.c_str());
            throw;
        }
        const int folder = open(path_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder < 0) fail(path_.parent_path().string());
        const int error = fsync(folder) == 0 ? 0 : errno;
        close(folder);
        if (error == 0) return;
        errno = error;
        fail(path_.parent_path().string());
    }

private:
    [[noreturn]] static void fail(const std::string& what) {
        throw std::system_error(errno, std::generic_category(), what);
    }

    // A link stays, and is no way round the lock. But a link that another user has put into a folder for
    // all may lead to a place that this user could not write.
    static std::filesystem::path resolved(std::filesystem::path path) {
        constexpr int most_links = 40;
        struct stat link {};
        for (int links = 0; lstat(path.c_str(), &link) == 0 && S_ISLNK(link.st_mode); ++links) {
            const std::filesystem::path parent = path.parent_path();
            struct stat folder {};
            if (stat(parent.c_str(), &folder) == 0 && (folder.st_mode & S_IWOTH) != 0 &&
                link.st_uid != geteuid() && link.st_uid != folder.st_uid) {
                errno = EACCES;
                fail(path.string() + " is a link of user " + std::to_string(link.st_uid) +
                     " in a folder that all can write");
            }
            if (links == most_links) {
                errno = ELOOP;
                fail(path.string());
            }
            path = parent / std::filesystem::read_symlink(path);
        }
        return std::filesystem::weakly_canonical(path);
    }

    // The lock of the file itself: a user may remove the file .lock while a program has the file.
    void hold() {
        hal::RegularFile file(path_, O_RDONLY | O_NOFOLLOW);
        const struct stat there = file.state();
        if (held_) {
            const struct stat held = held_->state();
            if (held.st_dev == there.st_dev && held.st_ino == there.st_ino) return;
        }
        if (flock(file.number(), LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK) errno = EBUSY;
            fail(path_.string());
        }
        held_.emplace(std::move(file));
    }

    static hal::RegularFile open_lock(const std::filesystem::path& path) {
        for (int tries = 0;; ++tries) {
            try {
                return {path, O_RDONLY | O_NOFOLLOW};
            } catch (const std::system_error& error) {
                if (error.code() != std::errc::no_such_file_or_directory) throw;
            }
            try {
                return {path, O_RDONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0644};
            } catch (const std::system_error& error) {  // another program was faster
                if (error.code() != std::errc::file_exists || tries == 100) throw;
            }
        }
    }

    // A user that may not give a file away keeps its group at least, or else gives the group no right.
    void resemble(const hal::RegularFile& file) const {
        constexpr auto same = static_cast<uid_t>(-1);
        mode_t mode = former_->st_mode & 07777;
        const struct stat state = file.state();
        if ((state.st_uid != former_->st_uid || state.st_gid != former_->st_gid) &&
            fchown(file.number(), former_->st_uid, former_->st_gid) != 0 &&
            fchown(file.number(), same, former_->st_gid) != 0)
            mode &= ~static_cast<mode_t>(S_IRWXG);
        if (fchmod(file.number(), mode) != 0) file.fail();
    }

    bool exists() const { return std::filesystem::exists(std::filesystem::symlink_status(path_)); }

    std::filesystem::path beside(const char* ending) const { return path_.string() + ending; }

    const std::filesystem::path path_;
    const hal::RegularFile lock_;           // a file of its own: path_ may not exist yet
    std::optional<hal::RegularFile> held_;  // path_, locked
    std::optional<struct stat> former_;     // the file, at the last look
};

}  // namespace plumb
