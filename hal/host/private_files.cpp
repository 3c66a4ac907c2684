// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/private_files.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace plumb::host {

namespace {

namespace files = std::filesystem;

const files::path tmp = "/tmp";
const files::path device_folder = "/dev";
const files::path shared_memory_folder = "/dev/shm";

// Devices that a program may need and that drive nothing.
constexpr const char* harmless_devices[] = {"null", "zero",    "full",   "random", "urandom",
                                            "tty",  "console", "pts",    "mqueue", "dri",
                                            "fd",   "stdin",   "stdout", "stderr"};

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

void mount_empty(const files::path& folder, const char* options) {
    if (mount("plumb", folder.c_str(), "tmpfs", MS_NOSUID, options) != 0)
        fail("cannot give the program a " + folder.string() + " of its own");
}

// Makes `there` appear as `here`, in a folder of the run's own. The program could not have used a file that
// has just gone, or is another user's, either. Returns whether it is there, else with errno.
bool show(const files::path& there, const files::path& here) {
    std::error_code error;
    if (files::is_symlink(there, error)) {
        files::copy_symlink(there, here, error);
        errno = error.value();
        return !error;
    }
    if (files::is_directory(there, error))
        files::create_directory(here, error);
    else if (const int file = open(here.c_str(), O_CREAT | O_CLOEXEC | O_WRONLY, 0600); file >= 0)
        close(file);
    return mount(there.c_str(), here.c_str(), nullptr, MS_BIND | MS_REC, nullptr) == 0;
}

class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) close(number_);
    }
    Descriptor(const Descriptor&) = delete;

    int operator*() const { return number_; }
    bool good() const { return number_ >= 0; }

    // Returns whether all that was written is there, as far as the system knows.
    bool close_now() { return close(std::exchange(number_, -1)) == 0; }

private:
    int number_;
};

// Brings new files of a program in its own /tmp to the real one, where other users may do anything
// meanwhile: it opens only files that it has just made, and follows no link.
class BroughtBack {
public:
    bool complete() const { return complete_; }

    // Copies a file, a link or a folder with all that is in it. Sockets and the like are nothing to keep.
    // `shown` is how people know it.
    void copy(int from_folder, const std::string& name, int to_folder, const std::string& new_name,
              const files::path& shown) {
        struct stat state {};
        if (fstatat(from_folder, name.c_str(), &state, AT_SYMLINK_NOFOLLOW) != 0) return lose(shown);
        const auto from = [&](int flags) {
            return openat(from_folder, name.c_str(), flags | O_NOFOLLOW | O_CLOEXEC);
        };
        if (S_ISLNK(state.st_mode)) {
            copy_link(from_folder, name, to_folder, new_name, state, shown);
        } else if (S_ISREG(state.st_mode)) {
            const Descriptor file(from(O_RDONLY));
            if (!file.good()) return lose(shown);
            if (copy_file(*file, to_folder, new_name, state)) return;
            const int error = errno;
            unlinkat(to_folder, new_name.c_str(), 0);  // half a result would be taken for a whole one
            errno = error;
            lose(shown);
        } else if (S_ISDIR(state.st_mode)) {
            const Descriptor folder(from(O_RDONLY | O_DIRECTORY));
            if (!folder.good() || mkdirat(to_folder, new_name.c_str(), 0700) != 0) return lose(shown);
            const Descriptor made(
                openat(to_folder, new_name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
            if (!made.good() || !is_own_folder(*made)) return lose(shown);
            copy_entries(*folder, *made, shown);
            copy_attributes(state, *made);
        }
    }

    void lose(const files::path& shown) {
        std::fprintf(stderr, "plumb run: %s is lost: %s\n", shown.c_str(), std::strerror(errno));
        complete_ = false;
    }

private:
    // Owner, rights and time; without its owner's name a file gets no more than its owner's rights.
    static void copy_attributes(const struct stat& from, int to) {
        const bool owned = fchown(to, from.st_uid, from.st_gid) == 0;
        fchmod(to, from.st_mode & (owned ? 07777 : 0777));
        const timespec times[] = {from.st_atim, from.st_mtim};
        futimens(to, times);
    }

    static bool is_own_folder(int folder) {
        struct stat state {};
        return fstat(folder, &state) == 0 && state.st_uid == geteuid();
    }

    void copy_link(int from_folder, const std::string& name, int to_folder, const std::string& new_name,
                   const struct stat& state, const files::path& shown) {
        std::string target(PATH_MAX, '\0');
        const ssize_t length = readlinkat(from_folder, name.c_str(), target.data(), target.size() - 1);
        if (length < 0) return lose(shown);
        target.resize(static_cast<std::size_t>(length));
        if (symlinkat(target.c_str(), to_folder, new_name.c_str()) != 0) return lose(shown);
        if (fchownat(to_folder, new_name.c_str(), state.st_uid, state.st_gid, AT_SYMLINK_NOFOLLOW) != 0)
            return;  // it is this user's, then
    }

    // Returns whether all of it is there.
    static bool copy_file(int from, int to_folder, const std::string& new_name, const struct stat& state) {
        Descriptor to(
            openat(to_folder, new_name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
        if (!to.good()) return false;
        std::vector<char> bytes(1 << 16);
        for (ssize_t n = 0; (n = read(from, bytes.data(), bytes.size())) != 0;) {
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) return false;
            for (ssize_t done = 0; done < n;) {
                const ssize_t written = write(*to, bytes.data() + done, static_cast<std::size_t>(n - done));
                if (written < 0 && errno != EINTR) return false;
                done += std::max<ssize_t>(written, 0);
            }
        }
        copy_attributes(state, *to);
        return to.close_now();
    }

    void copy_entries(int from, int to, const files::path& shown) {
        DIR* const entries = fdopendir(dup(from));
        if (entries == nullptr) return lose(shown);
        for (errno = 0; const dirent* const entry = readdir(entries); errno = 0) {
            const std::string name = entry->d_name;
            if (name != "." && name != "..") copy(from, name, to, name, shown / name);
        }
        if (errno != 0) lose(shown);
        closedir(entries);
    }

    bool complete_ = true;
};

bool belongs_to_the_run(const std::string& name) {
    const bool display =
        name.rfind(".X", 0) == 0 && name.size() > 7 && name.substr(name.size() - 5) == "-lock";
    const bool hosts_own = name.rfind(host_file_beginning, 0) == 0;
    return display || hosts_own || is_linuxcncs_in_tmp(name);
}

}  // namespace

PrivateFiles::PrivateFiles(bool devices) {
    std::error_code error;
    const files::path working_folder = files::current_path(error);
    real_tmp_ = open(tmp.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (real_tmp_ < 0) real_tmp_ = open(tmp.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (real_tmp_ < 0) fail(tmp.string());
    furnish_tmp();
    if (!devices)
        furnish_devices();
    else if (files::is_directory(shared_memory_folder, error))
        mount_empty(shared_memory_folder, "mode=1777");
    hide_tool_table();
    // The working folder may lie in /tmp, and is then another one now.
    if (!working_folder.empty()) files::current_path(working_folder, error);
}

PrivateFiles::~PrivateFiles() {
    umount2(tmp.c_str(), MNT_DETACH);
    close(real_tmp_);
    if (placeholder_) umount2(tool_table_.c_str(), MNT_DETACH);
}

files::path PrivateFiles::real_tmp() const {
    return "/proc/self/fd/" + std::to_string(real_tmp_);
}

void PrivateFiles::furnish_devices() {
    const int real = open(device_folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (real < 0) fail(device_folder.string());
    mount_empty(device_folder, "mode=0755");
    for (const char* const device : harmless_devices) {
        const files::path there = files::path("/proc/self/fd") / std::to_string(real) / device;
        std::error_code error;
        if (files::exists(files::symlink_status(there, error)) && !show(there, device_folder / device))
            std::fprintf(stderr, "plumb run: the program does not see /dev/%s: %s\n", device,
                         std::strerror(errno));
    }
    close(real);
    furnish_terminals();
    std::error_code error;
    files::create_directory(shared_memory_folder, error);
    mount_empty(shared_memory_folder, "mode=1777");
}

// New terminals come from /dev/ptmx, which belongs to the folder of terminals beside it. Where only the
// system's own may be opened, and not the one in that folder, the run gets a folder of its own.
void PrivateFiles::furnish_terminals() {
    const files::path folder = device_folder / "pts";
    std::error_code error;
    files::create_symlink("pts/ptmx", device_folder / "ptmx", error);
    if (access((folder / "ptmx").c_str(), R_OK | W_OK) == 0) return;
    files::create_directory(folder, error);
    mount("devpts", folder.c_str(), "devpts", MS_NOSUID | MS_NOEXEC, "newinstance,ptmxmode=0666,mode=0620");
}

void PrivateFiles::furnish_tmp() {
    mount_empty(tmp, "mode=1777");
    std::error_code error;
    for (const files::directory_entry& entry : files::directory_iterator(real_tmp(), error)) {
        const std::string name = entry.path().filename();
        if (name == linuxcnc_lock_file || is_twopass_file(name)) continue;
        seen_.push_back(name);
        show(entry.path(), tmp / name);
    }
    if (error)
        std::fprintf(stderr, "plumb run: the program sees an empty /tmp: %s\n", error.message().c_str());
}

void PrivateFiles::hide_tool_table() {
    const char* const home = std::getenv("HOME");
    if (home == nullptr || *home != '/') return;
    tool_table_ = Leftovers::tool_table_in(home);
    leftovers().set_placeholder(tool_table_);
    placeholder_.emplace(tool_table_);
    if (!placeholder_->held()) {
        // Where there is no such folder LinuxCNC cannot make one either.
        std::error_code error;
        if (files::exists(files::symlink_status(tool_table_, error)))
            std::fprintf(stderr, "plumb run: %s cannot be kept apart from the same file of another LinuxCNC\n",
                         tool_table_.c_str());
        placeholder_.reset();
        return;
    }
    // It keeps its name: a run inside this one could mount nothing over a file that has none.
    std::string cover = (tmp / host_file_template).string();
    const int file = mkostemp(cover.data(), O_CLOEXEC);
    if (file < 0 || mount(cover.c_str(), tool_table_.c_str(), nullptr, MS_BIND, nullptr) != 0)
        fail("cannot give the program a " + tool_table_ + " of its own");
    close(file);
}

bool PrivateFiles::bring_back() const {
    BroughtBack brought;
    const Descriptor own(open(tmp.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    std::vector<std::string> names;
    std::error_code error;
    for (const files::directory_entry& entry : files::directory_iterator(tmp, error))
        names.push_back(entry.path().filename());
    if (!own.good() || error) brought.lose(tmp);
    for (const std::string& name : names) {
        if (belongs_to_the_run(name) || std::find(seen_.begin(), seen_.end(), name) != seen_.end()) continue;
        std::string new_name = name;
        struct stat state {};
        for (int n = 1; fstatat(real_tmp_, new_name.c_str(), &state, AT_SYMLINK_NOFOLLOW) == 0; ++n)
            new_name = name + ".plumb-" + std::to_string(n);
        if (new_name != name)
            std::fprintf(stderr, "plumb run: /tmp/%s is another's meanwhile; the program's is /tmp/%s\n",
                         name.c_str(), new_name.c_str());
        brought.copy(*own, name, real_tmp_, new_name, tmp / new_name);
    }
    return brought.complete();
}

}  // namespace plumb::host
