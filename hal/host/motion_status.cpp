// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/motion_status.hpp"

#if __has_include(<motion.h>)
#include <motion.h>
#include <rtapi_mutex.h>

#include <cstring>
#include <utility>

#include "hal/host/shared_memory.hpp"

namespace plumb::host {

namespace {

// LinuxCNC's headers have no declaration of motion's shared memory, but for its parts.
struct Memory {
    emcmot_command_t command;
    emcmot_status_t status;
    emcmot_config_t config;
    emcmot_error_t error;
    emcmot_internal_t internal;
};
struct MemoryWithLock {  // since LinuxCNC 2.9.5
    rtapi_mutex_t lock;
    Memory rest;
};

HalFunction command_handler = nullptr;
emcmot_status_t* status = nullptr;
bool took_command = false;

// The size identifies the layout. With an unknown layout the status stays unmarked.
emcmot_status_t* status_of_motion() {
    if (void* const memory = shared_memory().address_of_size(sizeof(Memory)))
        return &static_cast<Memory*>(memory)->status;
    if (void* const memory = shared_memory().address_of_size(sizeof(MemoryWithLock)))
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

}  // namespace

HalFunction marking_status(const char* name, HalFunction function) {
    if (std::strcmp(name, "motion-command-handler") != 0) return function;
    status = status_of_motion();
    if (status == nullptr) return function;
    command_handler = function;
    return take_command;
}

bool motion_took_command() {
    return std::exchange(took_command, false);
}

}  // namespace plumb::host

#else  // LinuxCNC 2.10 does not install motion's declarations: the status stays unmarked

namespace plumb::host {

HalFunction marking_status(const char*, HalFunction function) {
    return function;
}

bool motion_took_command() {
    return false;
}

}  // namespace plumb::host

#endif
