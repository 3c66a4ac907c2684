// SPDX-License-Identifier: GPL-2.0-or-later
// How fast the virtual-time host is, and what update() of a component costs beside LinuxCNC's own pid.
//
// Not one of the tests: build/bin/speed_benchmark.  A shared computer blurs single figures, so that each is
// the median of many short runs, and what is compared is run in turns.
#include "hal/host/client.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double period = 0.001;  // seconds

// A host with servo-thread, started.
std::unique_ptr<host::Client> host_with(const std::vector<std::string>& commands) {
    auto client = std::make_unique<host::Client>();
    client->command("loadrt threads name1=servo-thread period1=1000000");
    for (const std::string& command : commands) client->command(command);
    client->command("start");
    return client;
}

double nanoseconds_per_period(host::Client& client, double simulated_seconds) {
    const auto begin = std::chrono::steady_clock::now();
    client.run(host::seconds(simulated_seconds));
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

// A module to be timed, many instances at once: it-0, it-1, ...  Its inputs change all the time; `alive` is a
// pin that is not 0 when it has really worked.
struct Subject {
    std::string module;
    std::string function;
    std::vector<std::pair<std::string, std::string>> settings;  // pin, value
    std::vector<std::pair<std::string, std::string>> inputs;    // pin, signal: slow, slope or steps
    std::string alive;
};

constexpr int instances = 16;  // as many as pid allows

std::vector<std::string> commands_of(const Subject* subject) {
    std::vector<std::string> commands{"loadrt siggen names=slow-wave,step-wave",
                                      "setp slow-wave.frequency 0.1",
                                      "setp slow-wave.amplitude 100",
                                      "setp step-wave.frequency 0.2",
                                      "setp step-wave.amplitude 10",
                                      "setp step-wave.offset 20",
                                      "net slow slow-wave.sine",
                                      "net slope slow-wave.cosine",
                                      "net steps step-wave.square",
                                      "addf slow-wave.update servo-thread",
                                      "addf step-wave.update servo-thread"};
    if (!subject) return commands;
    std::string names;
    for (int i = 0; i < instances; ++i) names += (i ? ",it-" : "it-") + std::to_string(i);
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

// One update() of the subject as a multiple of one of pid.  Both, and the thread without either, take turns.
void beside_pid(benchmark::State& state, const Subject& subject) try {
    const auto without = host_with(commands_of(nullptr));
    const auto with_pid = host_with(commands_of(&pid));
    const auto with_subject = host_with(commands_of(&subject));
    constexpr double turn = 20;  // simulated seconds
    std::vector<double> pids;
    std::vector<double> subjects;
    std::vector<double> ratios;
    for (auto _ : state) {
        const double empty = nanoseconds_per_period(*without, turn);
        pids.push_back((nanoseconds_per_period(*with_pid, turn) - empty) / instances);
        subjects.push_back((nanoseconds_per_period(*with_subject, turn) - empty) / instances);
        ratios.push_back(subjects.back() / pids.back());
        state.SetIterationTime(subjects.back() * 1e-9);
    }
    for (const auto& [client, timed] : {std::pair{with_pid.get(), &pid}, {with_subject.get(), &subject}})
        if (client->get("it-0." + timed->alive) == 0)
            throw std::runtime_error("it-0." + timed->alive + " is 0: it was not at work");
    state.counters["ns"] = quantile(subjects, 0.5);
    state.counters["pid_ns"] = quantile(pids, 0.5);
    state.counters["ratio"] = quantile(ratios, 0.5);
    state.counters["ratio_p10"] = quantile(ratios, 0.1);
    state.counters["ratio_p90"] = quantile(ratios, 0.9);
} catch (const std::runtime_error& error) {
    state.SkipWithError(error.what());
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
                       "contacts"});
}

// Taking an offset back, which is all that it does when it is armed, too.
void axis_offset_beside_pid(benchmark::State& state) {
    beside_pid(state, {"axis_offset",
                       "update",
                       {{"motion-enabled", "1"}, {"all-homed", "1"}, {"clear", "1"}},
                       {{"offset", "steps"}},
                       "uncompensated"});
}

BENCHMARK(empty_thread)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(control_loop)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(thermal_displacement_beside_pid)->UseManualTime()->Iterations(40);
BENCHMARK(axis_offset_beside_pid)->UseManualTime()->Iterations(40);

}  // namespace
}  // namespace plumb

BENCHMARK_MAIN();
