// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_course.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include <boost/algorithm/string.hpp>

#include "components/commissioning/growth/artifact_expansion.hpp"
#include "components/io/files/table_file.hpp"

namespace plumb::commissioning {
namespace {

// Name of the sensor of the artifact, if the log does not state it.
constexpr std::string_view artifact_sensor = "artifact";

// The meaning of a column of a table.
struct Meaning {
    enum Kind { nothing, time, speed, temperature, growth } kind = nothing;
    int axis = 0;
    bool upper = false;
    std::string unit;  // if the head has none
    std::size_t column = 0;
};

bool all_of(const std::vector<std::string>& words, const std::set<std::string>& known) {
    return std::all_of(words.begin(), words.end(),
                       [&](const std::string& its) { return known.count(its) > 0; });
}

Meaning meaning_of(const TableFile::Column& column) {
    std::vector<std::string> words;
    boost::split(words, column.name, boost::is_any_of(" "));
    const auto quantity = column.known.quantity;
    if (quantity == TableFile::unknown && !column.unit.empty()) return {};
    const auto fits = [&](TableFile::Quantity its) {
        return quantity == its || quantity == TableFile::unknown;
    };
    const bool of_time =
        all_of(words, {"time", "t", "date", "datetime", "timestamp", "clock", "elapsed", "stamp"});
    if (column.clock != TableFile::Clock::none || (of_time && quantity == TableFile::time))
        return {Meaning::time, 0, false, "", 0};
    if (fits(TableFile::speed) &&
        (quantity == TableFile::speed ||
         all_of(words, {"s", "n", "rpm", "speed", "spindle", "rotation", "actual", "commanded"})))
        return {Meaning::speed, 0, false, "rpm", 0};
    const bool numbered = words[0].size() > 1 && words[0][0] == 't' &&
                          words[0].find_first_not_of("0123456789", 1) == std::string::npos;
    const bool named = words[0].rfind("temp", 0) == 0 || words.back().rfind("temp", 0) == 0 ||
                       (words[0] == "t" && words.size() > 1);
    if (quantity == TableFile::temperature || (quantity == TableFile::unknown && (numbered || named)))
        return {Meaning::temperature, 0, false, "degC", 0};
    if (of_time && quantity == TableFile::unknown) return {Meaning::time, 0, false, "", 0};
    if (!fits(TableFile::length)) return {};
    Meaning its{Meaning::growth, 2, false, "um", 0};
    int axes = 0;
    for (const std::string& word : words) {
        const std::string axis = word.size() > 1 && word[0] == 'd' ? word.substr(1) : word;
        if (axis == "x" || axis == "y" || axis == "z" || axis == "x1" || axis == "y1" || axis == "x2" ||
            axis == "y2") {
            its.axis = axis[0] - 'x', its.upper = axis.back() == '2', ++axes;
        } else if (!all_of({word},
                           {"growth", "displacement", "drift", "deviation", "error", "delta", "expansion"})) {
            return {};
        }
    }
    return axes <= 1 ? its : Meaning{};
}

std::pair<double, double> range_of(const TableFile& table, std::size_t column) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = 0; i < table.rows(); ++i)
        if (const auto value = table.number(i, column))
            low = std::min(low, *value), high = std::max(high, *value);
    return {low, high};
}

std::string short_number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

// The unit of times by their length, which is no minute and no month.
std::string unit_of_times(const TableFile& table, std::size_t column) {
    const auto [low, high] = range_of(table, column);
    if (low > 1e11) return "ms";
    if (low > 1e8) return "s";
    std::vector<std::string> possible;
    for (const char* unit : {"ms", "s", "min", "h"}) {
        const double length = (high - low) * TableFile::unit_of(unit).factor;
        const double step = length / static_cast<double>(table.rows());
        if (length >= 1200 && length <= 4 * 86400 && step >= 0.05 && step <= 3600)
            possible.emplace_back(unit);
    }
    return possible.size() == 1 ? possible[0] : "";
}

// The columns of a table of growth, and how they are taken.
struct Meanings {
    std::vector<Meaning> all;  // those that are read
    std::string taken, unread;
};

void judge_unit(const TableFile& table, Meaning& its) {
    const TableFile::Column& column = table.columns()[its.column];
    if (column.clock != TableFile::Clock::none || !column.unit.empty()) return void(its.unit = column.unit);
    const auto [low, high] = range_of(table, its.column);
    const auto ask = [&](const std::string& between) {
        table.refuse(table.head_line(), "column " + csv::quoted(column.head) + " has no unit and goes from " +
                                            short_number(low) + " to " + short_number(high) + ": is it in " +
                                            between + "? State the unit, as by --head '" + column.head + '=' +
                                            column.head + " (" +
                                            between.substr(0, between.find_first_of(", ")) + ")'");
    };
    if (its.kind == Meaning::time && (its.unit = unit_of_times(table, its.column)).empty())
        ask("s, min or h");
    if (its.kind == Meaning::temperature && low > 45) ask(low > 200 ? "K, degC or degF" : "degF or degC");
    if (its.kind == Meaning::growth && high > low && high - low < 1) ask("mm or um");
    if (its.kind == Meaning::growth && high - low > 1000) ask("um or nm");
}

Meanings meanings_of(const TableFile& table) {
    Meanings result;
    std::map<int, std::vector<std::string>> heads;
    std::map<std::string, std::string> by_unit;
    const auto add = [](std::string& list, const std::string& its) {
        list += (list.empty() ? "" : ", ") + its;
    };
    for (std::size_t i = 0; i < table.columns().size(); ++i) {
        const TableFile::Column& column = table.columns()[i];
        Meaning its = meaning_of(column);
        its.column = i;
        if (its.kind == Meaning::nothing || !(range_of(table, i).first < HUGE_VAL)) {
            add(result.unread,
                csv::quoted(column.head) + (its.kind != Meaning::nothing ? " (no values)"
                                            : column.unit.empty() ? " (no quantity or unit in its head)"
                                            : column.known.quantity == TableFile::unknown
                                                ? " (unknown unit " + csv::quoted(column.unit) + ")"
                                                : ""));
            continue;
        }
        heads[its.kind].push_back(csv::quoted(column.head));
        result.all.push_back(its);
    }
    const auto refuse = [&](const std::string& why) {
        table.refuse(table.head_line(), why + (result.unread.empty() ? "" : ". Not read: " + result.unread));
    };
    const bool two_clocks = heads[Meaning::time].size() == 2 &&
                            std::all_of(result.all.begin(), result.all.end(), [&](const Meaning& its) {
                                const auto clock = table.columns()[its.column].clock;
                                return its.kind != Meaning::time || clock == TableFile::Clock::day ||
                                       clock == TableFile::Clock::date;
                            });
    if (heads[Meaning::time].empty()) refuse("names no column of times");
    if (heads[Meaning::time].size() > 1 && !two_clocks)
        refuse("names several columns of times: " + boost::join(heads[Meaning::time], ", "));
    if (heads[Meaning::speed].size() > 1)
        refuse("names several columns of the spindle speed: " + boost::join(heads[Meaning::speed], ", "));
    if (heads[Meaning::growth].empty()) refuse("names no column of growth: X, Y or Z");
    for (Meaning& its : result.all) {
        judge_unit(table, its);
        const TableFile::Column& column = table.columns()[its.column];
        std::string as = column.clock != TableFile::Clock::none ? " as dates or times of a day, in seconds"
                                                                : " in " + its.unit;
        if (its.kind == Meaning::growth && column.name.find("xyz"[its.axis]) == std::string::npos)
            as += " as growth of Z";
        add(by_unit[as], column.head);
    }
    for (const auto& [unit, names] : by_unit)
        result.taken += (result.taken.empty() ? "" : "; ") + names + unit;
    if (!table.form().empty()) result.taken += "; " + table.form();
    return result;
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

std::pair<double, double> range_of(const GrowthSamples& samples) {
    const auto [low, high] = std::minmax_element(
        samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    return {low->second, high->second};
}

std::optional<GrowthCurve> curve_of(const GrowthSamples& samples, double expected_noise) {
    Eigen::VectorXd t(samples.size()), y(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        std::tie(t[static_cast<Eigen::Index>(i)], y[static_cast<Eigen::Index>(i)]) = samples[i];
    return fit_growth_curve(t, y, expected_noise);
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
        const bool artifact = log.artifact ? number == log.artifact->sensor : name == artifact_sensor;
        course.sensors.push_back({name, number - 1, samples, artifact});
    }
    return course;
}

bool is_growth_log(const std::string& file) {
    constexpr std::string_view mark = "growth-log,";
    std::ifstream stream(file, std::ios::binary);
    std::string begin(mark.size(), ' ');
    return stream.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == mark;
}

GrowthCourse read_growth_course(const std::string& file, const std::map<std::string, std::string>& heads) {
    const TableFile table(file, heads);
    const Meanings meanings = meanings_of(table);
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    constexpr double day = 86400, longest_gap = 600;  // s
    GrowthCourse course;
    course.file = course.machine = file;
    std::map<std::size_t, GrowthSamples> temperatures;
    std::size_t equal = 0, gaps = 0;
    double gap = 0;
    std::size_t gap_line = 0;
    // Rows of one time: the sum and number of the values of each column.
    std::vector<std::pair<double, int>> sums(meanings.all.size());
    const auto time_of = [&](std::size_t row) {
        double time = 0;
        for (const Meaning& its : meanings.all)
            if (its.kind == Meaning::time)
                time += table.value(row, its.column, TableFile::unit_of(its.unit).factor);
        return time;
    };
    double days = 0;
    for (std::size_t row = 0; row < table.rows();) {
        const double now = time_of(row);
        std::fill(sums.begin(), sums.end(), std::pair(0.0, 0));
        const std::size_t first = row;
        for (; row < table.rows() && time_of(row) == now; ++row)
            for (std::size_t i = 0; i < sums.size(); ++i) {
                const Meaning& its = meanings.all[i];
                if (its.kind == Meaning::time) continue;
                const double scale = its.kind == Meaning::growth ? TableFile::unit_of(its.unit).factor : 1;
                const auto value = table.number(row, its.column, scale);
                gaps += !value;
                if (value) sums[i].first += *value, ++sums[i].second;
            }
        equal += row - first - 1;
        GrowthCourse::Value value{now + days, 0, static_cast<int>(table.line(first)), {none, none, none}};
        if (!course.values.empty()) {
            const double last = course.values.back().time;
            if (value.time < last - day / 2 && now < day) value.time += day, days += day;  // past midnight
            if (value.time <= last) table.refuse(table.line(first), "the time does not rise");
            if (value.time - last > gap) gap = value.time - last, gap_line = table.line(first);
        }
        for (std::size_t i = 0; i < sums.size(); ++i) {
            if (sums[i].second == 0) continue;
            const Meaning& its = meanings.all[i];
            const double mean = sums[i].first / sums[i].second;
            if (its.kind == Meaning::speed) course.speeds.emplace_back(value.time, mean);
            if (its.kind == Meaning::temperature) temperatures[its.column].emplace_back(value.time, mean);
            if (its.kind == Meaning::growth)
                (its.upper ? value.upper[its.axis] : value.place[its.axis]) = mean;
        }
        course.values.push_back(value);
    }
    for (const auto& [column, samples] : temperatures) {
        const std::string& head = table.columns()[column].head;
        course.sensors.push_back({head, -1, samples, head == artifact_sensor});
    }
    course.taken = "Taken as: " + meanings.taken;
    if (equal > 0)
        course.taken += "; " + std::to_string(equal) + " rows have the time of the row before: their mean";
    if (gaps > 0) course.taken += "; " + std::to_string(gaps) + " missing values";
    if (gap > longest_gap)
        course.taken +=
            "; no row for " + short_number(gap / 60) + " min before line " + std::to_string(gap_line);
    course.taken +=
        meanings.unread.empty() ? ". Every column is read." : ". Not read: " + meanings.unread + '.';
    return course;
}

}  // namespace plumb::commissioning
