// SPDX-License-Identifier: GPL-2.0-or-later
// The virtual clock and its tasks, without HAL.
#include "hal/host/scheduler.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <string>
#include <vector>

namespace plumb::host {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr unsigned long stack_size = 16384;  // HAL's request

constexpr int caught = 7;  // exit statuses
constexpr int missed = 8;

/// A task that does the same in each period, on the host's one scheduler, which waits and running() refer to.
class Task {
public:
    Task(int priority, std::function<void()> work) : work_(std::move(work)) {
        id_ = tasks().create(&Task::run, this, priority, stack_size);
    }
    ~Task() { tasks().remove(id_); }
    Task(const Task&) = delete;

    int id() const { return id_; }
    static Scheduler& tasks() { return scheduler(); }

private:
    static void run(void* self) {
        for (;;) {
            static_cast<Task*>(self)->work_();
            tasks().wait();
        }
    }

    std::function<void()> work_;
    int id_;
};

/// Runs all releases of the next `span`, up to and including its end.
void run(Nanoseconds span) {
    Scheduler& tasks = scheduler();
    const Nanoseconds end = tasks.time() + span;
    while (tasks.next_release() <= end) {
        tasks.advance(tasks.next_release());
        tasks.run_due();
    }
    tasks.advance(end);
}

/// Goes on to a whole multiple of `period`, so that a test knows the phase.
void align(Nanoseconds period) {
    const Nanoseconds over = scheduler().time() % period;
    run(over == 0 ? 0 : period - over);
}

TEST(HostScheduler, ReleasesAtMultiplesOfThePeriodAfterTheStart) {
    align(10 * ms);
    run(2'500'000);
    const Nanoseconds start = scheduler().time();
    std::vector<Nanoseconds> releases;
    Task task(50, [&] { releases.push_back(scheduler().time() - start); });
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    run(2'500'000);
    EXPECT_EQ(releases, (std::vector<Nanoseconds>{500'000, 1'500'000, 2'500'000}));
}

TEST(HostScheduler, ATieGoesToTheHigherPriorityAndThenToTheLowerId) {
    align(10 * ms);
    std::string order;
    Task first(10, [&] { order += 'a'; });
    Task second(10, [&] { order += 'b'; });
    Task urgent(20, [&] { order += 'U'; });
    for (const Task* task : {&second, &urgent, &first}) ASSERT_EQ(scheduler().start(task->id(), 2 * ms), 0);
    Task fast(5, [&] { order += '.'; });
    ASSERT_EQ(scheduler().start(fast.id(), ms), 0);
    run(4 * ms);
    EXPECT_EQ(order, ".Uab..Uab.");
}

TEST(HostScheduler, ATaskKeepsItsStackFromPeriodToPeriod) {
    struct Counter {
        long count = 0;
        static void run(void* self) {
            for (long local = 1;; ++local) {
                static_cast<Counter*>(self)->count = local;
                scheduler().wait();
            }
        }
    } counter;
    const int id = scheduler().create(&Counter::run, &counter, 50, stack_size);
    ASSERT_EQ(scheduler().start(id, ms), 0);
    run(1000 * ms);
    EXPECT_EQ(counter.count, 1000);
    EXPECT_EQ(scheduler().remove(id), 0);
}

TEST(HostScheduler, ATaskTakesTheSameTurnsAloneAsBesideAnother) {
    struct Run {
        std::vector<Nanoseconds> turns = {};
        static bool turn(void* self) {
            auto& turns = static_cast<Run*>(self)->turns;
            EXPECT_LT(scheduler().running(), 0);
            turns.push_back(scheduler().time());
            scheduler().advance(scheduler().next_release());
            return turns.size() % 3 != 0;
        }
    };
    std::vector<Nanoseconds> periods;
    Task task(50, [&] {
        EXPECT_EQ(scheduler().running(), task.id());
        periods.push_back(scheduler().time());
        scheduler().count_reading();
        EXPECT_EQ(scheduler().readings(), 1U);
    });
    Task other(40, [] {});
    for (const bool alone : {true, false}) {
        SCOPED_TRACE(alone);
        align(10 * ms);
        const Nanoseconds begin = scheduler().time();
        ASSERT_EQ(scheduler().start(task.id(), ms), 0);
        if (!alone) {
            ASSERT_EQ(scheduler().start(other.id(), ms), 0);
        }
        periods.clear();
        Run run;
        for (const std::size_t turns : {3U, 6U}) {
            scheduler().advance(scheduler().next_release());
            scheduler().run(&Run::turn, &run);
            EXPECT_EQ(run.turns.size(), turns);
        }
        std::vector<Nanoseconds> expected;
        for (int i = 1; i <= 6; ++i) expected.push_back(begin + i * ms);
        EXPECT_EQ(run.turns, expected);
        EXPECT_EQ(periods, expected);
        scheduler().pause(task.id());
        scheduler().pause(other.id());
    }
}

TEST(HostScheduler, ATaskHasAMebibyteOfStackForAnyRequest) {
    bool done = false;
    Task task(50, [&] {
        volatile char deep[900 * 1024];
        for (std::size_t i = 0; i < sizeof deep; i += 1024) deep[i] = 1;
        done = deep[0] == 1;
    });
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    run(ms);
    EXPECT_TRUE(done);
}

TEST(HostScheduler, AStackThatIsUsedUpIsCaughtByItsGuardPage) {
    struct Deep {
        [[gnu::noinline]] static int fall(
            int depth) {  // half a page a call, so that none steps over the guard
            volatile char frame[2048];
            frame[0] = static_cast<char>(depth);
            return depth == 1 << 20 ? 0 : fall(depth + 1) + frame[0];
        }
        static void run(void*) { fall(0); }
    };
    const auto die = [] {
        const rlimit no_core{0, 0};
        setrlimit(RLIMIT_CORE, &no_core);
#ifndef PLUMB_SANITIZED
        static char handler_stack[1 << 16];
        stack_t stack{};
        stack.ss_sp = handler_stack;
        stack.ss_size = sizeof handler_stack;
        sigaltstack(&stack, nullptr);
        struct sigaction action {};
        action.sa_flags = SA_SIGINFO | SA_ONSTACK;
        action.sa_sigaction = [](int, siginfo_t* information, void*) {
            _exit(scheduler().guards(information->si_addr) ? caught : missed);
        };
        sigaction(SIGSEGV, &action, nullptr);
#endif
        scheduler().start(scheduler().create(&Deep::run, nullptr, 50, stack_size), ms);
        run(ms);
    };
#ifdef PLUMB_SANITIZED
    EXPECT_DEATH(die(), "stack-overflow");
#else
    EXPECT_EXIT(die(), testing::ExitedWithCode(caught), "");
#endif
}

TEST(HostScheduler, EachReadingOfTheClockIsANanosecondLater) {
    const Nanoseconds now = scheduler().time();
    const Nanoseconds first = scheduler().read_clock();
    EXPECT_GT(first, now);
    EXPECT_EQ(scheduler().read_clock(), first + 1);
    EXPECT_EQ(scheduler().time(), now);
}

TEST(HostScheduler, TheClockNeverGoesBackEvenAfterALongBusyWait) {
    align(ms);
    Nanoseconds last = 0;
    Task task(50, [&] {
        const Nanoseconds begin = scheduler().read_clock();
        EXPECT_GT(begin, last);
        scheduler().delay(1'700'000);  // longer than the period
        last = scheduler().read_clock();
        EXPECT_GE(last, begin + 1'700'000);
    });
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    const Nanoseconds start = scheduler().time();
    run(5 * ms);
    EXPECT_EQ(scheduler().time(), start + 5 * ms);
}

TEST(HostScheduler, APausedTaskGoesOnWhereItWaits) {
    int periods = 0;
    Task task(50, [&] { ++periods; });
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    run(3 * ms);
    ASSERT_EQ(scheduler().pause(task.id()), 0);
    run(3 * ms);
    EXPECT_EQ(periods, 3);
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    run(2 * ms);
    EXPECT_EQ(periods, 5);
}

TEST(HostScheduler, ATaskMayPauseItselfAndOthers) {
    int mine = 0;
    int others = 0;
    Task other(40, [&] { ++others; });
    Task task(50, [&] {
        if (++mine < 2) return;
        EXPECT_EQ(scheduler().pause(other.id()), 0);
        EXPECT_EQ(scheduler().pause(scheduler().running()), 0);
    });
    align(ms);
    ASSERT_EQ(scheduler().start(task.id(), ms), 0);
    ASSERT_EQ(scheduler().start(other.id(), ms), 0);
    run(5 * ms);
    EXPECT_EQ(mine, 2);
    EXPECT_EQ(others, 1);
}

TEST(HostScheduler, RefusesWhatCannotBe) {
    Task task(50, [] {});
    EXPECT_EQ(scheduler().start(task.id(), 0), -EINVAL);
    EXPECT_EQ(scheduler().start(-1, ms), -EINVAL);
    EXPECT_EQ(scheduler().start(Scheduler::most_tasks, ms), -EINVAL);
    EXPECT_EQ(scheduler().start(task.id(), ms), 0);
    EXPECT_EQ(scheduler().start(task.id(), ms), -EINVAL) << "it is started already";
    EXPECT_EQ(scheduler().remove(task.id() + 1), -EINVAL);
    EXPECT_EQ(scheduler().create(nullptr, nullptr, 50, stack_size), -EINVAL);
    EXPECT_EQ(scheduler().create([](void*) {}, nullptr, Scheduler::highest_priority + 1, stack_size),
              -EINVAL);
    EXPECT_EQ(scheduler().running(), -EINVAL);
}

TEST(HostScheduler, ATaskThatReturnsDoesNothingEverAfter) {
    int calls = 0;
    const int id =
        scheduler().create([](void* count) { ++*static_cast<int*>(count); }, &calls, 50, stack_size);
    ASSERT_EQ(scheduler().start(id, ms), 0);
    run(10 * ms);
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(scheduler().remove(id), 0);
}

}  // namespace
}  // namespace plumb::host
