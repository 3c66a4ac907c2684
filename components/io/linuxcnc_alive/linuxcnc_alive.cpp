// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/linuxcnc_alive/beat.hpp"
#include "components/io/linuxcnc_alive/io_process.hpp"
#include "components/io/linuxcnc_alive/process_wakes.hpp"
#include "components/io/linuxcnc_alive/task_status.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"
#include "hal/program_state.hpp"
#include "pages/linuxcnc_alive.page.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace plumb {

struct LinuxcncAlive final : hal::Component {
    static constexpr hal::About about{"linuxcnc_alive", "shows interlock whether LinuxCNC's task and io live",
                                      page};

    static constexpr hal::Role role = hal::Role::program;
    using Component::Component;

    hal::ProgramState task_state{this, hal::Service::task, "task-"};
    hal::ProgramState io_state{this, hal::Service::io, "io-"};
    hal::Out<bool> program_running{this, "program-running",
                                   "A program or an MDI command runs or is paused, for interlock."};
    hal::Out<bool> part_program_running{
        this, "part-program-running", "A part program runs or is paused, not an MDI command; for chopping."};
    hal::Out<double> longest_task_pause{this, "longest-task-pause", "s",
                                        "Longest time between two cycles of task since its first one."};
    hal::Out<double> longest_io_pause{this, "longest-io-pause", "s",
                                      "Longest time between two cycles of io since its first one."};
    hal::Option<std::string> nml{
        this, "nml", "", "LinuxCNC's NML file, absolute path; by default the file of the running LinuxCNC."};

    void prepare() override {
        const std::string given = hal::absolute_path("nml", nml);
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
        task_state.report(task_.see(cycles_, now), {});
        io_state.report(io_beat_.see(io_ ? io_->count() : std::nullopt, now), {});
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
