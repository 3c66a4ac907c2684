// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/random.hpp"
#include "components/plants/sim_mill/tool_engagement.hpp"

#include <array>
#include <cstdint>
#include <utility>

namespace plumb {

// One cut: a plunge, or a pass from the side. Millimetres, rpm.
struct Operation {
    std::int32_t key;
    std::int32_t occurrence;  // run of the key in this cycle, from 1
    std::int32_t tool;
    ToolKind kind;
    bool from_side;
    double diameter;
    std::int32_t teeth;
    double speed;
    double top;    // Z of the work that it starts from
    double depth;  // below top
};

using PartProgram = std::array<Operation, 5>;

// The program of machine 0: two plunges by one line of a subroutine, a drill, a face mill, another end mill.
inline PartProgram typical_program() noexcept {
    return {{{10, 1, 1, ToolKind::end_mill, false, 12, 4, 8000, -1, 2},
             {10, 2, 1, ToolKind::end_mill, false, 12, 4, 8000, -4, 2},
             {20, 1, 2, ToolKind::drill, false, 8, 2, 5000, -1, 5},
             {30, 1, 3, ToolKind::end_mill, true, 32, 4, 4000, 0, 1},
             {40, 1, 4, ToolKind::end_mill, false, 10, 4, 8000, -2, 2}}};
}

// A program of the same kind with other tools, speeds, levels and depths. The drill and the face mill may
// be end mills that plunge, and change places.
inline PartProgram drawn_program(Random& random) noexcept {
    PartProgram program = typical_program();
    for (Operation& operation : program) {
        if (operation.tool == 1 || operation.tool == 4 || random.uniform() < 0.25) {
            operation.kind = ToolKind::end_mill;
            operation.from_side = false;
            operation.diameter = random.uniform(8, 16);
            operation.speed = random.uniform(5000, 8000);
        }
        operation.top = random.uniform(-10, 0);
        operation.depth = operation.from_side ? random.uniform(0.5, 1.5) : random.uniform(1.5, 3);
    }
    program[1].diameter = program[0].diameter;  // the same tool, the same line
    program[1].speed = program[0].speed;
    if (random.uniform() < 0.5) std::swap(program[2], program[3]);
    return program;
}

}  // namespace plumb
