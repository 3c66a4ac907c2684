// SPDX-License-Identifier: GPL-2.0-or-later
// What LinuxCNC's task finds in the status of motion, in the middle of a period. Fakes write it as motmod
// does.
#include "hal/host/motion_status.hpp"

#if __has_include(<motion.h>)
#define RTAPI
#include <gtest/gtest.h>
#include <motion.h>

#include <memory>

#include "hal/host/motion_memory.hpp"

namespace plumb::host {
namespace {

std::unique_ptr<MotionMemory> motion;
bool readable_within = false;

bool readable() {
    return motion->status.head == motion->status.tail;
}

void handle_command(void*, long) {
    if (motion->command.commandNum == motion->status.commandNumEcho) return;
    ++motion->status.head;
    motion->status.commandNumEcho = motion->command.commandNum;
    motion->status.tail = motion->status.head;
}

void control(void* depth, long) {
    ++motion->status.head;
    readable_within = readable();
    motion->status.depth = *static_cast<int*>(depth);
    motion->status.motionFlag = motion->status.depth > 0 ? 0 : EMCMOT_MOTION_INPOS_BIT;
    motion->status.tail = motion->status.head;
}

class MotionStatus : public testing::Test {
protected:
    MotionStatus() {
        motion = std::make_unique<MotionMemory>();
        motion->status.motionFlag = EMCMOT_MOTION_INPOS_BIT;
        controller_ = marking_status("motion-controller", control, segment);
        handler_ = marking_status("motion-command-handler", handle_command, segment);
    }

    void period(int depth) {
        handler_(nullptr, 1'000'000);
        readable_between_ = readable();
        controller_(&depth, 1'000'000);
        ASSERT_TRUE(readable());
    }

    static void* segment(std::size_t size) { return size == sizeof(MotionMemory) ? motion.get() : nullptr; }

    HalFunction handler_ = nullptr, controller_ = nullptr;
    bool readable_between_ = false;
};

TEST_F(MotionStatus, ACommandIsShownWithTheMoveThatItBegins) {
    ++motion->command.commandNum;
    period(1);
    EXPECT_FALSE(readable_between_) << "the echo, and no move";
    EXPECT_FALSE(readable_within);
}

TEST_F(MotionStatus, AMoveIsShownThroughoutItsPeriods) {
    ++motion->command.commandNum;
    period(1);
    for (int i = 0; i < 300; ++i) {  // the counts have a byte
        const unsigned char before = motion->status.head;
        period(1);
        EXPECT_TRUE(readable_between_);
        EXPECT_TRUE(readable_within);
        EXPECT_NE(motion->status.head, before) << "a copy from two periods would be taken for one";
    }
}

TEST_F(MotionStatus, ACommandDuringAMoveIsShownWithItsOwnMove) {
    period(1);
    ++motion->command.commandNum;
    period(2);
    EXPECT_FALSE(readable_between_);
    EXPECT_FALSE(readable_within);
}

TEST_F(MotionStatus, AtRestAStatusIsOfOnePeriod) {
    period(0);
    period(0);
    EXPECT_FALSE(readable_within);
}

TEST_F(MotionStatus, OtherFunctionsStayAsTheyAre) {
    EXPECT_EQ(marking_status("two.update", control, segment), &control);
}

}  // namespace
}  // namespace plumb::host
#endif
