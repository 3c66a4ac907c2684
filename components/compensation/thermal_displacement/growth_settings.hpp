// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_filter.hpp"
#include "hal/component.hpp"

namespace plumb {

// The growth between contacts: its settings by an integrator, and its estimate.
struct GrowthSettings : hal::Group {
    using Group::Group;

    void read(GrowthFilter::Settings& s, hal::SettingsReader& setting) noexcept {
        s.hold_time = setting(hold_time);
        s.work_tolerance = setting(work_tolerance);
        s.by_speed = follow_speed;
        s.expected_growth = setting(expected_growth);
        s.unexplained_growth = setting(unexplained_growth);
        s.repeatability = setting(contact_repeatability);
        s.temperature_growth = setting(temperature_growth);
    }

    bool temperature_usable() noexcept {
        const double age = temperature_age;
        return temperature_valid && age >= 0 && age <= max_temperature_age;
    }

    void show(double estimate, double sigma) noexcept {
        growth_estimate = estimate;
        growth_sigma = sigma;
    }

    static constexpr hal::Range growths{1e-6, 1}, unexplained{0, 1}, scatters{1e-5, 1}, per_kelvin{0, 0.1},
        ages{0, 1e6}, times{1e-3, 1e6}, errors{1e-9, 1e3};

    hal::In<bool> follow_speed{this, "follow-speed", true,
                               "Between contacts the growth follows the speed; else the last contact holds.",
                               hal::machine()};
    hal::In<double> expected_growth{this,
                                    "expected-growth",
                                    0.015,
                                    "mu",
                                    "Growth of the spindle to expect at 5000 rpm, roughly.",
                                    hal::machine(growths)};
    hal::In<double> unexplained_growth{this,
                                       "unexplained-growth",
                                       0.006,
                                       "mu",
                                       "Growth in an hour that the speed does not explain.",
                                       hal::machine(unexplained)};
    hal::In<double> contact_repeatability{this,
                                          "contact-repeatability",
                                          0.001,
                                          "mu",
                                          "Standard deviation of a contact by seat and blank.",
                                          hal::machine(scatters)};
    hal::In<bool> temperature_valid{this, "temperature-valid", false,
                                    "The growth is to follow temperature too, and it is good."};
    hal::In<double> temperature_age{this, "temperature-age", 0, "s", "Time since temperature was read."};
    hal::In<double> max_temperature_age{this,
                                        "max-temperature-age",
                                        60,
                                        "s",
                                        "Age from which a temperature counts as lost.",
                                        hal::expert(ages)};
    hal::In<double> temperature_growth{this,
                                       "temperature-growth",
                                       0.003,
                                       "mu/K",
                                       "Growth with temperature to expect either way, roughly.",
                                       hal::expert(per_kelvin)};
    hal::In<double> hold_time{this,
                              "hold-time",
                              1800,
                              "s",
                              "Time without a contact that counts, after which the offset returns to 0.",
                              hal::expert(times)};
    hal::In<double> work_tolerance{
        this,
        "work-tolerance",
        0.01,
        "mu",
        "Error of the work along Z that matters: a larger one to expect is a doubt, half of it a shift.",
        hal::machine(errors)};
    hal::Out<double> growth_estimate{this, "growth-estimate", "mu",
                                     "Growth now: by the model, or by the last accepted contact."};
    hal::Out<double> growth_sigma{this, "growth-sigma", "mu", "Standard deviation of growth-estimate."};
};

}  // namespace plumb
