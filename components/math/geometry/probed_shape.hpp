// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/corner.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <vector>

namespace plumb {

// Points on the straight faces of a square or polygon, or around a ring, in a plane of two axes.
struct ProbedShape {
    struct Point {
        Eigen::Vector2d place;  // mm, along a and b
        double normal = 0;      // rad, from +a towards +b: direction of the face; unused for a ring
        double turned = 0;  // rad, from +a towards +b: angle by which the artifact was turned before probing
    };

    Axis a = Axis::X, b = Axis::Y;
    bool ring = false;
    MeasuredObject object = MeasuredObject::artifact;
    std::vector<Point> points;
    double uncertainty = 0;  // mm, standard, of a point at right angles to the face
    // Standard, of the artifact itself: rad, of the direction of a face; of a ring mm, of its ovality.
    // Without it, the artifact counts as true unless it was turned.
    std::optional<double> own_uncertainty;
};

struct ProbedCorner {
    Corner corner;
    std::size_t worst = 0;  // the point, from 0, that lies furthest from the fitted shape, and
    double distance = 0;    // mm, how far
};

// The points do not lie on such a shape.
struct ProbedMisfit : std::invalid_argument {
    explicit ProbedMisfit(const ProbedCorner& found)
        : std::invalid_argument("the points do not lie on such a shape"), fitted(found) {}
    ProbedCorner fitted;
};

// Fits the shape, its place, the corner of the axes, and how much longer the scale of a is than that of b.
// The axes read q and draw the true shape p:
//
//     p = S q,   S = ((1 + k/2, -sin g), (0, (1 - k/2) cos g)),   g: the opening of their corner
//
// A true part reads q = S^-1 p. Faces have their directions, apart from their own errors; the ring is
// round, apart from its ovality. Errors of an artifact that was turned have turned with it; so they are
// separate from those of the axes.
//
// Throws ProbedMisfit, or std::invalid_argument with the reason.
ProbedCorner corner_from_shape(const ProbedShape& shape);

}  // namespace plumb
