// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/delayed_bit.hpp"
#include "components/stages/interlock/functions.hpp"
#include "components/stages/interlock/services.hpp"
#include "components/stages/interlock/stages.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

enum class Fault : std::int32_t { none, time, services, operation };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::time:
            return "A service-timeout, or a delay of a message, is out of range (0 to 3600 s); its last good "
                   "value is used.";
        case Fault::services:
            return "One of function-services is out of range (0 to 15); the function needs all services.";
        case Fault::operation: return "The operation-key is invalid or beyond 2147483647; operation is 0.";
        default: return nullptr;
    }
}

struct Interlock final : hal::Component {
    static constexpr hal::About about{
        "interlock",
        "permits functions to compensate, arms stages, and requests that LinuxCNC waits",
        R"(
interlock decides for all functions of a machine when they may compensate. It watches the programs that they need,
here called services, such as retain. It arms the stages when a cycle starts. It requests that LinuxCNC does not home,
waits, or aborts. It gives the operator's messages their delays. One interlock takes the place of and2, not, lut5,
timedelay, watchdog and conv_float_s32.

It serves up to four services, four functions and eight stages, numbered from 0. An input without a signal hinders
nothing, except function-switch: a function is off until it is switched on.)",
        hal::Wiring{R"(
Service 0 is retain. Function 0 is growth, with stage 0, z-stage. Function 1 is square, with stage 1, x-stage.

  loadrt interlock names=interlock

  setp interlock.service-timeout-0   30
  setp interlock.function-services-1  0
  setp interlock.function-switch-0    1
  setp interlock.function-switch-1    1

  net motion-enabled motion.motion-enabled => interlock.motion-enabled
  net all-homed      motion.is-all-homed   => interlock.all-homed
  net motion-type    motion.motion-type    => interlock.motion-type
  net cycle-running  motion.digital-out-00 => interlock.cycle-running

  net retain-beat  retain.heartbeat => interlock.service-heartbeat-0
  net restored     retain.restored  => interlock.service-ready-0
  net retain-fault retain.fault     => interlock.service-fault-0

  net growth-on    interlock.function-enable-0 => growth.enable
  net square-on    interlock.function-enable-1 => square.enable
  net square-ramp  square.ramping   => interlock.function-ramping-1
  net settling     square.settling  => interlock.function-settling-1

  net z-lacks  z-stage.uncompensated => interlock.stage-uncompensated-0
  net z-in-force z-stage.in-force    => interlock.stage-in-force-0
  net z-ramping  z-stage.ramping     => interlock.stage-ramping-0
  net z-fault  z-stage.fault         => interlock.stage-fault-0
  net z-refuses z-stage.probing-refused
  net z-refuses                    => interlock.stage-probing-refused-0
  net x-in-force  x-stage.inhibit-homing => interlock.stage-in-force-1
  net x-ramping   x-stage.ramping        => interlock.stage-ramping-1
  net x-fault     x-stage.fault          => interlock.stage-fault-1

  net arm        interlock.arm            => z-stage.arm
  net heartbeat  interlock.heartbeat      => x-stage.heartbeat
  net heartbeat                           => z-stage.heartbeat
  net no-homing  interlock.homing-inhibit => motion.homing-inhibit
  net feed-wait  interlock.feed-inhibit   => motion.feed-inhibit
  net feed-wait                           => motion.feed-hold
  net abort      interlock.abort          => halui.abort

  addf motion-command-handler servo-thread
  addf motion-controller      servo-thread
  addf growth.update          servo-thread
  addf square.update          servo-thread
  addf z-stage.update         servo-thread
  addf x-stage.update         servo-thread
  addf interlock.update       servo-thread

Add interlock to the thread of the stages, after all functions and stages: LinuxCNC must see a request before it begins
the next move. Net heartbeat to each stage: without it a stage does not notice that interlock has gone. Net both pins of
the feed: LinuxCNC 2.9 ignores feed-inhibit after M49 or M51 P0, and feed-hold after M53 P0.)"},
        hal::SettingUp{R"(
1. Set service-timeout-N to three times the longest pause of the heartbeat, at least. 30 s suit retain: it waits for
the disk.
2. Switch each function on, with setp or from the panel.
3. Set function-services-N where a function does not need all services: 0 for squareness, which needs none. A lost
service then leaves the function on.
4. Let the program set M64 P0 when a cycle starts, and M65 P0 when it ends and in ON_ABORT_COMMAND.
5. Net the messages to linuxcnc_link(1).
6. Stop a service, and watch its functions go off: halcmd show pin 'interlock.function*'.)"},
        hal::Behaviour{R"(
In the tables 1 is true, 0 is false, and - is either. A . leaves the output to the other rows.

Service N. Its heartbeat waits until it changes for the first time, then it beats, and it has stopped after
service-timeout. With a timeout of 0 it always beats. ok, lost, not-ready and troubled are service-ok and so on.

  heartbeat  ready  fault | ok  lost  not-ready  troubled
  waits      -      0     | 0   0     0          0
  waits      -      1     | 0   0     1          0
  beats      0      0     | 0   0     0          0
  beats      0      1     | 0   0     1          0
  beats      1      0     | 1   0     0          0
  beats      1      1     | 1   0     0          1
  stopped    -      -     | 0   1     0          0

Function N. The services that it needs are missing until all are ok. Then one is lost, and later they are back. They are
renewed when a cycle starts or the switch is turned on while they are back. enable and lost are function-enable and
function-lost.

  services  switch  suspend | enable  lost
  missing   -       -       | 0       0
  ok        0       -       | 0       0
  ok        1       0       | 1       0
  ok        1       1       | 0       0
  lost      -       -       | 0       1
  back      0       -       | 0       1
  back      1       -       | 0       1
  renewed   0       -       | 0       0
  renewed   1       0       | 1       0
  renewed   1       1       | 0       0

Arming. function is 1 if a function is switched on and its services are ok or renewed, suspended or not. before is arm
in the period before.

  before  cycle-running  motion-enabled  all-homed  function | arm
  0       rises          1               1          1        | 1
  0       rises          1               1          0        | 0
  0       rises          1               0          -        | 0
  0       rises          0               -          -        | 0
  0       1              -               -          -        | 0
  0       0              -               -          -        | 0
  1       1              1               1          -        | 1
  1       1              1               0          -        | 0
  1       1              0               -          -        | 0
  1       0              -               -          -        | 0

Requests. An input is 1 if it is for one stage, or for settling and ramping one function. probing is 1 while motion-type
is 5. homing and feed are homing-inhibit and feed-inhibit.

  in-force  ramping  settling  refused  probing | homing  feed  abort
  0         -        -         -        -       | 0       .     .
  1         -        -         -        -       | 1       .     .
  -         0        0         0        -       | .       0     .
  -         1        0         0        0       | .       0     .
  -         1        -         -        1       | .       1     .
  -         -        1         -        -       | .       1     .
  -         -        -         1        -       | .       1     1
  -         -        -         0        -       | .       .     0

compensated, for the panel. functions is none if none is switched on, and all if each that is switched on is enabled.

  functions  all-homed  stage-fault  uncompensated | compensated
  all        1          0            0             | 1
  all        0          -            -             | 0
  all        -          1            -             | 0
  all        -          -            1             | 0
  some       -          -            -             | 0
  none       -          -            -             | 0

- Start: Nothing is enabled or armed. A cycle that runs already, or begins with the machine off or not homed, arms nothing.
- Machine off, emergency stop, unhomed: arm falls. Stages hold or forget their offsets by themselves. Enables stay.
- Abort: Offsets hold. arm falls with cycle-running.
- Lost service: The functions that need it go off, and take their offsets back. Others go on. A service that returns
does not turn them on: nothing moves before a cycle starts or the operator turns the switch.
- Probing (G38): Enables do not change while a probing move runs. The move waits until no offset changes. If a stage
refuses it, it is held and aborted.
- Homing: LinuxCNC refuses to home while an offset is in force.
- Tool change: The next move waits while a function settles.
- ramping: True from the period in which an enable or arm changes, so that M66 right after M64 does not miss it.
- abort: True for 0.1 s at least; halui looks 50 times a second.
- uncompensated: After uncompensated-delay without a break. uncompensated-stage is the first such stage.
- probing-refused: At once, and for probing-refused-time afterwards.
- feed-held: After feed-held-delay of feed-inhibit: why the machine stands.
- operation: operation-key rounded to a whole number, 0 if it is invalid.
- Invalid timeout or delay: The last good value is used.
- Unloaded, or update is not called: heartbeat stands still. Each stage with heartbeat wired holds its offset and
cannot be armed, and has a fault. All other outputs keep their values: an arm that stays true arms nothing, and
homing-inhibit stays right, because no offset changes. When update is called again the stages go on: joint_offset by its
ramp, axis_offset with the next cycle start.)"},
        hal::Limits{R"(
A stage or function that is dead itself is not noticed. Its offset stays, because the signal keeps its value.

A dead interlock does not stop the program. The message of the stage's fault tells the operator.

A stage that holds its offset for a probing move must not be ramping meanwhile: the move would wait for it. feed-held
shows this.

LinuxCNC holds neither threads and rigid taps (G33, G33.1) nor jogs.)"},
        hal::SeeAlso{"axis_offset(9), joint_offset(9), retain(1), linuxcnc_link(1), halui(1), motion(9)"}};

    using Component::Component;

    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "As in LinuxCNC: 5 is probing."};
    hal::In<double> operation_key{this, "operation-key", 0, "1",
                                  "Key of the operation, which the program sets by M68."};
    Services services{this};
    Functions functions{this};
    Stages stages{this};
    hal::In<double> uncompensated_delay{this, "uncompensated-delay", 2, "s",
                                        "How long an axis lacks its offset before uncompensated is true."};
    hal::In<double> probing_refused_time{this, "probing-refused-time", 5, "s",
                                         "How long probing-refused stays true after the refusal."};
    hal::In<double> feed_held_delay{this, "feed-held-delay", 5, "s",
                                    "How long the feed is held before feed-held is true."};

    hal::Out<std::int32_t> heartbeat{this, "heartbeat", "Counts the periods, for the stages."};
    hal::Out<bool> arm{this, "arm", "A cycle runs that may apply offsets; a stage arms when it rises."};
    hal::Out<bool> ramping{this, "ramping", "A function or a stage is on its way to what is wanted."};
    hal::Out<bool> homing_inhibit{this, "homing-inhibit", "An offset is in force: LinuxCNC must not home."};
    hal::Out<bool> feed_inhibit{this, "feed-inhibit", "The next move has to wait."};
    hal::Out<bool> abort{this, "abort", "LinuxCNC has to abort."};
    hal::Out<bool> compensated{this, "compensated", "All functions that are switched on compensate."};
    hal::Out<bool> uncompensated{this, "uncompensated", "An axis lacks its offset for some time."};
    hal::Out<std::int32_t> uncompensated_stage{
        this, "uncompensated-stage", "Number of the first stage whose axis lacks its offset, or -1."};
    hal::Out<bool> probing_refused{this, "probing-refused", "Probing was refused a moment ago."};
    hal::Out<bool> feed_held{this, "feed-held", "The feed is held for some time."};
    hal::Out<std::int32_t> operation{this, "operation", "Key of the operation as a whole number."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Function run{this, "update", &Interlock::update, "After all functions and all stages."};

    void update(double dt) noexcept {
        const bool on = motion_enabled, homed = all_homed, cycle = cycle_running;
        const bool probing = motion_type == probe;
        const Delays delays{uncompensated_delay, probing_refused_time, feed_held_delay};
        if (delays.valid()) delays_ = delays;
        const double key = operation_key;
        const bool known_key = std::abs(key) <= std::numeric_limits<std::int32_t>::max();

        const bool able = cycle && on && homed, starts = able && !cycle_;
        cycle_ = cycle;
        const bool good_times = services.step(dt) && delays.valid();
        const bool good_needs = functions.step(services, {starts, probing});
        armed_ = able && (armed_ || (starts && functions.any_permitted()));
        request(probing, homed, dt);

        beats_ = (beats_ + 1) & std::numeric_limits<std::int32_t>::max();
        heartbeat = beats_;
        arm = armed_;
        operation = known_key ? static_cast<std::int32_t>(std::round(key)) : 0;
        fault = hal::first<Fault>(
            {{!good_times, Fault::time}, {!good_needs, Fault::services}, {!known_key, Fault::operation}});
    }

private:
    static constexpr std::int32_t probe = 5;   // motion-type
    static constexpr double abort_time = 0.1;  // s
    static constexpr int answer_in = 3;        // periods in which a function or a stage reports its ramp

    struct Delays {
        double uncompensated, probing_refused, feed_held;  // s

        bool valid() const noexcept {
            const auto possible = [](double time) { return time >= 0 && time <= Services::longest; };
            return possible(uncompensated) && possible(probing_refused) && possible(feed_held);
        }
    };

    void request(bool probing, bool homed, double dt) noexcept {
        const bool settles = any(functions.settling), refused = any(stages.probing_refused);
        const bool stage_ramps = any(stages.ramping), function_ramps = any(functions.ramping);
        const bool ramps = stage_ramps || function_ramps;
        const std::int32_t lacking = first_of(stages.uncompensated);
        const bool waits = settles || refused || (probing && ramps);
        if (functions.changed() || armed_ != was_armed_) announced_ = answer_in;
        was_armed_ = armed_;

        ramping = ramps || announced_ > 0;
        if (announced_ > 0) --announced_;
        homing_inhibit = any(stages.in_force);
        feed_inhibit = waits;
        abort = abort_.step(refused, 0, abort_time, dt);
        compensated = functions.all_enabled() && homed && lacking < 0 && !any(stages.fault);
        uncompensated = uncompensated_.step(lacking >= 0, delays_.uncompensated, 0, dt);
        uncompensated_stage = lacking;
        probing_refused = refused_.step(refused, 0, delays_.probing_refused, dt);
        feed_held = held_.step(waits, delays_.feed_held, 0, dt);
    }

    Delays delays_{2, 5, 5};  // the last good ones
    DelayedBit abort_, uncompensated_, refused_, held_;
    std::int32_t beats_ = 0;
    bool cycle_ = true;  // a cycle that runs already does not start
    bool armed_ = false, was_armed_ = false;
    int announced_ = 0;  // periods in which ramping is true without a ramp
};

hal::Model hal::model() {
    return model_of<Interlock>();
}

}  // namespace plumb
