// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/stages/joint_offset/offset_release.hpp"
#include "components/stages/joint_offset/tapered_offset.hpp"
#include "components/stages/stage_permit.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "hal/option.hpp"
#include "pages/joint_offset.page.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    source,
    position,
    feedback,
    settings,
    limits,
    origin,
    interlock,
    bound,
    unhomed,
    unreleased
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::source:
            return "One of offset-0 to offset-3, or trial, is invalid or beyond 1000; its last good value is "
                   "used.";
        case Fault::position:
            return "The joint-command or position is invalid or beyond 1e9; its last good value is used.";
        case Fault::feedback:
            return "The drive-feedback is invalid or beyond 1e9; LinuxCNC sees the joint stand, and stops "
                   "with a following error when it moves.";
        case Fault::settings:
            return "The max-offset, ramp-rate or max-rate is out of its range; the last good set stays in "
                   "force.";
        case Fault::limits:
            return "A limit is not set or out of range: min-limit below max-limit (both to 1e9), "
                   "joint-acceleration or offset-acceleration (0.001 to 1e9); the last good set stays in "
                   "force, and without one no offset is applied.";
        case Fault::origin:
            return "The origin was set with an offset in force; unhome the joint and home it again.";
        case Fault::interlock:
            return "No permit comes from interlock, so the offset is held: net stage-permit of interlock to "
                   "permit, and run plumb doctor --running.";
        case Fault::bound:
            return "The max-offset is below the present offset; the last good one stays in force until the "
                   "offset is within the new one.";
        case Fault::unhomed:
            return "The joint is not homed while a stroke is in force; the offset stays. Turn the machine off and "
                   "on, and home the joint.";
        case Fault::unreleased:
            return "A source with release-at-off is not 0 although the machine was off: net released to its "
                   "component; the source has no effect until it is 0.";
        default: return nullptr;
    }
}

enum class JointOffsetStatus : std::int32_t { applies = hal::first_own, limited, ramping, nothing };

constexpr hal::Said said(JointOffsetStatus status) {
    using hal::Kind;
    switch (status) {
        case JointOffsetStatus::applies: return {Kind::good, "The joint has the offset of its sources."};
        case JointOffsetStatus::limited:
            return hal::Said{Kind::warn, "The joint does not have all of its offset.",
                             "Move the joint away from its soft limit, or raise its largest offset or rate."}
                .told(hal::Tell::text);
        case JointOffsetStatus::ramping:
            return {Kind::wait, "The joint moves to its offset.", "Wait for the end of the move."};
        case JointOffsetStatus::nothing: return {Kind::off, "No source asks for an offset."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
    }
}

struct JointOffset final : hal::Component {
    static constexpr hal::About about{
        "joint_offset", "adds an offset to a joint of LinuxCNC, between motion and drive", page};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::Option<std::string> interlock{this, "interlock", "yes", StagePermit::about, {"no"}};
    StagePermit permit{this, interlock, false};
    SourceRow offset{this, "offset", 0, "mu", "Offset from one of the sources."};
    hal::Row<hal::In<bool>, 4> release_at_off{
        this, "release-at-off", false,
        "Machine off makes the offset of this source part of the position of the joint: for a stroke.",
        hal::machine()};
    hal::In<double> position{this, "position", 0, "mu", "Commanded position of the joint: joint.N.pos-cmd."};
    hal::In<double> joint_command{this, "joint-command", 0, "mu",
                                  "Command of motion for the drive: joint.N.motor-pos-cmd."};
    hal::In<double> joint_velocity{this, "joint-velocity", 0, "mu/s",
                                   "Commanded velocity of the joint: joint.N.vel-cmd."};
    hal::In<double> drive_feedback{this, "drive-feedback", 0, "mu",
                                   "Feedback of the drive, with the offset in it."};
    static constexpr hal::Range places{-SoftLimits::farthest, SoftLimits::farthest}, offsets{0, 1000},
        rates{1e-6, 1e4}, accelerations{0, SoftLimits::hardest};
    hal::In<double> min_limit{
        this, "min-limit", 0, "mu", "Lower soft limit of the joint.", hal::must(places)};
    hal::In<double> max_limit{
        this, "max-limit", 0, "mu", "Upper soft limit of the joint.", hal::must(places)};
    hal::In<double> joint_acceleration{
        this,
        "joint-acceleration",
        0,
        "mu/s2",
        "Maximum acceleration of the joint without the offset: [JOINT_N]MAX_ACCELERATION.",
        hal::must(accelerations)};
    hal::In<double> offset_acceleration{this,
                                        "offset-acceleration",
                                        0,
                                        "mu/s2",
                                        "Maximum acceleration that the offset adds to the joint.",
                                        hal::must(accelerations)};
    hal::In<double> max_offset{
        this, "max-offset", 1, "mu", "Maximum sum of the offsets, in either direction.", hal::must(offsets)};
    hal::In<double> ramp_rate{
        this, "ramp-rate", 0.1, "mu/s", "Rate of changes that motion does not cause.", hal::machine(rates)};
    hal::In<double> max_rate{this,
                             "max-rate",
                             1,
                             "mu/s",
                             "Maximum rate of change of the offset, away from soft limits.",
                             hal::must(rates)};

    hal::Out<double> drive_command{this, "drive-command", "mu",
                                   "Command to the drive, with the offset in it."};
    hal::Out<double> drive_velocity{
        this, "drive-velocity", "mu/s",
        "Sum of joint-velocity and the velocity of the offset: to pid.N.command-deriv of the drive."};
    hal::Out<double> joint_feedback{this, "joint-feedback", "mu",
                                    "Feedback without the offset: to joint.N.motor-pos-fb."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu", "Offset that drive-command contains."};
    hal::Out<bool> ramping{this, "ramping", "The offset is moving to the sum of its sources at ramp-rate."};
    hal::Out<bool> limited{this, "limited", "Max-offset, a rate or a soft limit prevents the full offset."};
    hal::Out<bool> inhibit_homing{this, "inhibit-homing", "An offset is in force: to motion.homing-inhibit."};
    hal::Out<std::int32_t> released{this, "released",
                                    "1 after the release of a source with release-at-off, until the machine "
                                    "is on; then 0. -1: no source has release-at-off."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::ComponentStatus<JointOffsetStatus> status{this};

    hal::Offset moves{this, hal::MovingPin(applied_offset)
                                .bound(max_offset)
                                .rate(max_rate)
                                .limited(limited)
                                .acceleration(offset_acceleration)
                                .motion(joint_command, 1)};

    hal::Effects at_once{
        this, hal::Effect::at_once, offset, min_limit, max_limit, joint_acceleration, offset_acceleration};
    hal::Effects in_no_cycle{this, hal::Effect::in_no_cycle, release_at_off};

    hal::Function un_correct{this, "update-feedback", &JointOffset::update_feedback, hal::Place::feedback,
                             "After the drive's feedback is read."};
    hal::Function run{this, "update", &JointOffset::update, hal::Place::stage,
                      "Before the drive's command is written."};

    void prepare() override { applied_ = TaperedOffset({max_offset, ramp_rate, max_rate}); }

    void update_feedback(double) noexcept {
        const double given = drive_feedback;
        feedback_ = usable(given, farthest, feedback_);
        good_feedback_ = within(given, farthest);
        joint_feedback = feedback_ - release_.in_feedback(applied_.value());
        show_release();
    }

    void update(double dt) noexcept {
        hal::SettingsReader setting;
        const TaperedOffset::Settings settings{setting(max_offset), setting(ramp_rate), setting(max_rate)};
        const bool refused = setting.good() && !applied_.take(settings, dt);
        const SoftLimits limits{min_limit, max_limit, joint_acceleration, offset_acceleration};
        if (limits.valid()) applied_.take(limits, dt);
        const double command = joint_command;
        const double moved = std::abs(usable(command, farthest, command_) - command_);
        command_ = usable(command, farthest, command_);
        const bool jumped = !read_position();
        const Permit now = permit.step();
        if (source_ == 0 && now.source != 0 && !active_) sources_.clear();  // a trial begins
        const std::size_t only = now.source, last = source_;
        const double others = sources_.without(last);
        const bool good_sources = sources_.read(offset, now);
        const bool returns =
            last != only && std::abs(sources_.without(last) - others) > slack;  // to other sources
        source_ = now.source;
        const bool is_homed = homed, knows_origin = knows_place_ && within(command, farthest);
        origin_.step(is_homed, knows_origin ? command_ - position_ : origin_.last(), in_force(), slack);
        const bool permitted = permit.alive() && !now.hold, wrong_origin = origin_.wrong();
        const bool is_enabled = now.enable, on = motion_enabled;
        const auto sums = release_.sum(sources_, read_release());
        const bool stroking = on && release_.out();  // its source brakes a stroke, which may not stop dead
        const bool based = (is_homed && !wrong_origin) || (stroking && !is_homed);
        const bool active = is_enabled && based && applied_.knows_limits();
        const double wanted = !permitted ? applied_.sum() : active ? sums.all : 0;
        const double possible = bounded(wanted, applied_.settings().max_offset);

        if (release_.step(on)) applied_.move_to(release_.stays(), dt);
        const bool holding = (is_homed && !on) || release_.pending() || (stroking && wrong_origin);
        if (returns || active != active_ || (holding_ && !holding) || (!permitted_ && permitted))
            applied_.ramp();
        active_ = active;
        permitted_ = permitted;
        holding_ = holding;
        const double before = applied_.value();
        const bool guarded = (is_homed || stroking) && applied_.knows_limits();
        if (holding)
            applied_.hold();
        else
            applied_.follow(possible, {last_position_, position_, jumped ? 0 : moved, guarded}, dt);
        const bool follows = permitted && active && !applied_.ramping() && applied_.value() == sums.all;
        if (!holding)
            release_.note(applied_.value(), bounded(sums.others, applied_.settings().max_offset), follows);

        drive_command = command_ + applied_.value();
        const double velocity = joint_velocity;
        drive_velocity = (within(velocity, farthest) ? velocity : 0) + (applied_.value() - before) / dt;
        applied_offset = applied_.value();
        const bool ramps = applied_.ramping(), forces = in_force();
        ramping = ramps;
        inhibit_homing = forces;
        show_release();
        const bool falls_short =
            !holding && (release_.ignores() || wanted != possible || applied_.falls_short(possible));
        limited = falls_short;
        const Fault found = hal::first<Fault>({{permit.missed(), Fault::interlock},
                                               {!good_sources, Fault::source},
                                               {!within(command, farthest) || !knows_place_, Fault::position},
                                               {!good_feedback_, Fault::feedback},
                                               {!setting.good(), Fault::settings},
                                               {refused, Fault::bound},
                                               {!limits.valid(), Fault::limits},
                                               {wrong_origin, Fault::origin},
                                               {stroking && (!is_homed || wrong_origin), Fault::unhomed},
                                               {on && release_.ignores(), Fault::unreleased}});
        fault = found;
        using S = JointOffsetStatus;
        status = hal::first<S>({{found != Fault::none, hal::common<S>(hal::Common::fault)},
                                {!is_enabled, hal::common<S>(hal::Common::off)},
                                {!on, hal::common<S>(hal::Common::machine_off)},
                                {!is_homed, hal::common<S>(hal::Common::not_homed)},
                                {falls_short, S::limited},
                                {ramps, S::ramping},
                                {sums.all == 0 && !forces, S::nothing},
                                {true, S::applies}});
        permit.report({forces, ramps, false, false, found != Fault::none, falls_short});
    }

private:
    static constexpr double farthest = SoftLimits::farthest;  // mu, of a position
    static constexpr double slack = TaperedOffset::slack;

    using Release = OffsetRelease<SourceSum::number>;

    static bool within(double x, double most) noexcept { return std::abs(x) <= most; }

    bool in_force() const noexcept { return std::abs(applied_.value()) > slack; }

    // Whether the distance from the last position to this one can be a move of the joint.
    bool read_position() noexcept {
        const double place = position;
        const bool knew = knows_place_;
        knows_place_ = within(place, farthest);
        last_position_ = position_;
        position_ = usable(place, farthest, position_);
        return knew && knows_place_;
    }

    Release::Which read_release() noexcept {
        Release::Which which{};  // never a trial
        std::size_t i = 0;
        for (const auto& pin : release_at_off) which[i++] = pin;
        return which;
    }

    void show_release() noexcept { released = !release_.any() ? -1 : release_.released() ? 1 : 0; }

    TaperedOffset applied_{{}};  // the last command contains it
    SourceSum sources_;
    Release release_;
    JointOrigin origin_;
    std::uint32_t source_ = 0;                                              // that alone acts, from 1
    double position_ = 0, last_position_ = 0, command_ = 0, feedback_ = 0;  // the last good values
    bool active_ = false, holding_ = false, permitted_ = true;
    bool good_feedback_ = true, knows_place_ = true;
};

hal::Model hal::model() {
    return model_of<JointOffset>();
}

}  // namespace plumb
