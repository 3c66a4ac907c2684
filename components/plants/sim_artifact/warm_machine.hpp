// SPDX-License-Identifier: GPL-2.0-or-later
// How the tip and the table of a simulated machine move as it warms. Tests of growth are scored against this
// truth, so it is never the model of one: the growth follows the heat with a lag of its own, and bends,
// pitches and stretches.
//
//     spindle   s' = (n/n0 - s) / tau          tip: -Z by spindle-growth s^1.15 (1 - cooling), and Y by a
//     share of it bed       b' = (work - b) / bed-tau      pitch about X, screws about their fixed bearings
//     column    c' = (work - c) / column-tau   tip: Z up, opposite to the spindle
//     air       air-growth (T_shop - 20)
//
// The second structure is another machine. Its spindle grows quickly and its head slowly, the opposite way;
// its column bends by the gradient between its front and its back:
//
//     fast      f' = ((n/n0)^1.6 - f) / fast-tau      tip: -Z by spindle-growth 1.25 f
//     slow      l' = ((n/n0)^1.6 - l) / slow-tau      tip: +Z by spindle-growth slow-share l
//     front     a' = (f - a) / column-tau             back  r' = (a - r) / (2 column-tau)
//     bend      a - r                                  pitch about X, and Z up by bend-growth
#pragma once

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

class WarmMachine final : public hal::Group {
public:
    using Group::Group;

    // Advances machine number `seed` by dt seconds at a spindle speed in rpm; `moving` is the part of the
    // time in which its axes move, 0 to 1.
    void step(std::int32_t seed, double speed, double moving, bool cooled, double dt) noexcept {
        seed_ = seed;
        time_ += dt;
        const double turning = std::min(std::abs(usable(speed, 1e5, 0)) / 8000, 2.0);
        spindle_.step(turning * (cooled ? 0.6 : 1), turning > 0 ? tau_turning_(seed) : tau_stopped_(seed),
                      dt);
        grown_.step(std::pow(spindle_.value(), 1.15), 120, dt);
        bed_.step(std::clamp(0.5 * moving + 0.5 * turning, 0.0, 2.0), bed_tau_(seed), dt);
        column_.step(turning, column_tau_(seed), dt);
        const double friction = std::pow(turning, 1.6) * (cooled ? 0.6 : 1);
        fast_.step(friction, fast_tau_(seed), dt);
        slow_.step(friction, slow_tau_(seed), dt);
        front_.step(fast_.value(), column_tau_(seed), dt);
        back_.step(front_.value(), 2 * column_tau_(seed), dt);
        second_ = structure_ == 1;
        constexpr double turn = 6.283185307179586;
        const double t = time_ + air_start_(seed);
        air_ = air_day_(seed) * (std::sin(turn * t / 86400) - std::sin(turn * air_start_(seed) / 86400)) +
               air_swing_(seed) * std::sin(turn * time_ / 1800);
        artifact_.step(air_ + 0.25 * bed_rise_(seed) * bed_.value(), 5400, dt);
        for (std::size_t i = 0; i < 3; ++i) replayed_[i] = usable(replay_[i], 10, replayed_[i]);
        replaying_ = use_replay_;
    }

    // The tip against its command at a place, in mm.
    Eigen::Vector3d tip_error(const Eigen::Vector3d& place) noexcept {
        if (second_ && !replaying_)
            return second_tip_error(place, {fast_.value(), slow_.value(), front_.value() - back_.value()},
                                    bed_.value(), air_);
        return tip_error(place, spindle_state(), bed_.value(), column_.value(), air_);
    }
    // The same, when the machine has worked at this speed for ever.
    Eigen::Vector3d steady_tip_error(const Eigen::Vector3d& place, double speed) noexcept {
        const double turning = std::min(std::abs(usable(speed, 1e5, 0)) / 8000, 2.0);
        if (second_ && !replaying_) {
            const double friction = std::pow(turning, 1.6);
            return second_tip_error(place, {friction, friction, 0}, 0.5 + 0.5 * turning, air_);
        }
        return tip_error(place, std::pow(turning, 1.15), 0.5 + 0.5 * turning, turning, air_);
    }
    // The centre of the table against its place on the cold machine, in mm.
    Eigen::Vector3d table_displacement() noexcept {
        return Eigen::Vector3d(0.3, 0.2, 0.5) * table_growth_(seed_) * bed_.value();
    }
    // Expansion of the artifact from its clamp.
    double artifact_strain() noexcept { return artifact_expansion_(seed_) * 1e-6 * artifact_.value(); }

    // Of the bodies at the sensors: spindle, bed, air, artifact, in degC.
    std::array<double, 4> bodies() noexcept {
        if (second_)
            return {20 + air_ + spindle_rise_(seed_) * (0.7 * fast_.value() + 0.3 * slow_.value()),
                    20 + air_ + bed_rise_(seed_) * (0.6 * bed_.value() + 0.4 * front_.value()), 20 + air_,
                    20 + artifact_.value()};
        return {20 + air_ + spindle_rise_(seed_) * spindle_.value() + 0.15 * bed_rise_(seed_) * bed_.value(),
                20 + air_ + bed_rise_(seed_) * bed_.value(), 20 + air_, 20 + artifact_.value()};
    }

    // What a compensation by the temperatures of spindle and bed has to know, for the places around `place`:
    // mm of tip error for 1 K of each.
    std::array<Eigen::Vector3d, 2> sensitivities(const Eigen::Vector3d& place) noexcept {
        const Eigen::Vector3d by_bed =
            (tip_error(place, 0, 1, 0.8, 0) - table_sensitivity()) / std::max(bed_rise_(seed_), 0.1);
        constexpr double usual = 0.75;  // of the spindle at work, where somebody measured it
        const Eigen::Vector3d by_spindle = tip_error(place, std::pow(usual, 1.15), 0, 0.1, 0) /
                                           (usual * std::max(spindle_rise_(seed_), 0.1));
        return {by_spindle, by_bed - 0.15 * by_spindle};
    }

    double cooling_time() noexcept { return std::max(tau_stopped_(seed_), 1.0); }  // s, of the spindle

private:
    Eigen::Vector3d table_sensitivity() noexcept {
        return Eigen::Vector3d(0.3, 0.2, 0.5) * table_growth_(seed_);
    }
    double spindle_state() const noexcept { return grown_.value(); }

    Eigen::Vector3d tip_error(const Eigen::Vector3d& place, double spindle, double bed, double column,
                              double air) noexcept {
        if (replaying_) return {replayed_[0], replayed_[1], -replayed_[2]};
        const double growth = spindle_growth_(seed_), side = spindle_side_(seed_);
        Eigen::Vector3d e(0.35 * side * growth * spindle, side * growth * spindle, -growth * spindle);
        e.z() += column_share_(seed_) * growth * column;
        const double pitch = pitch_(seed_) * bed;
        e.y() -= pitch * (place.z() + 300);
        e.z() += pitch * place.y();
        e.x() += x_screw_(seed_) * 1e-6 * bed * (place.x() + 400);
        e.y() += y_screw_(seed_) * 1e-6 * bed * (place.y() + 300);
        e.z() += z_screw_(seed_) * 1e-6 * bed * (place.z() + 200);
        e += air_growth_(seed_) * air * Eigen::Vector3d(0.3, 1, -0.5);
        return e;
    }

    struct Second {
        double fast, slow, bend;
    };
    Eigen::Vector3d second_tip_error(const Eigen::Vector3d& place, const Second& heat, double bed,
                                     double air) noexcept {
        const double growth = spindle_growth_(seed_), side = spindle_side_(seed_);
        const double along = growth * (1.25 * heat.fast - slow_share_(seed_) * heat.slow);
        Eigen::Vector3d e(0.2 * side * growth * heat.slow, side * growth * heat.fast, -along);
        const double pitch = pitch_(seed_) * heat.bend;
        e.y() += pitch * (place.z() + 300);
        e.z() += bend_growth_(seed_) * heat.bend - pitch * place.y();
        e.x() += x_screw_(seed_) * 1e-6 * bed * (place.x() - 400);
        e.y() += y_screw_(seed_) * 1e-6 * bed * (place.y() - 300);
        e.z() += z_screw_(seed_) * 1e-6 * bed * (place.z() + 200);
        e += air_growth_(seed_) * air * Eigen::Vector3d(-0.3, 0.5, 1);
        return e;
    }

    hal::In<std::int32_t> structure_{
        this, "structure", 0, "How the machine is built: 0, or 1 for a head that grows against the spindle."};
    Drawn fast_tau_{this, "fast-tau", 500, 300, 900, "s", "Time constant of the spindle, structure 1"};
    Drawn slow_tau_{this, "slow-tau", 7200, 5400, 10800, "s", "Time constant of the head, structure 1"};
    Drawn slow_share_{
        this, "slow-share", 0.5, 0.3, 0.7, "1", "Part of the spindle's growth that the head undoes"};
    Drawn bend_growth_{this, "bend-growth", 0.008, 0.004, 0.015, "mu", "Rise of the bent column"};
    Drawn spindle_growth_{
        this, "spindle-growth", 0.06, 0.035, 0.07, "mu", "Growth of the spindle in the end"};
    Drawn spindle_side_{this, "spindle-side", 0.3, 0.15, 0.45, "1", "Part of that growth that Y shows"};
    Drawn spindle_rise_{this, "spindle-rise", 15, 10, 22, "K", "Rise of the spindle"};
    Drawn tau_turning_{this, "tau-turning", 1500, 900, 2400, "s", "Time constant of the turning spindle"};
    Drawn tau_stopped_{this, "tau-stopped", 3600, 2700, 5400, "s", "Time constant of the spindle at rest"};
    Drawn bed_rise_{this, "bed-rise", 5, 4, 8, "K", "Rise of the bed"};
    Drawn bed_tau_{this, "bed-tau", 6000, 4500, 8000, "s", "Time constant of the bed"};
    Drawn column_share_{
        this, "column-share", 0.1, 0.05, 0.15, "1", "Part of that growth that the column undoes"};
    Drawn column_tau_{this, "column-tau", 5400, 4500, 7200, "s", "Time constant of the column"};
    Drawn pitch_{this, "pitch", 45e-6, 35e-6, 60e-6, "rad", "Pitch about X of the warm machine"};
    Drawn x_screw_{this, "x-screw-strain", 30, 0, 60, "1", "Expansion of the X screw, in parts of a million"};
    Drawn y_screw_{this, "y-screw-strain", 30, 0, 60, "1", "Expansion of the Y screw, in parts of a million"};
    Drawn z_screw_{this, "z-screw-strain", 30, 0, 60, "1", "Expansion of the Z screw, in parts of a million"};
    Drawn table_growth_{this, "table-growth", 0.01, 0.005, 0.015, "mu", "Displacement of the table's centre"};
    Drawn artifact_expansion_{this,
                              "artifact-expansion",
                              11.5,
                              1.5,
                              23,
                              "1",
                              "Expansion of the artifact in parts of a million for 1 K"};
    Drawn air_growth_{this, "air-growth", 0.001, 0.0005, 0.002, "mu/K", "Growth with the air"};
    Drawn air_day_{this, "air-day", 1.5, 0.5, 2, "K", "Amplitude of the air over the day"};
    Drawn air_swing_{this, "air-swing", 0.3, 0.2, 0.6, "K", "Amplitude of the air over half an hour"};
    Drawn air_start_{this, "air-start", 10000, 1, 86400, "s", "Time of the day at the start"};
    hal::In<bool> use_replay_{this, "use-replay", false,
                              "The replay pins are the growth, instead of the above."};
    hal::Axes<hal::In<double>, 3> replay_{this, "replay-%", 0.0, "mu",
                                          "Growth along %; in Z towards the work."};

    std::int32_t seed_ = 0;
    double time_ = 0, air_ = 0;
    bool replaying_ = false, second_ = false;
    FirstOrderLag spindle_, grown_, bed_, column_, artifact_, fast_, slow_, front_, back_;
    std::array<double, 3> replayed_{};
};

}  // namespace plumb
