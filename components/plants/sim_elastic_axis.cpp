// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/stroked_load.hpp"
#include "pages/sim_elastic_axis.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

struct SimElasticAxis final : hal::Component {
    static constexpr hal::About about{
        "sim_elastic_axis", "simulated axis of two masses: PI velocity loop, spring, friction with memory",
        page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the axis; 0 is the typical one."};
    hal::In<double> position_cmd{this, "position-cmd", 0, "mu", "Command of the drive."};
    hal::In<double> force_part{this, "force-part", 1, "1", "Force of the drive now, part of force-limit."};
    hal::In<bool> jammed{this, "jammed", false, "The load stands."};
    hal::In<double> slip{this, "slip", 0, "mu", "Added to the reading of the scale."};
    hal::In<double> integral_time{this, "integral-time", 0, "s",
                                  "Integral time of the position loop; 0 without an integral."};

    Drawn servo_gain{this, "servo-gain", 30, 15, 60, "1/s", "Gain Kv of the position loop"};
    Drawn feed_forward{this, "feed-forward", 0.5, 0, 1.25, "1", "Part of the commanded velocity fed forward"};
    Drawn velocity_gain{this, "velocity-gain", 150, 90, 190, "1/s", "Gain of the velocity loop"};
    Drawn force_limit{this, "force-limit", 3000, 1000, 10000, "mu/s2", "Largest acceleration by the motor"};
    Drawn friction{this, "friction", 100, 30, 200, "mu/s2", "Friction of the load"};
    Drawn friction_travel{
        this, "friction-travel", 0.01, 0.002, 0.03, "mu", "Travel in which friction builds up"};
    Drawn load_part{this, "load-part", 0.4, 0.2, 0.6, "1", "Part of the mass that is behind the spring"};
    Drawn resonance{this, "resonance", 80, 30, 120, "Hz", "Resonance of the load on a motor that stands"};
    Drawn damping{this, "damping", 0.05, 0.02, 0.1, "1", "Damping of that resonance"};
    Drawn command_delay{this, "command-delay", 0.002, 0.001, 0.004, "s", "Delay of the command"};
    Drawn resolution{this, "resolution", 0.0002, 0.0001, 0.001, "mu", "Step of the scale"};

    hal::Out<double> position{this, "position", "mu", "Position that the scale reads."};
    StrokedLoad stroked{this};
    hal::Out<double> truth_force_limit{this, "truth-force-limit", "mu/s2", "The force-limit of this axis."};
    hal::Out<double> truth_friction{this, "truth-friction", "mu/s2", "The friction of this axis."};
    hal::Function run{this, "update", &SimElasticAxis::update, hal::Place::machine,
                      "After the command of the axis."};

    void update(double dt) noexcept {
        const double given = position_cmd, part = force_part, moved = slip;
        command_ = usable(given, 1e6, command_);
        if (!started_) {
            started_ = true;
            late_.fill(command_);
            motor_ = load_ = last_ = command_;
            stroked.start(command_);
        }
        read();
        part_ = std::clamp(usable(part, 1e6, part_), 0.0, 1.0);
        slip_ = usable(moved, 1e6, slip_);
        jams_ = jammed;
        late_.take(command_);
        const double target = late_.at(delay_, dt), from = last_;
        last_ = target;
        for (int i = 1; i <= steps; ++i)
            step(from + (target - from) * i / steps, (target - from) / dt, dt / steps);
        stroked.step(load_, dt);
        const double reading = load_ + slip_;
        position = step_ > 0 ? std::round(reading / step_) * step_ : reading;
        truth_force_limit = limit_;
        truth_friction = friction_;
    }

private:
    static constexpr int steps = 20;  // within a period

    void read() noexcept {
        const std::int32_t number = seed;
        gain_ = servo_gain(number);
        forward_ = feed_forward(number);
        velocity_gain_ = velocity_gain(number);
        limit_ = std::max(force_limit(number), 1.0);
        friction_ = friction(number);
        travel_ = std::max(friction_travel(number), 1e-6);
        load_mass_ = std::clamp(load_part(number), 0.01, 0.99);
        resonance_ = 2 * pi * std::max(resonance(number), 1.0);
        damping_ = damping(number);
        delay_ = command_delay(number);
        step_ = resolution(number);
        const double time = integral_time;
        lag_time_ = usable(time, 1e6, lag_time_);
    }

    void step(double command, double command_velocity, double dt) noexcept {
        const double lag = command - motor_, late = lag_time_ > 0 ? lag + lags_ / lag_time_ : lag;
        const double wanted = gain_ * late + forward_ * command_velocity;
        const double error = wanted - motor_velocity_, most = limit_ * part_;
        const double force = velocity_gain_ * error + velocity_gain_ * velocity_gain_ / 4 * integral_;
        const double driven = std::clamp(force, -most, most);
        if (force == driven || force * error < 0) integral_ += error * dt;
        if (lag_time_ > 0 && (force == driven || force * lag < 0)) lags_ += lag * dt;
        const double spring = load_mass_ * (resonance_ * resonance_ * (motor_ - load_) +
                                            2 * damping_ * resonance_ * (motor_velocity_ - load_velocity_));
        motor_velocity_ += (driven - spring) / (1 - load_mass_) * dt;
        if (jams_)
            load_velocity_ = 0;
        else
            load_velocity_ += (spring - resisting(load_velocity_, dt)) / load_mass_ * dt;
        motor_ += motor_velocity_ * dt;
        load_ += load_velocity_ * dt;
    }

    // Dahl: a spring that yields, F' = (friction / travel) v (1 - F / friction), to either side.
    double resisting(double velocity, double dt) noexcept {
        if (!(friction_ > 0)) return 0;
        const double end = std::copysign(friction_, velocity);
        held_ = end + (held_ - end) * std::exp(-std::abs(velocity) * dt / travel_);
        return held_;
    }

    LateCommand late_;
    bool started_ = false, jams_ = false;
    double gain_ = 0, forward_ = 0, velocity_gain_ = 0, limit_ = 1, friction_ = 0, travel_ = 1,
           load_mass_ = 0.5, resonance_ = 1, damping_ = 0, delay_ = 0, step_ = 0, part_ = 1, slip_ = 0,
           lag_time_ = 0;
    double command_ = 0, last_ = 0, integral_ = 0, lags_ = 0, held_ = 0;
    double motor_ = 0, motor_velocity_ = 0, load_ = 0, load_velocity_ = 0;
};

hal::Model hal::model() {
    return model_of<SimElasticAxis>();
}

}  // namespace plumb
