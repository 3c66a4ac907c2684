// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_identify.hpp"

#include <nlohmann/json.hpp>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "components/commissioning/growth/growth_law_search.hpp"
#include "components/math/growth/coverage_factor.hpp"
#include "components/math/growth/growth_law.hpp"
#include "components/math/growth/temperature_watch.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Index;

constexpr double harmless = 0.005;  // mm, as axis_growth has it unless it is set

std::string line(const std::string& pin, double value) {
    char text[120];
    std::snprintf(text, sizeof text, "setp %-30s %.6g\n", ("axis-growth." + pin).c_str(), value);
    return text;
}

// How far each temperature departs from the others by the spindle.
struct GrowthWatch {
    TemperatureWatch::Settings settings;  // by the place of a sensor in `sensors`
    SpindleDrive::Settings drive;
};

using PerSensor = TemperatureWatch::PerSensor;

constexpr double step = 60;  // s
constexpr int blocks = 5;    // of a day; each from the third on is predicted by those before
// A limit is what moves an axis by `harm`, but between 1.5 and 4 times the largest error of the hours that
// were left out, and 0.25 K more for noise: on 24 drawn machines the largest error of another day was 0.3 to
// 3.4 times as large. A sensor that no law reads does no harm, and has the largest limit.
constexpr double harm = 0.007;  // mm
constexpr double least = 1.5, most = 4, noise = 0.25;

struct Moment {
    PerSensor contrast = PerSensor::Zero();
    Eigen::Vector2d drive = Eigen::Vector2d::Zero();
    int block = 0;
};

struct Fit {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Identity() * 1e-6;
    Eigen::Matrix<double, 2, TemperatureWatch::sensors> right =
        Eigen::Matrix<double, 2, TemperatureWatch::sensors>::Zero();

    void add(const Moment& moment) {
        normal += moment.drive * moment.drive.transpose();
        right += moment.drive * moment.contrast.transpose();
    }
    Eigen::Matrix<double, 2, TemperatureWatch::sensors> solved() const { return normal.ldlt().solve(right); }
};

double speed_at(const GrowthSamples& speeds, double time) {
    const auto next = std::upper_bound(speeds.begin(), speeds.end(), std::pair(time, HUGE_VAL));
    return next == speeds.begin() ? next->second : (next - 1)->second;
}

// `growths`: by how much an axis grows at most by each sensor, mm/K. `drive`: of the law, if it has a term by
// speed; otherwise the one that predicts the temperatures best. Nothing with fewer than two sensors, or
// without a spindle speed.
std::optional<GrowthWatch> learned_watch(const std::vector<const GrowthObservations::Sensor*>& sensors,
                                         const std::vector<double>& growths,
                                         const std::vector<GrowthSamples>& speeds,
                                         const std::optional<SpindleDrive::Settings>& drive) {
    if (sensors.size() < 2) return {};
    if (std::any_of(speeds.begin(), speeds.end(), [](const auto& day) { return day.empty(); })) return {};
    const auto count = static_cast<Eigen::Index>(sensors.size());
    TemperatureWatch::Settings judged;
    judged.limit.head(count).setOnes();
    std::vector<std::vector<Moment>> days(speeds.size());
    for (std::size_t day = 0; day < speeds.size(); ++day) {
        const GrowthSamples& samples = sensors.front()->days[day];
        const double begin = samples.front().first, span = samples.back().first - begin;
        for (double t = begin; t <= samples.back().first; t += step) {
            PerSensor rises = PerSensor::Zero();
            for (Eigen::Index i = 0; i < count; ++i)
                rises[i] = sensors[static_cast<std::size_t>(i)]->rise(day, t);
            Moment moment;
            moment.contrast = TemperatureWatch::contrasts(rises, judged);
            moment.block =
                std::min(static_cast<int>((t - begin) / std::max(span, step) * blocks), blocks - 1);
            days[day].push_back(moment);
        }
    }
    const auto try_drive = [&](const SpindleDrive::Settings& its, double slow_time, GrowthWatch& watch) {
        SpindleDrive::Settings slow = its;
        slow.turning_time = slow.stopped_time = slow_time;
        for (std::size_t day = 0; day < days.size(); ++day) {
            SpindleDrive fast_drive, slow_drive;
            double t = sensors.front()->days[day].front().first;
            for (Moment& moment : days[day]) {
                const double speed = speed_at(speeds[day], t);
                moment.drive = {fast_drive.value(), slow_drive.value()};
                fast_drive.step(speed, its, step);
                slow_drive.step(speed, slow, step);
                t += step;
            }
        }
        Fit fit;
        double squares = 0;
        PerSensor largest = PerSensor::Zero();
        for (int block = 0; block < blocks; ++block) {
            const auto by = fit.solved();
            for (const auto& day : days)
                for (const Moment& moment : day) {
                    if (moment.block != block) continue;
                    fit.add(moment);
                    if (block < 2) continue;
                    const PerSensor rest = moment.contrast - by.transpose() * moment.drive;
                    squares += rest.squaredNorm();
                    largest = largest.cwiseMax(rest.cwiseAbs());
                }
        }
        const auto by = fit.solved();
        watch.settings.fast = by.row(0).transpose();
        watch.settings.slow = by.row(1).transpose();
        watch.settings.slow_time = slow_time;
        watch.drive = its;
        watch.settings.low = watch.settings.high = PerSensor::Zero();
        for (const auto& day : days)
            for (const Moment& moment : day) {
                watch.settings.low = watch.settings.low.cwiseMin(moment.contrast);
                watch.settings.high = watch.settings.high.cwiseMax(moment.contrast);
                largest = largest.cwiseMax((moment.contrast - by.transpose() * moment.drive).cwiseAbs());
            }
        watch.settings.limit = PerSensor::Zero();
        for (Eigen::Index i = 0; i < count; ++i) {
            const double growth = growths[static_cast<std::size_t>(i)];
            const double harmful = growth > 0 ? harm / growth : HUGE_VAL;
            watch.settings.limit[i] =
                std::clamp(harmful, least * largest[i] + noise, most * largest[i] + noise);
        }
        return squares;
    };
    GrowthWatch best;
    double fewest = std::numeric_limits<double>::infinity();
    const auto improve = [&](const SpindleDrive::Settings& its) {
        for (const double slow_time : {3600.0, 7200.0}) {
            GrowthWatch watch;
            const double squares = try_drive(its, slow_time, watch);
            if (squares >= fewest) continue;
            fewest = squares;
            best = watch;
        }
    };
    if (drive)
        improve(*drive);
    else
        for (const double turning : {300.0, 600.0, 1200.0, 2400.0})
            for (const double ratio : {1.0, 2.0, 4.0})
                for (const double power : {1.0, SpindleDrive::Settings().exponent}) {
                    SpindleDrive::Settings its;
                    its.exponent = power;
                    its.turning_time = turning;
                    its.stopped_time = ratio * turning;
                    improve(its);
                }
    return best;
}

}  // namespace

std::string GrowthIdentified::sentence(int axis) const {
    const Axis& its = axes[static_cast<std::size_t>(axis)];
    const char letter = "XYZ"[axis];
    char text[300];
    if (!its.probed)
        std::snprintf(text, sizeof text, "%c: was not measured", letter);
    else if (!std::isfinite(its.predicted_rest))
        std::snprintf(
            text, sizeof text,
            "%c: drift %.1f um rms; not corrected, as the test is too short to predict a part of it", letter,
            its.drift * 1e3);
    else if (!its.used)
        std::snprintf(text, sizeof text,
                      "%c: drift %.1f um rms; not corrected, as no temperature predicts the later part of "
                      "the test: %.1f um without a law, %.1f um with the best temperature",
                      letter, its.drift * 1e3, its.none_rest * 1e3, its.line_rest * 1e3);
    else
        std::snprintf(text, sizeof text,
                      "%c: drift %.1f um rms; the law leaves %.1f um of %s that it did not see, and no law "
                      "%.1f um%s",
                      letter, its.drift * 1e3, its.predicted_rest * 1e3,
                      days > 1 ? "days" : "parts of the test", its.none_rest * 1e3,
                      its.predicted_rest > harmless ? "; more than harmless, 5 um" : "");
    return text;
}

GrowthIdentified growth_identified(const std::vector<GrowthCourse>& days,
                                   const GrowthIdentifyOptions& options) {
    const GrowthObservations data = growth_observations(days, options);
    const AxisLaws laws = best_laws(data);
    const double unit = days.front().millimetres;
    GrowthIdentified result;
    result.days = days.size();
    std::string& lines = result.lines;
    result.sensors.resize(GrowthLaw::sensors);

    // The sensors that a law reads, by their number in axis_growth.
    std::map<int, const GrowthObservations::Sensor*> numbered;
    const auto number_of = [&](const GrowthObservations::Sensor& sensor) {
        for (const auto& [number, its] : numbered)
            if (its->name == sensor.name) return number;
        const int number = sensor.number >= 0 ? sensor.number : static_cast<int>(numbered.size());
        numbered[number] = &sensor;
        result.sensors[static_cast<std::size_t>(number)] = sensor.name;
        return number;
    };

    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!laws[axis]) continue;
        const AxisLaw& law = *laws[axis];
        const IdentifiedGrowth& found = law.found;
        GrowthIdentified::Axis& its = result.axes[axis];
        its.probed = true;
        its.used = law.form.terms() > 0;
        its.drift = found.drift;
        its.rest = found.rest;
        its.predicted_rest = found.predicted_rest;
        its.none_rest = law.none;
        its.line_rest = law.line;
        its.scale = found.scale;
        its.slope = law.form.slope;
        its.speed = law.form.speed;
        const std::string prefix = std::string(1, "xyz"[axis]) + '-';
        double rest = std::isfinite(found.predicted_rest) ? found.predicted_rest : found.drift;
        // Without a law a few blocks are all that shows how large the drift of another day may be.
        if (!its.used) rest *= coverage_factor(std::max<double>(found.block_rests.size(), 1)) / 2;
        lines += line(prefix + "sigma", std::max(rest, value_sigma) / unit);
        for (Index s = 0; s < law.growth.size(); ++s) {
            const auto& sensor = data.sensors[law.form.sensors[static_cast<std::size_t>(s)]];
            const std::string number = std::to_string(number_of(sensor));
            lines += line(prefix + "growth-" + number, law.growth[s] / unit);
            lines += line(prefix + "growth-sigma-" + number, law.growth_sigma[s] / unit);
            if (law.form.slope) lines += line(prefix + "slope-" + number, law.slope[s]);
            its.terms.push_back({sensor.name, law.growth[s], law.growth_sigma[s]});
        }
        if (law.form.slope) {
            lines += line(prefix + "pivot", law.pivot / unit);
        }
        if (law.form.speed) {
            lines += line(prefix + "speed-growth", law.by_speed / unit);
            lines += line(prefix + "speed-sigma", law.speed_sigma / unit);
            its.terms.push_back({"speed", law.by_speed, law.speed_sigma});
        }
    }
    std::optional<SpindleDrive::Settings> drive;
    for (const auto& law : laws) {
        if (!law || !law->form.speed) continue;
        drive.emplace();
        drive->turning_time = law->form.turning;
        drive->stopped_time = law->form.stopped;
        break;
    }
    // The other sensors judge the sensors that the law reads.
    for (const auto& sensor : data.sensors)
        if (!numbered.empty() && numbered.size() < GrowthLaw::sensors) number_of(sensor);
    std::vector<const GrowthObservations::Sensor*> judged;
    std::vector<double> growths;
    for (const auto& [number, sensor] : numbered) {
        judged.push_back(sensor);
        double most = 0;
        for (const auto& axis : result.axes)
            for (const auto& term : axis.terms)
                if (term.name == sensor->name) most = std::max(most, std::abs(term.value));
        growths.push_back(most);
    }
    const auto watch = learned_watch(judged, growths, data.speeds, drive);
    if (!numbered.empty())
        lines +=
            "# Load axis_growth with sensors=" + std::to_string(numbered.rbegin()->first + 1) + " or more\n";
    Index place = 0;
    for (const auto& [number, sensor] : numbered) {
        const std::string its = std::to_string(number);
        lines += "# " + sensor->name + "\n";
        lines += line("reference-" + its, sensor->reference(0));
        double low = 0, high = 0;
        for (const GrowthSamples& day : sensor->days) {
            low = std::min(low, range_of(day).first - sensor->reference(0));
            high = std::max(high, range_of(day).second - sensor->reference(0));
        }
        lines += line("rise-low-" + its, low);
        lines += line("rise-high-" + its, high);
        if (watch) {
            const auto& expected = watch->settings;
            lines += line("expected-fast-" + its, expected.fast[place]);
            lines += line("expected-slow-" + its, expected.slow[place]);
            lines += line("expected-low-" + its, expected.low[place]);
            lines += line("expected-high-" + its, expected.high[place]);
            lines += line("expected-limit-" + its, expected.limit[place]);
        }
        ++place;
    }
    if (watch) {
        drive = watch->drive;
        lines += line("slow-time", watch->settings.slow_time);
    }
    if (drive) {
        lines += line("speed-exponent", drive->exponent);
        lines += line("turning-time", drive->turning_time);
        lines += line("stopped-time", drive->stopped_time);
    }
    return result;
}

std::string growth_settings(const std::string& file, const std::string& begun,
                            const GrowthIdentified& found) {
    std::string text =
        "# Found by plumb growth identify in " + file + (begun.empty() ? "" : ", of " + begun) + "\n";
    for (int axis = 0; axis < 3; ++axis) {
        text += "# " + found.sentence(axis) + '\n';
        for (const GrowthIdentified::Term& term : found.axes[static_cast<std::size_t>(axis)].terms) {
            char its[120];
            std::snprintf(its, sizeof its, "#    by %s %.2f +- %.2f %s\n", term.name.c_str(),
                          term.value * 1e3, term.sigma * 1e3, term.name == "speed" ? "um" : "um/K");
            text += its;
        }
    }
    return text + found.lines;
}

nlohmann::json growth_identified_json(const GrowthIdentified& found) {
    nlohmann::json all{{"lines", found.lines}, {"sensors", found.sensors}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const GrowthIdentified::Axis& its = found.axes[axis];
        if (!its.probed) continue;
        nlohmann::json terms = nlohmann::json::array();
        for (const GrowthIdentified::Term& term : its.terms)
            terms.push_back({{"name", term.name}, {"value_mm", term.value}, {"uncertainty_mm", term.sigma}});
        all["axes"][std::string(1, "XYZ"[axis])] = {{"drift_mm", its.drift},
                                                    {"rest_mm", its.rest},
                                                    {"predicted_rest_mm", its.predicted_rest},
                                                    {"none_rest_mm", its.none_rest},
                                                    {"line_rest_mm", its.line_rest},
                                                    {"scale", its.scale},
                                                    {"used", its.used},
                                                    {"slope", its.slope},
                                                    {"speed", its.speed},
                                                    {"terms", terms}};
    }
    return all;
}

}  // namespace plumb::commissioning
