// SPDX-License-Identifier: GPL-2.0-or-later
// Moves virtual time on: at each release it applies the replayed data, runs the tasks, lets modules do their
// background work, checks the expectations and writes the recordings, in this order.
#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "hal/host/expectations.hpp"
#include "hal/host/models.hpp"
#include "hal/host/recorder.hpp"
#include "hal/host/replayer.hpp"
#include "hal/host/time.hpp"

namespace plumb::host {

class Timeline {
public:
    explicit Timeline(Models& models) : models_(models) {}

    // Begins a run of `span`; go_on() does the work. Throws std::runtime_error when a recorded, replayed or
    // expected name is no longer there, or has become something else.
    void begin(Nanoseconds span);

    // Goes on with the run for `patience` of real time, to the instant `limit`, or until it ends. A recording
    // that cannot be written ends; then the run ends as well, and std::runtime_error is thrown, unless it has
    // no end: then stop_recording() throws it. Returns early, and true, when motion has taken a command.
    bool go_on(std::chrono::nanoseconds patience, Nanoseconds limit = never);

    // The next instant at which go_on() has something to do, or `never`.
    Nanoseconds next_instant() const;

    // Looks all names up again, in a run without end, in which other programs may net and unload anything.
    // A recording or expectation that has lost a name ends: the recording is complete, the expectation is
    // checked no more.
    void look_again();

    // Ends everything that has a name: HAL's memory is gone.
    void lose_names();

    // Ends the run at the period that it has reached.
    void stop();

    bool running() const { return running_; }

    // How far the last run has come.
    Nanoseconds ran() const;

    // Whether the last run ended because a replay came to the end of its data.
    bool ended_by_replay() const { return ended_by_replay_; }

    // Adds or replaces the recording with this id.
    void record(const std::string& id, std::unique_ptr<Recorder> recorder);

    // Ends a recording. Throws std::runtime_error when there was none, or it could not be written.
    void stop_recording(const std::string& id);

    // Begins a replay in place of the one that is there.
    void replay(std::unique_ptr<Replayer> replayer) { replayer_ = std::move(replayer); }

    // Whether names are recorded, checked, replayed or read by models.
    bool watches() const {
        return replayer_ || !recorders_.empty() || !expectations_.empty() || models_.watches();
    }

    Expectations& expectations() { return expectations_; }

private:
    using Clock = std::chrono::steady_clock;

    bool turn() noexcept;    // from the end of a period to the next release: whether it goes on
    bool turn_to_release();  // past the instants that are no release
    bool end_instant();      // whether it goes on
    void finish();
    void try_to(const std::function<void(Recorder&)>& write);
    void end_recording(const std::string& id);
    void apply_replay(Nanoseconds instant);
    Nanoseconds next_row() const;

    bool running_ = false;
    bool ended_by_replay_ = false;
    Nanoseconds began_ = 0;
    Nanoseconds target_ = 0;
    // Of go_on():
    Clock::time_point give_up_;
    Nanoseconds limit_ = never;
    int releases_ = 0;
    Nanoseconds row_ = never;
    bool took_command_ = false;
    std::exception_ptr failure_;

    std::map<std::string, std::unique_ptr<Recorder>> recorders_;
    std::map<std::string, std::string>
        ended_recordings_;  // before they were stopped, and why they are not complete
    std::unique_ptr<Replayer> replayer_;
    Expectations expectations_;
    Models& models_;
};

}  // namespace plumb::host
