// SPDX-License-Identifier: GPL-2.0-or-later
#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <string>

#include "components/commissioning/growth/growth_report.hpp"
#include "components/commissioning/growth/growth_words.hpp"

namespace plumb::commissioning {
namespace {

nlohmann::json real(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}
nlohmann::json reals(const Eigen::VectorXd& values) {
    nlohmann::json list = nlohmann::json::array();
    for (const double value : values) list.push_back(real(value));
    return list;
}

nlohmann::json fit_json(const std::optional<ExponentialFit>& fit) {
    if (!fit) return nullptr;
    return {{"a_mm", fit->a},
            {"b_mm", fit->b},
            {"tau_s", fit->tau},
            {"determined", fit->determined},
            {"steady_mm", fit->steady},
            {"steady_low_mm", fit->determined ? real(fit->steady_low) : nullptr},
            {"steady_high_mm", fit->determined ? real(fit->steady_high) : nullptr},
            {"steady_uncertainty_mm", real(fit->steady_uncertainty())},
            {"scatter_mm", fit->scatter},
            {"rate_mm_per_s", fit->rate},
            {"time_to_95_percent_s", fit->time_to_95}};
}

nlohmann::json axis_json(const GrowthOfAxis& axis) {
    if (!axis.probed) return nullptr;
    return {{"largest_mm", axis.largest},
            {"at_1_hour_mm", real(axis.at_1_hour)},
            {"at_4_hours_mm", real(axis.at_4_hours)},
            {"at_end_mm", real(axis.at_end)},
            {"range_mm", axis.range},
            {"largest_rate_mm_per_h", axis.rate},
            {"exponential", fit_json(axis.fit)}};
}

nlohmann::json test_json(const GrowthAnalysis& test) {
    const GrowthLog& log = *test.log;
    nlohmann::json j;
    j["log"] = log.file;
    j["machine"] = log.machine;
    j["begun"] = log.begun;
    j["clause"] = clause(log);
    j["duration_s"] = test.duration;
    j["passes"] = test.passes;
    j["stop"] = test.stop == 1 ? "stable" : test.stop == 2 ? "maximum time" : "not reached";
    j["verdict"] = word(test.verdict);
    j["reasons"] = test.reasons;
    j["notes"] = test.notes;
    j["uncertainty_mm"] = test.uncertainty;
    j["touch_scatter_mm"] = test.touch_scatter;
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        nlohmann::json& its = j["axes"][std::string(1, letters[axis])];
        its["tolerance_mm"] = log.tolerance[i];
        its["verdict"] = word(test.verdicts[i]);
        its["uncertainty_mm"] = test.uncertainties[i];
        its["off"] = test.has_off ? axis_json(test.off[i]) : nullptr;
        its["on"] = test.has_on ? axis_json(test.on[i]) : nullptr;
        const CompensationGain& gain = test.gain[i];
        its["gain"] = {{"determined", gain.determined},
                       {"value", gain.determined ? real(gain.gain) : nullptr},
                       {"uncertainty", gain.determined ? real(gain.uncertainty) : nullptr},
                       {"effectiveness", gain.determined ? real(gain.effectiveness) : nullptr}};
    }
    j["compensation"] = {{"name", log.compensation},
                         {"fault", static_cast<int>(test.finding.fault)},
                         {"sentence", compensation_sentence(test)},
                         {"gain", test.finding.gain}};
    const CrossGains& cross = test.finding.cross;
    const bool any = cross.drifts[0] || cross.drifts[1] || cross.drifts[2];
    for (int row = 0; any && row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            const bool known = cross.determined[static_cast<std::size_t>(column)];
            const bool drifts = cross.drifts[static_cast<std::size_t>(column)];
            const bool probed = test.off[static_cast<std::size_t>(row)].probed &&
                                test.off[static_cast<std::size_t>(column)].probed;
            j["compensation"]["cross_gains"][std::string(1, letters[row])][std::string(1, letters[column])] =
                {{"value", drifts ? real(cross.gain(row, column)) : nullptr},
                 {"uncertainty", drifts ? real(cross.uncertainty(row, column)) : nullptr},
                 {"determined", known},
                 {"difference_mm", probed ? real(cross.difference(row, column)) : nullptr}};
        }
    if (test.identified)
        j["identified"] = growth_identified_json(*test.identified);
    else
        j["identified"] = nullptr, j["not_identified"] = test.not_identified;
    if (test.rigid) {
        nlohmann::json& its = j["rigid_part"];
        its["rank"] = test.rigid->rank;
        its["bores"] = test.rigid_bores;
        its["rms_of_rest_mm"] = test.rigid->rms;
        for (std::size_t i = 0; i < RigidPart::names.size(); ++i)
            its["parameters"][RigidPart::names[i]] = {
                {"value", test.rigid->value[static_cast<Eigen::Index>(i)]},
                {"uncertainty", test.rigid->per_unit[static_cast<Eigen::Index>(i)] * test.uncertainty},
                {"determined", test.rigid->determined[i]}};
        for (Eigen::Index i = 0; i < test.rigid->rest.rows(); ++i)
            its["rest_mm"].push_back(reals(test.rigid->rest.row(i).transpose()));
    }
    j["orientations"] = nlohmann::json::array();
    for (const GrowthAnalysis::Turned& turned : test.turned)
        j["orientations"].push_back({{"bore", turned.bore},
                                     {"half_sum_mm", reals(turned.table.half_sum)},
                                     {"half_difference_mm", reals(turned.table.half_difference)},
                                     {"tilt_about_x_rad", turned.tilt ? real(*turned.tilt) : nullptr}});
    j["series"] = nlohmann::json::array();
    for (const GrowthSeries& series : test.series) {
        nlohmann::json points = nlohmann::json::array();
        for (const GrowthPoint& point : series.points)
            points.push_back({{"pass", point.pass},
                              {"time_s", point.time},
                              {"deviation_mm", reals(point.deviation)},
                              {"compensation_mm", reals(point.compensation)},
                              {"diameter_mm", point.diameter},
                              {"scatter_mm", point.scatter}});
        j["series"].push_back({{"bore", series.bore},
                               {"turned", series.turned},
                               {"compensated", series.compensated},
                               {"points", points}});
    }
    return j;
}

}  // namespace

std::string growth_json(const std::vector<GrowthAnalysis>& tests) {
    nlohmann::json all;
    all["version"] = 1;
    for (const GrowthAnalysis& test : tests) all["tests"].push_back(test_json(test));
    return all.dump(1) + '\n';
}

}  // namespace plumb::commissioning
