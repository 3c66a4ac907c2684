// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth_test/growth_test_inputs.hpp"
#include "components/compensation/thermal_growth_test/growth_test_report.hpp"

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

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};
    Program program{this};
    Machine machine{this};
    Temperatures temperatures{this};
    StopSettings stop_settings{this};

    TestReport report{this};
    hal::Records rows{this};
    GrowthRow row{this};

    hal::Function run{this, "update", &ThermalGrowthTest::update, hal::Place::measurement};

    void prepare() override {
        test_.reserve();
        test_.clear();
    }

    void update(double dt) noexcept {
        Signals now = program.read(dt);
        machine.read(now.at);
        now.oriented = machine.oriented(now.turned);
        temperatures.read(now.warmth);
        GrowthTest::Settings wanted = stop_settings.read();
        const bool good_settings = wanted.valid();
        if (good_settings) settings_ = wanted;
        settings_.stop.sensors = now.warmth.decides;

        if (program.acknowledges()) test_.acknowledge();
        const GrowthTest::Result result = test_.step(now, settings_, dt);
        walk();

        report.show(test_, settings_);
        if (result == GrowthTest::Result::touch) report.show_touch(now.at);
        if (result == GrowthTest::Result::bore) report.show_bore(test_.bore());
        report.show_states(program.wants_compensation(), program.wants_cooling(), now.confirmed);
        report.fault = hal::first<Fault>({{test_.fault() != Fault::none, test_.fault()},
                                          {!now.at.good, Fault::position},
                                          {!now.warmth.good, Fault::sensor},
                                          {!good_settings, Fault::settings},
                                          {program.unconfirmed(), Fault::unconfirmed},
                                          {!now.warmth.artifact_good, Fault::artifact_temperature}});
    }

private:
    void walk() noexcept {
        if (rows.wants_forget() && !test_.active()) test_.clear();
        if (rows.wants_restore()) rows.restored(test_.restore(row.given(), settings_));
        rows.show(static_cast<std::int32_t>(test_.records().size()),
                  [&](std::int32_t i) noexcept { row.show(test_.records()[static_cast<std::size_t>(i)]); });
    }

    GrowthTest test_;
    GrowthTest::Settings settings_;  // last good values
};

hal::Model hal::model() {
    return model_of<ThermalGrowthTest>();
}

}  // namespace plumb
