// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_identify.hpp"

#include <nlohmann/json.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "components/commissioning/growth/growth_visits.hpp"
#include "components/math/growth/growth_identification.hpp"
#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

constexpr double large_growth = 0.005;   // mm/K
constexpr double large_slope = 20e-6;    // 1/K, of aluminium
constexpr double large_by_speed = 0.05;  // mm
constexpr double least_travel = 20;      // mm, of bores whose places determine a slope
constexpr double visit_sigma = 0.001;    // mm
constexpr double least_warming = 1;      // K
constexpr double better = 0.95;  // a law with more terms has to predict better than that of a simpler one

using Samples = std::vector<std::pair<double, double>>;  // time, value

double at(const Samples& samples, double time) {
    const auto next = std::lower_bound(samples.begin(), samples.end(), std::pair(time, -1e300));
    if (next == samples.begin()) return next->second;
    const auto last = next - 1;
    if (next == samples.end()) return last->second;
    const double share = (time - last->first) / (next->first - last->first);
    return (1 - share) * last->second + share * next->second;
}

// Smoothed as axis_growth does it, by 60 s.
Samples smoothed(const Samples& samples) {
    Samples result;
    FirstOrderLag lag(samples.front().second);
    double before = samples.front().first;
    for (const auto& [time, value] : samples) {
        if (time > before) lag.step(value, 60, time - before);
        before = time;
        result.emplace_back(time, lag.value());
    }
    return result;
}

Samples driven(const Samples& speeds, const SpindleDrive::Settings& settings) {
    Samples result;
    SpindleDrive drive;
    double before = 0;
    for (const auto& [time, speed] : speeds) {
        if (time > before) drive.step(speed, settings, time - before);
        before = time;
        result.emplace_back(time, drive.value());
    }
    return result;
}

struct Sensor {
    int index = 0;  // of axis_growth, from 0
    std::string name;
    Samples samples;
    double reference = 0, low = 0, high = 0;
};

struct Data {
    std::vector<GrowthVisit> visits;
    std::vector<Sensor> sensors;
    std::optional<Sensor> artifact;
    Samples speeds;
    std::array<bool, 3> probed{};
};

// What the law of one axis may contain.
struct Form {
    bool slope = false, speed = false;
    double turning = 600, stopped = 2400;
};

struct AxisResult {
    IdentifiedGrowth found;
    Form form;
    Eigen::VectorXd growth, slope;  // of each sensor
    double by_speed = 0, pivot = 0, travel = 0;
};

Data read(const GrowthLog& log, const GrowthIdentifyOptions& options) {
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(log.file + ": " + why); };
    Data data;
    data.visits = growth_visits(log);
    for (GrowthVisit& visit : data.visits) visit.place += visit.compensation;  // the position of the joint
    std::map<int, Samples> temperatures;
    bool turned = false;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::temperature && r.at[1] != 0)
            temperatures[r.item].emplace_back(r.time, r.at[0]);
        if (r.kind != GrowthRecord::speed) continue;
        data.speeds.emplace_back(r.time, r.at[0]);
        turned |= r.at[0] > 0;
    }
    if (!turned || !options.speed) data.speeds.clear();
    int passes = 0;
    for (const GrowthVisit& visit : data.visits) {
        passes = std::max(passes, visit.pass);
        for (int axis = 0; axis < 3; ++axis)
            data.probed[static_cast<std::size_t>(axis)] |= std::isfinite(visit.place[axis]);
    }
    if (passes < 4)
        refuse("has " + std::to_string(passes) +
               " passes; a law of temperatures needs four, and better eight");
    const double cold_end = data.visits.front().time;
    std::vector<std::string> names;
    for (auto& [number, samples] : temperatures) {
        const auto named = log.sensors.find(number);
        Sensor sensor;
        sensor.index = number - 1;
        sensor.name = named == log.sensors.end() ? "sensor " + std::to_string(number) : named->second;
        names.push_back(sensor.name);
        const bool is_artifact = sensor.name == options.artifact;
        const auto& wanted = options.sensors;
        const bool chosen = wanted.empty()
                                ? !is_artifact
                                : std::find(wanted.begin(), wanted.end(), sensor.name) != wanted.end();
        if (!chosen && !is_artifact) continue;
        sensor.samples = smoothed(samples);
        sensor.reference = at(sensor.samples, cold_end);
        sensor.low = sensor.high = sensor.reference;
        for (const auto& [time, value] : sensor.samples) {
            sensor.low = std::min(sensor.low, value);
            sensor.high = std::max(sensor.high, value);
        }
        if (is_artifact && !chosen) {
            data.artifact = std::move(sensor);
            continue;
        }
        if (sensor.index >= GrowthLaw::sensors)
            refuse("sensor " + std::to_string(number) + " is chosen; axis_growth reads the sensors 1 to 4");
        data.sensors.push_back(std::move(sensor));
    }
    for (const std::string& wanted : options.sensors)
        if (std::find(names.begin(), names.end(), wanted) == names.end())
            refuse("there is no sensor '" + wanted + "'");
    const bool warmed = std::any_of(data.sensors.begin(), data.sensors.end(), [](const Sensor& sensor) {
        return sensor.high - sensor.low >= least_warming;
    });
    if (!warmed && data.speeds.empty())
        refuse("no sensor has warmed by 1 K, and there is no spindle speed: nothing shows the heat");
    return data;
}

AxisResult fit(const Data& data, int axis, const Form& form, double power) {
    std::vector<const GrowthVisit*> visits;
    for (const GrowthVisit& visit : data.visits)
        if (std::isfinite(visit.place[axis])) visits.push_back(&visit);
    const auto count = static_cast<Eigen::Index>(visits.size());
    const auto sensors = static_cast<Eigen::Index>(data.sensors.size());
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const GrowthVisit* visit : visits) {
        low = std::min(low, visit->place[axis]);
        high = std::max(high, visit->place[axis]);
    }
    AxisResult result;
    result.form = form;
    result.pivot = std::round((low + high) / 2) + 0.0;  // no -0
    result.travel = std::ceil((high - low) / 2);
    // k of the sensors, b of them, s; and the expansion of the artifact, from its clamp, which is not used
    const Eigen::Index slopes = form.slope ? sensors : 0, speeds = form.speed ? 1 : 0;
    const Eigen::Index own = data.artifact ? 2 : 0;
    GrowthVisits its;
    its.terms.resize(count, sensors + slopes + speeds + own);
    its.growth.resize(count);
    Eigen::VectorXd large(its.terms.cols());
    large.head(sensors).setConstant(large_growth);
    large.segment(sensors, slopes).setConstant(large_slope);
    large.segment(sensors + slopes, speeds).setConstant(large_by_speed);
    if (own > 0) large.tail<2>() << large_growth / 5, large_slope;
    SpindleDrive::Settings settings;
    settings.turning_time = form.turning;
    settings.stopped_time = form.stopped;
    settings.exponent = power;
    const Samples drive = form.speed ? driven(data.speeds, settings) : Samples();
    std::map<std::pair<int, bool>, int> groups;
    for (Eigen::Index i = 0; i < count; ++i) {
        const GrowthVisit& visit = *visits[static_cast<std::size_t>(i)];
        const double from_pivot = visit.place[axis] - result.pivot;
        for (Eigen::Index s = 0; s < sensors; ++s) {
            const Sensor& sensor = data.sensors[static_cast<std::size_t>(s)];
            const double rise = at(sensor.samples, visit.time) - sensor.reference;
            its.terms(i, s) = rise;
            if (form.slope) its.terms(i, sensors + s) = rise * from_pivot;
        }
        if (form.speed) its.terms(i, sensors + slopes) = at(drive, visit.time);
        if (own > 0) {
            const double rise = at(data.artifact->samples, visit.time) - data.artifact->reference;
            its.terms(i, its.terms.cols() - 2) = rise;
            its.terms(i, its.terms.cols() - 1) = rise * from_pivot;
        }
        its.growth[i] = visit.place[axis];
        its.groups.push_back(
            groups.try_emplace({visit.bore, visit.turned}, static_cast<int>(groups.size())).first->second);
        its.passes.push_back(visit.pass);
    }
    result.found = identified_growth(its, large, visit_sigma);
    const Eigen::VectorXd& w = result.found.value;
    result.growth = w.head(sensors);
    result.slope = form.slope ? Eigen::VectorXd(w.segment(sensors, sensors)) : Eigen::VectorXd::Zero(sensors);
    if (form.speed) result.by_speed = w[sensors + slopes];
    return result;
}

bool travels(const Data& data, int axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const GrowthVisit& visit : data.visits) {
        if (!std::isfinite(visit.place[axis])) continue;
        low = std::min(low, visit.place[axis]);
        high = std::max(high, visit.place[axis]);
    }
    return high - low >= least_travel;
}

// The laws of the axes, with the same time constants of the spindle: those with which all axes together are
// predicted best, if that is better than without the speed.
std::array<std::optional<AxisResult>, 3> choose(const Data& data, double power) {
    std::array<std::optional<AxisResult>, 3> best;
    double least = 0;
    const auto best_of = [&](int axis, const Form& form) {
        AxisResult plain = fit(data, axis, form, power);
        if (!travels(data, axis) || data.sensors.empty()) return plain;
        Form with = form;
        with.slope = true;
        AxisResult sloped = fit(data, axis, with, power);
        return sloped.found.predicted_rest < better * plain.found.predicted_rest ? sloped : plain;
    };
    for (int axis = 0; axis < 3; ++axis) {
        if (!data.probed[static_cast<std::size_t>(axis)]) continue;
        best[static_cast<std::size_t>(axis)] = best_of(axis, {});
        least += std::pow(best[static_cast<std::size_t>(axis)]->found.predicted_rest, 2);
    }
    if (data.speeds.empty()) return best;
    const auto without = best;
    for (const double turning : {300.0, 600.0, 1200.0, 2400.0, 4800.0})
        for (const double ratio : {1.0, 2.0, 4.0}) {
            auto with = without;
            double squares = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (!without[axis]) continue;
                AxisResult driven = best_of(static_cast<int>(axis), {false, true, turning, ratio * turning});
                if (driven.found.predicted_rest < better * without[axis]->found.predicted_rest)
                    with[axis] = driven;
                squares += std::pow(with[axis]->found.predicted_rest, 2);
            }
            if (squares >= least) continue;
            least = squares;
            best = with;
        }
    return best;
}

std::string line(const std::string& pin, double value) {
    char text[120];
    std::snprintf(text, sizeof text, "setp %-30s %.6g\n", pin.c_str(), value);
    return text;
}

}  // namespace

std::string GrowthIdentified::sentence(int axis) const {
    const Axis& its = axes[static_cast<std::size_t>(axis)];
    const char letter = "XYZ"[axis];
    char text[200];
    if (its.probed)
        std::snprintf(text, sizeof text,
                      "%c: drift %.1f um rms; the law leaves %.1f um, and %.1f um of passes it did not see%s",
                      letter, its.drift * 1e3, its.rest * 1e3, its.predicted_rest * 1e3,
                      its.used ? "" : ": not used, as it does not help");
    else
        std::snprintf(text, sizeof text, "%c: was not probed", letter);
    return text;
}

GrowthIdentified growth_identified(const GrowthLog& log, const GrowthIdentifyOptions& options) {
    const Data data = read(log, options);
    const auto laws = choose(data, options.speed_exponent);
    const double unit = log.millimetres;
    GrowthIdentified result;
    std::string& lines = result.lines;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!laws[axis]) continue;
        const AxisResult& law = *laws[axis];
        const IdentifiedGrowth& found = law.found;
        const bool useful = found.predicted_rest < 0.8 * found.drift;
        result.axes[axis] = {true,           useful,        found.drift, found.rest, found.predicted_rest,
                             law.form.slope, law.form.speed};
        if (!useful) continue;
        const std::string prefix = options.instance + '.' + "xyz"[axis] + '-';
        for (std::size_t s = 0; s < data.sensors.size(); ++s) {
            const std::string number = std::to_string(data.sensors[s].index);
            const auto i = static_cast<Eigen::Index>(s);
            lines += line(prefix + "growth-" + number, law.growth[i] / unit);
            if (law.form.slope) lines += line(prefix + "slope-" + number, law.slope[i]);
        }
        if (law.form.slope) {
            lines += line(prefix + "pivot", law.pivot / unit);
            lines += line(prefix + "travel", law.travel / unit);
        }
        if (law.form.speed) lines += line(prefix + "speed-growth", law.by_speed / unit);
        lines += line(prefix + "sigma", std::max(found.predicted_rest, visit_sigma) / unit);
    }
    for (const Sensor& sensor : data.sensors) {
        const std::string number = std::to_string(sensor.index);
        lines += "# " + sensor.name + "\n";
        lines += line(options.instance + ".reference-" + number, sensor.reference);
        lines += line(options.instance + ".low-" + number, sensor.low);
        lines += line(options.instance + ".high-" + number, sensor.high);
    }
    for (const auto& law : laws) {
        if (!law || !law->form.speed) continue;
        lines += line(options.instance + ".speed-exponent", options.speed_exponent);
        lines += line(options.instance + ".turning-time", law->form.turning);
        lines += line(options.instance + ".stopped-time", law->form.stopped);
        break;
    }
    return result;
}

std::string growth_settings(const GrowthLog& log, const GrowthIdentified& found) {
    std::string text = "# Found by plumb growth identify in " + log.file + ", of " + log.begun + "\n";
    for (int axis = 0; axis < 3; ++axis) text += "# " + found.sentence(axis) + '\n';
    return text + found.lines;
}

nlohmann::json growth_identified_json(const GrowthIdentified& found) {
    nlohmann::json all{{"lines", found.lines}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const GrowthIdentified::Axis& its = found.axes[axis];
        if (!its.probed) continue;
        all["axes"][std::string(1, "XYZ"[axis])] = {
            {"drift_mm", its.drift}, {"rest_mm", its.rest}, {"predicted_rest_mm", its.predicted_rest},
            {"used", its.used},      {"slope", its.slope},  {"speed", its.speed}};
    }
    return all;
}

}  // namespace plumb::commissioning
