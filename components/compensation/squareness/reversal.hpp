// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/math/blocks/trapezoidal_move.hpp"
#include "components/math/geometry/direction_of_motion.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// The direction d in which each axis moved last, on its way from one end to the other where the axis turns.
struct Reversal final : hal::Group {
    using Group::Group;

    hal::In<bool> motion_enabled{
        this, "motion-enabled", true,
        "The drives are on: motion.motion-enabled. While off, an axis may be pushed."};
    hal::Axes<hal::In<double>, 6> compensated{this, "%-backlash-corr", 0, "mu",
                                              "Compensation of % by LinuxCNC itself: joint.N.backlash-corr."};
    hal::Axes<hal::Out<double>, 6> direction{
        this, "%-direction", "1",
        "Direction in which % moved last: 1 to the + end, -1 to the - end, 0 unknown."};
    hal::Out<bool> doubtful{this, "direction-doubtful",
                            "Errors differ by direction, and that of an axis is not certain."};

    // Each period, first: d goes on, at the acceleration and rate that the joints can share. `fresh`: the
    // tables are new. Then, and with another acceleration, a d on its way starts again at its value: it could
    // not brake.
    void move(const SquarenessSettings::Values& settings, bool fresh, double dt) noexcept {
        fresh |= settings.reversal_acceleration != acceleration_;
        acceleration_ = settings.reversal_acceleration;
        for (Eigen::Index i = 0; i < 4; ++i) {
            TrapezoidalMove& d = turns_[static_cast<std::size_t>(i)];
            const double to = watches_[static_cast<std::size_t>(i)].direction();
            if (fresh || d.arrived(to)) d = TrapezoidalMove(d.position());  // at rest
            if (!d.arrived(to))
                d.step(to, settings.reversal_rate / share_[i], settings.reversal_acceleration / share_[i],
                       dt);
            if (!(std::abs(d.position()) <= 1)) d = TrapezoidalMove(to);  // never beyond the readings
            now_.values[i] = d.position();
            now_.rates[i] = d.arrived(to) && d.position() == last_[i] ? 0 : (d.position() - last_[i]) / dt;
            last_[i] = d.position();
        }
    }

    const SquarenessModel::Directions& now() const noexcept { return now_; }

    // Whether LinuxCNC compensates an axis whose scale has a table; it counts from then on.
    bool watch_compensation(const AxisChain& chain, const ErrorTables::Set& tables) noexcept {
        bool changed = false;
        for (const AxisBranch* branch : {&chain.work, &chain.tool}) {
            for (const Axis axis : *branch) {
                const auto k = static_cast<std::size_t>(coordinate(axis));
                const double by_linuxcnc = compensated[static_cast<std::size_t>(axis)];
                if (by_linuxcnc == 0 || !tables[k] || !tables[k]->scale_measured() || twice_[k]) continue;
                twice_[k] = changed = true;
            }
        }
        any_twice_ |= changed;
        return changed;
    }
    const std::array<bool, 4>& twice() const noexcept { return twice_; }
    bool any_twice() const noexcept { return any_twice_; }

    // Each period, last: the position that the mean tables want.
    void watch(const AxisChain& chain, const AxisPosition& wanted, bool jumped, double distance,
               const SquarenessModel::Result& result) noexcept {
        const bool on = motion_enabled;
        const Eigen::Matrix4d shares = result.by_direction.cwiseAbs();
        const Eigen::Vector4d sums = shares.rowwise().sum();
        bool any = false;
        for (const AxisBranch* branch : {&chain.work, &chain.tool}) {
            for (const Axis axis : *branch) {
                const Eigen::Index i = coordinate(axis);
                const auto k = static_cast<std::size_t>(i);
                if (jumped) {
                    watches_[k].shift(wanted[i] - wanted_[i]);
                    turned_on_at_[i] += wanted[i] - wanted_[i];
                }
                watches_[k].step(wanted[i], distance);
                const double most = shares.col(i).maxCoeff();
                share_[i] = least_share;
                for (Eigen::Index j = 0; j < 4; ++j)
                    if (shares(j, i) > 0) share_[i] = std::max(share_[i], sums[j]);
                if (on && !was_on_) turned_on_at_[i] = wanted[i], pushed_[k] = true;
                if (std::abs(wanted[i] - turned_on_at_[i]) > 2 * most + distance) pushed_[k] = false;
                any |= most > 0 && (pushed_[k] || watches_[k].direction() == 0);
                direction[static_cast<std::size_t>(axis)] = now_.values[i];
            }
        }
        doubtful = doubtful_ = any;
        wanted_ = wanted;
        was_on_ = on;
    }

    bool doubtful_now() const noexcept { return doubtful_; }

    // Whether a cut has begun in doubt, until the doubt ends. An axis that turns at the begin of a cut ends
    // it sooner than in `grace`.
    bool cut_in_doubt(bool cuts, double dt) noexcept {
        cut_for_ = doubtful_ && cuts ? cut_for_ + dt : 0;
        cut_in_doubt_ = doubtful_ && (cut_in_doubt_ || cut_for_ > grace);
        return cut_in_doubt_;
    }

private:
    static constexpr double least_share = 1e-9;  // mu
    static constexpr double grace = 0.2;         // s

    std::array<DirectionOfMotion, 4> watches_;
    std::array<TrapezoidalMove, 4> turns_;
    std::array<bool, 4> twice_{}, pushed_{};  // compensated twice; perhaps pushed while off
    bool any_twice_ = false, was_on_ = true, doubtful_ = false, cut_in_doubt_ = false;
    double cut_for_ = 0;       // s, in doubt
    double acceleration_ = 0;  // mu/s2, the last one
    SquarenessModel::Directions now_;
    AxisPosition last_ = AxisPosition::Zero(), wanted_ = AxisPosition::Zero(),
                 turned_on_at_ = AxisPosition::Zero();
    AxisPosition share_ = AxisPosition::Constant(least_share);  // mu, of the joint that d moves most
};

}  // namespace plumb
