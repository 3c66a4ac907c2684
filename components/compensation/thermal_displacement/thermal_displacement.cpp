// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_report.hpp"
#include "components/compensation/thermal_displacement/contact_settings.hpp"
#include "components/compensation/thermal_displacement/growth_settings.hpp"
#include "components/compensation/thermal_displacement/reference_conditions.hpp"
#include "components/compensation/thermal_displacement/reference_row.hpp"
#include "components/math/blocks/bounded.hpp"
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
        "compensate thermal growth along Z, measured by the contacts of the tools with the work",
        R"(
A warm spindle is longer and reaches the work earlier.  The load of a motor shows when: no sensor is added.  A
learning cycle on a settled machine records each contact A of a tool with the work; in later cycles on equal blanks
each contact B is compared with it.  +Z points away from the work, growth g > 0 is a longer spindle, and z-offset is
what is to be added to the Z origin:

    by coordinate:  g = zB - zA          z-offset = g                       z: z-position at the contact
    by time:        d = v (tB - tA)      z-offset = applied-offset + d      v < 0: signed feed in the plunge

The clock of the time method starts when z-position - applied-offset comes down to start-height, or with the cycle
(clock-from-program).  Then every cycle, and the one that is learnt from too, must begin with the same tool in the same
place: the first one after switching on often does not, and all contacts of the later ones are rejected.

z-offset changes where growth-estimate differs from it by more than tolerance, only in a cycle while the tool is out of
the work and does not feed down to it, by max-rate at most, and stays within max-offset.  Between cycles it stands
still, or returns to 0 when it is no longer to be applied.

The signal to net to z-position is the encoder, offset included: joint.N.motor-pos-fb when the offset goes in through
axis_offset, the drive's own feedback when through joint_offset.  applied-offset is what that stage says it applies.
z-velocity-cmd is joint.N.vel-cmd, motion-type motion.motion-type, operation motion.program-line or a number that the
program sets by M68.  load may be that of the spindle or of the Z motor.

Learning: with learn true at the start of a cycle, z-offset returns to 0 and stays there.  The cycle is learnt from
when cycle-running falls while cycle-complete is true: let the program set it as its last act (M64) and take it back as
its first.  A cycle that was aborted, that had a fault, or whose offset was not 0, counts for nothing and sets
learning-failed.  The reference is the mean of reference-cycles consecutive ones, and takes over with the last of them;
until then the one before stays.  It keeps the contacts, 64 at most, that all of them had and that agreed in feed,
override, window and gate.  A cycle none of which agrees, another program-id or tool-set-id, begins anew; a cycle with
learn false ends the attempt.

row-scatter is the standard deviation of one contact from cycle to cycle: what blanks, the seat of the tool and a
machine that warmed meanwhile make of it, beyond the noise of the load that row-sigma has.  It counts in
displacement-sigma.  Scatter well above row-sigma that grows with the number of cycles means that the machine warmed:
the reference lies in the middle of that, and fewer cycles, or a rest between them, are better.

The reference belongs to its program-id and tool-set-id, and can be read and restored row by row; of another program
than the one before it in the list, a row is not restored.  It is refused, with the reason in refusal-code, when a
cycle begins with another one of either, and when all contacts of a complete cycle came with another feed or override.
No contact is compared then, and z-offset returns to 0.  A rising edge of acknowledge ends it, and the next start of a
cycle is judged anew; learning ends it too, which is the way out after an edit or a change of tools.

There is no setting for wear at a tool change because no wear is kept: each contact sets the offset anew, so a fresh
edge of the same tool shows at its first contacts, within the gate.  A tool measured anew is another tool-set-id.

A contact is a rise of the smoothed load by threshold over its running baseline while Z feeds towards the work, one
per approach, that lasts for the debounce time.  Blanking-time after a change of spindle-speed-cmd it is rejected.
Choose threshold low: four or five times load-noise as shown while the tool feeds through air (it is never taken below
four times), and a third of the step of the lightest cut at most.

The threshold only finds the contact.  Where it was comes out of a fit, by least squares, to the load of up to 0.3 s
before and 0.3 s after, or less where the approach begins later or the feed ends earlier:

    y = b,  from t0 on  b + P (1 - exp(-(t - t0) / tau))        b, P, t0 free; z-position interpolated at t0

so that a softer part or a worn tool, whose step P is another one, moves nothing.  tau, mostly the drive's filter, is
fitted in the learning cycle, kept with the reference, and used for all contacts that are compared with it: what the
exponential does not describe shifts both alike.  A load that the drive samples and holds counts once per sample.  The
work is spread, and the contact told up to 0.5 s after it was found (0.35 s when tau is known); until then the cycle
must not end.  White noise s, sampled each T, gives the moment at best, and nearly so, a standard deviation of
(s / P) sqrt(2 tau T): 0.3 ms for 0.3 percent, P 8 percent, tau 30 ms and 1 ms, which is 0.5 um at 100 mm/min.
Pairs whose second load is 20 percent lower then scatter by 0.8 um rms, and by 2.7 um where the drive gives its load each
8 ms to 0.5 percent; a threshold at half height errs by 13 and 17 um.
displacement-sigma is estimated from the residuals of both fits, seen through the same exponential, so that ripple and
1/f noise count as well.  A rise that does not stand out from them by five standard deviations is rejected.

Pairing goes by operation, tool and occurrence: the first, second, ... approach of that tool in that operation.  A
drill, whose load rises over its point, and an entry from the side say nothing about Z: name their keys in
exclude-operation-N.  start-height and window may be set by operation, as
operation itself.  A different feed or override is rejected, not scaled away, by either method; so is a contact within
steady-time after a feed hold, a stop or a turn of the override: a tool that was held in the work, before the load
showed it, seems to meet it where it goes on.

The gate: growth can have come no further than max-growth-rate times the time since the last accepted contact, at
least gate-floor, at most gate-cap.  What lies beyond is rejected, or, with confirm-contacts above 0, believed once so
many further contacts agree with it within gate-floor, each of another tool and in another cycle than the one before.

Between contacts (follow-speed) the growth goes on by a model of what the speed n of the spindle makes of it, each part
learnt from the contacts, and weighed by its doubt:

    growth = b + K x + A d + c T     tau x' = (n / 5000 rpm)^1.7 - x      tau d' = -d, from 1 at the start

b is a slow bias, K x what the speed makes, A d the unknown heat at the start, c T what the temperature makes while
temperature-valid is true and temperature-age not above max-temperature-age.  Three such Kalman filters with tau 5, 10
and 20 min, four times that at rest, have the weight that their predictions earned.  Nothing is predicted before the
first accepted contact, also not after a restart.  The prediction stays within the gate about the last accepted contact;
a contact that the gate would let in but that lies beyond the gate about the prediction is rejected, and the prediction
given up for the last accepted contact until the next.  A lost speed holds; after a minute of it, and after three cycles
of which nothing was accepted, the last accepted contact does.  A lost temperature holds for ten minutes; then T goes
to 0, and later to the value that is there again, by 0.01 K/s.  With follow-speed false the last accepted contact holds.
  expected-growth says where learning starts; contact-repeatability is what seat and blank add to the
noise of the load, unexplained-growth how fast b may wander: the larger, the more a contact counts.  A fresh edge, a new
batch of blanks or another tool looks like a step of b, of which the first contact takes a part, those after it the
rest.  growth-uncertain stays true after a change of speed until a contact, whatever is predicted.

A contact measures tool, spindle, work and wear together, wear as a shorter spindle: a chip, odd stock or a longer tool
within the gate cannot be told from growth by any means and shifts the work by what it is, the gate at most.  A
correction is called wrong when it leaves |offset - growth| larger than before by more than gate + 3 sigma; a whole
batch of odd blanks that confirms itself can cause one.

An input that is not a number, or is beyond 1e6, is invalid.  Meanwhile contacts are ignored and z-offset holds;
afterwards the load is blanked as after a change of speed.  When three cycles had contacts and none was accepted, growth
may have left the gate, as over a long rest: z-offset holds the last accepted contact.  Check the machine and learn again.

When enable is false or dry-run true, z-offset returns to 0 at max-rate.  Defaults are for millimetres.  Source:
CN104227498A, claims 1 (time) and 2 (coordinate).)"};

    using Component::Component;

    hal::In<bool> enable{this, "enable", false, "Compare contacts and apply the offset."};
    hal::In<bool> learn{this, "learn", false, "The next cycle is one to learn from."};
    hal::In<bool> dry_run{this, "dry-run", false, "Compare and count, but never apply."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<bool> cycle_complete{this, "cycle-complete", false, "The cycle that ends was not aborted."};
    hal::In<double> load{this, "load", 0, "%", "Load of the spindle or Z motor, of its rating."};
    hal::In<double> spindle_speed_cmd{this, "spindle-speed-cmd", 0, "rpm", "Commanded speed of the spindle."};
    hal::In<double> z_position{this, "z-position", 0, "mu", "Z by its encoder, offset included."};
    hal::In<double> z_velocity_cmd{this, "z-velocity-cmd", 0, "mu/s", "Speed of Z, negative to the work."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 2, "As in LinuxCNC: 1 rapid, 2 feed."};
    hal::In<double> feed_override{this, "feed-override", 1, "1", "Feed override in force."};
    hal::In<std::int32_t> tool_number{this, "tool-number", 0, "Tool in the spindle."};
    hal::In<std::int32_t> operation{this, "operation", 0, "Key of the operation; 0 for none."};
    hal::In<double> start_height{this, "start-height", 0, "mu", "Where the clock of this operation starts."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu", "What the stage adds to the Z origin."};

    ReferenceConditions conditions{this};
    ContactSettings contact_settings{this};
    GrowthSettings growth{this};
    hal::In<double> tolerance{this, "tolerance", 0.002, "mu", "Smallest change that is applied."};
    hal::In<double> time_tolerance{this, "time-tolerance", 0, "s", "By time: likewise, as a time."};
    hal::In<double> max_offset{this, "max-offset", 0.15, "mu", "Largest offset either way."};
    hal::In<double> max_rate{this, "max-rate", 0.01, "mu/s", "Fastest change of the offset, 1 at most."};

    hal::Out<double> z_offset{this, "z-offset", "mu", "What is to be added to the Z origin, by a stage."};
    hal::Out<bool> limited{this, "limited", "The growth exceeds max-offset."};
    hal::Codes<Fault> fault{this, "fault"};
    ContactReport report{this};
    hal::Records records{this};
    ReferenceRow row{this};

    hal::Offset moves{this, hal::MovingPin(z_offset).bound(max_offset).rate(max_rate).limited(limited)};

    hal::Function run{this, "update", &ThermalDisplacement::update, "After all inputs, before the stage."};

    void prepare() override { settings_ = settings(); }

    void update(double dt) noexcept {
        const Sample now = sample();
        const Lost lost = GrowthByContact::lost(now);
        const Settings wanted = settings();
        if (wanted.valid()) settings_ = wanted;
        const bool at_zero = slew_.value() == 0 && std::abs(now.applied_offset) <= settings_.tolerance;
        const bool applying = now.enable && !dry_run && !now.learn && measured_.applicable();
        const bool frozen = applying && lost != Lost::nothing;

        const auto event = measured_.step(now, at_zero, settings_.contact, dt);
        if (conditions.acknowledges()) measured_.acknowledge();
        const double estimate = measured_.estimate(settings_.contact);
        following_ =
            applying && measured_.known() && (following_ || event == GrowthByContact::Event::accepted);
        if (following_ && differs(estimate)) target_ = estimate;
        if (!applying) target_ = 0;
        const double offset = bounded(target_, settings_.max_offset);
        const bool may_move = now.cycle_running || !applying;  // not under the hands of the operator
        if (may_move && !measured_.in_work() && !frozen) slew_.step(offset, settings_.max_rate, dt);

        z_offset = slew_.value();
        limited = offset != target_;
        fault = hal::first<Fault>({{lost == Lost::load, Fault::load},
                                   {lost == Lost::position, Fault::position},
                                   {lost == Lost::speed, Fault::spindle_speed},
                                   {lost == Lost::offset, Fault::applied_offset},
                                   {lost == Lost::approach, Fault::approach},
                                   {!wanted.valid(), Fault::settings},
                                   {measured_.lost_track(), Fault::lost_track}});
        growth.show(estimate, measured_.estimate_sigma(settings_.contact));
        report.show(measured_, event, now.setup, settings_.contact);
        walk();
    }

private:
    using Sample = GrowthByContact::Sample;
    using Lost = GrowthByContact::Lost;

    struct Settings {
        GrowthByContact::Settings contact;
        double tolerance = 0;       // mu
        double time_tolerance = 0;  // s
        double max_offset = 0;      // mu
        double max_rate = 0;        // mu/s

        bool valid() const noexcept {
            const auto within = [](double x, double most) { return x >= 0 && x <= most; };
            return contact.valid() && within(tolerance, 1e3) && within(time_tolerance, 1e3) &&
                   within(max_offset, 1e3) && within(max_rate, 1);
        }
    };

    Settings settings() noexcept {
        Settings s;
        s.contact = contact_settings.read();
        s.contact.between = growth.read();
        s.tolerance = tolerance;
        s.time_tolerance = time_tolerance;
        s.max_offset = max_offset;
        s.max_rate = max_rate;
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
        s.speed = spindle_speed_cmd;
        s.z = z_position;
        s.velocity = z_velocity_cmd;
        s.feed_override = feed_override;
        s.start_height = start_height;
        s.applied_offset = applied_offset;
        s.temperature = conditions.temperature;
        s.date = conditions.date;
        s.temperature_valid = growth.temperature_usable();
        return s;
    }

    // A growth is not what is applied, by more than the tolerances.
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
    Settings settings_;       // the last good ones
    double target_ = 0;       // mu
    bool following_ = false;  // a contact was accepted since the offset is applied
    SlewLimit slew_;
};

hal::Model hal::model() {
    return model_of<ThermalDisplacement>();
}

}  // namespace plumb
