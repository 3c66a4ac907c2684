// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_curve.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
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
VectorXd time_constants(double span, int count) {
    const double low = std::max(span / 50, std::min(shortest, span / 5));
    return row(low, std::max(std::min(3 * span, longest), 2 * low), count);
}

// Without knowledge of the noise: one to three exponentials with time constants of a fixed row, and a noise
// whose neighbours are correlated by r of another row. All sets of both are fitted by least squares of the
// whitened readings x_k - r x_{k-1}. Within a step of the row each time constant is linearised. The air of
// the shop swings over a day, which no record of some hours can tell from a slow exponential: a sine of that
// period stands beside them, whose size is bounded. Each number of exponentials is weighted by the AICc of
// its best set (Burnham and Anderson, Model selection and multimodel inference), with n (1 - r) / (1 + r)
// effective readings, and the sets of one number by the same quantity.
constexpr int most_exponentials = 3;
constexpr int fine = 48;                          // time constants in the row
constexpr std::array<int, 4> stride{0, 1, 2, 4};  // in the row, by the number of exponentials
constexpr std::array<double, 6> correlations{0, 0.4, 0.7, 0.85, 0.93, 0.98};
constexpr double day = 86400;         // s
constexpr double day_part = 0.02;     // of the range of y: the size of the sine
constexpr double size_part = 2;       // of the range: the size of an exponential
constexpr double start_part = 10;     // of the range: the size of a
constexpr double least_noise = 1e-3;  // of the range: the row shows no less
constexpr double least_freedom = 0.5;

// The columns of the fit: the exponentials of the row, a, the day, the derivatives by the time constants, y.
constexpr int of_start = fine, of_day = fine + 1, of_shift = of_day + 2, of_values = of_shift + fine;

struct Model {
    std::array<int, most_exponentials> constants{};  // in the row, rising
    int count = 0;
    double aicc = 0, freedom = 0, variance = 0;
    double steady = 0, steady_square = 0, rate = 0, rate_square = 0;  // values and variances
};

// Appends each set of `count` time constants that begins with the constants of `its`.
void add_models(std::vector<Model>& all, Model its, int count, int first) {
    if (its.count == count) {
        all.push_back(its);
        return;
    }
    const int step = stride[static_cast<std::size_t>(count)];
    ++its.count;
    for (int j = first; j < fine; j += step) {
        its.constants[static_cast<std::size_t>(its.count - 1)] = j;
        add_models(all, its, count, j + step);
    }
}

struct Row {
    VectorXd tau, slope;  // s; dy/dt at the end for a size of 1
    double step = 0;      // of log tau
    MatrixXd columns;
};

Row row_of(const VectorXd& t, const VectorXd& y) {
    const double span = t.maxCoeff() - t.minCoeff();
    const VectorXd since = t.array() - t.minCoeff();
    Row its;
    its.tau = time_constants(span, fine);
    its.step = std::log(its.tau[1] / its.tau[0]);
    its.slope = (-span * its.tau.array().inverse()).exp() / its.tau.array();
    its.columns.resize(t.size(), of_values + 1);
    for (int j = 0; j < fine; ++j) {
        const VectorXd fallen = (-since.array() / its.tau[j]).exp();
        its.columns.col(j) = 1 - fallen.array();
        its.columns.col(of_shift + j) = -since.array() / its.tau[j] * fallen.array();
    }
    its.columns.col(of_start).setOnes();
    its.columns.col(of_day) = (since.array() * (2 * EIGEN_PI / day)).sin();
    its.columns.col(of_day + 1) = (since.array() * (2 * EIGEN_PI / day)).cos();
    its.columns.col(of_values) = y.array() - y[0];
    return its;
}

MatrixXd whitened(const MatrixXd& columns, double r) {
    MatrixXd white = columns;
    white.bottomRows(columns.rows() - 1) -= r * columns.topRows(columns.rows() - 1);
    white.row(0) *= std::sqrt(1 - r * r);
    return white;
}

// The sum of the squares of the residuals. `products` of the whitened columns; `variance` of the white noise,
// which weighs the bounds of the sizes. The first pass gives the sizes with which the second one moves the
// time constants.
double fit(Model& its, const Row& row, const MatrixXd& products, double range, double variance) {
    constexpr int most = 2 * most_exponentials + 3;
    using Matrix = Eigen::Matrix<double, -1, -1, 0, most, most>;
    using Vector = Eigen::Matrix<double, -1, 1, 0, most, 1>;
    const int linear = its.count + 3;
    std::array<int, most> columns{of_start, of_day, of_day + 1};
    Vector factor = Vector::Ones(linear + its.count), width(linear + its.count);
    width.head(3) << start_part * range, day_part * range, day_part * range;
    for (int i = 0; i < its.count; ++i) {
        const int constant = its.constants[static_cast<std::size_t>(i)];
        columns[static_cast<std::size_t>(3 + i)] = constant;
        columns[static_cast<std::size_t>(linear + i)] = of_shift + constant;
        width[3 + i] = size_part * range;
        width[linear + i] = row.step * stride[static_cast<std::size_t>(its.count)] / 2;
    }
    double rest = 0;
    for (const int size : {linear, linear + its.count}) {
        Matrix information(size, size);
        Vector right(size), ends = Vector::Zero(size), slopes = ends;
        for (int i = 0; i < size; ++i) {
            const int column = columns[static_cast<std::size_t>(i)];
            right[i] = factor[i] * products(column, of_values);
            for (int k = 0; k < size; ++k)
                information(i, k) =
                    factor[i] * products(column, columns[static_cast<std::size_t>(k)]) * factor[k];
            information(i, i) += variance / (width[i] * width[i]);
            if (column <= of_start) ends[i] = 1;
            if (column < of_start) slopes[i] = row.slope[column];
        }
        const Eigen::LDLT<Matrix> factors(information);
        const Vector sizes = factors.solve(right);
        rest = products(of_values, of_values) - sizes.dot(right);
        its.steady = ends.dot(sizes);
        its.rate = slopes.dot(sizes);
        its.steady_square = ends.dot(factors.solve(ends));
        its.rate_square = slopes.dot(factors.solve(slopes));
        factor.tail(its.count) = sizes.segment(3, its.count);
    }
    return rest;
}

// The mean over weighted fits, whose spread is a part of its sigma. Squares: of a value, with its variance.
class Mean {
public:
    void add(double weight, double steady, double steady_square, double rate, double rate_square,
             double noise_square) {
        sum_ += weight;
        values_ += weight * Eigen::Vector2d(steady, rate);
        squares_ += weight * Eigen::Vector3d(steady_square, rate_square, noise_square);
    }

    double of(double total) const { return total / sum_; }

    // `first`: the value at which steady is 0.
    GrowthCurve curve(double first) const {
        const auto sigma = [this](int i) {
            return std::sqrt(std::max(of(squares_[i]) - std::pow(of(values_[i]), 2), 0.0));
        };
        GrowthCurve its;
        its.steady = of(values_[0]) + first;
        its.rate = of(values_[1]);
        its.steady_sigma = sigma(0);
        its.rate_sigma = sigma(1);
        its.noise = std::sqrt(of(squares_[2]));
        return its;
    }

private:
    double sum_ = 0;
    Eigen::Vector2d values_ = Eigen::Vector2d::Zero();
    Eigen::Vector3d squares_ = Eigen::Vector3d::Zero();
};

GrowthCurve mean_of_models(const VectorXd& t, const VectorXd& y) {
    const auto n = static_cast<double>(t.size());
    const double span = t.maxCoeff() - t.minCoeff(), range = std::max(y.maxCoeff() - y.minCoeff(), 1e-12);
    const Row row = row_of(t, y);
    std::vector<Model> sets, models;
    for (int count = 1; count <= most_exponentials; ++count) add_models(sets, {}, count, 0);
    std::array<double, most_exponentials + 1> best{}, sums{};
    best.fill(HUGE_VAL);
    for (const double r : correlations) {
        const MatrixXd white = whitened(row.columns, r);
        const MatrixXd products = white.transpose() * white;
        const double readings = n * (1 - r) / (1 + r);
        const double least = std::pow(least_noise * range, 2) * n * (1 + r * r);
        double rest = HUGE_VAL;
        for (Model& its : sets)
            if (its.count == most_exponentials)
                rest = std::min(rest, fit(its, row, products, range, least / n * least_noise));
        const double variance = (rest + least) / n;
        for (Model& its : sets) {
            const double left = (fit(its, row, products, range, variance) + least) / n;
            const double k = 2 * its.count + 3;  // with a, the noise and its correlation
            its.aicc = n * std::log(left) - std::log(1 - r * r) + 2 * k +
                       2 * k * (k + 1) / std::max(readings - k - 1, 0.1);
            its.freedom = std::max(readings - k, least_freedom);
            const double noise = left * readings / its.freedom;
            its.steady_square *= noise;
            its.rate_square *= noise;
            its.variance = noise / (1 - r * r);
            double& of_count = best[static_cast<std::size_t>(its.count)];
            of_count = std::min(of_count, its.aicc);
        }
        models.insert(models.end(), sets.begin(), sets.end());
    }
    for (const Model& its : models) {
        const auto count = static_cast<std::size_t>(its.count);
        sums[count] += std::exp((best[count] - its.aicc) / 2);
    }
    const double first = *std::min_element(best.begin(), best.end());
    Mean mean;
    double freedom = 0, slowest = 0;
    for (const Model& its : models) {
        const auto count = static_cast<std::size_t>(its.count);
        const double w = std::exp((first - its.aicc) / 2) / sums[count];
        const double wider = its.freedom > 2.5 ? its.freedom / (its.freedom - 2) : 5;  // Student's t
        mean.add(w, its.steady, its.steady * its.steady + wider * its.steady_square, its.rate,
                 its.rate * its.rate + wider * its.rate_square, its.variance);
        freedom += w * its.freedom;
        slowest += w * std::log(row.tau[its.constants[count - 1]]);
    }
    GrowthCurve curve = mean.curve(y[0]);
    curve.freedom = mean.of(freedom);
    curve.shorter = span < 2 * std::exp(mean.of(slowest));
    return curve;
}

// A choice of the size of the b_j and of the noise.
struct Choice {
    double weight = 0;  // logarithm
    double noise = 0, steady = 0, steady_square = 0, rate = 0, rate_square = 0;
};

}  // namespace
}  // namespace growth_curve

std::optional<GrowthCurve> fit_growth_curve(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                            double expected_noise) {
    using namespace growth_curve;
    const Eigen::Index n = t.size();
    if (n < (expected_noise > 0 ? 2 : 5) || n != y.size() || !t.allFinite() || !y.allFinite())
        return std::nullopt;
    const double span = t.maxCoeff() - t.minCoeff(), range = y.maxCoeff() - y.minCoeff();
    if (!(span > 0)) return std::nullopt;
    if (!(expected_noise > 0)) {
        GrowthCurve curve = mean_of_models(t, y);
        curve.determined = !curve.shorter && 4 * curve.steady_sigma < std::max(range, 4 * curve.noise);
        return curve;
    }
    const double size = std::max(range, expected_noise);
    const VectorXd tau = time_constants(span, constants);
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

    const VectorXd noises = row(expected_noise / 4, 4 * expected_noise, 15);
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
            its.weight = -rest / 2 - lower.diagonal().array().log().sum() +
                         precision.array().log().sum() / 2 - static_cast<double>(n) * std::log(s);
            its.weight -= std::pow(std::log(s / expected_noise) / guess, 2) / 2;
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
    const double best =
        std::max_element(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
            return a.weight < b.weight;
        })->weight;
    Mean all;
    double logarithm = 0, logarithm_square = 0;
    for (const Choice& its : choices) {
        const double w = std::exp(its.weight - best);
        all.add(w, its.steady, its.steady_square, its.rate, its.rate_square, its.noise * its.noise);
        logarithm += w * std::log(its.noise);
        logarithm_square += w * std::pow(std::log(its.noise), 2);
    }
    GrowthCurve curve = all.curve(y[0]);
    // A noise that is known within a part p has 1 / (2 p²) degrees of freedom (GUM, G.4.2).
    const double spread = all.of(logarithm_square) - std::pow(all.of(logarithm), 2);
    curve.freedom = std::min(1 / (2 * std::max(spread, 1e-3)), 500.0);
    curve.determined = n >= 5 && 4 * curve.steady_sigma < std::max(range, 4 * curve.noise);
    return curve;
}

}  // namespace plumb
