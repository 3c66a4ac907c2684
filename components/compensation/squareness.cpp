// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/error_tables.hpp"
#include "components/compensation/squareness_model.hpp"
#include "components/compensation/squareness_settings.hpp"
#include "components/math/ramped_correction.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace plumb {

struct Squareness final : hal::Component {
    static constexpr hal::About about{"squareness", "correct tilted columns and rails, with the tool", R"(
A machine whose columns and rails lean puts the tip of the tool elsewhere than it says.  The operator tells which axes
carry work and tool, and by how much each of them leans; the correction c of X, Y and Z brings the tip to where an ideal
machine would have it, tool length and radial offset included:

    tip(q + c) = ideal tip(q)         q = position - pivot

Positions and velocities are those of the joints, joint.N.pos-cmd and joint.N.vel-cmd.  Corrections go to the stages of
the joints, joint_offset.

limited-code:

    1 an angle is beyond max-angle
    2 the correction is beyond max-correction
    3 a position changed faster than max-speed: the correction follows by max-rate
    4 a table does not reach the position: its last value is in force

fault-code:

    1 a position or velocity is not a number, or beyond 1e6: the last good one stays
    2 a tool offset likewise, or beyond 1e4
    3 an angle, a pivot, a radial or reference offset likewise, or an angle of 0.1 rad or more
    4 max-angle (to 0.1), max-correction (to 100), max-rate (to 10) or max-speed (to 1e5): the last good set is in force
    5 an angle or pivot of an axis that the chain does not have: likewise
    6 to-bed, and no axis rides on one parallel to it: likewise
    7 radial-offset has no radial-direction: likewise
    8 the tables could not be read anew: those before stay)"};

    using Component::Component;

    hal::Option<std::string> chain{this, "chain", "w-X-Y.b-Z-C-t",
                                   "Which axes carry the work, before b, and the tool, after it."};
    hal::Option<std::string> table{this, "table", "",
                                   "CSV files of error tables, absolute paths, with : between."};
    hal::Option<std::string> unit{this, "unit", "mm", "Machine unit, mm or inch."};

    hal::In<bool> enable{this, "enable", false, "Apply the correction; else 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    SquarenessSettings settings{this};
    hal::In<double> tool_offset[3]{{this, "x-tool-offset", 0, "mu", "Offset of the tool in force, in X."},
                                   {this, "y-tool-offset", 0, "mu", "Likewise in Y."},
                                   {this, "z-tool-offset", 0, "mu", "Likewise in Z."}};
    hal::In<bool> reload{this, "reload", false, "Read the tables anew, when it rises."};

    hal::Out<double> correction[3]{{this, "x-correction", "mu", "What is to be added to X, by a stage."},
                                   {this, "y-correction", "mu", "Likewise to Y."},
                                   {this, "z-correction", "mu", "Likewise to Z."}};
    hal::Out<double> corrected_position[3]{
        {this, "x-corrected-position", "mu", "Commanded position of X with its correction."},
        {this, "y-corrected-position", "mu", "Likewise of Y."},
        {this, "z-corrected-position", "mu", "Likewise of Z."}};
    hal::Out<double> corrected_velocity[3]{{this, "x-corrected-velocity", "mu/s", "Its velocity."},
                                           {this, "y-corrected-velocity", "mu/s", "Likewise of Y."},
                                           {this, "z-corrected-velocity", "mu/s", "Likewise of Z."}};
    hal::Out<double> error[3]{{this, "x-error", "mu", "Error of the tip here without correction, in X."},
                              {this, "y-error", "mu", "Likewise in Y."},
                              {this, "z-error", "mu", "Likewise in Z."}};
    hal::Out<bool> ramping{this, "ramping", "The correction is on its way to what is wanted."};
    hal::Out<bool> limited{this, "limited", "Something is bounded that limited-code names."};
    hal::Out<std::int32_t> limited_code{this, "limited-code",
                                        "What is bounded, as listed above; 0 for nothing."};
    hal::Out<bool> fault{this, "fault", "Something is wrong that fault-code names."};
    hal::Out<std::int32_t> fault_code{this, "fault-code", "What is wrong, as listed above; 0 for nothing."};
    hal::Out<bool> table_fault{this, "table-fault", "The tables could not be read anew; those before stay."};
    hal::Out<std::int32_t> tables{this, "tables", "Axes that have a table."};
    hal::Out<std::int32_t> serial{this, "serial", "How often tables were read anew and taken over."};

    hal::Function run{this, "update", &Squareness::update,
                      "After motion-controller and before the stages of the joints."};

    void prepare() override {
        if (unit.get() != "mm" && unit.get() != "inch")
            throw std::invalid_argument("unit=" + unit.get() + ": mm and inch are possible");
        axes_ = AxisChainReader::read(chain);
        tables_.load(table, axes_);
        model_ = SquarenessModel(axes_, unit.get() == "inch" ? 25.4 : 1);
        settings.judge(axes_);
        model_.set(situation());
    }

    void background() noexcept override {
        const std::string reason = tables_.work();
        if (!reason.empty()) hal::report_error((reason + "; the tables before stay in force").c_str());
    }

    void update(double dt) noexcept {
        const bool jumped = read_motion(dt);
        const bool tool_known = read_tool();
        settings.judge(axes_);
        const bool reloaded = take_over_tables();
        const SquarenessModel::Situation next = situation();

        RampedCorrection::Wanted before = result_.wanted;  // where the axes were, if they jumped
        const bool changed = reloaded || !(next == model_.situation());
        if (changed) {
            if (!jumped) before = model_.at(motion_, reloaded ? tables_.before() : tables_.in_use()).wanted;
            model_.set(next);
        }
        result_ = model_.at(motion_, tables_.in_use());
        if (changed || jumped)
            result_ = model_.at(motion_, tables_.in_use());  // with errors of where it leads
        if (!changed && !jumped) before = result_.wanted;
        ramp_.step(result_.wanted, before, settings.values().max_rate, dt);

        for (int i = 0; i < 3; ++i) {
            correction[i] = ramp_.offset()[i];
            corrected_position[i] = motion_.position[i] + ramp_.offset()[i];
            corrected_velocity[i] = motion_.velocity[i] + ramp_.velocity()[i];
            error[i] = homed_ ? result_.error[i] : 0;
        }
        ramping = ramp_.ramping();
        report(tool_known, jumped);
    }

private:
    // Positions and velocities of the axes that there are.  Whether one has changed faster than it can move.
    bool read_motion(double dt) noexcept {
        bool jumped = false;
        motion_known_ = true;
        const double way = settings.values().max_speed * dt * (1 + 1e-9);
        for (const AxisBranch* branch : {&axes_.work, &axes_.tool}) {
            for (const Axis axis : *branch) {
                const SquarenessAxis& pins = settings.axes[static_cast<std::size_t>(axis)];
                const double p = pins.position, v = pins.velocity;
                double& position = motion_.position[coordinate(axis)];
                double& velocity = motion_.velocity[coordinate(axis)];
                const double last = position;
                motion_known_ &=
                    std::abs(p) <= SquarenessAxis::farthest && std::abs(v) <= SquarenessAxis::farthest;
                position = usable(p, SquarenessAxis::farthest, position);
                velocity = usable(v, SquarenessAxis::farthest, velocity);
                jumped |= std::abs(position - last) > way;
            }
        }
        return jumped;
    }

    // False for what cannot be; the last good offset stays.
    bool read_tool() noexcept {
        bool known = true;
        for (int i = 0; i < 3; ++i) {
            const double offset = tool_offset[i];
            known &= std::abs(offset) <= SquarenessSettings::longest;
            tool_[i] = -usable(offset, SquarenessSettings::longest, -tool_[i]);
        }
        return known;
    }

    bool take_over_tables() noexcept {
        const bool reloading = reload;
        if (reloading && !reloading_) tables_.ask();
        reloading_ = reloading;
        const bool reloaded = tables_.take_over();
        serial_ += reloaded;
        return reloaded;
    }

    SquarenessModel::Situation situation() noexcept {
        homed_ = all_homed;
        return {settings.values(), tool_ + settings.values().radial, enable && homed_};
    }

    void report(bool tool_known, bool jumped) noexcept {
        const std::int32_t bounded_code = settings.limited()     ? 1
                                          : ramp_.limited()      ? 2
                                          : jumped               ? 3
                                          : result_.beyond_table ? 4
                                                                 : 0;
        limited_code = bounded_code;
        limited = bounded_code != 0;
        const std::int32_t code = !motion_known_ ? 1
                                  : !tool_known  ? 2
                                  : settings.wrong() != SquarenessSettings::Wrong::nothing
                                      ? 2 + static_cast<std::int32_t>(settings.wrong())
                                  : tables_.refused() ? 8
                                                      : 0;
        fault_code = code;
        fault = code != 0;
        table_fault = tables_.refused();
        std::int32_t count = 0;
        for (const auto& its : tables_.in_use()) count += its.has_value();
        tables = count;
        serial = serial_;
    }

    AxisChain axes_;
    ErrorTables tables_;
    SquarenessModel model_{AxisChain{}, 1};
    SquarenessModel::Motion motion_;                  // the last good one
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();  // likewise; mu, from the gauge point to the tip
    bool motion_known_ = true, homed_ = false;
    SquarenessModel::Result result_;
    RampedCorrection ramp_;
    bool reloading_ = true;  // a reload that is true already asks for nothing
    std::int32_t serial_ = 0;
};

hal::Model hal::model() {
    return model_of<Squareness>();
}

}  // namespace plumb
