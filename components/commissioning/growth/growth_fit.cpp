// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_fit.hpp"

#include <nlohmann/json.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string_view>

#include "components/io/files/csv.hpp"
#include "components/math/growth/growth_curve.hpp"

namespace plumb::commissioning {
namespace {

struct Columns {
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // by column
};

Columns read(const std::string& file) {
    const std::string text = csv::text_of(file);
    std::string_view rest = csv::without_byte_order_mark(text);
    Columns columns;
    int line = 0;
    const auto refuse = [&](const std::string& why) {
        throw std::runtime_error(file + ":" + std::to_string(line) + ": " + why);
    };
    while (!rest.empty()) {
        ++line;
        const std::string_view whole = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), whole.size() + 1));
        if (csv::trimmed(whole).empty() || whole.front() == '#') continue;
        const auto fields = csv::split_at_commas(whole);
        if (columns.names.empty()) {
            for (const auto field : fields) {
                if (csv::number(field))
                    refuse("the first line has to name the columns, and has the number " +
                           csv::quoted(field));
                columns.names.emplace_back(field);
            }
            columns.values.resize(columns.names.size());
            continue;
        }
        if (fields.size() != columns.names.size())
            refuse("has " + std::to_string(fields.size()) + " fields, and the first line names " +
                   std::to_string(columns.names.size()) + " columns");
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const auto value = csv::number(fields[i]);
            if (!value) refuse(columns.names[i] + " is " + csv::quoted(fields[i]) + ", no number");
            columns.values[i].push_back(*value);
        }
    }
    if (columns.names.empty()) throw std::runtime_error(file + ": is empty");
    return columns;
}

}  // namespace

std::string growth_fit(const GrowthFitOptions& options, bool json) {
    const Columns columns = read(options.file);
    const auto index = [&](const std::string& name) {
        const auto at = std::find(columns.names.begin(), columns.names.end(), name);
        if (at == columns.names.end()) {
            std::string all;
            for (const std::string& each : columns.names) all += (all.empty() ? "" : ", ") + each;
            throw std::runtime_error(options.file + ":1: there is no column '" + name + "'; there are " +
                                     all);
        }
        return static_cast<std::size_t>(at - columns.names.begin());
    };
    const std::size_t time = index(options.time);
    std::vector<std::size_t> wanted;
    for (const std::string& name : options.columns) wanted.push_back(index(name));
    for (std::size_t i = 0; options.columns.empty() && i < columns.names.size(); ++i)
        if (i != time) wanted.push_back(i);
    const auto as_vector = [](const std::vector<double>& values) -> Eigen::VectorXd {
        return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    };
    Eigen::VectorXd t = as_vector(columns.values[time]) * options.time_unit;
    if (t.size() > 0) t.array() -= t.minCoeff();
    nlohmann::json all = nlohmann::json::array();
    std::string text = "column            steady      low     high   rate/s  scatter  now\n";
    for (const std::size_t column : wanted) {
        const Eigen::VectorXd y = as_vector(columns.values[column]);
        const auto fit = fit_growth_curve(t, y, {options.uncertainty, options.uncertainty > 0});
        char line[200];
        if (!fit)
            std::snprintf(line, sizeof line, "%-14s too few values, or all at one time\n",
                          columns.names[column].c_str());
        else
            std::snprintf(line, sizeof line, "%-14s %9.4g %8.4g %8.4g %8.2g %8.3g %8.4g%s\n",
                          columns.names[column].c_str(), fit->steady, fit->low(), fit->high(), fit->rate,
                          fit->noise, y[y.size() - 1], fit->determined ? "" : "   not determined");
        text += line;
        nlohmann::json its{
            {"column", columns.names[column]}, {"values", y.size()}, {"determined", fit && fit->determined}};
        if (fit) {
            its["steady"] = fit->steady;
            its["steady_low"] = fit->low();
            its["steady_high"] = fit->high();
            its["rate_per_s"] = fit->rate;
            its["rate_uncertainty_per_s"] = fit->rate_sigma;
            its["scatter"] = fit->noise;
        }
        all.push_back(its);
    }
    return json ? all.dump(1) + '\n'
                : text +
                      "Advice only: 95 of 100 steady states lie between low and high, if the duty goes on.\n";
}

}  // namespace plumb::commissioning
