// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/stroke_supervision.hpp"
#include "components/compensation/chopping/stroke_values.hpp"
#include "hal/component.hpp"

namespace plumb {

// The outputs that show the dead points, measured and learned.
struct DeadPointPins : hal::Group {
    using Group::Group;

    hal::Out<double> measured_upper{this, "measured-upper", "mu", "Upper dead point of the last stroke."};
    hal::Out<double> measured_lower{this, "measured-lower", "mu", "Lower dead point of the last stroke."};
    hal::Out<double> upper_error{
        this, "upper-error", "mu",
        "Measured minus programmed upper dead point; positive is beyond the stroke."};
    hal::Out<double> lower_error{
        this, "lower-error", "mu",
        "Programmed minus measured lower dead point; positive is beyond the stroke."};
    hal::Out<double> upper_correction{this, "upper-correction", "mu",
                                      "Correction of the commanded upper dead point; positive is outward."};
    hal::Out<double> lower_correction{this, "lower-correction", "mu",
                                      "Correction of the commanded lower dead point; positive is outward."};
    hal::Out<double> speed_factor{this, "speed-factor", "1", "Part of the speed that learning permits."};
    hal::Out<bool> learns{this, "learns", "Learn is in force, for squareness: L-learns."};
    hal::Out<bool> learned{this, "learned", "Both dead points were within tolerance twice."};
    hal::Out<double> drift{this, "drift", "mu", "Change of a correction since it was first learned."};

    void show(const StrokeSupervision& supervision, const StrokeValues& values) noexcept {
        const DeadPointWatch& watch = supervision.dead_points();
        const DeadPointLearning& learning = supervision.learning();
        measured_upper = watch.position(true);
        measured_lower = watch.position(false);
        upper_error = watch.error(true);
        lower_error = watch.error(false);
        upper_correction = values.learn ? watch.arrival(true).offset : 0;
        lower_correction = values.learn ? watch.arrival(false).offset : 0;
        speed_factor = supervision.part(values);
        learns = values.learn;
        learned = values.learn && learning.learned();
        drift = values.learn ? learning.drift() : 0;
    }
};

}  // namespace plumb
