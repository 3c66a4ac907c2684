// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/sensor_pins.hpp"
#include "components/io/sensor/value_table.hpp"
#include "components/io/sensor/worker.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"

#include <deque>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>

namespace plumb {

// A link in HAL: its pins, and the thread that talks to the devices.
template <class Talker, class Fault>
struct SensorLink : LinkPins<Fault> {
    template <class Settings>
    SensorLink(hal::Owner owner, const Settings& settings, const char* connected_sentence,
               const char* round_trip_sentence)
        : LinkPins<Fault>(owner, settings, connected_sentence, round_trip_sentence),
          worker(settings, [](const std::string& text) { hal::report_error(text.c_str()); }) {}

    Talker worker;
};

// A program whose file names links; Link(owner, settings of a link) is one of them, a SensorLink whose
// update(now, dt) writes its pins.
template <class Settings, class Link>
struct SensorProgram : hal::Component {
    static constexpr hal::Role role = hal::Role::program;

    // The page shows the pins of the example.
    SensorProgram(hal::Registrar& registrar, const Settings& example) : Component(registrar) {
        const Settings settings =
            file.get().empty() ? example : Settings::read(hal::absolute_path("file", file));
        for (const auto& link : settings.links) links_.emplace_back(this, link);
    }

    hal::Option<std::string> file{this, "file", "", "TOML file of the links and channels, absolute path."};
    hal::Function run{this, "update", &SensorProgram::update, "Once per period."};

    void prepare() override {
        if (file.get().empty()) throw std::invalid_argument("give the TOML file of the links by --file");
        for (Link& link : links_) link.worker.start();
    }

    void update(double dt) noexcept {
        const double now = seconds_now();
        for (Link& link : links_) link.update(now, dt);
    }

    void finish() override { stop_all(links_); }

private:
    std::deque<Link> links_;
};

// Prints the values of a file's links, and returns the exit status. longest_of(link): s, after which each of
// its values should have come.
template <class Settings, class Talker, class LongestOf>
int list_links(const std::string& file, const LongestOf& longest_of) {
    std::deque<Talker> links;
    double longest = 1;
    for (auto& link : Settings::read(file).links) {
        longest = std::max(longest, longest_of(link));
        links.emplace_back(std::move(link), [](const std::string& text) { std::cerr << text + '\n'; });
    }
    return list_values(links, longest, std::cout);
}

// The model of a program that also checks and lists its file without HAL.
template <class Program>
hal::Model sensor_model(const hal::WithoutHal* commands) {
    hal::Model model = hal::model_of<Program>();
    model.without_hal = commands;
    model.period = 0.01;
    return model;
}

}  // namespace plumb
