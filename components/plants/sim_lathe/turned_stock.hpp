// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// A bar in a chuck: the radius of its outside, or of its bore, along Z from the chuck. Lengths in mm.
class TurnedStock {
public:
    static constexpr double length = 0.1;  // of a cell
    static constexpr std::size_t cells = 2048;

    void fill(double radius, double from, double to, bool inside) noexcept {
        inside_ = inside;
        for (std::size_t i = 0; i < cells; ++i) {
            const double z = (static_cast<double>(i) + 0.5) * length;
            there_[i] = z >= from && z <= to;
            radius_[i] = radius;
        }
    }

    bool has(double z) const noexcept { return z >= 0 && cell(z) < cells && there_[cell(z)]; }
    double radius(double z) const noexcept { return has(z) ? radius_[cell(z)] : 0; }

    // How deep a tip that leaves this radius cuts here; below 0 if it does not reach the work.
    double depth(double z, double leaves) const noexcept {
        return has(z) ? (inside_ ? leaves - radius_[cell(z)] : radius_[cell(z)] - leaves) : -1;
    }

    // The same against a radius that was here before.
    double depth_against(double before, double leaves) const noexcept {
        return inside_ ? leaves - before : before - leaves;
    }

    // Whether both are in one disc.
    static bool same(double z, double other) noexcept { return cell(z) == cell(other); }

    // A tip that goes from one Z to another and leaves this radius.
    void cut(double from, double to, double leaves) noexcept {
        const double step = to > from ? length / 2 : -length / 2;
        for (double z = from; (to - z) * step > 0; z += step) cut(z, leaves);
        cut(to, leaves);
    }

private:
    void cut(double z, double leaves) noexcept {
        if (depth(z, leaves) > 0) radius_[cell(z)] = leaves;
    }

    static std::size_t cell(double z) noexcept { return static_cast<std::size_t>(z / length); }

    std::array<double, cells> radius_{};
    std::array<bool, cells> there_{};
    bool inside_ = false;
};

}  // namespace plumb
