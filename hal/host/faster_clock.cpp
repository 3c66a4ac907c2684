// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/faster_clock.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "hal/host/decimal.hpp"
#include "hal/host/faketime_library.hpp"

namespace plumb::host {

namespace {

const std::filesystem::path memory_folder = "/dev/shm";
constexpr const char* memory_names[] = {"sem.faketime_sem_", "faketime_shm_"};

std::filesystem::path memory_of(const char* beginning, pid_t process) {
    return memory_folder / (beginning + std::to_string(process));
}

// Lets libfaketime make its shared memory in a process that is killed, so that it does not remove it. Returns
// the process, or -1.
pid_t make_memory() {
    char shell[] = "sh", option[] = "-c", line[] = "kill -9 $$";
    char* const words[] = {shell, option, line, nullptr};
    pid_t maker = -1;
    if (posix_spawn(&maker, "/bin/sh", nullptr, nullptr, words, environ) != 0) return -1;
    int status = 0;
    while (waitpid(maker, &status, 0) < 0 && errno == EINTR) {
    }
    return maker;
}

}  // namespace

FasterClock::FasterClock(double speed) {
    const std::string library = faketime_library();
    if (library.empty()) throw std::runtime_error("libfaketime is not installed");
    const char* const others = std::getenv("LD_PRELOAD");
    std::string factor = "+0 x";
    append_number(factor, speed);
    set("LD_PRELOAD", others == nullptr || *others == '\0' ? library : library + ":" + others);
    set("FAKETIME", factor);
    share();
}

// libfaketime's memory belongs to the first program, and each subshell of that program removes it as it ends.
// Programs that come later have another clock then, or wait for ever. So the memory is this process's.
void FasterClock::share() {
    const pid_t maker = make_memory();
    for (const char* const name : memory_names)
        if (std::error_code error;
            std::filesystem::rename(memory_of(name, maker), memory_of(name, getpid()), error), error)
            return;
    const std::string number = std::to_string(getpid());
    set("FAKETIME_SHARED", "/faketime_sem_" + number + " /faketime_shm_" + number);
}

FasterClock::~FasterClock() {
    for (const auto& [variable, value] : before_) {
        if (value)
            setenv(variable, value->c_str(), 1);
        else
            unsetenv(variable);
    }
}

void FasterClock::set(const char* variable, const std::string& value) {
    const char* const before = std::getenv(variable);
    before_[variable] = before == nullptr ? std::nullopt : std::optional<std::string>(before);
    setenv(variable, value.c_str(), 1);
}

}  // namespace plumb::host
