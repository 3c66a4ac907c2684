// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include "components/math/growth/coverage_factor.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <iterator>
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

template <class Chosen>
std::map<int, Mean> means_of(const GrowthVisits& visits, Chosen chosen) {
    std::map<int, Mean> means;
    for (Index i = 0; i < visits.growth.size(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!chosen(at)) continue;
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

// The chosen visits, less the means of their groups.
struct Centred {
    MatrixXd terms;
    VectorXd growth, weight;
};

template <class Chosen>
Centred centred(const GrowthVisits& visits, Chosen chosen) {
    const std::map<int, Mean> means = means_of(visits, chosen);
    std::vector<Index> rows;
    for (Index i = 0; i < visits.growth.size(); ++i)
        if (chosen(static_cast<std::size_t>(i))) rows.push_back(i);
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

// The error of one law on the visits that it did not see, from the first visit of each group on.
struct Prediction {
    double squares = 0, sizes = 0, products = 0, weight = 0;  // of the error, the law, both

    void add(double error, double law, double w) {
        squares += w * error * error;
        sizes += w * law * law;
        products += w * error * law;
        weight += w;
    }
    // The part of the law that is wrong in its size.
    double off() const { return sizes > 0 ? products / sizes : 0; }
};

template <class Chosen>
Prediction predicted(const GrowthVisits& visits, const VectorXd& law, Chosen chosen) {
    std::map<int, Index> first;
    Prediction its;
    for (Index i = 0; i < visits.growth.size(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Index zero = first.try_emplace(visits.groups[at], i).first->second;
        if (!chosen(at)) continue;
        const double by_law = (visits.terms.row(i) - visits.terms.row(zero)).dot(law);
        its.add(visits.growth[i] - visits.growth[zero] - by_law, by_law, visits.weight[i]);
    }
    return its;
}

}  // namespace
}  // namespace growth_identification

IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& usual, double sigma) {
    using namespace growth_identification;
    constexpr int learned = 2;       // blocks, at least, that predict the next one
    constexpr double one_day = 0.5;  // the least scale with one day: 0.35 covered 84 % of other days
    const auto all = [](std::size_t) { return true; };
    const Centred whole = centred(visits, all);
    const Solution law = solved(whole, usual, sigma);
    IdentifiedGrowth result;
    result.value = law.value;
    result.covariance = law.covariance;
    result.drift = rms(whole.growth, whole.weight);
    result.rest = rms(whole.growth - whole.terms * law.value, whole.weight);
    result.predicted_rest = std::numeric_limits<double>::infinity();

    const std::set<int> blocks(visits.blocks.begin(), visits.blocks.end());
    const std::set<int> days(visits.days.begin(), visits.days.end());
    std::vector<Prediction> predictions;
    const auto predict = [&](const std::vector<int>& parts, int part) {
        const Centred before = centred(visits, [&](std::size_t i) { return parts[i] < part; });
        if (before.growth.size() < 2) return;
        const VectorXd its = solved(before, usual, sigma).value;
        const Prediction found = predicted(visits, its, [&](std::size_t i) { return parts[i] == part; });
        if (found.weight > 0) predictions.push_back(found);
    };
    if (days.size() > 1)
        for (auto day = std::next(days.begin()); day != days.end(); ++day) predict(visits.days, *day);
    else if (blocks.size() > learned)
        for (auto block = std::next(blocks.begin(), learned); block != blocks.end(); ++block)
            predict(visits.blocks, *block);
    if (predictions.empty()) return result;
    double squares = 0, off = 0;
    for (const Prediction& its : predictions) {
        const double square = its.squares / its.weight;
        result.block_rests.push_back(std::sqrt(square));
        squares += square;
        off += its.off() * its.off();
    }
    const auto count = static_cast<double>(predictions.size());
    result.predicted_rest = std::sqrt(squares / count);
    result.scale = std::sqrt(off / count);
    if (days.size() > 1)
        result.scale *= coverage_factor(count) / 2;
    else
        result.scale = std::max(result.scale, one_day);
    return result;
}

}  // namespace plumb
