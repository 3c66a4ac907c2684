// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_curve.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <vector>

namespace plumb {
namespace growth_curve {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int constants = 12;
constexpr double longest = 8 * 3600, shortest = 60;  // s, of a machine
constexpr double guess = 0.6;                        // of the logarithm of a noise that is expected

// From `low` to `high`, evenly in the logarithm.
VectorXd row(double low, double high, int count) {
    return VectorXd::LinSpaced(count, std::log(low), std::log(high)).array().exp();
}

// Time constants that a test of this length can show.
VectorXd time_constants(double span) {
    const double low = std::max(span / 50, std::min(shortest, span / 5));
    return row(low, std::max(std::min(3 * span, longest), 2 * low), constants);
}

// A choice of the size of the b_j and of the noise.
struct Choice {
    double weight = 0;  // logarithm
    double noise = 0, steady = 0, steady_square = 0, rate = 0, rate_square = 0;
};

}  // namespace
}  // namespace growth_curve

std::optional<GrowthCurve> fit_growth_curve(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                            const GrowthNoise& noise) {
    using namespace growth_curve;
    const Eigen::Index n = t.size();
    if (n < (noise.expected > 0 ? 2 : 5) || n != y.size() || !t.allFinite() || !y.allFinite())
        return std::nullopt;
    const double span = t.maxCoeff() - t.minCoeff(), range = y.maxCoeff() - y.minCoeff();
    if (!(span > 0)) return std::nullopt;
    const double size = std::max(range, noise.expected > 0 ? noise.expected : 1e-12);
    const VectorXd tau = time_constants(span);
    MatrixXd terms(n, constants + 1);
    VectorXd end = VectorXd::Ones(constants + 1), slope = VectorXd::Zero(constants + 1);
    terms.col(0).setOnes();
    for (int j = 0; j < constants; ++j) {
        terms.col(j + 1) = 1 - (-(t.array() - t.minCoeff()) / tau[j]).exp();
        slope[j + 1] = std::exp(-span / tau[j]) / tau[j];
    }
    const VectorXd from_first = y.array() - y[0];
    const MatrixXd products = terms.transpose() * terms;
    const VectorXd right = terms.transpose() * from_first;

    VectorXd noises = row(1e-4 * size, 0.3 * size, 24);
    if (noise.expected > 0) noises = row(noise.expected / 4, 4 * noise.expected, 15);
    if (noise.known) noises = VectorXd::Constant(1, noise.expected);
    std::vector<Choice> choices;
    for (const double b : row(0.03 * size, 4 * size, 10))
        for (const double s : noises) {
            VectorXd precision = VectorXd::Constant(constants + 1, 1 / (b * b));
            precision[0] = 1 / (100 * size * size);
            const MatrixXd information = products / (s * s) + MatrixXd(precision.asDiagonal());
            const Eigen::LLT<MatrixXd> factors(information);
            const VectorXd mean = factors.solve(right / (s * s));
            Choice its;
            const double rest = from_first.squaredNorm() / (s * s) - mean.dot(right) / (s * s);
            const MatrixXd lower = factors.matrixL();
            its.weight = -rest / 2 - lower.diagonal().array().log().sum() + precision.array().log().sum() / 2 -
                         static_cast<double>(n) * std::log(s);
            if (noise.expected > 0) its.weight -= std::pow(std::log(s / noise.expected) / guess, 2) / 2;
            its.noise = s;
            const auto square_of = [&](const VectorXd& wanted, double value) {
                return value * value + wanted.dot(factors.solve(wanted));
            };
            its.steady = end.dot(mean);
            its.steady_square = square_of(end, its.steady);
            its.rate = slope.dot(mean);
            its.rate_square = square_of(slope, its.rate);
            choices.push_back(its);
        }
    const double best = std::max_element(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
                            return a.weight < b.weight;
                        })->weight;
    double sum = 0, steady_square = 0, rate_square = 0, noise_square = 0, logarithm = 0, logarithm_square = 0;
    GrowthCurve curve;
    for (const Choice& its : choices) {
        const double w = std::exp(its.weight - best);
        sum += w;
        curve.steady += w * its.steady;
        curve.rate += w * its.rate;
        steady_square += w * its.steady_square;
        rate_square += w * its.rate_square;
        noise_square += w * its.noise * its.noise;
        logarithm += w * std::log(its.noise);
        logarithm_square += w * std::pow(std::log(its.noise), 2);
    }
    curve.steady /= sum;
    curve.rate /= sum;
    curve.steady_sigma = std::sqrt(std::max(steady_square / sum - curve.steady * curve.steady, 0.0));
    curve.rate_sigma = std::sqrt(std::max(rate_square / sum - curve.rate * curve.rate, 0.0));
    curve.steady += y[0];
    curve.noise = std::sqrt(noise_square / sum);
    // A noise that is known within a part p has 1 / (2 p²) degrees of freedom (GUM, G.4.2).
    const double spread = logarithm_square / sum - std::pow(logarithm / sum, 2);
    curve.freedom = std::min(1 / (2 * std::max(spread, 1e-3)), 500.0);
    curve.determined = n >= 5 && 4 * curve.steady_sigma < std::max(range, 4 * curve.noise);
    return curve;
}

}  // namespace plumb
