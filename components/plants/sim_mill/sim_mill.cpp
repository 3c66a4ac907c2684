// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/servo_lag.hpp"
#include "components/plants/sim_mill/cut_truth.hpp"
#include "components/plants/sim_mill/machine_growth.hpp"
#include "components/plants/sim_mill/tool_engagement.hpp"
#include "pages/sim_mill.page.hpp"

namespace plumb {

struct SimMill final : hal::Component {
    static constexpr hal::About about{"sim_mill", "simulated mill: Z axis, thermal growth, tool and work",
                                      page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine; 0 is the typical one."};
    hal::In<double> z_position_cmd{this, "z-position-cmd", 0, "mu",
                                   "Position of Z commanded by the part program."};
    hal::In<double> z_offset{this, "z-offset", 0, "mu", "Offset to add to the Z origin."};
    hal::In<double> spindle_speed_cmd{this, "spindle-speed-cmd", 0, "rpm", "Speed of the spindle."};
    hal::In<std::int32_t> operation{this, "operation", 0,
                                    "Operation under way; 0 for none that counts as a cut."};
    hal::In<std::int32_t> occurrence{this, "occurrence", 0, "Run of this operation in the cycle, from 1."};
    hal::In<std::int32_t> event{this, "event", 0, "Event under way, as sim_part_program numbers them."};
    hal::In<std::int32_t> tool_number{
        this, "tool-number", 0, "Tool in the spindle; a change seats it again, and replaces a worn-out one."};
    hal::In<std::int32_t> tool_kind{this, "tool-kind", 0, "0 end mill, 1 drill."};
    hal::In<double> tool_diameter{this, "tool-diameter", 10, "mu", "Diameter of the tool."};
    hal::In<double> tool_deviation{this, "tool-deviation", 0, "mu",
                                   "Excess of the tool's length over the measured one."};
    hal::In<bool> work_present{this, "work-present", true, "There is work under the tool."};
    hal::In<double> work_top{this, "work-top", 0, "mu", "Top of the work, as drawn."};
    hal::In<double> stock_deviation{this, "stock-deviation", 0, "mu",
                                    "Height of the work above the drawn one."};
    hal::In<double> chip_height{this, "chip-height", 0, "mu", "Height of a chip on the work; 0 for none."};
    hal::In<bool> from_side{this, "from-side", false,
                            "The tool comes down beside the work and cuts sideways."};
    hal::In<double> side_entry{this, "side-entry", 0, "mu",
                               "Width that the tool has in the work from the side."};
    hal::In<double> side_feed{this, "side-feed", 0, "mu/s", "Speed of the cut from the side."};
    hal::In<bool> use_replay{this, "use-replay", false, "Take the growth from growth-replay."};
    hal::In<double> growth_replay{this, "growth-replay", 0, "mu", "A measured growth."};

    Drawn servo_gain{this, "servo-gain", 30, 17, 60, "1/s", "Gain of the position loop"};
    Drawn encoder_step{this, "encoder-step", 0.0005, 0.0001, 0.001, "mu", "Resolution of the encoder"};
    Drawn backlash{this, "backlash", 0.001, 0, 0.003, "mu", "Lost motion between encoder and tip"};
    Drawn seating{this, "seating", 0.001, 0.001, 0.002, "mu", "Standard deviation of a tool's seat"};
    Drawn wear_length{this, "wear-length", 0.003, 0.001, 0.01, "mu", "Length that a worn-out tool has lost"};
    Drawn tool_life{this, "tool-life", 28800, 14400, 43200, "s", "Time in the cut that wears a tool out"};
    MachineGrowth growth{this};

    hal::Out<double> z_position{this, "z-position", "mu", "Z that the encoder reads, offset included."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu",
                                    "Offset in the position that Z is sent to."};
    hal::Out<double> engagement{this, "engagement", "1", "Part of its full chip that the tool cuts, 0 to 1."};
    hal::Out<double> cutting_power{this, "cutting-power", "W", "Power of the cut with a sharp tool."};
    hal::Out<double> tool_wear{this, "tool-wear", "1",
                               "Wear of the tool in the spindle, 0 to 1 when worn out."};
    hal::Out<double> truth_growth{this, "truth-growth", "mu", "Growth of the machine."};
    hal::Out<double> truth_tip_error{this, "truth-tip-error", "mu",
                                     "Error of the tip, positive when it is too high."};
    hal::Out<bool> truth_contact{this, "truth-contact",
                                 "The tip is below the top of the work it plunges into."};
    CutTruth truth{this};
    hal::Function run{this, "update", &SimMill::update, hal::Place::machine};

    void update(double dt) noexcept {
        const Task task{operation, occurrence, tool_number, event};
        if (seed_ != seed || !started_) start(seed);
        if (task.tool != tool_) seat(task.tool);
        command_ = usable(z_position_cmd, 1e5, command_);
        offset_ = usable(z_offset, 1e3, offset_);
        speed_ = usable(spindle_speed_cmd, 1e5, speed_);
        time_ += dt;

        const double gain = std::max(servo_gain(seed_), 1.0);
        const double nominal = command_lag_.step(command_, gain, dt);
        const double z = nominal + offset_lag_.step(offset_, gain, dt);
        const double warm = growth.step(seed_, speed_, z, (z - z_) / dt, dt);
        replayed_ = usable(growth_replay, 1e3, replayed_);
        const double grown = use_replay ? replayed_ : warm;
        const double play = backlash(seed_) / 2;
        driven_ = std::clamp(driven_, z - play, z + play);
        double& wear = wear_of(task.tool);
        longer_ = usable(tool_deviation, 1e3, longer_);
        const double tip = driven_ - grown + wear * wear_length(seed_) + seat_ - longer_;

        const Work work = cut(tip, dt);
        if (work.power > 0) wear = std::min(1.0, wear + dt / std::max(tool_life(seed_), 1.0));
        if (contact_.rises(work.contact)) {
            const double part = depth_ < 0 ? depth_ / (depth_ - work.depth) : 1;  // of the period, before it
            truth.contact(task, z_ + (z - z_) * part, time_ - dt + part * dt, grown);
        }
        truth.cut(task.operation != 0 && work.depth > 0 && work.engaged > 0, task, tip, tip - nominal, grown);

        const double step = encoder_step(seed_);
        z_position = step > 1e-9 ? std::round(z / step) * step : z;
        applied_offset = offset_;
        engagement = work.engaged;
        cutting_power = work.power;
        tool_wear = wear;
        truth_growth = grown;
        truth_tip_error = tip - nominal;
        truth_contact = work.contact;
        z_ = z;
        tip_ = tip;
        depth_ = work.depth;
    }

private:
    struct Work {
        double depth, engaged, power;
        bool contact;
    };

    static constexpr double cutting_force = 2.5;  // W for each mm3/s: steel
    static constexpr double chip_strength = 0.7;  // of the work

    // The machine at its start: cold, at rest at its command.
    void start(std::int32_t number) noexcept {
        if (!started_) {
            command_ = usable(z_position_cmd, 1e5, 0);
            command_lag_.reset(command_);
            driven_ = z_ = tip_ = command_;
        }
        started_ = true;
        seed_ = number;
        random_ = Random(static_cast<std::uint32_t>(number), 'm');
        tool_ = -1;
    }

    void seat(std::int32_t tool) noexcept {
        tool_ = tool;
        if (wear_of(tool) >= 1) wear_of(tool) = 0;
        seat_ = seating(seed_) * random_.gaussian();
    }

    double& wear_of(std::int32_t tool) noexcept {
        return wear_[static_cast<std::uint32_t>(tool) % std::size(wear_)];
    }

    Work cut(double tip, double dt) noexcept {
        top_ = usable(work_top, 1e5, top_);
        higher_ = usable(stock_deviation, 1e3, higher_);
        diameter_ = usable(tool_diameter, 1e3, diameter_);
        const bool present = work_present;
        const double depth = present ? top_ + higher_ - tip : -1;
        if (from_side) {
            side_feed_ = usable(side_feed, 1e4, side_feed_);
            width_ = usable(side_entry, 1e3, width_);
            const double engaged = depth > 0 ? std::clamp(width_ / std::max(diameter_, 1e-3), 0.0, 1.0) : 0;
            return {depth, engaged, cutting_force * std::max(0.0, depth) * diameter_ * engaged * side_feed_,
                    false};
        }
        const ToolKind kind = tool_kind == 1 ? ToolKind::drill : ToolKind::end_mill;
        const double feed = std::max(0.0, (tip_ - tip) / dt);
        const double chip = present ? depth + std::max(0.0, usable(chip_height, 1e3, 0)) : -1;
        const double engaged =
            depth > 0
                ? plunge_engagement(kind, depth, diameter_, feed * 60 / std::max(speed_, 1.0))
                : chip_strength * plunge_engagement(kind, chip, diameter_, feed * 60 / std::max(speed_, 1.0));
        return {depth, engaged, cutting_force * 0.785398 * diameter_ * diameter_ * feed * engaged, depth > 0};
    }

    Random random_;
    ServoLag command_lag_, offset_lag_;
    double command_ = 0, offset_ = 0, speed_ = 0, longer_ = 0, top_ = 0, higher_ = 0, diameter_ = 10;
    double width_ = 0, side_feed_ = 0, replayed_ = 0;  // last good inputs
    double time_ = 0, z_ = 0, driven_ = 0, tip_ = 0, depth_ = -1, seat_ = 0;
    double wear_[100] = {};  // of each tool
    bool started_ = false;
    Edge contact_;
    std::int32_t seed_ = 0, tool_ = -1;
};

hal::Model hal::model() {
    return model_of<SimMill>();
}

}  // namespace plumb
