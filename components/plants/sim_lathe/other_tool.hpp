// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/usable.hpp"
#include "components/plants/sim_lathe/turned_stock.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

// Two tools that cut one bar at once: each bends the work of the other, and the deeper one makes the
// diameter. X and Y of a force are machine axes, since the tools may stand on opposite sides.
struct OtherTool final : hal::Group {
    using Group::Group;

    hal::In<double> z{this, "other-z", 0, "mu", "Z at which another tool cuts this work: its cut-z."};
    hal::In<double> radius{this, "other-radius", 0, "mu", "Its cut-radius."};
    hal::In<double> force_x{this, "other-force-x", 0, "N", "Its force-x."};
    hal::In<double> force_y{this, "other-force-y", 0, "N", "Its force-y."};
    hal::Out<double> own_z{this, "cut-z", "mu", "Z at which this tool cuts."};
    hal::Out<double> own_radius{this, "cut-radius", "mu", "Radius that it leaves; 0 if it does not cut."};
    hal::Out<double> own_force_x{this, "force-x", "N", "Force of this tool on the work, in X."};
    hal::Out<double> own_force_y{this, "force-y", "N", "Force of this tool on the work, in Y."};

    struct Force {
        double x = 0, y = 0, z = 0;  // z: where it acts
    };

    // The other tool cuts; returns its force.
    Force cut(TurnedStock& stock) noexcept {
        const double at = usable(z, 1e5, at_), leaves = usable(radius, 1e4, 0);
        if (leaves > 0) stock.cut(cuts_ ? at_ : at, at, leaves);
        cuts_ = leaves > 0;
        at_ = at;
        return {usable(force_x, 1e5, 0), usable(force_y, 1e5, 0), at};
    }

    void show(double leaves, Force force) noexcept {
        own_z = force.z;
        own_radius = leaves;
        own_force_x = force.x;
        own_force_y = force.y;
    }

private:
    double at_ = 0;
    bool cuts_ = false;
};

}  // namespace plumb
