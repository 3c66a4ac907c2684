// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/compensation_effect.hpp"

#include <Eigen/Cholesky>

namespace plumb {
namespace {

// The law of the compensation c, relative to the first pass, in a choice of the sensors: one bit each.
struct SensorLaw {
    Eigen::MatrixXd law;  // mu/K, a row for each sensor, 0 where it was not chosen
    double rest = 0;      // mu²
};

SensorLaw sensor_law(const Eigen::MatrixXd& warm, const Eigen::MatrixX3d& c, unsigned chosen) {
    constexpr double sensor_noise = 0.03;  // K
    Eigen::MatrixXd terms = warm;
    for (Eigen::Index i = 0; i < terms.cols(); ++i)
        if ((chosen >> i & 1U) == 0) terms.col(i).setZero();
    Eigen::MatrixXd normal = terms.transpose() * terms;
    normal.diagonal().array() += sensor_noise * sensor_noise * static_cast<double>(terms.rows());
    SensorLaw result;
    result.law = normal.ldlt().solve(terms.transpose() * c);
    result.rest = (terms * result.law - c).squaredNorm();
    return result;
}

}  // namespace

SwappedSensors swapped_sensors(const CompensationRecord& record, const Eigen::MatrixX3d& c) {
    SwappedSensors best;
    const Eigen::Index sensors = record.temperatures.cols(), passes = record.drift.rows();
    if (sensors < 2 || sensors > 8 || passes <= sensors) return best;
    const Eigen::MatrixXd t = record.temperatures.rowwise() - record.temperatures.row(0);
    const bool by_visit = record.visit_temperatures.rows() > passes;
    Eigen::MatrixXd warm = by_visit ? record.visit_temperatures : t;
    Eigen::MatrixX3d found = by_visit ? record.visit_compensation : c;
    warm.rowwise() -= warm.colwise().mean().eval();
    found.rowwise() -= found.colwise().mean().eval();
    const unsigned all = (1U << sensors) - 1;
    const double least = sensor_law(warm, found, all).rest;
    const auto freedom = [&](Eigen::Index terms) { return static_cast<double>(warm.rows() - 1 - terms); };
    if (!(freedom(sensors) > 0)) return best;
    const double noise = 8 * record.uncertainty * record.uncertainty * static_cast<double>(warm.rows());
    if (!(least < 0.1 * found.squaredNorm() + noise)) return best;  // it follows other sensors
    const auto count = [](unsigned bits) {
        int n = 0;
        for (; bits != 0; bits &= bits - 1) ++n;
        return n;
    };
    for (int size = 1; size <= sensors && best.sensor < 0; ++size)
        for (unsigned chosen = 1; chosen <= all; ++chosen) {
            if (count(chosen) != size) continue;
            const SensorLaw its = sensor_law(warm, found, chosen);
            if (its.rest / freedom(size) > 2 * least / freedom(sensors)) continue;
            for (int i = 0; i < sensors; ++i)
                for (int j = i + 1; j < sensors; ++j) {
                    if ((chosen >> i & 1U) == 0 && (chosen >> j & 1U) == 0) continue;
                    Eigen::MatrixXd exchanged = its.law;
                    exchanged.row(i).swap(exchanged.row(j));
                    const double rest = (t * exchanged - record.drift).squaredNorm();
                    if (rest >= best.rest) continue;
                    best = {i, j, rest};
                }
        }
    return best;
}

}  // namespace plumb
