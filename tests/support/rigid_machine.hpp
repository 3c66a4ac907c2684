// SPDX-License-Identifier: GPL-2.0-or-later
// Machines out of square as the textbook has them, for tests: vectors that turn, and nothing else.
#pragma once

#include <array>
#include <cmath>

namespace plumb {

struct Vec {
    double x = 0, y = 0, z = 0;

    Vec operator+(const Vec& v) const { return {x + v.x, y + v.y, z + v.z}; }
    Vec operator-(const Vec& v) const { return {x - v.x, y - v.y, z - v.z}; }
    Vec operator*(double s) const { return {x * s, y * s, z * s}; }
    double length() const { return std::sqrt(x * x + y * y + z * z); }
};

inline Vec about_x(double a, const Vec& v) {
    return {v.x, std::cos(a) * v.y - std::sin(a) * v.z, std::sin(a) * v.y + std::cos(a) * v.z};
}
inline Vec about_y(double a, const Vec& v) {
    return {std::cos(a) * v.x + std::sin(a) * v.z, v.y, std::cos(a) * v.z - std::sin(a) * v.x};
}
inline Vec about_z(double a, const Vec& v) {
    return {std::cos(a) * v.x - std::sin(a) * v.y, std::sin(a) * v.x + std::cos(a) * v.y, v.z};
}
// By (EA, EB, EC): first about X, last about Z.
inline Vec turned(const Vec& angles, const Vec& v) {
    return about_z(angles.z, about_y(angles.y, about_x(angles.x, v)));
}
inline Vec turned_back(const Vec& angles, const Vec& v) {
    return about_x(-angles.x, about_y(-angles.y, about_z(-angles.z, v)));
}

using Position = std::array<double, 4>;  // X, Y, Z and W, from the pivot

// The tip of a machine without errors.
inline Vec ideal_tip(const Position& q, const Vec& tool) {
    return Vec{q[0], q[1], q[2] + q[3]} + tool;
}

// w-Z.b-X-Y-C-t: the column that Y carries the tool on leans.
struct LeaningColumn {
    double ea0y = 0, ec0y = 0;

    Vec tip(const Position& q, const Vec& tool) const {
        return Vec{q[0], 0, q[2]} + turned({ea0y, 0, ec0y}, Vec{0, q[1], 0} + tool);
    }
};

// w-X.b-W-Y-Z-C-t: the cross rail W leans, and the ram Z on its saddle Y.
struct LeaningPortal {
    double ea0w = 0, eb0w = 0, ea0z = 0, eb0z = 0;
    bool axis_direction = false, to_bed = false;

    Vec tip(const Position& q, const Vec& tool) const {
        const Vec rail{ea0w, eb0w, 0}, ram{ea0z, eb0z, 0};
        const Vec saddle{0, q[1], 0}, hanging = turned(ram, Vec{0, 0, q[2]} + tool);
        return Vec{q[0], 0, 0} + turned(rail, {0, 0, q[3]}) +
               (axis_direction ? saddle : turned(rail, saddle)) + (to_bed ? hanging : turned(rail, hanging));
    }
};

}  // namespace plumb
