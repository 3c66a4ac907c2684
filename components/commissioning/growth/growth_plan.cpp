// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_plan.hpp"

#include <nlohmann/json.hpp>

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

constexpr int terms = 3;  // temperature of the spindle, temperature of the structure, speed
using Terms = Eigen::Matrix<double, terms, 1>;
using Matrix = Eigen::Matrix<double, terms, terms>;

// As plumb growth identify expects them before the test, in um.
const Terms usual(50, 50, 50);

// The expansion of the artifact, which looks like growth by the structure.
constexpr double usual_artifact = 3;  // um/K

// The temperatures that the sensors would read during the planned test.
class PlannedMachine {
public:
    PlannedMachine(const GrowthPlanOptions& options, double phase)
        : its_(options.machine), fastest_(options.fastest), phase_(phase) {}

    void step(double share, bool moving, bool door, double dt) {
        time_ += dt;
        const double spindle =
            spindle_.step(its_.spindle_rise * share, share > 0 ? its_.turning_time : its_.stopped_time, dt);
        const double structure = structure_.step(its_.structure_rise * ((moving ? 0.5 : 0) + 0.5 * share),
                                                 its_.structure_time, dt);
        const double shop =
            1.5 * (std::sin(2 * pi * time_ / 86400 + phase_) - std::sin(phase_)) - (door ? 4 : 0);
        drive_.step(share * fastest_, {}, dt);
        const double body = structure + shop_.step(shop, 5400, dt);
        now_ = {spindle + body, body, drive_.value()};
        artifact_.step(shop + 0.25 * structure, 5400, dt);
    }
    const Terms& now() const { return now_; }
    double artifact() const { return artifact_.value(); }  // K

private:
    const GrowthPlanMachine& its_;
    double fastest_, phase_, time_ = 0;
    FirstOrderLag spindle_, structure_, shop_, artifact_;
    SpindleDrive drive_;
    Terms now_ = Terms::Zero();
};

constexpr double step = 60;  // s

// Mean square of the terms on other days, from a quarter of an hour after their start.
Matrix other_days(const GrowthPlanOptions& options) {
    constexpr int days = 24;
    constexpr double length = 4 * 3600, zero_time = 900;
    Matrix sum = Matrix::Zero();
    int count = 0;
    Random random(1, 3);
    for (int day = 0; day < days; ++day) {
        PlannedMachine machine(options, random.uniform(0, 2 * pi));
        double until = 0, share = 0;
        Terms zero = Terms::Zero();
        for (double t = 0; t < length; t += step) {
            if (t >= until) {
                share = random.uniform() < 0.3 ? 0 : random.uniform(0.25, 1);
                until = t + random.uniform(600, 3600);
            }
            machine.step(share, share > 0, false, step);
            if (t <= zero_time) zero = machine.now();
            const Terms since = machine.now() - zero;
            sum += since * since.transpose();
            ++count;
        }
    }
    return sum / count;
}

// Covariance of the terms after the test.
Matrix covariance(const std::vector<GrowthPlan::Cycle>& cycles, const GrowthPlanOptions& options) {
    PlannedMachine machine(options, 0);
    using All = Eigen::Matrix<double, terms + 1, 1>;  // and the artifact
    std::vector<All> passes;
    const auto run = [&](double minutes, double share, bool moving, bool door) {
        for (double t = 0; t < minutes * 60; t += step) machine.step(share, moving, door, step);
    };
    const auto probe = [&](bool door) {
        run(options.pass / 2, 0, true, door);
        passes.push_back((All() << machine.now(), machine.artifact()).finished());
        run(options.pass / 2, 0, true, door);
    };
    probe(false);
    for (const GrowthPlan::Cycle& cycle : cycles) {
        const double share = cycle.speed / options.fastest;
        run(options.work, share, share > 0, cycle.door);
        probe(cycle.door);
    }
    All mean = All::Zero();
    for (const All& pass : passes) mean += pass / static_cast<double>(passes.size());
    const double artifact = options.machine.artifact_known ? 1e-3 : usual_artifact;
    const All before = (All() << usual, artifact).finished();
    Eigen::Matrix<double, terms + 1, terms + 1> information =
        before.array().square().inverse().matrix().asDiagonal();
    const double rest = options.machine.rest;
    for (const All& pass : passes) information += (pass - mean) * (pass - mean).transpose() / (rest * rest);
    return information.inverse().topLeftCorner<terms, terms>();
}

struct Search {
    GrowthPlanOptions options;
    Matrix days;

    // Of the growth on another day. Two speeds show no exponent.
    double variance(const std::vector<GrowthPlan::Cycle>& cycles) const {
        std::set<double> speeds;
        for (const auto& cycle : cycles) speeds.insert(cycle.speed);
        const double its = (covariance(cycles, options) * days).trace();
        return speeds.size() < 3 ? 1e6 * its : its;
    }

    // Each cycle in turn takes the speed and the door that help most, until none helps. A longer test begins
    // as the shorter one does, too: so it is never worse.
    std::vector<GrowthPlan::Cycle> best(int count, const std::vector<GrowthPlan::Cycle>& shorter = {}) const {
        std::vector<GrowthPlan::Cycle> best;
        double least = HUGE_VAL;
        for (const double start : {1.0, 0.5, 0.0, -1.0}) {
            if (start < 0 && shorter.empty()) continue;
            std::vector<GrowthPlan::Cycle> its(static_cast<std::size_t>(count),
                                               {std::abs(start) * options.fastest, false});
            if (start < 0) std::copy(shorter.begin(), shorter.end(), its.begin());
            double now = variance(its);
            bool doors = false;  // first without
            for (bool better = true; better || doors != options.door;) {
                if (!better) doors = true;
                better = false;
                for (GrowthPlan::Cycle& cycle : its)
                    for (const double share : {1.0, 0.75, 0.5, 0.25, 0.0})
                        for (const bool door : {false, true}) {
                            if (door && !doors) continue;
                            const GrowthPlan::Cycle before = cycle;
                            cycle = {share * options.fastest, door};
                            const double with = variance(its);
                            if (with < now * (1 - 1e-6)) {
                                now = with;
                                better = true;
                            } else {
                                cycle = before;
                            }
                        }
            }
            if (now < least) {
                least = now;
                best = its;
            }
        }
        return best;
    }
};

int cycles_in(const GrowthPlanOptions& options, double hours) {
    return static_cast<int>((hours * 60 - options.pass) / (options.work + options.pass) + 1e-9);
}

template <class... Values>
std::string formatted(const char* form, Values... values) {
    char text[200];
    std::snprintf(text, sizeof text, form, values...);
    return text;
}

}  // namespace

GrowthPlan growth_plan(const GrowthPlanOptions& given) {
    GrowthPlanOptions options = given;
    if (options.work == 0)
        options.work =
            std::clamp(std::floor((options.hours * 60 - options.pass) / 4 - options.pass), 10.0, 30.0);
    const int count = cycles_in(options, options.hours), more = cycles_in(options, options.hours + 1);
    if (count < 3)
        throw std::runtime_error(
            formatted("%g h has %d cycles of %g min; a law needs three, and better seven", options.hours,
                      std::max(count, 0), options.work + options.pass));
    if (more > 60) throw std::runtime_error("a plan has at most 60 cycles");
    const Search search{options, other_days(options)};
    GrowthPlan plan;
    plan.options = options;
    plan.cycles = search.best(count);
    const Matrix before = usual.array().square().matrix().asDiagonal();
    const Matrix after = covariance(plan.cycles, options), later = covariance(search.best(more, plan.cycles), options);
    const char* const names[] = {"temperature of the spindle", "temperature of the structure", "spindle speed"};
    for (int i = 0; i < terms; ++i)
        plan.terms.push_back(
            {names[i], i == 2 ? "um" : "um/K", usual[i], std::sqrt(after(i, i)), std::sqrt(later(i, i))});
    const auto on_a_day = [&](const Matrix& its) { return std::sqrt((its * search.days).trace()); };
    plan.terms.push_back({"growth on another day", "um", on_a_day(before), on_a_day(after), on_a_day(later)});
    return plan;
}

std::string GrowthPlan::text() const {
    std::string text =
        formatted("A growth test of %g h: a cold pass, then %d cycles of %g min work and a pass\n\n",
                  options.hours, static_cast<int>(cycles.size()), options.work);
    for (std::size_t i = 0; i < cycles.size(); ++i)
        text += formatted("%4d  %s%s\n", static_cast<int>(i + 1),
                          cycles[i].speed > 0 ? formatted("%.0f rpm", cycles[i].speed).c_str() : "rest",
                          cycles[i].door ? ", shop door open" : "");
    text +=
        formatted("\n%-28s%10s%10s%14s   standard uncertainty in Z\n", "", "before", "after", "an hour more");
    for (const Term& term : terms)
        text += formatted("%-28s%10.1f%10.1f%14.1f   %s\n", term.name.c_str(), term.before, term.after,
                          term.hour_more, term.unit.c_str());
    const GrowthPlanMachine& its = options.machine;
    text += "\nfor " + (its.log.empty() ? "a usual machine" : "the machine of " + its.log) +
            formatted(", whose law leaves %.1f um of a pass\n", its.rest);
    text += formatted(
        "spindle %.1f K above the structure in the end, in %.0f min, at rest in %.0f min; structure %.1f K "
        "in %.0f min\n",
        its.spindle_rise, its.turning_time / 60, its.stopped_time / 60, its.structure_rise,
        its.structure_time / 60);
    text += its.artifact_known
                ? "the expansion of the artifact is known\n"
                : "the expansion of the artifact is not known: write it into [artifact] for growth_log\n";
    return text;
}

std::string GrowthPlan::json() const {
    nlohmann::json all{{"hours", options.hours}, {"work_min", options.work}, {"pass_min", options.pass}};
    const GrowthPlanMachine& its = options.machine;
    all["machine"] = {{"log", its.log},
                      {"rest_um", its.rest},
                      {"spindle_rise_k", its.spindle_rise},
                      {"turning_s", its.turning_time},
                      {"stopped_s", its.stopped_time},
                      {"structure_rise_k", its.structure_rise},
                      {"structure_s", its.structure_time},
                      {"artifact_known", its.artifact_known}};
    for (const Cycle& cycle : cycles) all["cycles"].push_back({{"rpm", cycle.speed}, {"door", cycle.door}});
    for (const Term& term : terms)
        all["terms"].push_back({{"name", term.name},
                                {"unit", term.unit},
                                {"before", term.before},
                                {"after", term.after},
                                {"hour_more", term.hour_more}});
    return all.dump(1) + '\n';
}

std::string GrowthPlan::program() const {
    const GrowthPlanMachine& its = options.machine;
    std::string text = formatted(
        "; SPDX-License-Identifier: GPL-2.0-or-later\n"
        "; o<growth_plan> call [cycle]: its speed, and whether the shop door is open. "
        "plumb growth plan --hours %g --ngc\n; wrote it%s.\no<growth_plan> sub\n",
        options.hours,
        its.log.empty()
            ? ""
            : (" for the machine of " + std::filesystem::path(its.log).filename().string()).c_str());
    text += formatted("#<_growth_planned> = %d\n#<_growth_minutes> = %g\n", static_cast<int>(cycles.size()),
                      options.work);
    text += "#<_growth_speed> = 0\n#<_growth_door> = 0\n";
    for (std::size_t i = 0; i < cycles.size(); ++i) {
        if (cycles[i].speed == 0 && !cycles[i].door) continue;
        const int label = 10 + static_cast<int>(i);
        text += formatted("o%d if [#1 EQ %d]\n  #<_growth_speed> = %.0f\n", label, static_cast<int>(i + 1),
                          cycles[i].speed);
        if (cycles[i].door) text += "  #<_growth_door> = 1\n";
        text += formatted("o%d endif\n", label);
    }
    return text + "o<growth_plan> endsub\nM2\n";
}

}  // namespace plumb::commissioning
