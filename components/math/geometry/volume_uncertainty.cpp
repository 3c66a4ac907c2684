// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/volume_uncertainty.hpp"

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/random.hpp"
#include "components/math/geometry/tip_correction.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>

namespace plumb {
namespace {

using Directions = std::array<int, 4>;  // 1 to the + end, -1 to the - end

// A machine that may stand at any place. The motions of its axes are read from its tables.
class Machine {
public:
    bool directed() const {
        return std::any_of(halves_.begin(), halves_.end(), [](const auto& its) { return its.has_value(); });
    }

    explicit Machine(const MeasuredVolume& its) : chain_(its.chain), pivot_(its.pivot) {
        for (std::size_t i = 0; i < its.means.size(); ++i) {
            if (its.means[i].empty()) continue;
            means_[i].emplace(its.means[i]);
            if (!its.halves[i].empty()) halves_[i].emplace(its.halves[i]);
        }
        for (const AxisBranch& branch : {its.chain.axes.work, its.chain.axes.tool})
            for (const Axis axis : branch) axes_[static_cast<std::size_t>(coordinate(axis))] = axis;
    }

    // The chain with the errors at q, which counts from the pivot.
    const KinematicChain& at(const AxisPosition& q, const Directions& d) {
        for (std::size_t i = 0; i < means_.size(); ++i) {
            if (!means_[i] || !axes_[i]) continue;
            const auto k = static_cast<Eigen::Index>(i);
            const ErrorTable::Reading mean = means_[i]->at(q[k] + pivot_[k]);
            const ErrorTable::Reading half =
                halves_[i] ? halves_[i]->at(q[k] + pivot_[k]) : ErrorTable::Reading{};
            AxisError error;
            error.position = q[k];
            for (int e = 0; e < 3; ++e) {
                const auto t = static_cast<std::size_t>(e), a = t + 3;
                error.value.translation[e] = mean.errors[t] + d[i] * half.errors[t];
                error.slope.translation[e] = mean.slopes[t] + d[i] * half.slopes[t];
                error.value.angles[e] = mean.errors[a] + d[i] * half.errors[a];
                error.slope.angles[e] = mean.slopes[a] + d[i] * half.slopes[a];
            }
            chain_.set_error(*axes_[i], error);
        }
        return chain_;
    }

    Eigen::Vector3d correction(const AxisPosition& q, const Eigen::Vector3d& tool, const Directions& d,
                               double most) {
        Eigen::Vector3d c = Eigen::Vector3d::Zero();
        for (int step = 0; step < 4; ++step)
            c = TipCorrection(at(TipCorrection::corrected(q, c), d)).at(q, tool, c).offset;
        return c.unaryExpr([most](double x) { return bounded(x, most); });
    }

    Eigen::Vector3d error(const AxisPosition& q, const Eigen::Vector3d& c, const Eigen::Vector3d& tool,
                          const Eigen::Vector3d& nominal_tool, const Directions& d) {
        const AxisPosition there = TipCorrection::corrected(q, c);
        const KinematicChain& chain = at(there, d);
        return chain.tip(there, tool).place - chain.ideal_tip(q, nominal_tool);
    }

private:
    KinematicChain chain_;
    AxisPosition pivot_;
    PerAxis<std::optional<ErrorTable>> means_, halves_;
    std::array<std::optional<Axis>, 7> axes_;
};

// The farthest that the tip is from its corrected place if squareness knows no direction of motion, and takes
// the mean of both: half of the lost motion of each axis.
double unknown_direction(Machine& machine, const AxisPosition& q, const Eigen::Vector3d& tool, double most) {
    if (!machine.directed()) return 0;
    const Eigen::Vector3d c = machine.correction(q, tool, {}, most);
    double farthest = 0;
    for (int bits = 0; bits < 16; ++bits) {
        Directions d;
        for (std::size_t i = 0; i < d.size(); ++i) d[i] = bits >> i & 1 ? 1 : -1;
        const Eigen::Vector3d known = machine.error(q, machine.correction(q, tool, d, most), tool, tool, d);
        farthest = std::max(farthest, (machine.error(q, c, tool, tool, d) - known).norm());
    }
    return farthest;
}

MeasuredVolume changed(const MeasuredVolume& from, const std::vector<double>& amounts) {
    MeasuredVolume to = from;
    for (std::size_t s = 0; s < from.sources.size(); ++s) {
        for (const UncertaintySource::Angle& angle : from.sources[s].angles)
            to.chain.tilts[angle.axis].angles[angle.rotation] += amounts[s] * angle.factor;
        for (const UncertaintySource::Row& row : from.sources[s].rows)
            (row.half ? to.halves : to.means)[row.axis][row.row].errors[row.error] += amounts[s] * row.factor;
    }
    return to;
}

Eigen::Vector3d tool_change(const MeasuredVolume& its, const std::vector<double>& amounts) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t s = 0; s < its.sources.size(); ++s) sum += amounts[s] * its.sources[s].tool;
    return sum;
}

}  // namespace

VolumeUncertainty uncertainty_of(const MeasuredVolume& measured, const VolumePlace& reference,
                                 const std::vector<VolumePlace>& places, int draws, std::uint64_t seed) {
    // A corner for each direction of all axes: the lost motion that remains differs from one to the other.
    constexpr Directions up = {1, 1, 1, 1}, down = {-1, -1, -1, -1};
    std::vector<VolumePlace> all = places;
    all.push_back(reference);
    Machine as_measured(measured);
    struct Corrected {
        AxisPosition q;
        std::array<Eigen::Vector3d, 2> c, rest;
        Eigen::Vector3d without;
    };
    std::vector<Corrected> corrected;
    for (const VolumePlace& place : all) {
        Corrected its;
        its.q = place.position - measured.pivot;
        its.without = as_measured.error(its.q, Eigen::Vector3d::Zero(), place.tool, place.tool, {});
        for (std::size_t way = 0; way < 2; ++way) {
            const Directions& d = way == 0 ? up : down;
            its.c[way] = as_measured.correction(its.q, place.tool, d, measured.max_correction);
            its.rest[way] = as_measured.error(its.q, its.c[way], place.tool, place.tool, d);
        }
        corrected.push_back(its);
    }
    const auto error_at = [&](Machine& machine, std::size_t i, std::size_t way, const Eigen::Vector3d& tool) {
        return machine.error(corrected[i].q, corrected[i].c[way], all[i].tool + tool, all[i].tool,
                             way == 0 ? up : down);
    };

    Random random(seed, 'v');
    const std::size_t count = places.size();
    std::vector<Eigen::Vector3d> sums(count, Eigen::Vector3d::Zero());
    std::vector<Eigen::Matrix3d> squares(count, Eigen::Matrix3d::Zero());
    const auto noise = [&] {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const UncertaintySource& source : measured.sources)
            for (int i = 0; i < 3; ++i)
                if (source.tip[i] != 0) sum[i] += source.tip[i] * random.gaussian();
        return sum;
    };
    std::vector<double> amounts(measured.sources.size());
    for (int draw = 0; draw < draws; ++draw) {
        for (double& amount : amounts) amount = random.gaussian();
        Machine machine(changed(measured, amounts));
        const Eigen::Vector3d tool = tool_change(measured, amounts);
        const std::size_t way_there = random.index(2) == 0 ? 0 : 1;
        const Eigen::Vector3d there = error_at(machine, count, way_there, tool) + noise();
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t way = random.index(2) == 0 ? 0 : 1;
            const Eigen::Vector3d D = error_at(machine, i, way, tool) + noise() - there -
                                      (corrected[i].rest[way] - corrected[count].rest[way_there]);
            sums[i] += D;
            squares[i] += D * D.transpose();
        }
    }
    VolumeUncertainty result;
    const double n = draws;
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Matrix3d covariance = (squares[i] - sums[i] * sums[i].transpose() / n) / (n - 1);
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
        PlaceUncertainty its;
        its.U = 2 * std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
        its.by_axis = 2 * covariance.diagonal().cwiseMax(0).cwiseSqrt();
        its.rest = corrected[i].rest[0] - corrected[count].rest[0];
        its.without = corrected[i].without - corrected[count].without;
        its.covariance = covariance;
        its.unknown = unknown_direction(as_measured, corrected[i].q, all[i].tool, measured.max_correction);
        const KinematicChain ideal(measured.chain);
        its.distance = (ideal.ideal_slopes() * (corrected[i].q - corrected[count].q)).norm();
        if (result.places.empty() || its.U > result.places[result.worst].U) {
            result.worst = i;
            direction = solver.eigenvectors().col(2);
        }
        result.places.push_back(its);
    }

    // Shares of the variance in the worst direction: the causes are independent, and their effects linear.
    std::map<std::string, double> variance;
    double sum = 0;
    std::fill(amounts.begin(), amounts.end(), 0);
    for (std::size_t s = 0; s < amounts.size() && count > 0; ++s) {
        amounts[s] = 1;
        Machine machine(changed(measured, amounts));
        const Eigen::Vector3d tool = tool_change(measured, amounts);
        double part = 2 * std::pow(measured.sources[s].tip.dot(direction), 2);
        for (const std::size_t way : {0, 1})
            for (const std::size_t way_there : {0, 1})
                part +=
                    std::pow((error_at(machine, result.worst, way, tool) - corrected[result.worst].rest[way] -
                              error_at(machine, count, way_there, tool) + corrected[count].rest[way_there])
                                 .dot(direction),
                             2) /
                    4;
        amounts[s] = 0;
        variance[measured.sources[s].name] += part;
        sum += part;
    }
    for (const auto& [name, part] : variance) result.shares.push_back({name, sum > 0 ? part / sum : 0});
    std::sort(result.shares.begin(), result.shares.end(),
              [](const Share& a, const Share& b) { return a.part > b.part; });
    return result;
}

}  // namespace plumb
