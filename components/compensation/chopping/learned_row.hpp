// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/dead_point_learning.hpp"
#include "hal/records.hpp"

namespace plumb {

// A learned stroke as the walk shows and restores it.
struct LearnedRow : hal::Group {
    using Group::Group;

    void show(DeadPointLearning::Learned learned) noexcept {
        each(learned, [](auto& field, const auto& value) { field.row = value; });
    }

    DeadPointLearning::Learned given() noexcept {
        DeadPointLearning::Learned learned;
        each(learned, [](auto& field, auto& value) { value = field.restore; });
        return learned;
    }

    hal::Field<double> lower{this, "lower", "mu", "Lower dead point."};
    hal::Field<double> upper{this, "upper", "mu", "Upper dead point."};
    hal::Field<double> speed{this, "speed", "mu/s", "Peak speed without override."};
    hal::Field<double> acceleration{this, "acceleration", "mu/s2", "The max-acceleration."};
    hal::Field<std::int32_t> sections{this, "sections", "",
                                      "Number that stands for all sections, dwells and the exact stop."};
    hal::Field<double> lower_offset{this, "lower-offset", "mu", "Correction of the lower dead point."};
    hal::Field<double> upper_offset{this, "upper-offset", "mu", "Correction of the upper dead point."};
    hal::Field<double> lower_first{this, "lower-first", "mu", "That correction when it was first learned."};
    hal::Field<double> upper_first{this, "upper-first", "mu", "That correction when it was first learned."};
    hal::Field<double> reversal{this, "reversal", "mu/s2", "Acceleration at the dead points."};
    hal::Field<double> proven{this, "proven", "mu/s2", "Largest acceleration that the joint has followed."};

private:
    // Each field, and its place in what was learned.
    template <class Visit>
    void each(DeadPointLearning::Learned& its, const Visit& visit) noexcept {
        visit(lower, its.stroke.lower);
        visit(upper, its.stroke.upper);
        visit(speed, its.stroke.speed);
        visit(acceleration, its.stroke.acceleration);
        visit(sections, its.stroke.sections);
        visit(lower_offset, its.offset[0]);
        visit(upper_offset, its.offset[1]);
        visit(lower_first, its.first_offset[0]);
        visit(upper_first, its.first_offset[1]);
        visit(reversal, its.reversal);
        visit(proven, its.proven);
    }
};

}  // namespace plumb
