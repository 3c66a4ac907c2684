// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_report.hpp"
#include "components/compensation/thermal_displacement/contact_settings.hpp"
#include "components/compensation/thermal_displacement/displacement_status.hpp"
#include "components/compensation/thermal_displacement/growth_settings.hpp"
#include "components/compensation/thermal_displacement/machine_signals.hpp"
#include "components/compensation/thermal_displacement/offset_settings.hpp"
#include "components/compensation/thermal_displacement/operator_questions.hpp"
#include "components/compensation/thermal_displacement/reference_conditions.hpp"
#include "components/compensation/thermal_displacement/reference_row.hpp"
#include "components/compensation/thermal_displacement/trust_report.hpp"
#include "components/compensation/thermal_displacement/work_summary.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/contact/growth_by_contact.hpp"
#include "components/math/contact/growth_offset.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "pages/thermal_displacement.page.hpp"

#include <cmath>
#include <string>

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
        "compensates thermal growth along Z, measured by the contacts of the tools with the work", page,
        "Growth of Z"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Compare contacts and apply the offset."};
    MachineSignals machine{this};
    ReferenceConditions conditions{this};
    ContactSettings contact_settings{this};
    GrowthSettings growth{this};
    OffsetSettings offset_settings{this};

    hal::Out<double> z_offset{this, "z-offset", "mu", "Offset that a stage adds to the Z origin."};
    hal::Out<bool> limited{this, "limited", "The growth exceeds max-offset."};
    hal::Codes<Fault> fault{this, "fault"};
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
            .bound(offset_settings.max_offset)
            .rate(offset_settings.max_rate)
            .accelerated_by("The stage limits its acceleration; axis_offset(9) leaves that to LinuxCNC.")
            .limited(limited)
            .at_next_cycle()};

    hal::Effects withholds{this, hal::Effect::withholds, offset_settings.dry_run, machine.learn};

    hal::Function run{this, "update", &ThermalDisplacement::update, hal::Place::source,
                      "After all its inputs."};

    void prepare() override { settings_ = settings(); }

    void update(double dt) noexcept {
        permission.step();
        Sample now = GrowthByContact::judged(sample());
        const Lost lost = now.lost;
        if (periods_++ % between_settings == 0) take_settings();
        const bool at_zero =
            offset_.value() == 0 && std::abs(now.applied_offset) <= settings_.own.offset.tolerance;
        const bool dry = offset_settings.dry_run;
        const bool applying = now.enable && !dry && !now.learn && measured_.applicable();
        const bool starts = watch_cycle(now.cycle_running, now.load_lost, applying);
        now.step = step_;

        const auto event = measured_.step(now, at_zero, settings_.contact, dt);
        if (conditions.acknowledges()) {
            measured_.acknowledge();
            shown_event_ = true;
        }
        questions.answer(measured_);
        GrowthOffset::Wish wish;
        wish.applying = applying;
        wish.known = measured_.known();
        wish.accepted = event == GrowthByContact::Event::accepted;
        wish.may_change = starts || !offset_settings.constant_in_part;
        const bool frozen = applying && (now.load_lost ? !load_gone_ : lost != Lost::nothing);
        const bool untouched = now.cycle_running || !applying;  // else an operator may be at the machine
        wish.may_move = untouched && !measured_.in_work() && !frozen;
        wish.growth = measured_.authority().offset();
        wish.step = step_;
        offset_.step(wish, settings_.own.at(settings_.contact.method, measured_.contact().feed), dt);

        z_offset = offset_.value();
        limited = offset_.limited();
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
        const bool doubted = applying && measured_.known() && measured_.authority().doubt() != Doubt::none;
        summary.step(applying && now.cycle_running && step_ == 0, offset_.value(), trust.sigma(), doubted,
                     dt);
        walk();
        if (measured_.due() || its_fault != fault_) show_status(now, its_fault != Fault::none, dry, applying);
        fault_ = its_fault;
        permission.report({});
    }

private:
    using Sample = GrowthByContact::Sample;
    using Lost = GrowthByContact::Lost;

    struct Settings {
        GrowthByContact::Settings contact;
        OffsetSettings::Values own;
        bool in_range = false;

        bool valid() const noexcept {
            return in_range && contact.valid() && std::abs(own.verify_step) <= contact.growth.gate.cap;
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
        trust.show(measured_, settings_.contact, grown, offset_.value(), applying);
        report.show(measured_, event, setup, settings_.contact);
        questions.show(measured_, settings_.contact.growth, applying);
    }

    Settings settings() noexcept {
        Settings s;
        hal::SettingsReader setting;
        s.contact = contact_settings.read(setting);
        growth.read(s.contact.growth, setting);
        s.own = offset_settings.read(setting);
        s.in_range = setting.good();
        return s;
    }

    Sample sample() noexcept {
        Sample s = machine.read();
        s.enable = permission.enabled();
        s.setup = conditions.setup();
        s.temperature = conditions.temperature;
        s.date = conditions.date;
        s.temperature_valid = growth.temperature_usable();
        s.origin_reason = questions.reason();
        return s;
    }

    void show_status(const Sample& now, bool has_fault, bool dry, bool applying) noexcept {
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
        const Doubt doubt = measured_.known() && applying ? measured_.authority().doubt() : Doubt::none;
        seen.doubted = doubt != Doubt::none;
        seen.uncertain = leaves_nothing_to_do(doubt);
        seen.asks_origin = applying && measured_.origin_change() != 0;
        seen.asks = applying && measured_.from_contacts().shift(settings_.contact.growth) != Shift::none;
        seen.known = measured_.known();
        seen.bounded = offset_.limited();
        seen.interlock = status.of_interlock();
        status = status_of(seen);
    }

    // A load that was lost before the cycle began holds nothing up: its authority decides.
    bool watch_cycle(bool running, bool load_lost, bool applying) noexcept {
        const bool starts = cycle_.rises(running);
        if (starts) {
            load_gone_ = load_lost;
            step_ = offset_settings.verify && applying ? settings_.own.verify_step : 0;
        }
        if (!load_lost) load_gone_ = false;
        return starts;
    }

    void walk() noexcept {
        const bool forgets = records.wants_forget(), restores = records.wants_restore();
        if (forgets) measured_.forget();
        if (restores) records.restored(measured_.restore(row.given()));
        if (!forgets && !restores && !measured_.due() && !records.asks()) return;
        const ContactReferences& references = measured_.cycle().references();
        records.show(references.size(), [&](std::int32_t i) noexcept { row.show(references[i]); });
    }

    GrowthByContact measured_;
    static constexpr std::uint32_t between_settings = 32;  // periods
    Settings settings_;                                    // last good values
    bool bad_settings_ = false, shown_event_ = false;
    std::uint32_t periods_ = 0;
    GrowthOffset offset_;
    double step_ = 0;  // mu, in this cycle
    Fault fault_ = Fault::none;
    Edge cycle_;
    bool load_gone_ = false;  // it was lost before this cycle began, and still is
};

hal::Model hal::model() {
    return model_of<ThermalDisplacement>();
}

}  // namespace plumb
