// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/motion_status.hpp"

#if __has_include(<motion.h>)
#include <motion.h>
#include <rtapi_mutex.h>

#include <cstring>
#include <utility>

#include "hal/host/motion_memory.hpp"

namespace plumb::host {

namespace {

struct MemoryWithLock {  // since LinuxCNC 2.9.5
    rtapi_mutex_t lock;
    MotionMemory rest;
};

HalFunction command_handler = nullptr;
HalFunction controller = nullptr;
emcmot_status_t* status = nullptr;
bool took_command = false;

// The size identifies the layout. With an unknown layout the status stays unmarked.
emcmot_status_t* status_of_motion(SegmentOfSize segment) {
    if (void* const memory = segment(sizeof(MotionMemory)))
        return &static_cast<MotionMemory*>(memory)->status;
    if (void* const memory = segment(sizeof(MemoryWithLock)))
        return &static_cast<MemoryWithLock*>(memory)->rest.status;
    return nullptr;
}

void take_command(void* argument, long period) {
    const int before = status->commandNumEcho;
    command_handler(argument, period);
    if (status->commandNumEcho == before) return;
    // A reader finds head and tail equal in a complete status. motion-controller counts head up, so one more
    // would be equal.
    __atomic_store_n(&status->tail, static_cast<unsigned char>(status->head - 1), __ATOMIC_RELEASE);
    took_command = true;
}

// A move that has begun and has not ended. Task must see it: a status older than the move says that all is
// done.
bool moving() {
    return status->depth > 0 || (status->motionFlag & EMCMOT_MOTION_INPOS_BIT) == 0;
}

// motion-controller counts head up at its beginning, and makes tail equal at its end. Task gives up after
// three incomplete statuses and goes on with the one before, and the computer may stop the host in this
// function for longer. So during a move both count up together.
void show_move(void* argument, long period) {
    if (moving() && status->head == status->tail)
        __atomic_store_n(&status->tail, static_cast<unsigned char>(status->head + 1), __ATOMIC_RELEASE);
    controller(argument, period);
}

}  // namespace

HalFunction marking_status(const char* name, HalFunction function, SegmentOfSize segment) {
    const bool handles = std::strcmp(name, "motion-command-handler") == 0;
    if (!handles && std::strcmp(name, "motion-controller") != 0) return function;
    status = status_of_motion(segment);
    if (status == nullptr) return function;
    (handles ? command_handler : controller) = function;
    return handles ? take_command : show_move;
}

bool motion_took_command() {
    return std::exchange(took_command, false);
}

}  // namespace plumb::host

#else  // LinuxCNC 2.10 does not install motion's declarations: the status stays unmarked

namespace plumb::host {

HalFunction marking_status(const char*, HalFunction function, SegmentOfSize) {
    return function;
}

bool motion_took_command() {
    return false;
}

}  // namespace plumb::host

#endif
