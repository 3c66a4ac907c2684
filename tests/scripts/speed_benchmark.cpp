// SPDX-License-Identifier: GPL-2.0-or-later
// The speed of the virtual-time host, and the cost of a component's update() beside LinuxCNC's own pid.
//
// Not one of the tests: build/tests/speed_benchmark. A shared computer blurs single figures, so each is the
// median of many short runs, and figures to be compared are run in turns.
#include "hal/client/client.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double period = 0.001;  // seconds

// A host with servo-thread, started.
std::unique_ptr<client::Client> host_with(const std::vector<std::string>& commands) {
    client::Start start;
    const auto bin = std::filesystem::path(client::find_host()).parent_path();
    start.modules = {bin.parent_path() / "specimens"};
    auto client = std::make_unique<client::Client>(start);
    client->command("loadrt threads name1=servo-thread period1=1000000");
    for (const std::string& command : commands) client->command(command);
    client->command("start");
    return client;
}

double nanoseconds_per_period(client::Client& client, double simulated_seconds) {
    const auto begin = std::chrono::steady_clock::now();
    client.run(client::seconds(simulated_seconds));
    const std::chrono::duration<double, std::nano> real = std::chrono::steady_clock::now() - begin;
    return real.count() / (simulated_seconds / period);
}

double quantile(std::vector<double> values, double part) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1) + 0.5)];
}

// How much faster than the clock, for these commands.
void virtual_time(benchmark::State& state, const std::vector<std::string>& commands) {
    const auto client = host_with(commands);
    nanoseconds_per_period(*client, 60);  // warm up
    std::vector<double> costs;
    for (auto _ : state) {
        costs.push_back(nanoseconds_per_period(*client, 600));
        state.SetIterationTime(costs.back() * 600 / period * 1e-9);
    }
    state.counters["ns/period"] = quantile(costs, 0.5);
    state.counters["times_real_time"] = period * 1e9 / quantile(costs, 0.5);
}

void empty_thread(benchmark::State& state) {
    virtual_time(state, {});
}

void control_loop(benchmark::State& state) {
    virtual_time(state, {"loadrt siggen names=wave",
                         "loadrt limit3 names=limit",
                         "loadrt lowpass names=filter",
                         "loadrt pid names=loop",
                         "loadrt scale names=scale",
                         "setp wave.frequency 1",
                         "setp limit.maxv 3",
                         "setp limit.maxa 100",
                         "setp filter.gain 0.05",
                         "setp loop.Pgain 3",
                         "setp loop.Igain 0.5",
                         "setp loop.enable 1",
                         "setp scale.gain 2",
                         "net wanted wave.sine => limit.in",
                         "net possible limit.out => filter.in",
                         "net smooth filter.out => loop.command",
                         "net driven loop.output => scale.in",
                         "addf wave.update servo-thread",
                         "addf limit servo-thread",
                         "addf filter servo-thread",
                         "addf loop.do-pid-calcs servo-thread",
                         "addf scale servo-thread"});
}

// A client that runs one period after the other.
void single_periods(benchmark::State& state) {
    const auto client = host_with({});
    for (auto _ : state) client->run(client::seconds(period));
}

// A module to be timed, many instances at once: it-0, it-1, ...  Its inputs change all the time; `alive` is a
// pin that is not 0 when it has really worked.
struct Subject {
    std::string module;
    std::string function;
    std::vector<std::pair<std::string, std::string>> settings;  // pin, value
    std::vector<std::pair<std::string, std::string>> inputs;    // pin, signal: slow, slope, steps, heat
    std::string alive;
    std::vector<std::pair<std::string, std::string>> options = {};  // of each instance
    std::vector<std::string> before = {};                           // commands
};

constexpr int instances = 16;  // as many as pid allows

// `before`: commands of the subject that is compared, so that nothing but the two modules differs.
std::vector<std::string> commands_of(const Subject* subject, const std::vector<std::string>& before = {}) {
    std::vector<std::string> commands{"loadrt siggen names=slow-wave,step-wave,heat-wave",
                                      "setp slow-wave.frequency 0.1",
                                      "setp slow-wave.amplitude 100",
                                      "setp step-wave.frequency 0.2",
                                      "setp step-wave.amplitude 10",
                                      "setp step-wave.offset 20",
                                      "net slow slow-wave.sine",
                                      "net slope slow-wave.cosine",
                                      "net steps step-wave.square",
                                      "setp heat-wave.frequency 0.01",
                                      "setp heat-wave.amplitude 0.0001",
                                      "net heat heat-wave.sine",
                                      "addf heat-wave.update servo-thread",
                                      "addf slow-wave.update servo-thread",
                                      "addf step-wave.update servo-thread"};
    commands.insert(commands.end(), before.begin(), before.end());
    if (!subject) return commands;
    std::string names;
    for (int i = 0; i < instances; ++i) names += (i ? ",it-" : "it-") + std::to_string(i);
    for (const auto& [option, value] : subject->options) {
        names += " " + option + "=" + value;
        for (int i = 1; i < instances; ++i) names += "," + value;
    }
    commands.push_back("loadrt " + subject->module + " names=" + names);
    for (int i = 0; i < instances; ++i) {
        const std::string instance = "it-" + std::to_string(i) + ".";
        for (const auto& [pin, value] : subject->settings)
            commands.push_back("setp " + instance + pin + " " + value);
        for (const auto& [pin, signal] : subject->inputs)
            commands.push_back("net " + signal + " " + instance + pin);
        commands.push_back("addf " + instance + subject->function + " servo-thread");
    }
    return commands;
}

const Subject pid{"pid",
                  "do-pid-calcs",
                  {{"enable", "1"}, {"Pgain", "3"}, {"Igain", "0.5"}, {"Dgain", "0.01"}, {"FF1", "1"}},
                  {{"command", "slow"}, {"feedback", "steps"}},
                  "output"};

// One update() of the subject as a multiple of one of another. Both, and the thread without either, take
// turns.
void beside(benchmark::State& state, const Subject& subject, const Subject& other,
            const std::string& name) try {
    const auto without = host_with(commands_of(nullptr, subject.before));
    const auto with_other = host_with(commands_of(&other, subject.before));
    const auto with_subject = host_with(commands_of(&subject, subject.before));
    constexpr double turn = 20;  // simulated seconds
    std::vector<double> others;
    std::vector<double> subjects;
    std::vector<double> ratios;
    for (auto _ : state) {
        const double empty = nanoseconds_per_period(*without, turn);
        others.push_back((nanoseconds_per_period(*with_other, turn) - empty) / instances);
        subjects.push_back((nanoseconds_per_period(*with_subject, turn) - empty) / instances);
        ratios.push_back(subjects.back() / others.back());
        state.SetIterationTime(subjects.back() * 1e-9);
    }
    for (const auto& [client, timed] : {std::pair{with_other.get(), &other}, {with_subject.get(), &subject}})
        if (client->get("it-0." + timed->alive) == 0)
            throw std::runtime_error("it-0." + timed->alive + " is 0: it was not at work");
    state.counters["ns"] = quantile(subjects, 0.5);
    state.counters[name + "_ns"] = quantile(others, 0.5);
    state.counters["ratio"] = quantile(ratios, 0.5);
    state.counters["ratio_p10"] = quantile(ratios, 0.1);
    state.counters["ratio_p90"] = quantile(ratios, 0.9);
} catch (const std::runtime_error& error) {
    state.SkipWithError(error.what());
}

void beside_pid(benchmark::State& state, const Subject& subject) {
    beside(state, subject, pid, "pid");
}

void thermal_displacement_beside_pid(benchmark::State& state) {
    beside_pid(state, {"thermal_displacement",
                       "update",
                       {{"enable", "1"},
                        {"cycle-running", "1"},
                        {"operation", "1"},
                        {"tool-number", "1"},
                        {"spindle-speed-cmd", "3000"},
                        {"z-velocity-cmd", "-10"}},
                       {{"load", "steps"}, {"z-position", "slow"}},
                       "contacts",
                       {{"interlock", "no"}}});
}

// A cycle to learn from, of two seconds, in which a tool meets the work: all that a contact takes.
std::filesystem::path write_cycle(int periods) {
    const auto path = std::filesystem::temp_directory_path() / "plumb_speed_benchmark.csv";
    std::ofstream file(path);
    file << "time,running,complete,motion,velocity,height,load\n";
    for (int i = 0; i <= periods; ++i) {
        const double time = i * period;
        const double cut = time - 1;
        const bool running = time > 0.1 && time < 1.9;
        const bool feeds = running && time < 1.5;
        const double rise = feeds && cut > 0 ? -8 * std::expm1(-cut / 0.03) : 0;
        file << time << ',' << running << ',' << !running << ',' << (feeds ? 2 : 1) << ',' << (feeds ? -2 : 0)
             << ',' << (feeds ? -2 * cut : 5) << ',' << 5 + rise + 0.2 * std::sin(1000 * time) << '\n';
    }
    return path;
}

// The least time of each stretch of the cycle, over many repeats of it, in ns a period. A single period
// would be lost in the time of a request to the host; the fit lasts for more than a hundred.
std::vector<double> least_of_each_stretch(client::Client& client, const std::filesystem::path& cycle,
                                          int periods) {
    constexpr int repeats = 40;
    constexpr int stretch = 20;
    std::vector<double> least(static_cast<std::size_t>(periods / stretch),
                              std::numeric_limits<double>::infinity());
    for (int repeat = 0; repeat < repeats; ++repeat) {
        client.replay({cycle.string()});
        for (double& its_least : least)
            its_least = std::min(its_least, nanoseconds_per_period(client, stretch * period));
    }
    return least;
}

// The most that one update() takes, as a multiple of one of pid: of the same stretches of many cycles the
// fastest, which nothing else on the computer disturbed, and of these the slowest.
// `known`: a cycle was learned, and another one compared with it, before.
void thermal_displacement_in_cycles(benchmark::State& state, bool known) try {
    constexpr int periods = 2000;
    const auto cycle = write_cycle(periods);
    const std::vector<std::pair<std::string, std::string>> inputs{
        {"cycle-running", "running"},   {"cycle-complete", "complete"}, {"motion-type", "motion"},
        {"z-velocity-cmd", "velocity"}, {"z-position", "height"},       {"load", "load"}};
    const Subject subject{
        "thermal_displacement",
        "update",
        {{"enable", "1"}, {"learn", "1"}, {"operation", "1"}, {"tool-number", "1"}, {"blanking-time", "0"}},
        inputs,
        "contacts",
        {{"interlock", "no"}}};
    auto commands = commands_of(nullptr);
    for (const auto& [pin, signal] : inputs) {
        const bool bit = signal == "running" || signal == "complete";
        commands.push_back("newsig " + signal + (bit ? " bit" : signal == "motion" ? " s32" : " float"));
    }
    const auto with = [&](const Subject& timed) {
        auto all = commands;
        const auto its = commands_of(&timed);
        all.insert(all.end(), its.begin() + static_cast<std::ptrdiff_t>(commands_of(nullptr).size()),
                   its.end());
        return host_with(all);
    };
    const auto without = host_with(commands);
    const auto with_pid = with(pid);
    const auto with_subject = with(subject);
    if (known) {
        with_subject->replay({cycle.string()});
        with_subject->run(client::seconds(periods * period));
        for (int i = 0; i < instances; ++i) with_subject->set("it-" + std::to_string(i) + ".learn", 0);
        with_subject->replay({cycle.string()});
        with_subject->run(client::seconds(periods * period));
        if (with_subject->get("it-0.contacts-accepted") == 0)
            throw std::runtime_error("the growth is not known");
    }
    for (auto _ : state) {
        const double empty = quantile(least_of_each_stretch(*without, cycle, periods), 0.5);
        const double one_pid =
            (quantile(least_of_each_stretch(*with_pid, cycle, periods), 0.5) - empty) / instances;
        const auto all = least_of_each_stretch(*with_subject, cycle, periods);
        const double slowest = (quantile(all, 1) - empty) / instances;
        state.SetIterationTime(slowest * 1e-9);
        state.counters["ns"] = slowest;
        state.counters["pid_ns"] = one_pid;
        state.counters["ratio"] = slowest / one_pid;
        const double median = (quantile(all, 0.5) - empty) / instances;
        state.counters["median_ns"] = median;
        state.counters["median_ratio"] = median / one_pid;
    }
    std::filesystem::remove(cycle);
    if (with_subject->get("it-0.contacts") == 0 || with_subject->get("it-0.contacts-rejected") > 0)
        throw std::runtime_error("it-0 has fitted no contact");
} catch (const std::runtime_error& error) {
    state.SkipWithError(error.what());
}

void slowest_thermal_displacement_beside_pid(benchmark::State& state) {
    thermal_displacement_in_cycles(state, false);
}

void known_thermal_displacement_beside_pid(benchmark::State& state) {
    thermal_displacement_in_cycles(state, true);
}

// Taking an offset back, which is all that it does when it is armed, too.
void axis_offset_beside_pid(benchmark::State& state) {
    beside_pid(state, {"axis_offset",
                       "update",
                       {{"motion-enabled", "1"}, {"all-homed", "1"}, {"clear", "1"}},
                       {{"offset-0", "steps"}},
                       "uncompensated"});
}

// Following one source, while motion goes to and fro.
void joint_offset_beside_pid(benchmark::State& state) {
    beside_pid(state, {"joint_offset",
                       "update",
                       {{"motion-enabled", "1"},
                        {"homed", "1"},
                        {"min-limit", "-50"},
                        {"max-limit", "50"},
                        {"joint-acceleration", "1000"},
                        {"offset-acceleration", "500"},
                        {"max-offset", "50"}},
                       {{"offset-0", "steps"}, {"position", "slow"}, {"joint-command", "slow"}},
                       "applied-offset"});
}

// A portal whose rail and ram lean, all four axes in motion, with a boring bar.
Subject squareness() {
    return {"squareness",
            "update",
            {{"enable", "1"},
             {"all-homed", "1"},
             {"max-speed", "1000"},
             {"ea0w", "0.0004"},
             {"eb0w", "-0.0003"},
             {"ea0z", "-0.0002"},
             {"eb0z", "0.0001"},
             {"radial-offset", "30"},
             {"z-tool-offset", "250"}},
            {{"x-position", "slow"},
             {"x-velocity", "slope"},
             {"y-position", "slow"},
             {"y-velocity", "slope"},
             {"z-position", "slow"},
             {"w-position", "slope"}},
            "y-correction",
            {{"chain", "w-X.b-W-Y-Z-C-t"}, {"interlock", "no"}}};
}

void squareness_beside_pid(benchmark::State& state) {
    beside_pid(state, squareness());
}

// As when heat bends the column: an angle is another one in each period.
Subject drifting(Subject subject) {
    subject.inputs.emplace_back("ea0w", "heat");
    subject.settings.erase(subject.settings.begin() + 3);
    return subject;
}

void drifting_squareness_beside_pid(benchmark::State& state) {
    beside_pid(state, drifting(squareness()));
}

// The tip on a contour whose direction is another one in each period.
Subject contouring(Subject subject) {
    subject.settings.emplace_back("tip-on-contour", "1");
    subject.settings.emplace_back("compensation-radius", "25");
    for (auto& [pin, signal] : subject.inputs)
        if (pin == "x-velocity") signal = "slow";
    return subject;
}

void contouring_squareness_beside_pid(benchmark::State& state) {
    beside_pid(state, contouring(squareness()));
}

// All six errors of all four axes, each at 101 places, beside the tilts; with `directed` each in both
// directions.
struct Tables {
    explicit Tables(bool directed = false)
        : path(std::filesystem::temp_directory_path() /
               (directed ? "plumb_speed_turns.csv" : "plumb_speed_tables.csv")) {
        std::ofstream file(path);
        for (const char axis : {'X', 'Y', 'Z', 'W'}) {
            file << axis;
            for (const char* error : {"EX", "EY", "EZ", "EA", "EB", "EC"}) {
                file << ',' << error << axis;
                if (directed) file << "+," << error << axis << '-';
            }
            for (int i = -50; i <= 50; ++i) {
                file << '\n' << 10 * i;
                for (int k = 0; k < 12; ++k)
                    if (directed || k % 2 == 0)
                        file << ','
                             << (k < 6 ? 0.01 : 5e-5) * std::sin(0.1 * i + axis + k / 2 + 0.2 * (k % 2));
            }
            file << '\n';
        }
        file << "# end, " << 4 * 101 << " rows\n";
    }
    ~Tables() { std::filesystem::remove(path); }

    Subject of(Subject subject) const {
        subject.options.emplace_back("table", path.string());
        return subject;
    }

    std::filesystem::path path;
};

void squareness_with_tables_beside_pid(benchmark::State& state) {
    const Tables tables;
    beside_pid(state, tables.of(squareness()));
}

void squareness_with_directions_beside_pid(benchmark::State& state) {
    const Tables tables(true);
    beside_pid(state, tables.of(squareness()));
}

void squareness_with_directions_beside_tables(benchmark::State& state) {
    const Tables tables, directions(true);
    beside(state, directions.of(squareness()), tables.of(squareness()), "tables");
}

void drifting_squareness_with_tables_beside_pid(benchmark::State& state) {
    const Tables tables;
    beside_pid(state, tables.of(drifting(squareness())));
}

void contouring_squareness_with_tables_beside_pid(benchmark::State& state) {
    const Tables tables;
    beside_pid(state, tables.of(contouring(squareness())));
}

// A stroke with two sections, jerk limited. Without learning: no axis is measured here.
Subject chopping() {
    return {"chopping",
            "update",
            {{"motion-enabled", "1"},
             {"homed", "1"},
             {"lower", "-40"},
             {"min-limit", "-100"},
             {"max-limit", "100"},
             {"feed", "100"},
             {"jerk-time", "0.02"},
             {"section-0-kind", "2"},
             {"section-0-from", "-30"},
             {"section-0-to", "-10"},
             {"section-0-ratio", "0.5"},
             {"section-1-kind", "4"},
             {"section-1-from", "-9"},
             {"section-1-to", "-1"},
             {"section-1-ratio", "0.9"},
             {"run", "1"}},
            {},
            "command",
            {{"sections", "2"}, {"interlock", "no"}}};
}

void chopping_beside_pid(benchmark::State& state) {
    beside_pid(state, chopping());
}

// With the infeed of another axis, at each upper dead point until its total.
void feeding_chopping_beside_pid(benchmark::State& state) {
    Subject subject = chopping();
    subject.options.emplace_back("infeed", "1");
    for (const auto& [pin, value] : {std::pair{"amount", "-0.01"},
                                     {"total", "1"},
                                     {"clear", "2"},
                                     {"min-limit", "-10"},
                                     {"max-limit", "10"}})
        subject.settings.emplace_back(std::string("infeed-") + pin, value);
    beside_pid(state, subject);
}

// The most that a period can take: a section is another one in each, so that each is judged and plans.
void planning_chopping_beside_pid(benchmark::State& state) {
    Subject subject = chopping();
    subject.settings.erase(subject.settings.begin() + 13);
    subject.inputs.emplace_back("section-1-to", "heat");
    beside_pid(state, subject);
}

// Without a procedure, with height and x of eight cuts on its pins.
Subject centre_height() {
    Subject subject{
        "centre_height",      "update", {{"keyed", "1"}, {"cuts", "8"}, {"method", "3"}}, {}, "sigma",
        {{"keyed_cuts", "8"}}};
    for (int i = 0; i < 8; ++i) {
        const double x = 5 - 0.1 * i, y = i % 2 ? -1 : 1;
        const std::string number = "-" + std::to_string(i);
        subject.settings.emplace_back("cut-diameter" + number, std::to_string(2 * std::hypot(x, y + 0.05)));
        subject.settings.emplace_back("cut-x" + number, std::to_string(x));
        subject.settings.emplace_back("cut-y" + number, std::to_string(y));
    }
    subject.settings.emplace_back("compute", "1");
    return subject;
}

void centre_height_beside_pid(benchmark::State& state) {
    beside_pid(state, centre_height());
}

// The most that a period can take: a fit of eight cuts, here in every second one.
void computing_centre_height_beside_pid(benchmark::State& state) {
    Subject subject = centre_height();
    subject.settings.pop_back();
    subject.inputs.emplace_back("compute", "every-second");
    subject.before = {"loadrt charge_pump", "net every-second charge-pump.out",
                      "addf charge-pump servo-thread"};
    beside_pid(state, subject);
}

// The words of functions, stages and programs beat, those of programs every fourth period. All functions are
// on, and offsets ramp.
Subject interlock(int functions, int stages) {
    Subject subject{"interlock",
                    "update",
                    {{"motion-enabled", "1"}, {"all-homed", "1"}, {"path-speed", "10"}, {"motion-type", "2"}},
                    {},
                    "ramping",
                    {{"functions", std::to_string(functions)}, {"stages", std::to_string(stages)}},
                    {"loadrt peers names=peers", "loadrt charge_pump", "net beat charge-pump.out-4",
                     "addf charge-pump servo-thread", "addf peers.update servo-thread"}};
    const auto row = [&](const std::string& kind, int i) {
        const std::string number = std::to_string(i), word = kind + "-" + number;
        subject.before.push_back("net " + word + " peers." + kind + "-state-" + number);
        subject.inputs.emplace_back(kind + "-state-" + number, word);
    };
    for (int i = 0; i < 8; ++i) {
        row("service", i);
        subject.before.push_back("net beat peers.service-heartbeat-" + std::to_string(i));
        subject.settings.emplace_back("service-timeout-" + std::to_string(i), "1");
    }
    for (int i = 0; i < functions; ++i) {
        row("function", i);
        subject.settings.emplace_back("function-switch-" + std::to_string(i), "1");
    }
    for (int i = 0; i < stages; ++i) row("stage", i);
    subject.before.push_back("setp peers.stage-ramping-0 1");
    return subject;
}

void interlock_beside_pid(benchmark::State& state) {
    beside_pid(state, interlock(2, 3));
}

void full_interlock_beside_pid(benchmark::State& state) {
    beside_pid(state, interlock(16, 17));
}

// Nothing is netted to it.
void idle_interlock_beside_pid(benchmark::State& state) {
    beside_pid(state, {"interlock", "update", {}, {}, "heartbeat", {{"functions", "2"}, {"stages", "3"}}});
}

// The cost of LinuxCNC's own kinematics in each period, for a machine that is not trivial: inverse and
// forward.
void stock_kinematics_beside_pid(benchmark::State& state) {
    beside_pid(state, {"kinematics_caller",
                       "update",
                       {},
                       {{"x", "slow"}, {"y", "slope"}, {"z", "slow"}, {"b", "steps"}, {"c", "slow"}},
                       "z-joint",
                       {},
                       {"loadrt 5axiskins"}});
}

BENCHMARK(empty_thread)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(control_loop)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(single_periods)->UseRealTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(thermal_displacement_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(slowest_thermal_displacement_beside_pid)->UseManualTime()->Iterations(1);
BENCHMARK(known_thermal_displacement_beside_pid)->UseManualTime()->Iterations(1);
BENCHMARK(axis_offset_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(squareness_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(drifting_squareness_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(contouring_squareness_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(squareness_with_tables_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(squareness_with_directions_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(squareness_with_directions_beside_tables)->UseManualTime()->Iterations(40);
BENCHMARK(drifting_squareness_with_tables_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(contouring_squareness_with_tables_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(chopping_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(feeding_chopping_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(planning_chopping_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(centre_height_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(computing_centre_height_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(stock_kinematics_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(idle_interlock_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(interlock_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(full_interlock_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(joint_offset_beside_pid)->UseManualTime()->Iterations(40);

}  // namespace
}  // namespace plumb

BENCHMARK_MAIN();
