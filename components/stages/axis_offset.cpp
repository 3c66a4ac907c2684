// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/offset_counter.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t { none, offset, report, settings, lost, counts, homed };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::offset: return "The offset is invalid or beyond 1000; its last good value is used.";
        case Fault::report:
            return "LinuxCNC's offset-request or offset-in-force is invalid or beyond 1000; the offset is "
                   "held.";
        case Fault::settings:
            return "A setting is out of range: scale (1e-7 to 0.1), max-offset (0 to 1000) or max-rate (0 to "
                   "10); the last good set stays in force.";
        case Fault::lost:
            return "LinuxCNC does not take the counts: a pin is not wired, or something else clears or "
                   "disables the offsets of this axis; arm again.";
        case Fault::counts: return "The counts exceed 32 bits; load the module again.";
        case Fault::homed:
            return "The machine was homed with an offset in force; turn it off and on, or clear, and home "
                   "again.";
        default: return nullptr;
    }
}

struct AxisOffset final : hal::Component {
    static constexpr hal::About about{"axis_offset",
                                      "brings an offset into an axis of LinuxCNC by external offsets",
                                      R"(
axis_offset applies an offset to an axis by LinuxCNC's external offsets. The offset shows in the DRO. It uses
OFFSET_AV_RATIO of the speed and acceleration of the axis; planned moves keep the rest. Nothing moves before a cycle
start arms the stage. Use one instance for each axis.

The output follows offset at max-rate, within max-offset:

    counts += round((output - offset-request) / scale))",
                                      hal::Wiring{R"(
  loadrt axis_offset names=z-stage

  net z-offset        thermal.z-offset        => z-stage.offset
  net motion-enabled  motion.motion-enabled   => z-stage.motion-enabled
  net all-homed       motion.is-all-homed     => z-stage.all-homed
  net motion-type     motion.motion-type      => z-stage.motion-type
  net offset-limited  motion.eoffset-limited  => z-stage.offset-limited
  net z-request       axis.z.eoffset-request  => z-stage.offset-request
  net z-in-force      axis.z.eoffset          => z-stage.offset-in-force
  net z-counts        z-stage.counts          => axis.z.eoffset-counts
  net z-counts-scale  z-stage.counts-scale    => axis.z.eoffset-scale
  net z-offset-enable z-stage.offset-enable   => axis.z.eoffset-enable
  net z-offset-clear  z-stage.offset-clear    => axis.z.eoffset-clear
  net cycle-start     motion.digital-out-00   => z-stage.arm
  net probing-refused z-stage.probing-refused => motion.feed-inhibit
  net probing-refused                         => halui.abort
  net applied-offset  z-stage.applied-offset  => thermal.applied-offset

  addf motion-command-handler servo-thread
  addf motion-controller      servo-thread
  addf thermal.update         servo-thread
  addf z-stage.update         servo-thread

Through this stage LinuxCNC's feedback contains the offset: joint.N.motor-pos-fb. A component that needs the
position of the program subtracts applied-offset from it.)"},
                                      hal::SettingUp{R"(
1. Write OFFSET_AV_RATIO = 0.2 into the section [AXIS_Z] of the INI file.
2. Let the program set M64 P0 when a cycle starts. This arms the stage.
3. Let a program that needs the offset wait with M66 until uncompensated is false, after it has armed the stage.
4. Keep programs away from the soft limits by max-offset.
5. On an inch machine divide scale, max-offset and max-rate by 25.4.)"},
                                      hal::Behaviour{R"(
- Start: No offset. The first rising edge of arm, with the machine on and homed, arms the stage.
- Machine off, emergency stop: The stage is disarmed. Nothing moves. When the machine is turned on, LinuxCNC forgets the
offset and the displayed position changes; uncompensated is true. The next cycle start applies the offset again.
- Abort: The offset holds.
- enable false: An armed stage takes the offset back at max-rate.
- clear: Takes the offset back, armed or not, and disarms. LinuxCNC then clears the rest.
- Probing (G38): The offset holds while a probing move runs. A move that begins with an offset in force is refused:
probing-refused holds and aborts it. Results such as #5063 contain the offset. If allow-probing is true, subtract it.
- Touch-off (G10 L20): Correct while uncompensated is false. Otherwise the offset is added to the new origin a
second time.
- Homing: Take the offset back first. If the joints become homed with an offset in force, the offset stays and the stage
cannot be armed (see FAULTS).
- Soft limit: LinuxCNC holds the axis there, and limited is true. The offset comes back when the axis leaves the limit.
- Joint mode: The output waits until LinuxCNC applies offsets again.
- Invalid offset: The last good value stays.)"},
                                      hal::Limits{R"(
External offsets do not work in joint mode. They take a part of the speed and acceleration of the axis all the time.

At a soft limit LinuxCNC stops axis and offset abruptly. The stage cannot brake before it.

joint_offset(9) works in every mode and costs no speed, but you must wire it between motion and drive.)"},
                                      hal::SeeAlso{"thermal_displacement(9), joint_offset(9), motion(9)"}};

    using Component::Component;

    hal::In<bool> enable{this, "enable", true, "Apply the offset; else 0."};
    hal::In<double> offset{this, "offset", 0, "mu", "Offset that the axis is to have."};
    hal::In<bool> arm{this, "arm", false, "A cycle starts, when it rises."};
    hal::In<bool> clear{this, "clear", false, "Take the offset back, and disarm."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "As in LinuxCNC: 5 is probing."};
    hal::In<double> offset_request{this, "offset-request", 0, "mu", "Offset that LinuxCNC is asked for."};
    hal::In<double> offset_in_force{this, "offset-in-force", 0, "mu", "Offset that LinuxCNC applies."};
    hal::In<bool> offset_limited{this, "offset-limited", false, "LinuxCNC holds an axis at a soft limit."};
    hal::In<bool> allow_probing{this, "allow-probing", false, "Probing results may contain the offset."};
    hal::In<double> scale{this, "scale", 0.0001, "mu", "Offset of one count."};
    hal::In<double> max_offset{this, "max-offset", 0.15, "mu", "Largest offset either way."};
    hal::In<double> max_rate{this, "max-rate", 0.1, "mu/s", "Fastest change of the offset."};

    hal::Out<std::int32_t> counts{this, "counts", "Counts of LinuxCNC's external offset."};
    hal::Out<double> counts_scale{this, "counts-scale", "mu", "Offset of one count, for LinuxCNC."};
    hal::Out<bool> offset_enable{this, "offset-enable", "LinuxCNC is to listen to the counts."};
    hal::Out<bool> offset_clear{this, "offset-clear", "LinuxCNC is to clear what is left of the offset."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu", "Offset that the axis has."};
    hal::Out<bool> armed{this, "armed", "The offset follows its source."};
    hal::Out<bool> limited{this, "limited",
                           "A soft limit or max-offset keeps the offset from what it is to be."};
    hal::Out<bool> uncompensated{this, "uncompensated", "An offset that is to be applied is not in force."};
    hal::Out<bool> probing_refused{this, "probing-refused", "Probing has begun with an offset in force."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Offset moves{this, hal::MovingPin(counts, counts_scale, offset_request)
                                .bound(max_offset)
                                .rate(max_rate)
                                .limited(limited)};

    hal::Function run{this, "update", &AxisOffset::update,
                      "After motion-controller and the source of offset."};

    void prepare() override { settings_ = {scale, max_offset, max_rate}; }

    void update(double dt) noexcept {
        const Settings given{scale, max_offset, max_rate};
        if (given.valid()) settings_ = given;
        const double wish = offset, request = offset_request, force = offset_in_force;
        const bool hears = within(request, largest) && within(force, largest);
        wish_ = usable(wish, largest, wish_);
        request_ = hears ? request : request_;
        force_ = hears ? force : force_;
        const bool on = motion_enabled, taking_back = clear;
        const double wanted = enable ? wish_ : 0;
        const double possible = bounded(wanted, settings_.max_offset);

        watch_homing();
        watch_probing();
        judge_readiness(on, taking_back);
        if (working_ && hears && !probing_) follow(taking_back ? 0 : possible, dt);

        counts = counter_.counts();
        counts_scale = settings_.scale;
        offset_enable = true;
        offset_clear = taking_back && !in_force() && std::abs(request_) <= settings_.scale / 2;
        applied_offset = force_;
        armed = armed_;
        limited = offset_limited || wanted != possible;
        uncompensated = std::abs(wanted - (on ? force_ : 0)) > slack();
        probing_refused = refused_;
        fault = hal::first<Fault>({{!within(wish, largest), Fault::offset},
                                   {!hears, Fault::report},
                                   {!given.valid(), Fault::settings},
                                   {lost_, Fault::lost},
                                   {counter_.used_up(), Fault::counts},
                                   {shifted_, Fault::homed}});
    }

private:
    static constexpr double largest = 1e3;       // mu
    static constexpr double follow_time = 0.01;  // s
    static constexpr std::int32_t probe = 5;     // motion-type

    static bool within(double x, double most) noexcept { return std::abs(x) <= most; }

    struct Settings {
        double scale, max_offset, max_rate;

        bool valid() const noexcept {
            return scale >= 1e-7 && scale <= 0.1 && max_offset >= 0 && max_offset <= largest &&
                   max_rate >= 0 && max_rate <= 10;
        }
    };

    bool in_force() const noexcept { return std::abs(force_) > settings_.scale / 2; }

    // What the offset in force may be off without meaning anything: LinuxCNC takes some periods to follow.
    double slack() const noexcept { return 10 * settings_.scale; }

    // A joint that homes where it stands takes the offset with it.
    void watch_homing() noexcept {
        const bool homed = all_homed;
        if (homed && !homed_) shifted_ = in_force();
        homed_ = homed;
    }

    void watch_probing() noexcept {
        const bool probing = motion_type == probe;
        refused_ = probing && (probing_ ? refused_ : in_force() && !allow_probing);
        probing_ = probing;
    }

    void judge_readiness(bool on, bool taking_back) noexcept {
        const bool arming = arm, begins = arming && !arming_, clears = taking_back && !taking_back_;
        arming_ = arming;
        taking_back_ = taking_back;
        const bool able = on && homed_;
        const bool ready = able && !taking_back && !shifted_;
        if (clears || (ready && begins)) lost_ = false;
        armed_ = ready && !lost_ && (armed_ || begins);

        const bool works = armed_ || (able && taking_back && !lost_);
        if (works && !working_) {
            y_ = request_;
            counter_.start(request_);
        }
        working_ = works;
    }

    void follow(double target, double dt) noexcept {
        if (counter_.answered(request_, settings_.scale)) {
            const double lag = slack() + settings_.max_rate * follow_time;
            const bool ahead = std::abs(y_ - force_) > lag && (target - y_) * (force_ - y_) <= 0;
            if (!ahead) y_ += bounded(target - y_, settings_.max_rate * dt);
            counter_.ask(y_, request_, settings_.scale);
        }
        lost_ = counter_.silent();
        if (lost_ || counter_.used_up()) armed_ = working_ = false;
    }

    Settings settings_{};                        // the last good ones
    double wish_ = 0, request_ = 0, force_ = 0;  // likewise
    double y_ = 0;                               // the offset that is asked for
    OffsetCounter counter_;
    bool armed_ = false, working_ = false;  // working: armed, or taking the offset back
    bool lost_ = false, shifted_ = false;   // faults lost and homed
    bool probing_ = false, refused_ = false;
    bool homed_ = false, taking_back_ = false;
    bool arming_ = true;  // an arm that is true already is no cycle start
};

hal::Model hal::model() {
    return model_of<AxisOffset>();
}

}  // namespace plumb
