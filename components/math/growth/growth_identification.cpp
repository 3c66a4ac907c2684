// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include "components/math/growth/coverage_factor.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace plumb {

namespace growth_identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

struct Mean {
    RowVectorXd terms;
    double growth = 0, weight = 0;
};

std::map<int, Mean> means_of(const GrowthVisits& visits, int without) {
    std::map<int, Mean> means;
    for (Index i = 0; i < visits.growth.size(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (visits.duties[at] == without) continue;
        const double w = visits.weight[i];
        Mean& mean =
            means.try_emplace(visits.groups[at], Mean{RowVectorXd::Zero(visits.terms.cols())}).first->second;
        mean.terms += w * visits.terms.row(i);
        mean.growth += w * visits.growth[i];
        mean.weight += w;
    }
    for (auto& [group, mean] : means) {
        mean.terms /= mean.weight;
        mean.growth /= mean.weight;
    }
    return means;
}

// The visits of some duties, less the means of their groups.
struct Centred {
    MatrixXd terms;
    VectorXd growth, weight;
};

template <class Chosen>
Centred centred(const GrowthVisits& visits, const std::map<int, Mean>& means, Chosen chosen) {
    std::vector<Index> rows;
    for (Index i = 0; i < visits.growth.size(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (chosen(visits.duties[at]) && means.count(visits.groups[at]) > 0) rows.push_back(i);
    }
    Centred its{MatrixXd(rows.size(), visits.terms.cols()), VectorXd(rows.size()), VectorXd(rows.size())};
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Index i = rows[row], to = static_cast<Index>(row);
        const Mean& mean = means.at(visits.groups[static_cast<std::size_t>(i)]);
        its.terms.row(to) = visits.terms.row(i) - mean.terms;
        its.growth[to] = visits.growth[i] - mean.growth;
        its.weight[to] = visits.weight[i];
    }
    return its;
}

struct Solution {
    VectorXd value;
    MatrixXd covariance;
};

// The scatter about the law is not known beforehand; the freedom is less by what the terms take.
Solution solved(const Centred& its, const VectorXd& usual, double sigma) {
    constexpr int rounds = 8;
    const Index count = its.terms.cols();
    const MatrixXd normal = its.terms.transpose() * its.weight.asDiagonal() * its.terms;
    const VectorXd right = its.terms.transpose() * its.weight.asDiagonal() * its.growth;
    const double total = its.weight.sum();
    double variance =
        std::max(sigma * sigma, 0.1 * its.weight.dot(its.growth.cwiseAbs2()) / std::max(total, 1e-9));
    Solution found{VectorXd::Zero(count), MatrixXd::Zero(count, count)};
    for (int round = 0; round < rounds; ++round) {
        MatrixXd inner = normal / variance;
        inner.diagonal().array() += usual.array().square().inverse();
        const Eigen::LDLT<MatrixXd> factors(inner);
        found.covariance = factors.solve(MatrixXd::Identity(count, count));
        found.value = found.covariance * right / variance;
        const VectorXd rest = its.growth - its.terms * found.value;
        const double taken = (found.covariance * normal).trace() / variance;
        const double freedom = std::max(total - 1 - taken, 1.0);
        variance = std::max(sigma * sigma, its.weight.dot(rest.cwiseAbs2()) / freedom);
    }
    return found;
}

double rms(const VectorXd& values, const VectorXd& weight) {
    const double total = weight.sum();
    return total > 0 ? std::sqrt(weight.dot(values.cwiseAbs2()) / total) : 0;
}

}  // namespace
}  // namespace growth_identification

IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& usual, double sigma) {
    using namespace growth_identification;
    constexpr int none = std::numeric_limits<int>::min();
    const Centred whole = centred(visits, means_of(visits, none), [](int) { return true; });
    const Solution law = solved(whole, usual, sigma);
    IdentifiedGrowth result;
    result.value = law.value;
    result.covariance = law.covariance;
    result.drift = rms(whole.growth, whole.weight);
    result.rest = rms(whole.growth - whole.terms * law.value, whole.weight);
    result.predicted_rest = std::numeric_limits<double>::infinity();

    const std::set<int> duties(visits.duties.begin(), visits.duties.end());
    std::vector<double> squares, sizes, weights;
    for (const int left_out : duties) {
        const std::map<int, Mean> means = means_of(visits, left_out);
        const Centred others = centred(visits, means, [&](int duty) { return duty != left_out; });
        const Centred its = centred(visits, means, [&](int duty) { return duty == left_out; });
        if (its.growth.size() == 0 || others.growth.size() < 2) continue;
        const Eigen::VectorXd predicted = its.terms * solved(others, usual, sigma).value;
        const Eigen::VectorXd rest = its.growth - predicted;
        for (Index i = 0; i < rest.size(); ++i) {
            squares.push_back(rest[i] * rest[i]);
            sizes.push_back(predicted[i] * predicted[i]);
            weights.push_back(its.weight[i]);
        }
    }
    if (weights.empty()) return result;
    const auto as_vector = [](const std::vector<double>& values) -> Eigen::VectorXd {
        return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(values.size()));
    };
    const Eigen::VectorXd weight = as_vector(weights);
    const double square = weight.dot(as_vector(squares)) / weight.sum();
    const double size = weight.dot(as_vector(sizes)) / weight.sum();
    result.predicted_rest = std::sqrt(square);
    // A few duties do not show how far others may differ. An error of a prediction beyond that of the fit
    // comes with the terms.
    const double few = coverage_factor(std::max(static_cast<double>(duties.size()) - 1, 1.0)) / 2;
    const double always = std::min(result.rest * result.rest, square);
    result.floor = few * std::sqrt(always);
    result.share = size > 0 ? few * std::sqrt((square - always) / size) : 0;
    return result;
}

}  // namespace plumb
