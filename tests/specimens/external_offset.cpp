// SPDX-License-Identifier: GPL-2.0-or-later
// LinuxCNC's handling of the external offset of an axis, for tests that need no LinuxCNC.
#include "components/math/blocks/bounded.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

struct ExternalOffset final : hal::Component {
    static constexpr hal::About about{"external_offset", "LinuxCNC's external offset of one axis", R"(
A step of the counts adds to the offset that is asked for, while the machine is on and homed; else it is lost.  The axis
follows within a speed and an acceleration while it is moved as an axis, and not beyond the upper limit.  Turning the
machine on forgets the offset and leaves the axis where it is.)"};

    using Component::Component;

    hal::In<std::int32_t> counts{this, "counts", 0, "Counts."};
    hal::In<double> scale{this, "scale", 0, "mu", "Offset of one count."};
    hal::In<bool> enable{this, "enable", false, "Listens to the counts."};
    hal::In<bool> clear{this, "clear", false, "Takes the offset back at once."};
    hal::In<bool> on{this, "on", false, "The machine is on."};
    hal::In<bool> homed{this, "homed", false, "The machine is homed."};
    hal::In<bool> joint_mode{this, "joint-mode", false, "Joints are moved, not axes."};
    hal::In<double> program{this, "program", 0, "mu", "Where the program wants the axis."};
    hal::In<double> limit{this, "limit", 1e9, "mu", "Upper limit of the axis."};
    hal::In<double> max_velocity{this, "max-velocity", 40, "mu/s", "Fastest change of the offset."};
    hal::In<double> max_acceleration{this, "max-acceleration", 400, "mu/s2", "Hardest change of it."};
    hal::Out<bool> enabled{this, "enabled", "The machine is on."};
    hal::Out<double> request{this, "request", "mu", "Offset that is asked for."};
    hal::Out<double> offset{this, "offset", "mu", "Offset in force."};
    hal::Out<bool> limited{this, "limited", "The limit holds the axis."};
    hal::Out<double> position{this, "position", "mu", "Where the axis is."};
    hal::Function run{this, "update", &ExternalOffset::update, "Before the stage."};

    void update(double dt) noexcept {
        const bool turned_on = on && !on_;
        on_ = on;
        if (turned_on) {
            shift_ += offset_;
            offset_ = velocity_ = request_ = shown_ = 0;
        }
        bool holds = false;
        if (on_ && homed && !joint_mode) {
            plan(dt);
            const double most = limit - program - shift_;
            holds = offset_ != 0 && offset_ >= most;
            if (holds) {
                offset_ = most;
                velocity_ = 0;
            }
        }
        listen();
        enabled = on_;
        request = shown_;
        offset = offset_;
        limited = holds;
        position = program + shift_ + offset_;
    }

private:
    void plan(double dt) noexcept {
        const double dv = max_acceleration * dt;
        if (!listening_) request_ = offset_;
        const double error = request_ - offset_;
        const double braking = std::sqrt(2 * max_acceleration * std::abs(error) + dv * dv) - dv;
        const double wanted =
            std::abs(error) > dv * dt * 1e-3 ? bounded(std::copysign(braking, error), max_velocity) : 0;
        velocity_ += bounded(wanted - velocity_, dv);
        offset_ += velocity_ * dt;
    }

    void listen() noexcept {
        const std::int32_t now = counts;
        const double step = (static_cast<double>(now) - counts_) * scale;
        counts_ = now;
        listening_ = enable;
        if (!listening_) return;
        if (clear)
            shown_ = request_ = 0;
        else if (step != 0 && on_ && homed)
            shown_ = request_ += step;
    }

    double offset_ = 0, velocity_ = 0, shift_ = 0;
    double request_ = 0, shown_ = 0;  // the pin keeps its value while nothing listens
    std::int32_t counts_ = 0;
    bool on_ = false, listening_ = false;
};

hal::Model hal::model() {
    return model_of<ExternalOffset>();
}

}  // namespace plumb
