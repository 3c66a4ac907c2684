// SPDX-License-Identifier: GPL-2.0-or-later
// LinuxCNC's motion of a joint, for tests that need no LinuxCNC.
#include "components/math/blocks/acceleration_limit.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

struct MotionJoint final : hal::Component {
    static constexpr hal::About about{"motion_joint", "LinuxCNC's motion of one joint", R"(
While it is on, the joint goes to program at the given speed and acceleration; while it is off, it is at its feedback.  A following
error turns it off.  Homing takes its feedback as 0, and is done after the final
move.)"};

    using Component::Component;

    hal::In<bool> on{this, "on", false, "The operator turns the machine on."};
    hal::In<bool> home{this, "home", false, "The joint is homed where it stands, when it rises."};
    hal::In<double> final_move{this, "final-move", 0, "s", "Time of homing after that."};
    hal::In<double> program{this, "program", 0, "mu", "Position wanted by the program."};
    hal::In<double> speed{this, "speed", 20, "mu/s", "Speed on the way there."};
    hal::In<double> acceleration{this, "acceleration", 1e9, "mu/s2", "Acceleration and braking on the way."};
    hal::In<double> max_error{this, "max-error", 1, "mu", "Largest following error."};
    hal::In<double> motor_feedback{this, "motor-feedback", 0, "mu", "Where the drive is."};
    hal::Out<bool> enabled{this, "enabled", "The machine is on."};
    hal::Out<bool> homed{this, "homed", "The joint is homed."};
    hal::Out<double> motor_command{this, "motor-command", "mu", "Where the drive is to be."};
    hal::Out<double> command{this, "command", "mu", "Commanded position of the joint."};
    hal::Out<double> error{this, "error", "mu", "Following error."};
    hal::Function run{this, "update", &MotionJoint::update, "After its feedback."};

    void update(double dt) noexcept {
        const double feedback = motor_feedback - origin_;
        if (!on) tripped_ = false;
        const double following = position_.value() - feedback;
        const bool runs = on && !tripped_;
        if (runs && was_on_ && !(std::abs(following) <= max_error)) tripped_ = true;
        if (!runs)
            stand_at(feedback, dt);
        else
            position_.step(program, {speed, speed, acceleration}, dt);
        was_on_ = runs;
        if (home && !homing_) {
            origin_ += feedback;
            stand_at(position_.value() - feedback, dt);
            moves_for_ = final_move;
        }
        homing_ = home;
        enabled = runs && !tripped_;
        homed = homing_ && moves_for_ <= 0;
        moves_for_ -= dt;
        motor_command = position_.value() + origin_;
        command = position_.value();
        error = following;
    }

private:
    void stand_at(double place, double dt) noexcept {
        position_.move_to(place, 1, dt);
        position_.hold();
    }

    AccelerationLimit position_;
    double origin_ = 0, moves_for_ = 0;
    bool was_on_ = false, tripped_ = false, homing_ = false;
};

hal::Model hal::model() {
    return model_of<MotionJoint>();
}

}  // namespace plumb
