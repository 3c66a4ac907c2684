// SPDX-License-Identifier: GPL-2.0-or-later
// The virtual clock and the realtime tasks that it releases.
//
// A task is a C function on a stack of its own that runs until it waits for its next period. All tasks share
// the host's one thread: they are released at multiples of their period, a tie goes to the higher priority
// and then to the lower id, and each runs to its wait in no virtual time at all. Equal inputs so give equal
// runs, to the bit.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "hal/host/time.hpp"

namespace plumb::host {

class Scheduler {
public:
    static constexpr int lowest_priority = 1;
    static constexpr int highest_priority = 99;
    static constexpr int most_tasks = 64;

    using Code = void (*)(void* argument);

    Scheduler();
    ~Scheduler();
    Scheduler(const Scheduler&) = delete;

    // Creates a paused task. The stack has at least `stack_size` bytes, never less than 8 MiB, and a guard
    // page. Returns its id (from 0), or a negative errno: -EINVAL (priority out of range), -ENOSPC, -ENOMEM.
    int create(Code code, void* argument, int priority, unsigned long stack_size);

    // Releases a task at every multiple of `period` after now. Returns 0 or -EINVAL (no such task, period
    // below 1, or already started).
    int start(int id, Nanoseconds period);

    // Stops releasing a task; `start` lets it go on where it waits. Returns 0 or -EINVAL.
    int pause(int id);

    // Ends a task. Its stack is unmapped, never unwound: it holds frames of C code. Returns 0 or -EINVAL (no
    // such task, or the one that is running).
    int remove(int id);

    // Ends the running task's period. Does nothing when called from outside any task.
    void wait();

    // Id of the running task, or -EINVAL outside any task.
    int running() const;

    // Whether a task runs. Any thread may ask.
    bool runs() const { return __atomic_load_n(&running_, __ATOMIC_RELAXED) != nullptr; }

    // How often HAL has read a clock since the running task runs. Any thread may ask for it.
    void count_reading() { __atomic_store_n(&readings_, readings_ + 1, __ATOMIC_RELAXED); }
    unsigned readings() const { return __atomic_load_n(&readings_, __ATOMIC_RELAXED); }

    // Whether the address lies in the page that guards the end of the running task's stack.
    bool guards(const void* address) const;

    // The instant that the clock stands at: a release, or the end of a run.
    Nanoseconds time() const { return time_; }

    // The same, for another thread.
    Nanoseconds seen_time() const { return __atomic_load_n(&time_, __ATOMIC_RELAXED); }

    // The time of a realtime clock. Each reading is 1 ns after the one before, so that a busy wait comes to
    // an end.
    Nanoseconds read_clock() { return time_ + ++since_time_; }

    // Lets the clock that realtime code reads go on by `span`, as a delay does.
    void delay(Nanoseconds span) { since_time_ += span > 0 ? span : 0; }

    // The next instant at which a task is released, or `never`.
    Nanoseconds next_release() const { return next_release_; }

    // Moves the clock to `instant`, which must not lie before time() nor beyond next_release().
    void advance(Nanoseconds instant) {
        const Nanoseconds step = instant - time_;
        since_time_ = since_time_ > step ? since_time_ - step : 0;
        time_ = instant;
    }

    // Runs each task that is due at time() for one period, in order of priority and id.
    void run_due();

    // Ends a period, and advances to the next release. Returns false if the run does not go on.
    using Turn = bool (*)(void* argument);

    // Runs the tasks that are due, and calls `turn`, until `turn` returns false. If one task alone is
    // started, wait() calls `turn` on the stack of this task: two changes of stacks cost more than all else
    // of an empty period. C code waits on that stack, so `turn` must not throw.
    void run(Turn turn, void* argument);

private:
    struct Task;
    struct Slot;  // data of a release: compact, since a period must cost next to nothing

    static void switch_to_scheduler(Task& task);
    friend struct TaskEntry;

    Task* find(int id) const;
    void find_next_release();

    std::array<std::unique_ptr<Task>, most_tasks> tasks_;
    std::vector<Slot> started_;  // by falling priority, then by id
    Task* running_ = nullptr;
    Nanoseconds time_ = 0;
    Nanoseconds since_time_ = 0;
    unsigned readings_ = 0;
    Nanoseconds next_release_ = never;
    Turn turn_ = nullptr;  // of the run that is under way
    void* turn_argument_ = nullptr;
    bool over_ = false;  // the last turn returned false
};

// The one scheduler of this process: rtapi is a C interface without a handle. Each period asks for it some
// times: an object in a function would cost a look at its guard each time.
extern Scheduler the_scheduler;
inline Scheduler& scheduler() {
    return the_scheduler;
}

}  // namespace plumb::host
