// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/delayed_bit.hpp"
#include "components/stages/interlock/commissioning.hpp"
#include "components/stages/interlock/functions.hpp"
#include "components/stages/interlock/interlock_status.hpp"
#include "components/stages/interlock/interlock_waiting.hpp"
#include "components/stages/interlock/services.hpp"
#include "components/stages/interlock/stages.hpp"
#include "hal/component.hpp"
#include "hal/thread_watch.hpp"
#include "pages/interlock.page.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace plumb {

enum class Fault : std::int32_t { none, time, services, operation, order, silent };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::time:
            return "A service-timeout or a delay of a message is out of range (0 to 3600 s), or clock-speed "
                   "(0.01 to 1000); its last good value is used.";
        case Fault::services:
            return "One of function-services, function-urgent and feed-services names a service without a "
                   "row "
                   "(services=N); it stands for all services.";
        case Fault::order:
            return "A function of Plumb is in a wrong place of its thread, or in none: run plumb doctor "
                   "--running; no cycle is armed, and offsets are held as soon as no function is busy.";
        case Fault::silent:
            return "A stage or a function is not heard: net its state to stage-state or function-state of "
                   "its "
                   "row, and the permit of that row to it; silent-row gives the row.";
        case Fault::operation: return "The operation-key is invalid or beyond 2147483647; operation is 0.";
        default: return nullptr;
    }
}

struct Interlock final : hal::Component {
    static constexpr hal::About about{
        "interlock", "permits functions to compensate, arms stages, and requests that LinuxCNC waits", page,
        "Interlock"};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0,
                                      "Kind of motion: motion.motion-type; 5 is a probing move."};
    hal::In<double> path_speed{this, "path-speed", 0, "mu/s",
                               "Speed along the path: motion.current-vel. With it, a move that begins in "
                               "spite of feed-inhibit is aborted."};
    hal::In<bool> program_running{this, "program-running", false, "A program runs or is paused."};
    hal::In<std::int32_t> feed_services{
        this, "feed-services", 0, "Services whose loss holds the feed, as a sum like function-services."};
    hal::In<double> operation_key{this, "operation-key", 0, "1",
                                  "Key of the operation, which the program sets by M68."};
    hal::Count number_of_functions{
        this, "functions", 1, 0, Functions::most, "Number of functions, 0 to 16: the rows function-...-N."};
    hal::Count number_of_stages{this, "stages",     1,
                                0,    Stages::most, "Number of stages, 0 to 17: the rows stage-...-N."};
    hal::Count number_of_services{this,           "services",
                                  Services::most, 0,
                                  Services::most, "Number of services, 0 to 8: the rows service-...-N."};
    Services services{this, number_of_services};
    Functions functions{this, number_of_functions, number_of_stages, number_of_services};
    Stages stages{this, number_of_stages};
    Commissioning commissioning{this, functions.number(), stages.number()};
    hal::In<double> uncompensated_delay{
        this, "uncompensated-delay", 2, "s",
        "Time for which an axis lacks its offset before uncompensated is true."};
    hal::In<double> probing_refused_time{this, "probing-refused-time", 5, "s",
                                         "Time for which probing-refused stays true after the refusal."};
    hal::In<double> feed_held_delay{this, "feed-held-delay", 5, "s",
                                    "Time for which the feed is held before feed-held is true."};

    hal::Out<std::int32_t> heartbeat{this, "heartbeat", "Counts the periods."};
    hal::Out<bool> arm{this, "arm", "A cycle runs in which offsets may be applied."};
    hal::Out<bool> ramping{this, "ramping", "A function or a stage is still ramping to its target."};
    hal::Out<bool> homing_inhibit{
        this, "homing-inhibit",
        "An offset is in force, and LinuxCNC must not home: to motion.homing-inhibit."};
    hal::Out<bool> feed_inhibit{this, "feed-inhibit",
                                "The next move must wait: to motion.feed-inhibit and motion.feed-hold."};
    hal::Out<bool> feed_service_lost{this, "feed-service-lost", "A lost service holds the feed."};
    hal::Out<bool> abort{this, "abort", "LinuxCNC must abort: to halui.abort."};
    hal::Out<bool> compensated{this, "compensated", "All functions that are switched on compensate."};
    hal::Out<bool> uncompensated{this, "uncompensated",
                                 "An axis has lacked its offset for uncompensated-delay."};
    hal::Out<std::int32_t> uncompensated_stage{
        this, "uncompensated-stage", "Number of the first stage whose axis lacks its offset, or -1."};
    hal::Out<std::int32_t> silent_row{
        this, "silent-row",
        "Number of the first stage that is not heard, or 100 and that of the first function; -1: none."};
    hal::Out<bool> probing_refused{this, "probing-refused",
                                   "A probing move was refused; true for probing-refused-time."};
    hal::Out<bool> hold_defeated{
        this, "hold-defeated",
        "A move began in spite of feed-inhibit, and was aborted; true for probing-refused-time. M49, M51 P0 "
        "and M53 P0 disable the holds of LinuxCNC."};
    hal::Out<bool> feed_held{this, "feed-held", "The feed has been held for feed-held-delay."};
    hal::Out<std::int32_t> operation{this, "operation", "Key of the operation as a whole number."};
    hal::Codes<Waiting> waiting{this, "waiting", "The machine waits; waiting-code gives the reason."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::ComponentStatus<InterlockStatus> status{this};
    hal::Told told_held{this, "feed-held", hal::Tell::text,
                        "The feed is held until the axes have their offsets."};
    hal::Told told_loss{this, "feed-service-lost", hal::Tell::error, "{waiting-code}"};
    hal::Told told_probing{
        this, "probing-refused", hal::Tell::error,
        "Probing is aborted: its result would contain the offset of an axis. Take the offset "
        "back, or use o<probe_work> call."};
    hal::Told told_defeat{
        this, "hold-defeated", hal::Tell::error,
        "A move began while an offset had not settled, and was aborted: M49, M51 P0 and M53 P0 "
        "disable the holds of LinuxCNC."};
    hal::Told told_lacks{
        this, "uncompensated", hal::Tell::text,
        "An axis lacks its offset until the next cycle starts: touch off by o<touch_off> call."};

    hal::Function run{this, "update", &Interlock::update, hal::Place::interlock};

    void background() override {
        threads_.work();
        commissioning.work();
    }

    void update(double dt) noexcept {
        const bool in_order = threads_.step(dt);
        const bool on = motion_enabled, homed = all_homed, cycle = cycle_running;
        const std::int32_t type = motion_type;
        const bool probing = type == probe;
        const double speed = path_speed;
        const Delays delays{uncompensated_delay, probing_refused_time, feed_held_delay};
        if (delays.valid()) delays_ = delays;
        const double key = operation_key;
        const bool known_key = std::abs(key) <= std::numeric_limits<std::int32_t>::max();

        const bool able = cycle && on && homed, starts = able && !cycle_;
        cycle_ = cycle;
        const bool good_times = services.step(dt) && delays.valid();
        const std::int32_t feed_needs = feed_services;
        const bool good_feed_needs = services.exist(feed_needs);
        const bool running = program_running;
        const bool cuts = running && type != rapid && type != tool_change;
        const Stages::Now its_stages = stages.read();
        commissioning.step({on, homed, running || cycle, its_stages}, functions, dt / services.speed());
        const bool good_needs =
            functions.step(services,
                           {starts, probing, cuts, running, its_stages.silent, commissioning.held_functions(),
                            commissioning.held_stages(), commissioning.tried_functions()}) &&
            good_feed_needs;
        const std::int32_t holding = good_feed_needs ? feed_needs : services.all();
        // Task may take a move for done that has not begun: motion knows better.
        const bool loss = services.any_lost(holding) || ((running || type != 0) && functions.any_withdrawn());
        armed_ = able && (armed_ || (starts && in_order && functions.any_permitted()));
        holds_ = !in_order && (holds_ || !functions.any_busy());
        const Waiting reason = request({probing, cuts, running, homed, loss, type != 0 && speed > 0,
                                        services.lost_of(holding | functions.urgent_services())},
                                       its_stages, dt);
        waiting = reason;
        if (!holds_) ++beats_;
        periods_ = (periods_ + 1) & std::numeric_limits<std::int32_t>::max();
        heartbeat = periods_;
        functions.show_status(services, its_stages, {on, homed, in_order},
                              static_cast<std::uint32_t>(periods_));
        commissioning.permit(beats_, armed_);
        arm = armed_;
        operation = known_key ? static_cast<std::int32_t>(std::round(key)) : 0;
        const std::int32_t silent_function = functions.first_silent();
        const std::int32_t silent = its_stages.silent      ? first_number(its_stages.silent)
                                    : silent_function >= 0 ? 100 + silent_function
                                                           : -1;
        const bool is_silent = silent_.step(silent >= 0, told_after, 0, dt);
        silent_row = is_silent ? silent : -1;
        const Fault found = hal::first<Fault>({{!in_order, Fault::order},
                                               {is_silent, Fault::silent},
                                               {!good_times, Fault::time},
                                               {!good_needs, Fault::services},
                                               {!known_key, Fault::operation}});
        fault = found;
        InterlockSeen seen;
        seen.fault = found != Fault::none;
        seen.settles = reason == Waiting::offsets;
        seen.holds = reason != Waiting::none && reason != Waiting::uncompensated && !seen.settles;
        seen.on = functions.any_on();
        seen.withholds = functions.any_withheld();
        seen.suspended = functions.any_suspended();
        seen.probing = seen.on && !functions.all_enabled();
        seen.machine_on = on;
        seen.homed = homed;
        seen.stage_fault = its_stages.fault != 0;
        seen.stage_lacks = (its_stages.uncompensated & ~its_stages.ramping) != 0;
        seen.stage_limited = its_stages.limited != 0;
        status = status_of(seen);
    }

private:
    static constexpr std::int32_t rapid = 1, tool_change = 4, probe = 5;  // motion-type
    static constexpr double abort_time = 0.1;                             // s
    static constexpr double told_after = 1;                               // s, of a row that is not heard
    static constexpr int answer_in = 3;  // periods in which a function or a stage reports its ramp

    struct Delays {
        double uncompensated, probing_refused, feed_held;  // s

        bool valid() const noexcept {
            const auto possible = [](double time) { return time >= 0 && time <= Services::longest; };
            return possible(uncompensated) && possible(probing_refused) && possible(feed_held);
        }
    };

    struct State {
        bool probing, cuts, running, homed, loss, moving;
        std::int32_t lost_services;  // of those that hold the feed
    };

    // Returns what the machine waits for.
    Waiting request(const State& state, const Stages::Now& its, double dt) noexcept {
        const auto& [probing, cuts, running, homed, loss, moving, lost_services] = state;
        const bool ramps = its.ramping != 0 || functions.any_ramping();
        const std::int32_t lacking = its.uncompensated ? first_number(its.uncompensated) : -1;
        if (functions.changed() || armed_ != was_armed_) announced_ = answer_in;
        was_armed_ = armed_;
        returns_ = (returns_ || functions.any_left()) && running && (ramps || announced_ > 0);
        const bool settles = functions.any_settling() || (returns_ && cuts);
        const bool refused = its.probing_refused != 0,
                   waits = settles || refused || loss || (probing && ramps);

        ramping = ramps || announced_ > 0;
        if (announced_ > 0) --announced_;
        homing_inhibit = its.in_force != 0;
        feed_inhibit = waits;
        // From rest: a path that is held brakes first.
        const bool defeats = waits && stood_ && moving;
        stood_ = waits && (stood_ || !moving);
        feed_service_lost = loss;
        abort = abort_.step(refused || defeats, 0, abort_time, dt);
        hold_defeated = defeated_.step(defeats, 0, delays_.probing_refused, dt);
        compensated = functions.all_enabled() && homed && lacking < 0 && its.fault == 0 && !holds_;
        const bool lacks = uncompensated_.step(lacking >= 0, delays_.uncompensated, 0, dt);
        uncompensated = lacks;
        uncompensated_stage = lacking;
        const bool was_refused = refused_.step(refused, 0, delays_.probing_refused, dt);
        probing_refused = was_refused;
        const bool held = held_.step(waits, delays_.feed_held, 0, dt);
        feed_held = held;
        return hal::first<Waiting>({{loss && lost_services, waits_for_service(first_number(lost_services))},
                                    {loss, Waiting::renew},
                                    {was_refused, Waiting::probing_refused},
                                    {held, Waiting::long_held},
                                    {waits, Waiting::offsets},
                                    {lacks, Waiting::uncompensated},
                                    {!homed && its.in_force, Waiting::homing}});
    }

    Delays delays_{2, 5, 5};  // the last good ones
    DelayedBit silent_, abort_, defeated_, uncompensated_, refused_, held_;
    hal::ThreadWatch threads_;
    bool stood_ = false;        // the path, since feed-inhibit
    bool holds_ = false;        // all offsets, because the order is wrong
    bool returns_ = false;      // an offset that was switched off in a program
    std::uint32_t beats_ = 0;   // of the permits of stages
    std::int32_t periods_ = 0;  // all
    bool cycle_ = true;         // a cycle that runs already does not start
    bool armed_ = false, was_armed_ = false;
    int announced_ = 0;  // periods in which ramping is true without a ramp
};

hal::Model hal::model() {
    return model_of<Interlock>();
}

}  // namespace plumb
