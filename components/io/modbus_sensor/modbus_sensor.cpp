// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/modbus_sensor/modbus_link.hpp"
#include "components/io/sensor/sensor_program.hpp"

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
        : SensorLink(owner, settings, "The link is open and a device of it answers.",
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
        "modbus_sensor",
        "reads and writes values of Modbus devices, and judges whether they can be used",
        R"(
modbus_sensor reads temperatures, powers, spindle loads and states from Modbus devices, over TCP and serial lines (RTU),
and writes outputs, by libmodbus. A TOML file names the links and the channels. Each channel has a pin valid: it is true while the
value is fresh, plausible, and changes no faster than the file permits. A link that fails is connected again by itself.)",
        hal::Wiring{R"(
  loadusr -W modbus_sensor --file $(CONFIG_DIR)/cabinet.toml

  loadrt watchdog num_inputs=1
  loadrt and2     names=load-usable

  setp watchdog.timeout-0 0.5
  setp watchdog.enable-in true

  net sensors-alive modbus-sensor.vfd.heartbeat      => watchdog.input-0
  net sensors-ok    watchdog.ok-out                  => load-usable.in0
  net load-fresh    modbus-sensor.spindle-load.valid => load-usable.in1
  net load-valid    load-usable.out
  net spindle-load  modbus-sensor.spindle-load.value

  addf watchdog.set-timeouts servo-thread
  addf watchdog.process      servo-thread
  addf load-usable           servo-thread

watchdog(9) is for the case that the program itself dies: HAL then keeps the last values, and valid with them.
$(CONFIG_DIR) is the folder of the INI file. configs/sensors has files for devices.)"},
        hal::SettingUp{R"(
1. Write the file, or copy one from configs/sensors. Keys with a default may be left out.

    [[link]]
    name = "vfd"              # a thread and its pins
    rtu = "/dev/serial/by-id/usb-FTDI"  # or tcp = "10.0.0.5:502"
    baud = 19200              # default 19200; parity = "even",
    parity = "none"           #   "odd" or "none"; stop-bits = 1
    device = 1                # default for the channels
    timeout = 0.3             # s, for a whole reply
    retry = 0.5               # s, after a failure, then doubled
    retry-max = 10            # s, up to this
    gap = 0                   # unasked registers within a request

    [[link.channel]]
    name = "spindle-load"
    table = "holding"         # input, coil, discrete
    register = 0x2103         # from 0; coils and inputs: bit = 7
    type = "s16"              # bit, u16, s16, u32, s32, f32, f64
    words = "high-first"      # or low-first
    bytes = "high-first"      # or low-first
    scale = 0.1               # value = number * scale + offset
    offset = 0
    unit = "%"
    every = 0.05              # s between two requests
    max-age = 0.3             # s; default 1, or 2.5 * every
    min = -200                # no value outside is valid
    max = 200
    max-rate = 5000           # unit/s

    [[link.channel]]
    name = "drive-state"
    table = "holding"
    register = 0x2101
    first-bit = 3             # a bit field; type = "bit" has
    bits = 2                  #   first-bit alone
    unit = "1"

    [[link.output]]
    name = "fan-speed"
    table = "holding"         # or coil
    register = 100
    scale = 0.1
    unit = "%"
    every = 0.5               # s between two writes
    min = 0                   # required
    max = 100

2. Check the file: modbus_sensor --check FILE names the line and the key of an error.
3. Read the devices without HAL: modbus_sensor --list FILE prints all channels. Compare them with the display of the
device. Manuals count registers from 0, from 1 or from 40001; the file counts from 0: 40001 is holding register 0.
4. Net value and valid. Never net a value without its valid.)"},
        hal::Behaviour{R"(
- Start: The program is ready before it connects. valid is false until the first value has come.
- Failed request: The last value stays valid until it is older than max-age. fault-code has the cause.
- Value outside min to max, not a number, or faster than max-rate: valid falls at once. The last accepted value stays.
- Step that lasts: It is accepted when max-rate times the time since the last accepted value allows it.
- Device that does not answer: It is asked again after retry, then twice as late each time, up to retry-max. Other
devices of the link are asked as before.
- Late reply: Over TCP the connection is closed. On a serial line the device is left alone for retry, and its bytes are
thrown away. Its next reply is dropped, as it may be the late one. The reply after that is accepted if no other follows
within timeout. Later, a reply that nobody has asked for makes the values before it invalid.
- Connection lost, server restarted, USB adapter unplugged: The link connects again, after retry to retry-max.
- Output: While enable is true, the command is written at the interval every. valid is true while the device has
acknowledged the present command. A command outside min to max is not written. At the end nothing is written: the device
keeps its value.
- Exception of a device: fault 5; standard error has the number and its meaning.
- SIGTERM, unloadusr: The program ends within a second.
- kill -9: HAL keeps the pins. The heartbeat stands still.
- Channels of one device, table and time whose registers are adjacent: One request reads them, and they fail together.

Pins are updated every 10 ms; --period sets that.)"},
        hal::Limits{R"(
Serial adapters that echo what they send are not supported. Modbus ASCII, Modbus over UDP and TLS are not.

Replies on a serial line have no number. A device may answer later than timeout and retry together, and then pause for
longer than timeout between its next two replies. Its value is then accepted once, although it belongs to the request
before; the next reply shows the mistake. Set retry longer than the slowest reply of the device.

Before version 3.1.11, libmodbus sends all requests over TCP with the number 0. Debian 12 has 3.1.6. The reply of a server
that repeats an earlier reply of the same connection is then accepted.

HAL cannot remove the pins of a program that was killed: loadusr refuses to load it again until LinuxCNC is restarted.

A file has at most 256 links and channels.)"},
        hal::SeeAlso{"can_sensor(1), watchdog(9), interlock(9), thermal_displacement(9)"}};

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
        file, [](const ModbusLinkSettings& link) { return 2 * link.timeout + link.retry + 0.5; });
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
