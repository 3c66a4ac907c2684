// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/leftovers.hpp"

#include <sys/mman.h>
#include <sys/shm.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <stdexcept>

namespace plumb::host {

struct Leftovers::Page {
    static constexpr int most_segments = 512;
    std::atomic<int> segments;
    int segment[most_segments];
    char folder[256];
    static constexpr int most_files = 4;
    std::atomic<int> files;
    char file[most_files][256];
};

Leftovers& leftovers() {
    static Leftovers the_leftovers;
    return the_leftovers;
}

void Leftovers::share() {
    void* memory = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to share with the host");
    page_ = static_cast<Page*>(memory);
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

void Leftovers::add_file(const std::string& path) {
    if (page_ == nullptr || page_->files == Page::most_files) return;
    std::strncpy(page_->file[page_->files], path.c_str(), sizeof page_->file[0] - 1);
    ++page_->files;
}

void Leftovers::clear_away(bool segments) {
    if (page_ == nullptr) return;
    for (int i = 0; i < page_->files; ++i) unlink(page_->file[i]);
    for (int i = 0; segments && i < page_->segments; ++i) {
        shmid_ds state{};
        if (shmctl(page_->segment[i], IPC_STAT, &state) == 0 && state.shm_nattch == 0)
            shmctl(page_->segment[i], IPC_RMID, nullptr);
    }
    if (page_->folder[0] == '\0') return;
    unlink((std::string(page_->folder) + "/" + socket_name).c_str());
    rmdir(page_->folder);
}

}  // namespace plumb::host
