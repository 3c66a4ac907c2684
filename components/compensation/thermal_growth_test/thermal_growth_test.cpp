// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth_test/growth_test_inputs.hpp"

#include <cmath>

namespace plumb {

using namespace growth_test;

struct ThermalGrowthTest final : hal::Component {
    static constexpr hal::About about{
        "thermal_growth_test",
        "measures how much a machine grows as it warms, and whether its compensation helps",
        R"(
A probe touches the bores of an artifact. The machine then works dry, and the probe touches the bores again, until the
machine is warm. thermal_growth_test holds the state of this test: it latches each touch with the compensation in force,
counts, decides when the machine is warm, and reports what went wrong. It moves nothing.

The G-code of configs/functions/thermal_growth_test moves and probes. growth_log(1) writes the log, and plumb-growth(1)
makes the report. The theory is in components/compensation/thermal_growth_test/README.md of the sources.)",
        hal::Wiring{R"(
  loadrt thermal_growth_test names=growth-test unit=[TRAJ]LINEAR_UNITS

  net test-running  motion.digital-out-24 => growth-test.running
  net test-pass     motion.digital-out-25 => growth-test.pass-running
  net test-at-bore  motion.digital-out-26 => growth-test.at-bore
  net test-measure  motion.digital-out-27 => growth-test.measuring
  net test-cycle    motion.digital-out-28 => growth-test.cycle
  net test-turned   motion.digital-out-29 => growth-test.turned
  net test-comp     motion.digital-out-30 => growth-test.compensate
  net test-resume   motion.digital-out-31 => growth-test.resume
  net test-cool     motion.digital-out-23 => growth-test.cool
  net test-bore     motion.analog-out-04  => growth-test.bore-key
  net probe                               => growth-test.probe
  net x-joint-fb                          => growth-test.x-position
  net x-applied-offset                    => growth-test.x-offset
  net x-velocity    joint.0.vel-cmd       => growth-test.x-velocity
  net spindle-speed spindle.0.speed-out   => growth-test.spindle-speed
  net test-request  growth-test.compensation-request
  net comp-on                             => growth-test.compensation-on
  net test-done     growth-test.done      => motion.digital-in-24

  addf motion-command-handler servo-thread
  addf motion-controller      servo-thread
  addf growth-test.update     servo-thread

Wire Y and Z like X; configs/growth has all lines, and loads linuxcnc_link(1) for the messages. Load motmod with num_dio=32 num_aio=5.

x-joint-fb must contain the compensation, and x-applied-offset is the compensation that it contains: through
axis_offset(9) both are those of LinuxCNC. Through joint_offset(9) take drive-feedback and applied-offset of the stage.)"},
        hal::SettingUp{R"(
1. Mount the artifact on the table and calibrate the probe. Note the place of each bore for growth_log(1).
2. Net the temperatures, with valid and age, and set sensors to their number.
3. Set the tolerances in the file of growth_log(1), and threshold, interval, minimum-time and maximum-time here.
4. Let the machine stand overnight. Start the program of the test.
5. Look at the report at any time: plumb growth report LOG.

The rule of the source is interval 0, by-displacement 0 and minimum-time 0. It stops far too early: at 5 K and cycles of
30 min 78 % of the drift is still to come. It needs no bore: temperatures, time and cycle are enough.)"},
        hal::Behaviour{R"(
- running rises: A new test begins. With resume true and records restored by growth_log(1), the test continues.
- running falls: The test is interrupted until it stops or is resumed.
- pass-running: A pass runs. The first one is the reference.
- at-bore rises: A bore is visited. While measuring is true, the first touch of the probe is latched: position and
compensation of that period. Its direction is that of the motion.
- at-bore falls: Centre and height are computed from the touches. If they do not count, repeat is true.
- Outlier: Touches that leave their circle, or touches of the face that differ, by more than max-scatter set repeat and fault 6.
- cycle rises: A cycle of the machine ends.
- Pass longer than max-pass-time: fault 15; the test goes on.
- Speed of the spindle: Its mean is a record with each row of temperatures, for plumb growth identify.
- Stop: done becomes true when temperatures and displacements stand, never before minimum-time, or at maximum-time.
- Sensor fault: A sensor that decides and is not valid holds the first rule back. The test goes on.
- State of compensation: compensation-request follows compensate. confirmed is true when compensation-on agrees.
- Abort: The records stay. The visit that was interrupted does not count. A pass that was interrupted goes on under its
number when the test is resumed.
- Invalid position: The touch is not latched, and the visit does not count.)"},
        hal::Limits{R"(
A stopped spindle cools while the probe works: 3 to 15 of 60 um in a pass. plumb-growth(1) removes the drift within a pass
by the first bore, which is probed again at its end.

At most 16 bores and 50000 records.)"},
        hal::SeeAlso{"growth_log(1), plumb-growth(1), thermal_displacement(9), axis_offset(9)"}};

    using Component::Component;

    hal::LengthUnit unit{this};
    hal::In<bool> running{this, "running", false, "The program of the test runs."};
    hal::In<bool> resume{this, "resume", false, "Continue the restored test instead of a new one."};
    hal::In<double> gap{this, "gap", 0, "s",
                        "Time since the last record of the restored test; -1 when not known."};
    hal::In<bool> pass_running{this, "pass-running", false, "A pass over the bores runs."};
    hal::In<bool> at_bore{this, "at-bore", false, "A bore is probed."};
    hal::In<bool> measuring{this, "measuring", false, "The next touch of the probe counts."};
    hal::In<bool> cycle{this, "cycle", false, "A rising edge ends a cycle of the machine."};
    hal::In<double> bore_key{this, "bore-key", 0, "1", "Number of the bore, 1 to 16."};
    hal::In<bool> turned{this, "turned", false, "The table is at the second orientation, 180 deg."};
    hal::In<bool> probe{this, "probe", false, "The probe touches."};
    hal::In<bool> overtravel{this, "probe-overtravel", false, "The probe reports overtravel."};
    hal::In<bool> compensate{this, "compensate", false, "The program wants position compensation."};
    hal::In<bool> compensation_on{this, "compensation-on", false, "The control confirms compensation."};
    hal::In<bool> cool{this, "cool", false, "The program wants temperature control."};
    hal::In<bool> cooling_on{this, "cooling-on", false, "The control confirms temperature control."};
    hal::In<double> confirm_time{this, "confirm-time", 30, "s", "Longest time until a state is confirmed."};
    hal::In<double> max_pass_time{this, "max-pass-time", 3600, "s", "Longest pass; the machine cools in it."};
    hal::In<bool> acknowledge{this, "acknowledge", false, "A rising edge clears a fault of the past."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm", "Speed of the spindle, for the log."};
    Machine machine{this};
    Temperatures temperatures{this};
    StopSettings stop_settings{this};

    hal::Codes<State> state{this, "state", "A test is not idle; state-code gives its state."};
    hal::Codes<Stop> stop_reason{this, "stop-reason", "The test has stopped; stop-reason-code gives why."};
    hal::Out<bool> done{this, "done", "The machine is warm, or the time is over."};
    hal::Out<std::int32_t> cycle_index{this, "cycle-index", "Number of cycles that ended."};
    hal::Out<std::int32_t> pass{this, "pass", "Number of the present or last pass."};
    hal::Out<std::int32_t> visit{this, "visit", "Number of visits of bores."};
    hal::Out<std::int32_t> touches{this, "touches", "Number of touches that were latched."};
    hal::Out<double> elapsed{this, "elapsed", "s", "Time since the test began."};
    hal::Out<double> change{this, "temperature-change", "K",
                            "Largest change of a temperature in the interval; 1000 while unknown."};
    hal::Axes<hal::Out<double>, 3> touch{this, "touch-%", "mu", "% of the last touch, with compensation."};
    hal::Axes<hal::Out<double>, 3> touch_offset{this, "touch-%-offset", "mu",
                                                "Compensation in % at the last touch."};
    hal::Axes<hal::Out<double>, 3> bore{this, "bore-%", "mu",
                                        "% of the last bore or face, without compensation."};
    hal::Out<double> bore_diameter{this, "bore-diameter", "mu", "Diameter of the last bore."};
    hal::Out<double> bore_scatter{this, "bore-scatter", "mu", "Scatter of its touches about the circle."};
    hal::In<double> ball{this, "ball-diameter", 6, "mu", "Diameter of the ball of the probe."};
    hal::In<bool> boss{this, "outside", false, "The probe touches a boss or a sphere from outside."};
    hal::Out<bool> repeat{this, "repeat", "The last visit does not count; probe the bore again."};
    hal::Out<bool> compensation_request{this, "compensation-request", "Compensation shall be on."};
    hal::Out<bool> cooling_request{this, "cooling-request", "Temperature control shall be on."};
    hal::Out<bool> confirmed{this, "confirmed", "The control confirms both wanted states."};
    hal::Codes<Advice> advice{this, "advice", "The settings are unusual; advice-code gives how."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Records rows{this};
    GrowthRow row{this};

    hal::Function run{this, "update", &ThermalGrowthTest::update, hal::Place::measurement};

    void prepare() override {
        test_.reserve();
        test_.clear();
    }

    void update(double dt) noexcept {
        const Machine::Reading at = machine.read();
        const Temperatures::Reading warmth = temperatures.read();
        const GrowthTest::Settings wanted = stop_settings.read(warmth.decides);
        const bool settings_good = wanted.stop.valid() && wanted.most_scatter > 0;
        if (settings_good) settings_ = wanted;
        settings_.stop.sensors = warmth.decides;

        confirm(dt);
        begin_or_end();
        if (active_) {
            time_ += dt;
            follow_pass(dt);
            follow_bore(at);
            follow_cycle();
            follow_speed(dt);
            sample(warmth);
            decide();
        }
        before_ = now_;
        walk();
        show(at, warmth, settings_good);
    }

private:
    struct Bits {
        bool running = false, pass = false, bore = false, measuring = false, cycle = false, probe = false;
        bool acknowledge = false;
    };

    void confirm(double dt) noexcept {
        now_ = {running, pass_running, at_bore, measuring, cycle, probe, acknowledge};
        wants_compensation_ = compensate;
        wants_cooling_ = cool;
        turned_ = turned;
        const double patience = confirm_time;
        const bool late = compensation_.step(wants_compensation_, compensation_on, patience, dt);
        const bool late_cooling = cooling_.step(wants_cooling_, cooling_on, patience, dt);
        unconfirmed_ = now_.running && (late || late_cooling);
        if (now_.acknowledge && !before_.acknowledge) past_ = Fault::none;
    }

    Record record(Kind kind, std::int32_t item) const noexcept {
        Record r;
        r.kind = static_cast<std::int32_t>(kind);
        r.item = item;
        r.time = time_;
        r.pass = pass_;
        r.visit = visit_;
        r.bore = bore_;
        r.turned = turned_;
        r.compensated = compensation_.is();
        r.cooled = cooling_.is();
        return r;
    }
    void happen(Event event, double x = 0) noexcept {
        Record r = record(Kind::event, static_cast<std::int32_t>(event));
        r.x = x;
        take(r);
    }
    void take(const Record& r) noexcept {
        if (!test_.take(r, settings_) && test_.full()) past_ = Fault::full;
    }
    void fail(Fault its) noexcept {
        if (its != past_) happen(Event::fault, static_cast<double>(its));
        past_ = its;
    }

    void begin_or_end() noexcept {
        if (now_.running && !before_.running) {
            const double pause = gap;
            past_ = Fault::none;
            repeat_ = false;
            pass_begun_ = false;
            pass_time_ = 0;
            if (resume && test_.begun() && test_.stop() == Stop::none) {
                const bool pause_known = pause >= 0 && pause < 1e7;
                time_ = test_.time() + (pause_known ? pause : 0);
                pass_ = test_.pass();
                visit_ = test_.visit();
                happen(Event::resumed, pause_known ? 0 : 1);
            } else {
                test_.clear();
                time_ = 0;
                pass_ = visit_ = bore_ = 0;
                happen(Event::begin);
            }
            sampled_ = false;
            turned_by_ = turned_for_ = 0;
            active_ = true;
        }
        if (!now_.running && active_) {
            happen(Event::end);
            active_ = false;
        }
    }

    void follow_pass(double dt) noexcept {
        if (now_.pass && !pass_begun_) {
            if (!test_.pass_open()) ++pass_;
            happen(Event::pass_begin);
        }
        if (!now_.pass && pass_begun_) happen(Event::pass_end);
        pass_begun_ = now_.pass;
        pass_time_ = now_.pass ? pass_time_ + dt : 0;
        if (pass_time_ > max_pass_time) fail(Fault::standstill);
    }

    void follow_bore(const Machine::Reading& at) noexcept {
        if (now_.bore && !before_.bore) {
            const double key = bore_key;
            bore_ = key >= 0.5 && key < 16.5 ? static_cast<std::int32_t>(std::lround(key)) : 0;
            ++visit_;
            repeat_ = false;
            visit_fault_ = bore_ == 0                                            ? Fault::bore
                           : !machine.at(turned_)                                ? Fault::orientation
                           : !compensation_.confirmed() || !cooling_.confirmed() ? Fault::unconfirmed
                                                                                 : Fault::none;
        }
        if (!now_.bore && before_.bore) close_visit();
        if (!now_.bore) return;
        if (overtravel) visit_fault_ = Fault::overtravel;
        if (now_.measuring && !before_.measuring) {
            latched_ = false;
            direction_ = 0;
        }
        if (now_.measuring && !latched_) latch(at);
        if (!now_.measuring && before_.measuring && !latched_) visit_fault_ = Fault::probe_miss;
    }

    // The direction is the fastest motion before the touch: at the touch the machine begins to brake.
    void latch(const Machine::Reading& at) noexcept {
        if (!at.good) {
            visit_fault_ = Fault::position;
            return;
        }
        int fastest = 0;
        for (int i = 1; i < 3; ++i)
            if (std::abs(at.velocity[i]) > std::abs(at.velocity[fastest])) fastest = i;
        if (!now_.probe && at.velocity[fastest] != 0)
            direction_ = at.velocity[fastest] > 0 ? fastest + 1 : -fastest - 1;
        if (!now_.probe || before_.probe) return;
        latched_ = true;
        if (direction_ == 0) {
            visit_fault_ = Fault::probe_miss;
            return;
        }
        Record r = record(Kind::touch, direction_);
        r.x = at.position[0], r.y = at.position[1], r.z = at.position[2];
        r.x_offset = at.offset[0], r.y_offset = at.offset[1], r.z_offset = at.offset[2];
        take(r);
        for (std::size_t i = 0; i < 3; ++i) {
            touch[i] = at.position[i];
            touch_offset[i] = at.offset[i];
        }
    }

    void close_visit() noexcept {
        if (visit_fault_ == Fault::none)
            visit_fault_ = test_.visit() == visit_
                               ? test_.judged(bore_, turned_, compensation_.is(), settings_)
                               : Fault::probe_miss;
        repeat_ = visit_fault_ != Fault::none;
        if (repeat_) {
            happen(Event::rejected);
            fail(visit_fault_);
            return;
        }
        if (is_of_visit(past_)) past_ = Fault::none;
        happen(Event::measured);
        for (std::size_t i = 0; i < 3; ++i)
            bore[i] = i == 0 ? test_.bore().x : i == 1 ? test_.bore().y : test_.bore().z;
        const double diameter = ball;
        const double size = std::abs(diameter) <= 1e6 ? diameter : 0;
        bore_diameter = 2 * test_.bore().radius + (boss ? -size : size);
        bore_scatter = test_.bore().scatter;
    }

    // Faults that a good visit ends.
    static bool is_of_visit(Fault fault) noexcept {
        return fault == Fault::probe_miss || fault == Fault::false_trigger || fault == Fault::overtravel ||
               fault == Fault::orientation || fault == Fault::position || fault == Fault::bore ||
               fault == Fault::unconfirmed;
    }

    void follow_cycle() noexcept {
        if (now_.cycle && !before_.cycle) happen(Event::cycle_end);
    }

    void follow_speed(double dt) noexcept {
        const double speed = std::abs(spindle_speed);
        if (!(speed <= 1e6)) return;
        turned_by_ += speed * dt;
        turned_for_ += dt;
    }

    void sample(const Temperatures::Reading& warmth) noexcept {
        const double every = temperatures.sample_time;
        if (sampled_ && time_ - last_sample_ < (every >= 1 && every <= 3600 ? every : 60)) return;
        sampled_ = true;
        last_sample_ = time_;
        for (std::int32_t i = 0; i < warmth.count; ++i) {
            const auto sensor = static_cast<std::size_t>(i);
            Record r = record(Kind::temperature, i + 1);
            const bool valid = std::isfinite(warmth.value[sensor]);
            r.x = valid ? warmth.value[sensor] : 0;
            r.y = valid ? 1 : 0;
            r.z = warmth.age[sensor];
            take(r);
        }
        if (turned_for_ > 0) {
            Record r = record(Kind::speed, 0);
            r.x = turned_by_ / turned_for_;
            take(r);
        }
        turned_by_ = turned_for_ = 0;
    }

    void decide() noexcept {
        if (test_.stop() != Stop::none || test_.records().size() == decided_) return;
        decided_ = test_.records().size();
        const Stop stop = test_.decision(time_, settings_);
        if (stop == Stop::none) return;
        happen(Event::stop, static_cast<double>(stop));
        if (stop == Stop::maximum_time) fail(Fault::not_stable);
        if (!test_.warmed(settings_)) fail(Fault::no_warm_up);
    }

    void walk() noexcept {
        if (rows.wants_forget() && !active_) test_.clear();
        if (rows.wants_restore()) rows.restored(!active_ && test_.take(row.given(), settings_));
        rows.show(static_cast<std::int32_t>(test_.records().size()),
                  [&](std::int32_t i) noexcept { row.show(test_.records()[static_cast<std::size_t>(i)]); });
    }

    void show(const Machine::Reading& at, const Temperatures::Reading& warmth, bool settings_good) noexcept {
        const bool ended = test_.stop() != Stop::none;
        state = !active_    ? (!test_.begun() ? State::idle
                               : ended        ? State::stopped
                                              : State::interrupted)
                : now_.pass ? (pass_ <= 1 ? State::probing_cold : State::probing)
                : ended     ? State::stopped
                            : State::warming;
        stop_reason = test_.stop();
        done = ended;
        cycle_index = test_.cycles();
        pass = test_.pass();
        visit = test_.visit();
        touches = test_.touches();
        elapsed = active_ ? time_ : test_.time();
        if (test_.records().size() != changed_) {
            changed_ = test_.records().size();
            const double now = test_.change(settings_);
            change = now <= 1000 ? now : 1000;
        }
        repeat = repeat_;
        compensation_request = wants_compensation_;
        cooling_request = wants_cooling_;
        confirmed = compensation_.confirmed() && cooling_.confirmed();
        advice = hal::first<Advice>({{!settings_.stop.usual(), Advice::threshold},
                                     {!settings_.stop.by_displacement, Advice::one_rule}});
        fault = hal::first<Fault>({{past_ != Fault::none, past_},
                                   {!at.good, Fault::position},
                                   {!warmth.good, Fault::sensor},
                                   {!settings_good, Fault::settings},
                                   {unconfirmed_, Fault::unconfirmed},
                                   {!warmth.artifact_good, Fault::artifact_temperature}});
    }

    GrowthTest test_;
    GrowthTest::Settings settings_;  // last good values
    Bits now_, before_;
    ConfirmedState compensation_, cooling_;
    bool active_ = false, sampled_ = false, pass_begun_ = false, latched_ = false, repeat_ = false,
         unconfirmed_ = false;
    bool turned_ = false, wants_compensation_ = false, wants_cooling_ = false;
    std::int32_t pass_ = 0, visit_ = 0, bore_ = 0, direction_ = 0;
    Fault past_ = Fault::none, visit_fault_ = Fault::none;
    double time_ = 0, last_sample_ = 0, pass_time_ = 0;
    double turned_by_ = 0, turned_for_ = 0;  // rpm s and s, since the last sample
    std::size_t decided_ = 0, changed_ = SIZE_MAX;
};

hal::Model hal::model() {
    return model_of<ThermalGrowthTest>();
}

}  // namespace plumb
