// SPDX-License-Identifier: GPL-2.0-or-later
// Who may act: services, stages and functions. What interlock knows of a row is a bit of a sum, so that one
// operation does for all rows. In each period:
//
//     Services::step      reads the words of the programs
//     Stages::step        reads the words of the stages
//     Functions::read     reads the words of the functions, and the switches of the operator
// If one of these is new:
//     Functions::step     decides which functions may act
//     Functions::show     gives the reason why a function may not act
// At the end of the period:
//     Functions::permit   writes the permits
//
// A function needs services, and acts on stages. A service that it needs and that stops turns it off: at once
// if the service is urgent, else as soon as the function is not busy. A service that returns turns nothing
// on: a cycle start or the switch renews the function.
#pragma once

#include "hal/bus.hpp"
#include "hal/clock_speed.hpp"
#include "hal/component.hpp"
#include "hal/service.hpp"
#include "hal/stage_word.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace plumb {

using Sum = std::uint32_t;  // 1 for number 0, 2 for number 1, 4 for number 2, ...

constexpr Sum all_of(std::size_t number) noexcept {
    return (Sum{1} << number) - 1;
}
constexpr bool has(Sum sum, std::size_t number) noexcept {
    return (sum >> number & 1) != 0;
}
// The number of the first one; 31 without one.
constexpr std::int32_t first_number(Sum sum) noexcept {
    return sum != 0 ? __builtin_ctz(sum) : 31;
}

// Keeps a value; whether it is another one than before.
template <class T>
bool replaces(T& kept, T given) noexcept {
    const bool news = kept != given;
    kept = given;
    return news;
}

// The machine in one period.
struct Machine {
    bool on = false, homed = false, in_order = false;  // the functions of its threads
    bool cycle = true, starts = false;                 // runs, and one that runs already does not start
    bool program = false, cuts = false;                // runs; and the tool is not clear
    bool moves = false, probes = false;                // motion, of any kind
    bool travels = false;                              // it moves, and has a speed

    bool operator!=(const Machine& other) const noexcept {
        return std::memcmp(this, &other, sizeof other) != 0;
    }
};

// By commissioning: functions and stages, and functions that it would hold but for a trial.
struct Held {
    Sum functions, stages, tried;

    bool operator!=(const Held& other) const noexcept {
        return functions != other.functions || stages != other.stages || tried != other.tried;
    }
};

// The words that one kind of party says, a row each.
class Words : hal::Group {
public:
    // dead: periods without a beat.
    Words(hal::Owner owner, std::size_t number, hal::Party who, int dead, const std::string& stem,
          const std::string& doc)
        : Group(owner), pins_{this, number, stem, 0U, doc} {
        for (std::size_t i = 0; i < number; ++i)
            rows_.push_back({{who, hal::Direction::to_interlock, static_cast<std::uint32_t>(i), dead}, 0, 0});
    }

    // Whether anything is new but beats. A row that is silent keeps the content that it said last.
    bool step() noexcept {
        bool news = false;
        beats_ = 0;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            Row& its = rows_[i];
            const std::uint32_t word = pins_[i];
            const bool same = word == its.word;
            if (same && its.stands) continue;
            its.word = word;
            its.heard.step(word);
            its.stands = same && its.heard.missed();
            beats_ |= Sum{its.heard.beats()} << i;
            const std::uint32_t state = its.heard.content() | Sum{its.heard.alive()} << alive |
                                        Sum{its.heard.heard()} << ever | Sum{its.heard.missed()} << missing |
                                        Sum{word == 0} << empty;
            if (state == its.state) continue;
            its.state = state;
            news = true;
            for (int bit = 0; bit < columns; ++bit)
                sums_[bit] = (sums_[bit] & ~(Sum{1} << i)) | (state >> bit & 1) << i;
        }
        return news;
    }

    std::size_t number() const noexcept { return rows_.size(); }
    Sum said(int bit) const noexcept { return sums_[bit]; }                   // bit of the content
    Sum beats() const noexcept { return beats_; }                             // in this period
    Sum silent() const noexcept { return ~sums_[alive] & all_of(number()); }  // for `dead` periods
    Sum missed() const noexcept { return sums_[missing]; }                    // for twice as long
    Sum unheard() const noexcept { return ~sums_[ever]; }
    Sum blank() const noexcept { return sums_[empty]; }  // 0: nothing is netted

private:
    enum { alive = hal::BusWord::content_bits, ever, missing, empty, columns };

    struct Row {
        hal::BusListener heard;
        std::uint32_t word, state;  // state: the content, and a bit of each other column
        bool stands = false;        // with the same word for so long that nothing follows
    };

    hal::Row<hal::In<std::uint32_t>> pins_;
    std::vector<Row> rows_;
    Sum sums_[columns]{}, beats_ = 0;
};

inline void show(hal::Row<hal::Out<bool>>& pins, std::size_t number, Sum sum) noexcept {
    for (std::size_t i = 0; i < number; ++i) pins[i] = has(sum, i);
}

// The programs beside realtime that functions need.
struct Services : hal::Group {
    static constexpr std::size_t most = hal::services;
    static constexpr hal::Range times{0, 3600}, speeds{0.01, 1000};

    Services(hal::Owner owner, std::size_t number) : Group(owner), number_(number), its_(number) {
        static constexpr hal::ServiceSentences sentences{"A service is lost: ", " does not answer. "};
        for (std::int32_t i = 0; i < static_cast<std::int32_t>(number); ++i) {
            const auto its = static_cast<hal::Service>(i);
            if (its == hal::Service::task || its == hal::Service::io) continue;  // waiting-code names them
            const char* const effect =
                its == hal::Service::growth_log
                    ? "The growth test is not written. Start growth_log again by its line in man growth_log, "
                      "or LinuxCNC and then resume.ngc."
                    : "Functions that need it go off when the program ends. Start LinuxCNC again.";
            hal::Told(this, "service-lost-" + std::to_string(i), hal::Tell::error,
                      std::string(sentences[i]) + effect);
        }
    }

    const std::size_t number_;

    Words state{this, number_,         hal::Party::program,
                1000, "service-state", "What the program says: from its state."};
    hal::Row<hal::In<double>> timeout{
        this, number_, "service-timeout",
        0,    "s",     "Maximum time without a beat in the state; 0: the beat is not watched.",
        times};
    hal::In<double> clock_speed{this,
                                "clock-speed",
                                hal::clock_speed(),
                                "1",
                                "Factor of each service-timeout. plumb run sets it to its speed, because a "
                                "service follows the computer's clock.",
                                speeds};
    hal::Row<hal::Out<bool>> show_ok{this, number_, "service-ok", "The service runs and is ready."};
    hal::Row<hal::Out<bool>> show_lost{this, number_, "service-lost", "The beat has stopped."};

    Sum ok = 0, lost = 0;
    double speed = 1;  // of the clock, against the computer's
    bool good = true;  // else clock-speed or a timeout is out of range; its last good value stays

    // Whether anything is new.
    bool step(double dt) noexcept {
        const Sum was_ok = ok, was_lost = lost;
        const bool was_good = good;
        const double given_speed = clock_speed;
        good = clock_speed.accepts(given_speed);
        if (good) speed = given_speed;
        const double by_computer = dt / speed;
        state.step();
        Sum lives = 0;
        lost = 0;
        for (std::size_t i = 0; i < number_; ++i) {
            Pulse& its = its_[i];
            const double given = timeout[i];
            const bool possible = timeout[i].accepts(given), beats = has(state.beats(), i);
            good &= possible;
            if (possible) its.timeout = given;
            const bool watched = its.timeout > 0;
            its.beaten = watched && (its.beaten || beats);
            its.silence = beats || !watched ? 0 : its.silence + by_computer;
            const bool stopped = watched && its.silence > its.timeout;
            lost |= Sum{stopped} << i;
            lives |= Sum{!watched || (its.beaten && !stopped)} << i;
        }
        ok = lives & ((state.said(ready) & ~state.unheard()) | (state.blank() & state.unheard()));
        return ok != was_ok || lost != was_lost || good != was_good;
    }

    void show() noexcept {
        plumb::show(show_ok, number_, ok);
        plumb::show(show_lost, number_, lost);
    }

    Sum all() const noexcept { return all_of(number_); }
    bool exist(Sum these) const noexcept { return (these & ~all()) == 0; }

private:
    enum { ready };  // bit of hal::ProgramReport

    struct Pulse {
        double timeout = 0, silence = 0;  // s of the computer's clock
        bool beaten = false;
    };

    std::vector<Pulse> its_;
};

// The stages that bring offsets into the axes.
struct Stages : hal::Group {
    static constexpr std::size_t most = 17;  // a joint each, and an axis

    Stages(hal::Owner owner, std::size_t number)
        : Group(owner), state{this, number,        hal::Party::stage,
                              10,   "stage-state", "What the stage does: from its state."} {}

    Words state;
    Sum in_force = 0, ramping = 0, uncompensated = 0, probing_refused = 0, fault = 0, limited = 0;

    // Whether anything is new. A stage that is silent has a fault.
    bool step() noexcept {
        if (!state.step()) return false;
        Sum* const of_bit[]{&in_force, &ramping, &uncompensated, &probing_refused, &fault, &limited};
        for (int bit = 0; bit < hal::StageState::bits; ++bit) *of_bit[bit] = state.said(bit);
        fault |= state.missed();
        return true;
    }
};

// What holds for which functions: a sum of functions each.
struct FunctionSums {
    Sum on = 0, suspended = 0;                    // by the operator, by the program
    Sum leaves = 0;                               // goes off when the tool is clear
    Sum served = 0, lost = 0;                     // by all that it needs; since then
    Sum lost_service = 0, late_service = 0;       // of those that it needs: stopped; not ready
    Sum permitted = 0;                            // by all
    Sum granted = 0, enabled = 0;                 // permitted, or busy since; and not suspended
    Sum withdrawn = 0;                            // by a loss, and not renewed
    Sum held = 0, held_stages = 0, on_trial = 0;  // by commissioning
    Sum silent = 0, silent_stages = 0;            // its state does not come, or that of a stage of it
    Sum stages_with_fault = 0, stages_that_lack = 0, stages_limited = 0;
    Sum at_point_r = 0;  // another function strokes an axis, and its position lacks the stroke
    Sum busy = 0, settling = 0, ramping = 0;
    Sum left = 0, changed = 0;                          // in this period: by the operator; the enable
    Sum machine_on = ~0U, homed = ~0U, in_order = ~0U;  // all or none
};

// Why a function does not act, or which of its axes does not follow. Services: those that it needs.
constexpr hal::Common reason(const FunctionSums& sums, std::size_t i, Sum lost_services, Sum late_services) {
    using hal::Common, hal::of_service;
    const auto its = [i](Sum sum) { return has(sum, i); };
    const std::int32_t missing = first_number(lost_services ? lost_services : late_services);
    const bool misses = (lost_services | late_services) != 0;
    if (!its(sums.on)) return Common::off;
    if (its(sums.leaves)) return Common::leaves;
    if (its(sums.held)) return its(sums.held_stages) ? Common::stage_uncommissioned : Common::uncommissioned;
    if (misses && its(sums.lost & sums.enabled)) return of_service(Common::ending, missing);
    if (misses) return of_service(lost_services ? Common::lost : Common::late, missing);
    if (its(sums.lost)) return Common::renew;
    if (!its(sums.in_order)) return Common::order;
    if (its(sums.silent)) return Common::unpermitted;
    if (its(sums.silent_stages & ~sums.enabled)) return Common::stage_fault;
    if (its(sums.suspended & ~sums.enabled)) return Common::suspended;
    if (!its(sums.machine_on)) return Common::machine_off;
    if (!its(sums.homed)) return Common::not_homed;
    if (!its(sums.enabled)) return Common::probing;
    if (its(sums.stages_with_fault)) return Common::stage_fault;
    if (its(sums.stages_that_lack)) return Common::stage_lacks;
    if (its(sums.at_point_r)) return Common::at_point_r;
    return its(sums.stages_limited) ? Common::stage_limited : Common::none;
}

// The functions that compensate.
struct Functions : hal::Group {
    static constexpr std::size_t most = 16;
    static constexpr Sum first_four = 15;  // services: the default of when there were no more

    // `stages`, `services`: their numbers.
    Functions(hal::Owner owner, std::size_t number, std::size_t stages, std::size_t services)
        : Group(owner),
          all_stages_(static_cast<std::int32_t>(all_of(stages))),
          first_services_(static_cast<std::int32_t>(first_four & all_of(services))),
          number_(number),
          its_(number),
          unseen_(number) {}

    const std::int32_t all_stages_, first_services_;  // as sums
    const std::size_t number_;

    hal::Row<hal::In<bool>> is_on{this, number_, "function-switch", false,
                                  "The operator has switched the function on."};
    hal::Row<hal::In<bool>> is_off{this, number_, "function-off", false,
                                   "Off, whatever function-switch says: for a screen, where a signal drives "
                                   "function-switch."};
    hal::Row<hal::In<bool>> suspend{this, number_, "function-suspend", false,
                                    "The part program suspends the function."};
    hal::Row<hal::In<std::int32_t>> needs{
        this, number_, "function-services", first_services_,
        "Services that the function needs: the sum of 1 for service 0, 2 for service 1, 4 for service 2, ... "
        "128 for service 7."};
    hal::Row<hal::In<std::int32_t>> urgent{
        this, number_, "function-urgent", 0,
        "Services whose loss turns the function off at once, as a sum; the "
        "function must need them."};
    hal::Row<hal::In<std::int32_t>> its_stages{
        this, number_, "function-stages", all_stages_,
        "Stages that apply the offset of the function to an axis, as a sum like function-services."};
    Words state{this,
                number_,
                hal::Party::function,
                100,  // its thread may be a slower one
                "function-state",
                "What the function does: from its state."};

    hal::Row<hal::Out<std::uint32_t>> word{
        this, number_, "function-permit",
        "Permit of the function: net it to the pin permit of the function."};
    hal::Row<hal::Out<bool>> enable{this, number_, "function-enable", "The permit enables the function."};
    hal::Row<hal::Out<bool>> lost{
        this, number_, "function-lost",
        "A service was lost. The function is off, or goes off when it is no longer busy. When the "
        "service is ok again, turn the switch off and on, or start a cycle."};
    hal::Row<hal::Code<hal::Common>> status{
        this, number_, "function-status",
        "Reason why the function does not act, which its permit gives it; 0: "
        "none."};

    // Reads all inputs; whether anything is new.
    bool read() noexcept {
        bool news = state.step();
        const auto take = [&news](auto& held, auto given) { news |= replaces(held, given); };
        Sum switched = 0, suspended = 0;
        for (std::size_t i = 0; i < number_; ++i) {
            switched |= Sum{is_on[i] && !is_off[i]} << i;
            suspended |= Sum{suspend[i]} << i;
            const std::int32_t named = its_stages[i];
            take(its_[i].services, static_cast<Sum>(std::int32_t{needs[i]}));
            take(its_[i].urgent, static_cast<Sum>(std::int32_t{urgent[i]}));
            take(its_[i].stages, static_cast<Sum>(named >= 0 ? named : all_stages_));
            take(its_[i].unseen, unseen_[i].load(std::memory_order_relaxed));
        }
        take(switched_, switched);
        take(suspended_, suspended);
        return news;
    }

    // False where one needs services that there are not; it needs all of them then.
    bool step(const Services& services, const Stages& stages, const Machine& machine,
              const Held& by_commissioning) noexcept {
        const FunctionSums last = sums_;
        FunctionSums next;
        Sum urgent_now = 0, is_urgent = 0, unknown = 0;
        urgent_services_ = 0;
        for (std::size_t i = 0; i < number_; ++i) {
            const auto mark = [i](Sum& sum, bool when) { sum |= Sum{when} << i; };
            const Sum at_once = its_[i].urgent, on_stages = its_[i].stages;
            const bool exist = services.exist(its_[i].services | at_once);
            const Sum needed = exist ? its_[i].services : services.all();
            its_[i].needed = needed;
            urgent_services_ |= exist ? at_once : services.all();
            mark(unknown, !exist);
            mark(is_urgent, at_once != 0);
            mark(urgent_now, !exist || (at_once & services.lost) != 0);
            mark(next.served, (needed & ~services.ok) == 0);
            mark(next.lost_service, (needed & services.lost) != 0);
            mark(next.late_service, (needed & ~services.ok & ~services.lost) != 0);
            mark(next.held_stages, (on_stages & by_commissioning.stages) != 0);
            mark(next.silent_stages, (on_stages & stages.state.silent()) != 0);
            mark(next.stages_with_fault, (on_stages & stages.fault) != 0);
            mark(next.stages_that_lack, (on_stages & stages.uncompensated & ~stages.ramping) != 0);
            mark(next.stages_limited, (on_stages & stages.limited) != 0);
            mark(next.at_point_r, (its_[i].unseen & state.said(busy)) != 0);
        }
        const auto all_if = [](bool when) { return when ? ~Sum{0} : 0; };
        next.busy = state.said(busy) | (state.said(in_programs) & all_if(machine.program));
        next.settling = state.said(settling);
        next.ramping = state.said(ramping);
        next.silent = state.silent();
        next.suspended = suspended_;
        next.machine_on = all_if(machine.on);
        next.homed = all_if(machine.homed);
        next.in_order = all_if(machine.in_order);
        next.on_trial = by_commissioning.tried;

        next.leaves =
            ~switched_ & last.on & last.enabled & all_if(machine.cuts) & ~is_urgent & ~last.on_trial;
        next.on = switched_ | next.leaves;
        next.left = last.on & ~next.on & last.enabled;
        const Sum renewed = all_if(machine.starts) | (next.on & ~last.on) | last.granted;
        next.lost = (last.lost & ~(next.served & renewed)) | (last.served & ~next.served);
        next.withdrawn = next.lost & (last.withdrawn | (last.granted & urgent_now));
        const Sum held = by_commissioning.functions | next.held_stages;
        next.permitted = next.on & next.served & ~next.lost & ~held & ~next.silent & ~next.silent_stages;
        const Sum stays = last.granted & next.busy & ~urgent_now & ~last.on_trial;
        next.granted = next.permitted | (next.on & stays);
        next.held = held & ~next.granted;
        next.busy &= last.granted;
        next.enabled = machine.probes ? last.enabled : next.granted & ~next.suspended;
        next.changed = next.enabled ^ last.enabled;
        sums_ = next;
        return unknown == 0;
    }

    // In background(): the functions that stroke an axis which `function` has at point R.
    void see(std::size_t function, Sum unseen) noexcept {
        unseen_[function].store(unseen, std::memory_order_relaxed);
    }

    // After step(): why the others do not act, and the contents of the permits.
    void show(const Services& services) noexcept {
        plumb::show(enable, number_, sums_.enabled);
        plumb::show(lost, number_, sums_.lost);
        for (std::size_t i = 0; i < number_; ++i) {
            Its& its = its_[i];
            const Sum missing = its.needed & ~services.ok;
            const hal::Common why = reason(sums_, i, its.needed & services.lost, missing & ~services.lost);
            its.word = hal::BusWord::of(hal::Party::function, hal::Direction::from_interlock,
                                        static_cast<std::uint32_t>(i), 0,
                                        hal::FunctionPermit{has(sums_.enabled, i), why}.content());
            status[i] = why;
        }
    }

    // The words, in each period.
    void permit(std::uint32_t beat) noexcept {
        for (std::size_t i = 0; i < number_; ++i) word[i] = hal::BusWord::beating(its_[i].word, beat);
    }

    const FunctionSums& now() const noexcept { return sums_; }
    bool all_act() const noexcept { return sums_.on != 0 && sums_.enabled == sums_.on; }
    Sum stages_of(std::size_t function) const noexcept { return its_[function].stages; }
    Sum urgent_services() const noexcept { return urgent_services_; }  // whose loss holds the feed

private:
    enum { busy, settling, ramping, in_programs };  // bits of hal::FunctionState

    struct Its {
        Sum services = 0, urgent = 0, stages = 0;  // as the pins; stages: on which it acts
        Sum unseen = 0;                            // functions, see()
        Sum needed = 0;                            // services that there are
        std::uint32_t word = 0;                    // the permit, of beat 0
    };

    FunctionSums sums_;
    std::vector<Its> its_;
    std::vector<std::atomic<Sum>> unseen_;
    Sum switched_ = 0, suspended_ = 0, urgent_services_ = 0;
};

}  // namespace plumb
