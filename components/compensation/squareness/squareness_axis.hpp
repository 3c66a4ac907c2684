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

// The pins of one axis: its motion, its settings, and its tilt in force.
struct SquarenessAxis final : hal::Group {
    using Group::Group;

    static constexpr double farthest = 1e6;  // mu, and mu/s

    hal::In<double> position{this, "%-position", 0, "mu", "Commanded position of %, uncorrected."};
    hal::In<double> velocity{this, "%-velocity", 0, "mu/s", "Commanded velocity of %, uncorrected."};
    hal::In<double> pivot{this, "%-pivot", 0, "mu", "Position of % at which its tilt displaces nothing."};
    hal::In<bool> tool_follows{this, "%-tool-follows", true,
                               "The tool, or the work, turned with %; false: it was set up square."};
    hal::In<double> ea0{this, "ea0%", 0, "rad", "EA0%: tilt of % about X."};
    hal::In<double> eb0{this, "eb0%", 0, "rad", "EB0%: tilt of % about Y."};
    hal::In<double> ec0{this, "ec0%", 0, "rad", "EC0%: tilt of % about Z."};
    hal::Turning turning{this, ea0, eb0, ec0, tool_follows};
    hal::Effects at_once{this, hal::Effect::at_once, position, pivot, tool_follows, ea0, eb0, ec0};
    hal::Out<double> ea0_in_use{this, "ea0%-in-use", "rad", "EA0% in force."};
    hal::Out<double> eb0_in_use{this, "eb0%-in-use", "rad", "EB0% in force."};
    hal::Out<double> ec0_in_use{this, "ec0%-in-use", "rad", "EC0% in force."};

    struct Settings {
        double pivot = 0;                                  // mu
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0
        bool tool_follows = true;

        bool operator==(const Settings& other) const noexcept {
            return std::tie(pivot, angles, tool_follows) ==
                   std::tie(other.pivot, other.angles, other.tool_follows);
        }
        bool names_nothing() const noexcept { return pivot == 0 && angles.isZero(0); }

        // An invalid value keeps its last good one, and sets `bad`.
        Settings usable(const Settings& last, bool& bad) const noexcept {
            Settings now = *this;
            if (now == last) return now;
            now.pivot = plumb::usable(pivot, farthest, last.pivot);
            for (int i = 0; i < 3; ++i)
                if (!(std::abs(angles[i]) < 0.1)) now.angles[i] = last.angles[i];
            bad |= !(now == *this);
            return now;
        }
    };

    Settings read() const noexcept { return {pivot, {ea0, eb0, ec0}, tool_follows}; }

    void show(const Eigen::Vector3d& in_use) noexcept {
        ea0_in_use = in_use[0];
        eb0_in_use = in_use[1];
        ec0_in_use = in_use[2];
    }
};

}  // namespace plumb
