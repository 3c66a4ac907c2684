// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <string>

namespace plumb {

// What squareness is told of one axis, and the tilt of it that it uses.
struct SquarenessAxis {
    struct Settings {
        double pivot = 0;                                  // mu
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0
        bool tool_follows = true;

        bool operator==(const Settings& other) const noexcept {
            return pivot == other.pivot && angles == other.angles && tool_follows == other.tool_follows;
        }
        bool names_nothing() const noexcept { return pivot == 0 && angles.isZero(0); }
    };

    static constexpr double farthest = 1e6;  // mu, and mu/s

    SquarenessAxis(hal::Component* owner, char letter)
        : name(1, letter),
          capital(1, static_cast<char>(letter - 'a' + 'A')),
          position{owner, name + "-position", 0, "mu", "Commanded position of " + capital + ", uncorrected."},
          velocity{owner, name + "-velocity", 0, "mu/s", "Likewise its velocity."},
          pivot{owner, name + "-pivot", 0, "mu",
                "Position of " + capital + " at which its tilt displaces nothing."},
          tool_follows{owner, name + "-tool-follows", true,
                       "The tool, or the work, turned with " + capital + "; false: it was set up square."},
          angles{{owner, "ea0" + name, 0, "rad", "EA0" + capital + ": tilt of " + capital + " about X."},
                 {owner, "eb0" + name, 0, "rad", "EB0" + capital + ": tilt of " + capital + " about Y."},
                 {owner, "ec0" + name, 0, "rad", "EC0" + capital + ": tilt of " + capital + " about Z."}},
          angles_in_use{
              {owner, "ea0" + name + "-in-use", "rad", "EA0" + capital + " that is corrected for."},
              {owner, "eb0" + name + "-in-use", "rad", "EB0" + capital + " that is corrected for."},
              {owner, "ec0" + name + "-in-use", "rad", "EC0" + capital + " that is corrected for."}} {}

    Settings read() const noexcept { return {pivot, {angles[0], angles[1], angles[2]}, tool_follows}; }

    // A value that cannot be keeps what it was; `bad` tells.
    static Settings usable_of(const Settings& given, const Settings& last, bool& bad) noexcept {
        Settings now = given;
        now.pivot = usable(given.pivot, farthest, last.pivot);
        bad |= !(now.pivot == given.pivot);
        for (int i = 0; i < 3; ++i) {
            if (!(std::abs(given.angles[i]) < 0.1)) now.angles[i] = last.angles[i];
            bad |= !(now.angles[i] == given.angles[i]);
        }
        return now;
    }

    void show(const Eigen::Vector3d& in_use) noexcept {
        for (int i = 0; i < 3; ++i) angles_in_use[i] = in_use[i];
    }

    const std::string name, capital;
    hal::In<double> position, velocity, pivot;
    hal::In<bool> tool_follows;
    hal::In<double> angles[3];
    hal::Out<double> angles_in_use[3];
};

}  // namespace plumb
