// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/attack.hpp"

#include "tests/support/place.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace plumb {
namespace {

constexpr double period = 0.001;  // s, of all live machines

// Loaded once: its declarations do not change.
const hal::Declarations& declarations_of(const std::string& module) {
    struct Loaded {
        explicit Loaded(const std::string& name)
            : module(build_folder() + "/modules/" + name + ".so"), declarations(module.model()) {}
        Module module;
        hal::Declarations declarations;
    };
    static std::map<std::string, std::unique_ptr<Loaded>> known;
    std::unique_ptr<Loaded>& its = known[module];
    if (!its) its = std::make_unique<Loaded>(module);
    return its->declarations;
}

// Its pins: some of those declared exist only with an option. Started once.
const std::map<std::string, Wired>& wiring_of(const Live& live) {
    static std::map<const Live*, std::map<std::string, Wired>> known;
    std::map<std::string, Wired>& its = known[&live];
    if (its.empty()) {
        Bench bench(Bench::Thread::none, with_specimens());
        live.start(bench);
        its = wiring(bench);
    }
    return its;
}

std::string text(double value) {
    std::ostringstream out;
    out.precision(17);
    out << value;
    return out.str();
}

// How fast the counts c change the own part beside a guest, less the quantum of one count. x is LinuxCNC's
// request, r the stage's input for it, g the guest's request, n and k are the guest's counts and their scale,
// and a is the own part in force. `before` is the own request before this step.
//
// A step of the counts is the sum of the guest's step and the own one. There are two exceptions.
//
// LinuxCNC forgets all offsets: x is 0, and both parts start from 0. The counts then contain at most the
// guest's step of this period, not what the guest has lost.
//
// The guest's request changes while the counts wait, without a valid report or unhomed. The counts then catch
// up in one step. The own part starts from the one in force, which lags behind its request by at most `lag`.
std::string change_beside_a_guest(const std::string& before, double rate) {
    const std::string step = "c_rate * s", never = "1e99";
    const std::string forgetting = "x == 0 ? min(abs(" + step + "), finite(k) > 0 ? abs(" + step +
                                   " - n_rate * k) : " + never + ") : " + never;
    const std::string lag = "(12 * s + " + text(0.012 * rate) + ")";
    const std::string waited =
        "((x != 0 || (abs(r_rate) < 1e9) == 0) && abs(" + before + " - a) > " + lag + ")";
    const std::string catching_up =
        waited + " ? 1000 * (abs(x + " + step + " * 0.001 - g - a) - " + lag + ") : " + never;
    return "(c_rate == 0 ? 0 : min(abs(" + step + " - g_rate), " + forgetting + ", " + catching_up +
           ")) - 1000 * s";
}

}  // namespace

std::vector<Attackable> attackable_inputs(const Live& live) {
    std::vector<Attackable> result;
    const std::map<std::string, Wired>& loaded = wiring_of(live);
    for (const Live::Part& part : live.parts) {
        const hal::Declarations& declared = declarations_of(part.module);
        for (const hal::PinInfo& pin : declared.pins) {
            if (pin.output || loaded.count(part.instance + "." + pin.name) == 0) continue;
            const bool echo = std::any_of(declared.offsets.begin(), declared.offsets.end(),
                                          [&](const hal::OffsetInfo& offset) {
                                              return !offset.counts.empty() && offset.value == pin.name;
                                          });
            result.push_back({part.instance + "." + pin.name, pin.type,
                              live.around.smooth_inputs.count(pin.name) > 0, echo});
        }
    }
    return result;
}

Attack::Attack(const Live& live, const Focus& focus)
    : live_(live), bench_(Bench::Thread::none, with_specimens()), smooth_(focus.smooth) {
    live.start(bench_);
    wiring_ = wiring(bench_);
    for (const std::string& pin : focus.pins) own_[pin] = bench_.get(pin);
    if (smooth_) load_meters();
    for (const Live::Part& part : live.parts)
        for (const hal::OffsetInfo& offset : declarations_of(part.module).offsets) watch(part, offset);
    for (const Live::Part& part : live.parts)
        for (const hal::PinInfo& pin : declarations_of(part.module).pins)
            if (pin.output && pin.type == hal::Type::real) {
                const std::string name = part.instance + "." + pin.name;
                bench_.client().expect("finite " + name, "finite(x)", {{"x", name}});
            }
}

// Stock ddt for each offset that declares its acceleration.
void Attack::load_meters() {
    std::string names;
    for (const Live::Part& part : live_.parts)
        for (const hal::OffsetInfo& offset : declarations_of(part.module).offsets)
            if (!offset.acceleration.empty() && wiring_.count("speed-of-" + part.instance + ".in") == 0)
                names += (names.empty() ? "" : ",") + ("speed-of-" + part.instance);
    if (!names.empty()) bench_.command("loadrt ddt names=" + names);
}

void Attack::watch(const Live::Part& part, const hal::OffsetInfo& offset) {
    const auto full = [&](const std::string& pin) { return pin.empty() ? "" : part.instance + "." + pin; };
    // LinuxCNC's offset by counts, and the command of motion, are those of the signal, even if the input
    // gets another value.
    const auto signal_of = [&](const std::string& pin) {
        const std::string& signal = wiring_.at(full(pin)).signal;
        return signal.empty() ? full(pin) : signal;
    };
    Watched watched;
    watched.name = full(offset.counts.empty() ? offset.value : offset.counts);
    watched.value = offset.counts.empty() ? full(offset.value) : signal_of(offset.value);
    watched.counts = full(offset.counts);
    watched.scale = full(offset.scale);
    watched.guest = full(offset.guest);
    if (!offset.guest.empty())
        watched.beside_guest = {{"r", full(offset.value)},
                                {"n", full("guest-counts")},
                                {"k", full("guest-scale")},
                                {"a", full("applied-offset")}};
    for (const std::string& position : offset.motion) watched.motion.push_back(full(position));
    watched.slope = offset.slope;
    watched.bound = full(offset.bound);
    watched.rate = full(offset.rate);
    watched.limited = full(offset.limited);
    if (!offset.acceleration.empty()) watched.refusal = full("fault");
    watched.driven = full(offset.driven);
    watched.homed = full(offset.homed);
    watched.bound_in_force = bench_.get(watched.bound);
    watched.rate_in_force = bench_.get(watched.rate);
    if (smooth_ && !offset.acceleration.empty()) {
        watched.acceleration = full(offset.acceleration);
        const std::string meter = "speed-of-" + part.instance;
        const std::string& signal = wiring_.at(watched.value).signal;
        bench_.command("net " + (signal.empty() ? meter : signal) + " " + watched.value + " " + meter +
                       ".in");
        bench_.command("addf " + meter + " servo-thread");
        bench_.run(3 * period);
        bench_.client().expect("acceleration of " + watched.name,
                               "abs(v_rate) <= " + text(offset.times) + " * a * 1.001 + 1e-6",
                               {{"v", meter + ".out"}, {"a", watched.acceleration}});
    }
    expect(watched);
    watched_.push_back(watched);
}

void Attack::expect(const Watched& its) {
    std::map<std::string, std::string> variables{{"x", its.value}};
    std::string quantum = "0", changed = "abs(x_rate)", own = "x", own_rate = "x_rate", forgotten;
    if (!its.counts.empty()) {
        variables["c"] = its.counts;
        variables["s"] = its.scale;
        quantum = "s";
        changed = "abs(c_rate * s) - 1000 * s";
    }
    if (!its.guest.empty()) {
        variables["g"] = its.guest;
        for (const auto& [variable, pin] : its.beside_guest) variables[variable] = pin;
        own = "(x - (g - g_rate * 0.001))";  // LinuxCNC answers a period later
        own_rate = "(x_rate - g_rate)";
        forgotten = " || (x == 0 && x_rate != 0)";
        changed = change_beside_a_guest(own, its.rate_in_force);
    }
    std::string unless;
    if (!its.driven.empty()) {
        variables["u"] = its.driven;
        variables["h"] = its.homed;
        unless = "u == 0 || h_rate != 0 || ";
    }
    bench_.client().expect("bound of " + its.name,
                           unless + "abs(" + own + ") <= " + text(its.bound_in_force * (1 + 1e-9) + 1e-12) +
                               " + " + quantum + " || abs(" + own + ") <= abs(" + own + " - " + own_rate +
                               " * 0.001) + 1e-12" + forgotten,
                           variables);
    std::string rate = unless + changed + " <= " + text(its.rate_in_force * (1 + 1e-6) + 1e-9);
    for (std::size_t i = 0; i < its.motion.size(); ++i) {
        const std::string name = "p" + std::to_string(i);
        variables[name] = its.motion[i];
        rate += " + (finite(" + name + "_rate) > 0 ? " + text(its.slope) + " * abs(" + name + "_rate) : 0)";
    }
    bench_.client().expect("rate of " + its.name, rate, variables);
}

void Attack::set(const std::string& pin, double value) {
    const std::string& signal = wiring_.at(pin).signal;
    if (!signal.empty() && given_.count(pin) == 0) bench_.command("unlinkp " + pin);
    bench_.set(pin, value);
    given_[pin] = value;
    follow_settings();
}

void Attack::give_back(const std::string& pin) {
    if (given_.erase(pin) == 0) return;
    const std::string& signal = wiring_.at(pin).signal;
    bench_.set(pin, own_.at(pin));
    if (!signal.empty()) bench_.command("net " + signal + " " + pin);
    follow_settings();
}

void Attack::turn(std::size_t knob, double value) {
    bench_.set(live_.around.knobs[knob].pin, value);
}

void Attack::run(double seconds) {
    bench_.client().run(client::seconds(seconds));
    for (Watched& its : watched_)
        if (!its.refusal.empty() && bench_.get(its.refusal) == 0 &&
            bench_.get(its.bound) < its.bound_in_force) {
            its.bound_in_force = bench_.get(its.bound);
            expect(its);
        }
}

bool Attack::settings_are_whole() const {
    return std::all_of(given_.begin(), given_.end(), [](const auto& each) {
        return std::abs(each.second) <= 100 && each.second >= 0;  // the range of any setting
    });
}

// While one setting is impossible, the last good set is in force, which may be any before: the largest one
// counts. A bound below the offset is refused, so it counts once there is no fault, after a run. A rate that
// was reduced is reached by braking: the largest one counts for the rest of the attack.
void Attack::follow_settings() {
    for (Watched& its : watched_) {
        const auto bound = given_.find(its.bound), rate = given_.find(its.rate);
        const double wanted_bound = bound != given_.end() ? bound->second : bench_.get(its.bound);
        const double wanted_rate = rate != given_.end() ? rate->second : bench_.get(its.rate);
        const double before_bound = its.bound_in_force, before_rate = its.rate_in_force;
        if (settings_are_whole() && (its.refusal.empty() || wanted_bound > its.bound_in_force))
            its.bound_in_force = wanted_bound;
        else if (wanted_bound <= 1e3)
            its.bound_in_force = std::max(its.bound_in_force, wanted_bound);
        if (wanted_rate <= 1e4) its.rate_in_force = std::max(its.rate_in_force, wanted_rate);
        if (its.bound_in_force != before_bound || its.rate_in_force != before_rate) expect(its);
    }
}

void Attack::end() {
    while (!given_.empty()) give_back(std::string(given_.begin()->first));
    for (const Live::Knob& knob : live_.around.knobs) bench_.set(knob.pin, knob.values.front());
    run(live_.recovery);
    if (!live_.around.rest) return;
    for (const std::string& complaint : live_.around.rest(bench_))
        complaints_.push_back("at rest: " + complaint);
}

std::vector<std::string> Attack::complaints() {
    std::vector<std::string> result = complaints_;
    for (const client::Violation& violation : bench_.client().violations()) {
        std::string values;
        for (const auto& [name, value] : violation.values) values += ", " + name + " = " + text(value);
        result.push_back(violation.id + ": " + std::to_string(violation.count) + " periods, first at " +
                         text(std::chrono::duration<double>(violation.first_time).count()) + " s" + values);
    }
    return result;
}

}  // namespace plumb
