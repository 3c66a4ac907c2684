// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

// How far the growth can be trusted, and why not.
struct TrustReport : hal::Group {
    using Group::Group;

    // `offset`: in force; `reason`: of a doubt.
    void show(const GrowthByContact& measured, const GrowthByContact::Settings& settings, double estimate,
              double offset, Doubt reason) noexcept {
        const bool known = measured.known();
        authority = known ? measured.filter().part() : 0;
        sigma_ = known ? std::hypot(std::hypot(measured.filter().sigma(settings.growth), measured.filter().apart()),
                                    estimate - offset, measured.learning_growth())
                       : 0;
        offset_sigma = sigma_;
        contact_age = known ? measured.filter().age() : 0;
        reference_sigma = measured.reference_sigma();
        doubt = reason != Doubt::none;
    }

    double sigma() const noexcept { return sigma_; }  // of the offset, mu

    hal::Out<double> authority{this, "authority", "1", "Part of the growth that is applied, 0 to 1."};
    hal::Out<double> offset_sigma{this, "offset-sigma", "mu",
                                  "Error of the offset to expect, as a standard deviation."};
    hal::Out<double> contact_age{this, "contact-age", "s",
                                 "Time since contacts should have counted, and none has; 0 while they do."};
    hal::Out<double> reference_sigma{this, "reference-sigma", "mu",
                                     "Standard deviation of the reference, by all its contacts together."};
    hal::Out<bool> doubt{this, "doubt", "The growth may be wrong; status-code gives the reason."};

private:
    double sigma_ = 0;
};

}  // namespace plumb
