// SPDX-License-Identifier: GPL-2.0-or-later
#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "components/commissioning/growth/growth_report.hpp"

namespace plumb::commissioning {
namespace {

// A value that is not finite is null in JSON.
template <class Vector>
nlohmann::json reals(const Vector& values) {
    return std::vector<double>(values.data(), values.data() + values.size());
}

nlohmann::json curve_json(const std::optional<GrowthCurve>& curve) {
    if (!curve) return nullptr;
    return {{"determined", curve->determined},
            {"steady_mm", curve->steady},
            {"steady_low_mm", curve->low()},
            {"steady_high_mm", curve->high()},
            {"rate_mm_per_h", curve->rate * seconds_per_hour},
            {"rate_uncertainty_mm_per_h", curve->rate_sigma * seconds_per_hour},
            {"scatter_mm", curve->noise}};
}

nlohmann::json budget_json(const GrowthBudget& budget) {
    return {{"touch_mm", budget.touch},
            {"seat_mm", budget.seat},
            {"drift_mm", budget.drift},
            {"artifact_mm", budget.artifact},
            {"probe_mm", budget.probe},
            {"pass_mm", budget.pass()},
            {"coverage", coverage_factor(budget.freedom)},
            {"freedom", budget.freedom},
            {"expanded_mm", budget.expanded()}};
}

nlohmann::json axis_json(const GrowthOfAxis& axis) {
    if (!axis.probed) return nullptr;
    return {{"largest_mm", axis.largest},       {"at_1_hour_mm", axis.at_1_hour},
            {"at_4_hours_mm", axis.at_4_hours}, {"at_end_mm", axis.at_end},
            {"range_mm", axis.range},           {"largest_rate_mm_per_h", axis.rate},
            {"curve", curve_json(axis.curve)}};
}

nlohmann::json gain_json(const CompensationGain& gain) {
    return {{"determined", gain.determined},
            {"value", gain.determined ? gain.gain : NAN},
            {"uncertainty", gain.determined ? gain.uncertainty : NAN},
            {"effectiveness", gain.determined ? gain.effectiveness : NAN}};
}

nlohmann::json slip_json(const std::optional<GrowthSlip>& slip) {
    if (!slip) return nullptr;
    return {{"before_pass", slip->pass}, {"size_mm", slip->size}};
}

nlohmann::json axes_json(const GrowthAnalysis& test) {
    nlohmann::json j;
    for (std::size_t i = 0; i < 3; ++i)
        j[std::string(1, letters[i])] = {{"tolerance_mm", test.log->tolerance[i]},
                                         {"verdict", word(test.verdicts[i])},
                                         {"uncertainty_mm", test.budgets[i].standard()},
                                         {"of_one_pass_mm", test.of_one_pass(i)},
                                         {"budget", budget_json(test.budgets[i])},
                                         {"off", test.has_off ? axis_json(test.off[i]) : nullptr},
                                         {"on", test.has_on ? axis_json(test.on[i]) : nullptr},
                                         {"gain", gain_json(test.gain[i])},
                                         {"slip", slip_json(test.slips[i])}};
    return j;
}

// By the axis of the compensation and the axis of the drift.
nlohmann::json differences_json(const GrowthAnalysis& test) {
    nlohmann::json j;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            j[std::string(1, letters[row])][std::string(1, letters[column])] =
                test.off[row].probed && test.off[column].probed
                    ? test.finding.difference(static_cast<int>(row), static_cast<int>(column))
                    : NAN;
    return j;
}

nlohmann::json compensation_json(const GrowthAnalysis& test) {
    nlohmann::json j{
        {"name", test.log->compensation},          {"fault", static_cast<int>(test.finding.fault)},
        {"sentence", compensation_sentence(test)}, {"gain", test.finding.gain},
        {"gain_low", test.finding.gain_low},       {"gain_high", test.finding.gain_high},
        {"more_passes", test.finding.more_passes}, {"larger_drift_mm", test.finding.larger_drift}};
    const auto& drifts = test.finding.drifts;
    if (drifts[0] + drifts[1] + drifts[2] > 1) j["differences_mm"] = differences_json(test);
    return j;
}

nlohmann::json turned_json(const GrowthAnalysis::Turned& turned) {
    return {{"bore", turned.bore},
            {"half_sum_mm", reals(turned.table.half_sum)},
            {"half_difference_mm", reals(turned.table.half_difference)},
            {"tilt_about_x_rad", turned.tilt.value_or(NAN)}};
}

nlohmann::json points_json(const std::vector<GrowthPoint>& points) {
    nlohmann::json all = nlohmann::json::array();
    for (const GrowthPoint& point : points)
        all.push_back({{"pass", point.pass},
                       {"part", point.part},
                       {"time_s", point.time},
                       {"deviation_mm", reals(point.deviation)},
                       {"compensation_mm", reals(point.compensation)},
                       {"diameter_mm", point.diameter},
                       {"scatter_mm", point.scatter}});
    return all;
}

nlohmann::json series_json(const GrowthSeries& series) {
    return {{"bore", series.bore},
            {"name", series.name()},
            {"turned", series.turned},
            {"compensated", series.compensated},
            {"points", points_json(series.points)},
            {"cool_down", points_json(series.cool_down)}};
}

nlohmann::json practice_json(const GrowthAnalysis& test) {
    const GrowthPractice& practice = test.practice;
    const ArtifactExpansion& expansion = test.expansion;
    nlohmann::json j{{"cool_down_s", practice.cooled_for},
                     {"artifact",
                      {{"applied", expansion.applied},
                       {"largest_mm", reals(expansion.largest)},
                       {"coldest_k", expansion.coldest},
                       {"warmest_k", expansion.warmest},
                       {"why_not", expansion.applied ? "" : expansion.why_not}}}};
    if (const auto& artifact = test.log->artifact) {
        j["artifact"]["expansion"] = artifact->expansion;
        j["artifact"]["uncertainty"] = artifact->uncertainty;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::string axis(1, letters[i]);
        if (const auto& its = practice.cool_down[i])
            j["cool_down"][axis] = {
                {"warm_mm", its->warm}, {"left_mm", its->left}, {"largest_rate_mm_per_h", its->rate}};
        if (const auto& its = practice.ends[i])
            j["ends"][axis] = {{"low_bore", its->low},
                               {"high_bore", its->high},
                               {"low_mm", its->at_low},
                               {"high_mm", its->at_high},
                               {"distance_mm", its->distance},
                               {"expansion", its->strain},
                               {"uncertainty", its->strain_sigma}};
    }
    for (const auto& [name, range] : practice.ranges) j["temperature_ranges_k"][name] = range;
    j["probe"] = {{"largest_mm", test.probe.largest()},
                  {"uncertainty_mm", test.probe.sigma},
                  {"seen", test.probe.seen()},
                  {"passes", nlohmann::json::array()}};
    for (const ProbeDrift::Pass& pass : test.probe.passes)
        j["probe"]["passes"].push_back(
            {{"pass", pass.number}, {"time_s", pass.time}, {"change_mm", pass.change}});
    return j;
}

// At most 400 values of a sensor, for a chart.
nlohmann::json temperatures_json(const GrowthAnalysis& test) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& [sensor, samples] : test.temperatures) {
        nlohmann::json its{{"name", test.sensor_name(sensor)}};
        for (std::size_t i = 0; i < samples.size(); i += samples.size() / 400 + 1) {
            its["time_s"].push_back(samples[i].first);
            its["value"].push_back(samples[i].second);
        }
        all.push_back(std::move(its));
    }
    return all;
}

nlohmann::json test_json(const GrowthAnalysis& test) {
    const GrowthLog& log = *test.log;
    nlohmann::json j;
    j["log"] = log.file;
    j["machine"] = log.machine;
    j["begun"] = log.begun;
    j["title"] = log.title();
    j["warming"] = log.warming;
    j["clause"] = clause(log);
    j["duration_s"] = test.duration;
    j["passes"] = test.passes;
    j["parts"] = test.parts;
    j["breaks_s"] = test.breaks;
    j["has_off"] = test.has_off;
    j["has_on"] = test.has_on;
    j["duty_changed"] = test.duty_changed;
    j["temperatures_degc"] = temperatures_json(test);
    j["stop"] = test.stop == growth_test::Stop::stable         ? "stable"
                : test.stop == growth_test::Stop::maximum_time ? "maximum time"
                                                               : "not reached";
    const hal::Said status = growth_test::said_of_log(test.stop);
    j["status"] = {{"kind", hal::name(status.kind)}, {"sentence", status.sentence}};
    j["verdict"] = word(test.verdict);
    j["reasons"] = test.reasons;
    j["notes"] = test.notes;
    j["uncertainty_mm"] = test.uncertainty;
    j["touch_scatter_mm"] = test.touch_scatter;
    j["last_hour_mm"] = test.last_hour;
    j["axes"] = axes_json(test);
    j["compensation"] = compensation_json(test);
    if (test.identified)
        j["identified"] = growth_identified_json(*test.identified),
        j["settings"] = growth_settings(log.file, log.begun, *test.identified);
    else
        j["identified"] = nullptr, j["not_identified"] = test.not_identified;
    j["practice"] = practice_json(test);
    j["orientations"] = nlohmann::json::array();
    for (const GrowthAnalysis::Turned& turned : test.turned) j["orientations"].push_back(turned_json(turned));
    j["series"] = nlohmann::json::array();
    for (const GrowthSeries& series : test.series) j["series"].push_back(series_json(series));
    return j;
}

}  // namespace

std::string growth_json(const std::vector<GrowthAnalysis>& tests) {
    nlohmann::json all;
    all["version"] = 1;
    all["version_of_plumb"] = PLUMB_VERSION;
    for (const GrowthAnalysis& test : tests) all["tests"].push_back(test_json(test));
    return all.dump(1) + '\n';
}

}  // namespace plumb::commissioning
