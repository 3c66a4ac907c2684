// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// The axes of ISO 841: linear ones, of which U, V and W are parallel to X, Y and Z, and rotary ones about
// X, Y and Z.
enum class Axis { X, Y, Z, U, V, W, A, B, C };

constexpr char letter(Axis axis) noexcept {
    return "XYZUVWABC"[static_cast<int>(axis)];
}

constexpr bool rotary(Axis axis) noexcept {
    return axis >= Axis::A;
}

// 0, 1 or 2: the axis moves along, or turns about, +X, +Y or +Z.
constexpr int direction(Axis axis) noexcept {
    return static_cast<int>(axis) % 3;
}

// Of two linear axes.
constexpr bool parallel(Axis a, Axis b) noexcept {
    return direction(a) == direction(b) && !rotary(a) && !rotary(b);
}

// Place of a linear axis in a position of X, Y, Z and the one axis parallel to one of them; A, B and C
// follow.
constexpr int coordinate(Axis axis) noexcept {
    if (rotary(axis)) return 4 + direction(axis);
    return axis <= Axis::Z ? static_cast<int>(axis) : 3;
}

}  // namespace plumb
