// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/error_tables.hpp"
#include "components/compensation/squareness_settings.hpp"
#include "components/math/ramped_correction.hpp"
#include "components/math/tip_correction.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>

namespace plumb {

// The correction that a position wants with one set of settings, one tool and one set of tables.
class SquarenessModel {
public:
    struct Situation {
        SquarenessSettings::Values settings;
        Eigen::Vector3d tool = Eigen::Vector3d::Zero();  // mu, from the gauge point to the tip
        bool active = false;                             // else the correction is 0

        bool operator==(const Situation& other) const noexcept {
            return settings == other.settings && tool == other.tool && active == other.active;
        }
    };
    struct Motion {
        AxisPosition position = AxisPosition::Zero(), velocity = AxisPosition::Zero();  // mu, mu/s
    };
    struct Result {
        RampedCorrection::Wanted wanted;
        Eigen::Vector3d error = Eigen::Vector3d::Zero();  // mu, of the tip without correction
        bool beyond_table = false;                        // a table does not reach here
        bool steady = true;  // false: it changes with the position as no machine's does, and means nothing
    };

    // A machine unit has so many millimetres, which are what tables are in.
    SquarenessModel(const AxisChain& axes, double millimetres) noexcept
        : axes_(axes), millimetres_(millimetres), chain_({axes, {}, {}, {}}) {}

    const Situation& situation() const noexcept { return situation_; }
    bool linear() const noexcept { return chain_.linear(); }  // no table was in force the last time

    void set(const Situation& situation) noexcept {
        situation_ = situation;
        KinematicChain::Settings s;
        s.axes = axes_;
        s.reading = situation.settings.reading;
        s.datum = situation.settings.datum;
        for_each_axis([&](Axis axis, std::size_t i) {
            s.tilts[i] = {situation.settings.angles(axis), situation.settings.of(axis).tool_follows};
            pivot_[static_cast<Eigen::Index>(i)] = situation.settings.of(axis).pivot;
        });
        chain_ = KinematicChain(s);
    }

    // Best called each period: it takes the errors of the axes where it had led to the last time.
    Result at(const Motion& motion, const ErrorTables::Set& tables) noexcept {
        Result result;
        const AxisPosition q = motion.position - pivot_;
        const AxisPosition there = TipCorrection::corrected(q, led_to_);
        for_each_axis([&](Axis axis, std::size_t i) {
            if (!tables[i]) return;
            const auto k = static_cast<Eigen::Index>(i);
            const double place = (there[k] + pivot_[k]) * millimetres_;
            chain_.set_error(axis, error(there[k], tables[i]->at(place)));
            result.beyond_table |= !(place >= tables[i]->first() && place <= tables[i]->last());
        });
        const TipCorrection::Correction c =
            TipCorrection(chain_, situation_.settings.reference).at(q, situation_.tool);
        result.steady = c.slopes.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= 0.5;
        if (!result.steady) {
            led_to_.setZero();
            return result;
        }
        led_to_ = c.offset;
        result.error = c.error;
        result.wanted.most = situation_.settings.max_correction;
        if (situation_.active) {
            result.wanted.offset = c.offset;
            result.wanted.velocity = c.slopes * motion.velocity;
        }
        return result;
    }

private:
    template <typename Function>
    void for_each_axis(const Function& call) const noexcept {
        for (const AxisBranch* branch : {&axes_.work, &axes_.tool})
            for (const Axis axis : *branch) call(axis, static_cast<std::size_t>(coordinate(axis)));
    }

    AxisError error(double position, const ErrorTable::Reading& reading) const noexcept {
        AxisError result;
        result.position = position;
        for (int i = 0; i < 3; ++i) {
            const auto translation = static_cast<std::size_t>(i), angle = translation + 3;
            result.value.translation[i] = reading.errors[translation] / millimetres_;
            result.slope.translation[i] = reading.slopes[translation];
            result.value.angles[i] = reading.errors[angle];
            result.slope.angles[i] = reading.slopes[angle] * millimetres_;
        }
        return result;
    }

    AxisChain axes_;
    double millimetres_;
    Situation situation_;
    AxisPosition pivot_ = AxisPosition::Zero();
    KinematicChain chain_;
    Eigen::Vector3d led_to_ = Eigen::Vector3d::Zero();  // mu, the correction of the last time
};

}  // namespace plumb
