// SPDX-License-Identifier: GPL-2.0-or-later
// The shared memory of LinuxCNC's motion. LinuxCNC's headers declare its parts alone. Include motion.h first.
#pragma once

namespace plumb::host {

struct MotionMemory {
    emcmot_command_t command;
    emcmot_status_t status;
    emcmot_config_t config;
    emcmot_error_t error;
    emcmot_internal_t internal;
};

}  // namespace plumb::host
