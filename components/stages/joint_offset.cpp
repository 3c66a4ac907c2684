// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/live_counter.hpp"
#include "components/math/blocks/offset_release.hpp"
#include "components/math/blocks/soft_limits.hpp"
#include "components/math/blocks/source_sum.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"
#include "pages/joint_offset.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

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
            return "One of offset-0 to offset-3 is invalid or beyond 1000; its last good value is used.";
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
            return "The heartbeat stands still: interlock is not loaded, not called, or has found a wrong "
                   "order "
                   "of functions; the offset is held.";
        case Fault::bound:
            return "The max-offset is below the present offset; the last good one stays in force until the "
                   "offset is within the new one.";
        case Fault::unhomed:
            return "The joint is not homed while a stroke is out; the offset is held. Turn the machine off "
                   "and "
                   "on, and home the joint.";
        case Fault::unreleased:
            return "A source with release-at-off is not 0 although the machine was off: net released to its "
                   "component; the source has no effect until it is 0.";
        default: return nullptr;
    }
}

struct JointOffset final : hal::Component {
    static constexpr hal::About about{
        "joint_offset", "adds an offset to a joint of LinuxCNC, between motion and drive", page};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> enable{this, "enable", true, "Apply the offset; else 0."};
    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<std::int32_t> heartbeat{this, "heartbeat", -1,
                                    "Of interlock, which permits changes of the offset; -1 without one."};
    hal::Row<hal::In<double>, 4> offset{this, "offset", 0, "mu", "Offset from one of the sources."};
    hal::Row<hal::In<bool>, 4> release_at_off{
        this, "release-at-off", false,
        "Machine off makes the offset of this source part of the position of the joint: for a stroke."};
    hal::In<double> position{this, "position", 0, "mu", "Commanded position of the joint: joint.N.pos-cmd."};
    hal::In<double> joint_command{this, "joint-command", 0, "mu", "From motion: joint.N.motor-pos-cmd."};
    hal::In<double> joint_velocity{this, "joint-velocity", 0, "mu/s", "From motion: joint.N.vel-cmd."};
    hal::In<double> drive_feedback{this, "drive-feedback", 0, "mu", "From the drive, offset included."};
    hal::In<double> min_limit{this, "min-limit", 0, "mu", "Lower soft limit of the joint."};
    hal::In<double> max_limit{this, "max-limit", 0, "mu", "Upper soft limit of the joint."};
    hal::In<double> joint_acceleration{this, "joint-acceleration", 0, "mu/s2",
                                       "Largest acceleration of the joint by motion."};
    hal::In<double> offset_acceleration{this, "offset-acceleration", 0, "mu/s2",
                                        "Largest acceleration that the offset adds to it."};
    static constexpr hal::Range offsets{0, 1000}, rates{1e-6, 1e4};
    hal::In<double> max_offset{this,   "max-offset", 1, "mu", "Largest sum of the offsets either way.",
                               offsets};
    hal::In<double> ramp_rate{this, "ramp-rate", 0.1, "mu/s", "Rate of changes that motion does not cause.",
                              rates};
    hal::In<double> max_rate{this, "max-rate", 1, "mu/s", "Fastest change of the offset, away from limits.",
                             rates};

    hal::Out<double> drive_command{this, "drive-command", "mu", "To the drive, offset included."};
    hal::Out<double> drive_velocity{
        this, "drive-velocity", "mu/s",
        "Joint-velocity and the velocity of the offset: to pid.N.command-deriv of the drive."};
    hal::Out<double> joint_feedback{this, "joint-feedback", "mu",
                                    "To motion, without the offset: joint.N.motor-pos-fb."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu", "Offset that drive-command contains."};
    hal::Out<bool> ramping{this, "ramping", "The offset moves to its sources at ramp-rate."};
    hal::Out<bool> limited{
        this, "limited", "Max-offset, a rate or a soft limit keeps the offset from the sum of its sources."};
    hal::Out<bool> inhibit_homing{this, "inhibit-homing", "An offset is in force: to motion.homing-inhibit."};
    hal::Out<std::int32_t> released{
        this, "released",
        "1 from the release of the sources with release-at-off until the machine is "
        "on, else 0; -1 without such a source."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Offset moves{this, hal::MovingPin(applied_offset)
                                .bound(max_offset)
                                .rate(max_rate)
                                .limited(limited)
                                .acceleration(offset_acceleration)
                                .motion(joint_command, 1)};

    hal::Function un_correct{this, "update-feedback", &JointOffset::update_feedback, hal::Place::feedback,
                             "After the drive's feedback is read."};
    hal::Function run{this, "update", &JointOffset::update, hal::Place::stage,
                      "Before the drive's command is written."};

    void prepare() override { settings_ = {max_offset, ramp_rate, max_rate}; }

    void update_feedback(double) noexcept {
        const double given = drive_feedback;
        feedback_ = usable(given, farthest, feedback_);
        good_feedback_ = within(given, farthest);
        joint_feedback = feedback_ - release_.in_feedback(applied_.value());
        show_release();
    }

    void update(double dt) noexcept {
        hal::SettingsReader setting;
        const Settings settings{setting(max_offset), setting(ramp_rate), setting(max_rate)};
        const bool refused = setting.good() && !take(settings, dt);
        const SoftLimits limits{min_limit, max_limit, joint_acceleration, offset_acceleration};
        if (limits.valid()) take(limits, dt);
        const double command = joint_command;
        const double moved = std::abs(usable(command, farthest, command_) - command_);
        command_ = usable(command, farthest, command_);
        const bool jumped = !read_position();
        const bool good_sources = sources_.read(offset, largest);
        const bool is_homed = homed;
        watch_origin(is_homed, knows_place_ && within(command, farthest));
        interlock_.step(heartbeat);
        const bool permitted = interlock_.alive();
        const bool active = enable && is_homed && !shifted_ && limits_.valid(), on = motion_enabled;
        const auto sums = release_.sum(sources_, read_release());
        const double wanted = !permitted ? source_.value() : active ? sums.all : 0;
        const double possible = bounded(wanted, settings_.max_offset);

        if (release_.step(on)) move_to(release_.stays(), dt);
        const bool stranded = on && release_.out() && (!is_homed || shifted_);
        const bool holding = (is_homed && !on) || release_.pending() || stranded;
        if (active != active_ || (holding_ && !holding) || (!permitted_ && permitted)) ramping_ = true;
        active_ = active;
        permitted_ = permitted;
        holding_ = holding;
        const double before = applied_.value();
        if (holding)
            hold();
        else
            follow(possible, is_homed && limits_.valid(), jumped ? 0 : moved, dt);
        const bool follows = permitted && active && !ramping_ && applied_.value() == sums.all;
        if (!holding) release_.note(applied_.value(), bounded(sums.others, settings_.max_offset), follows);

        drive_command = command_ + applied_.value();
        const double velocity = joint_velocity;
        drive_velocity = (within(velocity, farthest) ? velocity : 0) + (applied_.value() - before) / dt;
        applied_offset = applied_.value();
        ramping = ramping_;
        inhibit_homing = std::abs(applied_.value()) > slack;
        show_release();
        limited = !holding && (release_.ignores() || wanted != possible || tapered_ ||
                               (!ramping_ && lag(possible) > slack));
        fault = hal::first<Fault>({{interlock_.missed(), Fault::interlock},
                                   {!good_sources, Fault::source},
                                   {!within(command, farthest) || !knows_place_, Fault::position},
                                   {!good_feedback_, Fault::feedback},
                                   {!setting.good(), Fault::settings},
                                   {refused, Fault::bound},
                                   {!limits.valid(), Fault::limits},
                                   {shifted_, Fault::origin},
                                   {stranded, Fault::unhomed},
                                   {on && release_.ignores(), Fault::unreleased}});
    }

private:
    static constexpr double largest = 1e3;                    // mu, of an offset
    static constexpr double farthest = SoftLimits::farthest;  // mu, of a position
    static constexpr double slack = 1e-9;                     // mu, without meaning
    static constexpr double gentle = 100;                     // mu/s2, without valid limits
    static constexpr double quarter = 0.25;  // of the acceleration, for sources, beside a taper

    static bool within(double x, double most) noexcept { return std::abs(x) <= most; }

    struct Settings {
        double max_offset, ramp_rate, max_rate;
    };

    // False if max-offset is too small for the present offset; the last one stays in force.
    bool take(const Settings& given, double dt) noexcept {
        const double most = settings_.max_offset;
        settings_ = given;
        if (given.max_offset >= most || stops_within(given.max_offset, acceleration(), dt)) return true;
        settings_.max_offset = most;
        return false;
    }

    // A smaller offset-acceleration waits until the offset can stop within max-offset by it.
    void take(const SoftLimits& given, double dt) noexcept {
        const double before = limits_.offset_acceleration;
        limits_ = given;
        if (given.offset_acceleration < before &&
            !stops_within(settings_.max_offset, given.offset_acceleration, dt))
            limits_.offset_acceleration = before;
    }

    bool stops_within(double bound, double acceleration, double dt) const noexcept {
        return source_.stops_within(bound, acceleration * source_share(), dt) &&
               applied_.stops_within(bound, acceleration, dt);
    }

    // Whether the distance from the last position to this one can be a move of the joint.
    bool read_position() noexcept {
        const double place = position;
        const bool knew = knows_place_;
        knows_place_ = within(place, farthest);
        last_position_ = position_;
        position_ = usable(place, farthest, position_);
        return knew && knows_place_;
    }

    // Homing moves the origin of motion at the switch, long before the joint is homed, and by a feedback
    // without the offset. Once the offset is released, the origin would be wrong by it.
    void watch_origin(bool is_homed, bool known) noexcept {
        const double origin = known ? command_ - position_ : origin_;
        if (homed_ && !is_homed) shifted_ = false;
        const bool homes = !homed_ || !is_homed;
        if (homes && std::abs(applied_.value()) > slack && std::abs(origin - origin_) > slack)
            shifted_ = true;
        origin_ = origin;
        homed_ = is_homed;
    }

    OffsetRelease<4>::Which read_release() noexcept {
        OffsetRelease<4>::Which which{};
        for (std::size_t i = 0; i < which.size(); ++i) which[i] = release_at_off[i];
        return which;
    }

    void show_release() noexcept { released = !release_.any() ? -1 : release_.released() ? 1 : 0; }

    // In drive-command motion has the rest of it.
    void move_to(double place, double dt) noexcept {
        source_.move_to(place, acceleration(), dt);
        applied_.move_to(place, acceleration(), dt);
        hold();
    }

    void hold() noexcept {
        source_.hold();
        applied_.hold();
    }

    // The sources, then the soft limits, then the drive. `moved` is the distance that motion moves the joint
    // in this period.
    void follow(double possible, bool guarded, double moved, double dt) noexcept {
        const double most = settings_.max_offset, rate = settings_.max_rate;
        const double acceleration = this->acceleration();
        if (guarded_ && !guarded) {  // the rest of the sum must not come at once
            source_.move_to(applied_.value(), acceleration, dt);
            source_.hold();
        }
        guarded_ = guarded;
        const double source = source_.value(), applied = applied_.value();
        const SoftLimits::Step joint{last_position_, position_, moved, dt};
        share_out(guarded && (limits_.tapers(std::max(source, possible), joint) ||
                              limits_.tapers(std::min(source, possible), joint)),
                  acceleration, dt);
        AccelerationLimit::Limits speeds{
            ramping_ ? settings_.ramp_rate : rate, rate, acceleration * source_share(), rate, rate, most};
        if (guarded) {
            speeds.down = limits_.largest_speed(-1, source, joint);
            speeds.up = limits_.largest_speed(1, source, joint);
        }
        source_.step(possible, speeds, dt);
        const bool held = (possible > source ? speeds.up : speeds.down) * dt <= slack;  // by a soft limit
        ramping_ = ramping_ && source_.value() != possible && !held;

        const double now = source_.value();
        const double allowed = guarded ? limits_.allowed(now, position_) : now;
        tapered_ = allowed != now;
        // At most share(), so that the offset brakes in time when motion does.
        const double by_motion = guarded ? std::min(std::abs(allowed - limits_.allowed(now, last_position_)),
                                                    limits_.share() * moved)
                                         : 0;
        const double fastest = rate + by_motion / dt;
        applied_.step(allowed, {rate, fastest, acceleration, fastest, fastest, most}, dt);
        if (!guarded) return;
        const double within = limits_.largest_offset(applied_.value(), applied, joint);
        if (std::abs(applied_.value()) > within)
            applied_.move_to(std::copysign(within, applied_.value()), acceleration, dt);
    }

    // While the taper may act, it needs all of the acceleration but a quarter. The sources have all of it
    // elsewhere; they give it back when they do not need it to stop within max-offset.
    void share_out(bool tapers, double acceleration, double dt) noexcept {
        const double rest = acceleration * quarter;
        if (!tapers)
            shares_ = false;
        else if (source_.settled(rest, dt) && source_.stops_within(settings_.max_offset, rest, dt))
            shares_ = true;
    }

    double acceleration() const noexcept { return limits_.valid() ? limits_.offset_acceleration : gentle; }
    double source_share() const noexcept { return shares_ ? quarter : 1; }

    double lag(double possible) const noexcept { return std::abs(possible - applied_.value()); }

    Settings settings_{};  // these are the last good values
    SoftLimits limits_{};
    SourceSum<4> sources_;
    double position_ = 0, command_ = 0, feedback_ = 0;

    double last_position_ = 0;
    AccelerationLimit source_;   // the sum, bounded and ramped
    AccelerationLimit applied_;  // source_ within the soft limits; the last command contains it
    OffsetRelease<4> release_;
    LiveCounter interlock_;
    bool active_ = false, holding_ = false, ramping_ = false, permitted_ = true;
    bool guarded_ = false, tapered_ = false;  // by the soft limits
    bool shares_ = true;                      // the acceleration, with the taper
    double origin_ = 0;                       // command_ - position_
    bool homed_ = false, shifted_ = false;    // shifted: fault origin
    bool good_feedback_ = true, knows_place_ = true;
};

hal::Model hal::model() {
    return model_of<JointOffset>();
}

}  // namespace plumb
