// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_identify.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "components/commissioning/growth/growth_law_search.hpp"
#include "components/commissioning/growth/growth_watch.hpp"
#include "components/math/growth/coverage_factor.hpp"
#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Index;

constexpr double harmless = 0.005;  // mm, as axis_growth has it unless it is set

std::string line(const std::string& pin, double value) {
    char text[120];
    std::snprintf(text, sizeof text, "setp %-30s %.6g\n", ("axis-growth." + pin).c_str(), value);
    return text;
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
