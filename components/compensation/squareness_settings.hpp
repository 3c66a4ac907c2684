// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness_axis.hpp"
#include "components/math/axis_chain.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/tilted_branch.hpp"
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
        Eigen::Vector3d radial = Eigen::Vector3d::Zero();  // mu, of the tool
        Eigen::Vector3d reference =
            Eigen::Vector3d::Zero();  // mu, the reference tool from gauge point to tip
        double max_angle = 0, max_correction = 0, max_rate = 0, max_speed = 0;

        const SquarenessAxis::Settings& of(Axis axis) const noexcept {
            return axes[static_cast<std::size_t>(axis)];
        }
        Eigen::Vector3d angles(Axis axis) const noexcept {
            return of(axis).angles.unaryExpr([this](double angle) { return bounded(angle, max_angle); });
        }
        bool operator==(const Values& other) const noexcept {
            return axes == other.axes && reading == other.reading && datum == other.datum &&
                   radial == other.radial && reference == other.reference && max_angle == other.max_angle &&
                   max_correction == other.max_correction;
        }
    };
    enum class Wrong { nothing, value, limit, axis, datum, direction };

    explicit SquarenessSettings(hal::Component* component) : owner(component) {}

    // Takes over what is there, unless it contradicts itself.
    void judge(const AxisChain& chain) noexcept {
        bool bad_value = false;
        Values given = read(bad_value);
        const Wrong contradiction = contradiction_of(given, chain);
        if (contradiction == Wrong::nothing) values_ = given;
        wrong_ = contradiction != Wrong::nothing ? contradiction : bad_value ? Wrong::value : Wrong::nothing;
        limited_ = false;
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W}) {
            const Eigen::Vector3d in_use = values_.angles(axis);
            limited_ |= in_use != values_.of(axis).angles;
            axes[static_cast<std::size_t>(axis)].show(in_use);
        }
    }

    const Values& values() const noexcept { return values_; }
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
    hal::In<double> max_speed{owner, "max-speed", 1000, "mu/s",
                              "A position that changes faster did not move: it is ramped."};

private:
    Values read(bool& bad) noexcept {
        Values now;
        for (std::size_t i = 0; i < now.axes.size(); ++i) now.axes[i] = axes[i].read(values_.axes[i], bad);
        now.reading = axis_direction ? TiltReading::axis_direction : TiltReading::component;
        now.datum = to_bed ? TiltDatum::bed : TiltDatum::rail;
        radius_ = usable_radius(bad);
        const double degrees = radial_direction;
        const double direction = std::remainder(degrees, 360) * (3.14159265358979323846 / 180);
        directed_ = std::abs(degrees) <= 1e6;
        if (directed_) now.radial = radius_ * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
        for (int i = 0; i < 3; ++i) {
            const double offset = reference_tool_offset[i];
            const bool good = std::abs(offset) <= longest;
            now.reference[i] = good ? -offset : values_.reference[i];
            bad |= !good;
        }
        now.max_angle = max_angle;
        now.max_correction = max_correction;
        now.max_rate = max_rate;
        now.max_speed = max_speed;
        return now;
    }

    double usable_radius(bool& bad) noexcept {
        const double offset = radial_offset;
        const bool good = std::abs(offset) <= longest;
        bad |= !good;
        if (!good) return radius_;
        return radial_is_diameter ? offset / 2 : offset;
    }

    Wrong contradiction_of(const Values& given, const AxisChain& chain) const noexcept {
        const auto within = [](double x, double most) { return x > 0 && x <= most; };
        if (!(within(given.max_angle, 0.1) && within(given.max_correction, 100) &&
              within(given.max_rate, 10) && within(given.max_speed, 1e5)))
            return Wrong::limit;
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
            if (!chain.has(axis) && !given.of(axis).names_nothing()) return Wrong::axis;
        if (given.datum == TiltDatum::bed && !chain.work.stacked() && !chain.tool.stacked())
            return Wrong::datum;
        if (radius_ != 0 && !directed_) return Wrong::direction;
        return Wrong::nothing;
    }

    Values values_;
    double radius_ = 0;     // mu, the last that could be
    bool directed_ = true;  // the radial offset has a direction
    Wrong wrong_ = Wrong::nothing;
    bool limited_ = false;
};

}  // namespace plumb
