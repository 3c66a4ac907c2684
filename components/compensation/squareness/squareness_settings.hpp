// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_codes.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/error_table.hpp"
#include "components/math/geometry/kinematic_chain.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/turning.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

namespace plumb {

// What an axis may be set to.
struct SquarenessRanges {
    static constexpr hal::Range places{-1e6, 1e6}, tilts{-0.1, 0.1}, misplacements{-10, 10}, tools{-1e4, 1e4};

    // An invalid value keeps its last good one, and sets `bad`.
    static void make_usable(double& value, const hal::Range& range, double last, bool& bad) noexcept {
        if (range.contains(value)) return;
        value = last;
        bad = true;
    }
};

// Errors of an axis about or along each of the others: about or along itself they are its zero, or are those
// of the axes that it carries. By number of X, Y, Z.
class CrossErrors final : hal::Group {
public:
    // `first` is the letter of the error X: a of EA0Y, x of EX0C. The sentence is "EA0Y: tilt of Y about X.":
    // `of` stands before the last word, `after` behind it.
    CrossErrors(hal::Owner owner, char first, const char* unit, const char* of, const char* after,
                const hal::Range& range)
        : Group(owner),
          own_((owner.axis() - (owner.axis() < 'd'   ? 'a'
                                : owner.axis() < 'x' ? 'u'
                                                     : 'x')) %
               3),
          pins_{{this, name(first, 0), 0, unit, sentence(first, 0, of, after), hal::machine(range)},
                {this, name(first, 1), 0, unit, sentence(first, 1, of, after), hal::machine(range)}} {}

    Eigen::Vector3d read() const noexcept {
        Eigen::Vector3d errors = Eigen::Vector3d::Zero();
        errors[other(0)] = pins_[0];
        errors[other(1)] = pins_[1];
        return errors;
    }
    int other(int which) const noexcept { return which + (which >= own_ ? 1 : 0); }
    std::string name(char first, int which) const {
        return std::string("e") + static_cast<char>(first + other(which)) + "0%";
    }
    // As in ISO 230-1: EA0 and the axis.
    std::string code(char first, int which) const {
        return std::string("E") + static_cast<char>(first - 'a' + 'A' + other(which)) + "0%";
    }

    const hal::In<double>* begin() const noexcept { return pins_; }
    const hal::In<double>* end() const noexcept { return pins_ + 2; }

private:
    std::string sentence(char first, int which, const char* of, const char* after) const {
        return code(first, which) + ": " + of + static_cast<char>('X' + other(which)) + after;
    }

    const int own_;
    const hal::In<double> pins_[2];
};

// The pins of one axis: its motion, its settings, and its tilt in force.
struct SquarenessAxis final : hal::Group {
    using Group::Group;
    using Ranges = SquarenessRanges;

    hal::In<double> position{this, "%-position", 0, "mu", "Commanded position of %, uncorrected."};
    hal::In<double> velocity{this, "%-velocity", 0, "mu/s", "Commanded velocity of %, uncorrected."};
    hal::In<double> pivot{this,
                          "%-pivot",
                          0,
                          "mu",
                          "Position of % at which its tilt displaces nothing.",
                          hal::machine(Ranges::places)};
    hal::In<bool> tool_follows{this, "%-tool-follows", true,
                               "The tool, or the work, turned with %; false: it was set up square.",
                               hal::machine()};
    CrossErrors tilts{this, 'a', "rad", "tilt of % about ", ".", Ranges::tilts};
    hal::Turning turning{this, tilts, tool_follows};
    hal::Effects at_once{this, hal::Effect::at_once, position, pivot, tool_follows, tilts};
    hal::Out<double> in_use[2]{in_use_of(0), in_use_of(1)};

    struct Settings {
        double pivot = 0;                                  // mu
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0
        bool tool_follows = true;

        bool operator==(const Settings& other) const noexcept {
            return std::tie(pivot, angles, tool_follows) ==
                   std::tie(other.pivot, other.angles, other.tool_follows);
        }

        Settings usable(const Settings& last, bool& bad) const noexcept {
            Settings now = *this;
            if (now == last) return now;
            Ranges::make_usable(now.pivot, Ranges::places, last.pivot, bad);
            for (int i = 0; i < 3; ++i)
                Ranges::make_usable(now.angles[i], Ranges::tilts, last.angles[i], bad);
            return now;
        }
    };

    Settings read() const noexcept { return {pivot, tilts.read(), tool_follows}; }

    void show(const Eigen::Vector3d& angles) noexcept {
        for (int i = 0; i < 2; ++i) in_use[i] = angles[tilts.other(i)];
    }

private:
    hal::Out<double> in_use_of(int which) {
        return {this, tilts.name('a', which) + "-in-use", "rad", tilts.code('a', which) + " in force."};
    }
};

// The pins of a rotary axis: its motion, its place on the machine, and the errors of that place.
struct SquarenessRotary final : hal::Group {
    SquarenessRotary(hal::Owner owner) : Group(owner), axis(owner.axis() - 'a') {}
    using Ranges = SquarenessRanges;

    const int axis;  // 0 of A
    hal::In<double> position{this, "%-position", 0, "deg", "Commanded position of %."};
    hal::In<double> velocity{this, "%-velocity", 0, "deg/s", "Commanded velocity of %."};
    hal::In<bool> reversed{this, "%-reversed", false,
                           "% turns against ISO 841, as in xyzac-trt-kins without conventional-directions.",
                           hal::machine()};
    hal::In<double> x{this,
                      "%-x-pivot",
                      0,
                      "mu",
                      "X of a point of the axis of %, all axes at 0.",
                      hal::machine(Ranges::places)};
    hal::In<double> y{this,
                      "%-y-pivot",
                      0,
                      "mu",
                      "Y of a point of the axis of %, all axes at 0.",
                      hal::machine(Ranges::places)};
    hal::In<double> z{this,
                      "%-z-pivot",
                      0,
                      "mu",
                      "Z of a point of the axis of %, all axes at 0.",
                      hal::machine(Ranges::places)};
    CrossErrors misplacement{
        this, 'x', "mu", "place of % along ", ", actual minus nominal.", Ranges::misplacements};
    CrossErrors tilts{this, 'a', "rad", "tilt of % about ", ".", Ranges::tilts};
    hal::Turning turning{this, reversed, misplacement, tilts};
    hal::Effects at_once{this, hal::Effect::at_once, position, reversed, x, y, z, misplacement, tilts};

    struct Settings {
        bool reversed = false;
        Eigen::Vector3d point = Eigen::Vector3d::Zero();   // mu
        Eigen::Vector3d error = Eigen::Vector3d::Zero();   // mu, EX0, EY0, EZ0
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0

        bool operator==(const Settings& other) const noexcept {
            return std::tie(reversed, point, error, angles) ==
                   std::tie(other.reversed, other.point, other.error, other.angles);
        }

        Settings usable(const Settings& last, bool& bad) const noexcept {
            Settings now = *this;
            if (now == last) return now;
            for (int i = 0; i < 3; ++i) {
                Ranges::make_usable(now.point[i], Ranges::places, last.point[i], bad);
                Ranges::make_usable(now.error[i], Ranges::misplacements, last.error[i], bad);
                Ranges::make_usable(now.angles[i], Ranges::tilts, last.angles[i], bad);
            }
            return now;
        }
    };

    Settings read() const noexcept { return {reversed, {x, y, z}, misplacement.read(), tilts.read()}; }
};

// The settings of a chain with U, V or W.
struct ParallelSettings final : hal::Group {
    using Group::Group;

    hal::In<bool> to_bed{this, "to-bed", false,
                         "The tilt of an axis on a parallel axis was measured against the bed; false: "
                         "against the parallel axis.",
                         hal::machine()};
    hal::In<bool> corrects{
        this, "parallel-axis-corrects", false,
        "U, V or W corrects its own travel; false: it stays, and X, Y and Z correct for it.", hal::machine()};
    hal::Turning turning{this, to_bed, corrects};
    hal::Effects at_once{this, hal::Effect::at_once, to_bed, corrects};
};

// The squareness settings of integrator and operator, and the set in force: the last one that did not
// contradict itself. An axis that the chain does not have has no pins.
struct SquarenessSettings final : hal::Group {
    SquarenessSettings(hal::Owner owner, const AxisChain& chain) : Group(owner), chain_(chain) {
        if (chain.parallel_axis()) parallel.emplace(this);
        if (chain.rotary())
            max_rotary_speed.emplace(this, "max-rotary-speed", 3600, "deg/s", "Maximum speed of A, B and C.",
                                     hal::machine(rotary_speeds));
        read();
        values_ = given_;  // the defaults, until there is a good set
        judge(given_);
    }

private:
    const AxisChain chain_;

public:
    hal::Axes<SquarenessAxis> axes{this, chain_.linear_letters()};  // by coordinate()
    hal::Axes<SquarenessRotary> rotaries{this, chain_.rotary_letters()};
    std::optional<ParallelSettings> parallel;
    std::optional<hal::In<double>> max_rotary_speed;
    hal::In<bool> axis_direction{
        this, "axis-direction", false,
        "A tilt turns only parallel axes and the tool; false: it turns all that the axis carries.",
        hal::machine()};
    hal::In<double> radial_offset{this,
                                  "radial-offset",
                                  0,
                                  "mu",
                                  "Distance of the tip from the tool's axis.",
                                  hal::machine(SquarenessRanges::tools)};
    static constexpr hal::Range directions{-1e6, 1e6};
    hal::In<double> radial_direction{this,
                                     "radial-direction",
                                     0,
                                     "deg",
                                     "Direction of the tip, from +X towards +Y.",
                                     hal::machine(directions)};
    hal::In<bool> radial_is_diameter{this, "radial-is-diameter", false,
                                     "The radial offset is given as a diameter.", hal::machine()};
    hal::Turning turning{this, axis_direction, radial_offset, radial_is_diameter};
    hal::Axes<hal::In<double>, 3> reference_tool_offset{
        this,
        "%-reference-tool-offset",
        0,
        "mu",
        "Offset in % of the tool with which the origin of the work was set.",
        hal::machine(SquarenessRanges::tools)};
    static constexpr hal::Range tilts{1e-9, 0.1}, corrections{1e-6, 100}, rates{1e-6, 10}, speeds{0, 1e5},
        settling_times{1e-3, 3600}, distances{1e-7, 0.1}, rotary_speeds{1e-3, 1e5}, reversal_rates{1e-6, 100},
        accelerations{1e-3, 1e5};
    hal::In<double> max_speed{this,
                              "max-speed",
                              0,
                              "mu/s",
                              "Maximum speed of the axes, [TRAJ]MAX_LINEAR_VELOCITY; 0 is not set.",
                              hal::must(speeds)};
    hal::In<double> max_angle{
        this, "max-angle", 0.002, "rad", "Maximum tilt, in either direction.", hal::expert(tilts)};
    hal::In<double> max_correction{this,
                                   "max-correction",
                                   1,
                                   "mu",
                                   "Maximum correction of an axis, in either direction.",
                                   hal::machine(corrections)};
    hal::In<double> max_rate{this,
                             "max-rate",
                             0.1,
                             "mu/s",
                             "Maximum rate of change of the correction that motion does not cause.",
                             hal::machine(rates)};
    hal::In<double> settling_time{this,
                                  "settling-time",
                                  10,
                                  "s",
                                  "Maximum time for which settling is true.",
                                  hal::expert(settling_times)};

    hal::In<double> reversal_distance{
        this,
        "reversal-distance",
        DirectionOfMotion::usual_distance,
        "mu",
        "Distance that an axis goes back until its direction of motion is the other one.",
        hal::expert(distances)};
    hal::In<double> reversal_rate{this,
                                  "reversal-rate",
                                  0.9,
                                  "mu/s",
                                  "Maximum rate of change of the correction where an axis turns.",
                                  hal::machine(reversal_rates)};
    hal::In<double> reversal_acceleration{this,
                                          "reversal-acceleration",
                                          DirectionOfMotion::usual_acceleration,
                                          "mu/s2",
                                          "Maximum acceleration of the correction where an axis turns.",
                                          hal::machine(accelerations)};

    hal::Effects at_once{this,
                         hal::Effect::at_once,
                         axis_direction,
                         radial_offset,
                         radial_direction,
                         radial_is_diameter,
                         reference_tool_offset,
                         max_angle,
                         max_correction};

    struct Values {
        std::array<SquarenessAxis::Settings, 4> axes;  // by coordinate()
        std::array<SquarenessRotary::Settings, 3> rotaries;
        bool axis_direction = false, to_bed = false, parallel_axis_corrects = false,
             radial_is_diameter = false;
        double radial_offset = 0, radial_direction = 0;                   // mu, deg
        Eigen::Vector3d reference_tool_offset = Eigen::Vector3d::Zero();  // mu
        double max_angle = 0, max_correction = 0, max_rate = 0, max_speed = 0, settling_time = 0;
        double max_rotary_speed = 0, reversal_distance = 0, reversal_rate = 0, reversal_acceleration = 0;

        const SquarenessAxis::Settings& of(Axis axis) const noexcept {
            return axes[static_cast<std::size_t>(coordinate(axis))];
        }
        // Within max-angle.
        Eigen::Vector3d bounded_angles(const Eigen::Vector3d& angles) const noexcept {
            return angles.unaryExpr([this](double angle) { return bounded(angle, max_angle); });
        }
        Eigen::Vector3d angles(Axis axis) const noexcept { return bounded_angles(of(axis).angles); }
        const SquarenessRotary::Settings& of_rotary(Axis axis) const noexcept {
            return rotaries[static_cast<std::size_t>(plumb::direction(axis))];
        }
        RotaryPlace place(Axis axis) const noexcept {
            const SquarenessRotary::Settings& its = of_rotary(axis);
            return {its.point, its.error, bounded_angles(its.angles)};
        }
        TiltReading reading() const noexcept {
            return axis_direction ? TiltReading::axis_direction : TiltReading::component;
        }
        TiltDatum datum() const noexcept { return to_bed ? TiltDatum::bed : TiltDatum::rail; }
        double radius() const noexcept { return radial_is_diameter ? radial_offset / 2 : radial_offset; }
        bool directed() const noexcept { return directions.contains(radial_direction); }
    };

    // Reads the settings, and puts them in force unless they contradict themselves. Returns false if
    // nothing has changed.
    bool judge() noexcept {
        const bool changed = read();
        if (changed) judge(given_);
        for (std::size_t i = 0; i < axes.size(); ++i)
            axes[i].show(values_.bounded_angles(values_.axes[i].angles));
        return changed;
    }

    const Values& values() const noexcept { return values_; }
    const Eigen::Vector3d& radial() const noexcept { return radial_; }  // mu, from the tool's axis to the tip
    bool complete() const noexcept { return values_.max_speed > 0; }    // there has been a good set
    Fault fault() const noexcept { return fault_; }
    bool any_tilt() const noexcept { return any_tilt_; }
    bool limited() const noexcept { return limited_; }  // an angle is beyond max-angle

private:
    // Returns whether a setting has changed.
    bool read() noexcept {
        bool changed = false;
        const auto take = [&changed](auto& given, const auto& pin) {
            const std::decay_t<decltype(given)> now = pin;
            changed |= !(given == now);
            given = now;
        };
        for (std::size_t i = 0; i < axes.size(); ++i) take(given_.axes[i], axes[i].read());
        for (const SquarenessRotary& its : rotaries)
            take(given_.rotaries[static_cast<std::size_t>(its.axis)], its.read());
        take(given_.axis_direction, axis_direction);
        if (parallel) take(given_.to_bed, parallel->to_bed);
        if (parallel) take(given_.parallel_axis_corrects, parallel->corrects);
        take(given_.radial_is_diameter, radial_is_diameter);
        take(given_.radial_offset, radial_offset);
        take(given_.radial_direction, radial_direction);
        for (int i = 0; i < 3; ++i) take(given_.reference_tool_offset[i], reference_tool_offset[i]);
        take(given_.max_angle, max_angle);
        take(given_.max_correction, max_correction);
        take(given_.max_rate, max_rate);
        take(given_.max_speed, max_speed);
        if (max_rotary_speed) take(given_.max_rotary_speed, *max_rotary_speed);
        take(given_.settling_time, settling_time);
        take(given_.reversal_distance, reversal_distance);
        take(given_.reversal_rate, reversal_rate);
        take(given_.reversal_acceleration, reversal_acceleration);
        return changed;
    }

    void judge(const Values& given) noexcept {
        bool bad_value = false;
        const Values usable = usable_of(given, bad_value);
        const Fault contradiction = contradiction_of(usable);
        fault_ = contradiction != Fault::none ? contradiction : bad_value ? Fault::value : Fault::none;
        if (contradiction != Fault::none) return;
        values_ = usable;
        radial_.setZero();
        if (values_.radius() != 0) {
            const double direction = std::remainder(values_.radial_direction, 360) * (pi / 180);
            radial_ = values_.radius() * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
        }
        limited_ = any_tilt_ = false;
        const auto weigh = [this](const Eigen::Vector3d& angles) {
            limited_ |= values_.bounded_angles(angles) != angles;
            any_tilt_ |= !angles.isZero(0);
        };
        for (const SquarenessAxis::Settings& its : values_.axes) weigh(its.angles);
        for (const SquarenessRotary::Settings& its : values_.rotaries) {
            weigh(its.angles);
            any_tilt_ |= !its.error.isZero(0);
        }
    }

    // An invalid value keeps its last good one.
    Values usable_of(const Values& given, bool& bad) const noexcept {
        Values now = given;
        for (std::size_t i = 0; i < now.axes.size(); ++i)
            now.axes[i] = given.axes[i].usable(values_.axes[i], bad);
        for (std::size_t i = 0; i < now.rotaries.size(); ++i)
            now.rotaries[i] = given.rotaries[i].usable(values_.rotaries[i], bad);
        if (!radial_offset.accepts(given.radial_offset)) {
            now.radial_offset = values_.radial_offset;
            now.radial_is_diameter = values_.radial_is_diameter;
            bad = true;
        }
        for (int i = 0; i < 3; ++i)
            SquarenessRanges::make_usable(now.reference_tool_offset[i], SquarenessRanges::tools,
                                          values_.reference_tool_offset[i], bad);
        return now;
    }

    Fault contradiction_of(const Values& usable) const noexcept {
        if (usable.max_speed == 0) return Fault::speed;
        if (!(max_angle.accepts(usable.max_angle) && max_correction.accepts(usable.max_correction) &&
              max_rate.accepts(usable.max_rate) && max_speed.accepts(usable.max_speed) &&
              settling_time.accepts(usable.settling_time) &&
              reversal_distance.accepts(usable.reversal_distance) &&
              (!max_rotary_speed || max_rotary_speed->accepts(usable.max_rotary_speed)) &&
              reversal_rate.accepts(usable.reversal_rate) &&
              reversal_acceleration.accepts(usable.reversal_acceleration)))
            return Fault::limit;
        if (usable.to_bed && !chain_.stacked()) return Fault::datum;
        if (usable.radius() != 0 && !usable.directed()) return Fault::direction;
        return Fault::none;
    }

    Values given_;                                      // the last time
    Values values_;                                     // the last good set
    Eigen::Vector3d radial_ = Eigen::Vector3d::Zero();  // of values_
    Fault fault_ = Fault::none;
    bool limited_ = false, any_tilt_ = false;
};

}  // namespace plumb
