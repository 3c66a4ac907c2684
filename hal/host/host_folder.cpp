// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/host_folder.hpp"

#include <dirent.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "hal/folder_lock.hpp"
#include "hal/host/leftovers.hpp"
#include "hal/socket_folder.hpp"

namespace plumb::host {

namespace {

constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz0123456789";
constexpr std::size_t drawn = 6;  // letters behind the beginning of a name

// Whether nobody else can remove or rename files of this process in the folder. In a user namespace its
// owner has no number to be known by.
bool is_safe(const std::string& folder) {
    struct stat state {};
    if (stat(folder.c_str(), &state) != 0 || (geteuid() == 0 && state.st_uid != 0)) return false;
    return (state.st_mode & (S_IWGRP | S_IWOTH)) == 0 || (state.st_mode & S_ISVTX) != 0;
}

// Root's rtapi_app opens the socket with the rights of another user, who may not get into a TMPDIR of root's.
bool can_be_reached(std::string folder) {
    if (geteuid() != 0) return true;
    for (struct stat state{}; !folder.empty(); folder.erase(folder.rfind('/')))
        if (stat(folder.c_str(), &state) != 0 || (state.st_mode & S_IXOTH) == 0) return false;
    return true;
}

// The folders in which a host makes its own, the first choice first.
std::vector<std::string> places() {
    const char* const asked_for = std::getenv("TMPDIR");
    // A socket's path must be short, and TMPDIR may not be there.
    const std::size_t most = sizeof sockaddr_un::sun_path - 1 - 1 - std::strlen(hal::socket_name) -
                             std::strlen(host_file_template) - 1;
    std::vector<std::string> found;
    if (asked_for != nullptr && *asked_for == '/' && std::strlen(asked_for) <= most)
        found.emplace_back(asked_for);
    found.emplace_back("/tmp");
    const auto unfit = [](const std::string& place) { return !is_safe(place) || !can_be_reached(place); };
    found.erase(std::remove_if(found.begin(), found.end(), unfit), found.end());
    return found;
}

bool is_name_of_a_host(std::string_view name) {
    const std::string_view beginning = host_file_beginning;
    return name.size() == beginning.size() + drawn && name.substr(0, beginning.size()) == beginning &&
           name.find_first_not_of(letters, beginning.size()) == std::string_view::npos;
}

// Whether a host listens in the folder: one of an older Plumb has no lock.
bool answers(int folder) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = "/proc/self/fd/" + std::to_string(folder) + "/" + hal::socket_name;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int caller = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool refused = caller >= 0 &&
                         connect(caller, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 &&
                         (errno == ECONNREFUSED || errno == ENOENT);
    if (caller >= 0) close(caller);
    return !refused;
}

bool is_dead(int place, const char* name, int folder) {
    struct stat state {};
    struct stat named {};
    return fstat(folder, &state) == 0 && state.st_uid == geteuid() &&
           hal::lock_folder(folder, LOCK_EX | LOCK_NB) &&
           fstatat(place, name, &named, AT_SYMLINK_NOFOLLOW) == 0 && hal::same_file(state, named) &&
           !answers(folder);
}

bool remove_if_dead(int place, const char* name) {
    const int folder = hal::open_folder(place, name);
    if (folder < 0) return false;
    const bool dead = is_dead(place, name, folder);
    if (dead) unlinkat(folder, hal::socket_name, 0);
    const bool removed = dead && unlinkat(place, name, AT_REMOVEDIR) == 0;
    close(folder);
    return removed;
}

}  // namespace

// The keeper knows of the folder before it is there: the host may be killed at any moment.
HostFolder::HostFolder() {
    std::random_device random;
    errno = EACCES;  // where there is no place at all
    for (const std::string& place : places()) {
        for (int tries = 0; tries < 100; ++tries) {
            path_ = place + "/" + host_file_beginning;
            for (std::size_t i = 0; i < drawn; ++i) path_ += letters[random() % letters.size()];
            leftovers().set_folder(path_);
            const bool made = mkdir(path_.c_str(), 0700) == 0;
            if (!made && errno != EEXIST) break;
            if (const auto lock = made ? hal::lock_new_folder(path_) : std::nullopt) {
                lock_ = *lock;
                return;
            }
        }
    }
    const int error = errno;
    leftovers().set_folder("");
    throw std::runtime_error(std::string("cannot make a folder for the host's socket in /tmp: ") +
                             std::strerror(error));
}

HostFolder::~HostFolder() {
    hal::remove_socket_folder(path_);
    if (lock_ >= 0) close(lock_);
}

bool remove_folders_of_killed_hosts() {
    bool any = false;
    for (const std::string& place : places()) {
        DIR* const entries = opendir(place.c_str());
        if (entries == nullptr) continue;
        std::vector<std::string> names;
        while (const dirent* const entry = readdir(entries))
            if (is_name_of_a_host(entry->d_name)) names.emplace_back(entry->d_name);
        for (const std::string& name : names) any = remove_if_dead(dirfd(entries), name.c_str()) || any;
        closedir(entries);
    }
    return any;
}

}  // namespace plumb::host
