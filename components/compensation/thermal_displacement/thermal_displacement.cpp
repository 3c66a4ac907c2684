// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_report.hpp"
#include "components/compensation/thermal_displacement/contact_settings.hpp"
#include "components/compensation/thermal_displacement/growth_settings.hpp"
#include "components/compensation/thermal_displacement/reference_conditions.hpp"
#include "components/compensation/thermal_displacement/reference_row.hpp"
#include "components/compensation/thermal_displacement/trust_report.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/slew_limit.hpp"
#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"

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
        "compensates thermal growth along Z, measured by the contacts of the tools with the work",
        R"(
A warm spindle grows and cuts too deep, 20 to 70 um within half an hour. thermal_displacement measures this growth
without a sensor. The load of the motor rises when a tool meets the work. The component compares the Z position of
this contact with the contact that it learned on a cold machine. It outputs the difference as an offset of the Z origin.

Use it for repeated parts with plunging end mills. It corrects Z only. The theory, the symbols and the figures are in
components/compensation/thermal_displacement/README.md of the sources.)",
        hal::Wiring{R"(
  loadrt thermal_displacement names=growth unit=[TRAJ]LINEAR_UNITS
  loadrt axis_offset          names=z-stage unit=[TRAJ]LINEAR_UNITS

  net z-motor-fb                               => growth.z-position
  net spindle-load                             => growth.load
  net z-velocity-cmd joint.2.vel-cmd           => growth.z-velocity-cmd
  net motion-type    motion.motion-type        => growth.motion-type
  net operation      motion.program-line       => growth.operation
  net spindle-speed spindle.0.speed-out => growth.spindle-speed-cmd
  net tool-number    iocontrol.0.tool-number   => growth.tool-number
  net feed-override  halui.feed-override.value => growth.feed-override
  net cycle-running  motion.digital-out-00     => growth.cycle-running
  net cycle-complete motion.digital-out-01     => growth.cycle-complete
  net learn          motion.digital-out-02     => growth.learn
  net z-offset       growth.z-offset           => z-stage.offset-0
  net applied-offset z-stage.applied-offset    => growth.applied-offset

  addf motion-command-handler servo-thread
  addf motion-controller      servo-thread
  addf growth.update          servo-thread
  addf z-stage.update         servo-thread

  setp growth.enable  1
  setp growth.dry-run 1

spindle-load is the load of the spindle motor or of the Z motor, 0 to 100 percent of its rating. Give a new value every
10 ms or faster. z-motor-fb is the position of the encoder, and it must contain the offset. Through axis_offset this is
your signal at joint.2.motor-pos-fb. Through joint_offset it is the feedback of the drive, at z-stage.drive-feedback.

operation identifies a cut. It is the program line, or a number that the program sets with M68. axis_offset(9) has the
other lines of the stage, and configs/mill/stages.hal has all of them.)"},
        hal::SettingUp{R"(
1. Keep dry-run true. Let the program begin a cycle with M65 P1 and M64 P0, and end it with M64 P1 and M65 P0.
2. Run a part and watch contacts: it counts every plunge. If it misses some, reduce threshold. Four to five times
load-noise is a good value, read while the tool feeds through air. Use at most a third of the rise of the lightest cut.
3. Exclude drills and cuts from the side with exclude-operation-N. Their load does not show the Z position of the work.
4. Let the machine stand overnight. Set learn true (M64 P2) before the cycle starts, and run one part. reference-valid
becomes true, and reference-sigma shows how good it is. learning-failed-code gives the reason if nothing was learnt. To
learn again, repeat this step.
5. Run parts as usual. displacement follows the spindle; displacement-sigma is its uncertainty.
6. Set dry-run false when the growth is at least three times displacement-sigma.
7. Once, verify that the contacts are of the work: set verify-step to 0.02 mm, and verify true before a cycle whose part
does not count. The offset is displaced by that much in this cycle. An operation whose load rises at the same place of
the program all the same is withdrawn, and doubt-code is 5. Set verify-step to 0 again.
8. Only to compare the times of the contacts instead of their coordinates: add

  net z-motor-offset joint.2.motor-offset  => growth.z-motor-offset
  net start-height   motion.analog-out-03  => growth.start-height

  setp growth.by-time 1

and set the start height in the program, right before each plunge, in machine units:

  G0 Z3
  M68 E3 Q[#<_abs_z> - 1]
  G1 Z-2 F100

The clock starts 1 mm below Z3, where the tool has its feed. contact-time shows the time of the last contact. Learn again.
9. With clock-from-program, the clock starts with the cycle. Then all cycles must begin alike within lost-time-tolerance, and
LinuxCNC's cycles do not. Net motion.digital-out-07 to clock-start, and write M65 P7 and M62 P7 right before each plunge: the
clock starts with the plunge. o<growth_clock> call [1] of configs/functions has the lines of steps 8 and 9, for programs in
mm and in inches.

plumb-contacts(1) finds the settings from a recording. Keep unit=[TRAJ]LINEAR_UNITS in the loadrt line: on an inch
machine it converts the defaults.)"},
        hal::Behaviour{R"(
- Start of LinuxCNC: z-offset is 0. It follows the growth again after the first accepted contact. retain(1) keeps the
reference over a restart. A growth above gate-floor needs two contacts that agree.
- A contact far from the growth that was expected: Within gate-floor it counts in part, beyond it not at all, until
another contact agrees. Then the offset follows whole. Beyond gate-floor this is a contact of another tool, if the
reference has one and the growth was known.
- A contact that no other agrees with in three cycles: Within gate-floor its reference is taken to be off by as much. Beyond
it the operation is withdrawn until it is learnt again, as is one whose contacts move with the offset. doubt is true.
- Growth in doubt: doubt-code gives the reason, before the cut that it concerns. authority is the part of the growth that
is applied. It falls with the uncertainty of the growth, with disagreement of the contacts, and with time. In a cycle it
never falls. While the machine begins to warm only a part is applied; doubt is true where an offset may do harm, or where
it was applied and no longer is.
- No contact counts, or load-valid is false: z-offset holds in this cycle. After hold-time it returns to 0, at the start
of a cycle, within as long again. The next contacts bring it back.
- In a cycle: z-offset changes at most at max-rate, only while the tool is clear of the work and does not feed down.
- Between cycles: z-offset does not move. If it is no longer applied, it returns to 0.
- Abort: z-offset holds. The cycle does not count.
- Machine off, emergency stop: Z does not move. axis_offset applies the offset again when the next cycle starts.
- enable false, dry-run true: z-offset returns to 0 at max-rate.
- Learning: z-offset returns to 0 first. The cycle counts if cycle-complete is true when cycle-running falls. An
aborted cycle, a fault, or an offset that is not 0 sets learning-failed. So do contacts of one tool that disagree in how
the load rises; if they disagree in the next cycle too, the other contacts are learnt alone.
- Another program or tool set: The reference is refused (refusal-code) and z-offset returns to 0. Learn again, or raise
acknowledge. The same happens if all contacts of a complete cycle came with a feed or override beyond feed-range.
- Another feed or override: By time the contact is rejected. By coordinate it is compared within feed-range, and is less
certain.
- Change of spindle speed: Contacts within blanking-time are rejected. One that follows later in the same approach counts.
- Feed hold, stop, change of override: Contacts within steady-time are rejected.
- By time, no clock: Contacts are rejected, and nothing is learnt from them. The codes of rejection and learning name it.
- By time, a stop on the way, or a cycle that begins unlike the reference: Contacts whose lost time differs by more than
lost-time-tolerance are rejected.
- Invalid input: Contacts are ignored and z-offset holds. An input is invalid if it is not a number or beyond 1e6.
- Growth beyond the gate: The contact is rejected and z-offset holds.)"},
        hal::Limits{R"(
A contact measures tool, spindle, work and wear together. Odd stock, or a longer tool that is the only gauge, looks like
growth within the gate (15 to 60 um), and shifts the work by as much. With gauges of two tools each shows the error of the
other.

A load event of the program, as coolant that comes on late, looks like a contact that never moves. While the offset stands,
nobody can distinguish it from a machine that does not grow. A verifying cycle can.

Only plunges with an end mill give the Z position. Drills and cuts from the side do not.

The result is as good as the load. With a noisy, late or coarse load, offset-sigma is large and authority small.

The reference is as good as its learning cycle. A tool that wears, or one that seats differently, moves the origin.

After a long rest the growth may be beyond the gate. Every contact is then rejected, the offset holds, and fault is
true. Look after the machine, and learn again.

Between contacts the offset follows a model of the spindle speed. The temperature of the shop shows at the next contact.

The reference holds at most 64 contacts.

By time, plumb-contacts(1) cannot judge a recording: it compares coordinates.)"},
        hal::SeeAlso{"axis_offset(9), joint_offset(9), retain(1), linuxcnc_link(1), plumb-contacts(1)"}};

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
    hal::In<double> tolerance{this, "tolerance", 0.002, "mu", "Smallest change that is applied.", lengths};
    hal::In<double> time_tolerance{
        this, "time-tolerance", 0, "s", "Smallest change that is applied by the time method, as a time.",
        times};
    hal::In<double> max_offset{this, "max-offset", 0.15, "mu", "Largest offset either way.", lengths};
    hal::In<double> max_rate{this, "max-rate", 0.01, "mu/s", "Fastest change of the offset.", rates};

    hal::Out<double> z_offset{this, "z-offset", "mu", "Offset that a stage adds to the Z origin."};
    hal::Out<bool> limited{this, "limited", "The growth exceeds max-offset."};
    hal::Codes<Fault> fault{this, "fault"};
    ContactReport report{this};
    TrustReport trust{this};
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
        const Settings wanted = settings();
        if (wanted.valid()) settings_ = wanted;
        const bool at_zero = slew_.value() == 0 && std::abs(now.applied_offset) <= settings_.tolerance;
        const bool applying = now.enable && !dry_run && !now.learn && measured_.applicable();
        watch_cycle(now.cycle_running, now.load_lost, applying);
        now.step = step_;

        const auto event = measured_.step(now, at_zero, settings_.contact, dt);
        if (conditions.acknowledges()) measured_.acknowledge();
        const double asked = ask(applying, event);
        const double offset = bounded(asked, settings_.max_offset);
        const bool frozen = applying && (now.load_lost ? !load_gone_ : lost != Lost::nothing);
        const bool may_move = now.cycle_running || !applying;  // not while an operator may touch the machine
        if (may_move && !measured_.in_work() && !frozen) slew_.step(offset, settings_.max_rate, dt);

        z_offset = slew_.value();
        limited = offset != asked;
        fault = hal::first<Fault>({{lost == Lost::load, Fault::load},
                                   {lost == Lost::position, Fault::position},
                                   {lost == Lost::speed, Fault::spindle_speed},
                                   {lost == Lost::offset, Fault::applied_offset},
                                   {lost == Lost::approach, Fault::approach},
                                   {!wanted.valid(), Fault::settings},
                                   {measured_.tally().lost_track(), Fault::lost_track}});
        const double grown = measured_.known() ? measured_.estimate(settings_.contact) : 0;
        growth.show(grown, measured_.known() ? measured_.estimate_sigma() : 0);
        trust.show(measured_, grown, slew_.value(), applying);
        report.show(measured_, event, now.setup, settings_.contact);
        walk();
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
            return in_range && contact.valid() && std::abs(verify_step) <= contact.gate.cap;
        }
    };

    Settings settings() noexcept {
        Settings s;
        hal::SettingsReader setting;
        s.contact = contact_settings.read();
        s.contact.between = growth.read();
        s.contact.hold_time = growth.hold_time;
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

    // A load that was lost before the cycle began holds nothing up: its authority decides.
    void watch_cycle(bool running, bool load_lost, bool applying) noexcept {
        if (cycle_.rises(running)) {
            load_gone_ = load_lost;
            step_ = verify && applying ? settings_.verify_step : 0;
        }
        if (!load_lost) load_gone_ = false;
    }

    // The offset that is asked for, mu.
    double ask(bool applying, GrowthByContact::Event event) noexcept {
        const double estimate = measured_.authority().offset();
        following_ =
            applying && measured_.known() && (following_ || event == GrowthByContact::Event::accepted);
        if (following_ && differs(estimate)) target_ = estimate;
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
    Settings settings_;       // last good values
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
