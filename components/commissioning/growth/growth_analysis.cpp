// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {

using Eigen::Vector3d;

namespace {

// Whether the mean speed of the spindle between two passes is another one than between two others.
bool duty_changed(const GrowthLog& log) {
    std::map<int, std::pair<double, double>> works;  // by the pass before: speed times time, and time
    bool in_pass = true;
    double before = 0;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::event && (r.item == 2 || r.item == 3)) in_pass = r.item == 2;
        if (r.kind == GrowthRecord::event && r.item == 3) before = r.time, works[r.pass];
        if (r.kind != GrowthRecord::speed || in_pass || works.empty()) continue;
        auto& [turned, time] = works.rbegin()->second;
        turned += r.at[0] * (r.time - before);
        time += r.time - before;
        before = r.time;
    }
    double low = HUGE_VAL, high = 0;
    for (const auto& [pass, work] : works) {
        if (!(work.second > 0)) continue;
        low = std::min(low, work.first / work.second);
        high = std::max(high, work.first / work.second);
    }
    return high > 100 && low < 0.8 * high;
}

}  // namespace

void compare_orientations(GrowthAnalysis& analysis) {
    const bool compensated = !analysis.has_off;
    std::map<std::pair<int, bool>, Vector3d> last;
    int pass = 0;
    for (const GrowthSeries& series : analysis.series)
        if (series.compensated == compensated) pass = std::max(pass, series.points.back().pass);
    for (const GrowthSeries& series : analysis.series)
        if (series.compensated == compensated && series.points.back().pass == pass && pass > 1 &&
            series.points.back().deviation.allFinite())
            last[{series.bore, series.turned}] = series.points.back().deviation;
    for (const auto& [key, deviation] : last) {
        const auto other = last.find({key.first, true});
        if (key.second || other == last.end()) continue;
        GrowthAnalysis::Turned turned{key.first, TurnedTable(deviation, other->second), std::nullopt};
        const auto place = analysis.log->bores.find(key.first);
        if (place != analysis.log->bores.end() && std::abs(place->second.place[0]) < 1)
            turned.tilt = turned.table.tilt_about_x(place->second.place[2]);
        analysis.turned.push_back(turned);
    }
}

std::string GrowthSeries::name() const {
    return (sphere ? "sphere " : "bore ") + std::to_string(bore) + (turned ? ", 180\u00b0" : ", 0\u00b0");
}

std::string word(GrowthVerdict verdict) {
    return verdict == GrowthVerdict::pass   ? "pass"
           : verdict == GrowthVerdict::fail ? "fail"
                                            : "not determined";
}

std::string GrowthAnalysis::sensor_name(int sensor) const {
    const auto named = log->sensors.find(sensor);
    return named == log->sensors.end() ? "sensor " + std::to_string(sensor) : named->second;
}

GrowthAnalysis analysed(const GrowthLog& log) {
    GrowthAnalysis analysis;
    analysis.log = &log;
    std::set<bool> cooled;
    for (const GrowthRecord& r : log.records) {
        const double before = analysis.duration;
        analysis.duration = r.time;
        analysis.passes = std::max(analysis.passes, r.pass);
        if (r.kind == GrowthRecord::temperature && r.at[1] != 0)
            analysis.temperatures[r.item].emplace_back(r.time, r.at[0]);
        if (r.kind != GrowthRecord::event) continue;
        if (r.item == 5) analysis.stop = static_cast<growth_test::Stop>(static_cast<int>(r.at[0]));
        if (r.item == 6) ++analysis.resumed;
        if (r.item == 6 && r.at[0] != 0) ++analysis.unknown_breaks;
        if (r.item == 6 && (r.at[0] != 0 || r.time - before > longest_break)) {
            ++analysis.parts;
            analysis.breaks.push_back(r.time);
        }
        if (r.item == 7) ++analysis.rejected;
        if (r.item == 8) ++analysis.faults;
    }
    std::vector<GrowthVisit> visits = growth_visits(log);
    analysis.expansion = take_out_expansion(log, visits);
    double squares = 0, circles = 0;
    for (const GrowthVisit& visit : visits) {
        cooled.insert(visit.cooled);
        if (!visit.checked) continue;
        squares += visit.scatter * visit.scatter;
        ++circles;
    }
    if (circles > 0) analysis.touch_scatter = std::sqrt(squares / circles);
    analysis.visits = static_cast<int>(visits.size());
    analysis.cooling_toggled = cooled.size() > 1;
    analysis.duty_changed = duty_changed(log);
    make_series(visits_at_one_time(visits), analysis);
    measure_axes(analysis);
    make_budgets(analysis, visits);
    judge_compensation(analysis, visits);
    compare_orientations(analysis);
    find_slips(analysis);
    decide(analysis);
    analysis.practice = growth_practice(analysis);
    if (!log.torn.empty()) analysis.notes.push_back("The log is not complete: " + log.torn + ".");
    if (analysis.cooling_toggled)
        analysis.notes.push_back(
            "Temperature control was switched between visits. It acts over hours: compare two tests "
            "from cold instead, one with it and one without.");
    if (analysis.rejected > 0)
        analysis.notes.push_back(std::to_string(analysis.rejected) +
                                 " visits of bores did not count and were repeated.");
    if (analysis.resumed > 0)
        analysis.notes.push_back("The test was interrupted and resumed " + std::to_string(analysis.resumed) +
                                 " times.");
    if (analysis.unknown_breaks > 0)
        analysis.notes.push_back("The computer was started again in " +
                                 std::to_string(analysis.unknown_breaks) +
                                 " of these breaks. Their length is not known, and counts as 0.");
    if (log.artifact && !analysis.expansion.applied)
        analysis.notes.push_back(
            "The expansion of the artifact was not taken out: " + analysis.expansion.why_not + ".");
    return analysis;
}

void identify_law(GrowthAnalysis& analysis) {
    try {
        analysis.identified = growth_identified({course_of(*analysis.log)});
    } catch (const std::runtime_error& error) {
        const std::string reason = error.what(), file = analysis.log->file + ": ";
        analysis.not_identified = reason.rfind(file, 0) == 0 ? reason.substr(file.size()) : reason;
        if (analysis.not_identified.rfind("has ", 0) == 0) analysis.not_identified.insert(0, "the log ");
    }
}

}  // namespace plumb::commissioning
