// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

// Over the pass, as the compensation in it is a mean, too; else the last value before it.
double temperature_in(const std::vector<std::pair<double, double>>& samples,
                      const std::pair<double, double>& pass) {
    double sum = 0, before = GrowthVisit::none;
    int count = 0;
    for (const auto& [when, degrees] : samples) {
        if (when < pass.first) before = degrees;
        if (when < pass.first || when > pass.second) continue;
        sum += degrees;
        ++count;
    }
    return count > 0 ? sum / count : before;
}

std::map<int, std::pair<double, double>> times_of_passes(const GrowthLog& log) {
    std::map<int, std::pair<double, double>> times;
    for (const GrowthRecord& r : log.records)
        if (r.kind == GrowthRecord::touch)
            times.try_emplace(r.pass, r.time, r.time).first->second.second = r.time;
    return times;
}

}  // namespace

void judge_compensation(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits) {
    if (!analysis.has_off || !analysis.has_on) return;
    const GrowthMeans off = means_of(analysis, false), on = means_of(analysis, true);
    std::vector<std::pair<std::size_t, std::size_t>> both;
    for (std::size_t i = 0; i < off.pass.size(); ++i)
        for (std::size_t j = 0; j < on.pass.size(); ++j)
            if (off.pass[i] == on.pass[j]) both.emplace_back(i, j);
    const auto passes = static_cast<Eigen::Index>(both.size());
    CompensationRecord record;
    std::array<double, 3> sorted = analysis.uncertainties;
    std::sort(sorted.begin(), sorted.end());
    record.uncertainty = sorted[1];
    record.drift.resize(passes, 3);
    record.compensation.resize(passes, 3);
    Eigen::MatrixX3d residual(passes, 3);
    for (Eigen::Index k = 0; k < passes; ++k) {
        const auto [i, j] = both[static_cast<std::size_t>(k)];
        record.drift.row(k) = off.deviation[i].transpose();
        residual.row(k) = on.deviation[j].transpose();
        record.compensation.row(k) = on.compensation[j].transpose();
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!analysis.off[static_cast<std::size_t>(axis)].probed) {
            record.drift.col(axis).setZero();
            record.compensation.col(axis).setZero();
            continue;
        }
        CompensationGain& gain = analysis.gain[static_cast<std::size_t>(axis)];
        gain = compensation_gain(record.drift.col(axis), residual.col(axis),
                                 analysis.uncertainties[static_cast<std::size_t>(axis)]);
        const double most = analysis.off[static_cast<std::size_t>(axis)].largest;
        if (gain.determined)
            gain.effectiveness = 1 - analysis.on[static_cast<std::size_t>(axis)].largest / most;
    }
    std::vector<std::vector<double>> columns;
    std::vector<int> sensors;
    const auto times = times_of_passes(*analysis.log);
    for (const auto& [sensor, samples] : analysis.temperatures) {
        std::vector<double> column;
        for (const auto& [i, j] : both) column.push_back(temperature_in(samples, times.at(off.pass[i])));
        if (std::any_of(column.begin(), column.end(), [](double value) { return !std::isfinite(value); }))
            continue;
        columns.push_back(column);
        sensors.push_back(sensor);
        const auto name = analysis.log->sensors.find(sensor);
        analysis.logged_sensors.push_back(
            name == analysis.log->sensors.end() ? "sensor " + std::to_string(sensor) : name->second);
    }
    record.temperatures.resize(passes, static_cast<Eigen::Index>(columns.size()));
    for (std::size_t s = 0; s < columns.size(); ++s)
        for (Eigen::Index k = 0; k < passes; ++k)
            record.temperatures(k, static_cast<Eigen::Index>(s)) = columns[s][static_cast<std::size_t>(k)];
    std::vector<const GrowthVisit*> compensated;
    for (const GrowthVisit& visit : visits)
        if (visit.compensated) compensated.push_back(&visit);
    record.visit_temperatures.resize(static_cast<Eigen::Index>(compensated.size()),
                                     record.temperatures.cols());
    record.visit_compensation.resize(static_cast<Eigen::Index>(compensated.size()), 3);
    for (Eigen::Index i = 0; i < record.visit_compensation.rows(); ++i) {
        const GrowthVisit& visit = *compensated[static_cast<std::size_t>(i)];
        record.visit_compensation.row(i) = visit.compensation.transpose();
        for (std::size_t s = 0; s < sensors.size(); ++s)
            record.visit_temperatures(i, static_cast<Eigen::Index>(s)) =
                temperature_in(analysis.temperatures[sensors[s]], {visit.time - 60, visit.time + 60});
    }
    if (!record.visit_temperatures.allFinite())
        record.visit_temperatures.resize(0, record.temperatures.cols());
    analysis.finding = judged_compensation(record);
}

}  // namespace plumb::commissioning
