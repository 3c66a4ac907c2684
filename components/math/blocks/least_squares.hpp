// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <optional>

namespace plumb {

// Parameters p of a linear model, from observations a p = value, each with its standard uncertainty. Prior
// knowledge of a parameter counts as one more observation of it.
class LeastSquares {
public:
    struct Solution {
        Eigen::VectorXd parameters;
        Eigen::MatrixXd covariance;
        double ratio = 0;  // scatter about the model, as a multiple of the stated one; 0 if unknown
    };

    explicit LeastSquares(Eigen::Index parameters)
        : normal_(Eigen::MatrixXd::Zero(parameters, parameters)), right_(Eigen::VectorXd::Zero(parameters)) {}

    void observe(const Eigen::VectorXd& a, double value, double sigma) {
        const Eigen::VectorXd row = a / sigma;
        normal_ += row * row.transpose();
        right_ += row * (value / sigma);
        square_ += value / sigma * (value / sigma);
        ++count_;
    }

    void know(Eigen::Index parameter, double value, double sigma) {
        observe(Eigen::VectorXd::Unit(right_.size(), parameter), value, sigma);
    }

    // Nothing if the observations leave a parameter undetermined.
    std::optional<Solution> solve() const {
        const Eigen::VectorXd diagonal = normal_.diagonal();
        if (!(diagonal.array() > 0).all()) return std::nullopt;
        const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
        const Eigen::LDLT<Eigen::MatrixXd> factors(scale.asDiagonal() * normal_ * scale.asDiagonal());
        if (!(factors.vectorD().minCoeff() > least_pivot)) return std::nullopt;
        Solution solution;
        const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(right_.size(), right_.size());
        solution.covariance = scale.asDiagonal() * factors.solve(unit) * scale.asDiagonal();
        solution.parameters = scale.asDiagonal() * factors.solve(scale.asDiagonal() * right_);
        const auto freedom = static_cast<double>(count_ - right_.size());
        if (freedom > 0)
            solution.ratio = std::sqrt(std::max(0.0, square_ - right_.dot(solution.parameters)) / freedom);
        return solution;
    }

private:
    static constexpr double least_pivot = 1e-11;

    Eigen::MatrixXd normal_;
    Eigen::VectorXd right_;
    double square_ = 0;
    Eigen::Index count_ = 0;
};

}  // namespace plumb
