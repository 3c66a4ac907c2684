// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/axis_growth/axis_growth_codes.hpp"
#include "components/compensation/axis_growth/axis_growth_inputs.hpp"
#include "components/math/blocks/authority.hpp"
#include "components/math/blocks/ramped_correction.hpp"
#include "hal/codes.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"

#include <array>
#include <cmath>

namespace plumb {

struct AxisGrowth final : hal::Component {
    static constexpr hal::About about{
        "axis_growth",
        "compensates thermal growth of X, Y and Z, by temperatures and spindle speed",
        R"(
A machine that warms displaces its tool in X, Y and Z, by 20 to 70 um. axis_growth follows up to four temperature sensors and
the spindle speed, and outputs the offset of each axis that brings the tool back. The offset may depend on the position of
the axis, as where a screw expands. plumb-growth(1) computes the settings from a growth test of the machine.

Use it where sensors are mounted, and for any work. The theory and the figures are in
components/compensation/axis_growth/README.md of the sources.)",
        hal::Wiring{R"(
For X. Wire Y and Z in the same way.

  loadrt axis_growth  names=axis-growth unit=[TRAJ]LINEAR_UNITS
  loadrt joint_offset names=x-stage,y-stage,z-stage \
         unit=[TRAJ]LINEAR_UNITS

  setp axis-growth.enable    true
  setp axis-growth.max-speed [TRAJ]MAX_LINEAR_VELOCITY

  net x-position      joint.0.pos-cmd
  net x-position      => axis-growth.x-position x-stage.position
  net all-homed       motion.is-all-homed => axis-growth.all-homed
  net spindle-speed   spindle.0.speed-out
  net spindle-speed   => axis-growth.spindle-speed
  net cycle-running   motion.digital-out-00
  net cycle-running   => axis-growth.cycle-running
  net spindle-warm    => axis-growth.temperature-0
  net spindle-valid   => axis-growth.temperature-valid-0
  net spindle-age     => axis-growth.temperature-age-0
  net x-growth-offset axis-growth.x-offset
  net x-growth-offset => x-stage.offset-0

  addf motion-command-handler  servo-thread
  addf x-stage.update-feedback servo-thread
  addf motion-controller       servo-thread
  addf axis-growth.update      servo-thread
  addf x-stage.update          servo-thread

spindle-warm, spindle-valid and spindle-age come from your sensor, such as modbus_sensor(1) or can_sensor(1). Number the sensors
as in the growth test. joint_offset(9) has the other lines of a stage.

thermal_displacement(9) may correct Z on the same machine. Give it the feedback of LinuxCNC, joint.2.motor-pos-fb, which does
not contain the offset of joint_offset(9): then it measures the growth that axis_growth leaves. Set its expected-growth and
unexplained-growth to a fifth.)"},
        hal::SettingUp{R"(
1. Mount the sensors: the spindle bearing, the column or bed, and the air. Net them to thermal_growth_test(9), too.
2. Run a growth test from the cold machine, with the dry cycle of your work.
3. plumb growth identify LOG prints the setp lines, and how much of the drift they would have removed. Copy them to
axis_growth_settings.hal.
4. Set enable true, and repeat the growth test on another day. The report shows the gain, 1 for a perfect compensation.
5. Keep unit=[TRAJ]LINEAR_UNITS in the loadrt line: on an inch machine it converts the defaults.)"},
        hal::Behaviour{R"(
- Start, not homed, a sensor never valid: No offset, and nothing moves.
- Temperatures, speed, enable, settings: The offsets change at max-rate, at most, as a vector.
- Motion: The part that depends on the position follows without lag.
- Position faster than max-speed: A position that changes faster, by more than a tenth, did not move. The offset follows at
max-rate.
- Temperature invalid, or older than max-age: Its last good value holds, and doubt is true. After hold-time the offset
returns to 0, within as long again.
- Growth in doubt: doubt-code gives the reason. authority is the part of the growth that is applied, of the axis that is
least certain. It falls with the uncertainty of the law, beyond the temperatures of the growth test, and with the age of a
lost temperature. With a larger harmless more of an uncertain growth is applied.
- In a cycle (cycle-running): authority never falls, so that no step is cut into a part.
- Machine off, emergency stop: joint_offset(9) holds the offset, and turning on moves nothing.
- Abort: The offsets follow the temperatures as before.
- Invalid position or speed: The last good value stays.
- Invalid settings: The last good set stays in force, as a whole.)"},
        hal::Limits{R"(
A sensor that is frozen but reports valid values looks like a machine that stands still. A sensor with an offset displaces the
axes by as much as that many kelvin. Repeat the growth test after you change a sensor.

The law is that of the growth test. Another dry cycle, coolant, or an open door can warm the machine in a way that the sensors
do not show. The artifact and the work expand themselves; axis_growth does not correct the work.

There is no sensor of the growth itself. thermal_displacement(9) measures what remains in Z.)"},
        hal::SeeAlso{"plumb-growth(1), thermal_growth_test(9), joint_offset(9), thermal_displacement(9)"}};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;
    using Fault = axis_growth::Fault;
    using Doubt = axis_growth::Doubt;
    using Settings = axis_growth::Settings;

    hal::LengthUnit unit{this};

    hal::In<bool> enable{this, "enable", false, "Apply the offsets; else 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::Axes<hal::In<double>, 3> position{this, "%-position", 0.0, "mu", "Commanded position of %."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm", "Speed of the spindle."};
    axis_growth::Sensors sensors{this};
    axis_growth::LawPins law{this};
    static constexpr hal::Range smoothings{0, 3600}, ages{0, 1e6}, errors{0, 1}, offsets{0, 100};
    static constexpr hal::Range rates{1e-6, 10}, axis_speeds{1e-6, 1e5};
    hal::In<double> smoothing{this,      "smoothing", 60, "s", "Time constant that smooths the temperatures.",
                              smoothings};
    hal::In<double> max_age{this, "max-age", 60, "s", "Largest age of a temperature.", ages};
    hal::In<double> hold_time{this,
                              "hold-time",
                              1800,
                              "s",
                              "Time without a temperature, after which the offset returns to 0.",
                              axis_growth::LawPins::times};
    hal::In<double> harmless{this, "harmless", 0.005, "mu", "An offset this wrong does no harm.", errors};
    hal::In<double> max_offset{this,   "max-offset", 0.15, "mu", "Largest offset of an axis, either way.",
                               offsets};
    hal::In<double> max_rate{this, "max-rate", 0.002, "mu/s", "Fastest change of the offsets but for motion.",
                             rates};
    hal::In<double> max_speed{this, "max-speed", 1000, "mu/s", "No axis moves faster.", axis_speeds};

    hal::Axes<hal::Out<double>, 3> offset{this, "%-offset", "mu", "Offset of %, for its stage."};
    hal::Axes<hal::Out<double>, 3> growth{this, "%-growth", "mu", "Growth of % here and now, by the law."};
    hal::Axes<hal::Out<double>, 3> growth_sigma{this, "%-growth-sigma", "mu",
                                                "Standard uncertainty of that growth."};
    hal::Out<double> authority{this, "authority", "1",
                               "Part of the growth that is applied, 0 to 1, of the least certain axis."};
    hal::Out<double> lost_age{this, "lost-age", "s",
                              "Time since a temperature was lost; 0 while all are valid."};
    hal::Out<bool> ramping{this, "ramping", "The offsets still change to their wanted values."};
    hal::Out<bool> limited{this, "limited", "The growth of an axis exceeds max-offset."};
    hal::Codes<Doubt> doubt{this, "doubt", "The growth may be wrong; doubt-code gives the reason."};
    hal::Codes<Fault> fault{this, "fault"};

    hal::Offset moves[3]{{this, moving(0)}, {this, moving(1)}, {this, moving(2)}};

    hal::Function run{this, "update", &AxisGrowth::update, hal::Place::source};

    void prepare() override { judge(); }

    void update(double dt) noexcept {
        const bool settings_good = judge();
        const bool jumped = read_position(dt);
        const double speed = spindle_speed;
        const bool speed_good = std::abs(speed) <= 1e6;
        speed_ = speed_good ? speed : speed_;
        sensors.step(
            settings_, [this](int i) noexcept { return settings_.law.uses(i); }, dt);

        const GrowthLaw::Line line =
            settings_.law.at(sensors.values(), drive_.step(speed_, settings_.drive, dt));
        const bool homed = all_homed;
        const bool applies = enable && homed && sensors.all_known();
        const double part = trust(line, applies);
        follow(line, applies, jumped, dt);

        const Eigen::Vector3d grown = line.at(position_, settings_.law.pivot);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int k = static_cast<int>(axis);
            offset[axis] = ramp_.offset()[k];
            growth[axis] = sensors.all_known() ? grown[k] : 0;
            growth_sigma[axis] = sigma_[k];
        }
        authority = applies ? part : 0;
        lost_age = sensors.lost();
        ramping = ramp_.ramping();
        limited = ramp_.limited();
        doubt = hal::first<Doubt>({{sensors.lost() > settings_.hold_time, Doubt::old},
                                   {sensors.lost() > 0, Doubt::sensor},
                                   {!sensors.outside().isZero(0), Doubt::range},
                                   {applies && unapplied_ > settings_.harmless, Doubt::uncertain}});
        fault = hal::first<Fault>({{!position_good_, Fault::position},
                                   {settings_.law.uses_speed() && !speed_good, Fault::speed},
                                   {!settings_good, Fault::settings}});
    }

private:
    static constexpr double play = 0.1;  // of max-speed: blended moves add up
    static constexpr double farthest = 1e6;

    hal::MovingPin moving(std::size_t axis) {
        return hal::MovingPin(offset[axis])
            .bound(max_offset)
            .rate(max_rate)
            .accelerated_by("The stage limits its acceleration, joint_offset(9) by offset-acceleration.")
            .limited(limited)
            .motion(position[axis], GrowthLaw::steepest);
    }

    // False if the settings contradict themselves; the last good set stays in force.
    bool judge() noexcept {
        Settings wanted;
        hal::SettingsReader read;
        law.read(wanted, read);
        wanted.smoothing = read(smoothing);
        wanted.max_age = read(max_age);
        wanted.hold_time = read(hold_time);
        wanted.harmless = read(harmless);
        wanted.max_offset = read(max_offset);
        wanted.max_rate = read(max_rate);
        wanted.max_speed = read(max_speed);
        wanted.in_range = read.good();
        if (!wanted.valid()) return false;
        settings_ = wanted;
        return true;
    }

    // Whether a position has changed faster than its axis can move.
    bool read_position(double dt) noexcept {
        bool jumped = false;
        position_good_ = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double now = position[axis];
            double& its = position_[static_cast<int>(axis)];
            const double last = its;
            its = usable(now, farthest, its);
            position_good_ &= std::abs(now) <= farthest;
            jumped |= std::abs(its - last) > settings_.max_speed * dt * (1 + play);
        }
        return jumped;
    }

    // The part of the growth that may be applied, by axis; returns the smallest.
    double trust(const GrowthLaw::Line& line, bool applies) noexcept {
        const bool holds = cycle_running && applies;
        double least = 1;
        unapplied_ = 0;
        for (int k = 0; k < 3; ++k) {
            const double beyond = settings_.law.growth.row(k).cwiseAbs() * sensors.outside();
            sigma_[k] = std::hypot(settings_.sigma[k], beyond);
            const double largest = std::abs(line.offset[k]) + std::abs(line.slope[k]) * settings_.travel[k];
            const Authority::Evidence evidence{largest, sigma_[k], sensors.lost(), 1};
            part_[k] = authority_[static_cast<std::size_t>(k)].step(
                evidence, holds, {1, 2, settings_.harmless, settings_.hold_time});
            if (largest > 0) least = std::min(least, part_[k]);
            unapplied_ = std::max(unapplied_, (1 - part_[k]) * largest);
        }
        return least;
    }

    // Motion moves the offset at once; the ramp takes every other change.
    void follow(const GrowthLaw::Line& line, bool applies, bool jumped, double dt) noexcept {
        const RampedCorrection::Wanted last = wanted_;
        RampedCorrection::Wanted before = last;
        if (!jumped) before.offset = applied_.at(position_, pivot_);
        applied_ = GrowthLaw::Line();
        if (applies) applied_ = {part_.cwiseProduct(line.offset), part_.cwiseProduct(line.slope)};
        pivot_ = settings_.law.pivot;
        wanted_.offset = applied_.at(position_, pivot_);
        wanted_.most = settings_.max_offset;
        ramp_.step(wanted_, before, settings_.max_rate, dt);
    }

    Settings settings_;  // last good values
    Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), pivot_ = position_;
    Eigen::Vector3d part_ = Eigen::Vector3d::Zero(), sigma_ = part_;
    double speed_ = 0, unapplied_ = 0;
    bool position_good_ = true;
    SpindleDrive drive_;
    std::array<Authority, 3> authority_;
    GrowthLaw::Line applied_;
    RampedCorrection::Wanted wanted_;
    RampedCorrection ramp_;
};

hal::Model hal::model() {
    return model_of<AxisGrowth>();
}

}  // namespace plumb
