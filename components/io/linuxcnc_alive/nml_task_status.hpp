// SPDX-License-Identifier: GPL-2.0-or-later
// The status of LinuxCNC's task by its NML buffer, whose declarations LinuxCNC 2.9 installs.
#pragma once

#include "components/io/linuxcnc_alive/task_report.hpp"

#include <emccfg.h>
#include <emc_nml.hh>
#include <rcs_print.hh>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>

extern int emcFormat(NMLTYPE type, void* buffer, CMS* cms);

namespace plumb {

class TaskStatus {
public:
    explicit TaskStatus(std::string nml_file) : file_(std::move(nml_file)) {
        set_rcs_print_destination(RCS_PRINT_TO_NULL);  // until LinuxCNC has started there is no status
    }

    // The file with which LinuxCNC was started, or its default.
    static std::string usual_file() {
        const char* const given = std::getenv("NMLFILE");
        return given && *given ? given : DEFAULT_EMC_NMLFILE;
    }

    // Nothing if task has written no status since the last call, or it cannot be read. Waits for 10 s if
    // another program was stopped or killed while it held the lock of the status.
    std::optional<TaskReport> read() {
        if (!channel_)
            channel_ = std::make_unique<RCS_STAT_CHANNEL>(emcFormat, "emcStatus", "xemc", file_.c_str());
        const NMLTYPE type = channel_->valid() ? channel_->peek() : -1;
        if (type < 0) channel_.reset();
        if (type != EMC_STAT_TYPE) return std::nullopt;
        const auto& status = *static_cast<const EMC_STAT*>(channel_->get_address());
        if (status.size != sizeof(EMC_STAT)) return std::nullopt;  // of another version of LinuxCNC
        const bool runs = status.task.interpState != EMC_TASK_INTERP_IDLE;
        return TaskReport{status.task.heartbeat, runs, runs && status.task.mode == EMC_TASK_MODE_AUTO};
    }

private:
    const std::string file_;
    std::unique_ptr<RCS_STAT_CHANNEL> channel_;
};

}  // namespace plumb
