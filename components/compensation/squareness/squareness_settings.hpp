// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_axis.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/tilted_branch.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// How the machine is out of square, as an integrator and the operator set it, and what of it is in force: the
// last set of settings that did not contradict itself.
struct SquarenessSettings {
    struct Values {
        std::array<SquarenessAxis::Settings, 6> axes;
        TiltReading reading = TiltReading::component;
        TiltDatum datum = TiltDatum::rail;
        double radius = 0;                                 // mu, of the tool
        Eigen::Vector3d radial = Eigen::Vector3d::Zero();  // mu, where that lies
        Eigen::Vector3d reference =
            Eigen::Vector3d::Zero();  // mu, the reference tool from gauge point to tip
        double max_angle = 0, max_correction = 0, max_rate = 0, max_speed = 0;
        double settling_time = 0;  // s

        const SquarenessAxis::Settings& of(Axis axis) const noexcept {
            return axes[static_cast<std::size_t>(axis)];
        }
        Eigen::Vector3d angles(Axis axis) const noexcept {
            return of(axis).angles.unaryExpr([this](double angle) { return bounded(angle, max_angle); });
        }
    };
    enum class Wrong { nothing, value, limit, axis, datum, direction, speed = 8 };  // fault-code - 2

    explicit SquarenessSettings(hal::Component* component) : owner(component) {}

    // Takes over what is there, unless it contradicts itself.  Whether anything may have changed.
    bool judge(const AxisChain& chain) noexcept {
        const Given given = read();
        const bool changed = !(given == given_);
        if (changed) {
            given_ = given;
            judge(given, chain);
        }
        for (std::size_t i = 0; i < 6; ++i) axes[i].show(in_use_[i]);
        return changed;
    }

    const Values& values() const noexcept { return values_; }
    bool complete() const noexcept { return values_.max_speed > 0; }  // there has been a good set
    Wrong wrong() const noexcept { return wrong_; }
    bool limited() const noexcept { return limited_; }  // an angle is beyond max-angle

    static constexpr double longest = 1e4;  // mu, of a tool

    hal::Component* const owner;
    SquarenessAxis axes[6]{{owner, 'x'}, {owner, 'y'}, {owner, 'z'},
                           {owner, 'u'}, {owner, 'v'}, {owner, 'w'}};
    hal::In<bool> axis_direction{
        owner, "axis-direction", false,
        "A tilt turns the axes parallel to it alone, and the tool; else all behind it."};
    hal::In<bool> to_bed{owner, "to-bed", false,
                         "The tilt of an axis on a parallel one was measured to the bed; else to that one."};
    hal::In<double> radial_offset{owner, "radial-offset", 0, "mu",
                                  "Distance of the tip from the tool's axis."};
    hal::In<double> radial_direction{owner, "radial-direction", 0, "deg",
                                     "Where the tip is, from +X towards +Y."};
    hal::In<bool> radial_is_diameter{owner, "radial-is-diameter", false,
                                     "The radial offset is given as a diameter."};
    hal::In<double> reference_tool_offset[3]{{owner, "x-reference-tool-offset", 0, "mu",
                                              "Offset of the tool the work's origin was set with, in X."},
                                             {owner, "y-reference-tool-offset", 0, "mu", "Likewise in Y."},
                                             {owner, "z-reference-tool-offset", 0, "mu", "Likewise in Z."}};
    hal::In<double> max_angle{owner, "max-angle", 0.002, "rad", "Largest tilt either way."};
    hal::In<double> max_correction{owner, "max-correction", 1, "mu",
                                   "Largest correction of an axis either way."};
    hal::In<double> max_rate{owner, "max-rate", 0.1, "mu/s",
                             "Fastest change of the correction that motion did not cause."};
    hal::In<double> max_speed{owner, "max-speed", 0, "mu/s",
                              "Maximum speed of the axes, [TRAJ]MAX_LINEAR_VELOCITY; 0 is not set."};
    hal::In<double> settling_time{owner, "settling-time", 10, "s",
                                  "Maximum time for which settling is true."};

private:
    // The pins as they are.
    struct Given {
        std::array<SquarenessAxis::Settings, 6> axes;
        bool axis_direction = false, to_bed = false, is_diameter = false;
        double radial_offset = 0, radial_direction = 0;
        Eigen::Vector3d reference_offset = Eigen::Vector3d::Zero();
        double max_angle = 0, max_correction = 0, max_rate = 0, max_speed = 0, settling_time = 0;

        bool operator==(const Given& other) const noexcept {
            return axes == other.axes && axis_direction == other.axis_direction && to_bed == other.to_bed &&
                   is_diameter == other.is_diameter && radial_offset == other.radial_offset &&
                   radial_direction == other.radial_direction && reference_offset == other.reference_offset &&
                   max_angle == other.max_angle && max_correction == other.max_correction &&
                   max_rate == other.max_rate && max_speed == other.max_speed &&
                   settling_time == other.settling_time;
        }
    };

    Given read() const noexcept {
        Given given;
        for (std::size_t i = 0; i < given.axes.size(); ++i) given.axes[i] = axes[i].read();
        given.axis_direction = axis_direction;
        given.to_bed = to_bed;
        given.is_diameter = radial_is_diameter;
        given.radial_offset = radial_offset;
        given.radial_direction = radial_direction;
        for (int i = 0; i < 3; ++i) given.reference_offset[i] = reference_tool_offset[i];
        given.max_angle = max_angle;
        given.max_correction = max_correction;
        given.max_rate = max_rate;
        given.max_speed = max_speed;
        given.settling_time = settling_time;
        return given;
    }

    void judge(const Given& given, const AxisChain& chain) noexcept {
        bool bad_value = false;
        const Values usable = usable_of(given, bad_value);
        const Wrong contradiction = contradiction_of(usable, given, chain);
        wrong_ = contradiction != Wrong::nothing ? contradiction : bad_value ? Wrong::value : Wrong::nothing;
        if (contradiction != Wrong::nothing) return;
        values_ = usable;
        limited_ = false;
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W}) {
            Eigen::Vector3d& in_use = in_use_[static_cast<std::size_t>(axis)];
            in_use = values_.angles(axis);
            limited_ |= in_use != values_.of(axis).angles;
        }
    }

    // A value that cannot be keeps what it was.
    Values usable_of(const Given& given, bool& bad) const noexcept {
        Values now;
        for (std::size_t i = 0; i < now.axes.size(); ++i)
            now.axes[i] = SquarenessAxis::usable_of(given.axes[i], values_.axes[i], bad);
        now.reading = given.axis_direction ? TiltReading::axis_direction : TiltReading::component;
        now.datum = given.to_bed ? TiltDatum::bed : TiltDatum::rail;
        const bool good_radius = std::abs(given.radial_offset) <= longest;
        bad |= !good_radius;
        now.radius = !good_radius        ? values_.radius
                     : given.is_diameter ? given.radial_offset / 2
                                         : given.radial_offset;
        if (now.radius != 0 && directed(given)) {
            const double direction = std::remainder(given.radial_direction, 360) * (pi / 180);
            now.radial = now.radius * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
        }
        for (int i = 0; i < 3; ++i) {
            const bool good = std::abs(given.reference_offset[i]) <= longest;
            now.reference[i] = good ? -given.reference_offset[i] : values_.reference[i];
            bad |= !good;
        }
        now.max_angle = given.max_angle;
        now.max_correction = given.max_correction;
        now.max_rate = given.max_rate;
        now.max_speed = given.max_speed;
        now.settling_time = given.settling_time;
        return now;
    }

    static bool directed(const Given& given) noexcept { return std::abs(given.radial_direction) <= 1e6; }

    static Wrong contradiction_of(const Values& usable, const Given& given, const AxisChain& chain) noexcept {
        if (usable.max_speed == 0) return Wrong::speed;
        const auto within = [](double x, double most) { return x > 0 && x <= most; };
        if (!(within(usable.max_angle, 0.1) && within(usable.max_correction, 100) &&
              within(usable.max_rate, 10) && within(usable.max_speed, 1e5) &&
              within(usable.settling_time, 3600)))
            return Wrong::limit;
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
            if (!chain.has(axis) && !usable.of(axis).names_nothing()) return Wrong::axis;
        if (usable.datum == TiltDatum::bed && !chain.stacked()) return Wrong::datum;
        if (usable.radius != 0 && !directed(given)) return Wrong::direction;
        return Wrong::nothing;
    }

    Given given_;    // the last time
    Values values_;  // the last good set
    std::array<Eigen::Vector3d, 6> in_use_{
        Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
        Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};  // rad, EA0 EB0 EC0
    Wrong wrong_ = Wrong::nothing;
    bool limited_ = false;
};

}  // namespace plumb
