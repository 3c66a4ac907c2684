// SPDX-License-Identifier: GPL-2.0-or-later
// The thread on which a module works beside realtime.
#include "hal/background.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

namespace plumb {

namespace {
std::atomic<int> errors_shown{0};
}

// The test program is no module that would have one.
void hal::report_error(const char* text) noexcept {
    EXPECT_EQ(std::string(text), std::bad_alloc().what());
    ++errors_shown;
}

namespace {

using namespace std::chrono_literals;

struct NoPins final : hal::Registrar {
    hal::Slot add(const hal::PinInfo&) override { return hal::Slot(nullptr); }
    void add(hal::Function&) override {}
    std::string add(const hal::OptionInfo& option) override { return option.initial; }
};

struct Worker final : hal::Component {
    explicit Worker(bool works, std::atomic<int>& rounds)
        : Component(no_pins), works_(works), rounds_(rounds) {}
    bool has_background() const noexcept override { return works_; }
    void background() override {
        ++rounds_;
        if (fails) throw std::bad_alloc();
        result += rounds_;  // no atomic: of this thread alone, until it is joined
    }

    std::atomic<bool> fails{false};
    long result = 0;

private:
    static inline NoPins no_pins;
    const bool works_;
    std::atomic<int>& rounds_;
};

struct BackgroundThread : testing::Test {
    Worker& add(bool works) {
        instances.push_back(std::make_unique<Worker>(works, rounds));
        return static_cast<Worker&>(*instances.back());
    }
    void await_rounds(int number) {
        const int before = rounds;
        for (int tries = 0; rounds < before + number && tries < 5000; ++tries)
            std::this_thread::sleep_for(1ms);
        EXPECT_GE(rounds, before + number);
    }

    std::atomic<int> rounds{0};
    std::vector<std::unique_ptr<hal::Component>> instances;
};

TEST_F(BackgroundThread, IsNotThereWhereNoInstanceHasWork) {
    EXPECT_EQ(hal::Background::of(instances), nullptr);
    add(false);
    EXPECT_EQ(hal::Background::of(instances), nullptr);
}

TEST_F(BackgroundThread, WorksForThoseThatHaveWorkUntilItIsDestroyed) {
    Worker& idle = add(false);
    Worker& busy = add(true);
    auto background = hal::Background::of(instances, 1ms);
    await_rounds(3);
    background.reset();
    const int done = rounds;
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(rounds, done);
    EXPECT_EQ(idle.result, 0);
    EXPECT_EQ(busy.result, done * (done + 1L) / 2);
}

TEST_F(BackgroundThread, GoesOnWithoutMemoryAndReportsItOnce) {
    Worker& worker = add(true);
    const int shown = errors_shown;
    const auto background = hal::Background::of(instances, 1ms);
    worker.fails = true;
    await_rounds(5);
    EXPECT_EQ(errors_shown, shown + 1);
    worker.fails = false;
    await_rounds(2);
    worker.fails = true;
    await_rounds(2);
    EXPECT_EQ(errors_shown, shown + 2) << "it had worked in between";
}

}  // namespace
}  // namespace plumb
