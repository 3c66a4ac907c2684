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
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "hal/socket_folder.hpp"

namespace plumb::host {

namespace {

bool begins_with(const std::string& text, const char* beginning) {
    return text.rfind(beginning, 0) == 0;
}

bool alive(int process) {
    return process > 0 && (kill(process, 0) == 0 || errno != ESRCH);
}

constexpr const char* faketimes_memory[] = {"faketime_shm_", "sem.faketime_sem_"};

bool is_faketimes(const std::string& name) {
    return begins_with(name, faketimes_memory[0]) || begins_with(name, faketimes_memory[1]);
}

// libfaketime's memory is named for the process that makes it, which does not remove it when it ends. A host that clears
// its own is at its end.
bool is_of_live_program(const std::string& name) {
    for (const char* const beginning : faketimes_memory) {
        if (!begins_with(name, beginning)) continue;
        const int maker = std::atoi(name.c_str() + std::strlen(beginning));
        return maker != getpid() && alive(maker);
    }
    return false;
}

bool is_tool_table(const std::string& name) {
    return name == ".tool.mmap";
}

// A file by what its file system knows it by: place, and the moment at which it was made. The moment is
// compared with itself alone, so a clock that was set meanwhile does no harm; a place is given again to a
// later file.
using FileIdentity = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t, std::int64_t, std::uint32_t>;

struct FoundFile {
    std::filesystem::path path;
    FileIdentity identity;
};

// This user's files that belong to LinuxCNC and libfaketime.
std::vector<FoundFile> files_of_programs() {
    std::vector<FoundFile> found;
    const auto look = [&found](const char* folder, bool (*belongs)(const std::string& name)) {
        std::error_code error;
        for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
            struct statx state {};
            if (!belongs(entry.path().filename()) ||
                statx(AT_FDCWD, entry.path().c_str(), AT_SYMLINK_NOFOLLOW, STATX_BASIC_STATS | STATX_BTIME,
                      &state) != 0 ||
                !S_ISREG(state.stx_mode) || state.stx_uid != geteuid())
                continue;
            found.push_back({entry.path(),
                             {state.stx_dev_major, state.stx_dev_minor, state.stx_ino, state.stx_btime.tv_sec,
                              state.stx_btime.tv_nsec}});
        }
    };
    look("/tmp", is_linuxcncs_in_tmp);
    look("/dev/shm", is_faketimes);
    if (const char* const home = std::getenv("HOME")) look(home, is_tool_table);
    return found;
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

// Calls visit(key, segment) for all shared memory of this computer.
template <class Visit>
void for_each_segment(const Visit& visit) {
    std::ifstream table("/proc/sysvipc/shm");
    std::string line;
    std::getline(table, line);  // the headings
    while (std::getline(table, line)) {
        std::istringstream words(line);
        unsigned long key = 0;
        int segment = 0;
        if (words >> key >> segment) visit(key & 0xffffffff, segment);
    }
}

// Shared memory of this user's dead programs: a killed LinuxCNC leaves it behind.
std::vector<int> segments_of_dead_programs() {
    std::vector<int> found;
    for_each_segment([&found](unsigned long key, int segment) {
        shmid_ds state{};
        if (is_linuxcncs_key(key) && shmctl(segment, IPC_STAT, &state) == 0 &&
            state.shm_perm.uid == geteuid() && !alive(state.shm_cpid))
            found.push_back(segment);
    });
    return found;
}

}  // namespace

bool is_twopass_file(const std::string& name) {
    const std::string end = name.size() < 8 ? "" : name.substr(name.size() - 4);
    return begins_with(name, "tmp_") && (end == ".hal" || end == ".tcl");
}

bool is_linuxcncs_in_tmp(const std::string& name) {
    return name == linuxcnc_lock_file || is_twopass_file(name) || begins_with(name, "linuxcnc.debug.") ||
           begins_with(name, "linuxcnc.print.");
}

struct Leftovers::Page {
    static constexpr int most_segments = 512;
    std::atomic<int> segments;
    int segment[most_segments];
    char folder[256];
    char placeholder[512];
};

struct Leftovers::Before {
    std::set<FileIdentity> files;
    std::set<int> segments;  // whose numbers the kernel does not soon give again
};

Leftovers& leftovers() {
    static Leftovers the_leftovers;
    return the_leftovers;
}

void Leftovers::share() {
    void* memory = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to share with the host");
    page_ = static_cast<Page*>(memory);
    auto before = std::make_shared<Before>();
    for (const FoundFile& file : files_of_programs()) before->files.insert(file.identity);
    for_each_segment([&before](unsigned long, int segment) { before->segments.insert(segment); });
    before_ = before;
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
    for (const int segment : segments_of_dead_programs())
        if (before_->segments.count(segment) == 0) remove_if_unattached(segment);
    std::error_code error;
    for (const FoundFile& file : files_of_programs())
        if (before_->files.count(file.identity) == 0 && !is_of_live_program(file.path.filename()))
            std::filesystem::remove(file.path, error);
}

void Leftovers::clear_memory_of_the_dead() {
    for (const int segment : segments_of_dead_programs()) remove_if_unattached(segment);
    std::error_code error;
    for (const FoundFile& file : files_of_programs()) {
        const std::string name = file.path.filename();
        if (is_faketimes(name) && !is_of_live_program(name)) std::filesystem::remove(file.path, error);
    }
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
