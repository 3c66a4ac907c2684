// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/modbus_sensor/modbus_link.hpp"
#include "components/io/sensor/sensor_program.hpp"
#include "pages/modbus_sensor.page.hpp"

#include <deque>
#include <iostream>
#include <optional>
#include <string>

namespace plumb {

// A link, one channel and one output without a file, for the manual page.
static ModbusSettings example() {
    ModbusSettings settings;
    ModbusLinkSettings link;
    link.name = "LINK";
    ModbusChannel channel;
    channel.name = "CHANNEL";
    channel.scale.unit = "unit of the file";
    ModbusChannel output = channel;
    output.name = "OUTPUT";
    output.output = true;
    link.channels = {channel, output};
    settings.links = {link};
    return settings;
}

namespace {

struct OutputPins : hal::Group {
    OutputPins(hal::Owner owner, const ModbusChannel& channel)
        : Group(owner), enable{this, channel.name + ".enable", false, "The command is written."} {
        const std::string name = channel.name + ".command";
        if (channel.is_bit())
            bit.emplace(this, name, false, "State to write to the coil.");
        else
            number.emplace(this, name, 0, channel.scale.unit, "Value to write.");
    }

    ModbusLinkState::Command command() const noexcept {
        return {enable, number ? static_cast<double>(*number) : static_cast<double>(*bit)};
    }

    hal::In<bool> enable;
    std::optional<hal::In<double>> number;
    std::optional<hal::In<bool>> bit;
};

struct Link : SensorLink<ModbusLink, ModbusLinkFault> {
    Link(hal::Owner owner, const ModbusLinkSettings& settings)
        : SensorLink(owner, settings, "The link is open, and one of its devices answers.",
                     "Time from the last request to its reply.") {
        for (const ModbusChannel& channel : settings.channels) {
            outputs.emplace_back();
            if (channel.output) outputs.back().emplace(this, channel);
        }
    }

    void update(double now, double dt) noexcept {
        ModbusLinkState& state = worker.state();
        const std::lock_guard lock(state.mutex);
        for (std::size_t i = 0; i < channels.size(); ++i) {
            Reading reading = state.judges[i].at(now);
            if (outputs[i]) judge_output(state, i, reading);
            channels[i].show(reading);
        }
        show(state, dt);
    }

    void judge_output(ModbusLinkState& state, std::size_t i, Reading& reading) noexcept {
        const ModbusLinkState::Command command = outputs[i]->command();
        state.commands[i] = command;
        if (!command.enable) reading.fault = SensorFault::disabled;
        reading.valid &= command.enable && state.written[i] == command.value;
    }

    std::deque<std::optional<OutputPins>> outputs;
};

}  // namespace

struct ModbusSensor final : SensorProgram<ModbusSettings, Link> {
    static constexpr hal::About about{
        "modbus_sensor", "reads and writes values of Modbus devices, and judges whether they can be used",
        page};

    explicit ModbusSensor(hal::Registrar& registrar) : SensorProgram(registrar, example()) {}
};

static void print_hints(const ModbusLinkSettings& link) {
    for (const ModbusChannel& channel : link.channels) {
        const std::string hint = numbering_hint(channel);
        if (!hint.empty()) std::cerr << hint << '\n';
    }
}

// Prints the links and their requests.
static int check_file(const std::string& file) {
    for (const ModbusLinkSettings& link : ModbusSettings::read(file).links) {
        print_hints(link);
        std::cout << link.name << ", " << link.place() << ":\n";
        TextTable table({"  device", "function", "first", "count", "every", "channels"});
        const auto row = [&](const ModbusRequest& request, double every, const std::string& names) {
            table.add({"  " + std::to_string(request.device), std::to_string(request.function()),
                       std::to_string(request.first), std::to_string(request.count), shown(every) + " s",
                       names});
        };
        for (const ModbusGroup& group : request_plan(link.channels, link.gap)) {
            std::string names;
            for (const std::size_t i : group.channels)
                names += (names.empty() ? "" : " ") + link.channels[i].name;
            row(group.request, group.every, names);
        }
        for (const ModbusChannel& channel : link.channels) {
            if (!channel.output) continue;
            ModbusRequest request;
            request.device = channel.device;
            request.table = channel.table;
            request.first = channel.first;
            request.count = channel.count();
            request.words.resize(static_cast<std::size_t>(channel.count()));
            request.multiple = channel.multiple;
            row(request, channel.every, channel.name + " (written)");
        }
        table.write(std::cout);
    }
    return 0;
}

static int list_file(const std::string& file) {
    for (const ModbusLinkSettings& link : ModbusSettings::read(file).links) print_hints(link);
    return list_links<ModbusSettings, ModbusLink>(
        file, [](const ModbusLinkSettings& link) { return 2 * link.timeout + 10 * link.retry + 0.5; });
}

static constexpr hal::WithoutHal commands[] = {
    {"check", "Checks a TOML file, and prints its links and requests.", check_file},
    {"list", "Reads the devices of a TOML file, and prints all channels; status 1 if a value is not valid.",
     list_file},
    {}};

hal::Model hal::model() {
    return sensor_model<ModbusSensor>(commands);
}

}  // namespace plumb
