// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb::growth_test {

enum class Status : std::int32_t {
    runs = hal::first_own,
    paused,
    program_lost,
    warm,
    time_over,
    resumable,
    interrupted,
    idle
};

constexpr hal::Said said(Status status) {
    using hal::Kind;
    using hal::Tell;
    switch (status) {
        case Status::runs: return {Kind::good, "The test runs.", "", {}, "state-code"};
        case Status::paused:
            return {Kind::warn, "The program is paused: the machine cools.", "Resume the program."};
        case Status::program_lost:
            return {Kind::bad, "The program of the test has ended without its end: nothing is probed.",
                    "Start LinuxCNC again, then resume.ngc."};
        case Status::warm:
            return hal::Said{Kind::good, "The test has ended: the machine is warm.",
                             "The pass that follows is the last warm one. Look at its report.",
                             hal::Button::report}
                .told(Tell::behind_panel);
        case Status::time_over:
            return hal::Said{Kind::warn,
                             "The test has ended at its maximum time: the machine is not warm by the rules.",
                             "Look at its report.", hal::Button::report}
                .told(Tell::behind_panel);
        case Status::resumable:
            return {Kind::warn, "The test was interrupted.", "Start resume.ngc to go on.",
                    hal::Button::resume};
        case Status::interrupted:
            return {Kind::warn, "The test was interrupted. resume.ngc is refused before a restart.",
                    "Start LinuxCNC again, then resume.ngc."};
        case Status::idle:
            return {Kind::off, "No test runs.", "Start the program of the test.", hal::Button::start};
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

// The status of a test by its log. A log without an end does not say whether its test runs or was
// interrupted.
constexpr hal::Said said_of_log(Stop stop) {
    switch (stop) {
        case Stop::stable: return said(Status::warm);
        case Stop::maximum_time: return said(Status::time_over);
        default:
            return {hal::Kind::wait, "The test has not reached its end.",
                    "If its program does not run any more, start LinuxCNC again, then resume.ngc."};
    }
}

struct Seen {
    State state = State::idle;
    Stop stop = Stop::none;
    bool running = false;  // by the program of the test
    bool fault = false, program_gone = false, paused = false, resumable = false;
    Status interlock{};
};

// The test moves nothing, and runs whether interlock permits it or not: only a lost service counts.
inline Status status_of(const Seen& its) noexcept {
    const bool service = hal::is_of_service(static_cast<std::int32_t>(its.interlock));
    const bool interrupted = its.state == State::interrupted;
    return hal::first<Status>({{its.running && its.program_gone, Status::program_lost},
                               {its.fault, hal::common<Status>(hal::Common::fault)},
                               {service, its.interlock},
                               {its.stop == Stop::stable, Status::warm},
                               {its.stop != Stop::none, Status::time_over},
                               {interrupted && its.resumable, Status::resumable},
                               {interrupted, Status::interrupted},
                               {its.state == State::idle, Status::idle},
                               {its.paused, Status::paused},
                               {true, Status::runs}});
}

}  // namespace plumb::growth_test
