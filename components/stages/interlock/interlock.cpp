// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/delayed_bit.hpp"
#include "components/stages/interlock/commissioning.hpp"
#include "components/stages/interlock/functions.hpp"
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
                   "row (services=N); it stands for all services.";
        case Fault::order:
            return "A function of Plumb is in a wrong place of its thread, or in none: run plumb doctor "
                   "--running; no cycle is armed, and offsets are held as soon as no function is busy.";
        case Fault::silent:
            return "A stage or a function is not heard: net its state to stage-state or function-state of "
                   "its row, and the permit of that row to it; silent-row gives the row.";
        case Fault::operation: return "The operation-key is invalid or beyond 2147483647; operation is 0.";
        default: return nullptr;
    }
}

// What the machine waits for, as a screen shows it; from service on by the number of the lost service.
enum class Waiting : std::int32_t {
    none,
    renew,
    probing_refused,
    long_held,
    offsets,
    uncompensated,
    homing,
    service
};

constexpr Waiting waits_for_service(std::int32_t number) {
    return static_cast<Waiting>(static_cast<std::int32_t>(Waiting::service) + number);
}

inline constexpr hal::ServiceSentences feed_services_lost{"The feed is held: ",
                                                          " does not answer. Start LinuxCNC again."};

constexpr const char* sentence(Waiting waiting) {
    switch (waiting) {
        case Waiting::renew:
            return "A function is off because a service was lost, and the feed is held. When the service "
                   "answers again, turn the switch of the function off and on.";
        case Waiting::probing_refused: return "Probing is refused: remove the offset first.";
        case Waiting::long_held:
            return "The feed is held for long: an offset or a correction of the tool does not come to rest.";
        case Waiting::offsets:
            return "The next move waits until no offset and no correction of the tool changes.";
        case Waiting::uncompensated: return "An axis lacks its offset until the next cycle begins.";
        case Waiting::homing:
            return "Homing waits: an offset is in force. Remove it, or switch the function off.";
        default: break;
    }
    const std::int32_t number =
        static_cast<std::int32_t>(waiting) - static_cast<std::int32_t>(Waiting::service);
    return number >= 0 && number < hal::services ? feed_services_lost[number] : nullptr;
}

enum class InterlockStatus : std::int32_t {
    permits = hal::first_own,
    holds,
    nothing_on,
    stage_fault,
    withholds,
    settles,
    stage_lacks,
    stage_limited
};

constexpr hal::Said said(InterlockStatus status) {
    using hal::Kind;
    switch (status) {
        case InterlockStatus::permits: return {Kind::good, "All functions that are switched on compensate."};
        case InterlockStatus::holds:
            return {Kind::warn, "The machine waits.", "Remove the cause that is named.", {}, "waiting-code"};
        case InterlockStatus::nothing_on:
            return {Kind::off, "No function is switched on.", "Switch a function on."};
        case InterlockStatus::stage_fault:
            return hal::Said{Kind::bad, "A stage has a fault, and its axis does not follow.",
                             "Look at the faults of the stages."}
                .told(hal::Tell::never);  // the stage tells it
        case InterlockStatus::withholds:
            return {Kind::warn, "A function is switched on, and a service that it needs is missing.",
                    "Look at the page of the function."};
        case InterlockStatus::settles:
            return {Kind::wait, "The next move waits until the axes have their offsets.",
                    "Wait for the end of the move."};
        case InterlockStatus::stage_lacks:
            return {Kind::wait, "An axis lacks its offset.", "It gets it when the next cycle begins."};
        case InterlockStatus::stage_limited:
            return {Kind::warn, "A limit of a stage prevents the full offset of its axis.",
                    "Look at the limits of the stages."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
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
    Commissioning commissioning{this, functions.number_, stages.state.number()};
    hal::In<double> uncompensated_delay{
        this,
        "uncompensated-delay",
        2,
        "s",
        "Time for which an axis lacks its offset before uncompensated is true.",
        Services::times};
    hal::In<double> probing_refused_time{this,
                                         "probing-refused-time",
                                         5,
                                         "s",
                                         "Time for which probing-refused stays true after the refusal.",
                                         Services::times};
    hal::In<double> feed_held_delay{this,
                                    "feed-held-delay",
                                    5,
                                    "s",
                                    "Time for which the feed is held before feed-held is true.",
                                    Services::times};

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
        "Probing is aborted: its result would contain the offset of an axis. Remove the offset, "
        "or use o<probe_work> call."};
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
        commissioning.work(functions);
    }

    void update(double dt) noexcept {
        if (read(dt)) settling_ = settle_in;
        if (settling_ > 0) {
            judge(dt);
            settling_ = waits() ? settle_in : settling_ - 1;
        }
        if (!holds_) ++beats_;
        periods_ = (periods_ + 1) & std::numeric_limits<std::int32_t>::max();
        heartbeat = periods_;
        functions.permit(static_cast<std::uint32_t>(periods_));
        commissioning.permit(stages, beats_, armed_);
    }

private:
    struct Delays {
        double uncompensated, probing_refused, feed_held;  // s
    };

    static constexpr std::int32_t rapid = 1, tool_change = 4, probe = 5;  // motion-type
    static constexpr double abort_time = 0.1;                             // s
    static constexpr double told_after = 1;                               // s, of a row that is not heard
    static constexpr int answer_in = 3;  // periods in which a function or a stage reports its ramp
    static constexpr int settle_in = 4;  // periods, until all follows from what is new

    // Whether anything is new but beats.
    bool read(double dt) noexcept {
        const std::int32_t type = motion_type;
        const bool on = motion_enabled, homed = all_homed, cycle = cycle_running, program = program_running;
        const bool starts = cycle && !machine_.cycle && on && homed,
                   cuts = type != rapid && type != tool_change;
        const Machine machine{
            on,      homed,           threads_.step(dt), cycle,         starts,
            program, program && cuts, type != 0,         type == probe, type != 0 && path_speed > 0};
        bool news = services.step(dt);
        news |= stages.step();
        news |= commissioning.step(machine, stages, functions, dt / services.speed);
        news |= functions.read();
        news |= replaces(machine_, machine);
        news |= replaces(key_, double{operation_key});
        news |= replaces(feed_services_, static_cast<Sum>(std::int32_t{feed_services}));
        hal::SettingsReader setting;
        const Delays delays{setting(uncompensated_delay), setting(probing_refused_time),
                            setting(feed_held_delay)};
        if (setting.good()) delays_ = delays;
        return replaces(good_delays_, setting.good()) || news;
    }

    // From what was read: who may act, and the requests to LinuxCNC.
    void judge(double dt) noexcept {
        const bool known_key = std::abs(key_) <= std::numeric_limits<std::int32_t>::max();
        const bool good_feed_services = services.exist(feed_services_);
        const bool good_services =
            functions.step(services, stages, machine_, commissioning.now()) && good_feed_services;
        const FunctionSums& its = functions.now();
        armed_ = machine_.cycle && machine_.on && machine_.homed &&
                 (armed_ || (machine_.starts && machine_.in_order && its.permitted != 0));
        holds_ = !machine_.in_order && (holds_ || its.busy == 0);
        const Waiting reason = request(good_feed_services ? feed_services_ : services.all(), dt);
        waiting = reason;
        services.show();
        functions.show(services);
        arm = armed_;
        operation = known_key ? static_cast<std::int32_t>(std::round(key_)) : 0;
        const Sum silent_stages = stages.state.silent(), silent_functions = its.silent & its.on;
        const bool is_silent = silent_.step((silent_stages | silent_functions) != 0, told_after, 0, dt);
        silent_row = !is_silent      ? -1
                     : silent_stages ? first_number(silent_stages)
                                     : 100 + first_number(silent_functions);
        const Fault found = hal::first<Fault>({{!machine_.in_order, Fault::order},
                                               {is_silent, Fault::silent},
                                               {!services.good || !good_delays_, Fault::time},
                                               {!good_services, Fault::services},
                                               {!known_key, Fault::operation}});
        fault = found;
        using S = InterlockStatus;
        const bool settles = reason == Waiting::offsets,
                   holds = reason != Waiting::none && reason != Waiting::uncompensated && !settles;
        status = hal::first<S>({{found != Fault::none, hal::common<S>(hal::Common::fault)},
                                {holds, S::holds},
                                {its.on == 0, S::nothing_on},
                                {(its.on & ~its.granted) != 0, S::withholds},
                                {!machine_.on, hal::common<S>(hal::Common::machine_off)},
                                {!machine_.homed, hal::common<S>(hal::Common::not_homed)},
                                {stages.fault != 0, S::stage_fault},
                                {(its.granted & its.suspended) != 0, hal::common<S>(hal::Common::suspended)},
                                {!functions.all_act(), hal::common<S>(hal::Common::probing)},
                                {settles, S::settles},
                                {(stages.uncompensated & ~stages.ramping) != 0, S::stage_lacks},
                                {stages.limited != 0, S::stage_limited},
                                {true, S::permits}});
    }

    // Returns what the machine waits for. The loss of `feed_needs` holds the feed.
    Waiting request(Sum feed_needs, double dt) noexcept {
        const FunctionSums& its = functions.now();
        const Sum lost = services.lost & feed_needs;
        // Task may take a move for done that has not begun: motion knows better.
        const bool loss = lost != 0 || ((machine_.program || machine_.moves) && its.withdrawn != 0);
        const Sum lost_services = lost | (services.lost & functions.urgent_services());
        const bool ramps = (stages.ramping | its.ramping) != 0;
        const bool lacking = stages.uncompensated != 0;
        if (its.changed != 0 || armed_ != was_armed_) announced_ = answer_in;
        was_armed_ = armed_;
        returns_ = (returns_ || its.left != 0) && machine_.program && (ramps || announced_ > 0);
        const bool settles = its.settling != 0 || (returns_ && machine_.cuts);
        const bool refused = stages.probing_refused != 0,
                   waits = settles || refused || loss || (machine_.probes && ramps);

        ramping = ramps || announced_ > 0;
        if (announced_ > 0) --announced_;
        homing_inhibit = stages.in_force != 0;
        feed_inhibit = waits;
        // From rest: a path that is held brakes first.
        const bool defeats = waits && stood_ && machine_.travels;
        stood_ = waits && (stood_ || !machine_.travels);
        feed_service_lost = loss;
        abort = abort_.step(refused || defeats, 0, abort_time, dt);
        hold_defeated = defeated_.step(defeats, 0, delays_.probing_refused, dt);
        compensated = functions.all_act() && machine_.homed && !lacking && stages.fault == 0 && !holds_;
        const bool lacks = uncompensated_.step(lacking, delays_.uncompensated, 0, dt);
        uncompensated = lacks;
        uncompensated_stage = lacking ? first_number(stages.uncompensated) : -1;
        const bool was_refused = refused_.step(refused, 0, delays_.probing_refused, dt);
        probing_refused = was_refused;
        const bool held = held_.step(waits, delays_.feed_held, 0, dt);
        feed_held = held;
        return hal::first<Waiting>(
            {{loss && lost_services != 0, waits_for_service(first_number(lost_services))},
             {loss, Waiting::renew},
             {was_refused, Waiting::probing_refused},
             {held, Waiting::long_held},
             {waits, Waiting::offsets},
             {lacks, Waiting::uncompensated},
             {!machine_.homed && stages.in_force != 0, Waiting::homing}});
    }

    // Whether a delay runs, which ends by time.
    bool waits() const noexcept {
        return announced_ > 0 || silent_.waits() || abort_.waits() || defeated_.waits() ||
               uncompensated_.waits() || refused_.waits() || held_.waits();
    }

    Machine machine_;
    double key_ = 0;
    Sum feed_services_ = 0;
    Delays delays_{2, 5, 5};  // the last good ones
    bool good_delays_ = true;
    DelayedBit silent_, abort_, defeated_, uncompensated_, refused_, held_;
    hal::ThreadWatch threads_;
    bool stood_ = false;        // the path, since feed-inhibit
    bool holds_ = false;        // all offsets, because the order is wrong
    bool returns_ = false;      // an offset that was switched off in a program
    std::uint32_t beats_ = 0;   // of the permits of stages
    std::int32_t periods_ = 0;  // all
    bool armed_ = false, was_armed_ = false;
    int announced_ = 0;         // periods in which ramping is true without a ramp
    int settling_ = settle_in;  // periods left
};

hal::Model hal::model() {
    return model_of<Interlock>();
}

}  // namespace plumb
