// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/timeline.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "hal/host/background.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/motion_status.hpp"
#include "hal/host/names.hpp"
#include "hal/host/scheduler.hpp"
#include "hal/host/watchdog.hpp"

namespace plumb::host {

void Timeline::begin(Nanoseconds span) {
    // A net moves values to other cells, so all names are looked up again.
    if (watches()) {
        const Names names;
        if (replayer_) replayer_->resolve(names);
        for (const auto& [id, recorder] : recorders_) recorder->resolve(names);
        expectations_.resolve(names);
        models_.resolve(names);
    }
    began_ = scheduler().time();
    target_ = after(began_, span);
    if (target_ == never && span != never)
        throw std::runtime_error("virtual time ends 292 years after its beginning");
    if (replayer_ && target_ != never) target_ = std::min(target_, replayer_->end());
    ended_by_replay_ = false;
    running_ = true;
}

Nanoseconds Timeline::next_row() const {
    Nanoseconds next = never;
    for (const auto& [id, recorder] : recorders_) next = std::min(next, recorder->next_row());
    return next;
}

Nanoseconds Timeline::next_instant() const {
    return std::min({scheduler().next_release(), next_row(), target_});
}

bool Timeline::go_on(std::chrono::nanoseconds patience, Nanoseconds limit) {
    give_up_ = Clock::now() + patience;
    limit_ = limit;
    releases_ = 0;
    row_ = next_row();
    took_command_ = false;
    failure_ = nullptr;
    const Watchdog watchdog;
    if (turn_to_release())
        scheduler().run([](void* self) { return static_cast<Timeline*>(self)->turn(); }, this);
    if (failure_) std::rethrow_exception(failure_);
    return took_command_;
}

bool Timeline::turn() noexcept try {
    work_in_background();
    models_.move(scheduler().time());
    if (!expectations_.empty()) expectations_.check(scheduler().time());
    return end_instant() && turn_to_release();
} catch (...) {
    failure_ = std::current_exception();
    return false;
}

bool Timeline::turn_to_release() {
    constexpr int releases_between_looks = 64;  // a look at the real clock costs as much as a release
    Scheduler& tasks = scheduler();
    for (; running_; ++releases_) {
        if (releases_ == releases_between_looks) {
            if (Clock::now() >= give_up_) return false;
            releases_ = 0;
        }
        const Nanoseconds instant = std::min({tasks.next_release(), row_, target_});
        if (instant > limit_ || instant == never) return false;
        tasks.advance(instant);
        if (tasks.next_release() == instant) {
            if (replayer_) apply_replay(instant);
            ++releases_;
            return true;
        }
        if (!end_instant()) return false;
    }
    return false;
}

bool Timeline::end_instant() {
    const Nanoseconds instant = scheduler().time();
    if (row_ == instant) {
        try_to([&](Recorder& recorder) {
            if (recorder.next_row() == instant) recorder.write_row();
        });
        row_ = next_row();
    }
    if (instant == target_) finish();
    took_command_ = motion_took_command();
    return !took_command_;
}

void Timeline::apply_replay(Nanoseconds instant) {
    replayer_->apply(instant);
    if (target_ == never && instant >= replayer_->end()) replayer_.reset();
}

void Timeline::look_again() {
    const Names names;
    std::vector<std::string> lost;
    for (auto recorder = recorders_.begin(); recorder != recorders_.end();) {
        try {
            recorder->second->resolve(names);
            ++recorder;
        } catch (const std::runtime_error&) {
            const std::string id = (recorder++)->first;
            lost.push_back(id);
        }
    }
    for (const std::string& id : lost) end_recording(id);
    expectations_.drop_lost(names);
    models_.resolve(names);
    if (!replayer_) return;
    try {
        replayer_->resolve(names);
    } catch (const std::runtime_error&) {
        replayer_.reset();
    }
}

void Timeline::lose_names() {
    while (!recorders_.empty()) end_recording(std::string(recorders_.begin()->first));
    expectations_.lose_all();
    models_.lose_names();
    replayer_.reset();
}

void Timeline::stop() {
    if (running_) finish();
}

void Timeline::finish() {
    running_ = false;
    if (replayer_ && scheduler().time() >= replayer_->end()) {
        ended_by_replay_ = true;
        replayer_.reset();
    }
    try_to([](Recorder& recorder) { recorder.flush(); });
}

void Timeline::try_to(const std::function<void(Recorder&)>& write) {
    std::string failed;
    for (auto recorder = recorders_.begin(); recorder != recorders_.end();) {
        try {
            write(*recorder->second);
            ++recorder;
        } catch (const std::runtime_error& error) {
            failed = error.what();
            ended_recordings_[recorder->first] = failed;
            recorder = recorders_.erase(recorder);
        }
    }
    if (failed.empty()) return;
    if (target_ == never) return print_message("plumb-host: " + failed + ": the recording ends here\n", true);
    if (running_) finish();
    throw std::runtime_error(failed);
}

void Timeline::end_recording(const std::string& id) {
    std::string failed;
    try {
        recorders_.at(id)->flush();
    } catch (const std::runtime_error& error) {
        failed = error.what();
    }
    recorders_.erase(id);
    ended_recordings_[id] = failed;
}

Nanoseconds Timeline::ran() const {
    return scheduler().time() - began_;
}

void Timeline::record(const std::string& id, std::unique_ptr<Recorder> recorder) {
    ended_recordings_.erase(id);
    recorders_[id] = std::move(recorder);
}

void Timeline::stop_recording(const std::string& id) {
    if (recorders_.count(id) > 0) end_recording(id);
    const auto ended = ended_recordings_.find(id);
    if (ended == ended_recordings_.end()) throw std::runtime_error("there is no recording '" + id + "'");
    const std::string failed = ended->second;
    ended_recordings_.erase(ended);
    if (!failed.empty()) throw std::runtime_error(failed);
}

}  // namespace plumb::host
