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
                                      "bring an offset into an axis of LinuxCNC, by external offsets",
                                      R"(
Whatever computes an offset of an axis nets it to offset; LinuxCNC adds it to the axis as an external offset, within
OFFSET_AV_RATIO of the axis' speed and acceleration (in [AXIS_L] of the INI file; planned moves keep the rest).

    y  follows  offset  by max-rate at most, within max-offset
    counts += round((y - offset-request) / scale)

One instance an axis.  In the servo thread after motion-controller and after the source of offset, here for Z:

    net z-offset          source.z-offset            => z-stage.offset
    net motion-enabled    motion.motion-enabled      => z-stage.motion-enabled
    net all-homed         motion.is-all-homed        => z-stage.all-homed
    net motion-type       motion.motion-type         => z-stage.motion-type
    net offset-limited    motion.eoffset-limited     => z-stage.offset-limited
    net z-request         axis.z.eoffset-request     => z-stage.offset-request
    net z-in-force        axis.z.eoffset             => z-stage.offset-in-force
    net z-counts          z-stage.counts             => axis.z.eoffset-counts
    net z-counts-scale    z-stage.counts-scale       => axis.z.eoffset-scale
    net z-offset-enable   z-stage.offset-enable      => axis.z.eoffset-enable
    net z-offset-clear    z-stage.offset-clear       => axis.z.eoffset-clear
    net cycle-start       motion.digital-out-00      => z-stage.arm
    net probing-refused   z-stage.probing-refused    => motion.feed-inhibit halui.abort
    net applied-offset    z-stage.applied-offset     => source.applied-offset

    addf motion-command-handler servo-thread
    addf motion-controller      servo-thread
    addf source.update          servo-thread
    addf z-stage.update         servo-thread

Arming: nothing moves before a rising edge of arm, the start of a cycle, finds the machine on and homed.  Machine off,
emergency stop, unhoming, clear and the faults 4 to 6 disarm.  LinuxCNC forgets the offset when the machine is turned on:
nothing moves then, the position shown changes instead, and the interpreter takes note of it at the next change of
mode.  Then, and whenever else an offset that is to be applied is not in force, to ten counts, uncompensated is true:
tell the operator.  A program that must not go on without it waits for that pin (M66) after it has set arm.

With enable false an armed stage takes the offset back by max-rate.  So does clear, armed or not; when nothing is left
it has LinuxCNC clear the rest.

At a soft limit LinuxCNC holds the axis, where it stops it without braking, and limited says so; the offset comes back
as the axis leaves the limit.  So let programs keep off the limits by max-offset.  y waits while the offset in force
does not follow, there and in joint mode.

The feedback contains the offset: to know where the program wants the axis subtract applied-offset from it.  #5063 and
the other results of G38 contain it, too.  While one is under way the offset is held, and one that begins with an
offset in force is refused: probing-refused is true until it has ended, and wired as above holds it and breaks it off.
With allow-probing it goes on; subtract the offset from its results.  Touch-off (G10 L20) takes the position without
the offset, which is right as long as uncompensated is false: an origin set while it is true contains what the offset
will add once more.

Take the offset back before homing anew: a joint that homes where it stands takes the place, offset included, as its
home.  When the joints become homed with an offset in force, it stays as it is, and the stage has fault 6 and cannot be
armed.

At a soft limit LinuxCNC holds axis and offset together, and limited is true.  It stops the axis there as abruptly as
motion and offset arrive: that is LinuxCNC's own, and the stage cannot brake before it.  Leave the offset as much room
before the limits as max-offset.

The defaults are for millimetres; on an inch machine divide scale, max-offset and max-rate by 25.4.)"};

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
