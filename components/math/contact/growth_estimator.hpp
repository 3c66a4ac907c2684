// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "components/math/contact/growth_between_contacts.hpp"
#include "components/math/contact/program_lock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace plumb {

// The growth by contacts of several gauges, each of which may be wrong. A contact is taken at once if it lies
// within three standard deviations of the prediction and changes the growth by less than `floor`. Another
// one is a claim, which the next contacts decide. One within `floor` counts meanwhile as if it lay at three
// standard deviations (P. J. Huber, Ann. Math. Statist. 35, 1964); one beyond counts for nothing.
//
//     step       another contact agrees with the claim: beyond `floor` one of another tool, if the
//                reference has one and the growth was known. The growth follows them whole.
//     outlier    the next contact of this gauge is as predicted. The claim is dropped.
//     contradiction    the gauge claims again and again, and no other agrees: its reference is off by less
//                than `floor`, or the gauge is withdrawn.
//     event of the program    its contacts move with the offset (ProgramLock): it is withdrawn.
//
// A withdrawn gauge counts for nothing until it is learnt again. Contacts that scatter more than their noise
// explains weigh less, and innovations that are larger than expected widen sigma().
class GrowthEstimator {
public:
    struct Settings {
        GrowthBetweenContacts::Settings between;
        double floor = 0.015;  // mu, largest change by one contact that no other confirms
        double cap = 0.06;     // mu, standard deviation of a growth of which nothing is known
    };

    struct Reading {
        double growth = 0, noise = 0;  // mu
        double reference_sigma = 0;    // mu
        double applied_offset = 0;     // mu
        double step = 0;               // mu, by which the offset is displaced on purpose
        std::int32_t gauge = -1;       // index of the reference
        std::int32_t tool = 0, cycle = 0;
        bool other_tools = false;  // the reference has gauges of other tools, not withdrawn
        bool admitted = true;      // the gate lets it in
        bool confirmed = false;    // the gate does so after contacts that confirm it
    };

    enum class Verdict { accepted, claim, withdrawn };
    enum class Withdrawal : std::int8_t { none, program, contradiction };

    void step(double speed, double temperature, bool temperature_valid, const Settings& settings,
              double dt) noexcept {
        model_.step(speed, temperature, temperature_valid, settings.between, dt);
        if (!model_.known()) known_ = false;
        predict();
    }

    Verdict judge(const Reading& r, const Settings& settings) noexcept {
        const Verdict verdict = decide(r, settings);
        sum_up();
        return verdict;
    }

    // A contact of a learning cycle. `first`: of a new reference, to which the growth counts from now on.
    void learn(double growth, double sigma, bool first, const Settings& settings) noexcept {
        model_.correct(growth, sigma, {}, !first, settings.between);
        accepted_ = 0;
        finish_taking();
    }

    // All gauges have new references; the growth stays known.
    void renew_gauges() noexcept {
        model_.renew_gauges();
        watches_.fill({});
        turns_ = 0;
        sum_up();
    }
    void forget() noexcept {
        model_.forget();
        watches_.fill({});
        turns_ = 0;
        sum_up();
        known_ = false;
        consistency_ = 1;
        accepted_ = 0;
    }

    bool known() const noexcept { return known_; }
    double growth() const noexcept { return growth_; }  // mu, predicted for now
    double sigma() const noexcept { return sigma_; }
    double held() const noexcept { return held_; }  // mu, after the last accepted contact
    // Standard deviation of the change of the growth since the last accepted contact.
    double since_sigma() const noexcept {
        const double now = sigma();
        return std::sqrt(std::max(0.0, now * now - held_sigma_ * held_sigma_));
    }

    std::int32_t accepted() const noexcept { return accepted_; }  // contacts since nothing was known
    // The spindle has turned so long that it should have grown, and many contacts do not show it.
    bool lacks_growth(const Settings& settings) const noexcept {
        constexpr std::int32_t many = 10;
        constexpr double least = 0.15;  // of the usual growth
        const double usual = usual_growth(settings);
        return accepted_ >= many && usual > settings.floor && std::abs(held_) < least * usual;
    }

    // That a spindle as expected would have by its speed, in mu.
    double usual_growth(const Settings& settings) const noexcept {
        return model_.usual_growth(settings.between);
    }

    Withdrawal withdrawal(std::int32_t gauge) const noexcept { return watches_[gauge].withdrawn; }
    bool program_event() const noexcept { return program_event_; }  // a gauge is withdrawn for that
    // A gauge has claimed the same in two cycles, and no other agrees; or steps take each other back.
    bool contradicted() const noexcept { return contradicted_; }

private:
    Verdict decide(const Reading& r, const Settings& settings) noexcept {
        Watch& watch = watches_[r.gauge];
        if (watch.withdrawn != Withdrawal::none) return Verdict::withdrawn;
        const GrowthBetweenContacts::Gauge gauge{r.gauge, r.reference_sigma};
        const GrowthBetweenContacts::Expected expected =
            known_ ? model_.expected(gauge) : unknown(gauge, settings);
        const double repeatability = settings.between.repeatability;
        const double noise2 = r.noise * r.noise + repeatability * repeatability;
        const double seen2 = noise2 + watch.scatter2;
        const double sum2 = consistency_ * expected.variance + seen2;
        const double innovation = r.growth - expected.mean;

        watch.lock.add(r.growth, expected.mean, r.applied_offset, std::sqrt(noise2));
        if (watch.lock.locked() || watch.lock.follows(r.growth, expected.mean, r.step))
            return withdraw(watch, Withdrawal::program);
        const bool near = innovation * innovation <= 9 * sum2;
        const double change = std::abs(innovation) * consistency_ * expected.variance / sum2;
        const Claim claim{
            innovation, std::sqrt(noise2), r.cycle, r.tool, near, std::abs(innovation) > settings.floor};
        const bool of_a_step = innovation * innovation > 4 * sum2 && confirmed(claim, r);
        if (r.admitted && near && change <= settings.floor && !of_a_step) {
            drop_claim(watch);
            ++predicted_;
            learn_scatter(watch, innovation * innovation, expected.variance, noise2);
            return take(r, gauge, std::sqrt(seen2), true, settings);
        }
        if (r.admitted && (r.confirmed || confirmed(claim, r)))
            return take_step(r, claim.shift, gauge, std::sqrt(seen2), settings);
        const Verdict verdict = claimed(watch, claim, r, gauge, std::sqrt(seen2), settings);
        if (verdict != Verdict::claim) return verdict;
        watch.claimed2 = std::min(innovation * innovation, 16 * sum2) - sum2;
        if (!r.admitted || near || std::abs(innovation) > settings.floor) return verdict;
        Reading bounded_one = r;
        bounded_one.growth = expected.mean + std::copysign(3 * std::sqrt(sum2), innovation);
        return take(bounded_one, gauge, std::sqrt(seen2), true, settings);
    }

    static constexpr std::int32_t most_turns = 2;   // steps, each the reverse of the one before
    static constexpr std::int32_t most_claims = 3;  // of a gauge, and no other agrees
    static constexpr double scatter_part = 0.15, consistency_part = 0.05, widest = 16;

    struct Claim {
        double shift = 0, noise = 0;  // mu, from the prediction
        std::int32_t cycle = 0, tool = 0;
        bool possible = false;                     // as far as known, though more than one contact may change
        bool large = false;                        // beyond `floor`
        bool clear = std::abs(shift) > 4 * noise;  // as it was made
    };

    struct Watch {
        ProgramLock lock;
        double scatter2 = 0;  // mu², beyond the known noise
        Claim claim;
        double claimed2 = 0;         // mu², by which the claim exceeded its expected square
        std::int32_t claims = 0;     // one after the other
        std::int64_t predicted = 0;  // see below, at the first claim
        Withdrawal withdrawn = Withdrawal::none;
    };

    static GrowthBetweenContacts::Expected unknown(const GrowthBetweenContacts::Gauge& gauge,
                                                   const Settings& settings) noexcept {
        return {0, settings.cap * settings.cap + gauge.sigma * gauge.sigma};
    }

    static bool agree(const Claim& a, const Claim& b) noexcept {
        return std::abs(a.shift - b.shift) <= 3 * std::hypot(a.noise, b.noise);
    }

    // Noise agrees with noise: only a claim far beyond its own can be confirmed.
    bool confirmed(const Claim& claim, const Reading& r) const noexcept {
        if (std::abs(claim.shift) < 3 * claim.noise) return false;
        const bool by_another_tool = r.other_tools && claim.large && !claim.possible;
        for (std::size_t i = 0; i < watches_.size(); ++i) {
            const Watch& other = watches_[i];
            if (other.claims == 0 || !other.claim.clear || !agree(other.claim, claim)) continue;
            const bool another_gauge = static_cast<std::int32_t>(i) != r.gauge;
            const bool another_cycle =
                other.claim.cycle != claim.cycle && (another_gauge || predicted_ == other.predicted);
            if (by_another_tool ? other.claim.tool != claim.tool : another_cycle || another_gauge)
                return true;
        }
        return false;
    }

    Verdict claimed(Watch& watch, const Claim& claim, const Reading& r,
                    const GrowthBetweenContacts::Gauge& gauge, double sigma,
                    const Settings& settings) noexcept {
        if (watch.claims == 0 || !agree(watch.claim, claim)) {
            drop_claim(watch);
            watch.predicted = predicted_;
        }
        watch.claim = claim;
        if (++watch.claims < most_claims) return Verdict::claim;
        if (predicted_ > watch.predicted) {
            if (claim.large) return withdraw(watch, Withdrawal::contradiction);
            watch.claims = 0;
            model_.doubt(gauge, claim.shift);
            return r.admitted ? take(r, gauge, sigma, true, settings) : Verdict::claim;
        }
        return r.admitted ? take_step(r, claim.shift, gauge, sigma, settings)
                          : Verdict::claim;  // no other spoke
    }

    Verdict take_step(const Reading& r, double shift, const GrowthBetweenContacts::Gauge& gauge, double sigma,
                      const Settings& settings) noexcept {
        for (Watch& watch : watches_) watch.claims = 0;
        turns_ =
            shift * last_step_ < 0 && std::abs(shift + last_step_) < 0.5 * std::abs(shift) ? turns_ + 1 : 0;
        last_step_ = shift;
        return take(r, gauge, sigma, false, settings);
    }

    Verdict take(const Reading& r, const GrowthBetweenContacts::Gauge& gauge, double sigma, bool explained,
                 const Settings& settings) noexcept {
        const double before = model_.growth();
        model_.correct(r.growth, sigma, gauge, explained, settings.between);
        ++accepted_;
        finish_taking();
        for (Watch& watch : watches_) watch.claim.shift -= growth_ - before;
        return Verdict::accepted;
    }

    void sum_up() noexcept {
        program_event_ = false;
        contradicted_ = turns_ >= most_turns;
        for (const Watch& watch : watches_) {
            program_event_ |= watch.withdrawn == Withdrawal::program;
            contradicted_ |=
                watch.withdrawn == Withdrawal::contradiction || (watch.claims >= 2 && watch.claim.large);
        }
    }

    // It was scatter, not a step.
    static void drop_claim(Watch& watch) noexcept {
        if (watch.claims > 0) watch.scatter2 += scatter_part * watch.claimed2;
        watch.claims = 0;
    }

    void finish_taking() noexcept {
        known_ = true;
        predict();
        held_ = growth_;
        held_sigma_ = sigma_;
    }

    // Once a period, for all who ask.
    void predict() noexcept {
        growth_ = model_.growth();
        sigma_ = std::sqrt(consistency_) * model_.sigma();
    }

    static Verdict withdraw(Watch& watch, Withdrawal reason) noexcept {
        watch.withdrawn = reason;
        watch.claims = 0;
        return Verdict::withdrawn;
    }

    void learn_scatter(Watch& watch, double square, double variance, double noise2) noexcept {
        const double sum2 = consistency_ * variance + noise2 + watch.scatter2;
        watch.scatter2 = std::max(0.0, watch.scatter2 + scatter_part * (square - sum2));
        const double ratio = std::min(square / (variance + noise2 + watch.scatter2), 9.0);
        consistency_ = std::clamp(consistency_ + consistency_part * (ratio - consistency_), 1.0, widest);
    }

    GrowthBetweenContacts model_;
    std::array<Watch, ContactReferences::capacity> watches_{};
    bool known_ = false, program_event_ = false, contradicted_ = false;
    double growth_ = 0, sigma_ = 0;
    double held_ = 0, held_sigma_ = 0;
    double consistency_ = 1;
    double last_step_ = 0;        // mu
    std::int32_t turns_ = 0;      // steps that took the one before back
    std::int32_t accepted_ = 0;   // contacts since nothing was known
    std::int64_t predicted_ = 0;  // contacts that came as predicted
};

}  // namespace plumb
