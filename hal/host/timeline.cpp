// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/timeline.hpp"

#include <algorithm>
#include <stdexcept>

#include "hal/host/background.hpp"
#include "hal/host/names.hpp"
#include "hal/host/scheduler.hpp"

namespace plumb::host {

void Timeline::begin(Nanoseconds span) {
    // A net moves values to other cells, so all names are looked up again.
    if (replayer_ || !recorders_.empty() || !expectations_.empty()) {
        const Names names;
        if (replayer_) replayer_->resolve(names);
        for (const auto& [id, recorder] : recorders_) recorder->resolve(names);
        expectations_.resolve(names);
    }
    began_ = scheduler().time();
    target_ = began_ + span;
    if (replayer_) target_ = std::min(target_, replayer_->end());
    ended_by_replay_ = false;
    running_ = true;
}

Nanoseconds Timeline::next_row() const {
    Nanoseconds next = never;
    for (const auto& [id, recorder] : recorders_) next = std::min(next, recorder->next_row());
    return next;
}

void Timeline::go_on(std::chrono::nanoseconds patience) {
    using Clock = std::chrono::steady_clock;
    constexpr int releases_between_looks = 64;  // a look at the real clock costs as much as a release
    const auto give_up = Clock::now() + patience;
    Scheduler& tasks = scheduler();
    const bool expecting = !expectations_.empty();
    Nanoseconds row = next_row();
    for (int releases = 0; running_; ++releases) {
        if (releases == releases_between_looks) {
            if (Clock::now() >= give_up) return;
            releases = 0;
        }
        const Nanoseconds instant = std::min({tasks.next_release(), row, target_});
        tasks.advance(instant);
        if (tasks.next_release() == instant) {
            if (replayer_) replayer_->apply(instant);
            tasks.run_due();
            work_in_background();
            if (expecting) expectations_.check(instant);
        }
        if (row == instant) {
            for (const auto& [id, recorder] : recorders_)
                if (recorder->next_row() == instant) recorder->write_row();
            row = next_row();
        }
        if (instant == target_) finish();
    }
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
    for (const auto& [id, recorder] : recorders_) recorder->flush();
}

Nanoseconds Timeline::ran() const {
    return scheduler().time() - began_;
}

void Timeline::record(const std::string& id, std::unique_ptr<Recorder> recorder) {
    recorders_[id] = std::move(recorder);
}

void Timeline::stop_recording(const std::string& id) {
    const auto found = recorders_.find(id);
    if (found == recorders_.end()) throw std::runtime_error("there is no recording '" + id + "'");
    found->second->flush();
    recorders_.erase(found);
}

}  // namespace plumb::host
