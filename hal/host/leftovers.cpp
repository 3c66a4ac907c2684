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

struct NamedFiles {
    const char* folder;
    const char* beginning;     // of their names
    bool ends_with_a_process;  // whose number is the rest of the name; while it lives, the file is in use
};

constexpr NamedFiles machine_files[] = {{"/tmp", "linuxcnc.lock", false},
                                        {"/tmp", "linuxcnc.debug.", false},
                                        {"/tmp", "linuxcnc.print.", false},
                                        {"/dev/shm", "faketime_shm_", true},
                                        {"/dev/shm", "sem.faketime_sem_", true}};

bool alive(int process) {
    return process > 0 && (kill(process, 0) == 0 || errno != ESRCH);
}

void remove_young(const NamedFiles& which, std::time_t since) {
    std::error_code error;
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(which.folder, error)) {
        const std::string name = entry.path().filename();
        if (name.rfind(which.beginning, 0) != 0) continue;
        struct stat state {};
        if (lstat(entry.path().c_str(), &state) != 0 || !S_ISREG(state.st_mode) || state.st_ctime < since)
            continue;
        if (which.ends_with_a_process && alive(std::atoi(name.c_str() + std::strlen(which.beginning))))
            continue;
        found.push_back(entry.path());
    }
    for (const auto& file : found) std::filesystem::remove(file, error);
}

void remove_if_unattached(int segment) {
    shmid_ds state{};
    if (shmctl(segment, IPC_STAT, &state) == 0 && state.shm_nattch == 0) shmctl(segment, IPC_RMID, nullptr);
}

// Of this user's dead programs: those of a killed LinuxCNC leave the memory that they talk over.
void remove_young_segments(std::time_t since) {
    std::vector<int> found;
    std::ifstream table("/proc/sysvipc/shm");
    std::string line;
    std::getline(table, line);  // the headings
    while (std::getline(table, line)) {
        std::istringstream words(line);
        long key = 0;
        int segment = 0;
        shmid_ds state{};
        if (words >> key >> segment && shmctl(segment, IPC_STAT, &state) == 0 &&
            state.shm_perm.uid == geteuid() && state.shm_ctime >= since && !alive(state.shm_cpid))
            found.push_back(segment);
    }
    for (const int segment : found) remove_if_unattached(segment);
}

}  // namespace

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
    std::strncpy(page_->folder, folder.c_str(), sizeof page_->folder - 1);
}

void Leftovers::set_placeholder(const std::string& file) {
    if (page_ == nullptr || file.size() >= sizeof page_->placeholder) return;
    std::strcpy(page_->placeholder, file.c_str());
}

void Leftovers::clear_away() const {
    if (page_ == nullptr) return;
    if (page_->placeholder[0] != '\0') Placeholder::remove(page_->placeholder);
    if (page_->folder[0] == '\0') return;
    unlink((std::string(page_->folder) + "/" + socket_name).c_str());
    rmdir(page_->folder);
}

void Leftovers::clear_machine() const {
    if (page_ == nullptr) return;
    for (int i = 0; i < page_->segments; ++i) remove_if_unattached(page_->segment[i]);
    remove_young_segments(page_->began);
    for (const NamedFiles& files : machine_files) remove_young(files, page_->began);
    if (const char* const home = std::getenv("HOME")) remove_young({home, ".tool.mmap", false}, page_->began);
}

Placeholder::Placeholder(const std::string& file) : file_(file), descriptor_(-1) {
    for (;;) {
        descriptor_ = open(file.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (!held() || flock(descriptor_, LOCK_SH) != 0) return;
        // Another host may have removed it since it was opened.
        struct stat state {};
        if (fstat(descriptor_, &state) == 0 && state.st_nlink > 0) return;
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
