// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_between_contacts.hpp"
#include "hal/component.hpp"

namespace plumb {

// How the growth goes on between contacts, as an integrator sets it, and what comes of it.
struct GrowthSettings {
    explicit GrowthSettings(hal::Component* component) : owner(component) {}

    GrowthBetweenContacts::Settings read() noexcept {
        return {follow_speed, expected_growth, unexplained_growth, contact_repeatability, temperature_growth};
    }

    bool temperature_usable() noexcept {
        const double age = temperature_age;
        return temperature_valid && age >= 0 && age <= max_temperature_age;
    }

    void show(double estimate, double sigma) noexcept {
        growth_estimate = estimate;
        growth_sigma = sigma;
    }

    hal::Component* const owner;
    hal::In<bool> follow_speed{owner, "follow-speed", true,
                               "Between contacts the growth follows the speed; else the last contact holds."};
    hal::In<double> expected_growth{owner, "expected-growth", 0.015, "mu",
                                    "Growth of the spindle to expect at 5000 rpm, about."};
    hal::In<double> unexplained_growth{owner, "unexplained-growth", 0.006, "mu",
                                       "Growth in an hour that the speed does not explain."};
    hal::In<double> contact_repeatability{owner, "contact-repeatability", 0.001, "mu",
                                          "Standard deviation of a contact by seat and blank."};
    hal::In<bool> temperature_valid{owner, "temperature-valid", false,
                                    "The growth is to follow temperature too, and it is good."};
    hal::In<double> temperature_age{owner, "temperature-age", 0, "s", "Time since temperature was read."};
    hal::In<double> max_temperature_age{owner, "max-temperature-age", 60, "s",
                                        "Age from which a temperature counts as lost."};
    hal::In<double> temperature_growth{owner, "temperature-growth", 0.003, "mu/K",
                                       "Growth with temperature to expect, about, either way."};
    hal::Out<double> growth_estimate{owner, "growth-estimate", "mu",
                                     "Growth now: by the model, or by the last contact that was believed."};
    hal::Out<double> growth_sigma{owner, "growth-sigma", "mu",
                                  "Standard deviation of growth-estimate by the model; 0 without it."};
};

}  // namespace plumb
