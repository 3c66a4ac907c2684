// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "components/compensation/thermal_growth/growth_procedure.hpp"
#include "components/math/blocks/delayed_bit.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"
#include "pages/thermal_growth.page.hpp"

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

namespace plumb {

namespace growth_test {

// The program of the test, and its probe.
struct Program : hal::Group {
    using Group::Group;

    hal::In<bool> running{this, "running", false, "The program of the test runs."};
    hal::In<bool> program_running{
        this, "program-running", true,
        "A program or an MDI command runs or is paused: net program-running of linuxcnc_alive."};
    hal::In<bool> program_paused{this, "program-paused", false, "A program is paused."};
    hal::In<bool> resumable{this, "resumable", false, "A test can be resumed: net resumable of growth_log."};
    hal::In<bool> resume{this, "resume", false, "Continue the restored test instead of a new one."};
    hal::In<double> gap{this, "gap", 0, "s",
                        "Time since the last record of the restored test; -1 when not known."};
    hal::In<bool> pass_running{this, "pass-running", false, "A pass over the bores runs."};
    hal::In<bool> at_bore{this, "at-bore", false, "A bore is probed."};
    hal::In<bool> measuring{this, "measuring", false, "The next touch of the probe counts."};
    hal::In<bool> cycle{this, "cycle", false, "A rising edge ends a cycle of the machine."};
    hal::In<double> bore_key{this, "bore-key", 0, "1", "Number of the bore, 1 to 16."};
    hal::In<bool> turned{this, "turned", false, "The table is at the second orientation, 180 deg."};
    hal::In<bool> probe{this, "probe", false, "The probe touches."};
    hal::In<bool> overtravel{this, "probe-overtravel", false, "The probe reports overtravel."};
    hal::In<bool> compensate{this, "compensate", false, "The program wants position compensation."};
    hal::In<bool> compensation_on{this, "compensation-on", false, "The control confirms compensation."};
    hal::In<bool> cool{this, "cool", false, "The program wants temperature control."};
    hal::In<bool> cooling_on{this, "cooling-on", false, "The control confirms temperature control."};
    static constexpr hal::Range times{0, 1e6};
    hal::In<double> confirm_time{
        this, "confirm-time", 30, "s", "Longest time until a state is confirmed.", hal::machine(times)};
    hal::In<double> max_pass_time{
        this, "max-pass-time", 3600, "s", "Longest pass; the machine cools in it.", hal::machine(times)};
    hal::In<bool> acknowledge{this, "acknowledge", false, "A rising edge clears a fault of the past."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm", "Speed of the spindle, for the log."};

    Signals read(double dt) noexcept {
        Signals s;
        s.running = Bit::of(running_, running);
        s.pass = Bit::of(pass_, pass_running);
        s.bore = Bit::of(bore_, at_bore);
        s.measuring = Bit::of(measuring_, measuring);
        s.cycle = Bit::of(cycle_, cycle);
        s.probe = Bit::of(probe_, probe);
        s.resume = resume;
        s.gap = gap;
        s.bore_key = bore_key;
        s.max_pass_time = max_pass_time;
        s.turned = turned;
        s.overtravel = overtravel;
        s.spindle_speed = spindle_speed;
        s.gone = gone_.step(s.running.now && !program_running, gone_time, 0, dt);
        s.paused = program_paused;
        s.resumable = resumable;
        s.acknowledged = acknowledging_.rises(acknowledge);
        s.wants_compensation = compensate;
        s.wants_cooling = cool;
        s.compensated = compensation_on;
        s.cooled = cooling_on;
        const double patience = std::fmax(static_cast<double>(confirm_time), 0.0);
        const bool compensated = s.compensated == s.wants_compensation, cooled = s.cooled == s.wants_cooling;
        const bool late = compensation_late_.step(!compensated, patience, 0, dt);
        const bool late_cooling = cooling_late_.step(!cooled, patience, 0, dt);
        s.unconfirmed = s.running.now && (late || late_cooling);
        s.confirmed = compensated && cooled;
        return s;
    }

private:
    static constexpr double gone_time = 1;  // s

    DelayedBit gone_, compensation_late_, cooling_late_;
    Edge running_, pass_, bore_, measuring_, cycle_, probe_, acknowledging_;
};

// The sensors of temperature.
struct Temperatures : hal::Group {
    Temperatures(hal::Owner owner, std::size_t sensors) : Group(owner), sensors_(sensors) {}

private:
    const std::size_t sensors_;  // their number

public:
    static constexpr std::size_t most = 8;
    static constexpr hal::Range places{-1, most - 1}, times{0, 1e6}, temperatures{-100, 500};
    hal::Row<hal::In<double>> value{this, sensors_, "temperature",
                                    20.0, "degC",   "Temperature of this sensor."};
    hal::Row<hal::In<bool>> valid{this, sensors_, "temperature-valid", true,
                                  "The sensor reports that it is valid."};
    hal::Row<hal::In<double>> age{this, sensors_, "temperature-age", 0.0, "s", "Age of the temperature."};
    hal::Row<hal::In<bool>> decides{
        this, sensors_, "temperature-decides", true, "The stop rule reads this sensor.", hal::machine()};
    hal::In<double> max_age{this, "max-age", 30, "s", "Largest age of a temperature.", hal::machine(times)};
    hal::In<double> sample_time{
        this, "sample-time", 60, "s", "Time between two temperature records.", hal::must(times)};
    hal::In<std::int32_t> artifact{this, "artifact-sensor", -1, "Sensor of the artifact; -1 for none.",
                                   hal::machine(places)};
    hal::In<double> artifact_low{
        this, "artifact-low", 10, "degC", "Lowest temperature of the artifact.", hal::expert(temperatures)};
    hal::In<double> artifact_high{
        this, "artifact-high", 35, "degC", "Highest temperature of the artifact.", hal::expert(temperatures)};

    void read(Warmth& r) noexcept {
        r.good = r.artifact_good = true;
        r.decides = 0;
        r.sample_time = sample_time;
        r.count = static_cast<int>(sensors_);
        const double oldest = max_age;
        for (std::size_t i = 0; i < sensors_; ++i) {
            const double now = value[i], since = age[i];
            const bool fine = valid[i] && now > -100 && now < 500 && since >= 0 && since <= oldest;
            r.value[i] = fine ? now : NAN;
            r.age[i] = std::abs(since) <= 1e6 ? since : 1e6;
            if (decides[i]) r.decides |= 1U << i;
            if (!fine) r.good = false;
        }
        const std::int32_t sensor = artifact;
        if (sensor >= 0 && sensor < r.count) {
            const double now = r.value[static_cast<std::size_t>(sensor)];
            r.artifact_good = !std::isfinite(now) || (now >= artifact_low && now <= artifact_high);
        }
    }
};

// When the machine is warm.
struct StopSettings : hal::Group {
    using Group::Group;

    static constexpr hal::Range rises{0, 1e3}, times{0, 1e9}, lengths{0, 1e3};
    hal::In<double> threshold{
        this, "threshold", 0.5, "K", "Largest change of a temperature in the interval.", hal::must(rises)};
    hal::In<double> interval{
        this, "interval", 3600, "s", "Interval of the threshold; 0 for one cycle.", hal::must(times)};
    hal::In<double> minimum_time{
        this, "minimum-time", 14400, "s", "The test does not pass before.", hal::must(times)};
    hal::In<double> maximum_time{
        this, "maximum-time", 43200, "s", "The test ends then in any case.", hal::must(times)};
    hal::In<bool> by_displacement{this, "by-displacement", true, "The displacements must stand, too.",
                                  hal::must()};
    hal::In<double> range_floor{
        this, "range-floor", 0.002, "mu", "A range this small is always accepted.", hal::expert(lengths)};
    hal::In<double> uncertainty{this,
                                "position-uncertainty",
                                0.0007,
                                "mu",
                                "Standard uncertainty of a displacement; four of it are accepted.",
                                hal::must(lengths)};
    hal::In<double> most_scatter{this,
                                 "max-scatter",
                                 0.01,
                                 "mu",
                                 "Largest scatter of the touches of a bore about its circle.",
                                 hal::must(lengths)};
    hal::In<double> most_change{this,
                                "max-shape-change",
                                0.004,
                                "mu",
                                "Largest change of oval and radius of a bore since its first visit.",
                                hal::machine(lengths)};
    hal::In<double> farthest{this,
                             "max-displacement",
                             0.5,
                             "mu",
                             "Farthest that a bore may be from its place in the first pass.",
                             hal::machine(lengths)};
    hal::In<double> most_step{this,
                              "max-step",
                              0.1,
                              "mu",
                              "Largest displacement of a bore since its last pass.",
                              hal::machine(lengths)};
    hal::In<double> most_slip{this,
                              "max-slip",
                              0.03,
                              "mu",
                              "Largest part of this displacement that the other bores do not share.",
                              hal::machine(lengths)};
    hal::In<double> least_slip{this,
                               "min-slip",
                               0.01,
                               "mu",
                               "Smallest slip of the whole artifact that is reported.",
                               hal::machine(lengths)};
    hal::In<double> least_rise{this,
                               "least-rise",
                               0.5,
                               "K",
                               "Least rise of a machine that has warmed; 0 if it only stands.",
                               hal::machine(rises)};

    // Nothing where one of them is out of its range, or they contradict themselves.
    std::optional<GrowthTest::Settings> read() noexcept {
        hal::SettingsReader read;
        GrowthTest::Settings s;
        s.stop.threshold = read(threshold);
        s.stop.interval = read(interval);
        s.stop.minimum_time = read(minimum_time);
        s.stop.maximum_time = read(maximum_time);
        s.stop.by_displacement = by_displacement;
        s.stop.range_floor = read(range_floor);
        s.stop.uncertainty = read(uncertainty);
        s.most_scatter = read(most_scatter);
        s.most_change = read(most_change);
        s.farthest = read(farthest);
        s.most_step = read(most_step);
        s.most_slip = read(most_slip);
        s.least_slip = read(least_slip);
        s.least_rise = read(least_rise);
        if (!read.good() || !s.valid()) return std::nullopt;
        return s;
    }
};

// The position of the machine, and the compensation that it contains.
struct Machine : hal::Group {
    using Group::Group;

    hal::Axes<hal::In<double>, 3> position{this, "%-position", 0.0, "mu",
                                           "Position of % by its encoder, compensation included."};
    hal::Axes<hal::In<double>, 3> offset{this, "%-offset", 0.0, "mu",
                                         "Compensation contained in %-position."};
    hal::Axes<hal::In<double>, 3> velocity{this, "%-velocity", 0.0, "mu/s", "Velocity of %."};
    hal::In<double> table_position{this, "table-position", 0, "deg", "Position of the table or trunnion."};
    static constexpr hal::Range angles{-1e6, 1e6}, turns{0, 180};
    hal::In<double> table_0{
        this, "table-0", 0, "deg", "Its position for the orientation 0.", hal::machine(angles)};
    hal::In<double> table_180{
        this, "table-180", 180, "deg", "Its position for the other orientation.", hal::machine(angles)};
    hal::In<double> table_tolerance{
        this, "table-tolerance", 0.01, "deg", "Largest error of the orientation.", hal::machine(turns)};
    hal::In<bool> table{this, "table", false, "The machine has a table or trunnion; check its position.",
                        hal::machine()};

    void read(Position& r) noexcept {
        r.good = true;
        for (std::size_t i = 0; i < 3; ++i) {
            r.position[i] = position[i];
            r.offset[i] = offset[i];
            r.velocity[i] = velocity[i];
            for (const double value : {r.position[i], r.offset[i], r.velocity[i]})
                if (!(std::abs(value) <= 1e6)) r.good = false;
        }
    }

    // Whether the table is where the program wants it.
    bool oriented(bool turned) const noexcept {
        const double wanted = turned ? table_180 : table_0;
        return !table || std::abs(std::remainder(table_position - wanted, 360)) <= table_tolerance;
    }
};

// The outputs of a test.
struct TestReport : hal::Group {
    using Group::Group;

    hal::Code<State> state{this, "state-code", "Number of the state; 0 for idle."};
    hal::Codes<Stop> stop_reason{this, "stop-reason", "The test has stopped; stop-reason-code gives why.",
                                 "Number of the reason for the stop; 0 before the test has stopped."};
    hal::Out<bool> done{this, "done", "The machine is warm, or the time is over."};
    hal::Out<std::int32_t> cycle_index{this, "cycle-index", "Number of cycles that ended."};
    hal::Out<std::int32_t> pass{this, "pass", "Number of the present or last pass."};
    hal::Out<std::int32_t> visit{this, "visit", "Number of visits of bores."};
    hal::Out<std::int32_t> touches{this, "touches", "Number of touches that were latched."};
    hal::Out<double> elapsed{this, "elapsed", "s", "Time since the test began."};
    hal::Out<double> change{this, "temperature-change", "K",
                            "Largest change of a temperature in the interval; 1000 while unknown."};
    hal::Axes<hal::Out<double>, 3> touch{this, "touch-%", "mu", "% of the last touch, with compensation."};
    hal::Axes<hal::Out<double>, 3> touch_offset{this, "touch-%-offset", "mu",
                                                "Compensation in % at the last touch."};
    hal::Axes<hal::Out<double>, 3> bore{this, "bore-%", "mu",
                                        "% of the last bore or face, without compensation."};
    hal::Out<double> bore_diameter{this, "bore-diameter", "mu", "Diameter of the last bore."};
    hal::Out<double> bore_scatter{this, "bore-scatter", "mu", "Scatter of its touches about the circle."};
    static constexpr hal::Range balls{0, 100};
    hal::In<double> ball{
        this, "ball-diameter", 6, "mu", "Diameter of the ball of the probe.", hal::machine(balls)};
    hal::In<bool> boss{this, "outside", false, "The probe touches a boss or a sphere from outside.",
                       hal::machine()};
    hal::Out<bool> repeat{this, "repeat", "The last visit does not count; probe the bore again."};
    hal::Out<bool> compensation_request{this, "compensation-request", "Compensation shall be on."};
    hal::Out<bool> cooling_request{this, "cooling-request", "Temperature control shall be on."};
    hal::Out<bool> confirmed{this, "confirmed", "The control confirms both wanted states."};
    hal::Codes<Advice> advice{this, "advice", "The settings are unusual; advice-code gives how.",
                              "Number of the advice; 0 for none."};
    hal::Told told_advice{this, "advice", hal::Tell::behind_panel, "{advice-code}"};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Told told_fault{this, "fault", hal::Tell::text, "{fault-code}"};  // the test goes on
    hal::Out<std::int32_t> fault_bore{this, "fault-bore", "Number of the bore of the fault; 0 for none."};

    void show(const GrowthTest& test, const GrowthTest::Settings& settings) noexcept {
        const bool ended = test.stop() != Stop::none;
        state_ = !test.active()   ? (!test.begun() ? State::idle
                                     : ended       ? State::stopped
                                                   : State::interrupted)
                 : test.in_pass() ? (test.pass() <= 1 ? State::probing_cold : State::probing)
                 : ended          ? State::stopped
                                  : State::warming;
        state = state_;
        stop_reason = test.stop();
        done = ended;
        cycle_index = test.cycles();
        pass = test.pass();
        visit = test.visits();
        touches = test.touches();
        elapsed = test.time();
        repeat = test.repeat();
        fault_bore = test.bore_of_fault();
        advice = hal::first<Advice>({{!settings.stop.usual(), Advice::threshold},
                                     {!settings.stop.by_displacement, Advice::one_rule}});
        if (test.records().size() == shown_) return;
        shown_ = test.records().size();
        change = std::fmin(test.change(settings), 1000);
    }

    void show_touch(const Position& at) noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            touch[i] = at.position[i];
            touch_offset[i] = at.offset[i];
        }
    }

    void show_bore(const GrowthTest::Bore& centre) noexcept {
        bore[0] = centre.x;
        bore[1] = centre.y;
        bore[2] = centre.z;
        const double diameter = ball, size = std::abs(diameter) <= 1e6 ? diameter : 0;
        bore_diameter = 2 * centre.radius + (boss ? -size : size);
        bore_scatter = centre.scatter;
    }

    State now() const noexcept { return state_; }

private:
    State state_ = State::idle;
    std::size_t shown_ = SIZE_MAX;  // records at the last computation of temperature-change
};

}  // namespace growth_test

using namespace growth_test;

struct ThermalGrowthTest final : hal::Component {
    static constexpr hal::About about{
        "thermal_growth_test",
        "measures how much a machine grows as it warms, and whether its compensation helps", page,
        "Growth test"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};
    hal::Count sensors{
        this, "sensors",          0,
        0,    Temperatures::most, "Number of temperature sensors, 0 to 8: the rows temperature-N and so on."};
    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock};
    Program program{this};
    Machine machine{this};
    Temperatures temperatures{this, sensors};
    StopSettings stop_settings{this};

    TestReport report{this};
    hal::Status<Status> status{this, permission};
    hal::Records rows{this};
    GrowthRow row{this};

    hal::Function run{this, "update", &ThermalGrowthTest::update, hal::Place::measurement};

    void prepare() override {
        settings_ = stop_settings.read().value_or(settings_);  // the defaults
        test_.reserve();
        test_.clear();
    }

    void update(double dt) noexcept {
        permission.step();
        Signals now = program.read(dt);
        machine.read(now.at);
        now.oriented = machine.oriented(now.turned);
        temperatures.read(now.warmth);
        const std::optional<GrowthTest::Settings> wanted = stop_settings.read();
        const bool good_settings = wanted.has_value();
        if (good_settings) settings_ = *wanted;
        settings_.stop.sensors = now.warmth.decides;

        if (now.acknowledged) test_.acknowledge();
        const GrowthTest::Result result = test_.step(now, settings_, dt);
        walk();

        report.show(test_, settings_);
        if (result == GrowthTest::Result::touch) report.show_touch(now.at);
        if (result == GrowthTest::Result::bore) report.show_bore(test_.bore());
        report.compensation_request = now.wants_compensation;
        report.cooling_request = now.wants_cooling;
        report.confirmed = now.confirmed;
        const Fault its_fault = hal::first<Fault>({{test_.fault() != Fault::none, test_.fault()},
                                                   {!now.at.good, Fault::position},
                                                   {!now.warmth.good, Fault::sensor},
                                                   {!good_settings, Fault::settings},
                                                   {now.unconfirmed, Fault::unconfirmed},
                                                   {!now.warmth.artifact_good, Fault::artifact_temperature}});
        report.fault = its_fault;
        status = status_of({report.now(), test_.stop(), now.running.now, its_fault != Fault::none, now.gone,
                            now.paused, now.resumable, status.of_interlock()});
        permission.report({});
    }

private:
    void walk() noexcept {
        if (rows.wants_forget() && !test_.active()) test_.clear();
        if (rows.wants_restore()) rows.restored(test_.restore(row.given(), settings_));
        rows.show(static_cast<std::int32_t>(test_.records().size()),
                  [&](std::int32_t i) noexcept { row.show(test_.records()[static_cast<std::size_t>(i)]); });
    }

    GrowthTest test_;
    GrowthTest::Settings settings_;  // last good values
};

hal::Model hal::model() {
    return model_of<ThermalGrowthTest>();
}

}  // namespace plumb
