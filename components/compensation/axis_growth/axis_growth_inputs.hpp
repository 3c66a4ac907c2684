// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/growth/growth_law.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/turning.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb::axis_growth {

struct Settings {
    GrowthLaw law;
    SpindleDrive::Settings drive;
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();                            // mu
    Eigen::Vector3d travel = Eigen::Vector3d::Zero();                           // mu
    GrowthLaw::PerSensor growth_sigma = GrowthLaw::PerSensor::Zero();           // mu/K
    Eigen::Vector3d speed_sigma = Eigen::Vector3d::Zero();                      // mu
    GrowthLaw::Temperatures low = GrowthLaw::Temperatures::Zero(), high = low;  // K, of the rises
    double smoothing = 0, max_age = 0, hold_time = 0;                           // s
    double harmless = 0, max_offset = 0;                                        // mu
    double max_rate = 0, max_speed = 0;                                         // mu/s

    bool in_range = false;

    bool valid() const noexcept { return in_range && (low.array() <= high.array()).all(); }
};

// The law of this machine. plumb-growth(1) prints these lines.
struct LawPins : hal::Group {
    using Group::Group;

    static constexpr hal::Range growths{-1, 1}, slopes{-1e-4, 1e-4}, temperatures{-500, 500},
        places{-1e6, 1e6};
    static constexpr hal::Range rises{-600, 600}, numbers{-1, GrowthLaw::sensors - 1};
    static constexpr hal::Range distances{0, 1e5}, sigmas{0, 1}, speeds{1, 1e6}, exponents{0.1, 4},
        times{1, 1e6};

    struct Sensor : hal::Group {
        Sensor(hal::Owner owner, const std::string& number)
            : Group(owner),
              growth{
                  this,   "%-growth-" + number, 0.0, "mu/K", "Growth of % by the rise of this temperature.",
                  growths},
              growth_sigma{
                  this,  "%-growth-sigma-" + number, 0.0, "mu/K", "Standard uncertainty of that growth.",
                  sigmas},
              slope{this,  "%-slope-" + number, 0.0, "1/K", "Growth of % by that rise, per mu of travel.",
                    slopes},
              turning{this, growth, slope},
              at_once{this, hal::Effect::at_once, growth, growth_sigma, slope} {}
        hal::Axes<hal::In<double>, 3> growth, growth_sigma, slope;
        hal::Turning turning;
        hal::Effects at_once;
    };

    hal::In<std::int32_t> structure{
        this, "structure", -1,
        "Sensor of the structure: the rises of the others are counted from it; -1 for none.", numbers};

    Sensor sensor[GrowthLaw::sensors]{{this, "0"}, {this, "1"}, {this, "2"}, {this, "3"}};
    hal::Row<hal::In<double>, GrowthLaw::sensors> reference{
        this, "reference", 20.0, "degC", "This temperature on the cold machine.", temperatures};
    hal::Row<hal::In<double>, GrowthLaw::sensors> low{
        this, "rise-low", -600.0, "K", "Lowest rise of this temperature in the growth test.", rises};
    hal::Row<hal::In<double>, GrowthLaw::sensors> high{
        this, "rise-high", 600.0, "K", "Highest rise of this temperature in the test.", rises};
    hal::Axes<hal::In<double>, 3> pivot{
        this, "%-pivot", 0.0, "mu", "Position of % where its slope displaces nothing.", places};
    hal::Axes<hal::In<double>, 3> travel{
        this, "%-travel", 100.0, "mu", "Distance of the work from %-pivot, at most.", distances};
    hal::Axes<hal::In<double>, 3> by_speed{
        this, "%-speed-growth", 0.0, "mu", "Growth of % in the end at reference-speed.", growths};
    hal::Turning turning{this, by_speed};
    hal::Axes<hal::In<double>, 3> speed_sigma{
        this, "%-speed-sigma", 0.0, "mu", "Standard uncertainty of that growth.", sigmas};
    hal::Axes<hal::In<double>, 3> sigma{
        this, "%-sigma", 0.002, "mu", "Standard uncertainty of % with the temperatures of its zero.", sigmas};
    hal::In<double> reference_speed{this,  "reference-speed", 5000, "rpm", "Speed of the speed-growth.",
                                    speeds};
    hal::In<double> exponent{this,     "speed-exponent", 1.7, "1", "Exponent of the speed in the growth.",
                             exponents};
    hal::In<double> turning_time{this, "turning-time", 600, "s", "Time constant of the turning spindle.",
                                 times};
    hal::In<double> stopped_time{this, "stopped-time", 2400, "s", "Time constant of the spindle at rest.",
                                 times};

    hal::Effects at_once{this,     hal::Effect::at_once, structure, reference,       low,     high, pivot,
                         by_speed, speed_sigma,          sigma,     reference_speed, exponent};

    void read(Settings& s, hal::SettingsReader& read) noexcept {
        s.law.structure = read(structure);
        for (int i = 0; i < GrowthLaw::sensors; ++i) {
            const auto row = static_cast<std::size_t>(i);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                s.law.growth(static_cast<int>(axis), i) = read(sensor[i].growth[axis]);
                s.law.slope(static_cast<int>(axis), i) = read(sensor[i].slope[axis]);
                s.growth_sigma(static_cast<int>(axis), i) = read(sensor[i].growth_sigma[axis]);
            }
            s.law.reference[i] = read(reference[row]);
            s.low[i] = read(low[row]);
            s.high[i] = read(high[row]);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int k = static_cast<int>(axis);
            s.law.pivot[k] = read(pivot[axis]);
            s.law.by_speed[k] = read(by_speed[axis]);
            s.speed_sigma[k] = read(speed_sigma[axis]);
            s.sigma[k] = read(sigma[axis]);
            s.travel[k] = read(travel[axis]);
        }
        s.drive.reference_speed = read(reference_speed);
        s.drive.exponent = read(exponent);
        s.drive.turning_time = read(turning_time);
        s.drive.stopped_time = read(stopped_time);
    }
};

// The temperatures, each with its doubts: value, valid, age. An invalid one keeps its last good value.
class Sensors : public hal::Group {
public:
    using Group::Group;

    // `used`: the law reads this sensor.
    template <class Used>
    void step(const Settings& settings, Used used, double dt) noexcept {
        bool good = true, known = true;
        for (int i = 0; i < GrowthLaw::sensors; ++i) {
            const auto row = static_cast<std::size_t>(i);
            const double now = value_[row], age = age_[row];
            const bool fine = valid_[row] && now > -100 && now < 500 && age >= 0 && age <= settings.max_age;
            if (fine && !known_[row]) lag_[row].set(now);
            if (fine) lag_[row].step(now, settings.smoothing, dt);
            known_[row] |= fine;
            smooth_[i] = known_[row] ? lag_[row].value() : settings.law.reference[i];
            if (!used(i)) continue;
            good &= fine;
            known &= known_[row];
        }
        rises_ = settings.law.rises(smooth_);
        all_known_ = known;
        lost_ = good ? 0 : std::min(lost_ + dt, 1e9);
    }

    const GrowthLaw::Temperatures& values() const noexcept { return smooth_; }  // degC
    const GrowthLaw::Temperatures& rises() const noexcept { return rises_; }    // K, as the law counts them
    bool all_known() const noexcept { return all_known_; }  // each that the law reads was valid once
    double lost() const noexcept { return lost_; }          // s since one of them was valid

private:
    static constexpr std::size_t count = GrowthLaw::sensors;
    hal::Row<hal::In<double>, count> value_{this, "temperature", 20.0, "degC", "Temperature of this sensor."};
    hal::Effects at_once_{this, hal::Effect::at_once, value_};
    hal::Row<hal::In<bool>, count> valid_{this, "temperature-valid", true,
                                          "The sensor reports that it is valid."};
    hal::Row<hal::In<double>, count> age_{this, "temperature-age", 0.0, "s",
                                          "Time since the sensor was read."};
    std::array<FirstOrderLag, count> lag_;
    std::array<bool, count> known_{};
    GrowthLaw::Temperatures smooth_ = GrowthLaw::Temperatures::Zero(), rises_ = smooth_;
    double lost_ = 0;
    bool all_known_ = false;
};

}  // namespace plumb::axis_growth
