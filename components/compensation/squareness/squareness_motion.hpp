// SPDX-License-Identifier: GPL-2.0-or-later
// What squareness follows while the machine runs, each period in this order:
//
//     MotionReader      positions, velocities and the tool in force, from their pins
//     Reversal          the direction in which each axis moved last, and its ramp from one table to the other
//     Settling          whether the next cut has to wait until all ramps have ended
#pragma once

#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/math/blocks/trapezoidal_move.hpp"
#include "components/math/geometry/error_table.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// The motion of the axes and the tool in force, from their pins. An invalid value keeps its last good one.
class MotionReader {
public:
    const SquarenessModel::Motion& motion() const noexcept { return motion_; }
    const Eigen::Vector3d& tool() const noexcept { return tool_; }  // mu, from the gauge point to the tip
    bool motion_known() const noexcept { return motion_known_; }
    bool tool_known() const noexcept { return tool_known_; }

    // Returns whether a position has changed faster than its axis can move within `time`.
    bool read_motion(const SquarenessSettings& settings, double time) noexcept {
        const double way = settings.values().max_speed * time,
                     turn = settings.values().max_rotary_speed * time;
        bool jumped = false;
        motion_known_ = true;
        for (std::size_t i = 0; i < settings.axes.size(); ++i) {
            const SquarenessAxis& pins = settings.axes[i];
            jumped |= take(pins.position, pins.velocity, motion_.position[static_cast<int>(i)],
                           motion_.velocity[static_cast<int>(i)], way);
        }
        for (const SquarenessRotary& pins : settings.rotaries) {
            const auto k = static_cast<std::size_t>(pins.axis);
            const double sign = settings.values().rotaries[k].reversed ? -1 : 1;
            jumped |= take(sign * pins.position, sign * pins.velocity, motion_.angles[pins.axis],
                           motion_.rates[pins.axis], turn);
        }
        return jumped;
    }

    template <class Offsets>
    void read_tool(const Offsets& tool_offset) noexcept {
        tool_known_ = true;
        for (int i = 0; i < 3; ++i) {
            const double offset = tool_offset[i];
            tool_known_ &= std::abs(offset) <= SquarenessRanges::tools.most;
            tool_[i] = -usable(offset, SquarenessRanges::tools.most, -tool_[i]);
        }
    }

private:
    // Returns whether the position has changed by more than `most`.
    bool take(double given, double rate, double& position, double& velocity, double most) noexcept {
        const double last = position;
        const bool known = std::abs(given) <= SquarenessRanges::places.most &&
                           std::abs(rate) <= SquarenessRanges::places.most;
        motion_known_ &= known;
        position = usable(given, SquarenessRanges::places.most, last);
        velocity = known ? rate : 0;
        return std::abs(position - last) > most;
    }

    SquarenessModel::Motion motion_;
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();
    bool motion_known_ = true, tool_known_ = true;
};

// The direction d in which each axis moved last, on its way from one end to the other where the axis turns.
struct Reversal final : hal::Group {
    Reversal(hal::Owner owner, const std::string& linear_axes) : Group(owner), axes_(linear_axes) {}

private:
    const std::string axes_;  // letters, by coordinate()

public:
    hal::In<bool> motion_enabled{
        this, "motion-enabled", true,
        "The drives are on: motion.motion-enabled. While off, an axis may be pushed."};
    hal::Axes<hal::In<double>> compensated{
        this, axes_, "%-backlash-corr",
        0,    "mu",  "Compensation of % by LinuxCNC itself: joint.N.backlash-corr."};
    hal::Axes<hal::In<bool>> learns{this, axes_, "%-learns", false,
                                    "Strokes of % learn its dead points: learns of chopping."};
    hal::Axes<hal::Out<double>> direction{
        this, axes_, "%-direction", "1",
        "Direction in which % moved last: 1 to the + end, -1 to the - end, 0 unknown."};
    hal::Out<bool> doubtful{
        this, "direction-doubtful",
        "The errors of an axis differ by direction, and the direction of its last move is not "
        "certain."};

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

    // Whether LinuxCNC compensates an axis whose scale has a table; it counts from then on. Or chopping
    // begins or ends to correct the dead points of an axis whose scale differs by direction.
    bool watch_compensation(const ErrorTables::Set& tables) noexcept {
        bool changed = false;
        any_learned_ = false;
        for (std::size_t k = 0; k < axes_.size(); ++k) {
            const bool by_chopping = learns[k] && tables[k] && tables[k]->scale_directed();
            changed |= learned_[k] != by_chopping;
            learned_[k] = by_chopping;
            any_learned_ |= by_chopping;
            const double by_linuxcnc = compensated[k];
            if (by_linuxcnc == 0 || !tables[k] || !tables[k]->scale_measured() || twice_[k]) continue;
            twice_[k] = any_twice_ = changed = true;
        }
        return changed;
    }
    const std::array<bool, 4>& twice() const noexcept { return twice_; }
    const std::array<bool, 4>& learned() const noexcept { return learned_; }
    bool any_twice() const noexcept { return any_twice_; }
    bool any_learned() const noexcept { return any_learned_; }

    // Each period, last: the position that the mean tables want.
    void watch(const AxisPosition& wanted, bool jumped, double distance,
               const SquarenessModel::Result& result) noexcept {
        const bool on = motion_enabled;
        const Eigen::Matrix4d shares = result.by_direction.cwiseAbs();
        const Eigen::Vector4d sums = shares.rowwise().sum();
        bool any = false;
        for (std::size_t k = 0; k < axes_.size(); ++k) {
            const auto i = static_cast<Eigen::Index>(k);
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
            direction[k] = now_.values[i];
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
    std::array<bool, 4> learned_{};           // the dead points, by chopping
    bool any_learned_ = false;
    bool any_twice_ = false, was_on_ = true, doubtful_ = false, cut_in_doubt_ = false;
    double cut_for_ = 0;       // s, in doubt
    double acceleration_ = 0;  // mu/s2, the last one
    SquarenessModel::Directions now_;
    AxisPosition last_ = AxisPosition::Zero(), wanted_ = AxisPosition::Zero(),
                 turned_on_at_ = AxisPosition::Zero();
    AxisPosition share_ = AxisPosition::Constant(least_share);  // mu, of the joint that d moves most
};

// Whether the next cut has to wait: from a change of the tool until all ramps have ended. LinuxCNC changes
// the offset of a tool at rest, between two moves, and the next move begins a period later.
class Settling {
public:
    // The unsettled-code.
    enum class Ended : std::int32_t { in_force, disabled, fault, limited, late, by_a_cut, in_a_cut };
    friend constexpr const char* sentence(Ended ended) {
        switch (ended) {
            case Ended::disabled: return "The correction was switched off, or a joint is not homed any more.";
            case Ended::fault: return "The correction has a fault.";
            case Ended::limited: return "The correction is limited.";
            case Ended::late: return "Settling took longer than settling-time.";
            case Ended::by_a_cut: return "A cut began: after M53 P0 with M49 or M51 P0, or a thread.";
            case Ended::in_a_cut: return "The tool changed in a cut.";
            default: return nullptr;
        }
    }

    // The inputs of one period.
    struct Inputs {
        bool tool_changed, ramping;
        bool active, fault, limited;  // of the correction
        bool coordinated;             // by a program or MDI; else by jogs
        std::int32_t motion_type;     // of LinuxCNC, below
        double path_velocity;         // mu/s
        double longest;               // s
    };

    void step(const Inputs& now, double dt) noexcept {
        watch_cut(now);
        const Ended end = reason(now);
        if (now.tool_changed) {
            waits_ = now.ramping && now.active;
            waited_ = 0;
            ended_ = Ended::in_force;
            if (waits_ && end != Ended::in_force) stop(end == Ended::by_a_cut ? Ended::in_a_cut : end);
        } else if (waits_) {
            waited_ += dt;
            if (end != Ended::in_force)
                stop(end);
            else if (!now.ramping)
                waits_ = false;
            else if (waited_ >= now.longest)
                stop(Ended::late);
        }
        holds_ = waits_ && now.coordinated;
    }

    bool holds() const noexcept { return holds_; }
    bool cuts() const noexcept { return cuts_; }
    Ended ended() const noexcept {
        return ended_;
    }  // of the last change: why it was not waited for to the end

private:
    enum MotionType : std::int32_t { none = 0, rapid = 1, tool_change = 4, index_rotary = 6 };

    // From the first motion that is no rapid until LinuxCNC does something else: a hold in between belongs
    // to the cut. A rigid tap has no type, and other moves have none in their first period.
    void watch_cut(const Inputs& now) noexcept {
        const bool moves = !(std::abs(now.path_velocity) <= still), goes_on = moves && moved_;
        const bool works =
            now.motion_type != rapid && now.motion_type != tool_change && now.motion_type != index_rotary;
        if (!now.coordinated || !works || (now.motion_type == none && !moves))
            cuts_ = false;
        else if (now.motion_type == none ? goes_on : moves)
            cuts_ = true;
        moved_ = moves;
    }

    Ended reason(const Inputs& now) const noexcept {
        return !now.active   ? Ended::disabled
               : now.fault   ? Ended::fault
               : now.limited ? Ended::limited
               : cuts_       ? Ended::by_a_cut
                             : Ended::in_force;
    }

    void stop(Ended why) noexcept {
        waits_ = false;
        ended_ = why;
    }

    static constexpr double still = 1e-9;  // mu/s

    bool moved_ = false, cuts_ = false, waits_ = false, holds_ = false;
    double waited_ = 0;  // s
    Ended ended_ = Ended::in_force;
};

}  // namespace plumb
