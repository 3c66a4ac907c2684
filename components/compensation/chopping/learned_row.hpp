// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/dead_point_learning.hpp"
#include "hal/records.hpp"

namespace plumb {

// A learned stroke as the walk shows and restores it.
struct LearnedRow final : hal::RecordRow<DeadPointLearning::Learned> {
    using RecordRow::RecordRow;

    Field<double> lower{this, record.stroke.lower, "lower", "mu", "Lower dead point."};
    Field<double> upper{this, record.stroke.upper, "upper", "mu", "Upper dead point."};
    Field<double> speed{this, record.stroke.speed, "speed", "mu/s", "Peak speed without override."};
    Field<double> acceleration{this, record.stroke.acceleration, "acceleration", "mu/s2",
                               "The max-acceleration."};
    Field<std::int32_t> sections{this, record.stroke.sections, "sections", "",
                                 "Number that stands for all sections, dwells, the lead and the exact stop."};
    Field<double> lower_offset{this, record.offset[0], "lower-offset", "mu",
                               "Correction of the lower dead point."};
    Field<double> upper_offset{this, record.offset[1], "upper-offset", "mu",
                               "Correction of the upper dead point."};
    Field<double> lower_first{this, record.first_offset[0], "lower-first", "mu",
                              "That correction when it was first learned."};
    Field<double> upper_first{this, record.first_offset[1], "upper-first", "mu",
                              "That correction when it was first learned."};
    Field<double> reversal{this, record.reversal, "reversal", "mu/s2", "Acceleration at the dead points."};
    Field<double> proven{this, record.proven, "proven", "mu/s2",
                         "Largest acceleration that the joint has followed."};
    Field<double> lower_slow{this, record.slow[0], "lower-slow", "mu",
                             "Distance that the axis turns beyond its command at 82 % of its speed."};
    Field<double> upper_slow{this, record.slow[1], "upper-slow", "mu",
                             "Distance that the axis turns beyond its command at 82 % of its speed."};
    Field<double> lower_shown{this, record.shown[0], "lower-shown", "mu/s2",
                              "Acceleration of the axis itself after the lower dead point."};
    Field<double> upper_shown{this, record.shown[1], "upper-shown", "mu/s2",
                              "Acceleration of the axis itself after the upper dead point."};
};

}  // namespace plumb
