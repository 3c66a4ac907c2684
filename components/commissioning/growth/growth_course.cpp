// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_course.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <tuple>

#include "components/commissioning/growth/artifact_expansion.hpp"
#include "components/io/files/csv.hpp"
#include "components/math/blocks/first_order_lag.hpp"

namespace plumb::commissioning {
namespace {

constexpr double smoothing = 20;  // s, of axis_growth

GrowthSamples smoothed(const GrowthSamples& samples) {
    GrowthSamples result;
    FirstOrderLag lag(samples.front().second);
    double before = samples.front().first;
    for (const auto& [time, value] : samples) {
        if (time > before) lag.step(value, smoothing, time - before);
        before = time;
        result.emplace_back(time, lag.value());
    }
    return result;
}

bool ends_with(std::string_view text, std::string_view end) {
    return text.size() > end.size() && text.substr(text.size() - end.size()) == end;
}

// The quantity and the unit of a column of a CSV file.
struct Column {
    enum Kind { nothing, time, speed, temperature, growth } kind = nothing;
    double unit = 1;  // s, or mm
    int axis = 0;
    bool upper = false;
};

Column column_of(const std::string& name) {
    std::string lower;
    for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const bool numbered =
        lower.size() > 1 && lower[0] == 't' &&
        std::all_of(lower.begin() + 1, lower.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (numbered || ends_with(lower, "_degc")) return {Column::temperature};
    if (lower == "s" || lower == "rpm" || lower == "speed" || ends_with(lower, "_rpm"))
        return {Column::speed};
    if (lower.rfind("time", 0) == 0 || lower == "t")
        return {Column::time, ends_with(lower, "_s") ? 1.0 : ends_with(lower, "_h") ? 3600.0 : 60.0};
    if (lower == "x" || lower == "y" || lower == "z" || lower == "x_um" || lower == "y_um" || lower == "z_um")
        return {Column::growth, 1e-3, lower[0] - 'x'};
    const std::string place = ends_with(lower, "_um") ? lower.substr(0, lower.size() - 3) : lower;
    if (place == "x1" || place == "y1" || place == "x2" || place == "y2")
        return {Column::growth, 1e-3, place[0] - 'x', place[1] == '2'};
    return {};
}

}  // namespace

double value_at(const GrowthSamples& samples, double time) {
    const auto next = std::lower_bound(samples.begin(), samples.end(), std::pair(time, -1e300));
    if (next == samples.begin()) return next->second;
    const auto last = next - 1;
    if (next == samples.end()) return last->second;
    const double share = (time - last->first) / (next->first - last->first);
    return (1 - share) * last->second + share * next->second;
}

GrowthCourse course_of(const GrowthLog& log) {
    GrowthCourse course;
    course.file = log.file;
    course.machine = log.machine;
    course.begun = log.begun;
    course.millimetres = log.millimetres;
    course.places = true;
    std::map<std::pair<int, bool>, int> groups;
    std::vector<GrowthVisit> visits = growth_visits(log);
    course.expansion_out = take_out_expansion(log, visits).applied;
    for (const GrowthVisit& visit : visits) {
        const auto number = static_cast<int>(groups.size());
        const int group = groups.try_emplace({visit.bore, visit.turned}, number).first->second;
        // The position of the joint, which contains the compensation: its state does not matter.
        course.values.push_back({visit.time, group, visit.pass, visit.place + visit.compensation});
    }
    std::map<int, GrowthSamples> temperatures;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::temperature && r.at[1] != 0)
            temperatures[r.item].emplace_back(r.time, r.at[0]);
        if (r.kind == GrowthRecord::speed) course.speeds.emplace_back(r.time, r.at[0]);
    }
    for (const auto& [number, samples] : temperatures) {
        const auto named = log.sensors.find(number);
        const std::string name =
            named == log.sensors.end() ? "sensor " + std::to_string(number) : named->second;
        course.sensors.push_back({name, number - 1, smoothed(samples)});
    }
    return course;
}

bool is_growth_log(const std::string& file) {
    constexpr std::string_view mark = "growth-log,";
    std::ifstream stream(file, std::ios::binary);
    std::string begin(mark.size(), ' ');
    return stream.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == mark;
}

GrowthCourse read_growth_course(const std::string& file) {
    const std::string text = csv::text_of(file);
    std::string_view rest = csv::without_byte_order_mark(text);
    int line = 0;
    const auto refuse = [&](const std::string& why) {
        throw std::runtime_error(file + ":" + std::to_string(line) + ": " + why);
    };
    GrowthCourse course;
    course.file = course.machine = file;
    std::vector<Column> columns;
    std::vector<std::string> names;
    std::map<std::size_t, GrowthSamples> temperatures;
    std::size_t time_at = 0;
    while (!rest.empty()) {
        ++line;
        const std::string_view whole = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), whole.size() + 1));
        if (csv::trimmed(whole).empty() || whole.front() == '#') continue;
        const auto fields = csv::split_at_commas(whole);
        if (columns.empty()) {
            for (const auto field : fields) {
                names.emplace_back(field);
                columns.push_back(column_of(names.back()));
            }
            const auto is = [&](Column::Kind kind) {
                return std::count_if(columns.begin(), columns.end(),
                                     [&](const Column& column) { return column.kind == kind; });
            };
            if (is(Column::time) != 1) refuse("names no column of times, or several");
            if (is(Column::speed) > 1) refuse("names several columns of the spindle speed");
            if (is(Column::growth) == 0) refuse("names no column of growth: X, Y or Z, in um");
            if (is(Column::temperature) + is(Column::speed) == 0) refuse("names no temperature");
            time_at = static_cast<std::size_t>(
                std::find_if(columns.begin(), columns.end(),
                             [](const Column& column) { return column.kind == Column::time; }) -
                columns.begin());
            continue;
        }
        if (fields.size() != columns.size())
            refuse("has " + std::to_string(fields.size()) + " fields, and the first line names " +
                   std::to_string(columns.size()) + " columns");
        const auto now = csv::number(fields[time_at]);
        if (!now) refuse("the time is " + csv::quoted(fields[time_at]));
        constexpr double none = std::numeric_limits<double>::quiet_NaN();
        GrowthCourse::Value value{*now * columns[time_at].unit, 0, line, {none, none, none}};
        if (!course.values.empty() && value.time <= course.values.back().time)
            refuse("the time does not rise");
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto number = csv::number(fields[i]);
            if (!number) continue;
            if (columns[i].kind == Column::speed) course.speeds.emplace_back(value.time, *number);
            if (columns[i].kind == Column::temperature) temperatures[i].emplace_back(value.time, *number);
            if (columns[i].kind == Column::growth)
                (columns[i].upper ? value.upper[columns[i].axis] : value.place[columns[i].axis]) =
                    *number * columns[i].unit;
        }
        course.values.push_back(value);
    }
    if (course.values.empty()) throw std::runtime_error(file + ": has no values");
    for (const auto& [column, samples] : temperatures)
        course.sensors.push_back({names[column], -1, smoothed(samples)});
    return course;
}

}  // namespace plumb::commissioning
