// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb::growth_test {

enum class State : std::int32_t { idle, probing_cold, warming, probing, stopped, interrupted };

constexpr const char* sentence(State state) {
    switch (state) {
        case State::probing_cold: return "The first pass runs; it is the reference.";
        case State::warming: return "The machine warms between two passes.";
        case State::probing: return "A pass runs.";
        case State::stopped: return "The test has ended; stop-reason gives the reason.";
        case State::interrupted: return "A test is not complete; it can be resumed.";
        default: return nullptr;
    }
}

enum class Stop : std::int32_t { none, stable, maximum_time };

constexpr const char* sentence(Stop stop) {
    switch (stop) {
        case Stop::stable: return "The machine is warm by the rules.";
        case Stop::maximum_time: return "The maximum time is over.";
        default: return nullptr;
    }
}

enum class Fault : std::int32_t {
    none,
    position,
    sensor,
    settings,
    probe_miss,
    overtravel,
    false_trigger,
    orientation,
    unconfirmed,
    no_reference,
    artifact_temperature,
    no_warm_up,
    not_stable,
    full,
    bore,
    standstill,
    displaced,
    slipped,
};

constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::position: return "A position, an offset or a velocity is invalid.";
        case Fault::sensor: return "A temperature is invalid, not valid by its sensor, or too old.";
        case Fault::settings: return "The settings are out of range; the last good ones are used.";
        case Fault::probe_miss: return "The probe did not touch; probe the bore again.";
        case Fault::overtravel: return "The probe reports overtravel.";
        case Fault::false_trigger:
            return "A touch is off the circle of the others, or the bore has another shape than in its first "
                   "visit; "
                   "probe it again.";
        case Fault::orientation: return "The table is not at the orientation that the program names.";
        case Fault::unconfirmed: return "The control did not confirm the state of compensation or cooling.";
        case Fault::no_reference: return "This bore has no position in the first pass.";
        case Fault::artifact_temperature: return "The temperature of the artifact is out of its limits.";
        case Fault::no_warm_up: return "The machine did not warm: no temperature rose.";
        case Fault::not_stable: return "The maximum time is over, and the machine is not stable.";
        case Fault::full: return "There is no room for further records.";
        case Fault::bore: return "The number of the bore is not one of 1 to 16.";
        case Fault::displaced:
            return "A bore is not where its last visit found it: the artifact has slipped, or the program "
                   "gives the "
                   "number of another bore. fault-bore has its number.";
        case Fault::slipped:
            return "All bores moved at once, which no growth does: the artifact has slipped, or the probe "
                   "has changed. "
                   "Clamp the artifact, and begin a new test.";
        case Fault::standstill:
            return "The pass takes longer than max-pass-time: the machine cools meanwhile. Probe fewer "
                   "bores.";
        default: return nullptr;
    }
}

enum class Advice : std::int32_t { none, threshold, one_rule };

constexpr const char* sentence(Advice advice) {
    switch (advice) {
        case Advice::threshold: return "The threshold is outside 0.5 to 5 K, the range of the method.";
        case Advice::one_rule:
            return "The temperatures alone decide: they can stand long before the machine does.";
        default: return nullptr;
    }
}

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
inline Status status_of(const Seen& seen) noexcept {
    const bool service = hal::is_of_service(static_cast<std::int32_t>(seen.interlock));
    const bool interrupted = seen.state == State::interrupted;
    return hal::first<Status>({{seen.running && seen.program_gone, Status::program_lost},
                               {seen.fault, hal::common<Status>(hal::Common::fault)},
                               {service, seen.interlock},
                               {seen.stop == Stop::stable, Status::warm},
                               {seen.stop != Stop::none, Status::time_over},
                               {interrupted && seen.resumable, Status::resumable},
                               {interrupted, Status::interrupted},
                               {seen.state == State::idle, Status::idle},
                               {seen.paused, Status::paused},
                               {true, Status::runs}});
}

}  // namespace plumb::growth_test
