// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "components/math/growth/bore_centre.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double hour = 3600;

struct Visit {
    int pass = 0, bore = 0;
    bool turned = false, compensated = false, cooled = false;
    double time = 0;
    Vector3d place{none, none, none}, compensation{0, 0, 0};
    double diameter = 0, scatter = 0;
    bool circle = false;
};

std::vector<Visit> visits_of(const GrowthLog& log, GrowthAnalysis& analysis) {
    std::vector<Visit> visits;
    std::vector<const GrowthRecord*> touches;
    double squares = 0;
    int circles = 0;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::touch) {
            if (!touches.empty() && touches.front()->visit != r.visit) touches.clear();
            touches.push_back(&r);
        }
        if (r.kind != GrowthRecord::event) continue;
        if (r.item == 7) ++analysis.rejected;
        if (r.item != 10) continue;
        Visit visit{r.pass, r.bore, r.turned, r.compensated, r.cooled};
        BoreTouches circle;
        Vector3d offset = Vector3d::Zero();
        double face = 0, count = 0, faces = 0;
        for (const GrowthRecord* t : touches) {
            if (t->visit != r.visit) continue;
            const Vector3d c = Vector3d(t->offset[0], t->offset[1], t->offset[2]) * log.millimetres;
            const Vector3d p = Vector3d(t->at[0], t->at[1], t->at[2]) * log.millimetres - c;
            offset += c;
            visit.time += t->time;
            ++count;
            if (std::abs(t->item) == 3) {
                face += p.z();
                ++faces;
            } else {
                circle.add(p.x(), p.y());
            }
        }
        touches.clear();
        if (count == 0) continue;
        visit.time /= count;
        visit.compensation = offset / count;
        if (const auto centre = circle.centre()) {
            visit.place.head<2>() = Eigen::Vector2d(centre->x, centre->y);
            visit.diameter = centre->bore_diameter(log.ball);
            visit.scatter = centre->scatter;
            if (circle.count() > 3) {
                squares += centre->scatter * centre->scatter;
                ++circles;
            }
        }
        if (faces > 0) visit.place.z() = face / faces;
        visits.push_back(visit);
    }
    analysis.touch_scatter = circles > 0 ? std::sqrt(squares / circles) : 0;
    return visits;
}

using Key = std::tuple<int, bool, bool>;  // bore, turned, compensated
Key key_of(const Visit& visit) {
    return {visit.bore, visit.turned, visit.compensated};
}

// Takes the drift within each pass out, by the bore that was probed twice in it, and leaves one visit of each
// bore.
std::vector<Visit> at_one_time(const std::vector<Visit>& visits) {
    std::vector<Visit> result;
    for (std::size_t begin = 0; begin < visits.size();) {
        std::size_t end = begin;
        while (end < visits.size() && visits[end].pass == visits[begin].pass) ++end;
        const double time = (visits[begin].time + visits[end - 1].time) / 2;
        std::map<bool, Vector3d> rates;
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = i + 1; j < end; ++j)
                if (key_of(visits[i]) == key_of(visits[j]) && visits[j].time > visits[i].time)
                    rates[visits[i].compensated] =
                        (visits[j].place - visits[i].place) / (visits[j].time - visits[i].time);
        std::map<Key, std::pair<Visit, int>> merged;
        for (std::size_t i = begin; i < end; ++i) {
            Visit visit = visits[i];
            const auto rate = rates.find(visit.compensated);
            if (rate != rates.end())
                for (int axis = 0; axis < 3; ++axis)
                    if (std::isfinite(rate->second[axis]))
                        visit.place[axis] -= rate->second[axis] * (visit.time - time);
            visit.time = time;
            const auto [it, fresh] = merged.try_emplace(key_of(visit), visit, 1);
            if (fresh) continue;
            auto& [kept, count] = it->second;
            kept.place = (kept.place * count + visit.place) / (count + 1);
            kept.compensation = (kept.compensation * count + visit.compensation) / (count + 1);
            ++count;
        }
        for (const auto& [key, visit] : merged) result.push_back(visit.first);
        begin = end;
    }
    return result;
}

void make_series(const std::vector<Visit>& visits, GrowthAnalysis& analysis) {
    std::map<Key, std::vector<const Visit*>> keyed;
    for (const Visit& visit : visits) keyed[key_of(visit)].push_back(&visit);
    std::set<int> without;
    for (const auto& [key, all] : keyed) {
        GrowthSeries series;
        std::tie(series.bore, series.turned, series.compensated) = key;
        if (all.front()->pass > 1) {
            without.insert(series.bore);
            continue;
        }
        for (const Visit* visit : all)
            series.points.push_back({visit->pass, visit->time, visit->place - all.front()->place,
                                     visit->compensation, visit->diameter, visit->scatter});
        (series.compensated ? analysis.has_on : analysis.has_off) = true;
        analysis.series.push_back(std::move(series));
    }
    for (const int bore : without)
        analysis.notes.push_back(
            "Bore " + std::to_string(bore) +
            " was not probed in the first pass in each state: it has no reference there.");
}

double at(const GrowthSeries& series, int axis, double time) {
    const auto& points = series.points;
    if (points.empty() || time > points.back().time + 60) return none;
    for (std::size_t i = 1; i < points.size(); ++i) {
        if (points[i].time < time && i + 1 < points.size()) continue;
        const double share = std::clamp(
            (time - points[i - 1].time) / std::max(points[i].time - points[i - 1].time, 1.0), 0.0, 1.0);
        return (1 - share) * points[i - 1].deviation[axis] + share * points[i].deviation[axis];
    }
    return points.front().deviation[axis];
}

double larger(double a, double b) {
    return !std::isfinite(a) || std::abs(b) > std::abs(a) ? b : a;
}

// The means over bores and orientations of each pass that has them all; the passes and their times.
struct Means {
    std::vector<int> pass;
    std::vector<double> time;
    std::vector<Vector3d> deviation, compensation;
};

Means means_of(const GrowthAnalysis& analysis, bool compensated) {
    std::map<int, std::tuple<Vector3d, Vector3d, double, int>> sums;
    int series = 0;
    for (const GrowthSeries& each : analysis.series) {
        if (each.compensated != compensated) continue;
        ++series;
        for (const GrowthPoint& point : each.points) {
            auto& [d, c, time, count] =
                sums.try_emplace(point.pass, Vector3d::Zero(), Vector3d::Zero(), 0.0, 0).first->second;
            d += point.deviation;
            c += point.compensation;
            time = point.time;
            ++count;
        }
    }
    Means means;
    for (const auto& [pass, sum] : sums) {
        const auto& [d, c, time, count] = sum;
        if (count < series) continue;  // a pass that was interrupted
        means.pass.push_back(pass);
        means.time.push_back(time);
        means.deviation.push_back(d / count);
        means.compensation.push_back(c / count);
    }
    return means;
}

void measure_axes(GrowthAnalysis& analysis) {
    for (const bool compensated : {false, true}) {
        const Means means = means_of(analysis, compensated);
        for (int axis = 0; axis < 3; ++axis) {
            GrowthOfAxis& its = (compensated ? analysis.on : analysis.off)[static_cast<std::size_t>(axis)];
            its.at_1_hour = its.at_4_hours = its.at_end = none;
            for (const GrowthSeries& series : analysis.series) {
                if (series.compensated != compensated) continue;
                double low = 0, high = 0;
                for (std::size_t i = 0; i < series.points.size(); ++i) {
                    const double d = series.points[i].deviation[axis];
                    if (!std::isfinite(d)) continue;
                    its.probed = true;
                    its.largest = std::max(its.largest, std::abs(d));
                    low = std::min(low, d);
                    high = std::max(high, d);
                    if (i == 0) continue;
                    const double step = (d - series.points[i - 1].deviation[axis]) /
                                        std::max(series.points[i].time - series.points[i - 1].time, 1.0) *
                                        hour;
                    if (std::abs(step) > std::abs(its.rate)) its.rate = step;
                }
                its.range = std::max(its.range, high - low);
                const double first = series.points.front().time;
                its.at_1_hour = larger(its.at_1_hour, at(series, axis, first + hour));
                its.at_4_hours = larger(its.at_4_hours, at(series, axis, first + 4 * hour));
                its.at_end = larger(its.at_end, series.points.back().deviation[axis]);
            }
            if (!its.probed) continue;
            Eigen::VectorXd t(static_cast<Eigen::Index>(means.time.size())), y(t.size());
            for (Eigen::Index i = 0; i < t.size(); ++i) {
                t[i] = means.time[static_cast<std::size_t>(i)] - means.time.front();
                y[i] = means.deviation[static_cast<std::size_t>(i)][axis];
            }
            its.fit = fit_exponential(t, y);
        }
    }
    // A deviation contains two bores, the seat of the probe, and what else scatters about a smooth curve.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double& its = analysis.uncertainties[axis];
        its = std::max(analysis.touch_scatter, 0.0002);
        for (const GrowthOfAxis& each : {analysis.off[axis], analysis.on[axis]})
            if (each.fit) its = std::max(its, each.fit->scatter);
        analysis.uncertainty = std::max(analysis.uncertainty, its);
    }
}

// Over the pass, as the compensation in it is a mean, too; else the last value before it.
double temperature_in(const std::vector<std::pair<double, double>>& samples,
                      const std::pair<double, double>& pass) {
    double sum = 0, before = none;
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

void judge_compensation(GrowthAnalysis& analysis, const std::vector<Visit>& visits) {
    if (!analysis.has_off || !analysis.has_on) return;
    const Means off = means_of(analysis, false), on = means_of(analysis, true);
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
    std::vector<const Visit*> compensated;
    for (const Visit& visit : visits)
        if (visit.compensated) compensated.push_back(&visit);
    record.visit_temperatures.resize(static_cast<Eigen::Index>(compensated.size()),
                                     record.temperatures.cols());
    record.visit_compensation.resize(static_cast<Eigen::Index>(compensated.size()), 3);
    for (Eigen::Index i = 0; i < record.visit_compensation.rows(); ++i) {
        const Visit& visit = *compensated[static_cast<std::size_t>(i)];
        record.visit_compensation.row(i) = visit.compensation.transpose();
        for (std::size_t s = 0; s < sensors.size(); ++s)
            record.visit_temperatures(i, static_cast<Eigen::Index>(s)) =
                temperature_in(analysis.temperatures[sensors[s]], {visit.time - 60, visit.time + 60});
    }
    if (!record.visit_temperatures.allFinite())
        record.visit_temperatures.resize(0, record.temperatures.cols());
    analysis.finding = judged_compensation(record);
}

void split(GrowthAnalysis& analysis) {
    const bool compensated = !analysis.has_off;
    std::map<std::pair<int, bool>, Vector3d> last;
    int pass = 0;
    for (const GrowthSeries& series : analysis.series)
        if (series.compensated == compensated) pass = std::max(pass, series.points.back().pass);
    for (const GrowthSeries& series : analysis.series)
        if (series.compensated == compensated && series.points.back().pass == pass && pass > 1 &&
            series.points.back().deviation.allFinite())
            last[{series.bore, series.turned}] = series.points.back().deviation;
    std::vector<std::pair<Vector3d, Vector3d>> bores;
    for (const auto& [key, deviation] : last) {
        const auto place = analysis.log->bores.find(key.first);
        if (key.second || place == analysis.log->bores.end()) continue;
        const auto& at = place->second.place;
        bores.emplace_back(Vector3d(at[0], at[1], at[2]), deviation);
        analysis.rigid_bores.push_back(key.first);
    }
    if (!bores.empty()) {
        Eigen::MatrixX3d places(static_cast<Eigen::Index>(bores.size()), 3), deviations = places;
        for (std::size_t i = 0; i < bores.size(); ++i) {
            places.row(static_cast<Eigen::Index>(i)) = bores[i].first.transpose();
            deviations.row(static_cast<Eigen::Index>(i)) = bores[i].second.transpose();
        }
        analysis.rigid = rigid_part(places, deviations);
    }
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

std::string micrometres(double mm) {
    char text[40];
    std::snprintf(text, sizeof text, "%.1f \u00b5m", mm * 1e3);
    return text;
}

void decide(GrowthAnalysis& analysis) {
    const bool compensated = analysis.has_on;
    const auto& axes = compensated ? analysis.on : analysis.off;
    const std::string state = compensated ? "with compensation" : "without compensation";
    bool all = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string letter(1, "XYZ"[axis]);
        if (!axes[axis].probed) continue;
        const double most = axes[axis].largest, room = 2 * analysis.uncertainties[axis],
                     tolerance = analysis.log->tolerance[axis];
        GrowthVerdict& verdict = analysis.verdicts[axis];
        if (most - room > tolerance) {
            verdict = GrowthVerdict::fail;
            analysis.reasons.push_back(letter + " drifts " + micrometres(most) + " " + state +
                                       "; the tolerance is " + micrometres(tolerance) + ".");
            analysis.verdict = GrowthVerdict::fail;
        } else if (most + room > tolerance) {
            analysis.reasons.push_back(letter + " drifts " + micrometres(most) + " " + state +
                                       ", within 2 u = " + micrometres(room) + " of the tolerance of " +
                                       micrometres(tolerance) + ".");
        } else if (analysis.stop == 1) {
            verdict = GrowthVerdict::pass;
        }
        all = all && verdict == GrowthVerdict::pass;
    }
    if (analysis.stop == 0)
        analysis.reasons.push_back("The test has not reached its end. Only a fail can be stated now.");
    if (analysis.stop == 2)
        analysis.reasons.push_back("The maximum time was reached, and the machine was not stable.");
    const bool any =
        std::any_of(axes.begin(), axes.end(), [](const GrowthOfAxis& axis) { return axis.probed; });
    if (!any) analysis.reasons.push_back("No bore was probed twice.");
    if (any && all && analysis.verdict != GrowthVerdict::fail) analysis.verdict = GrowthVerdict::pass;
    if (analysis.verdict == GrowthVerdict::pass)
        analysis.reasons.push_back("All axes stay within their tolerances " + state + ".");
}

}  // namespace

std::string GrowthSeries::name() const {
    return "bore " + std::to_string(bore) + (turned ? ", 180\u00b0" : ", 0\u00b0");
}

std::string word(GrowthVerdict verdict) {
    return verdict == GrowthVerdict::pass   ? "pass"
           : verdict == GrowthVerdict::fail ? "fail"
                                            : "not determined";
}

const GrowthSeries* GrowthAnalysis::worst(bool compensated) const {
    const GrowthSeries* found = nullptr;
    double most = -1;
    for (const GrowthSeries& each : series) {
        if (each.compensated != compensated) continue;
        for (const GrowthPoint& point : each.points) {
            const double size = point.deviation.allFinite() ? point.deviation.norm() : 0;
            if (size > most) most = size, found = &each;
        }
    }
    return found;
}

GrowthAnalysis analysed(const GrowthLog& log) {
    GrowthAnalysis analysis;
    analysis.log = &log;
    std::set<bool> cooled;
    for (const GrowthRecord& r : log.records) {
        analysis.duration = r.time;
        analysis.passes = std::max(analysis.passes, r.pass);
        if (r.kind == GrowthRecord::temperature && r.at[1] != 0)
            analysis.temperatures[r.item].emplace_back(r.time, r.at[0]);
        if (r.kind != GrowthRecord::event) continue;
        if (r.item == 5) analysis.stop = static_cast<int>(r.at[0]);
        if (r.item == 6) ++analysis.resumed;
        if (r.item == 8) ++analysis.faults;
    }
    const std::vector<Visit> visits = visits_of(log, analysis);
    for (const Visit& visit : visits) cooled.insert(visit.cooled);
    analysis.visits = static_cast<int>(visits.size());
    analysis.cooling_toggled = cooled.size() > 1;
    make_series(at_one_time(visits), analysis);
    measure_axes(analysis);
    judge_compensation(analysis, visits);
    split(analysis);
    decide(analysis);
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
    if (log.bores.empty() && !analysis.series.empty())
        analysis.notes.push_back("The places of the bores are not in the log: there is no rigid part.");
    return analysis;
}

}  // namespace plumb::commissioning
