// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/chopping_settings.hpp"
#include "components/compensation/chopping/chopping_status.hpp"
#include "components/compensation/chopping/dead_point_pins.hpp"
#include "components/compensation/chopping/guarded_offset.hpp"
#include "components/compensation/chopping/homed_watch.hpp"
#include "components/compensation/chopping/learned_row.hpp"
#include "components/compensation/chopping/standing_off.hpp"
#include "components/compensation/chopping/stroke_faults.hpp"
#include "components/compensation/chopping/stroke_in_force.hpp"
#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/compensation/chopping/stroke_orders.hpp"
#include "components/compensation/chopping/stroke_pins.hpp"
#include "components/compensation/chopping/stroke_supervision.hpp"
#include "components/compensation/chopping/stroke_words.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/oscillation/oscillation.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"
#include "hal/records.hpp"
#include "pages/chopping.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

struct Chopping final : hal::Component {
    static constexpr hal::About about{
        "chopping", "strokes an axis between two dead points, while others follow a contour", page};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> run{this, "run", false, "A rising edge starts strokes; false stops them."};
    hal::In<bool> stop{this, "stop", false,
                       "True ends strokes as run false does, and refuses a start: for a button."};
    hal::In<bool> enable{this, "enable", true,
                         "Strokes are permitted; false withdraws the axis to position."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> feed_hold{this, "feed-hold", false, "Stand where hold-kind selects, and go on when false."};
    hal::In<bool> emergency_hold{this, "emergency-hold", false,
                                 "Brake at once and stand within the region, also amid a stroke, where a "
                                 "wheel in contact marks the work."};
    hal::In<bool> go_to_end{this, "go-to-end", false,
                            "A rising edge moves the axis to position, and ends strokes."};
    hal::In<bool> shift{this, "shift", false, "Each change takes over the dead points while stroking."};
    hal::In<bool> shift_at_crossing{this, "shift-at-crossing", false,
                                    "A crossing of crossing-at takes over the dead points, too."};
    hal::In<double> crossing_position{this, "crossing-position", 0, "mu", "Position of the crossing axis."};
    hal::In<double> crossing_at{this, "crossing-at", 0, "mu", "Coordinate that it crosses, either way."};
    hal::In<bool> program_running{this, "program-running", false,
                                  "A part program runs, not an MDI command. Strokes that it began end "
                                  "when it becomes false."};
    hal::In<bool> outlast{this, "outlast", false, "Strokes go on when the program that began them ends."};
    hal::In<double> position{this, "position", 0, "mu",
                             "Commanded position of the joint, point R: joint.N.pos-cmd."};
    hal::In<double> joint_feedback{this, "joint-feedback", 0, "mu",
                                   "Measured position of the joint, without the offset: joint.N.pos-fb."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that joint-feedback lacks: offset, with joint_offset; 0 for an "
                                   "extra joint."};
    hal::In<bool> stage_limited{this, "stage-limited", false, "The stage does not apply the whole offset."};
    hal::In<std::int32_t> stage_released{
        this, "stage-released", -1,
        "Net released of joint_offset: with 1, machine off has made the offset "
        "part of position; -1 without such a stage."};
    hal::In<double> pulse_time{this, "pulse-time", 0.02, "s", "Length of the infeed pulses."};
    hal::In<double> program_word{this, "program-word", 0, "1",
                                 "Number of a word of the program, whose value is program-value; each change "
                                 "takes it. chop_word.ngc has the numbers."};
    hal::In<double> program_value{this, "program-value", 0, "1",
                                  "Value of this word, in machine units or s."};
    ChoppingSettings settings{this};

    hal::Out<double> offset{this, "offset", "mu", "For the stage of the joint."};
    hal::Out<double> command{this, "command", "mu", "Position with the offset: joint.N.posthome-cmd."};
    hal::Out<bool> at_end{this, "at-end", "The axis rests at position, and the offset is 0."};
    hal::Out<bool> stands_off{this, "stands-off",
                              "Machine off has ended strokes, and the axis has not been at their point R since: "
                              "position is where it stood."};
    hal::Out<bool> program_refused{this, "program-refused",
                                   "The last word of the program is invalid, or the stroke that it checks."};
    hal::Out<std::int32_t> program_sections{this, "program-sections", "Sections that the program gave."};
    hal::Out<bool> feed_wait{
        this, "feed-wait",
        "Moves of a program have to wait: strokes end that no program orders any more, or "
        "a fault has stopped the axis away from position."};
    hal::Out<double> end_position{
        this, "end-position", "mu",
        "Point R, where strokes end, for a display: position at its last good value."};
    hal::Out<double> measured_position{this, "measured-position", "mu",
                                       "Measured position of the axis, with the offset, for a display."};
    StrokePins stroke{this};
    DeadPointPins dead_points{this};
    hal::Records records{this};
    LearnedRow row{this};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<ChoppingStatus> status{this};

    static constexpr double guard_factor = 10;  // of max-acceleration
    hal::Offset moves{this, hal::MovingPin(offset)
                                .bound(settings.max_offset)
                                .rate(settings.max_rate)
                                .acceleration(settings.max_acceleration, guard_factor)
                                .limited(limited.active())};

    hal::Function update_function{this, "update", &Chopping::update, hal::Place::source};

    void prepare() override {
        in_force_.begin(settings.read());
        guard(1);
    }

    void update(double dt) noexcept {
        const Now now = read(dt);
        const StrokeValues given = words_.over(settings.read());
        obey(now, given, dt);
        judge(given, dt);
        generate(now, dt);
        supervise(now, dt);
        show(now);
    }

private:
    static constexpr double farthest = StrokeValues::farthest;  // mu
    static constexpr double nothing = 1e-9;                     // mu
    static constexpr std::size_t nodes = 64;                    // to plan in a period

    // The inputs of a period.
    struct Now {
        StrokeOrders::Now orders;
        bool on, homed;
        bool releasable;           // the offset, by its stage
        bool released;             // it has become part of the position
        bool known;                // the position
        bool measurable;           // the joint-feedback and the applied-offset
        double measured, applied;  // mu
        double pulse;              // s

        bool ready() const noexcept { return on && homed; }
    };

    Now read(double dt) noexcept {
        const bool program = program_running;
        words_.watch_program(program, dt);
        words_.step(program_word, program_value, motion_.moves());
        const std::int32_t stage = stage_released;
        const bool is_on = motion_enabled, released = stage == 1 && !is_on;
        const double place = position, joint = joint_feedback, applied = released ? 0.0 : applied_offset;
        position_ = usable(place, farthest, position_);
        const StrokeOrders::Given given{run,         stop,    enable,
                                        go_to_end,   shift,   shift_at_crossing,
                                        program,     outlast, crossing_position,
                                        crossing_at, farthest};
        StrokeOrders::Now orders = orders_.step(given, dt);
        orders.returns |= words_.returns();
        return {orders,
                is_on,
                homed,
                stage >= 0,
                released,
                std::abs(place) <= farthest,
                std::abs(joint) <= farthest && std::abs(applied) <= farthest,
                joint + applied,
                applied,
                usable(pulse_time, 3600, 0)};
    }

    void obey(const Now& now, const StrokeValues& given, double dt) noexcept {
        const StrokeOrders::Now& orders = now.orders;
        faults_.step(orders.run);
        faults_.check(words_.checks() ? refusal(now, given, words_.checked(), dt) : Fault::none);
        if (motion_.moves() && !now.ready()) freeze();
        if (now.released) release();
        if (records.wants_forget()) supervision_.learning().forget();
        if (records.wants_restore()) records.restored(supervision_.learning().restore(row.given()));
        if (orders.starts && motion_.state() == StrokeMotion::State::returning)
            faults_.start(Fault::withdrawing);
        if (orders.starts && !motion_.moves()) start(now, given, dt);
        if (orders.returns && !motion_.moves() && now.ready() && now.known) return_to_end(now, given, dt);
        if (orders.shifts && motion_.moves()) take_over(given, dt);
    }

    void start(const Now& now, const StrokeValues& given, double dt) noexcept {
        const bool ready = now.ready() && now.orders.permitted && now.orders.runs;
        faults_.start(!ready       ? Fault::not_ready
                      : !now.known ? Fault::position
                                   : in_force_.take(given, position_, dt));
        if (faults_.refused()) return;
        standing_off_.end();
        in_force_.begin_strokes();
        supervision_.select(in_force_);
        supervision_.begin(seen(now));
        motion_.start(wanted(), position_ + rest_, command_in_force(dt));
    }

    // Of a stroke that is to begin at an end, mu.
    static Fault refusal(const Now& now, const StrokeValues& given, double end, double dt) noexcept {
        if (!now.ready() || !now.orders.permitted) return Fault::not_ready;
        return given.refusal(given.lower, given.upper, end, dt);
    }

    void return_to_end(const Now& now, const StrokeValues& given, double dt) noexcept {
        if (!in_force_.take_end(given, position_, dt)) return;
        supervision_.begin(seen(now));
        motion_.return_to_end(wanted(), position_ + rest_, command_in_force(dt));
    }

    void take_over(const StrokeValues& given, double dt) noexcept {
        const Fault reason = in_force_.take(given, position_, dt);
        if (reason != Fault::none) return faults_.happen(reason);
        supervision_.select(in_force_);
        supervision_.pause();
    }

    // The drive is off: nothing moves, and nothing will by itself.
    void freeze() noexcept {
        rest_ = offset_.value();
        motion_.freeze(position_ + rest_);
    }

    // Motion has taken over the place of the axis.
    void release() noexcept {
        if (offset_.value() != 0) standing_off_.begin(end_, end_ + offset_.value());
        rest_ = 0;
        offset_.release();
        motion_.freeze(position_);
    }

    void judge(const StrokeValues& given, double dt) noexcept {
        const StrokeMotion::Command& its = motion_.command();
        if (in_force_.judge(given, {position_, motion_.moves(), its.lead, its.jerk_time}, dt))
            supervision_.select(in_force_);
        guard(dt);
    }

    void guard(double dt) noexcept {
        const StrokeValues& values = in_force_.values();
        const double planned = motion_.moves() ? motion_.oscillation().planned_acceleration() : 0;
        const double hardest = std::max(values.stroke.acceleration, planned);
        offset_.allow({values.max_offset, values.max_rate, guard_factor * hardest}, motion_.moves(), farthest,
                      dt);
    }

    StrokeMotion::Command command_in_force(double dt) const noexcept {
        const StrokeValues& values = in_force_.values();
        return {values.lead, values.jerk_time, values.jerk_samples(dt)};
    }

    Oscillation::Settings wanted() const noexcept {
        Oscillation::Settings its = in_force_.stroke(supervision_.part(in_force_.values()), position_);
        if (in_force_.values().learn) supervision_.learning().restrain(its);
        return its;
    }

    StrokeSupervision::Seen seen(const Now& now) noexcept {
        return {now.measurable, now.measured, position_ + offset_.value(), now.pulse};
    }

    void generate(const Now& now, double dt) noexcept {
        const StrokeValues& values = in_force_.values();
        const bool moved = motion_.moves();
        motion_.oscillation().see_axis(
            now.measurable && std::abs(now.measured - motion_.oscillation().position()) <= values.exact_stop);
        motion_.step({now.orders.runs, now.orders.permitted, now.orders.returns, hold(), values.stop()},
                     wanted(), dt, nodes, [&](bool upper, double reversal, double speed) {
                         return values.learn ? supervision_.learning().offset(upper, reversal, speed) : 0;
                     });
        if (moved && !motion_.moves()) rest_at(motion_.leading().mean() - position_);
        watch_homed(now, dt);
        // Where a bound has stopped it, a larger one must not move it later.
        if (!motion_.moves() && offset_.kept_back() && offset_.stands()) rest_ = offset_.value();
        const double target = motion_.moves() ? motion_.leading().position() - position_ : rest_;
        offset_.step(target, !now.on && now.homed, dt);
    }

    Oscillation::Stop hold() noexcept {
        const StrokeValues& values = in_force_.values();
        const bool at_once = emergency_hold, held = feed_hold;
        hold_ordered_ = at_once || held;
        if (at_once || supervision_.recovers()) return Oscillation::Stop::at_once;
        return held || values.override_value == 0 ? values.hold() : Oscillation::Stop::none;
    }

    void rest_at(double place) noexcept { rest_ = std::abs(place) <= nothing ? 0 : place; }

    void watch_homed(const Now& now, double dt) noexcept {
        const double lag = std::abs(now.measured - (position_ + offset_.value()));
        switch (homed_watch_.step(
            {now.homed, now.releasable, std::abs(now.applied) > nothing, now.measurable, lag}, dt)) {
            case HomedWatch::Offset::as_applied: rest_ = offset_.value(); break;
            case HomedWatch::Offset::none: rest_ = 0; break;
            case HomedWatch::Offset::stays: break;
        }
    }

    void supervise(const Now& now, double dt) noexcept {
        const StrokeSupervision::Findings found = supervision_.step(seen(now), motion_, in_force_, dt);
        if (found.fault != Fault::none) faults_.happen(found.fault);
        if (found.stops) motion_.fail();
        if (found.corrected) motion_.oscillation().refresh();
    }

    void show(const Now& now) noexcept {
        offset = offset_.value();
        command = position_ + offset_.value();
        feed_wait = motion_.moves() ? !now.orders.ordered : motion_.failed() && offset_.value() != 0;
        end_position = position_;
        if (now.measurable) measured_position = now.measured;
        stroke.show(motion_, supervision_, in_force_.values());
        at_end = !motion_.moves() && offset_.value() == 0;
        if (!now.homed) standing_off_.end();
        if (now.on) standing_off_.step(position_);
        end_ = position_;
        stands_off = standing_off_.stands();
        program_refused = words_.refused() || faults_.checked() != Fault::none;
        program_sections = static_cast<std::int32_t>(words_.sections());
        dead_points.show(supervision_, in_force_.values());
        const LearnedStrokes& strokes = supervision_.learning().strokes();
        records.show(strokes.size(), [&](std::int32_t i) noexcept { row.show(strokes[i]); });
        report(now);
    }

    void report(const Now& now) noexcept {
        const Oscillation& oscillation = motion_.oscillation();
        const bool runs = motion_.moves();
        const Fault checked = faults_.checked(), happened = faults_.happened(),
                    settings_fault = in_force_.refused(),
                    supervised = supervision_.fault(in_force_.values(), runs && !now.measurable);
        late_ = runs && (late_ || oscillation.late());
        const Bound bound =
            hal::first<Bound>({{offset_.kept_back(), Bound::offset},
                               {runs && stage_limited, Bound::stage},
                               {runs && oscillation.clipped(), Bound::soft_limit},
                               {runs && supervision_.part(in_force_.values()) < 1, Bound::learning},
                               {runs && oscillation.limited(), Bound::speed},
                               {late_, Bound::plan},
                               {runs && oscillation.impatient(), Bound::arrival}});
        limited = bound;
        const Fault its_fault = hal::first<Fault>({{checked != Fault::none, checked},
                                                   {happened != Fault::none, happened},
                                                   {!now.known, Fault::position},
                                                   {settings_fault != Fault::none, settings_fault},
                                                   {offset_.refused(), Fault::bound},
                                                   {supervised != Fault::none, supervised}});
        fault = its_fault;
        show_status(now, its_fault != Fault::none, bound != Bound::none);
    }

    void show_status(const Now& now, bool has_fault, bool bounded) noexcept {
        ChoppingSeen seen;
        seen.fault = has_fault;
        seen.bounded = bounded;
        seen.moves = motion_.moves();
        seen.returns = motion_.state() == StrokeMotion::State::returning;
        seen.ends = motion_.state() == StrokeMotion::State::stopping;
        seen.held = motion_.oscillation().held();
        seen.hold_ordered = hold_ordered_;
        seen.speed_zero = in_force_.values().override_value == 0;
        seen.away = std::abs(offset_.value()) > nothing;
        seen.on = now.on;
        seen.homed = now.homed;
        seen.permitted = now.orders.permitted;
        seen.interlock = status.of_interlock();
        status = status_of(seen);
    }

    StrokeOrders orders_;
    StrokeWords words_;
    StrokeInForce in_force_;
    StrokeMotion motion_;
    StrokeSupervision supervision_;
    StrokeFaults faults_;
    HomedWatch homed_watch_;
    StandingOff standing_off_;
    GuardedOffset offset_;
    double position_ = 0;  // mu, point R: the last good one
    double end_ = 0;       // mu, point R in the period before
    double rest_ = 0;      // mu, the offset at rest
    bool late_ = false;
    bool hold_ordered_ = false;
};

hal::Model hal::model() {
    return model_of<Chopping>();
}

}  // namespace plumb
