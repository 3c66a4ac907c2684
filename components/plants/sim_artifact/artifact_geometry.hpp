// SPDX-License-Identifier: GPL-2.0-or-later
// Blocks with bores through them on a table that turns about Y, or about X where it is a trunnion. Each block
// has a face on both sides of the axis, so that every bore can be probed at both orientations.
#pragma once

#include "components/math/blocks/pi.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace plumb {

struct ArtifactBore {
    double x = 0, y = 0;         // mm, of its axis, from the centre of the table
    double front = 0, back = 0;  // mm, of its two faces along Z, from the centre of the table
    static constexpr double radius = 15,
                            face = 35;  // mm; the face reaches this far from the axis of the bore
};

class ArtifactGeometry {
public:
    static constexpr int most = 8;
    static constexpr double sphere_radius = 10, sphere_height = 80;  // mm, above the centre of the table
    static constexpr double ball = 3;                                // mm, its radius

    static const ArtifactBore& bore(int index) noexcept {
        static constexpr std::array<ArtifactBore, most> bores{{{0, -60, 60, -60},
                                                               {0, 60, 60, -60},
                                                               {-80, -60, 60, -60},
                                                               {80, 60, 60, -60},
                                                               {-80, 60, 110, -110},
                                                               {80, -60, 110, -110},
                                                               {-160, 0, 110, -110},
                                                               {160, 0, 110, -110}}};
        return bores[static_cast<std::size_t>(index < 0 || index >= most ? 0 : index)];
    }

    // The centre of the table in the machine, mm.
    static Eigen::Vector3d centre() noexcept { return {0, 0, -200}; }

    // A point of the artifact, from the centre of the table, in the machine: by its strain from the clamp,
    // the angle of the table in deg, and the displacement of the centre.
    static Eigen::Vector3d place(const Eigen::Vector3d& point, double strain, double angle, bool trunnion,
                                 const Eigen::Vector3d& displacement) noexcept {
        const Eigen::Vector3d clamp(0, -100, 0);
        const Eigen::Vector3d at = point + strain * (point - clamp);
        return centre() + displacement + turned(at, angle, trunnion);
    }

    // A vector that turns with the table.
    static Eigen::Vector3d turned(const Eigen::Vector3d& at, double angle, bool trunnion) noexcept {
        const double c = std::cos(angle * pi / 180), s = std::sin(angle * pi / 180);
        return trunnion ? Eigen::Vector3d(at.x(), c * at.y() - s * at.z(), s * at.y() + c * at.z())
                        : Eigen::Vector3d(c * at.x() + s * at.z(), at.y(), c * at.z() - s * at.x());
    }

    // The centre of the sphere that looks to the spindle now; each side of the table has one.
    static Eigen::Vector3d sphere_place(double strain, double angle, bool trunnion,
                                        const Eigen::Vector3d& displacement) noexcept {
        const double side = std::cos(angle * pi / 180) >= 0 ? 1 : -1;
        return place({0, 0, side * sphere_height}, strain, angle, trunnion, displacement);
    }

    // The place of a bore and of the face that looks to the spindle now.
    static Eigen::Vector3d bore_place(int index, double strain, double angle, bool trunnion,
                                      const Eigen::Vector3d& displacement) noexcept {
        const ArtifactBore& its = bore(index);
        const bool front = std::cos(angle * pi / 180) >= 0;
        return place({its.x, its.y, front ? its.front : its.back}, strain, angle, trunnion, displacement);
    }
};

}  // namespace plumb
