// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_report.hpp"
#include "components/compensation/thermal_displacement/contact_settings.hpp"
#include "components/compensation/thermal_displacement/displacement_status.hpp"
#include "components/compensation/thermal_displacement/growth_settings.hpp"
#include "components/compensation/thermal_displacement/reference_conditions.hpp"
#include "components/compensation/thermal_displacement/reference_row.hpp"
#include "components/compensation/thermal_displacement/shift_question.hpp"
#include "components/compensation/thermal_displacement/trust_report.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/slew_limit.hpp"
#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"
#include "pages/thermal_displacement.page.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    load,
    position,
    spindle_speed,
    applied_offset,
    approach,
    settings,
    lost_track,
};

constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::load: return "The load is invalid.";
        case Fault::position: return "The position or velocity of Z is invalid.";
        case Fault::spindle_speed: return "The spindle speed is invalid.";
        case Fault::applied_offset: return "The applied offset is invalid.";
        case Fault::approach: return "The feed override or start height is invalid.";
        case Fault::settings: return "The settings are out of range; the last good ones are used.";
        case Fault::lost_track:
            return "No contact was accepted in three cycles. Check the machine and learn again.";
        default: return nullptr;
    }
}

struct ThermalDisplacement final : hal::Component {
    static constexpr hal::About about{
        "thermal_displacement",
        "compensates thermal growth along Z, measured by the contacts of the tools with the work", page};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> enable{this, "enable", false, "Compare contacts and apply the offset."};
    hal::In<bool> learn{this, "learn", false, "Learn from the next cycle."};
    hal::In<bool> dry_run{this, "dry-run", false, "Compare and count, but never apply."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<bool> cycle_complete{this, "cycle-complete", false, "The cycle that ends was not aborted."};
    hal::In<double> load{this, "load", 0, "%", "Load of the spindle or Z motor, of its rating."};
    hal::In<bool> load_valid{this, "load-valid", true, "The sensor reports that load is valid."};
    hal::In<double> spindle_speed_cmd{this, "spindle-speed-cmd", 0, "rpm", "Commanded speed of the spindle."};
    hal::In<double> z_position{this, "z-position", 0, "mu", "Z by its encoder, offset included."};
    hal::In<double> z_velocity_cmd{this, "z-velocity-cmd", 0, "mu/s", "Speed of Z, negative to the work."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 2, "As in LinuxCNC: 1 rapid, 2 feed."};
    hal::In<double> feed_override{this, "feed-override", 1, "1", "Feed override in force."};
    hal::In<std::int32_t> tool_number{this, "tool-number", 0, "Tool in the spindle."};
    hal::In<std::int32_t> operation{this, "operation", 0, "Key of the operation; 0 for none."};
    hal::In<double> z_motor_offset{this, "z-motor-offset", 0, "mu",
                                   "Offset of the motor that z-position contains, found by homing."};
    hal::In<double> start_height{this, "start-height", 0, "mu",
                                 "Height of the joint at which the clock of this operation starts."};
    hal::In<bool> clock_start{this, "clock-start", false,
                              "With clock-from-program: a rising edge starts the clock again."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that the stage adds to the Z origin."};

    ReferenceConditions conditions{this};
    ContactSettings contact_settings{this};
    GrowthSettings growth{this};
    hal::In<bool> verify{
        this, "verify", false,
        "Displace the offset by verify-step in the next cycle, never for a part that counts."};
    hal::In<double> verify_step{
        this, "verify-step", 0, "mu",
        "Displacement that shows which contacts are of the work, at most gate-cap; 0: none."};
    static constexpr hal::Range lengths{0, 1000}, times{0, 1000}, rates{0, 1};
    hal::In<bool> constant_in_part{
        this, "constant-in-part", false,
        "The offset changes only at the start of a cycle: an even part, whose error changes."};
    hal::In<double> tolerance{this, "tolerance", 0.002, "mu", "Smallest change that is applied.", lengths};
    hal::In<double> time_tolerance{
        this, "time-tolerance", 0, "s", "Smallest change that is applied by the time method, as a time.",
        times};
    hal::In<double> max_offset{this, "max-offset", 0.15, "mu", "Largest offset either way.", lengths};
    hal::In<double> max_rate{this, "max-rate", 0.01, "mu/s", "Fastest change of the offset.", rates};

    hal::Out<double> z_offset{this, "z-offset", "mu", "Offset that a stage adds to the Z origin."};
    hal::Out<bool> limited{this, "limited", "The growth exceeds max-offset."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<DisplacementStatus> status{this};
    ContactReport report{this};
    TrustReport trust{this};
    ShiftQuestion shift{this};
    hal::Records records{this};
    ReferenceRow row{this};

    hal::Offset moves{
        this,
        hal::MovingPin(z_offset)
            .bound(max_offset)
            .rate(max_rate)
            .accelerated_by("The stage limits its acceleration; axis_offset(9) leaves that to LinuxCNC.")
            .limited(limited)};

    hal::Function run{this, "update", &ThermalDisplacement::update, hal::Place::source,
                      "After all its inputs."};

    void prepare() override { settings_ = settings(); }

    void update(double dt) noexcept {
        Sample now = GrowthByContact::judged(sample());
        const Lost lost = now.lost;
        if (periods_++ % between_settings == 0) take_settings();
        const bool at_zero = slew_.value() == 0 && std::abs(now.applied_offset) <= settings_.tolerance;
        const bool dry = dry_run;
        const bool applying = now.enable && !dry && !now.learn && measured_.applicable();
        const bool starts = watch_cycle(now.cycle_running, now.load_lost, applying);
        now.step = step_;

        const auto event = measured_.step(now, at_zero, settings_.contact, dt);
        if (conditions.acknowledges()) {
            measured_.acknowledge();
            shown_event_ = true;
        }
        shift.answer(measured_);
        const double asked = ask(applying, event, starts || !constant_in_part);
        const double offset = bounded(asked, settings_.max_offset);
        const bool frozen = applying && (now.load_lost ? !load_gone_ : lost != Lost::nothing);
        const bool may_move = now.cycle_running || !applying;  // not while an operator may touch the machine
        if (may_move && !measured_.in_work() && !frozen) slew_.step(offset, settings_.max_rate, dt);

        z_offset = slew_.value();
        limited = offset != asked;
        const Fault its_fault = hal::first<Fault>({{lost == Lost::load, Fault::load},
                                                   {lost == Lost::position, Fault::position},
                                                   {lost == Lost::speed, Fault::spindle_speed},
                                                   {lost == Lost::offset, Fault::applied_offset},
                                                   {lost == Lost::approach, Fault::approach},
                                                   {bad_settings_, Fault::settings},
                                                   {measured_.tally().lost_track(), Fault::lost_track}});
        fault = its_fault;
        if (measured_.due() || shown_event_) show(event, applying, now.setup);
        shown_event_ = event != GrowthByContact::Event::none;
        walk();
        show_status(now, its_fault != Fault::none, dry, applying, offset != asked);
    }

private:
    using Sample = GrowthByContact::Sample;
    using Lost = GrowthByContact::Lost;

    struct Settings {
        GrowthByContact::Settings contact;
        double tolerance = 0;       // mu
        double verify_step = 0;     // mu
        double time_tolerance = 0;  // s
        double max_offset = 0;      // mu
        double max_rate = 0;        // mu/s
        bool in_range = false;

        bool valid() const noexcept {
            return in_range && contact.valid() && std::abs(verify_step) <= contact.growth.gate.cap;
        }
    };

    void take_settings() noexcept {
        const Settings wanted = settings();
        bad_settings_ = !wanted.valid();
        if (!bad_settings_) settings_ = wanted;
    }

    void show(GrowthByContact::Event event, bool applying, const MachiningSetup& setup) noexcept {
        const double grown = measured_.known() ? measured_.estimate(settings_.contact) : 0;
        growth.show(grown, measured_.known() ? measured_.estimate_sigma() : 0);
        trust.show(measured_, grown, slew_.value(), applying);
        report.show(measured_, event, setup, settings_.contact);
        shift.show(measured_, settings_.contact.growth, applying);
    }

    Settings settings() noexcept {
        Settings s;
        hal::SettingsReader setting;
        s.contact = contact_settings.read();
        growth.read(s.contact.growth);
        s.tolerance = setting(tolerance);
        s.verify_step = verify_step;
        s.time_tolerance = setting(time_tolerance);
        s.max_offset = setting(max_offset);
        s.max_rate = setting(max_rate);
        s.in_range = setting.good();
        return s;
    }

    Sample sample() noexcept {
        Sample s;
        s.enable = enable;
        s.learn = learn;
        s.cycle_running = cycle_running;
        s.cycle_complete = cycle_complete;
        s.setup = conditions.setup();
        s.motion = motion_type;
        s.tool = tool_number;
        s.operation = operation;
        s.load = load;
        s.load_valid = load_valid;
        s.speed = spindle_speed_cmd;
        s.z = z_position;
        s.velocity = z_velocity_cmd;
        s.feed_override = feed_override;
        s.motor_offset = z_motor_offset;
        s.start_height = start_height;
        s.clock_start = clock_start;
        s.applied_offset = applied_offset;
        s.temperature = conditions.temperature;
        s.date = conditions.date;
        s.temperature_valid = growth.temperature_usable();
        return s;
    }

    void show_status(const Sample& now, bool has_fault, bool dry, bool applying, bool bounded) noexcept {
        DisplacementSeen seen;
        seen.fault = has_fault;
        seen.enabled = now.enable;
        seen.load_valid = !now.load_lost;
        seen.learning = measured_.cycle().learning();
        seen.will_learn = now.learn;
        seen.learning_failed = measured_.tally().learning_fault() != LearningFault{};
        seen.refused = measured_.refusal().reason() != Refusal::none;
        seen.has_reference = measured_.cycle().references().made_with(now.setup);
        seen.has_rows = measured_.cycle().references().size() > 0;
        seen.cycle_running = now.cycle_running;
        seen.dry_run = dry;
        seen.doubted = measured_.known() && applying && measured_.authority().doubt() != Doubt::none;
        seen.asks = applying && measured_.from_contacts().shift(settings_.contact.growth) != Shift::none;
        seen.known = measured_.known();
        seen.bounded = bounded;
        seen.interlock = status.of_interlock();
        status = status_of(seen);
    }

    // A load that was lost before the cycle began holds nothing up: its authority decides.
    bool watch_cycle(bool running, bool load_lost, bool applying) noexcept {
        const bool starts = cycle_.rises(running);
        if (starts) {
            load_gone_ = load_lost;
            step_ = verify && applying ? settings_.verify_step : 0;
        }
        if (!load_lost) load_gone_ = false;
        return starts;
    }

    // The offset that is asked for, mu.
    double ask(bool applying, GrowthByContact::Event event, bool may_change) noexcept {
        const double estimate = measured_.authority().offset();
        following_ =
            applying && measured_.known() && (following_ || event == GrowthByContact::Event::accepted);
        if (following_ && may_change && differs(estimate)) target_ = estimate;
        if (!applying) target_ = 0;
        return applying ? target_ + step_ : 0;
    }

    // The growth differs from the applied offset by more than the tolerances.
    bool differs(double estimate) const noexcept {
        const bool timed = settings_.contact.method == Method::time;
        const double least = timed ? std::abs(measured_.contact().feed) * settings_.time_tolerance : 0;
        return std::abs(estimate - target_) > std::max(settings_.tolerance, least);
    }

    void walk() noexcept {
        if (records.wants_forget()) measured_.forget();
        if (records.wants_restore()) records.restored(measured_.restore(row.given()));
        const ContactReferences& references = measured_.cycle().references();
        records.show(references.size(), [&](std::int32_t i) noexcept { row.show(references[i]); });
    }

    GrowthByContact measured_;
    static constexpr std::uint32_t between_settings = 32;  // periods
    Settings settings_;                                    // last good values
    bool bad_settings_ = false, shown_event_ = false;
    std::uint32_t periods_ = 0;
    double target_ = 0;       // mu
    bool following_ = false;  // the offset is applied, and a contact was accepted since
    SlewLimit slew_;
    double step_ = 0;  // mu, in this cycle
    Edge cycle_;
    bool load_gone_ = false;  // it was lost before this cycle began, and still is
};

hal::Model hal::model() {
    return model_of<ThermalDisplacement>();
}

}  // namespace plumb
