// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/turning.hpp"

#include <Eigen/Core>

#include <cmath>
#include <tuple>

namespace plumb {

// The pins of a rotary axis: its motion, its place on the machine, and the errors of that place.
struct SquarenessRotary final : hal::Group {
    using Group::Group;

    static constexpr double farthest = 1e6;  // deg, and deg/s
    static constexpr double misplaced = 10;  // mu

    hal::In<double> position{this, "%-position", 0, "deg",
                             "Commanded position of %, if the option rotary names it."};
    hal::In<double> velocity{this, "%-velocity", 0, "deg/s", "Commanded velocity of %."};
    hal::In<bool> reversed{this, "%-reversed", false,
                           "% turns against ISO 841, as in xyzac-trt-kins without conventional-directions."};
    hal::In<double> x{this, "%-x-pivot", 0, "mu", "X of a point of the axis of %, all axes at 0."};
    hal::In<double> y{this, "%-y-pivot", 0, "mu", "Y of a point of the axis of %, all axes at 0."};
    hal::In<double> z{this, "%-z-pivot", 0, "mu", "Z of a point of the axis of %, all axes at 0."};
    hal::In<double> ex0{this, "ex0%", 0, "mu", "EX0%: place of % along X, actual minus nominal."};
    hal::In<double> ey0{this, "ey0%", 0, "mu", "EY0%: place of % along Y, actual minus nominal."};
    hal::In<double> ez0{this, "ez0%", 0, "mu", "EZ0%: place of % along Z, actual minus nominal."};
    hal::In<double> ea0{this, "ea0%", 0, "rad", "EA0%: tilt of % about X."};
    hal::In<double> eb0{this, "eb0%", 0, "rad", "EB0%: tilt of % about Y."};
    hal::In<double> ec0{this, "ec0%", 0, "rad", "EC0%: tilt of % about Z."};
    hal::Turning turning{this, reversed, ex0, ey0, ez0, ea0, eb0, ec0};
    hal::Effects at_once{this, hal::Effect::at_once, position, reversed, x, y, z, ex0, ey0, ez0, ea0, eb0,
                         ec0};

    struct Settings {
        bool reversed = false;
        Eigen::Vector3d point = Eigen::Vector3d::Zero();   // mu
        Eigen::Vector3d error = Eigen::Vector3d::Zero();   // mu, EX0, EY0, EZ0
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0

        bool operator==(const Settings& other) const noexcept {
            return std::tie(reversed, point, error, angles) ==
                   std::tie(other.reversed, other.point, other.error, other.angles);
        }
        bool names_nothing() const noexcept { return point.isZero(0) && error.isZero(0) && angles.isZero(0); }

        // An invalid value keeps its last good one, and sets `bad`.
        Settings usable(const Settings& last, bool& bad) const noexcept {
            Settings now = *this;
            if (now == last) return now;
            for (int i = 0; i < 3; ++i) {
                now.point[i] = plumb::usable(point[i], farthest, last.point[i]);
                now.error[i] = plumb::usable(error[i], misplaced, last.error[i]);
                if (!(std::abs(angles[i]) < 0.1)) now.angles[i] = last.angles[i];
            }
            bad |= !(now == *this);
            return now;
        }
    };

    Settings read() const noexcept { return {reversed, {x, y, z}, {ex0, ey0, ez0}, {ea0, eb0, ec0}}; }
};

}  // namespace plumb
