// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/can_sensor/can_link.hpp"
#include "components/io/sensor/sensor_program.hpp"
#include "pages/can_sensor.page.hpp"

#include <cstdio>
#include <iostream>
#include <string>

namespace plumb {

// A link and a channel without a file, for the manual page.
static CanSettings example() {
    CanSettings settings;
    CanLinkSettings link;
    link.name = "LINK";
    CanChannel channel;
    channel.name = "CHANNEL";
    channel.scale.unit = "unit of the file";
    link.channels = {channel};
    settings.links = {link};
    return settings;
}

namespace {

struct Link : SensorLink<CanLink, CanLinkFault> {
    Link(hal::Owner owner, const CanLinkSettings& settings)
        : SensorLink(owner, settings, "The interface is up and not bus-off.",
                     "Time from the last SDO request to its reply; 0 without one."),
          frames{this, settings.name + ".frame-count",
                 "Number of frames that were received for the channels."} {}

    void update(double now, double dt) noexcept {
        CanLinkState& state = worker.state();
        const std::lock_guard lock(state.mutex);
        for (std::size_t i = 0; i < channels.size(); ++i) channels[i].show(state.judges[i].at(now));
        frames = state.frames;
        show(state, dt);
    }

    hal::Out<std::int32_t> frames;
};

}  // namespace

struct CanSensor final : SensorProgram<CanSettings, Link> {
    static constexpr hal::About about{
        "can_sensor", "reads values from CAN frames, and judges whether they can be used", page};

    explicit CanSensor(hal::Registrar& registrar) : SensorProgram(registrar, example()) {}
};

static std::string hexadecimal(std::uint32_t number) {
    char text[16];
    std::snprintf(text, sizeof text, "0x%X", number);
    return text;
}

// Prints the links and the place of each value.
static int check_file(const std::string& file) {
    for (const CanLinkSettings& link : CanSettings::read(file).links) {
        std::cout << link.name << ", " << link.interface << (link.transmit ? ", transmits" : ", listens only")
                  << ":\n";
        TextTable table({"  channel", "frame", "bits", "order", "unit"});
        for (const CanChannel& channel : link.channels) {
            const CanSignal& signal = channel.signal;
            const std::string frame =
                channel.object ? "SDO of node " + std::to_string(channel.object->node) + ", " +
                                     hexadecimal(static_cast<std::uint32_t>(channel.object->index)) + ":" +
                                     std::to_string(channel.object->subindex)
                               : hexadecimal(channel.match.id) + (channel.match.extended ? " extended" : "");
            table.add({"  " + channel.name, frame,
                       std::to_string(signal.start) + "+" + std::to_string(signal.length),
                       signal.motorola ? "motorola" : "intel",
                       channel.is_bit() ? "bit" : channel.scale.unit});
        }
        table.write(std::cout);
    }
    return 0;
}

static int list_file(const std::string& file) {
    return list_links<CanSettings, CanLink>(file, [](const CanLinkSettings& link) {
        double longest = 1;
        for (const CanChannel& channel : link.channels)
            longest = std::max(longest, std::min(channel.limits.max_age, 5.0) + 0.5);
        return longest;
    });
}

static constexpr hal::WithoutHal commands[] = {
    {"check", "Checks a TOML file, and prints its links and channels.", check_file},
    {"list",
     "Listens to the buses of a TOML file, and prints all channels; status 1 if a value is not valid.",
     list_file},
    {}};

hal::Model hal::model() {
    return sensor_model<CanSensor>(commands);
}

}  // namespace plumb
