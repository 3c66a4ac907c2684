// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/stroked_load.hpp"
#include "pages/sim_grinder.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

struct SimGrinder final : hal::Component {
    static constexpr hal::About about{
        "sim_grinder", "simulated reciprocating axis: drive, friction, backlash, load and scale", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the axis; 0 is the typical one."};
    hal::In<double> position_cmd{this, "position-cmd", 0, "mu", "Command of the drive."};
    hal::In<bool> enabled{this, "enabled", true, "The drive is on."};
    hal::In<double> push_speed{this, "push-speed", 0, "mu/s",
                               "Speed at which a hand pushes the axis while the drive is off."};
    hal::In<bool> scale_at_load{this, "scale-at-load", true, "The scale reads the load, not the motor."};
    hal::In<double> contact_low{this, "contact-low", 0, "mu", "Lower end of the work."};
    hal::In<double> contact_high{this, "contact-high", 0, "mu", "Upper end of the work."};

    Drawn servo_gain{this, "servo-gain", 35, 17, 60, "1/s", "Gain Kv of the position loop"};
    Drawn feed_forward{this, "feed-forward", 0, 0, 1, "1", "Part of the commanded velocity fed forward"};
    Drawn velocity_loop{this, "velocity-loop", 60, 30, 80, "Hz", "Natural frequency of the velocity loop"};
    Drawn damping{this, "damping", 0.7, 0.5, 0.8, "1", "Damping of the velocity loop"};
    Drawn force_limit{this, "force-limit", 5000, 1000, 20000, "mu/s2", "Largest acceleration by the motor"};
    Drawn friction{this, "friction", 0.15, 0.1, 0.3, "1", "Coulomb friction, part of force-limit"};
    Drawn stiction{this, "stiction", 0.2, 0.1, 0.4, "1", "Friction at rest beyond that, part of friction"};
    Drawn stribeck_speed{this, "stribeck-speed", 2, 1, 5, "mu/s", "Speed at which that has faded"};
    Drawn backlash{this, "backlash", 0.001, 0, 0.003, "mu", "Backlash between motor and load"};
    Drawn load_resonance{this, "load-resonance", 0, 40, 120, "Hz", "Resonance of the load on the motor"};
    Drawn load_damping{this, "load-damping", 0.1, 0.05, 0.2, "1", "Damping of that resonance"};
    Drawn command_delay{this, "command-delay", 0.002, 0.001, 0.003, "s", "Delay of the command"};
    Drawn wheel_force{this, "wheel-force", 0, 0, 0.1, "1", "Force of the wheel, part of force-limit"};
    Drawn resolution{this, "resolution", 0.0001, 0.0001, 0.001, "mu", "Step of the scale"};

    hal::Out<double> position{this, "position", "mu", "Position that the scale reads."};
    hal::Out<bool> truth_contact{this, "truth-contact", "The wheel is on the work."};
    StrokedLoad stroked{this};
    hal::Out<double> truth_acceleration{this, "truth-acceleration", "mu/s2",
                                        "Peak of the motor, last stroke."};
    hal::Out<double> truth_force_limit{this, "truth-force-limit", "mu/s2", "The force-limit of this axis."};
    hal::Function run{this, "update", &SimGrinder::update, hal::Place::machine,
                      "After the command of the axis."};

    void update(double dt) noexcept {
        const double given = position_cmd;
        command_ = usable(given, 1e6, command_);
        if (!started_) {
            started_ = true;
            late_.fill(command_);
            motor_ = load_ = play_ = last_play_ = last_ = command_;
            stroked.start(command_);
        }
        seed_ = seed;
        read();
        const bool on = enabled;
        if (!on) {
            velocity_ = integral_ = 0;
            motor_ += pushed_ * dt;
            late_.fill(motor_);
            last_ = motor_;
        } else {
            if (!on_) late_.fill(command_);
            late_.take(command_);
        }
        on_ = on;
        const double target = late_.at(delay_, dt), from = last_;
        last_ = target;
        for (int i = 1; i <= steps; ++i)
            step(from + (target - from) * i / steps, (target - from) / dt, on, dt / steps);
        if (stroked.step(load_, dt)) {
            truth_acceleration = hardest_;
            hardest_ = 0;
        }
        const double read_position = scale_at_load ? load_ : motor_;
        position = step_ > 0 ? std::round(read_position / step_) * step_ : read_position;
        truth_contact = touches_;
        truth_force_limit = limit_;
    }

private:
    static constexpr int steps = 20;  // within a period

    void read() noexcept {
        gain_ = servo_gain(seed_);
        forward_ = feed_forward(seed_);
        loop_ = std::max(2 * pi * velocity_loop(seed_), 1.0);
        damping_ = damping(seed_);
        limit_ = std::max(force_limit(seed_), 1.0);
        friction_ = friction(seed_) * limit_;
        stiction_ = stiction(seed_);
        stribeck_ = std::max(stribeck_speed(seed_), 1e-3);
        backlash_ = backlash(seed_);
        resonance_ = 2 * pi * load_resonance(seed_);
        load_loss_ = load_damping(seed_);
        delay_ = command_delay(seed_);
        wheel_ = wheel_force(seed_) * limit_;
        step_ = resolution(seed_);
        pushed_ = usable(push_speed, 1e4, pushed_);
        low_ = usable(contact_low, 1e6, low_);
        high_ = usable(contact_high, 1e6, high_);
    }

    void step(double command, double command_velocity, bool on, double dt) noexcept {
        double motor_force = 0;
        if (on) {
            const double wanted = gain_ * (command - motor_) + forward_ * command_velocity;
            const double error = wanted - velocity_;
            const double force = loop_ * loop_ * (integral_ + error * dt) - 2 * damping_ * loop_ * velocity_;
            motor_force = std::clamp(force, -limit_, limit_);
            if (force == motor_force || force * error < 0) integral_ += error * dt;
            touches_ = high_ > low_ && load_ >= low_ && load_ <= high_;
            advance(motor_force, friction_at(velocity_) + (touches_ ? wheel_ : 0), dt);
        }
        hardest_ = std::max(hardest_, std::abs(motor_force));
        // Play, and a load on a spring.
        play_ = std::clamp(play_, motor_ - backlash_ / 2, motor_ + backlash_ / 2);
        if (resonance_ > 0) {
            const double play_velocity = (play_ - last_play_) / dt;
            load_velocity_ += (resonance_ * resonance_ * (play_ - load_) +
                               2 * load_loss_ * resonance_ * (play_velocity - load_velocity_)) *
                              dt;
            load_ += load_velocity_ * dt;
        } else {
            load_ = play_;
        }
        last_play_ = play_;
    }

    double friction_at(double velocity) const noexcept {
        const double part = velocity / stribeck_;
        return friction_ * (1 + stiction_ * std::exp(-part * part));
    }

    // Friction stops a motion and holds at rest; it never drives.
    void advance(double force, double resisting, double dt) noexcept {
        const double free = velocity_ + force * dt, most = resisting * dt;
        const double before = velocity_;
        const double against = velocity_ != 0 ? std::copysign(1.0, velocity_) : std::copysign(1.0, free);
        velocity_ = free - against * most;
        if (before != 0 ? velocity_ * before < 0 : velocity_ * free < 0) velocity_ = 0;
        motor_ += (before + velocity_) / 2 * dt;
    }

    LateCommand late_;
    std::int32_t seed_ = 0;
    bool started_ = false, on_ = false, touches_ = false;
    double gain_ = 0, forward_ = 0, loop_ = 0, damping_ = 0, limit_ = 0, friction_ = 0, stiction_ = 0,
           stribeck_ = 1, backlash_ = 0, resonance_ = 0, load_loss_ = 0, delay_ = 0, wheel_ = 0, step_ = 0;
    double low_ = 0, high_ = 0, pushed_ = 0;
    double command_ = 0, last_ = 0;
    double motor_ = 0, velocity_ = 0, integral_ = 0, play_ = 0, last_play_ = 0, load_ = 0, load_velocity_ = 0;
    double hardest_ = 0;
};

hal::Model hal::model() {
    return model_of<SimGrinder>();
}

}  // namespace plumb
