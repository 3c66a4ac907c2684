// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"
#include "components/plants/sim_artifact/artifact_geometry.hpp"
#include "components/plants/sim_artifact/compensation_under_test.hpp"
#include "components/plants/sim_artifact/growth_program.hpp"
#include "components/plants/sim_artifact/temperature_sensors.hpp"
#include "components/plants/sim_artifact/touch_probe.hpp"
#include "components/plants/sim_artifact/warm_machine.hpp"
#include "pages/sim_artifact.page.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

struct SimArtifact final : hal::Component {
    static constexpr hal::About about{
        "sim_artifact",
        "simulated machine that grows, with an artifact on its table and a probe in its spindle", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine."};
    hal::Axes<hal::In<double>, 3> command{this, "%-position-cmd", 0.0, "mu", "Command of the drive of %."};
    hal::In<double> table_cmd{this, "table-position-cmd", 0, "deg", "Command of the table."};
    hal::In<double> spindle_speed{this, "spindle-speed-cmd", 0, "rpm", "Commanded speed of the spindle."};
    hal::In<bool> tool_changed{this, "tool-changed", false, "A rising edge puts the probe into the spindle."};
    hal::In<bool> trunnion{this, "trunnion", false, "The table is a trunnion, which turns about X."};
    hal::Axes<hal::In<double>, 3> slip{this, "slip-%", 0.0, "mu",
                                       "How far the artifact has slipped on its table in %."};
    hal::In<bool> cooling{this, "cooling-request", false, "Temperature control shall be on."};
    hal::In<bool> repeat{this, "repeat", false, "The last visit does not count; probe again."};
    hal::In<bool> done{this, "done", false, "The machine is warm; one more pass, and the program ends."};
    GrowthProgram program{this};
    WarmMachine machine{this};
    TouchProbe touch_probe{this};
    TemperatureSensors sensors{this};
    CompensationUnderTest compensation{this};

    hal::Axes<hal::Out<double>, 3> position{this, "%-position", "mu", "Position of % by its encoder."};
    hal::Axes<hal::Out<double>, 3> velocity{this, "%-velocity", "mu/s", "Velocity of %."};
    hal::Out<double> table_position{this, "table-position", "deg", "Position of the table."};
    hal::Out<double> turns{this, "spindle-speed", "rpm", "Speed of the spindle."};
    hal::Out<bool> probe{this, "probe", "The probe touches."};
    hal::Out<bool> cooling_on{this, "cooling-on", "Temperature control is on."};
    hal::Axes<hal::Out<double>, 3> deviation{this, "truth-%-deviation", "mu",
                                             "Deviation of the bore in %, without compensation."};
    hal::Axes<hal::Out<double>, 3> residual{this, "truth-%-residual", "mu",
                                            "The same with the present offset."};
    hal::Axes<hal::Out<double>, 3> steady{this, "truth-%-steady", "mu",
                                          "Deviation at work-speed for ever, artifact and table as now."};
    hal::Function run{this, "update", &SimArtifact::update, hal::Place::machine,
                      "After the commands of the axes."};

    void update(double dt) noexcept {
        const std::int32_t number = seed;
        if (!started_ || number != seed_) start(number);
        const GrowthProgram::Step step = program.step(repeat, done, dt);
        const bool plays = step_plays(step);
        const bool changes = tool_change_.rises(tool_changed);
        if (step.changed_tool || changes) touch_probe.mount(seed_);
        cooled_ = cooling;
        trunnion_ = trunnion;
        const double speed = plays ? step.speed : usable(spindle_speed, 1e5, 0);
        machine.step(seed_, speed, plays ? step.moving : moving_.value(), cooled_, dt);
        turns = speed;
        touch_probe.step(seed_, dt);
        compensation.read();
        sensors.step(seed_, machine.bodies(), compensation.sensor_error(), dt);
        auto sensitivities = machine.sensitivities(ArtifactGeometry::centre());
        // It was set where the probe works, while the spindle cools and its sensor lags behind.
        const double tau = machine.cooling_time(), usual = std::min(120.0, tau / 22.5);
        sensitivities[0] /= std::max(1 + (sensors.lag(seed_) - usual) / tau, 0.5);
        offset_ = compensation.step(sensitivities, sensors, dt);
        if (plays)
            play(step);
        else
            follow(dt);
        table_position = angle_;
        cooling_on = cooled_;
        show(step);
    }

private:
    void start(std::int32_t number) noexcept {
        seed_ = number;
        started_ = true;
        touch_probe.start(number);
        sensors.start(number, machine.bodies());
        compensation.start(number);
        for (std::size_t i = 0; i < 3; ++i) at_[i] = usable(command[i], 1e5, 0);
    }

    bool step_plays(const GrowthProgram::Step& step) noexcept {
        if (step.pass || step.speed != 0 || step.moving != 0) played_ = true;
        return played_;
    }

    // Of the artifact with its table: by the growth of the machine, and where it has slipped on the table.
    Eigen::Vector3d displacement() noexcept {
        const Eigen::Vector3d slipped(usable(slip[0], 1e3, 0), usable(slip[1], 1e3, 0),
                                      usable(slip[2], 1e3, 0));
        return machine.table_displacement() + ArtifactGeometry::turned(slipped, angle_, trunnion_);
    }

    Eigen::Vector3d place(int bore) noexcept {
        return ArtifactGeometry::bore_place(bore, machine.artifact_strain(), angle_, trunnion_,
                                            displacement());
    }

    // Of the bore or the sphere that is probed.
    Eigen::Vector3d place(const GrowthProgram::Step& step) noexcept {
        return step.sphere ? sphere_place() : place(step.bore);
    }
    Eigen::Vector3d sphere_place() noexcept {
        return ArtifactGeometry::sphere_place(machine.artifact_strain(), angle_, trunnion_, displacement());
    }
    Eigen::Vector3d cold_place(const GrowthProgram::Step& step) const noexcept {
        const Eigen::Vector3d still = Eigen::Vector3d::Zero();
        return step.sphere ? ArtifactGeometry::sphere_place(0, angle_, trunnion_, still)
                           : ArtifactGeometry::bore_place(step.bore, 0, angle_, trunnion_, still);
    }

    // Where the probe touches, as the encoders show it.
    void play(const GrowthProgram::Step& step) noexcept {
        angle_ = step.turned ? 180 : 0;
        static constexpr double sides[5][3] = {{0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
        const Eigen::Vector3d direction(sides[step.side][0], sides[step.side][1], sides[step.side][2]);
        const Eigen::Vector3d bore = place(step);
        const Eigen::Vector3d nominal = cold_place(step);
        Eigen::Vector3d target = step.sphere ? nominal
                                 : step.side == 0
                                     ? Eigen::Vector3d(nominal.x() + 25, nominal.y(), bore.z())
                                     : Eigen::Vector3d(nominal.x(), nominal.y(), nominal.z() - 10);
        Eigen::Vector3d p = target;
        if (step.touching) {
            const double reach = (step.sphere      ? -ArtifactGeometry::sphere_radius
                                  : step.side == 0 ? 0
                                                   : ArtifactBore::radius) -
                                 ArtifactGeometry::ball;
            const int axis = step.side == 0 ? 2 : (step.side - 1) / 2;
            const double along = bore[axis] - (machine.tip_error(bore) + touch_probe.displacement())[axis];
            const double travel = reach + touch_probe.pre_travel(seed_, direction) + touch_probe.noise(seed_);
            p[axis] = along + direction[axis] * travel;
        } else if (step.approaching) {
            p -= direction;
        }
        for (int i = 0; i < 3; ++i) {
            const auto axis = static_cast<std::size_t>(i);
            at_[axis] = p[i];
            position[axis] = p[i];
            velocity[axis] = step.touching || step.approaching ? 5 * direction[i] : 0;
        }
        probe = step.touching;
    }

    // The machine follows LinuxCNC, and the ball meets the artifact.
    void follow(double dt) noexcept {
        constexpr double lag = 0.003;  // s
        const double gain = -std::expm1(-dt / lag);
        double fastest = 0;
        Eigen::Vector3d ball;
        for (std::size_t i = 0; i < 3; ++i) {
            const double step = gain * (usable(command[i], 1e5, at_[i]) - at_[i]);
            at_[i] += step;
            position[i] = at_[i];
            velocity[i] = step / dt;
            direction_[static_cast<int>(i)] = step;
            fastest = std::max(fastest, std::abs(step / dt));
            ball[static_cast<int>(i)] = at_[i];
        }
        angle_ += gain * (usable(table_cmd, 1e6, angle_) - angle_);
        moving_.step(fastest > 1 ? 1 : 0, 60, dt);
        ball += machine.tip_error(ball) + touch_probe.displacement();
        probe = depth(ball) > trip_depth();
    }

    // Those of the approach hold while the ball touches: an offset that creeps does not turn the stylus.
    double trip_depth() noexcept {
        if (!touching_) {
            if (direction_.norm() > 1e-9) heading_ = direction_.normalized();
            error_ = touch_probe.noise(seed_);
        }
        return std::max(touch_probe.pre_travel(seed_, heading_) + error_, 1e-6);
    }

    // How far the ball is inside a block or the sphere, mm; negative outside.
    double depth(const Eigen::Vector3d& ball) noexcept {
        double deepest = -1;
        for (int i = 0; i < ArtifactGeometry::most; ++i) {
            const Eigen::Vector3d from = ball - place(i);
            const double radial = from.head<2>().norm(), r = ArtifactGeometry::ball;
            if (radial > ArtifactBore::face + r || from.z() > r + 1 || from.z() < -100) continue;
            const double wall = radial + r - ArtifactBore::radius, face = r - from.z();
            deepest = std::max(deepest,
                               radial < ArtifactBore::radius && from.z() < r ? std::min(wall, face) : face);
        }
        deepest = std::max(deepest, ArtifactGeometry::sphere_radius + ArtifactGeometry::ball -
                                        (ball - sphere_place()).norm());
        touching_ = deepest > 0;
        return deepest;
    }

    void show(const GrowthProgram::Step& step) noexcept {
        const Eigen::Vector3d now = place(step), cold = cold_place(step);
        const Eigen::Vector3d d = now - cold - machine.tip_error(now);
        const Eigen::Vector3d end = now - cold - machine.steady_tip_error(now, 8000);
        for (int i = 0; i < 3; ++i) {
            deviation[static_cast<std::size_t>(i)] = d[i];
            residual[static_cast<std::size_t>(i)] = d[i] - offset_[i];
            steady[static_cast<std::size_t>(i)] = end[i];
        }
    }

    std::int32_t seed_ = 0;
    bool started_ = false, cooled_ = false, trunnion_ = false, played_ = false;
    bool touching_ = false;
    Edge tool_change_;
    double angle_ = 0, error_ = 0;
    std::array<double, 3> at_{};
    Eigen::Vector3d offset_ = Eigen::Vector3d::Zero(), direction_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d heading_ = -Eigen::Vector3d::UnitZ();
    FirstOrderLag moving_;
};

hal::Model hal::model() {
    return model_of<SimArtifact>();
}

}  // namespace plumb
