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
#include <set>
#include <stdexcept>
#include <utility>

#include "components/math/growth/growth_identification.hpp"
#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Sensor = GrowthCourse::Sensor;

// Usual sizes of the coefficients: a metre of steel grows by 11.5 um/K, a metre of aluminium by 23. A common
// change moves the tip and the work alike, and leaves a small difference.
constexpr double usual_growth = 0.010, usual_common = 0.003;  // mm/K
constexpr double usual_slope = 12e-6;                         // 1/K
constexpr double usual_by_speed = 0.05;                       // mm
// No machine has more.
constexpr double most_growth = 0.020, most_slope = 30e-6, most_by_speed = 0.15;

constexpr double least_travel = 20;    // mm, of bores whose places determine a slope
constexpr double value_sigma = 0.001;  // mm
constexpr double least_warming = 1;    // K
constexpr double lasts = 1800;         // s, for which a residual of slow growth lasts
constexpr double cost = 1.3;           // by which a term has to improve the prediction
constexpr double cost_of_speed = 2;    // the same: friction depends on grease, preload and load
constexpr double determined = 2;       // a coefficient by its sigma, where there are several
constexpr int least_speeds = 3;        // that tell the exponent of the speed
constexpr int duties = 5;              // into which the course is cut
constexpr std::size_t most_values = 250;

struct Data {
    const GrowthCourse* course = nullptr;
    std::vector<GrowthCourse::Value> values;
    std::vector<double> weight;
    std::vector<int> duty;
    std::vector<Sensor> sensors;  // without the sensor of the structure
    std::optional<Sensor> structure, artifact;
    bool turned = false;
    double cold = 0;  // s, when the machine was cold
    std::array<bool, 3> measured{};

    double reference(const Sensor& sensor) const { return value_at(sensor.samples, cold); }
    // As GrowthLaw counts it.
    double rise(const Sensor& sensor, double time) const {
        return value_at(sensor.samples, time) - reference(sensor) - (structure ? common(time) : 0);
    }
    double common(double time) const { return value_at(structure->samples, time) - reference(*structure); }
};

// The terms of the law of one axis.
struct Form {
    std::vector<std::size_t> sensors;
    bool slope = false, speed = false;
    double turning = 600, stopped = 2400;

    int terms() const { return static_cast<int>(sensors.size()) * (slope ? 2 : 1); }
};

struct AxisResult {
    IdentifiedGrowth found;
    Form form;
    double score = std::numeric_limits<double>::infinity();
    double pivot = 0, travel = 0;
    // By sensor of the form, and last of the structure if there is one.
    VectorXd growth, growth_sigma, slope;
    double by_speed = 0, speed_sigma = 0;
};

double range_of(const Sensor& sensor) {
    const auto [low, high] =
        std::minmax_element(sensor.samples.begin(), sensor.samples.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });
    return high->second - low->second;
}

// How many speeds the spindle has had for a tenth of the time each. Two show no exponent.
int speeds_of(const GrowthCourse& course) {
    std::map<int, double> times;  // by steps of a fifth
    double all = 0;
    for (std::size_t i = 1; i < course.speeds.size(); ++i) {
        const auto& [time, speed] = course.speeds[i - 1];
        const double length = course.speeds[i].first - time, size = std::abs(speed);
        times[size < 1 ? -1 : static_cast<int>(std::lround(std::log(size) / std::log(1.2)))] += length;
        all += length;
    }
    return static_cast<int>(
        std::count_if(times.begin(), times.end(), [&](const auto& its) { return its.second >= 0.1 * all; }));
}

// The sensor from which the others differ least: of the body that most of them share.
std::size_t most_typical(const Data& data) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < data.sensors.size(); ++i) {
        std::vector<double> distances;
        for (std::size_t j = 0; j < data.sensors.size(); ++j) {
            if (i == j) continue;
            double mean = 0, square = 0;
            for (const auto& value : data.values) {
                const double d = value_at(data.sensors[i].samples, value.time) -
                                 value_at(data.sensors[j].samples, value.time);
                mean += d, square += d * d;
            }
            const auto count = static_cast<double>(data.values.size());
            distances.push_back(std::sqrt(std::max(0.0, square / count - std::pow(mean / count, 2))));
        }
        const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
        std::nth_element(distances.begin(), middle, distances.end());
        // Of two the one that moves less.
        const double size = *middle + 1e-3 * range_of(data.sensors[i]);
        if (size >= least) continue;
        least = size;
        best = i;
    }
    return best;
}

// Stretches of the course, cut where the speed changes.
void cut_into_duties(Data& data) {
    const double begin = data.values.front().time, span = data.values.back().time - begin;
    double since = begin, before = begin;
    int duty = 0;
    for (const auto& value : data.values) {
        const auto changes = [&] {
            double last = std::numeric_limits<double>::quiet_NaN();
            for (const auto& [time, speed] : data.course->speeds) {
                if (time > value.time) break;
                if (time > before && std::abs(speed - last) > 0.1 * std::abs(last)) return true;
                last = speed;
            }
            return false;
        };
        const double length = value.time - since;
        const bool apart = value.time > before;
        if (apart && (length >= span / duties || (length >= 0.8 * span / duties && changes()))) {
            ++duty;
            since = value.time;
        }
        before = value.time;
        data.duty.push_back(duty);
    }
}

void weigh(Data& data) {
    const auto count = data.values.size();
    data.weight.assign(count, 0);
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
        while (end < count && data.values[end].pass == data.values[begin].pass) ++end;
        const double gap = begin > 0 ? data.values[begin].time - data.values[begin - 1].time : lasts;
        const double length = data.values[end - 1].time - data.values[begin].time;
        const double weight = std::min(1.0, (gap + length) / lasts) / static_cast<double>(end - begin);
        for (std::size_t i = begin; i < end; ++i) data.weight[i] = weight;
    }
}

Data read(const GrowthCourse& course, const GrowthIdentifyOptions& options) {
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(course.file + ": " + why); };
    Data data;
    data.course = &course;
    data.values = course.values;
    if (!course.places && data.values.size() > most_values) {
        data.values.clear();
        const double step =
            (course.values.back().time - course.values.front().time) / static_cast<double>(most_values);
        for (const auto& value : course.values)
            if (data.values.empty() || value.time >= data.values.back().time + step)
                data.values.push_back(value);
    }
    std::set<int> passes;
    for (const auto& value : data.values) {
        passes.insert(value.pass);
        for (int axis = 0; axis < 3; ++axis)
            data.measured[static_cast<std::size_t>(axis)] |= std::isfinite(value.place[axis]);
    }
    if (passes.size() < 4)
        refuse("has " + std::to_string(passes.size()) +
               " passes; a law of temperatures needs four, and better eight");
    data.cold = data.values.front().time;
    data.turned = options.speed && speeds_of(course) >= least_speeds;
    for (const Sensor& sensor : course.sensors) {
        const bool is_artifact = sensor.name == options.artifact;
        const auto& wanted = options.sensors;
        const bool chosen = wanted.empty()
                                ? !is_artifact
                                : std::find(wanted.begin(), wanted.end(), sensor.name) != wanted.end();
        if (is_artifact && !chosen && !course.expansion_out) data.artifact = sensor;
        if (!chosen) continue;
        if (sensor.number >= GrowthLaw::sensors)
            refuse("sensor " + std::to_string(sensor.number + 1) +
                   " is chosen; axis_growth reads the sensors 1 to 4");
        data.sensors.push_back(sensor);
    }
    const auto there = [&](const std::string& name) {
        const bool found = std::any_of(course.sensors.begin(), course.sensors.end(),
                                       [&](const Sensor& sensor) { return sensor.name == name; });
        if (!found) refuse("there is no sensor '" + name + "'");
    };
    for (const std::string& wanted : options.sensors) there(wanted);
    const bool warmed = std::any_of(data.sensors.begin(), data.sensors.end(),
                                    [](const Sensor& sensor) { return range_of(sensor) >= least_warming; });
    if (!warmed && !data.turned)
        refuse("no sensor has warmed by 1 K, and there is no spindle speed: nothing shows the heat");
    if (options.structure.empty() ? data.sensors.size() > 1 : options.structure != "none") {
        if (!options.structure.empty()) there(options.structure);
        auto its = data.sensors.begin();
        if (options.structure.empty())
            its += static_cast<std::ptrdiff_t>(most_typical(data));
        else
            its = std::find_if(data.sensors.begin(), data.sensors.end(),
                               [&](const Sensor& sensor) { return sensor.name == options.structure; });
        if (its == data.sensors.end()) refuse("the sensor '" + options.structure + "' was not chosen");
        data.structure = *its;
        data.sensors.erase(its);
    }
    weigh(data);
    cut_into_duties(data);
    return data;
}

GrowthSamples driven(const GrowthSamples& speeds, const SpindleDrive::Settings& settings) {
    GrowthSamples result;
    SpindleDrive drive;
    double before = speeds.front().first, speed = 0;
    for (const auto& [time, next] : speeds) {
        if (time > before) drive.step(speed, settings, time - before);
        speed = next;
        before = time;
        result.emplace_back(time, drive.value());
    }
    return result;
}

// The travel of an axis in the values.
std::pair<double, double> travel_of(const Data& data, int axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const auto& value : data.values) {
        if (!std::isfinite(value.place[axis])) continue;
        low = std::min(low, value.place[axis]);
        high = std::max(high, value.place[axis]);
    }
    return {low, high};
}

AxisResult fit(const Data& data, int axis, const Form& form, double power) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < data.values.size(); ++i)
        if (std::isfinite(data.values[i].place[axis])) rows.push_back(i);
    const auto count = static_cast<Index>(rows.size());
    const auto chosen = static_cast<Index>(form.sensors.size());
    const Index all = chosen + (data.structure ? 1 : 0);
    const auto [low, high] = travel_of(data, axis);
    AxisResult result;
    result.form = form;
    if (data.course->places) {
        result.pivot = std::round((low + high) / 2) + 0.0;  // no -0
        result.travel = std::ceil((high - low) / 2);
    }
    // k of the sensors and of the structure, b of them, s; and the expansion of the artifact, from its clamp,
    // which is not used
    const Index slopes = form.slope ? all : 0, speeds = form.speed ? 1 : 0;
    const Index own = data.artifact ? (data.course->places ? 2 : 1) : 0;
    GrowthVisits its;
    its.terms.resize(count, all + slopes + speeds + own);
    its.growth.resize(count);
    its.weight.resize(count);
    VectorXd usual(its.terms.cols());
    usual.head(all).setConstant(usual_growth);
    if (data.structure) usual[chosen] = usual_common;
    usual.segment(all, slopes).setConstant(usual_slope);
    usual.segment(all + slopes, speeds).setConstant(usual_by_speed);
    if (own > 0) usual[usual.size() - own] = usual_common;
    if (own > 1) usual[usual.size() - 1] = 20e-6;  // 1/K, of aluminium
    SpindleDrive::Settings settings;
    settings.turning_time = form.turning;
    settings.stopped_time = form.stopped;
    settings.exponent = power;
    const GrowthSamples drive = form.speed ? driven(data.course->speeds, settings) : GrowthSamples();
    for (Index i = 0; i < count; ++i) {
        const std::size_t row = rows[static_cast<std::size_t>(i)];
        const GrowthCourse::Value& value = data.values[row];
        const double from_pivot = value.place[axis] - result.pivot;
        for (Index s = 0; s < all; ++s) {
            const double rise =
                s < chosen ? data.rise(data.sensors[form.sensors[static_cast<std::size_t>(s)]], value.time)
                           : data.common(value.time);
            its.terms(i, s) = rise;
            if (form.slope) its.terms(i, all + s) = rise * from_pivot;
        }
        if (form.speed) its.terms(i, all + slopes) = value_at(drive, value.time);
        if (own > 0) {
            const double rise = value_at(data.artifact->samples, value.time) - data.reference(*data.artifact);
            its.terms(i, its.terms.cols() - own) = rise;
            if (own > 1) its.terms(i, its.terms.cols() - 1) = rise * from_pivot;
        }
        its.growth[i] = value.place[axis];
        its.weight[i] = data.weight[row];
        its.groups.push_back(value.group);
        its.duties.push_back(data.duty[row]);
    }
    result.found = identified_growth(its, usual, value_sigma);
    const VectorXd& w = result.found.value;
    const VectorXd variance = result.found.covariance.diagonal();
    result.growth = w.head(all);
    result.slope = form.slope ? VectorXd(w.segment(all, all)) : VectorXd::Zero(all);
    result.growth_sigma = VectorXd::Zero(all);
    const double share = result.found.share;
    for (Index s = 0; s < all; ++s) {
        const double by_slope = form.slope ? variance[all + s] * result.travel * result.travel : 0;
        result.growth_sigma[s] = std::sqrt(variance[s] + by_slope + std::pow(share * w[s], 2));
    }
    if (form.speed) {
        result.by_speed = w[all + slopes];
        result.speed_sigma = std::hypot(std::sqrt(variance[all + slopes]), share * result.by_speed);
    }
    const bool physical = (result.growth.head(chosen).array().abs() <= most_growth).all() &&
                          (result.slope.array().abs() <= most_slope).all() &&
                          std::abs(result.by_speed) <= most_by_speed;
    bool separate = true;
    for (Index s = 0; s < chosen && chosen > 1; ++s)
        separate &= std::abs(w[s]) > determined * std::sqrt(variance[s]);
    if (physical && separate && w.size() > own)
        result.score =
            result.found.predicted_rest * std::pow(cost, form.terms()) * (form.speed ? cost_of_speed : 1);
    return result;
}

using Laws = std::array<std::optional<AxisResult>, 3>;

double squares_of(const Laws& laws) {
    double sum = 0;
    for (const auto& law : laws)
        if (law && std::isfinite(law->score)) sum += law->score * law->score;
    return sum;
}

// Each way to choose up to `most` sensors.
std::vector<std::vector<std::size_t>> choices(std::size_t sensors, std::size_t most) {
    std::vector<std::vector<std::size_t>> all{{}};
    for (std::size_t begin = 0, size = 1; size <= std::min(most, sensors); ++size) {
        const std::size_t end = all.size();
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t s = all[i].empty() ? 0 : all[i].back() + 1; s < sensors; ++s) {
                all.push_back(all[i]);
                all.back().push_back(s);
            }
        begin = end;
    }
    return all;
}

// Chooses the laws of the axes, beginning with the axis of the largest drift. All axes together use at most
// as many sensors as axis_growth has. The time constants of the spindle are common to them.
Laws choose(const Data& data, double power) {
    const std::size_t places = GrowthLaw::sensors - (data.structure ? 1 : 0);
    const auto subsets = choices(data.sensors.size(), data.sensors.size() > 3 ? 2 : 3);
    std::vector<std::pair<double, int>> order;
    for (int axis = 0; axis < 3; ++axis)
        if (data.measured[static_cast<std::size_t>(axis)])
            order.emplace_back(-fit(data, axis, {}, power).found.drift, axis);
    std::sort(order.begin(), order.end());
    const auto best_of = [&](int axis, std::set<std::size_t>& used, const Form& form) {
        AxisResult best = fit(data, axis, form, power);
        const auto [low, high] = travel_of(data, axis);
        const bool travels = data.course->places && high - low >= least_travel;
        for (const auto& subset : subsets) {
            std::set<std::size_t> together = used;
            together.insert(subset.begin(), subset.end());
            if (together.size() > places) continue;
            for (const bool slope : {false, true}) {
                if (slope && !travels) continue;
                if (subset.empty() && !slope) continue;
                Form its = form;
                its.sensors = subset;
                its.slope = slope;
                AxisResult result = fit(data, axis, its, power);
                if (result.score < best.score) best = std::move(result);
            }
        }
        used.insert(best.form.sensors.begin(), best.form.sensors.end());
        return best;
    };
    const auto laws_of = [&](const Form& form, const Laws& without) {
        Laws laws;
        std::set<std::size_t> used;
        for (const auto& [drift, axis] : order) {
            const auto at = static_cast<std::size_t>(axis);
            laws[at] = best_of(axis, used, form);
            if (without[at] && !(laws[at]->score < without[at]->score)) laws[at] = without[at];
        }
        return laws;
    };
    Laws best = laws_of({}, {});
    if (!data.turned) return best;
    const Laws without = best;
    for (const double turning : {150.0, 300.0, 600.0, 1200.0, 2400.0})
        for (const double ratio : {1.0, 2.0, 4.0}) {
            Form form;
            form.speed = true;
            form.turning = turning;
            form.stopped = ratio * turning;
            const Laws with = laws_of(form, without);
            if (squares_of(with) < squares_of(best)) best = with;
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
                      "%c: drift %.1f um rms; the law leaves %.1f um, and %.1f um of duties it did not see%s",
                      letter, its.drift * 1e3, its.rest * 1e3, its.predicted_rest * 1e3,
                      its.used ? "" : ": not used, as it does not help");
    else
        std::snprintf(text, sizeof text, "%c: was not measured", letter);
    return text;
}

GrowthIdentified growth_identified(const GrowthCourse& course, const GrowthIdentifyOptions& options) {
    const Data data = read(course, options);
    const Laws laws = choose(data, options.speed_exponent);
    const double unit = course.millimetres;
    GrowthIdentified result;
    std::string& lines = result.lines;
    result.sensors.resize(GrowthLaw::sensors);

    // The sensors that a law reads, by their number in axis_growth.
    std::map<int, const Sensor*> numbered;
    int structure = -1;
    const auto number_of = [&](const Sensor& sensor) {
        for (const auto& [number, its] : numbered)
            if (its->name == sensor.name) return number;
        const int number = sensor.number >= 0 ? sensor.number : static_cast<int>(numbered.size());
        numbered[number] = &sensor;
        result.sensors[static_cast<std::size_t>(number)] = sensor.name;
        return number;
    };

    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!laws[axis]) continue;
        const AxisResult& law = *laws[axis];
        const IdentifiedGrowth& found = law.found;
        GrowthIdentified::Axis& its = result.axes[axis];
        its.probed = true;
        bool certain = law.form.slope;
        for (Index i = 0; i < found.value.size(); ++i)
            certain |= std::abs(found.value[i]) > determined * std::sqrt(found.covariance(i, i));
        its.used = std::isfinite(law.score) && certain && found.predicted_rest < 0.8 * found.drift;
        its.drift = found.drift;
        its.rest = found.rest;
        its.predicted_rest = found.predicted_rest;
        its.floor = found.floor;
        its.share = found.share;
        its.slope = law.form.slope;
        its.speed = law.form.speed;
        const std::string prefix = options.instance + '.' + "xyz"[axis] + '-';
        // What is not compensated is as uncertain as it is large.
        const double floor = its.used ? found.floor : found.drift;
        lines += line(prefix + "sigma", std::max(floor, value_sigma) / unit);
        for (Index s = 0; s < law.growth.size(); ++s) {
            const bool common = s == static_cast<Index>(law.form.sensors.size());
            const Sensor& sensor =
                common ? *data.structure : data.sensors[law.form.sensors[static_cast<std::size_t>(s)]];
            const int n = number_of(sensor);
            if (common) structure = n;
            const std::string number = std::to_string(n);
            const double unused = its.used ? 0 : law.growth[s];
            if (its.used) lines += line(prefix + "growth-" + number, law.growth[s] / unit);
            lines += line(prefix + "growth-sigma-" + number, std::hypot(law.growth_sigma[s], unused) / unit);
            if (!its.used) continue;
            if (law.form.slope) lines += line(prefix + "slope-" + number, law.slope[s]);
            its.terms.push_back(
                {common ? "all sensors together" : sensor.name, law.growth[s], law.growth_sigma[s]});
        }
        if (!its.used) continue;
        if (law.form.slope) {
            lines += line(prefix + "pivot", law.pivot / unit);
            lines += line(prefix + "travel", law.travel / unit);
        }
        if (law.form.speed) {
            lines += line(prefix + "speed-growth", law.by_speed / unit);
            lines += line(prefix + "speed-sigma", law.speed_sigma / unit);
            its.terms.push_back({"speed", law.by_speed, law.speed_sigma});
        }
    }
    lines += line(options.instance + ".structure", structure);
    if (data.structure) result.structure = data.structure->name;
    for (const auto& [number, sensor] : numbered) {
        const std::string its = std::to_string(number);
        lines += "# " + sensor->name + "\n";
        lines += line(options.instance + ".reference-" + its, data.reference(*sensor));
        if (number == structure) continue;
        double low = 0, high = 0;
        for (const auto& sample : sensor->samples) {
            if (sample.first < data.cold) continue;
            const double rise = data.rise(*sensor, sample.first);
            low = std::min(low, rise);
            high = std::max(high, rise);
        }
        lines += line(options.instance + ".rise-low-" + its, low);
        lines += line(options.instance + ".rise-high-" + its, high);
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
        all["axes"][std::string(1, "XYZ"[axis])] = {
            {"drift_mm", its.drift}, {"rest_mm", its.rest},   {"predicted_rest_mm", its.predicted_rest},
            {"used", its.used},      {"slope", its.slope},    {"speed", its.speed},
            {"terms", terms},        {"floor_mm", its.floor}, {"share", its.share}};
    }
    return all;
}

}  // namespace plumb::commissioning
