// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// Growth that a drive u explains through one lag, learnt from the contacts, and the growth that it does not
// explain:
//
//     g = b + K x + A d + c T        x' = (u - x) / tau,  x(0) = 0        d' = -d / tau,  d(0) = 1
//
// b is a slow bias, K the growth in the end for u = 1, A d the unknown heat that the machine had at the
// start, c the growth by a temperature T. b, K, A and c are the state of a Kalman filter (R. E. Kalman, J.
// Basic Eng. 82, 1960): b and K wander, and contacts correct each of the four by its uncertainty.
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
        constexpr double start_bias = 2, start_heat = 2.0 / 3, forgetting = 1.0 / 90000;  // 1/s, as 25 h
        const auto squared = [](double x) { return x * x; };
        state_ = {0, prior.growth, 0, 0};
        most_ = {squared(start_bias * prior.growth), squared(prior.growth),
                 squared(start_heat * prior.growth), squared(prior.temperature)};
        wander_ = {squared(prior.wander), forgetting * most_[gain], 0, 0};
        row_ = {1, 0, 1, 0};
        covariance_ = {};
        for (std::size_t i = 0; i < states; ++i) covariance_[i][i] = most_[i];
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
        for (std::size_t i = 0; i < heat; ++i)
            if (covariance_[i][i] < most_[i]) covariance_[i][i] += wander_[i] * dt;
    }

    // T in K, from its first value.
    void temperature(double T) noexcept { row_[warmth] = T; }

    // The growth now may differ from the model by any bias.
    void forget_bias() noexcept { covariance_[bias][bias] += most_[bias]; }

    // Corrects the state by a growth z of variance `variance` > 0. Returns the logarithm of how likely z
    // was.
    double correct(double z, double variance) noexcept {
        const Row doubt = product();
        const double sum = dot(row_, doubt) + variance;
        const double error = z - growth();
        for (std::size_t i = 0; i < states; ++i) {
            state_[i] += doubt[i] / sum * error;
            for (std::size_t j = 0; j < states; ++j) covariance_[i][j] -= doubt[i] * doubt[j] / sum;
        }
        return -0.5 * (error * error / sum + std::log(sum));
    }

    double growth() const noexcept { return dot(row_, state_); }       // mu
    double variance() const noexcept { return dot(row_, product()); }  // mu²

private:
    static constexpr std::size_t bias = 0, gain = 1, heat = 2, warmth = 3, states = 4;
    using Row = std::array<double, states>;

    static double dot(const Row& a, const Row& b) noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < states; ++i) sum += a[i] * b[i];
        return sum;
    }
    Row product() const noexcept {
        Row sum{};
        for (std::size_t i = 0; i < states; ++i) sum[i] = dot(covariance_[i], row_);
        return sum;
    }

    Row state_{}, row_{}, most_{}, wander_{};
    std::array<Row, states> covariance_{};
    double tau_ = 0, dt_ = 0, part_ = 0;  // the last one, which costs most
};

}  // namespace plumb
