// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/live_counter.hpp"
#include "components/math/blocks/offset_counter.hpp"
#include "components/math/blocks/offset_ledger.hpp"
#include "components/math/blocks/source_sum.hpp"
#include "components/stages/axis_offset/axis_offset_codes.hpp"
#include "components/stages/axis_offset/guest_pins.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

struct AxisOffset final : hal::Component {
    static constexpr hal::About about{
        "axis_offset",
        "brings an offset into an axis of LinuxCNC by external offsets",
        R"(
axis_offset applies up to four offsets to an axis by LinuxCNC's external offsets. They show in the DRO. They use
OFFSET_AV_RATIO of the speed and acceleration of the axis; planned moves keep the rest. No source moves the axis before
a cycle start arms the stage. Use one instance for each axis.

The own part follows the sum of the sources at max-rate, within max-offset. Another user of the external offsets of this
axis is the guest. Its part moves as LinuxCNC would move it without the stage:

    counts += round((own + guest-request - offset-request) / scale))",
        hal::Wiring{R"(
  loadrt axis_offset names=z-stage unit=[TRAJ]LINEAR_UNITS

  net z-offset        growth.z-offset         => z-stage.offset-0
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
  net applied-offset  z-stage.applied-offset  => growth.applied-offset

  addf motion-command-handler servo-thread
  addf motion-controller      servo-thread
  addf growth.update          servo-thread
  addf z-stage.update         servo-thread

Through this stage LinuxCNC's feedback contains the offset: joint.N.motor-pos-fb. A component that needs the
position of the program subtracts applied-offset and guest-applied from it.

External offsets that something else moves, such as QtDragon, eoffset_per_angle or a torch height control, become the
guest. In its HAL files replace the left pins by the right ones:

  axis.z.eoffset-counts   z-stage.guest-counts
  axis.z.eoffset-scale    z-stage.guest-scale
  axis.z.eoffset-enable   z-stage.guest-enable
  axis.z.eoffset-clear    z-stage.guest-clear
  axis.z.eoffset-request  z-stage.guest-request
  axis.z.eoffset          z-stage.guest-applied
  motion.eoffset-active   z-stage.guest-active)"},
        hal::SettingUp{R"(
1. Write OFFSET_AV_RATIO = 0.2 into the section [AXIS_Z] of the INI file.
2. Let the program set M64 P0 when a cycle starts. This arms the stage.
3. Let a program that needs the offset wait with M66 until uncompensated is false, after it has armed the stage.
4. Keep programs away from the soft limits by max-offset.
5. Keep unit=[TRAJ]LINEAR_UNITS in the loadrt line: on an inch machine it converts the defaults.)"},
        hal::Behaviour{R"(
- Start: No offset. The first rising edge of arm, with the machine on and homed, arms the stage.
- Machine off, emergency stop: The stage is disarmed. Nothing moves. When the machine is turned on, LinuxCNC forgets the
offset and the displayed position changes; uncompensated is true. The next cycle start applies the offset again.
- Abort: The offset holds.
- Guest: It moves the axis whenever the machine is on and homed, armed or not. LinuxCNC limits its speed and
acceleration; max-offset and max-rate do not. Its counts take effect as changes, and changes while the machine is off or
unhomed are lost, as without the stage. armed, uncompensated and probing-refused ignore its part.
- Guest disabled (guest-enable false): Its part stops where it is. Changes of its counts are lost.
- Guest cleared (guest-clear): Its part returns at once, at the speed of LinuxCNC. The own part stays.
- enable false: An armed stage takes the offset back at max-rate.
- clear: Takes the own part back, armed or not, and disarms. LinuxCNC then clears the rest, unless a guest needs it.
- Probing (G38): The offset holds while a probing move runs. A move that begins with an offset in force is refused:
probing-refused holds and aborts it. Results such as #5063 contain the offset. If allow-probing is true, subtract it.
- Touch-off (G10 L20): Correct while uncompensated is false. Otherwise the offset is added to the new origin a
second time.
- Homing: Take the offset back first, also the guest's. If the joints become homed with an offset in force, the offset
stays and the stage cannot be armed (see FAULTS).
- Soft limit: LinuxCNC holds the axis there, and limited is true. The offset comes back when the axis leaves the limit.
While the guest is at rest the own part is the one that is missing.
- Interlock unloaded, not called, or with a fault of the order (heartbeat stands still): The offset holds and the stage is disarmed. clear still
takes the offset back. When interlock is called again, the next cycle start arms the stage.
- Joint mode: The output waits until LinuxCNC applies offsets again.
- Invalid source: The last good value stays.
- Invalid guest-scale, or a guest beyond 1000: The guest's part holds. The change follows when the input is good again.

The stage asks LinuxCNC for the sum of its own offset and the guest's. It is always in one of these states:

  state        armed  own offset      guest's offset  begins when
  off          false  holds           holds           the machine is off or not homed
  disarmed     false  holds           moves           the machine is on and homed
  armed        true   moves           moves           arm rises
  taking back  false  returns to 0    moves           clear is true
  lost         false  holds           holds           LinuxCNC does not take the counts (fault 4)

The stage leaves armed when the machine goes off, and stays disarmed until arm rises. It leaves lost when it is armed, or when
clear rises.)"},
        hal::Limits{R"(
External offsets do not work in joint mode. They take a part of the speed and acceleration of the axis all the time.

At a soft limit LinuxCNC stops axis and offset abruptly. The stage cannot brake before it.

LinuxCNC shows the sum of both parts alone. While the guest is under way, applied-offset is the offset that was asked
for, and guest-applied the rest. There is one guest; add the counts of several, as scaled_s32_sums does.

joint_offset(9) works in every mode and costs no speed, but you must wire it between motion and drive.)"},
        hal::SeeAlso{
            "thermal_displacement(9), interlock(9), joint_offset(9), eoffset_per_angle(9), motion(9)"}};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> enable{this, "enable", true, "Apply the own offset; else 0."};
    hal::Row<hal::In<double>, 4> offset{this, "offset", 0, "mu", "Offset from one of the sources."};
    hal::In<bool> arm{this, "arm", false, "A cycle starts, when it rises."};
    hal::In<bool> clear{this, "clear", false, "Take the own offset back, and disarm."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "As in LinuxCNC: 5 is probing."};
    hal::In<double> offset_request{this, "offset-request", 0, "mu", "Offset that LinuxCNC is asked for."};
    hal::In<double> offset_in_force{this, "offset-in-force", 0, "mu", "Offset that LinuxCNC applies."};
    hal::In<std::int32_t> heartbeat{this, "heartbeat", -1,
                                    "Of interlock, which permits changes of the offset; -1 without one."};
    hal::In<bool> offset_limited{this, "offset-limited", false, "LinuxCNC holds an axis at a soft limit."};
    hal::In<bool> allow_probing{this, "allow-probing", false, "Probing results may contain the offset."};
    static constexpr hal::Range scales{1e-7, 0.1}, offsets{0, 1000}, rates{0, 10};
    hal::In<double> scale{this, "scale", 0.0001, "mu", "Offset of one count.", scales};
    hal::In<double> max_offset{this,   "max-offset", 0.15, "mu", "Largest sum of the offsets either way.",
                               offsets};
    hal::In<double> max_rate{this, "max-rate", 0.1, "mu/s", "Fastest change of the own offset.", rates};
    GuestPins guest{this};

    hal::Out<std::int32_t> counts{this, "counts", "Counts of LinuxCNC's external offset."};
    hal::Out<double> counts_scale{this, "counts-scale", "mu", "Offset of one count, for LinuxCNC."};
    hal::Out<bool> offset_enable{this, "offset-enable", "LinuxCNC is to listen to the counts."};
    hal::Out<bool> offset_clear{this, "offset-clear", "LinuxCNC is to clear what is left of the offset."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu",
                                    "Own offset that the axis has, without the guest's."};
    hal::Out<bool> armed{this, "armed", "The offset follows its sources."};
    hal::Out<bool> in_force{this, "in-force", "LinuxCNC applies an offset, the own one or the guest's."};
    hal::Out<bool> ramping{this, "ramping", "The own offset changes towards its sources."};
    hal::Out<bool> limited{this, "limited",
                           "A soft limit or max-offset keeps the offset from what it is to be."};
    hal::Out<bool> uncompensated{this, "uncompensated", "An offset that is to be applied is not in force."};
    hal::Out<bool> probing_refused{this, "probing-refused", "Probing has begun with an offset in force."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Offset moves{this, hal::MovingPin(counts, counts_scale, offset_request)
                                .bound(max_offset)
                                .rate(max_rate)
                                .accelerated_by("LinuxCNC limits its acceleration, to OFFSET_AV_RATIO of "
                                                "the acceleration of the axis, except at a soft limit.")
                                .limited(limited)
                                .guest(guest.request)};

    hal::Function run{this, "update", &AxisOffset::update, hal::Place::stage,
                      "After a guest in the same thread."};

    void prepare() override { settings_ = {scale, max_offset, max_rate}; }

    void update(double dt) noexcept {
        hal::SettingsReader setting;
        const Settings given{setting(scale), setting(max_offset), setting(max_rate)};
        if (setting.good()) settings_ = given;
        const bool good_sources = sources_.read(offset, largest);
        const bool on = motion_enabled, homed = all_homed, probing = motion_type == probe;
        const bool arms = arm_.rises(arm), taking_back = clear, clears = clear_.rises(taking_back);
        if (power_.rises(on)) forget();
        const bool hears = read_report(dt);
        const double wanted = enable ? sources_.value() : 0;
        const double possible = bounded(wanted, settings_.max_offset);
        const double target = taking_back ? 0 : possible;

        // A joint that homes where it stands takes the offset with it, also the guest's.
        if (homing_.rises(homed)) shifted_ = any_in_force();
        if (probing_.rises(probing)) refused_ = own_in_force() && !allow_probing;
        refused_ = refused_ && probing;
        interlock_.step(heartbeat);
        const bool able = on && homed;
        const bool ready = able && !taking_back && !shifted_ && interlock_.alive();
        enter(next({able, ready, arms, taking_back, clears}));
        ledger_.listen(guest.read(), takes_counts());
        if (takes_counts() && hears) follow(target, probing, dt);

        counts = counter_.counts();
        counts_scale = settings_.scale;
        offset_enable = true;
        offset_clear = taking_back && !own_in_force() && std::abs(ledger_.guest().request()) <= nothing &&
                       std::abs(request_) <= settings_.scale / 2;
        applied_offset = ledger_.own_in_force();
        guest.show(ledger_.guest().request(), ledger_.guest_in_force(), settings_.scale);
        armed = state_ == State::armed;
        in_force = any_in_force();
        ramping = moves_own() && hears && !probing && !offset_limited &&
                  std::abs(target - ledger_.own_in_force()) > slack();
        limited = offset_limited || wanted != possible;
        uncompensated = std::abs(wanted - (on ? ledger_.own_in_force() : 0)) > slack();
        probing_refused = refused_;
        fault = hal::first<Fault>({{interlock_.missed(), Fault::interlock},
                                   {!good_sources, Fault::source},
                                   {!hears, Fault::report},
                                   {!setting.good(), Fault::settings},
                                   {state_ == State::lost, Fault::lost},
                                   {counter_.used_up(), Fault::counts},
                                   {shifted_, Fault::homed},
                                   {!ledger_.guest().good(), Fault::guest}});
    }

private:
    static constexpr double largest = 1e3;       // mu
    static constexpr double nothing = 1e-9;      // mu, that a guest's sum leaves of 0
    static constexpr double follow_time = 0.01;  // s
    static constexpr std::int32_t probe = 5;     // motion-type

    struct Settings {
        double scale, max_offset, max_rate;
    };

    enum class State {
        off,          // LinuxCNC takes no counts: the machine is off or not homed
        disarmed,     // the guest's part moves, the own one holds
        taking_back,  // the own part returns to 0
        armed,        // the own part follows the sources
        lost,         // LinuxCNC does not take the counts, until the stage is armed again or cleared
    };

    struct Signals {
        bool able;   // the machine is on and homed
        bool ready;  // to be armed
        bool arms, taking_back, clears;
    };

    State next(const Signals& now) const noexcept {
        if (state_ == State::lost && !now.clears && !(now.ready && now.arms)) return State::lost;
        if (now.ready && (state_ == State::armed || now.arms)) return State::armed;
        if (!now.able) return State::off;
        return now.taking_back ? State::taking_back : State::disarmed;
    }

    void enter(State state) noexcept {
        const bool took_counts = takes_counts(), moved_own = moves_own();
        state_ = state;
        const bool begins = (moves_own() && !moved_own) || (takes_counts() && !took_counts);
        if (begins && !counter_.agrees(request_, settings_.scale)) take_stock();
    }

    bool takes_counts() const noexcept { return state_ != State::off && state_ != State::lost; }
    bool moves_own() const noexcept { return state_ == State::taking_back || state_ == State::armed; }

    // Beside a guest's fractions of a count the own part is rounded to half a count.
    bool own_in_force() const noexcept { return std::abs(ledger_.own_in_force()) > 0.75 * settings_.scale; }

    bool any_in_force() const noexcept { return std::abs(force_) > settings_.scale / 2; }

    // What the offset in force may be off without meaning anything: LinuxCNC takes some periods to follow.
    double slack() const noexcept { return 10 * settings_.scale; }

    // LinuxCNC forgets all offsets when it is turned on.
    void forget() noexcept {
        ledger_.forget();
        counter_.start(0);
    }

    // What LinuxCNC reports.  An invalid value keeps its last good one; then false.
    bool read_report(double dt) noexcept {
        const double request = offset_request, force = offset_in_force;
        const bool hears = std::abs(request) <= largest && std::abs(force) <= largest;
        request_ = hears ? request : request_;
        force_ = hears ? force : force_;
        ledger_.divide(force_, settings_.max_rate * dt, settings_.scale);
        return hears;
    }

    void take_stock() noexcept {
        ledger_.take_stock(request_, force_, settings_.max_offset, settings_.scale);
        counter_.start(request_);
    }

    // Sends the sum of both parts.  The own one moves while the stage is armed or takes it back, the guest's
    // at any time.
    void follow(double target, bool probing, double dt) noexcept {
        if (counter_.answered(request_, settings_.scale)) {
            if (moves_own() && !probing)
                ledger_.approach(target, settings_.max_rate * dt, slack() + settings_.max_rate * follow_time);
            if (moves_own() || std::abs(ledger_.asked() - request_) > settings_.scale / 2)
                counter_.ask(ledger_.asked(), request_, settings_.scale);
        } else if (!moves_own() && !counter_.under_way()) {
            take_stock();  // not by the stage
        }
        if (counter_.silent())
            state_ = State::lost;
        else if (counter_.used_up())
            state_ = State::disarmed;
    }

    Settings settings_{};             // the last good ones
    double request_ = 0, force_ = 0;  // likewise
    SourceSum<4> sources_;
    OffsetLedger ledger_;
    OffsetCounter counter_;
    LiveCounter interlock_;
    State state_ = State::off;
    bool shifted_ = false;  // fault homed
    bool refused_ = false;  // the present probing move
    Edge power_, homing_, probing_, clear_;
    Edge arm_{true};  // an arm that is true already is no cycle start
};

hal::Model hal::model() {
    return model_of<AxisOffset>();
}

}  // namespace plumb
