// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/linuxcnc_alive/beat.hpp"
#include "components/io/linuxcnc_alive/io_process.hpp"
#include "components/io/linuxcnc_alive/process_wakes.hpp"
#include "components/io/linuxcnc_alive/task_status.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace plumb {

struct LinuxcncAlive final : hal::Component {
    static constexpr hal::About about{
        "linuxcnc_alive",
        "shows interlock whether LinuxCNC's task and io live",
        R"(
linuxcnc_alive has a heartbeat for LinuxCNC's task and one for its io. A heartbeat stands still if the program was killed or
stopped, or hangs. interlock(9) then lets strokes end and holds the feed. Without it a stroke goes on after the death of task,
and neither Stop nor the emergency stop of LinuxCNC reaches it.)",
        hal::Wiring{R"(
Task is service 4 of interlock, io is service 5.

  loadusr -W linuxcnc_alive

  setp interlock.service-timeout-4  2.5
  setp interlock.service-timeout-5  2.5
  setp interlock.feed-services     48

  net task-beat  linuxcnc-alive.task-heartbeat => interlock.service-heartbeat-4
  net io-beat    linuxcnc-alive.io-heartbeat   => interlock.service-heartbeat-5
  net program    linuxcnc-alive.program-running => interlock.program-running

LinuxCNC starts task after the HAL files. The heartbeat of task begins then.)"},
        hal::SettingUp{R"(
1. Load your longest program, and run the remaps and subroutines in Python that you have, with a busy computer.
2. Read the longest pauses: halcmd show pin 'linuxcnc-alive.longest*'.
3. Set service-timeout-4 and service-timeout-5 of interlock to three times the longest pause, and to 2.5 s at least.
4. Try it with the axes clear and nothing in the machine: end task by kill -9, and watch interlock.feed-inhibit.)"},
        hal::Behaviour{R"(
- Start before LinuxCNC's task: task-heartbeat waits.
- Task: It counts the cycles of its main loop in LinuxCNC's status. The heartbeat changes with this count.
- io: The heartbeat changes with the number of times that io has slept, as the kernel counts it. LinuxCNC 2.9's own counter
of io changes only when io has work. In LinuxCNC 2.10 io is a part of task, and this is the sleep of task.
- kill -9, SIGSTOP, a debugger, a loop without end: The heartbeat stands still. It goes on with the program.
- Task dies: program-running keeps its value. A program that was cut off counts as running.
- A Python remap, or a file of Python, that does not return to task: The heartbeat stands still meanwhile. A remap that waits
has to yield, as LinuxCNC's documents say.
- linuxcnc_alive dies or is stopped: Both heartbeats stand still.
- Another program is stopped while it holds the lock of LinuxCNC's status: task cannot write its status, and its heartbeat
stands still.

--period is the time between two looks. It adds to the time in which a loss is seen; 0.1 s is the longest.)"},
        hal::Limits{R"(
A task that lives and ignores the operator is not noticed.

An [EMCIO]EMCIO that is not LinuxCNC's io or iov2 needs a component iocontrol in HAL and a loop that sleeps.)"},
        hal::SeeAlso{"interlock(9), chopping(9), linuxcnc_link(1), linuxcnc(1)"}};

    static constexpr hal::Role role = hal::Role::program;
    using Component::Component;

    hal::Out<bool> task_heartbeat{this, "task-heartbeat", "Changes as long as task's main loop runs."};
    hal::Out<bool> io_heartbeat{this, "io-heartbeat", "Changes as long as the loop of io runs."};
    hal::Out<bool> program_running{this, "program-running",
                                   "A program or an MDI command runs or is paused, for interlock."};
    hal::Out<bool> part_program_running{
        this, "part-program-running", "A part program runs or is paused, not an MDI command; for chopping."};
    hal::Out<double> longest_task_pause{this, "longest-task-pause", "s",
                                        "Longest time between two cycles of task since its first one."};
    hal::Out<double> longest_io_pause{this, "longest-io-pause", "s",
                                      "Longest time between two cycles of io since its first one."};
    hal::Option<std::string> nml{
        this, "nml", "", "LinuxCNC's NML file, absolute path; by default that of the running LinuxCNC."};

    void prepare() override {
        const std::string& given = hal::absolute_path("nml", nml);
        status_ = std::make_unique<TaskStatus>(given.empty() ? TaskStatus::usual_file() : given);
    }

    void background() override {
        const double now = seconds();
        if (const auto report = status_->read()) {
            cycles_ = report->cycles;
            program_running = report->program_runs;
            part_program_running = report->part_program_runs;
        }
        if (!io_) look_for_io(now);
        task_.see(cycles_, now);
        io_beat_.see(io_ ? io_->count() : std::nullopt, now);
        task_heartbeat = task_.bit();
        io_heartbeat = io_beat_.bit();
        longest_task_pause = task_.longest_pause();
        longest_io_pause = io_beat_.longest_pause();
    }

private:
    static double seconds() {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }

    // io is there before the HAL files are read. A process that takes its place later is not looked for: HAL
    // keeps the number of one that was killed.
    void look_for_io(double now) {
        if (now < look_again_) return;
        look_again_ = now + 1;
        if (const auto process = find_io_process())
            io_ = std::make_unique<ProcessWakes>(*process);
        else if (++looks_ == 10)
            hal::report_error(
                "HAL has no component iocontrol, which is LinuxCNC's io; io-heartbeat stands still");
    }

    std::unique_ptr<TaskStatus> status_;
    std::unique_ptr<ProcessWakes> io_;
    std::optional<std::uint64_t> cycles_;
    Beat task_, io_beat_;
    double look_again_ = 0;
    int looks_ = 0;
};

hal::Model hal::model() {
    Model its = model_of<LinuxcncAlive>();
    its.period = 0.05;
    return its;
}

}  // namespace plumb
