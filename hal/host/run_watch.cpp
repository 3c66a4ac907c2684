// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/run_watch.hpp"

#include <sys/shm.h>

#include <algorithm>

#include "hal/host/programs.hpp"
#include "hal/host/shared_memory.hpp"

namespace plumb::host {

namespace {

constexpr auto between_looks = std::chrono::milliseconds(500);
constexpr auto patience = std::chrono::seconds(5);  // the clean-up of linuxcnc unloads modules long before

// Whether a process has HAL's memory attached.
bool hal_is_in_use() {
    const int segment = shmget(hal_memory_key, 0, 0);
    shmid_ds state{};
    return segment >= 0 && shmctl(segment, IPC_STAT, &state) == 0 && state.shm_nattch > 0;
}

}  // namespace

std::optional<std::string> realtime_beside(const Programs& programs) {
    // One without HAL's memory is halcmd's messenger to this host.
    if (!hal_is_in_use() || programs.called("rtapi_app").empty()) return std::nullopt;
    return "halcmd has started a realtime of LinuxCNC's own (rtapi_app) instead of using the virtual-time "
           "host: it "
           "does not look for the host at RTAPI_FIFO_PATH, as halcmd of LinuxCNC 2.9 does. The host works "
           "with LinuxCNC "
           "2.9; 'plumb doctor' says which one is installed";
}

std::optional<std::string> RunWatch::look(const Programs& programs, bool own_hal, unsigned long changes) {
    const auto now = Clock::now();
    if (now - last_look_ < between_looks) return std::nullopt;
    last_look_ = now;
    if (auto why = look_for_realtime(programs, own_hal)) return why;
    return look_for_task(programs, changes);
}

std::optional<std::string> RunWatch::look_for_realtime(const Programs& programs, bool own_hal) {
    const auto beside = own_hal ? std::nullopt : realtime_beside(programs);
    looks_with_realtime_ = beside ? looks_with_realtime_ + 1 : 0;
    return looks_with_realtime_ > 1 ? beside : std::nullopt;
}

std::optional<std::string> RunWatch::look_for_task(const Programs& programs, unsigned long changes) {
    const bool task = !programs.called("milltask").empty();
    if (task_ && !task) {
        scripts_ = programs.called("linuxcnc");
        task_gone_ = last_look_;
        changes_then_ = changes;
    }
    task_ = task;
    // A linuxcnc that ends unloads its modules next.
    if (task || changes != changes_then_) scripts_.clear();
    if (scripts_.empty() || last_look_ - task_gone_ < patience) return std::nullopt;
    const std::vector<pid_t> alive = programs.called("linuxcnc");
    if (std::find_first_of(alive.begin(), alive.end(), scripts_.begin(), scripts_.end()) == alive.end()) {
        scripts_.clear();
        return std::nullopt;
    }
    return "milltask has ended, and linuxcnc waits without it. A LinuxCNC that starts or ends outside the "
           "run sends "
           "SIGTERM to every milltask on the computer (pidof -x milltask), also to a run's: start and end "
           "none "
           "meanwhile";
}

}  // namespace plumb::host
