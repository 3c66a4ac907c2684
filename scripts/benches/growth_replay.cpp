// SPDX-License-Identifier: GPL-2.0-or-later
// Replays the contacts of a file of scripts/bench rivals, from stdin, through the filter of
// thermal_displacement, and writes "OFFSET SIGMA TOLD" in um for each of its cuts. Seconds of a machine take
// microseconds.
#include "components/compensation/thermal_displacement/growth_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

struct Event {
    std::string kind;
    double time = 0;
    std::vector<double> values;
    double value(std::size_t i) const { return i < values.size() ? values[i] : 0; }
};

// References of the contacts, in the order in which they come.
struct Gauges {
    std::map<int, int> index;              // by the key of a contact
    std::map<int, std::uint64_t> of_tool;  // bits

    void add(const Event& contact) {
        const int key = static_cast<int>(contact.value(0)), tool = static_cast<int>(contact.value(1));
        const int next = static_cast<int>(index.size());
        if (index.emplace(key, next).second) of_tool[tool] |= std::uint64_t{1} << (next & 63);
    }
};

struct Replay {
    GrowthFilter::Settings settings{};
    GrowthFilter filter{};
    GrowthFilter::Machine machine{};
    double now = 0;

    void run_until(double time) {
        while (now < time - 1e-9) {
            const double dt = std::min(1.0, time - now);
            filter.predict(machine, settings, dt);
            filter.apply(machine, settings, dt);
            now += dt;
        }
    }
    void take(const Event& contact, const Gauges& gauges) {
        GrowthFilter::Reading r;
        const int tool = static_cast<int>(contact.value(1));
        r.gauge = gauges.index.at(static_cast<int>(contact.value(0)));
        r.of_tool = gauges.of_tool.at(tool);
        r.other_tools = gauges.of_tool.size() > 1;
        r.cycle = static_cast<std::int32_t>(contact.value(2));
        r.growth = contact.value(3) * um;
        r.noise = contact.value(4) * um;
        r.feed = contact.value(5) * um;
        r.reference_sigma = contact.value(6) > 0 ? contact.value(6) * um : std::hypot(r.noise, 1 * um);
        machine.accepted = filter.judge(r, settings) == Rejection::none;
        filter.apply(machine, settings, 1e-3);
        machine.accepted = false;
    }
};

int replay() {
    std::vector<Event> events;
    Gauges gauges;
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream in(line);
        Event event;
        if (!(in >> event.kind >> event.time)) continue;
        for (double x = 0; in >> x;) event.values.push_back(x);
        if (event.kind == "contact") gauges.add(event);
        events.push_back(event);
    }
    const auto its = std::make_unique<Replay>();
    its->settings.by_speed = true;
    its->now = events.empty() ? 0 : events.front().time;
    its->filter.predict(its->machine, its->settings, 1e-3);
    its->filter.begin_at(0, 0, its->settings);
    its->filter.renew_gauges();
    for (const Event& event : events) {
        its->run_until(event.time);
        if (event.kind == "speed") its->machine.speed = event.value(0);
        if (event.kind == "part") its->machine.in_cycle = event.value(0) > 0;
        if (event.kind == "contact") its->take(event, gauges);
        if (event.kind != "cut") continue;
        const GrowthFilter& filter = its->filter;
        const double away = filter.offset() - filter.growth();
        const double sigma = std::hypot(std::hypot(filter.sigma(its->settings), filter.apart()), away);
        std::printf("%.3f %.3f %d\n", filter.offset() / um, sigma / um, filter.doubt() != Doubt::none);
    }
    return 0;
}

}  // namespace
}  // namespace plumb

int main() {
    return plumb::replay();
}
