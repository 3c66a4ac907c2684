// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_rejection.hpp"
#include "components/math/contact/growth_authority.hpp"
#include "components/math/contact/growth_estimator.hpp"
#include "components/math/contact/plausibility_gate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace plumb {

// From compared contacts to the growth that may be applied.
class GrowthFromContacts {
public:
    struct Settings {
        GrowthBetweenContacts::Settings between;
        PlausibilityGate::Settings gate;
        double max_correction = 0.1;  // mu, from the last accepted growth
        double hold_time = 1800;      // s without a contact that counted, after which the offset returns to 0
        double work_tolerance = 0.01;  // mu

        bool valid() const noexcept {
            return hold_time > 0 && hold_time <= 1e6 && work_tolerance > 0 && work_tolerance <= 1e3 &&
                   max_correction >= 0 && max_correction <= 1e3 && gate.valid() && between.valid();
        }
        GrowthEstimator::Settings estimator() const noexcept {
            return {between, gate.floor, gate.cap, gate.max_growth_rate};
        }
    };

    struct Reading : GrowthEstimator::Reading {
        std::int32_t tool = 0;
    };

    // The machine in a period.
    struct Machine {
        double speed = 0;         // rpm
        double temperature = 20;  // degC
        bool temperature_valid = false;
        double reference_sigma = 0;  // mu, of all gauges together
        bool load_valid = true;
        bool barren = false;  // contacts should have come, and none has counted
        bool in_cycle = false;
        bool accepted = false;  // a contact, in this period
        bool origin = false;    // it has changed, and nobody knows why
    };

    // Once a period of dt > 0, in s: predict() before its contact is judged, apply() after it.
    void predict(const Machine& machine, const Settings& settings, double dt) noexcept {
        gate_.step(dt);
        estimator_.step(machine.speed, machine.temperature, machine.temperature_valid, settings.estimator(),
                        dt);
    }
    void apply(const Machine& machine, const Settings& settings, double dt) noexcept {
        if (known())
            authority_.step(evidence(machine, settings),
                            {settings.gate.floor, settings.hold_time, settings.work_tolerance}, dt);
    }

    // Whether a contact that could be compared counts as growth.
    Rejection judge(const Reading& reading, const Settings& settings) noexcept {
        Reading r = reading;
        const double before = r.growth - estimator_.displaced(r.gauge, r.feed);
        if (!(std::abs(before - gate_.growth()) <= settings.max_correction)) return Rejection::too_large;
        const bool admitted = gate_.admits(before, r.tool, r.cycle, settings.gate);
        r.confirmed = admitted && std::abs(before - gate_.growth()) > gate_.spread(settings.gate);
        switch (estimator_.judge(r, settings.estimator())) {
            case GrowthEstimator::Verdict::withdrawn: return Rejection::withdrawn;
            case GrowthEstimator::Verdict::claim:
                return admitted ? Rejection::unconfirmed : Rejection::beyond_gate;
            default: gate_.accept(r.growth - estimator_.displaced(r.gauge, r.feed)); return Rejection::none;
        }
    }

    // Of a learning cycle: `first` of a new reference, or compared with the mean so far.
    Rejection compare(const Reading& r, const Settings& settings) noexcept {
        if (!(std::abs(r.growth - gate_.growth()) <= settings.max_correction)) return Rejection::too_large;
        return gate_.admits(r.growth, r.tool, r.cycle, settings.gate) ? Rejection::none
                                                                      : Rejection::beyond_gate;
    }
    void learn(double growth, double sigma, bool first, const Settings& settings) noexcept {
        estimator_.learn(growth, sigma, first, settings.estimator());
        gate_.accept(growth);
    }
    void renew_gauges() noexcept { estimator_.renew_gauges(); }

    // A contact was accepted; nothing has been forgotten since.
    bool known() const noexcept { return gate_.known() && estimator_.known(); }
    // The growth now, by the model or the last accepted contact, and its standard deviation, in mu.
    double growth(const Settings& settings) const noexcept {
        return settings.between.by_speed ? estimator_.growth() : gate_.growth();
    }
    double sigma() const noexcept { return estimator_.sigma(); }
    double gate(const Settings& settings) const noexcept { return gate_.spread(settings.gate); }  // mu
    const GrowthEstimator& estimator() const noexcept { return estimator_; }
    const GrowthAuthority& authority() const noexcept { return authority_; }

    // A shift that matters to the work.
    Shift shift(const Settings& settings) const noexcept {
        return std::abs(estimator_.shift_size()) > 0.5 * settings.work_tolerance ? estimator_.shift()
                                                                                 : Shift::none;
    }
    void shift_is_growth() noexcept {
        if (estimator_.shift() == Shift::none) return;
        estimator_.shift_is_growth();
        gate_.accept(estimator_.growth());
        answered_ = true;
    }
    void shift_is_corrected() noexcept { estimator_.shift_is_corrected(); }

    // The growth counts from another origin: all growths are lower by -distance, in mu.
    void displace(double distance) noexcept {
        estimator_.displace(distance);
        gate_.displace(distance);
        answered_ = true;
    }

    // Growth that a contact of a gauge may show, mu: about this mean, with this standard deviation.
    struct Expected {
        double mean, sigma;
    };
    Expected expected(const Reading& r, const Settings& settings) const noexcept {
        if (!known()) return {0, settings.gate.cap / 2};
        const auto its = estimator_.expected(r);
        return {its.mean, std::hypot(std::sqrt(its.variance), r.noise, gate(settings) / 3)};
    }

    void forget() noexcept {
        gate_.forget();
        estimator_.forget();
        authority_.forget();
    }

private:
    GrowthAuthority::Evidence evidence(const Machine& machine, const Settings& settings) noexcept {
        GrowthAuthority::Evidence e;
        e.held = settings.between.by_speed ? estimator_.held() : gate_.growth();
        e.predicted = growth(settings);
        e.sigma = estimator_.sigma();
        e.apart = estimator_.apart(settings.estimator());
        e.possible = estimator_.possible();
        if (!settings.between.by_speed) e.possible = {{{1, e.predicted, estimator_.sigma()}}};
        e.since_sigma = estimator_.since_sigma();
        e.spread = gate_.spread(settings.gate);
        e.reference_sigma = machine.reference_sigma;
        e.predicts = settings.between.by_speed;
        e.load_valid = machine.load_valid;
        e.barren = machine.barren;
        e.compared = estimator_.accepted() > 0;
        e.program_event = estimator_.program_event();
        e.shift = shift(settings);
        e.origin = machine.origin;
        e.in_cycle = machine.in_cycle;
        e.accepted = machine.accepted || std::exchange(answered_, false);
        return e;
    }

    PlausibilityGate gate_;
    GrowthEstimator estimator_;
    GrowthAuthority authority_;
    bool answered_ = false;  // a shift is growth, since the last period
};

}  // namespace plumb
