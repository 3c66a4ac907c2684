// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/trapezoidal_move.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/part_program.hpp"
#include "components/math/program_event.hpp"
#include "components/plants/drawn.hpp"

namespace plumb {

struct SimPartProgram final : hal::Component {
    static constexpr hal::About about{
        "sim_part_program", "simulated part program: a cycle of plunge cuts, and what upsets it", R"(
Moves Z where no LinuxCNC does.  Every cycle-interval a part is made: for each operation a tool change where the tool
is another one, a rapid to 6 mm above the work, a feed to depth, a dwell, a rapid up.  Then, until the next part, the
last tool mills sides at its speed (operation 0).  Speeds are trapezoids; z-velocity-cmd is signed, + away from the work.

    operation  tool            occurrences       of machine 0; any other seed draws diameters,
    10         1 end mill 12   1, 2              speeds, levels and depths
    20         2 drill 8       1
    30         3 face mill 32  1, from the side
    40         4 end mill 10   1

With probability event-rate one event, drawn by seed, upsets a cycle after the learning ones; or the one that event
names upsets cycle event-cycle (every one, where that is 0):

    1 air cut      no work under an operation
    2 chip         on the work of an operation, event-height high
    3 stock        all of the work higher by event-height, up to 0.3 mm either way
    4 wrong part   likewise, up to 5 mm
    5 wrong tool length  a tool longer by event-height, up to 2 mm either way
    6 feed override  of an operation, by event-factor
    7 feed hold    for 3 s on the way down
    8 spindle override  of an operation, by event-factor
    9 speed change on approach  by event-factor, within 1 mm above the work
    10 abort       on the way down; the machine stands until the next cycle
    11 edited      from this cycle on the work of every operation lies event-height higher, and program-id is another

The truth-... pins are for scoring only.)"};

    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine; 0 has the program above."};
    hal::In<bool> run{this, "run", true,
                      "Begin cycles; when false the machine stands after the present one."};
    hal::In<std::int32_t> learning_cycles{this, "learning-cycles", 1,
                                          "Number of cycles to learn from, the first ones."};
    hal::In<double> cycle_interval{this, "cycle-interval", 300, "s",
                                   "Time from the start of a cycle to that of the next."};
    hal::In<double> event_rate{this, "event-rate", 0, "", "Part of the cycles that an event upsets, 0 to 1."};
    hal::In<std::int32_t> event{this, "event", 0, "Number of an event to have; 0 leaves it to event-rate."};
    hal::In<std::int32_t> event_cycle{this, "event-cycle", 0,
                                      "Cycle that event upsets, from 1; 0 for every one."};
    hal::In<std::int32_t> event_operation{this, "event-operation", 0,
                                          "Operation that an event upsets; 0 draws it."};
    hal::In<double> event_height{this, "event-height", 0, "mu", "Height of an event; 0 draws it."};
    hal::In<double> event_factor{this, "event-factor", 0, "", "Factor of an event; 0 draws it."};
    hal::In<double> event_smallest{this, "event-smallest", 0.1, "mu", "Smallest height that is drawn."};
    hal::In<double> event_largest{this, "event-largest", 0, "mu",
                                  "Largest height that is drawn; 0 for the usual one."};
    Drawn contact_feed{this, "contact-feed", 1.6667, 1.3, 2, "mu/s", "Feed on the way down"};
    Drawn blank_repeatability{
        this, "blank-repeatability", 0.0005, 0, 0.002, "mu", "Standard deviation of the work's top"};

    hal::Out<bool> cycle_running{this, "cycle-running", "A part is being made."};
    hal::Out<bool> cycle_complete{this, "cycle-complete",
                                  "The last part was made to its end; false from the start of the next."};
    hal::Out<bool> learn{this, "learn", "This cycle is one to learn from."};
    hal::Out<std::int32_t> cycle{this, "cycle", "Number of the cycle, from 1."};
    hal::Out<double> z_position_cmd{this, "z-position-cmd", "mu", "Where Z is to be."};
    hal::Out<double> z_velocity_cmd{this, "z-velocity-cmd", "mu/s",
                                    "How fast that moves; negative to the work."};
    hal::Out<std::int32_t> motion_type{this, "motion-type", "0 none, 1 rapid, 2 feed, as in LinuxCNC."};
    hal::Out<double> spindle_speed_cmd{this, "spindle-speed-cmd", "rpm", "Speed of the spindle."};
    hal::Out<double> feed_override{this, "feed-override", "Factor on the feed that the operator has set."};
    hal::Out<bool> coolant{this, "coolant", "Coolant is on."};
    hal::Out<std::int32_t> operation{this, "operation", "Key of the operation; 0 between parts."};
    hal::Out<std::int32_t> program_id{this, "program-id", "Changes when the program is edited."};
    hal::Out<double> start_height{this, "start-height", "mu", "Z from which the way down is timed."};
    hal::Out<double> work_top{this, "work-top", "mu", "Top of the work of this operation, as drawn."};
    hal::Out<bool> work_present{this, "work-present", "There is work under the tool."};
    hal::Out<double> stock_deviation{this, "stock-deviation", "mu",
                                     "How much higher the work is than drawn."};
    hal::Out<double> chip_height{this, "chip-height", "mu", "Height of a chip on the work; 0 for none."};
    hal::Out<bool> from_side{this, "from-side", "The tool comes down beside the work and cuts sideways."};
    hal::Out<double> side_entry{this, "side-entry", "mu",
                                "Width that the tool has in the work from the side."};
    hal::Out<double> side_feed{this, "side-feed", "mu/s", "Speed of the cut from the side."};
    hal::Out<std::int32_t> tool_number{this, "tool-number", "Tool in the spindle."};
    hal::Out<std::int32_t> tool_kind{this, "tool-kind", "0 end mill, 1 drill."};
    hal::Out<double> tool_diameter{this, "tool-diameter", "mu", "Diameter of the tool."};
    hal::Out<double> tool_deviation{this, "tool-deviation", "mu",
                                    "How much longer the tool is than measured."};
    hal::Out<std::int32_t> teeth{this, "teeth", "Teeth of the tool."};
    hal::Out<std::int32_t> truth_occurrence{this, "truth-occurrence",
                                            "Which run of the operation in its cycle, from 1."};
    hal::Out<std::int32_t> truth_event{this, "truth-event",
                                       "Event under way, as numbered above; 0 for none."};
    hal::Function update_{this, "update", &SimPartProgram::update, "First."};

    void update(double dt) noexcept {
        if (seed_ != seed || !started_) start(seed);
        time_ += dt;
        if (time_ >= due_ && (step_ == Step::stand || step_ == Step::sides)) run ? begin_cycle() : stand();

        const Operation& now = program_[index_];
        const double place = move_.position() - top_;
        if (step_ == Step::plunge && place < event_.place) {
            if (upset(Event::abort)) stand();
            if (upset(Event::speed_change)) speed_ = now.speed * event_.factor;
            if (upset(Event::feed_hold)) held_ += dt;
        }
        const bool held = held_ > 0 && held_ < hold_time;
        const double override = upset(Event::feed_override) ? event_.factor : 1;
        const double feed = held ? 0 : contact_feed(seed_) * override;
        move_.step(target_, motion_ == feeding ? feed : rapid, acceleration, dt);
        if (move_.arrived(target_) && (waited_ += dt) >= wait_) enter(following());

        const bool beside = step_ == Step::beside || step_ == Step::sides;
        cycle_running = making_;
        cycle_complete = complete_;
        learn = cycle_ <= learning_cycles;
        cycle = cycle_;
        z_position_cmd = move_.position();
        z_velocity_cmd = move_.velocity();
        motion_type = motion_ == moving && move_.arrived(target_) ? resting : motion_;
        spindle_speed_cmd = speed_;
        feed_override = override;
        coolant = speed_ > 0;
        operation = cutting_ ? now.key : 0;
        program_id = 1 + edits_;
        start_height = top_ + timed_from;
        work_top = top_;
        work_present = !upset(Event::air_cut);
        stock_deviation = blank_ + (upset(Event::stock) || upset(Event::wrong_part) ? event_.height : 0);
        chip_height = upset(Event::chip) ? event_.height : 0;
        from_side = now.from_side || beside;
        side_entry = step_ == Step::sides                  ? contour_width
                     : step_ == Step::cut && now.from_side ? waited_ * pass_feed
                                                           : 0;
        side_feed = step_ == Step::sides ? contour_feed : pass_feed;
        tool_number = tool_;
        tool_kind = static_cast<std::int32_t>(now.kind);
        tool_diameter = now.diameter;
        tool_deviation = upset(Event::wrong_tool_length) ? event_.height : 0;
        teeth = now.teeth;
        truth_occurrence = now.occurrence;
        truth_event = static_cast<std::int32_t>(upset(event_.kind) ? event_.kind
                                                : edits_ > 0       ? Event::edited
                                                                   : Event::none);
    }

private:
    // Each moves Z to its target and then waits.
    enum class Step { stand, lift, change, spin_up, descend, plunge, cut, beside, sides };

    static constexpr std::int32_t resting = 0, moving = 1, feeding = 2;  // as motion-type says
    static constexpr double rapid = 300, acceleration = 2500;            // mm/s, mm/s2
    static constexpr double change_height = 100, lifted = 50, clearance = 6,
                            timed_from = 2;  // mm, the last three above the work
    static constexpr double change_time = 2, spin_up_time = 1.5, travel_time = 0.7, dwell_time = 0.5,
                            hold_time = 3;                                            // s
    static constexpr double pass_feed = 16, pass_overrun = 10;                        // mm/s, mm
    static constexpr double contour_feed = 20, contour_width = 1, contour_depth = 6;  // mm/s, mm, mm
    static constexpr double forever = 1e300;

    struct Upset {
        Event kind;
        std::size_t operation;
        double height, factor, place;
    };

    void start(std::int32_t number) noexcept {
        started_ = true;
        seed_ = number;
        const auto machine = static_cast<std::uint32_t>(number);
        blanks_ = Random(machine, 'b');
        events_ = Random(machine, 'e');
        Random tools(machine, 'p');
        program_ = number == 0 ? typical_program() : drawn_program(tools);
    }

    void begin_cycle() noexcept {
        due_ = std::max(due_ + std::max(0.0, usable(cycle_interval, 1e6, 300)), time_);
        ++cycle_;
        making_ = true;
        complete_ = false;
        next_ = 0;
        event_ = drawn_upset();
        if (event_.kind == Event::edited) {
            ++edits_;
            shift_ = usable(shift_ + event_.height, 100, 0);
        }
        enter(Step::lift);
    }

    // Draws as much whatever happens, so that one setting does not change what another one draws.
    Upset drawn_upset() noexcept {
        const bool drawn = events_.uniform() < event_rate && cycle_ > learning_cycles;
        const auto drawn_kind = static_cast<Event>(1 + events_.index(event_count));
        auto which = static_cast<std::size_t>(events_.index(static_cast<int>(program_.size())));
        const std::int32_t named = event, only = event_cycle, key = event_operation;
        const bool forced = named >= 1 && named <= event_count && (only == 0 || only == cycle_);
        const Event kind = forced ? static_cast<Event>(named) : drawn ? drawn_kind : Event::none;
        const double smallest = usable(event_smallest, 10, 0.1), largest = usable(event_largest, 10, 0);
        const double height = drawn_height(kind, smallest, largest, events_);
        const double factor = drawn_factor(events_);
        const double place = kind == Event::speed_change ? events_.uniform(0.2, 1) : events_.uniform(-1, 4);
        const double given_height = usable(event_height, 10, 0), given_factor = usable(event_factor, 2, 0);
        for (std::size_t i = program_.size(); i-- > 0;)
            if (program_[i].key == key) which = i;
        return {kind, which, given_height != 0 ? given_height : height,
                given_factor > 0 ? given_factor : factor, place};
    }

    bool upset(Event kind) const noexcept {
        if (event_.kind != kind || !making_) return false;
        if (kind == Event::wrong_tool_length) return program_[index_].tool == program_[event_.operation].tool;
        return concerns_cycle(kind) || index_ == event_.operation;
    }

    void stand() noexcept {
        making_ = cutting_ = false;
        enter(Step::stand);
    }

    void choose(std::size_t operation_index) noexcept {
        index_ = operation_index;
        cutting_ = true;
        held_ = 0;
        top_ = program_[index_].top + shift_;
        blank_ = blank_repeatability(seed_) * blanks_.gaussian();
    }

    // The step after the one that is over.
    Step following() noexcept {
        switch (step_) {
            case Step::lift:
                if (next_ == program_.size()) {
                    making_ = cutting_ = false;
                    complete_ = true;
                    return Step::beside;
                }
                choose(next_++);
                return program_[index_].tool == tool_ ? Step::spin_up : Step::change;
            case Step::change: return Step::spin_up;
            case Step::spin_up: return Step::descend;
            case Step::descend: return Step::plunge;
            case Step::plunge: return Step::cut;
            case Step::cut: return Step::lift;
            case Step::beside: return Step::sides;
            default: return step_;
        }
    }

    void enter(Step step) noexcept {
        const Operation& now = program_[index_];
        const bool another = next_ < program_.size() && program_[next_].tool != tool_;
        const double bottom = top_ - now.depth;
        step_ = step;
        waited_ = 0;
        switch (step) {
            case Step::stand: speed_ = 0; return go(change_height, moving, forever);
            case Step::lift: return go(another ? change_height : top_ + lifted, moving, 0);
            case Step::change: speed_ = 0; return go(change_height, resting, change_time);
            case Step::spin_up:
                speed_ = now.speed * (upset(Event::spindle_override) ? event_.factor : 1);
                return go(move_.position(), resting,
                          now.tool == std::exchange(tool_, now.tool) ? travel_time : spin_up_time);
            case Step::descend: return go(top_ + clearance, moving, 0);
            case Step::plunge: return go(bottom, feeding, 0);
            case Step::cut:
                return go(bottom, feeding,
                          now.from_side ? (now.diameter + pass_overrun) / pass_feed : dwell_time);
            case Step::beside: return go(top_ - contour_depth, moving, 0);
            case Step::sides: return go(top_ - contour_depth, feeding, forever);
        }
    }

    void go(double target, std::int32_t motion, double wait) noexcept {
        target_ = target;
        motion_ = motion;
        wait_ = wait;
    }

    PartProgram program_ = typical_program();
    Random blanks_, events_;
    Upset event_{};
    TrapezoidalMove move_{change_height};
    Step step_ = Step::stand;
    double target_ = change_height, wait_ = forever, waited_ = 0;  // of the step
    std::int32_t motion_ = resting;
    double time_ = 0, due_ = 1;  // s; the first cycle begins a second after the start
    std::size_t index_ = program_.size() - 1, next_ = 0;
    std::int32_t tool_ = program_.back().tool, cycle_ = 0, edits_ = 0, seed_ = 0;
    double top_ = program_.back().top, shift_ = 0, blank_ = 0, speed_ = 0, held_ = 0;
    bool started_ = false, making_ = false, complete_ = false, cutting_ = false;
};

hal::Model hal::model() {
    return model_of<SimPartProgram>();
}

}  // namespace plumb
