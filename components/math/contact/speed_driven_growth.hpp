// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// Growth that a drive u explains through one lag, learned from the contacts, and the growth that it does not
// explain:
//
//     g = b + K x + A d + c T        x' = (u - x) / tau,  x(0) = 0        d' = -d / tau,  d(0) = 1
//     z = g + s + v l + r_i + noise        a contact of gauge i at the signed feed v
//
// b is a slow bias, K the growth in the end for u = 1, A d the unknown heat that the machine had at the
// start, c the growth by a temperature T, s a shift of all contacts that is not growth, l a delay of the load
// since the reference, r_i the error of the reference of gauge i, which all its contacts share. They are the
// state of a Kalman filter (R. E. Kalman, J. Basic Eng. 82, 1960): b and K wander, s, l and the r_i stand,
// and contacts correct each by its uncertainty. So many contacts of one gauge do not make the growth more
// certain than its reference is.
class SpeedDrivenGrowth {
public:
    // Standard deviations at the start, and the mean of K; lengths in mu.
    struct Prior {
        double growth = 0;       // mu, mean and standard deviation of K; of b twice that, of A two thirds
        double wander = 0;       // mu / sqrt(s), of b
        double temperature = 0;  // mu/K, standard deviation of c
    };

    // For a machine in an unknown state.
    void start(const Prior& prior) noexcept {
        constexpr double start_bias = 2, start_heat = 2.0 / 3;
        const auto squared = [](double x) { return x * x; };
        renew_gauges();
        std::fill_n(state_.begin(), states, 0);
        state_[gain] = prior.growth;
        most_ = {squared(start_bias * prior.growth),
                 squared(prior.growth),
                 squared(start_heat * prior.growth),
                 squared(prior.temperature),
                 0,
                 0};
        wander_ = {squared(prior.wander), 0, 0, 0, 0, 0};
        row_ = {1, 0, 1, 0, 0, 0};
        for (std::size_t i = 0; i < states; ++i) {
            std::fill_n(covariance_[i].begin(), states, 0);
            covariance_[i][i] = most_[i];
        }
    }

    // Advances by dt > 0 seconds, in which the drive was u and the lag tau > 0.
    void step(double u, double tau, double dt) noexcept {
        if (tau != tau_ || dt != dt_) {
            tau_ = tau;
            dt_ = dt;
            part_ = -std::expm1(-dt / tau);
        }
        row_[gain] += (u - row_[gain]) * part_;
        row_[heat] = row_[heat] > 1e-9 ? row_[heat] * (1 - part_) : 0;
    }

    // dt > 0 seconds make the state less certain; b at most as uncertain as at the start, where it is as
    // good as unknown.
    void wander(double dt) noexcept {
        if (covariance_[bias][bias] < most_[bias]) covariance_[bias][bias] += wander_[bias] * dt;
        const double gain2 = std::min(state_[gain] * state_[gain], most_[gain]);
        if (covariance_[gain][gain] < most_[gain]) covariance_[gain][gain] += forgetting * gain2 * dt;
    }

    // T in K, from its first value.
    void temperature(double T) noexcept { row_[warmth] = T; }

    // The growth now may differ from the model by any bias, or by one of this variance, in mu².
    void forget_bias() noexcept { forget_bias(most_[bias]); }
    void forget_bias(double variance) noexcept { covariance_[bias][bias] += variance; }

    static constexpr std::int32_t most_gauges = 64;

    // A gauge, the standard deviation of its reference in mu before its first contact, and the signed feed of
    // this contact in mu/s.
    struct Gauge {
        std::int32_t number = -1;  // 0 ... most_gauges - 1; another one has no error of its own
        double sigma = 0;
        double feed = 0;
    };

    // Mean and variance that a contact of a gauge is expected to have.
    struct Expected {
        double mean, variance;
    };
    Expected expected(const Gauge& gauge) const noexcept {
        const std::int32_t slot = slot_of(gauge);
        const double own = slot < 0 ? gauge.sigma * gauge.sigma : covariance_[slot][slot];
        const Row seen = row_of_contact(gauge);
        double shared = 0;
        for (std::size_t i = 0; slot >= 0 && i < states; ++i) shared += covariance_[slot][i] * seen[i];
        return {dot(state_, seen) + (slot < 0 ? 0 : state_[slot]), variance(seen) + own + 2 * shared};
    }

    // Corrects the state by a contact z of variance `variance` > 0, of no gauge that has an error of its own.
    // Returns the logarithm of how likely z was.
    double correct(double z, double variance) noexcept { return correct(z, variance, Gauge()); }

    double correct(double z, double variance, const Gauge& gauge) noexcept {
        const std::int32_t slot = introduce(gauge);
        const Row seen = row_of_contact(gauge);
        All doubt;
        for (std::size_t i = 0; i < used_; ++i) {
            doubt[i] = dot(covariance_[i], seen);
            if (slot >= 0) doubt[i] += covariance_[i][slot];
        }
        double sum = dot(doubt, seen) + variance, error = z - dot(state_, seen);
        if (slot >= 0) {
            sum += doubt[slot];
            error -= state_[slot];
        }
        for (std::size_t i = 0; i < used_; ++i) {
            state_[i] += doubt[i] / sum * error;
            for (std::size_t j = 0; j < used_; ++j) covariance_[i][j] -= doubt[i] * doubt[j] / sum;
        }
        return -0.5 * (error * error / sum + std::log(sum));
    }

    // All contacts may have shifted by any distance of this variance, in mu².
    void shift_all(double variance) noexcept { covariance_[shifted][shifted] += variance; }

    // The load may have another delay, of this variance in s².
    void delay_all(double variance) noexcept { covariance_[late][late] += variance; }

    // The gauges of one tool may have shifted alike: those whose bits are set.
    void shift(std::uint64_t gauges, double sigma, double variance) noexcept {
        for (std::int32_t i = 0; i < most_gauges; ++i)
            if (gauges >> i & 1) introduce({i, sigma});
        for (std::int32_t i = 0; i < most_gauges; ++i)
            for (std::int32_t j = 0; j < most_gauges; ++j)
                if (gauges >> i & gauges >> j & 1) covariance_[slots_[i]][slots_[j]] += variance;
    }

    double shift_of_all(double feed) const noexcept { return state_[shifted] + feed * state_[late]; }  // mu
    double error_of(std::int32_t gauge) const noexcept {  // mu, of its reference
        const std::int32_t slot = slot_of({gauge});
        return slot < 0 ? 0 : state_[slot];
    }

    // The growth counts from another origin, lower by a distance in mu.
    void displace(double distance) noexcept { state_[bias] += distance; }

    // The shift of all contacts at this feed was growth.
    void take_shift_as_growth(double feed) noexcept {
        take_as_growth(shifted, 1);
        take_as_growth(late, feed);
        forget_shift();
    }

    // All references have been corrected by the shift.
    void forget_shift() noexcept {
        for (const std::size_t its : {shifted, late}) {
            state_[its] = 0;
            for (std::size_t i = 0; i < used_; ++i) covariance_[its][i] = covariance_[i][its] = 0;
        }
    }

    // The references of the gauges whose bits are set were corrected by their errors.
    void forget_errors(std::uint64_t gauges) noexcept {
        for (std::int32_t i = 0; i < most_gauges; ++i)
            if (gauges >> i & 1 && slots_[i] >= 0) state_[slots_[i]] = 0;
    }

    // All gauges have new references.
    void renew_gauges() noexcept {
        used_ = states;
        slots_.fill(-1);
        forget_shift();
    }

    // Copies only the gauges that have come.
    SpeedDrivenGrowth() noexcept = default;
    SpeedDrivenGrowth(const SpeedDrivenGrowth& other) noexcept { *this = other; }
    SpeedDrivenGrowth& operator=(const SpeedDrivenGrowth& other) noexcept {
        used_ = other.used_;
        for (std::size_t i = 0; i < used_; ++i) {
            state_[i] = other.state_[i];
            std::copy_n(other.covariance_[i].begin(), used_, covariance_[i].begin());
        }
        slots_ = other.slots_;
        row_ = other.row_;
        most_ = other.most_;
        wander_ = other.wander_;
        tau_ = other.tau_;
        dt_ = other.dt_;
        part_ = other.part_;
        return *this;
    }

    double driven() const noexcept { return row_[gain]; }                    // x
    double effect() const noexcept { return std::abs(state_[gain]); }        // mu, |K|
    double growth() const noexcept { return dot(state_, row_, of_growth); }  // mu
    double variance() const noexcept { return variance(row_, of_growth); }   // mu²

private:
    static constexpr double forgetting = 1.0 / 90000;  // 1/s, of the gain: as 25 h
    static constexpr std::size_t bias = 0, gain = 1, heat = 2, warmth = 3, shifted = 4, late = 5, states = 6;
    static constexpr std::size_t of_growth = 4;  // of the states: the first ones
    using Row = std::array<double, states>;

    Row row_of_contact(const Gauge& gauge) const noexcept {
        Row row = row_;
        row[shifted] = 1;
        row[late] = gauge.feed;
        return row;
    }

    void take_as_growth(std::size_t its, double part) noexcept {
        state_[bias] += part * state_[its];
        for (std::size_t i = 0; i < used_; ++i) covariance_[bias][i] += part * covariance_[its][i];
        for (std::size_t i = 0; i < used_; ++i) covariance_[i][bias] += part * covariance_[i][its];
    }

    double variance(const Row& row, std::size_t count = states) const noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += row[i] * dot(covariance_[i], row, count);
        return sum;
    }

    template <class Wide>
    static double dot(const Wide& a, const Row& b, std::size_t count = states) noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += a[i] * b[i];
        return sum;
    }

    std::int32_t slot_of(const Gauge& gauge) const noexcept {
        return gauge.number >= 0 && gauge.number < most_gauges ? slots_[gauge.number] : -1;
    }

    // The place of a gauge in the state; -1 without one.
    std::int32_t introduce(const Gauge& gauge) noexcept {
        if (gauge.number < 0 || gauge.number >= most_gauges || slots_[gauge.number] >= 0)
            return slot_of(gauge);
        const auto slot = static_cast<std::int32_t>(used_++);
        slots_[gauge.number] = static_cast<std::int8_t>(slot);
        state_[slot] = 0;
        for (std::size_t i = 0; i < used_; ++i) covariance_[i][slot] = covariance_[slot][i] = 0;
        covariance_[slot][slot] = gauge.sigma * gauge.sigma;
        return slot;
    }

    using All = std::array<double, states + most_gauges>;
    All state_{};
    std::array<All, states + most_gauges> covariance_{};
    std::array<std::int8_t, most_gauges> slots_{};  // of each gauge in the state; -1 before its first contact
    std::size_t used_ = states;
    Row row_{}, most_{}, wander_{};
    double tau_ = 0, dt_ = 0, part_ = 0;  // the last one, which costs most
};

}  // namespace plumb
