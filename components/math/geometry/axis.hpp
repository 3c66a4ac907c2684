// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// The linear axes of ISO 841; U, V and W are parallel to X, Y and Z.
enum class Axis { X, Y, Z, U, V, W };

constexpr char letter(Axis axis) noexcept {
    return "XYZUVW"[static_cast<int>(axis)];
}

// 0, 1 or 2: the axis moves along +X, +Y or +Z.
constexpr int direction(Axis axis) noexcept {
    return static_cast<int>(axis) % 3;
}

constexpr bool parallel(Axis a, Axis b) noexcept {
    return direction(a) == direction(b);
}

// Place of the axis in a position of X, Y, Z and the one axis parallel to one of them.
constexpr int coordinate(Axis axis) noexcept {
    return axis <= Axis::Z ? static_cast<int>(axis) : 3;
}

}  // namespace plumb
