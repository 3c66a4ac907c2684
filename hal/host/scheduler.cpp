// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/scheduler.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <boost/context/detail/fcontext.hpp>
#include <cerrno>

#ifdef __SSE__
#include <xmmintrin.h>
#endif
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/common_interface_defs.h>
#endif

namespace plumb::host {

using boost::context::detail::fcontext_t;
using boost::context::detail::jump_fcontext;
using boost::context::detail::make_fcontext;
using boost::context::detail::transfer_t;

namespace {

constexpr std::size_t smallest_stack = 8 << 20;  // as the first thread has: turns are taken there, too

std::size_t page_size() {
    return static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// A mapped stack whose lowest page may not be touched.
class Stack {
public:
    explicit Stack(std::size_t size) : guard_(page_size()) {
        size_ = (std::max(size, smallest_stack) + guard_ - 1) / guard_ * guard_;
        void* memory =
            mmap(nullptr, guard_ + size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (memory == MAP_FAILED) return;
        bottom_ = static_cast<char*>(memory) + guard_;
        if (mprotect(bottom_, size_, PROT_READ | PROT_WRITE) != 0) release();
    }
    ~Stack() { release(); }
    Stack(const Stack&) = delete;

    bool guards(const void* address) const { return address >= bottom_ - guard_ && address < bottom_; }
    bool valid() const { return bottom_ != nullptr; }
    char* bottom() const { return bottom_; }
    char* top() const { return bottom_ + size_; }
    std::size_t size() const { return size_; }

private:
    void release() {
        if (bottom_ != nullptr) munmap(bottom_ - guard_, guard_ + size_);
        bottom_ = nullptr;
    }

    std::size_t guard_;
    std::size_t size_ = 0;
    char* bottom_ = nullptr;
};

// AddressSanitizer must know which stack is in use. Without it this costs nothing.
class StackSwitch {
public:
#ifdef __SANITIZE_ADDRESS__
    StackSwitch(const void* bottom, std::size_t size) {
        __sanitizer_start_switch_fiber(&fake_stack_, bottom, size);
    }
    void back() {
        __sanitizer_finish_switch_fiber(fake_stack_, nullptr, nullptr);
    }
    static void arrived(const void** from_bottom, std::size_t* from_size) {
        __sanitizer_finish_switch_fiber(nullptr, from_bottom, from_size);
    }

private:
    void* fake_stack_ = nullptr;
#else
    StackSwitch(const void*, std::size_t) {}
    void back() {}
    static void arrived(const void**, std::size_t*) {}
#endif
};

// A switch between stacks is some ten times slower while the two sides' floating point exception flags
// differ. They are sticky: once all are set on this side, the tasks, which begin with a copy, differ no
// more.
void set_sticky_floating_point_flags() {
#ifdef __SSE__
    _mm_setcsr(_mm_getcsr() | _MM_EXCEPT_MASK);
#endif
}

}  // namespace

struct Scheduler::Task {
    Task(int task_id, Code task_code, void* task_argument, int task_priority, std::size_t stack_size)
        : id(task_id), priority(task_priority), code(task_code), argument(task_argument), stack(stack_size) {}

    int id;
    int priority;
    Code code;
    void* argument;
    Stack stack;
    fcontext_t context = nullptr;    // where the task goes on
    fcontext_t scheduler = nullptr;  // where the scheduler goes on, while the task runs
    const void* scheduler_stack = nullptr;
    std::size_t scheduler_stack_size = 0;
};

struct Scheduler::Slot {
    Nanoseconds release;
    Nanoseconds period;
    Task* task;
};

struct TaskEntry {
    // The first frame of a task's stack.
    static void run(transfer_t transfer) {
        auto& task = *static_cast<Scheduler::Task*>(transfer.data);
        StackSwitch::arrived(&task.scheduler_stack, &task.scheduler_stack_size);
        task.scheduler = transfer.fctx;
        task.code(task.argument);
        for (;;)
            Scheduler::switch_to_scheduler(task);  // a task that has returned does nothing for ever after
    }
};

Scheduler the_scheduler;

Scheduler::Scheduler() = default;
Scheduler::~Scheduler() = default;

int Scheduler::create(Code code, void* argument, int priority, unsigned long stack_size) {
    if (priority < lowest_priority || priority > highest_priority || code == nullptr) return -EINVAL;
    const auto free_place = std::find(tasks_.begin(), tasks_.end(), nullptr);
    if (free_place == tasks_.end()) return -ENOSPC;
    const int id = static_cast<int>(free_place - tasks_.begin());
    auto task = std::make_unique<Task>(id, code, argument, priority, stack_size);
    if (!task->stack.valid()) return -ENOMEM;
    set_sticky_floating_point_flags();
    task->context = make_fcontext(task->stack.top(), task->stack.size(), &TaskEntry::run);
    *free_place = std::move(task);
    return id;
}

Scheduler::Task* Scheduler::find(int id) const {
    return id >= 0 && id < most_tasks ? tasks_[static_cast<std::size_t>(id)].get() : nullptr;
}

int Scheduler::start(int id, Nanoseconds period) {
    Task* const task = find(id);
    if (task == nullptr || period < 1) return -EINVAL;
    for (const Slot& slot : started_)
        if (slot.task == task) return -EINVAL;
    const auto place = std::find_if(started_.begin(), started_.end(), [task](const Slot& slot) {
        return slot.task->priority < task->priority ||
               (slot.task->priority == task->priority && slot.task->id > task->id);
    });
    started_.insert(place, Slot{(time_ / period + 1) * period, period, task});
    find_next_release();
    return 0;
}

int Scheduler::pause(int id) {
    Task* const task = find(id);
    const auto place = std::find_if(started_.begin(), started_.end(),
                                    [task](const Slot& slot) { return slot.task == task; });
    if (task == nullptr || place == started_.end()) return -EINVAL;
    started_.erase(place);
    find_next_release();
    return 0;
}

int Scheduler::remove(int id) {
    Task* const task = find(id);
    if (task == nullptr || task == running_) return -EINVAL;
    pause(id);
    tasks_[static_cast<std::size_t>(id)].reset();
    return 0;
}

void Scheduler::switch_to_scheduler(Task& task) {
    StackSwitch to_scheduler(task.scheduler_stack, task.scheduler_stack_size);
    const transfer_t transfer = jump_fcontext(task.scheduler, nullptr);
    to_scheduler.back();
    task.scheduler = transfer.fctx;
}

void Scheduler::wait() {
    Task* const self = running_;
    if (self == nullptr) return;
    if (turn_ != nullptr && started_.size() == 1 && started_.front().task == self) {
        Slot& slot = started_.front();
        next_release_ = slot.release;
        running_ = nullptr;
        over_ = !turn_(turn_argument_);
        running_ = self;
        if (!over_) {
            slot.release += slot.period;
            readings_ = 0;
            return;
        }
    }
    switch_to_scheduler(*self);
}

void Scheduler::run(Turn turn, void* argument) {
    turn_ = turn;
    turn_argument_ = argument;
    over_ = false;
    do {
        run_due();
    } while (!over_ && turn(argument));
    turn_ = nullptr;
}

int Scheduler::running() const {
    return running_ == nullptr ? -EINVAL : running_->id;
}

bool Scheduler::guards(const void* address) const {
    return running_ != nullptr && running_->stack.guards(address);
}

void Scheduler::run_due() {
    // By index: a task may pause another one, or itself.
    for (std::size_t i = 0; i < started_.size(); ++i) {
        Slot& slot = started_[i];
        if (slot.release > time_) continue;
        slot.release += slot.period;
        Task& task = *slot.task;
        running_ = &task;
        readings_ = 0;
        StackSwitch to_task(task.stack.bottom(), task.stack.size());
        task.context = jump_fcontext(task.context, &task).fctx;
        to_task.back();
        running_ = nullptr;
    }
    find_next_release();
}

void Scheduler::find_next_release() {
    Nanoseconds next = never;
    for (const Slot& slot : started_) next = std::min(next, slot.release);
    next_release_ = next;
}

}  // namespace plumb::host
