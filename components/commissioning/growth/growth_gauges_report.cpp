// SPDX-License-Identifier: GPL-2.0-or-later
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "components/commissioning/growth/growth_gauges.hpp"
#include "components/commissioning/growth/growth_report.hpp"

namespace plumb::commissioning {
namespace {

using Quantity = GrowthGauges::Quantity;

struct Column {
    const char *title, *key;  // of the JSON
    double (*value)(const Quantity&);
};

std::vector<Column> columns_of(const GrowthGauges& test) {
    if (test.environment)
        return {{"range", "range", [](const Quantity& its) { return its.range; }},
                {"rate per h", "rate_per_h", [](const Quantity& its) { return its.rate; }},
                {"U", "expanded", [](const Quantity& its) { return its.expanded; }}};
    std::vector<Column> all{{"1 h", "at_1_hour", [](const Quantity& its) { return its.at_1_hour; }},
                            {"4 h", "at_4_hours", [](const Quantity& its) { return its.at_4_hours; }},
                            {"warm", "warm", [](const Quantity& its) { return its.warm; }},
                            {"range", "range", [](const Quantity& its) { return its.range; }},
                            {"rate per h", "rate_per_h", [](const Quantity& its) { return its.rate; }},
                            {"U", "expanded", [](const Quantity& its) { return its.expanded; }}};
    if (test.cooled > 0) {
        all.push_back({"after rest", "left", [](const Quantity& its) { return its.left; }});
        all.push_back(
            {"its rate", "cooling_rate_per_h", [](const Quantity& its) { return its.cooling_rate; }});
    }
    return all;
}

std::string prediction(const GrowthGauges& test, const Quantity& its) {
    if (test.environment || !its.curve) return "";
    if (!test.steady_duty) return "not determined: the spindle speed changed";
    if (its.curve->shorter) {
        const double last = test.environment ? its.left : its.warm;
        const bool rises = its.curve->steady > last;
        return (rises ? "at least " : "at most ") +
               number(rises ? std::max(its.curve->low(), last) : std::min(its.curve->high(), last)) +
               ", as the record is shorter than two of the slowest time constant";
    }
    return (its.curve->determined ? number(its.curve->steady) + ", " : "not determined, ") + "between " +
           number(its.curve->low()) + " and " + number(its.curve->high());
}

std::string times(const GrowthGauges& test) {
    if (test.environment) return number(test.length / seconds_per_hour) + " h, the spindle stood";
    return number(test.warmed / seconds_per_hour) + " h of work, " + number(test.cooled / seconds_per_hour) +
           " h of rest";
}

}  // namespace

std::string GrowthGauges::clause() const {
    std::string its = std::string(environment ? "Environmental temperature variation error"
                                              : "Thermal distortion caused by rotating spindle") +
                      ", after ISO 230-3";
    for (std::size_t i = 0; i < missing.size(); ++i)
        its += (i == 0 ? ". Not a whole test after it: " : "; ") + missing[i];
    return its + ".";
}

std::string GrowthGauges::text() const {
    std::ostringstream out;
    out << file << "\n  " << taken << "\n  " << clause() << "\n  " << times(*this) << "\n\n";
    const auto cell = [&](const std::string& text, int width) {
        char padded[80];
        std::snprintf(padded, sizeof padded, "%*s", width, text.c_str());
        out << padded;
    };
    cell("", -16);
    for (const Column& column : columns_of(*this)) cell(column.title, 11);
    out << '\n';
    for (const Quantity& its : quantities) {
        cell("  " + its.name, -16);
        for (const Column& column : columns_of(*this)) {
            const double value = column.value(its);
            cell(std::isfinite(value) ? number(value) : "-", 11);
        }
        out << "  " << its.unit << '\n';
    }
    if (!environment)
        for (const Quantity& its : quantities)
            out << "  Steady state of " << its.name << ", " << its.unit << ": " << prediction(*this, its)
                << '\n';
    for (const auto& [name, range] : ranges) out << "  " << name << " changed by " << number(range) << " K\n";
    return out.str();
}

nlohmann::json GrowthGauges::json(const GrowthCourse& course) const {
    nlohmann::json all{
        {"file", file},       {"taken", taken},       {"clause", clause()}, {"environment", environment},
        {"length_s", length}, {"warmed_s", warmed},   {"cooled_s", cooled}, {"interval_s", interval},
        {"missing", missing}, {"times", times(*this)}};
    for (const Column& column : columns_of(*this))
        all["columns"].push_back({{"title", column.title}, {"key", column.key}});
    for (const Quantity& its : quantities) {
        nlohmann::json& j = all["quantities"][its.name];
        j = {{"unit", its.unit},
             {"at_1_hour", its.at_1_hour},
             {"at_4_hours", its.at_4_hours},
             {"warm", its.warm},
             {"range", its.range},
             {"rate_per_h", its.rate},
             {"expanded", its.expanded},
             {"left", its.left},
             {"cooling_rate_per_h", its.cooling_rate},
             {"prediction", prediction(*this, its)}};
        for (std::size_t i = 0; i < its.samples.size(); i += its.samples.size() / 400 + 1) {  // for a chart
            j["time_s"].push_back(its.samples[i].first);
            j["value"].push_back(its.samples[i].second);
        }
        if (its.curve && !environment)
            j["steady"] = {{"determined", its.curve->determined && steady_duty},
                           {"value", its.curve->steady},
                           {"shorter_than_two_time_constants", its.curve->shorter},
                           {"low", its.curve->low()},
                           {"high", its.curve->high()}};
    }
    for (const auto& [name, range] : ranges) all["temperature_ranges_k"][name] = range;
    const auto samples_json = [](const GrowthSamples& samples) {
        nlohmann::json both{{"time_s", nlohmann::json::array()}, {"value", nlohmann::json::array()}};
        for (const auto& [time, value] : samples)
            both["time_s"].push_back(time), both["value"].push_back(value);
        return both;
    };
    nlohmann::json& series = all["series"];
    series["speed_rpm"] = samples_json(course.speeds);
    for (const GrowthCourse::Sensor& sensor : course.sensors)
        series["temperature_degc"][sensor.name] = samples_json(sensor.samples);
    for (int axis = 0; axis < 3; ++axis) {
        GrowthSamples grown;
        for (const GrowthCourse::Value& value : course.values)
            if (std::isfinite(value.place[axis])) grown.emplace_back(value.time, value.place[axis]);
        if (!grown.empty()) series["growth_mm"][std::string(1, letters[axis])] = samples_json(grown);
    }
    return all;
}

}  // namespace plumb::commissioning
