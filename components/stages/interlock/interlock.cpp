// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/delayed_bit.hpp"
#include "components/stages/interlock/functions.hpp"
#include "components/stages/interlock/services.hpp"
#include "components/stages/interlock/stages.hpp"
#include "hal/component.hpp"
#include "hal/thread_watch.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

enum class Fault : std::int32_t { none, time, services, operation, order };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::time:
            return "A service-timeout or a delay of a message is out of range (0 to 3600 s), or clock-speed "
                   "(0.01 to 1000); its last good value is used.";
        case Fault::services:
            return "One of function-services, function-urgent and feed-services is out of range (0 to 255); "
                   "it "
                   "stands for all services.";
        case Fault::order:
            return "A function of Plumb is in a wrong place of its thread, or in none: run plumb doctor "
                   "--running; no cycle is armed, and offsets are held as soon as no function is busy.";
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

It serves up to eight services, six functions and ten stages, numbered from 0. An input without a signal hinders
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
the feed: LinuxCNC 2.9 ignores feed-inhibit after M49 or M51 P0, and feed-hold after M53 P0. Where a program may use
both, net motion.current-vel to path-speed.)"},
        hal::SettingUp{R"(
1. Set service-timeout-N to three times the longest pause of the heartbeat, at least. 30 s suit retain: it waits for
the disk.
2. Switch each function on, with setp or from the panel.
3. Set function-services-N where a function does not need the services 0 to 3: 0 for squareness, which needs none. A lost
service then leaves the function on.
4. Let the program set M64 P0 when a cycle starts, and M65 P0 when it ends and in ON_ABORT_COMMAND.
5. Net the messages to linuxcnc_link(1).
6. Load linuxcnc_alive(1), make LinuxCNC's task and io services, here 4 and 5, and let a loss hold the feed:

    loadusr -W linuxcnc_alive
    setp interlock.service-timeout-4  2.5
    setp interlock.service-timeout-5  2.5
    setp interlock.feed-services     48     # 16 + 32
    net task-beat linuxcnc-alive.task-heartbeat
    net task-beat => interlock.service-heartbeat-4
    net io-beat   linuxcnc-alive.io-heartbeat
    net io-beat   => interlock.service-heartbeat-5
    net program   linuxcnc-alive.program-running
    net program   => interlock.program-running

7. Let a function finish when a service is lost. For an offset, net the signal of program-running to function-busy-N, too.
For strokes, net active of chopping to function-busy-N, add 50 to function-services-N, for linuxcnc_link, task and io, and
set function-urgent-N to 48.
8. Net the input of the emergency stop chain to motion.enable, too: LinuxCNC's io, which reads it otherwise, may be dead.
The hardware of the chain must cut the drives. motion.enable cannot do that, and nor can interlock.
9. Stop a service, and watch its functions go off: halcmd show pin 'interlock.function*'.)"},
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
renewed when a cycle starts or the switch is turned on while they are back. They are kept instead of lost if the function
was on, is busy since, and no service of function-urgent has stopped: then a service that returns is ok again. enable and
lost are function-enable and function-lost.

  services  switch  suspend | enable  lost
  missing   -       -       | 0       0
  ok        0       -       | 0       0
  ok        1       0       | 1       0
  ok        1       1       | 0       0
  kept      1       0       | 1       1
  kept      1       1       | 0       1
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
is 5. loss is feed-service-lost: a service of feed-services has stopped, or one of function-urgent has put a function off
that is not renewed, and program-running is true. homing and feed are homing-inhibit and feed-inhibit.

  in-force  ramping  settling  refused  probing  loss | homing  feed  abort
  0         -        -         -        -        -    | 0       .     .
  1         -        -         -        -        -    | 1       .     .
  -         0        0         0        -        0    | .       0     .
  -         1        0         0        0        0    | .       0     .
  -         1        -         -        1        -    | .       1     .
  -         -        1         -        -        -    | .       1     .
  -         -        -         1        -        -    | .       1     1
  -         -        -         0        -        -    | .       .     0
  -         -        -         -        -        1    | .       1     .

Losses, wired as SETTING UP has it. The function is stroke (chopping), records (an offset with records:
thermal_displacement) or offset (an offset without: squareness, centre_height). during is function-enable while the stroke
or the program goes on, after is it when that has ended, again is it for another stroke or cycle, feed is feed-inhibit.

  gone       function | during  after  again  feed
  retain     stroke   | 1       0      0      0
  retain     records  | 1       0      0      0
  retain     offset   | 1       1      1      0
  link       stroke   | 1       0      0      0
  link       records  | 1       1      1      0
  link       offset   | 1       1      1      0
  task       stroke   | 0       0      0      1
  task       records  | 1       1      1      1
  task       offset   | 1       1      1      1
  io         stroke   | 0       0      0      1
  io         records  | 1       1      1      1
  io         offset   | 1       1      1      1

Where enable falls, the strokes of chopping go on to the dead point nearest point R, and then to R. An offset returns to 0
at the ramp-rate.

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
- Lost service: The functions that need it go off when they are not busy, and take their offsets back. Others go on. A
service that returns does not turn them on: nothing moves before a cycle starts or the operator turns the switch.
- A service of feed-services lost: motion has a queue of moves, and feed-inhibit holds it at once. A program that was cut
off counts as running.
- Probing (G38): Enables do not change while a probing move runs. The move waits until no offset changes. If a stage
refuses it, it is held and aborted.
- Homing: LinuxCNC refuses to home while an offset is in force.
- Tool change: The next move waits while a function settles.
- ramping: True from the period in which an enable or arm changes, so that M66 right after M64 does not miss it.
- abort: True for 0.1 s at least; halui looks 50 times a second.
- uncompensated: After uncompensated-delay without a break. uncompensated-stage is the first such stage.
- probing-refused: At once, and for probing-refused-time afterwards.
- hold-defeated: At once, and for probing-refused-time afterwards.
- feed-held: After feed-held-delay of feed-inhibit: why the machine stands.
- feed-service-lost: At once, with loss of the table.
- operation: operation-key rounded to a whole number, 0 if it is invalid.
- Invalid timeout, delay or clock-speed: The last good value is used.
- Order of the functions: Once a second interlock compares the threads with the places under FUNCTIONS in the pages of
all loaded components. A mistake that it finds twice is a fault, and a message with both functions and the thread. No cycle
is armed. As soon as no function is busy, heartbeat stands still: the stages hold their offsets. When the order is right,
the fault ends. The stages go on as after an interlock that was not called.
- plumb run at K times the clock: A service gets K times its service-timeout. Its program is no faster than the computer.
- Unloaded, or update is not called: heartbeat stands still. Each stage with heartbeat wired holds its offset and
cannot be armed, and has a fault. All other outputs keep their values: an arm that stays true arms nothing, and
homing-inhibit stays right, because no offset changes. When update is called again the stages go on: joint_offset by its
ramp, axis_offset with the next cycle start.)"},
        hal::Limits{R"(
A stage or function that was unloaded is not noticed. Its offset stays, because the signal keeps its value.

Functions of other components, except motion-controller, have no place in the order. Add the functions that write to the
drives after the stages yourself.

LinuxCNC begins a move in spite of both pins of the feed after M49 or M51 P0 together with M53 P0. With path-speed
interlock aborts it, after some milliseconds of motion. A move that runs already when feed-inhibit comes goes on to its end.

A dead interlock does not stop the program. The message of the stage's fault tells the operator. joint_offset stops a
stroke then, because it holds the offset.

A message by linuxcnc_link needs LinuxCNC's task.

A stage that holds its offset for a probing move must not be ramping meanwhile: the move would wait for it. feed-held
shows this.

LinuxCNC holds neither threads and rigid taps (G33, G33.1) nor jogs.)"},
        hal::SeeAlso{"axis_offset(9), joint_offset(9), chopping(9), retain(1), linuxcnc_link(1), "
                     "linuxcnc_alive(1), halui(1), motion(9)"}};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "As in LinuxCNC: 5 is probing."};
    hal::In<double> path_speed{
        this, "path-speed", 0, "mu/s",
        "Speed of the path: motion.current-vel. A move that begins in spite of feed-inhibit "
        "is aborted."};
    hal::In<bool> program_running{this, "program-running", false, "A program runs or is paused."};
    hal::In<std::int32_t> feed_services{
        this, "feed-services", 0, "Services whose loss holds the feed, as a sum like function-services."};
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
    hal::Out<bool> feed_service_lost{this, "feed-service-lost", "A lost service holds the feed."};
    hal::Out<bool> abort{this, "abort", "LinuxCNC has to abort."};
    hal::Out<bool> compensated{this, "compensated", "All functions that are switched on compensate."};
    hal::Out<bool> uncompensated{this, "uncompensated", "An axis lacks its offset for some time."};
    hal::Out<std::int32_t> uncompensated_stage{
        this, "uncompensated-stage", "Number of the first stage whose axis lacks its offset, or -1."};
    hal::Out<bool> probing_refused{this, "probing-refused", "Probing was refused a moment ago."};
    hal::Out<bool> hold_defeated{
        this, "hold-defeated",
        "A move began a moment ago in spite of feed-inhibit, and was aborted: M49, M51 P0 "
        "and M53 P0 disable the holds of LinuxCNC."};
    hal::Out<bool> feed_held{this, "feed-held", "The feed is held for some time."};
    hal::Out<std::int32_t> operation{this, "operation", "Key of the operation as a whole number."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Function run{this, "update", &Interlock::update, hal::Place::interlock};

    void background() override { threads_.work(); }

    void update(double dt) noexcept {
        const bool in_order = threads_.step(dt);
        const bool on = motion_enabled, homed = all_homed, cycle = cycle_running;
        const std::int32_t type = motion_type;
        const bool probing = type == probe;
        const double speed = path_speed;
        const Delays delays{uncompensated_delay, probing_refused_time, feed_held_delay};
        if (delays.valid()) delays_ = delays;
        const double key = operation_key;
        const bool known_key = std::abs(key) <= std::numeric_limits<std::int32_t>::max();

        const bool able = cycle && on && homed, starts = able && !cycle_;
        cycle_ = cycle;
        const bool good_times = services.step(dt) && delays.valid();
        const std::int32_t feed_needs = feed_services;
        const bool good_feed_needs = feed_needs >= 0 && feed_needs <= Services::all;
        const bool good_needs = functions.step(services, {starts, probing}) && good_feed_needs;
        const bool running = program_running;
        const bool loss = services.any_lost(good_feed_needs ? feed_needs : Services::all) ||
                          (running && functions.any_withdrawn());
        armed_ = able && (armed_ || (starts && in_order && functions.any_permitted()));
        holds_ = !in_order && (holds_ || !functions.any_busy());
        request({probing, homed, loss, type != 0 && speed > 0}, dt);

        if (!holds_) beats_ = (beats_ + 1) & std::numeric_limits<std::int32_t>::max();
        heartbeat = beats_;
        arm = armed_;
        operation = known_key ? static_cast<std::int32_t>(std::round(key)) : 0;
        fault = hal::first<Fault>({{!in_order, Fault::order},
                                   {!good_times, Fault::time},
                                   {!good_needs, Fault::services},
                                   {!known_key, Fault::operation}});
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

    struct State {
        bool probing, homed, loss, moving;
    };

    void request(const State& state, double dt) noexcept {
        const auto& [probing, homed, loss, moving] = state;
        const bool settles = any(functions.settling), refused = any(stages.probing_refused);
        const bool stage_ramps = any(stages.ramping), function_ramps = any(functions.ramping);
        const bool ramps = stage_ramps || function_ramps;
        const std::int32_t lacking = first_of(stages.uncompensated);
        const bool waits = settles || refused || loss || (probing && ramps);
        if (functions.changed() || armed_ != was_armed_) announced_ = answer_in;
        was_armed_ = armed_;

        ramping = ramps || announced_ > 0;
        if (announced_ > 0) --announced_;
        homing_inhibit = any(stages.in_force);
        feed_inhibit = waits;
        // From rest: a path that is held brakes first.
        const bool defeats = waits && stood_ && moving;
        stood_ = waits && (stood_ || !moving);
        feed_service_lost = loss;
        abort = abort_.step(refused || defeats, 0, abort_time, dt);
        hold_defeated = defeated_.step(defeats, 0, delays_.probing_refused, dt);
        compensated = functions.all_enabled() && homed && lacking < 0 && !any(stages.fault) && !holds_;
        uncompensated = uncompensated_.step(lacking >= 0, delays_.uncompensated, 0, dt);
        uncompensated_stage = lacking;
        probing_refused = refused_.step(refused, 0, delays_.probing_refused, dt);
        feed_held = held_.step(waits, delays_.feed_held, 0, dt);
    }

    Delays delays_{2, 5, 5};  // the last good ones
    DelayedBit abort_, defeated_, uncompensated_, refused_, held_;
    hal::ThreadWatch threads_;
    bool stood_ = false;  // the path, since feed-inhibit
    bool holds_ = false;  // all offsets, because the order is wrong
    std::int32_t beats_ = 0;
    bool cycle_ = true;  // a cycle that runs already does not start
    bool armed_ = false, was_armed_ = false;
    int announced_ = 0;  // periods in which ramping is true without a ramp
};

hal::Model hal::model() {
    return model_of<Interlock>();
}

}  // namespace plumb
