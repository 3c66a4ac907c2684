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

// Passes that were probed without and with compensation, in one order.
class PassesOfBoth {
public:
    explicit PassesOfBoth(const GrowthAnalysis& analysis)
        : off_(means_of(analysis, false)), on_(means_of(analysis, true)) {
        for (std::size_t i = 0; i < off_.pass.size(); ++i)
            for (std::size_t j = 0; j < on_.pass.size(); ++j)
                if (off_.pass[i] == on_.pass[j]) both_.emplace_back(i, j);
    }

    Eigen::Index count() const { return static_cast<Eigen::Index>(both_.size()); }
    int number(Eigen::Index k) const { return off_.pass[at(k).first]; }
    const Eigen::Vector3d& off(Eigen::Index k) const { return off_.deviation[at(k).first]; }
    const Eigen::Vector3d& on(Eigen::Index k) const { return on_.deviation[at(k).second]; }
    const Eigen::Vector3d& compensation(Eigen::Index k) const { return on_.compensation[at(k).second]; }

private:
    const std::pair<std::size_t, std::size_t>& at(Eigen::Index k) const {
        return both_[static_cast<std::size_t>(k)];
    }

    GrowthMeans off_, on_;
    std::vector<std::pair<std::size_t, std::size_t>> both_;
};

void compare_axes(GrowthAnalysis& analysis, const PassesOfBoth& passes, CompensationRecord& record) {
    record.drift.resize(passes.count(), 3);
    record.compensation.resize(passes.count(), 3);
    Eigen::MatrixX3d residual(passes.count(), 3);
    for (Eigen::Index k = 0; k < passes.count(); ++k) {
        record.drift.row(k) = passes.off(k).transpose();
        residual.row(k) = passes.on(k).transpose();
        record.compensation.row(k) = passes.compensation(k).transpose();
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        if (!analysis.off[i].probed) {
            record.drift.col(axis).setZero();
            record.compensation.col(axis).setZero();
            continue;
        }
        CompensationGain& gain = analysis.gain[i];
        gain = compensation_gain(record.drift.col(axis), residual.col(axis), analysis.of_one_pass(i));
        if (gain.determined) gain.effectiveness = 1 - analysis.on[i].largest / analysis.off[i].largest;
    }
}

// The sensors that have a temperature in each pass.
std::vector<int> add_temperatures(GrowthAnalysis& analysis, const PassesOfBoth& passes,
                                  CompensationRecord& record) {
    std::vector<int> sensors;
    const auto times = times_of_passes(*analysis.log);
    record.temperatures.resize(passes.count(), 0);
    for (const auto& [sensor, samples] : analysis.temperatures) {
        Eigen::VectorXd column(passes.count());
        for (Eigen::Index k = 0; k < passes.count(); ++k)
            column[k] = temperature_in(samples, times.at(passes.number(k)));
        if (!column.allFinite()) continue;
        record.temperatures.conservativeResize(Eigen::NoChange, record.temperatures.cols() + 1);
        record.temperatures.rightCols(1) = column;
        sensors.push_back(sensor);
        analysis.logged_sensors.push_back(analysis.sensor_name(sensor));
    }
    return sensors;
}

// Each visit with compensation, and the temperatures about it; none if one of these is unknown.
void add_visits(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits,
                const std::vector<int>& sensors, CompensationRecord& record) {
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
}

}  // namespace

void judge_compensation(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits) {
    if (!analysis.has_off || !analysis.has_on) return;
    const PassesOfBoth passes(analysis);
    CompensationRecord record;
    std::array<double, 3> sorted = analysis.of_mean;
    std::sort(sorted.begin(), sorted.end());
    record.uncertainty = sorted[1];
    compare_axes(analysis, passes, record);
    const std::vector<int> sensors = add_temperatures(analysis, passes, record);
    add_visits(analysis, visits, sensors, record);
    analysis.finding = judged_compensation(record);
}

}  // namespace plumb::commissioning
