// SPDX-License-Identifier: GPL-2.0-or-later
// Preloaded into plumb-retain, it kills it at the KILL_AT-th step of its writing. A step is each call that opens a
// new file to be written or a folder, that writes, syncs, closes or gives rights to such, unlinks or renames;
// and the middle of each write. The first step waits until there is a file KILL_AFTER.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <cstdlib>
#include <set>

namespace {

std::set<int>& watched() {
    static std::set<int> files;
    return files;
}

void wait_for_the_test() {
    while (access(std::getenv("KILL_AFTER"), F_OK) != 0) usleep(1000);
}

void step() {
    static const bool waited = (wait_for_the_test(), true);
    static_cast<void>(waited);
    static std::atomic<int> left{std::atoi(std::getenv("KILL_AT"))};
    if (--left == 0) kill(getpid(), SIGKILL);
}

template <class Function>
Function real(const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
    va_end(more);
    const bool written_again = (flags & O_EXCL) != 0 && (flags & O_ACCMODE) == O_WRONLY;
    const bool ours = written_again || (flags & O_DIRECTORY) != 0;
    if (ours) step();
    const int file = real<int (*)(const char*, int, ...)>("open")(path, flags, mode);
    if (ours) watched().insert(file);
    return file;
}

ssize_t write(int file, const void* bytes, size_t size) {
    const auto real_write = real<ssize_t (*)(int, const void*, size_t)>("write");
    if (watched().count(file) == 0) return real_write(file, bytes, size);
    step();
    const ssize_t half = real_write(file, bytes, size / 2);
    step();
    if (half < 0) return half;
    return half + real_write(file, static_cast<const char*>(bytes) + half, size - static_cast<size_t>(half));
}

int fsync(int file) {
    step();
    return real<int (*)(int)>("fsync")(file);
}

int fchown(int file, uid_t user, gid_t group) {
    step();
    return real<int (*)(int, uid_t, gid_t)>("fchown")(file, user, group);
}

int fchmod(int file, mode_t mode) {
    step();
    return real<int (*)(int, mode_t)>("fchmod")(file, mode);
}

int unlink(const char* path) {
    step();
    return real<int (*)(const char*)>("unlink")(path);
}

int rename(const char* from, const char* to) {
    step();
    return real<int (*)(const char*, const char*)>("rename")(from, to);
}

int close(int file) {
    if (watched().erase(file) != 0) step();
    return real<int (*)(int)>("close")(file);
}
}
