// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace plumb {

namespace growth_identification {
namespace {

// A and y of the chosen visits, each less the mean of its group in them.
GrowthVisits centred(const GrowthVisits& visits, const std::vector<Eigen::Index>& chosen) {
    GrowthVisits result;
    result.terms.resize(static_cast<Eigen::Index>(chosen.size()), visits.terms.cols());
    result.growth.resize(static_cast<Eigen::Index>(chosen.size()));
    struct Sum {
        Eigen::RowVectorXd terms;
        double growth = 0, count = 0;
    };
    std::map<int, Sum> sums;
    for (const Eigen::Index i : chosen) {
        Sum& sum = sums.try_emplace(visits.groups[static_cast<std::size_t>(i)],
                                    Sum{Eigen::RowVectorXd::Zero(visits.terms.cols())})
                       .first->second;
        sum.terms += visits.terms.row(i);
        sum.growth += visits.growth[i];
        ++sum.count;
    }
    Eigen::Index row = 0;
    for (const Eigen::Index i : chosen) {
        const Sum& sum = sums.at(visits.groups[static_cast<std::size_t>(i)]);
        result.terms.row(row) = visits.terms.row(i) - sum.terms / sum.count;
        result.growth[row] = visits.growth[i] - sum.growth / sum.count;
        result.groups.push_back(visits.groups[static_cast<std::size_t>(i)]);
        result.passes.push_back(visits.passes[static_cast<std::size_t>(i)]);
        ++row;
    }
    return result;
}

Eigen::VectorXd solved(const GrowthVisits& its, const Eigen::VectorXd& large, double sigma) {
    Eigen::MatrixXd normal = its.terms.transpose() * its.terms;
    normal.diagonal().array() += (sigma / large.array()).square();
    return normal.ldlt().solve(its.terms.transpose() * its.growth);
}

double rms(const Eigen::VectorXd& values) {
    return values.size() > 0 ? std::sqrt(values.squaredNorm() / static_cast<double>(values.size())) : 0;
}

}  // namespace
}  // namespace growth_identification

IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& large, double sigma) {
    using namespace growth_identification;
    std::vector<Eigen::Index> all;
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i) all.push_back(i);
    const GrowthVisits whole = centred(visits, all);
    IdentifiedGrowth result;
    result.value = solved(whole, large, sigma);
    result.drift = rms(whole.growth);
    result.rest = rms(whole.growth - whole.terms * result.value);
    result.predicted_rest = std::numeric_limits<double>::infinity();

    const int first = *std::min_element(visits.passes.begin(), visits.passes.end());
    const int last = *std::max_element(visits.passes.begin(), visits.passes.end());
    double squares = 0, count = 0;
    for (int left_out = first + 1; left_out <= last; ++left_out) {
        std::vector<Eigen::Index> others, tested;
        for (const Eigen::Index i : all) {
            const int pass = visits.passes[static_cast<std::size_t>(i)];
            if (pass != left_out) others.push_back(i);
            if (pass == left_out || pass == first) tested.push_back(i);
        }
        if (tested.empty() || others.size() < 2) continue;
        const Eigen::VectorXd value = solved(centred(visits, others), large, sigma);
        const GrowthVisits pair = centred(visits, tested);
        const Eigen::VectorXd rest = pair.growth - pair.terms * value;
        // About the mean of two passes a difference shows with half its size.
        squares += 4 * rest.squaredNorm();
        count += static_cast<double>(rest.size());
    }
    if (count > 0) result.predicted_rest = std::sqrt(squares / count);
    return result;
}

}  // namespace plumb
