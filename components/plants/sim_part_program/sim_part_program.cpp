// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/plants/drawn.hpp"
#include "components/plants/sim_part_program/part_cycle.hpp"
#include "components/plants/sim_part_program/program_upset.hpp"
#include "pages/sim_part_program.page.hpp"

namespace plumb {

struct SimPartProgram final : hal::Component {
    static constexpr hal::About about{
        "sim_part_program", "simulated part program: a cycle of plunge cuts, and events that disturb it",
        page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine; 0 has the program above."};
    hal::In<bool> run{this, "run", true,
                      "Begin cycles; when false the machine stands after the present one."};
    hal::In<std::int32_t> learning_cycles{this, "learning-cycles", 1,
                                          "Number of cycles to learn from, the first ones."};
    hal::In<bool> relearn{this, "relearn", false, "Learn from the next cycle too."};
    hal::In<double> cycle_interval{this, "cycle-interval", 300, "s",
                                   "Time from the start of a cycle to the next start."};
    hal::In<double> sides_speed{
        this, "sides-speed", -1, "rpm",
        "Speed for milling the sides; 0 for none of it, negative for the speed of the last cut."};
    Upsets upsets{this};
    Drawn contact_feed{this, "contact-feed", 1.6667, 1.3, 2, "mu/s", "Feed of the descent"};
    hal::In<double> coolant_height{this, "coolant-height", 0, "mu",
                                   "Z above the work at which coolant comes on; 0: with the spindle."};
    hal::In<double> coolant_jitter{this, "coolant-jitter", 0, "s",
                                   "Standard deviation of the time at which it comes on there."};
    Drawn blank_repeatability{
        this, "blank-repeatability", 0.0005, 0, 0.002, "mu", "Standard deviation of the work's top"};

    hal::Out<bool> cycle_running{this, "cycle-running", "A part is being made."};
    hal::Out<bool> cycle_complete{this, "cycle-complete",
                                  "The last part was made to its end; false from the start of the next."};
    hal::Out<bool> learn{this, "learn", "This cycle is learned from."};
    hal::Out<std::int32_t> cycle{this, "cycle", "Number of the cycle, from 1."};
    hal::Out<double> z_position_cmd{this, "z-position-cmd", "mu", "Commanded position of Z."};
    hal::Out<double> z_velocity_cmd{this, "z-velocity-cmd", "mu/s",
                                    "Commanded speed of Z, negative to the work."};
    hal::Out<std::int32_t> motion_type{this, "motion-type", "0 none, 1 rapid, 2 feed, as in LinuxCNC."};
    hal::Out<double> spindle_speed_cmd{this, "spindle-speed-cmd", "rpm", "Speed of the spindle."};
    hal::Out<double> feed_override{this, "feed-override", "1",
                                   "Factor on the feed that the operator has set."};
    hal::Out<bool> coolant{this, "coolant", "Coolant is on."};
    hal::Out<std::int32_t> operation{this, "operation", "Key of the operation; 0 between parts."};
    hal::Out<std::int32_t> program_id{this, "program-id", "Changes when the program is edited."};
    hal::Out<double> start_height{this, "start-height", "mu", "Z from which the descent is timed."};
    hal::Out<double> work_top{this, "work-top", "mu", "Top of the work of this operation, as drawn."};
    hal::Out<bool> work_present{this, "work-present", "There is work under the tool."};
    hal::Out<double> stock_deviation{this, "stock-deviation", "mu",
                                     "Height of the work above the drawn one."};
    hal::Out<double> chip_height{this, "chip-height", "mu", "Height of a chip on the work; 0 for none."};
    hal::Out<bool> from_side{this, "from-side", "The tool comes down beside the work and cuts sideways."};
    hal::Out<double> side_entry{this, "side-entry", "mu",
                                "Width that the tool has in the work from the side."};
    hal::Out<double> side_feed{this, "side-feed", "mu/s", "Speed of the cut from the side."};
    hal::Out<std::int32_t> tool_number{this, "tool-number", "Tool in the spindle."};
    hal::Out<std::int32_t> tool_kind{this, "tool-kind", "0 end mill, 1 drill."};
    hal::Out<double> tool_diameter{this, "tool-diameter", "mu", "Diameter of the tool."};
    hal::Out<double> tool_deviation{this, "tool-deviation", "mu",
                                    "Excess of the tool's length over the measured one."};
    hal::Out<std::int32_t> teeth{this, "teeth", "Teeth of the tool."};
    hal::Out<std::int32_t> truth_occurrence{this, "truth-occurrence",
                                            "Run of the operation in its cycle, from 1."};
    hal::Code<Event> truth_event{this, "truth-event", "Event under way; 0 for none."};
    hal::Function update_{this, "update", &SimPartProgram::update, hal::Place::program};

    void update(double dt) noexcept {
        if (seed_ != seed || !started_) start(seed);
        time_ += dt;
        if (time_ >= due_ && part_.waiting()) run ? begin() : part_.stand(program_);
        const bool holding = held_ > 0 && held_ < hold_time;
        part_.step(program_, holding ? 0 : contact_feed(seed_) * feed_factor(), dt);
        if (part_.operations() != operations_) load_blank();

        const Operation& now = program_[part_.operation()];
        reached_ = reached_ || (part_.plunging() && part_.position() < now.top + upset_.place);
        if (reached_ && is(Event::abort)) part_.stand(program_);
        if (reached_ && is(Event::feed_hold)) held_ += dt;
        const bool other_speed = is(Event::spindle_override) || (reached_ && is(Event::speed_change));

        cycle_running = part_.making();
        cycle_complete = part_.complete();
        learn = learning_;
        cycle = cycle_;
        z_position_cmd = part_.position();
        z_velocity_cmd = part_.velocity();
        motion_type = part_.motion();
        const double speed = turning();
        spindle_speed_cmd = speed * (other_speed ? upset_.factor : 1);
        feed_override = feed_factor();
        coolant = speed > 0 && coolant_on();
        operation = part_.cutting() ? now.key : 0;
        program_id = 1 + edits_;
        start_height = now.top + timed_from;
        work_top = now.top;
        work_present = !is(Event::air_cut);
        stock_deviation = blank_ + (is(Event::stock) || is(Event::wrong_part) ? upset_.height : 0);
        chip_height = is(Event::chip) ? upset_.height : 0;
        from_side = now.from_side || !part_.cutting();
        side_entry = speed > 0 ? part_.side_entry(now) : 0;
        side_feed = part_.side_feed();
        tool_number = part_.tool();
        tool_kind = static_cast<std::int32_t>(now.kind);
        tool_diameter = now.diameter;
        tool_deviation = is(Event::wrong_tool_length) ? upset_.height : 0;
        teeth = now.teeth;
        truth_occurrence = now.occurrence;
        truth_event = hal::first<Event>({{is(upset_.kind), upset_.kind}, {edits_ > 0, Event::edited}});
    }

private:
    static constexpr double first_cycle = 1;  // s after the start
    static constexpr double timed_from = 2;   // mm above the work
    static constexpr double hold_time = 3;    // s

    void start(std::int32_t number) noexcept {
        const auto machine = static_cast<std::uint32_t>(number);
        Random tools(machine, 'p');
        started_ = true;
        seed_ = number;
        program_ = number == 0 ? typical_program() : drawn_program(tools);
        blanks_ = Random(machine, 'b');
        events_ = Random(machine, 'e');
    }

    void begin() noexcept {
        due_ = std::max(due_ + std::max(0.0, usable(cycle_interval, 1e6, 300)), time_);
        ++cycle_;
        learning_ = relearn || cycle_ <= learning_cycles;
        upset_ = upsets.draw(program_, cycle_, learning_, events_);
        if (upset_.kind == Event::edited) {
            ++edits_;
            for (Operation& edited : program_) edited.top += upset_.height;
        }
        part_.begin(program_);
    }

    void load_blank() noexcept {
        operations_ = part_.operations();
        blank_ = blank_repeatability(seed_) * blanks_.gaussian();
        reached_ = false;
        cooled_ = false;
        held_ = 0;
        const double jitter = usable(coolant_jitter, 1, 0);
        late_ = jitter > 0 ? jitter * blanks_.gaussian() : 0;
    }

    // With a coolant-height it comes on again in each plunge, where no offset moves it.
    bool coolant_on() noexcept {
        const double height = usable(coolant_height, 1e3, 0);
        const double above = part_.position() + part_.velocity() * late_ - program_[part_.operation()].top;
        cooled_ = cooled_ || (part_.plunging() && above <= height);
        return cooled_ || !(height > 0);
    }

    double turning() const noexcept {
        const double given = usable(sides_speed, 1e5, -1);
        return part_.sides() && given >= 0 ? given : part_.speed();
    }

    bool is(Event event) const noexcept {
        return part_.cutting() && upset_.is(event, program_, part_.operation());
    }
    double feed_factor() const noexcept { return is(Event::feed_override) ? upset_.factor : 1; }

    PartProgram program_ = typical_program();
    PartCycle part_;
    Random blanks_, events_;
    Upset upset_;
    double time_ = 0, due_ = first_cycle, blank_ = 0, held_ = 0, late_ = 0;
    bool started_ = false, reached_ = false, cooled_ = false, learning_ = true;
    std::int32_t seed_ = 0, cycle_ = 0, edits_ = 0, operations_ = 0;
};

hal::Model hal::model() {
    return model_of<SimPartProgram>();
}

}  // namespace plumb
