// SPDX-License-Identifier: GPL-2.0-or-later
// The status of LinuxCNC's task by its Python module: LinuxCNC 2.10 installs no declarations of its NML
// buffer.
#pragma once

#include "components/io/linuxcnc_alive/task_report.hpp"

#include <pybind11/embed.h>

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

namespace plumb {

// The module linuxcnc and its object stat; hidden, as the types of pybind11 are.
struct __attribute__((visibility("hidden"))) PythonStatus {
    PythonStatus() { pybind11::initialize_interpreter(false); }  // signals stay the program's

    // Throws pybind11::error_already_set if there is no status yet.
    TaskReport read(const std::string& nml_file) {
        if (!status) {
            linuxcnc = pybind11::module_::import("linuxcnc");
            if (!nml_file.empty()) linuxcnc.attr("nmlfile") = nml_file;
            status = linuxcnc.attr("stat")();
        }
        status.attr("poll")();
        const bool runs = !status.attr("interp_state").equal(linuxcnc.attr("INTERP_IDLE"));
        return TaskReport{status.attr("taskbeat").cast<std::uint64_t>(), runs,
                          runs && status.attr("task_mode").equal(linuxcnc.attr("MODE_AUTO"))};
    }

    pybind11::object linuxcnc, status;
};

class TaskStatus {
public:
    // An empty name is LinuxCNC's default.
    explicit TaskStatus(std::string nml_file) : file_(std::move(nml_file)) {}

    // The file with which LinuxCNC was started, or its default.
    static std::string usual_file() {
        const char* const given = std::getenv("NMLFILE");
        return given ? given : "";
    }

    // Nothing if there is no status yet; then it looks again after a second's worth of calls. All calls come
    // from one thread.
    std::optional<TaskReport> read() {
        // Stays until the process ends: another thread may end it, which Python does not allow.
        static auto* const python = new PythonStatus;
        if (calls_to_skip_ > 0) {
            --calls_to_skip_;
            return std::nullopt;
        }
        try {
            return python->read(file_);
        } catch (const pybind11::error_already_set&) {
            python->status = pybind11::object();
            calls_to_skip_ = 20;
            return std::nullopt;
        }
    }

private:
    const std::string file_;
    int calls_to_skip_ = 0;
};

}  // namespace plumb
