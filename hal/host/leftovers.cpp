// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/leftovers.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/shm.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb::host {

namespace {

bool begins_with(const std::string& text, const char* beginning) {
    return text.rfind(beginning, 0) == 0;
}

bool alive(int process) {
    return process > 0 && (kill(process, 0) == 0 || errno != ESRCH);
}

// libfaketime names its memory for the process that makes it, and does not remove it when that ends.
bool is_dead_faketimes(const std::string& name) {
    for (const char* const beginning : {"faketime_shm_", "sem.faketime_sem_"})
        if (begins_with(name, beginning)) return !alive(std::atoi(name.c_str() + std::strlen(beginning)));
    return false;
}

bool is_tool_table(const std::string& name) {
    return name == ".tool.mmap";
}

void remove_young(const char* folder, bool (*belongs)(const std::string& name), std::time_t since) {
    std::error_code error;
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        struct stat state {};
        if (belongs(entry.path().filename()) && lstat(entry.path().c_str(), &state) == 0 &&
            S_ISREG(state.st_mode) && state.st_uid == geteuid() && state.st_ctime >= since)
            found.push_back(entry.path());
    }
    for (const auto& file : found) std::filesystem::remove(file, error);
}

// Keys of shared memory as LinuxCNC has them: of motion and its like, of the buffers in linuxcnc.nml, of
// halscope, and HAL's own, which are four letters that begin with H.
bool is_linuxcncs_key(unsigned long key) {
    return (key >= 100 && key < 200) || (key > 1000 && key <= 1010) || key == 0x130CF406 || key >> 24 == 'H';
}

void remove_if_unattached(int segment) {
    shmid_ds state{};
    if (shmctl(segment, IPC_STAT, &state) == 0 && state.shm_nattch == 0) shmctl(segment, IPC_RMID, nullptr);
}

// Removes shared memory of this user's dead programs: those of a killed LinuxCNC leave it behind.
void remove_young_segments(std::time_t since) {
    std::vector<int> found;
    std::ifstream table("/proc/sysvipc/shm");
    std::string line;
    std::getline(table, line);  // the headings
    while (std::getline(table, line)) {
        std::istringstream words(line);
        unsigned long key = 0;
        int segment = 0;
        shmid_ds state{};
        if (words >> key >> segment && is_linuxcncs_key(key & 0xffffffff) &&
            shmctl(segment, IPC_STAT, &state) == 0 && state.shm_perm.uid == geteuid() &&
            state.shm_ctime >= since && !alive(state.shm_cpid))
            found.push_back(segment);
    }
    for (const int segment : found) remove_if_unattached(segment);
}

}  // namespace

bool is_linuxcncs_in_tmp(const std::string& name) {
    return name == linuxcnc_lock_file || begins_with(name, "linuxcnc.debug.") ||
           begins_with(name, "linuxcnc.print.");
}

struct Leftovers::Page {
    static constexpr int most_segments = 512;
    std::atomic<int> segments;
    int segment[most_segments];
    char folder[256];
    char placeholder[512];
    std::time_t began;
};

Leftovers& leftovers() {
    static Leftovers the_leftovers;
    return the_leftovers;
}

void Leftovers::share() {
    void* memory = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to share with the host");
    page_ = static_cast<Page*>(memory);
    page_->began = std::time(nullptr);
}

void Leftovers::add_segment(int system_id) {
    if (page_ == nullptr) return;
    const int count = page_->segments;
    for (int i = 0; i < count; ++i)
        if (page_->segment[i] == system_id) return;
    if (count == Page::most_segments) return;
    page_->segment[count] = system_id;
    page_->segments = count + 1;
}

void Leftovers::set_folder(const std::string& folder) {
    if (page_ == nullptr) return;
    std::snprintf(page_->folder, sizeof page_->folder, "%s", folder.c_str());
}

void Leftovers::set_placeholder(const std::string& file) {
    if (page_ == nullptr || file.size() >= sizeof page_->placeholder) return;
    std::strcpy(page_->placeholder, file.c_str());
}

void Leftovers::clear_away() const {
    if (page_ == nullptr) return;
    if (page_->placeholder[0] != '\0') Placeholder::remove(page_->placeholder);
    if (page_->folder[0] != '\0') hal::remove_socket_folder(page_->folder);
}

void Leftovers::clear_machine() const {
    if (page_ == nullptr) return;
    for (int i = 0; i < page_->segments; ++i) remove_if_unattached(page_->segment[i]);
    remove_young_segments(page_->began);
    remove_young("/tmp", is_linuxcncs_in_tmp, page_->began);
    remove_young("/dev/shm", is_dead_faketimes, page_->began);
    if (const char* const home = std::getenv("HOME")) remove_young(home, is_tool_table, page_->began);
}

Placeholder::Placeholder(const std::string& file) : file_(file), descriptor_(-1) {
    for (;;) {
        descriptor_ = open(file.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (!held() || flock(descriptor_, LOCK_SH) != 0) return;
        // Another host may have removed it since it was opened. A file without a name that is still there
        // has been mounted over it, by a host around this one.
        struct stat opened {};
        struct stat named {};
        if (fstat(descriptor_, &opened) != 0 || opened.st_nlink > 0) return;
        if (lstat(file.c_str(), &named) == 0 && named.st_ino == opened.st_ino &&
            named.st_dev == opened.st_dev)
            return;
        close(descriptor_);
    }
}

Placeholder::~Placeholder() {
    if (!held()) return;
    close(descriptor_);
    remove(file_);
}

void Placeholder::remove(const std::string& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) return;
    struct stat state {};
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0 && fstat(descriptor, &state) == 0 && state.st_size == 0)
        unlink(file.c_str());
    close(descriptor);
}

}  // namespace plumb::host
