// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

struct JointOffset final : hal::Component {
    static constexpr hal::About about{"joint_offset",
                                      "add an offset to a joint of LinuxCNC, between motion and drive",
                                      R"(
Whatever computes offsets of a joint nets them to offset-0 to offset-3.  Their sum is added to what LinuxCNC commands the
drive, and taken from what the drive reports, so that motion knows nothing of it:

    drive-command  = joint-command  + applied-offset
    joint-feedback = drive-feedback - applied-offset of the last drive-command

    applied-offset = the sum, bounded, + r     r = what keeps it from stepping, which goes to 0 by ramp-rate

What motion causes is followed without lag, by max-rate at most.  What motion does not cause is ramped: enable, the joint
becoming homed, the machine turned on.  A source that has a ramp of its own may be on it at the same time; the two add up
then.  No speed or acceleration of the axis is used up, and it works in every mode.

One instance a joint.  Its two functions have motion-controller between them; a drive that reads and writes
hardware reads before the first and writes after the second.  Here for joint 0, with one source:

    net x-homed           joint.0.homed              => x-stage.homed
    net motion-enabled    motion.motion-enabled      => x-stage.motion-enabled
    net x-position-cmd    joint.0.pos-cmd            => x-stage.position
    net x-joint-cmd       joint.0.motor-pos-cmd      => x-stage.joint-command
    net x-motor-fb        x-drive.out                => x-stage.drive-feedback
    net x-offset          source.x-correction        => x-stage.offset-0
    net x-motor-cmd       x-stage.drive-command      => x-drive.in
    net x-joint-fb        x-stage.joint-feedback     => joint.0.motor-pos-fb
    net x-inhibit-homing  x-stage.inhibit-homing     => motion.homing-inhibit

    setp x-stage.min-limit [JOINT_0]MIN_LIMIT
    setp x-stage.max-limit [JOINT_0]MAX_LIMIT

    addf motion-command-handler  servo-thread
    addf x-stage.update-feedback servo-thread
    addf motion-controller       servo-thread
    addf source.update           servo-thread
    addf x-stage.update          servo-thread
    addf x-drive                 servo-thread

Frames: joint-feedback, and all that LinuxCNC shows, limits and probes, is without the offset: it says where the program
has the joint.  The feedback of the drive, and its encoder, is with it.  A component that asks for the position of the
encoder gets the signal at drive-feedback, and applied-offset.  The following error of the joint grows by the speed of
applied-offset times the lag of its drive.

While the machine is off the offset is held, and LinuxCNC takes the feedback over as its position: turning it on moves
nothing.  What the sources have changed meanwhile comes by the ramp then.  While the joint is not homed its offset is
released, by the ramp, and position, whose origin is not known, bounds nothing.

Two joints of one axis, a gantry, get a stage each, and the same offset.

Home with no offset in force.  A homing that takes the place of the joint from the feedback, at a switch or where it
stands, would make what is left of the offset a part of the origin for good, however long it goes on moving afterwards.
So inhibit-homing is true until the offset is released: with more than one stage, net the or of all to
motion.homing-inhibit.  LinuxCNC then refuses to home a joint that is homed and corrected; unhome it, and try again when
its offset is 0.

Where that is not wired, fault 6 tells: the origin has been moved with an offset in force, and the offset stays released
until the joint is unhomed and homed again.  The stage sees the origin as the difference of joint-command and position.
Backlash and screw compensation of LinuxCNC move it, too: a joint that has them, and is moved while its offset is
released, has to be homed again without need.

Motion checks its soft limits without the offset.  So the stage keeps position and offset within min-limit and max-limit:
set them from the INI file.  Where the offset would lead the drive beyond a limit, the drive stops at it, up to the offset's
length before motion does, and limited is true.  A joint that is beyond a limit itself is not taken back.

fault-code:

    1 one of offset-0 to offset-3 is not a number, or beyond 1e3: its last good one stays
    2 joint-command or position is not a number, or beyond 1e9: likewise
    3 drive-feedback likewise: LinuxCNC sees the joint stand, and stops with a following error when it moves
    4 max-offset (0 to 1e3), ramp-rate or max-rate (above 0, to 1e4): the last good set is in force
    5 min-limit is not below max-limit: likewise
    6 the origin was set with an offset in force: unhome, and home again

The defaults are for millimetres; on an inch machine divide max-offset, ramp-rate and max-rate by 25.4.)"};

    using Component::Component;

    hal::In<bool> enable{this, "enable", true, "Apply the offset; else 0."};
    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::Row<hal::In<double>, 4> offset{this, "offset", 0, "mu", "Offset from one of the sources."};
    hal::In<double> position{this, "position", 0, "mu", "Where the program has the joint: joint.N.pos-cmd."};
    hal::In<double> joint_command{this, "joint-command", 0, "mu", "From motion: joint.N.motor-pos-cmd."};
    hal::In<double> drive_feedback{this, "drive-feedback", 0, "mu", "From the drive, offset included."};
    hal::In<double> min_limit{this, "min-limit", -1e99, "mu", "Lower soft limit of the joint."};
    hal::In<double> max_limit{this, "max-limit", 1e99, "mu", "Upper soft limit of the joint."};
    hal::In<double> max_offset{this, "max-offset", 1, "mu", "Largest sum of the offsets either way."};
    hal::In<double> ramp_rate{this, "ramp-rate", 0.1, "mu/s", "Rate of what motion does not cause."};
    hal::In<double> max_rate{this, "max-rate", 1, "mu/s", "Fastest change of the offset, away from limits."};

    hal::Out<double> drive_command{this, "drive-command", "mu", "To the drive, offset included."};
    hal::Out<double> joint_feedback{this, "joint-feedback", "mu",
                                    "To motion, without the offset: joint.N.motor-pos-fb."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu", "Offset that drive-command contains."};
    hal::Out<bool> ramping{this, "ramping", "The offset is on its way to what it is to be."};
    hal::Out<bool> limited{this, "limited",
                           "Max-offset, max-rate or a soft limit keeps the offset from what it is to be."};
    hal::Out<bool> inhibit_homing{this, "inhibit-homing", "An offset is in force: to motion.homing-inhibit."};
    hal::Out<bool> fault{this, "fault", "Something is wrong that fault-code names."};
    hal::Out<std::int32_t> fault_code{this, "fault-code", "What is wrong, as listed above; 0 for nothing."};

    hal::Function un_correct{this, "update-feedback", &JointOffset::update_feedback,
                             "After the drive's feedback is read, before motion-controller."};
    hal::Function run{this, "update", &JointOffset::update,
                      "After motion-controller and the sources, before the drive's command is written."};

    void prepare() override {
        settings_ = {max_offset, ramp_rate, max_rate};
        limits_ = {min_limit, max_limit};
    }

    void update_feedback(double) noexcept {
        const double given = drive_feedback;
        feedback_ = usable(given, farthest, feedback_);
        hears_ = within(given, farthest);
        joint_feedback = feedback_ - applied_;
    }

    void update(double dt) noexcept {
        const Settings settings{max_offset, ramp_rate, max_rate};
        if (settings.valid()) settings_ = settings;
        const Limits limits{min_limit, max_limit};
        if (limits.valid()) limits_ = limits;
        const double place = position, command = joint_command;
        const bool knew_place = knows_place_;
        knows_place_ = within(place, farthest);
        const double last_position = position_;
        position_ = usable(place, farthest, position_);
        const double moved = std::abs(usable(command, farthest, command_) - command_);
        command_ = usable(command, farthest, command_);
        const bool good_sources = read_sources();
        const bool is_homed = homed;
        watch_origin(is_homed, knows_place_ && within(command, farthest));
        const bool active = enable && is_homed && !shifted_;
        const double wanted = active ? sum() : 0;
        const double possible = bounded(wanted, settings_.max_offset);

        start_a_ramp(active, is_homed && !motion_enabled, possible);
        if (!holding_) {
            ramp_ -= bounded(ramp_, settings_.ramp_rate * dt);
            followed_ += bounded(possible + ramp_ - followed_, settings_.max_rate * dt);
            const double allowed = is_homed ? limits_.nearest(followed_, position_) : followed_;
            const double way = allowed - applied_;
            // Motion may take the joint to a limit, or away from it, faster than by max-rate; a limit or a
            // position that changes without it may not.
            double by_motion = 0;
            if (is_homed && knew_place && knows_place_)
                by_motion = bounded(allowed - limits_.nearest(followed_, last_position), moved);
            if (by_motion * way <= 0) by_motion = 0;
            applied_ += bounded(way, settings_.max_rate * dt + std::abs(by_motion));
        }

        drive_command = command_ + applied_;
        applied_offset = applied_;
        ramping = ramp_ != 0;
        inhibit_homing = std::abs(applied_) > slack;
        limited = std::abs(wanted + ramp_ - applied_) > slack && !holding_;
        const std::int32_t code = !good_sources                                            ? 1
                                  : !within(command, farthest) || !within(place, farthest) ? 2
                                  : !hears_                                                ? 3
                                  : !settings.valid()                                      ? 4
                                  : !limits.valid()                                        ? 5
                                  : shifted_                                               ? 6
                                                                                           : 0;
        fault_code = code;
        fault = code != 0;
    }

private:
    static constexpr double largest = 1e3;   // mu, of an offset
    static constexpr double farthest = 1e9;  // mu, of a position
    static constexpr double slack = 1e-9;    // mu, of no meaning

    static bool within(double x, double most) noexcept { return std::abs(x) <= most; }

    struct Settings {
        double max_offset, ramp_rate, max_rate;

        bool valid() const noexcept {
            return max_offset >= 0 && max_offset <= largest && ramp_rate > 0 && ramp_rate <= 1e4 &&
                   max_rate > 0 && max_rate <= 1e4;
        }
    };

    struct Limits {
        double min, max;

        bool valid() const noexcept { return min < max; }
        // The offset next to x that does not lead beyond a limit, or no further beyond.
        double nearest(double x, double place) const noexcept {
            return std::clamp(x, std::fmin(0, min - place), std::fmax(0, max - place));
        }
    };

    bool read_sources() noexcept {
        bool good = true;
        for (std::size_t i = 0; i < sources_.size(); ++i) {
            const double given = offset[i];
            good = good && within(given, largest);
            sources_[i] = usable(given, largest, sources_[i]);
        }
        return good;
    }

    double sum() const noexcept { return sources_[0] + sources_[1] + sources_[2] + sources_[3]; }

    // Homing moves the origin of motion at the switch, long before the joint is homed.  The feedback by which
    // it does so is without the offset; the drive's place, once the offset is released, is off by it.
    void watch_origin(bool is_homed, bool known) noexcept {
        const double origin = known ? command_ - position_ : origin_;
        if (homed_ && !is_homed) shifted_ = false;
        const bool homes = !homed_ || !is_homed;
        if (homes && std::abs(applied_) > slack && std::abs(origin - origin_) > slack) shifted_ = true;
        origin_ = origin;
        homed_ = is_homed;
    }

    // From the offset there is, whatever has been wanted before.
    void start_a_ramp(bool active, bool holding, double possible) noexcept {
        if (active != active_ || (holding_ && !holding)) {
            followed_ = applied_;
            ramp_ = applied_ - possible;
        }
        active_ = active;
        holding_ = holding;
    }

    Settings settings_{};                               // the last good ones
    Limits limits_{};                                   // likewise
    std::array<double, 4> sources_{};                   // likewise
    double position_ = 0, command_ = 0, feedback_ = 0;  // likewise
    double ramp_ = 0;                                   // what keeps the offset from stepping
    double followed_ = 0;                               // the offset, but for the soft limits
    double applied_ = 0;                                // by the last command
    bool active_ = false, holding_ = false;
    double origin_ = 0;                     // of motion, for the drive
    bool homed_ = false, shifted_ = false;  // shifted: fault 6
    bool hears_ = true, knows_place_ = true;
};

hal::Model hal::model() {
    return model_of<JointOffset>();
}

}  // namespace plumb
