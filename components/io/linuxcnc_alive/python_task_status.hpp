// SPDX-License-Identifier: GPL-2.0-or-later
// The status of LinuxCNC's task by its Python module: LinuxCNC 2.10 installs no declarations of its NML buffer.
#pragma once

#include "components/io/linuxcnc_alive/task_report.hpp"

#include <pybind11/embed.h>

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

namespace plumb {

class TaskStatus {
public:
    // An empty name is that of LinuxCNC's default.
    explicit TaskStatus(std::string nml_file) : file_(std::move(nml_file)) {}

    // The file with which LinuxCNC was started, or its default.
    static std::string usual_file() {
        const char* const given = std::getenv("NMLFILE");
        return given ? given : "";
    }

    // Nothing if there is no status yet; then it looks again after a second's worth of calls.
    std::optional<TaskReport> read() {
        if (calls_to_skip_ > 0) {
            --calls_to_skip_;
            return std::nullopt;
        }
        try {
            if (!status_) {
                linuxcnc_ = pybind11::module_::import("linuxcnc");
                if (!file_.empty()) linuxcnc_.attr("nmlfile") = file_;
                status_ = linuxcnc_.attr("stat")();
            }
            status_.attr("poll")();
            const bool runs = !status_.attr("interp_state").equal(linuxcnc_.attr("INTERP_IDLE"));
            return TaskReport{status_.attr("taskbeat").cast<std::uint64_t>(), runs,
                              runs && status_.attr("task_mode").equal(linuxcnc_.attr("MODE_AUTO"))};
        } catch (const pybind11::error_already_set&) {
            status_ = pybind11::object();
            calls_to_skip_ = 20;
            return std::nullopt;
        }
    }

private:
    const pybind11::scoped_interpreter python_{false};  // signals stay the program's
    const std::string file_;
    pybind11::object linuxcnc_, status_;
    int calls_to_skip_ = 0;
};

}  // namespace plumb
