// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/displacement_pins.hpp"
#include "components/compensation/thermal_displacement/displacement_reports.hpp"
#include "components/compensation/thermal_displacement/displacement_status.hpp"
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "components/compensation/thermal_displacement/growth_offset.hpp"
#include "components/compensation/thermal_displacement/machine_signals.hpp"
#include "components/compensation/thermal_displacement/operator_questions.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "pages/thermal_displacement.page.hpp"

#include <cmath>
#include <string>

namespace plumb {

struct ThermalDisplacement final : hal::Component {
    static constexpr hal::About about{
        "thermal_displacement",
        "compensates thermal growth along Z, measured by the contacts of the tools with the work", page,
        "Growth of Z"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Compare contacts and apply the offset."};
    MachineSignals machine{this};
    ReferenceConditions conditions{this};
    DisplacementPins contact_settings{this};
    hal::In<bool> dry_run{this, "dry-run", false, "Compare and count, but never apply.", hal::must()};
    hal::In<bool> verify{
        this, "verify", false,
        "Displace the offset by verify-step in the next cycle, never for a part that counts.",
        hal::machine()};
    OffsetPins offset_settings{this};
    hal::Effects next_cycle{this,
                            hal::Effect::next_cycle,
                            verify,
                            offset_settings.pin_of(offset_settings.verify_step),
                            offset_settings.pin_of(offset_settings.constant_in_part),
                            offset_settings.pin_of(offset_settings.tolerance),
                            offset_settings.pin_of(offset_settings.time_tolerance),
                            offset_settings.pin_of(offset_settings.max_offset)};

    hal::Out<double> growth_estimate{this, "growth-estimate", "mu",
                                     "Growth now: by the model, or by the last accepted contact."};
    hal::Out<double> growth_sigma{this, "growth-sigma", "mu", "Standard deviation of growth-estimate."};
    hal::Out<double> z_offset{this, "z-offset", "mu", "Offset that a stage adds to the Z origin."};
    hal::Out<bool> limited{this, "limited", "The growth exceeds max-offset."};
    hal::Out<bool> fault{this, "fault", "A fault is active; detail-code gives the cause."};
    hal::Code<DisplacementDetail> detail{
        this, "detail-code",
        "A fault; else why nothing was learned, why the reference is refused, or why the last contact is "
        "rejected; 0 for none."};
    hal::Status<DisplacementStatus> status{this, permission};
    ContactReport report{this};
    TrustReport trust{this};
    OperatorQuestions questions{this};
    WorkSummary summary{this};
    hal::Records records{this};
    ReferenceRow row{this};

    hal::Offset moves{
        this,
        hal::MovingPin(z_offset)
            .bound(offset_settings.pin_of(offset_settings.max_offset))
            .rate(offset_settings.pin_of(offset_settings.max_rate))
            .accelerated_by("The stage limits its acceleration; axis_offset(9) leaves that to LinuxCNC.")
            .limited(limited)
            .at_next_cycle()};

    hal::Effects withholds{this, hal::Effect::withholds, dry_run};

    hal::Function run{this, "update", &ThermalDisplacement::update, hal::Place::source,
                      "After all its inputs."};

    void prepare() override {
        contact_ = contact_settings;
        own_ = offset_settings;
    }

    void update(double dt) noexcept {
        permission.step();
        Sample now = sample();
        now.judge();
        now.learn = now.learn || measured_.learns_again(now.setup);
        const Lost lost = now.lost;
        take_settings();
        const bool dry = dry_run;
        const bool applying = now.enable && !dry && measured_.applicable();
        const bool starts = watch_cycle(now.cycle_running, now.load_lost, applying && !now.learn);
        now.step = step_;

        const auto event = measured_.step(now, contact_, dt);
        const bool acknowledged = conditions.acknowledges();
        if (acknowledged) {
            measured_.acknowledge();
            shown_event_ = true;
        }
        questions.answer(measured_, contact_, now.tool, acknowledged, dt);
        GrowthOffset::Wish wish;
        wish.applying = applying;
        wish.known = measured_.known();
        wish.may_change = starts || !offset_settings.constant_in_part;
        const bool frozen = applying && (now.load_lost ? !load_gone_ : lost != Lost::nothing);
        const bool untouched = now.cycle_running || !applying;  // else an operator may be at the machine
        wish.may_move = untouched && !measured_.in_work() && !frozen;
        wish.growth = measured_.filter().offset();
        wish.step = step_;
        offset_.step(wish, own_, own_.smallest(contact_.method(), measured_.contact().feed), dt);

        z_offset = offset_.value();
        limited = offset_.limited();
        using D = DisplacementDetail;
        const D its_fault = hal::first<D>({{lost == Lost::load, D::load},
                                           {lost == Lost::position, D::position},
                                           {lost == Lost::speed, D::spindle_speed},
                                           {lost == Lost::offset, D::applied_offset},
                                           {lost == Lost::approach, D::approach},
                                           {bad_settings_, D::settings},
                                           {measured_.tally().lost_track(), D::lost_track}});
        fault = its_fault != D::none;
        const Doubt doubt = doubted(applying);
        const bool shows = measured_.due() || shown_event_;
        if (shows) show(event, applying, doubt, now.setup);
        shown_event_ = event != GrowthByContact::Event::none;
        summary.step(applying && now.cycle_running && !now.learn && step_ == 0, offset_.value(), trust.sigma(),
                     measured_.known() && doubt != Doubt::none, dt);
        walk();
        if (shows || its_fault != fault_) show_status(now, its_fault, doubt, dry, applying);
        fault_ = its_fault;
        permission.report({});
    }

private:
    using Sample = GrowthByContact::Sample;
    using Lost = GrowthByContact::Lost;

    // Those of the contacts, which are many, later. A bound of the offset holds at once.
    void take_settings() noexcept {
        const bool contact = periods_++ % between_settings == 0 && contact_settings.read();
        const bool own = offset_settings.read();
        if (!contact && !own) return;
        bad_settings_ =
            !(contact_settings.in_range && contact_settings.consistent() && offset_settings.in_range &&
              std::abs(offset_settings.verify_step) <= contact_settings.cap);
        if (bad_settings_) return;
        contact_ = contact_settings;
        own_ = offset_settings;
    }

    // Why the growth may be wrong, while it is to be applied.
    Doubt doubted(bool applying) const noexcept {
        if (!applying) return Doubt::none;
        if (measured_.known()) return measured_.filter().doubt();
        return measured_.cycle().rows() > 0 ? Doubt::unknown : Doubt::none;
    }

    void show(GrowthByContact::Event event, bool applying, Doubt doubt,
              const MachiningSetup& setup) noexcept {
        const double grown = measured_.known() ? measured_.filter().growth() : 0;
        growth_estimate = grown;
        growth_sigma = measured_.known() ? measured_.filter().sigma(contact_) : 0;
        trust.show(measured_, contact_, grown, offset_.value(), doubt);
        report.show(measured_, event, setup, contact_);
        questions.show(measured_, contact_, applying);
    }

    Sample sample() noexcept {
        Sample s = machine.read();
        s.enable = permission.enabled();
        s.setup = conditions.setup();
        s.temperature = conditions.temperature;
        s.date = conditions.date;
        s.temperature_valid = conditions.temperature_usable(contact_settings.max_temperature_age);
        s.origin_reason = questions.reason();
        return s;
    }

    void show_status(const Sample& now, DisplacementDetail its_fault, Doubt doubt, bool dry,
                     bool applying) noexcept {
        DisplacementSeen seen;
        seen.fault = its_fault;
        seen.enabled = now.enable;
        seen.load_valid = !now.load_lost;
        seen.learning = measured_.cycle().learning();
        seen.will_learn = now.learn;
        seen.learns_again = measured_.learns_again(now.setup);
        seen.learning_fault = measured_.tally().learning_fault();
        seen.refusal = measured_.refusal().reason();
        seen.rejection = measured_.tally().of_last_contact();
        seen.has_reference = measured_.cycle().has(now.setup);
        seen.has_rows = measured_.cycle().rows() > 0;
        seen.cycle_running = now.cycle_running;
        seen.dry_run = dry;
        seen.doubt = doubt;
        seen.asks_origin = applying && measured_.origin_change() != 0;
        if (applying) seen.shift = measured_.filter().shift(contact_);
        seen.waits = questions.waits();
        seen.known = measured_.known();
        seen.bounded = offset_.limited();
        seen.interlock = status.of_interlock();
        status = status_of(seen);
        detail = detail_of(seen);
    }

    // A load that was lost before the cycle began holds nothing up: its authority decides.
    bool watch_cycle(bool running, bool load_lost, bool applying) noexcept {
        const bool starts = cycle_.rises(running);
        if (starts) {
            load_gone_ = load_lost;
            step_ = verify && applying ? own_.verify_step : 0;
        }
        if (!load_lost) load_gone_ = false;
        return starts;
    }

    void walk() noexcept {
        const bool forgets = records.wants_forget(), restores = records.wants_restore();
        if (forgets) measured_.forget();
        if (restores) records.restored(measured_.restore(row.given()));
        if (!forgets && !restores && !measured_.due() && !records.asks()) return;
        const ContactCycle& cycle = measured_.cycle();
        records.show(cycle.rows(), [&](std::int32_t i) noexcept { row.show(cycle.row(i)); });
    }

    GrowthByContact measured_;
    static constexpr std::uint32_t between_settings = 32;  // periods
    DisplacementSettings contact_;                         // the last good ones
    GrowthOffset::Settings own_;                           // the last good ones
    bool bad_settings_ = false, shown_event_ = false;
    std::uint32_t periods_ = 0;
    GrowthOffset offset_;
    double step_ = 0;  // mu, in this cycle
    DisplacementDetail fault_ = DisplacementDetail::none;
    Edge cycle_;
    bool load_gone_ = false;  // it was lost before this cycle began, and still is
};

hal::Model hal::model() {
    return model_of<ThermalDisplacement>();
}

}  // namespace plumb
