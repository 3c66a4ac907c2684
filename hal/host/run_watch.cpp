// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/run_watch.hpp"

#include "hal/linuxcnc_series.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>

#include "hal/host/programs.hpp"

namespace plumb::host {

namespace {

constexpr auto between_looks = std::chrono::milliseconds(500);
constexpr auto patience = std::chrono::seconds(5);

// Whether a process has modules loaded. A messenger of halcmd to this host has none. An ordinary user
// cannot see the modules of a set-uid program, except in namespaces, where it has no more rights than he.
bool serves_hal(pid_t process) {
    std::ifstream maps("/proc/" + std::to_string(process) + "/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.find("/hal_lib.so") != std::string::npos) return true;
    return false;
}

// The page faults of these processes and of their children that have ended: a linuxcnc that cleans up starts
// one program after the other, however slow the computer is; one that waits does nothing.
std::uint64_t work_of(const std::vector<pid_t>& processes) {
    std::uint64_t sum = 0;
    for (const pid_t process : processes) {
        std::ifstream file("/proc/" + std::to_string(process) + "/stat");
        std::string state;
        std::getline(file, state, ')');  // its number, and its name, which has none
        std::int64_t parent, group, session, terminal, owner, flags;
        std::uint64_t own = 0, of_children = 0;
        if (file >> state >> parent >> group >> session >> terminal >> owner >> flags >> own >> of_children)
            sum += own + of_children;
    }
    return sum;
}

}  // namespace

std::optional<std::string> realtime_beside(const Programs& programs) {
    const std::vector<pid_t> found = programs.called("rtapi_app");
    if (std::none_of(found.begin(), found.end(), serves_hal)) return std::nullopt;
    return std::string(
               "halcmd has started a realtime of LinuxCNC's own (rtapi_app) instead of using the "
               "virtual-time host: "
               "it does not look for the host at RTAPI_FIFO_PATH. The host was built for LinuxCNC ") +
           hal::linuxcnc_series + "; 'plumb doctor' shows which one is installed";
}

std::optional<std::string> RunWatch::look(const Programs& programs, bool own_hal) {
    const auto now = Clock::now();
    if (now - last_look_ < between_looks) return std::nullopt;
    last_look_ = now;
    if (!own_hal)
        if (auto why = realtime_beside(programs)) return why;
    return look_for_task(programs);
}

std::optional<std::string> RunWatch::look_for_task(const Programs& programs) {
    const bool task = !programs.called("milltask").empty();
    if (task_ && !task) {
        scripts_ = programs.called("linuxcnc");
        idle_since_ = last_look_;
    }
    task_ = task;
    if (task) scripts_.clear();
    if (scripts_.empty()) return std::nullopt;
    const std::uint64_t work = work_of(scripts_);
    if (work != work_then_) idle_since_ = last_look_;
    work_then_ = work;
    if (last_look_ - idle_since_ < patience) return std::nullopt;
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
