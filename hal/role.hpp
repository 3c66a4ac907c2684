// SPDX-License-Identifier: GPL-2.0-or-later
// What a module or a program is for. The JSON has it, and lists of functions follow from it.
#pragma once

namespace plumb::hal {

enum class Role {
    none,          // of a test
    compensation,  // measures an error of the machine, or corrects it
    stage,         // brings an offset into an axis, or permits it
    plant,         // simulates a machine, or a part of it
    program,       // runs beside realtime
};

constexpr const char* name(Role role) {
    switch (role) {
        case Role::compensation: return "compensation";
        case Role::stage: return "stage";
        case Role::plant: return "plant";
        case Role::program: return "program";
        default: return "";
    }
}

}  // namespace plumb::hal
