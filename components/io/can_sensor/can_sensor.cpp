// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/can_sensor/can_link.hpp"
#include "components/io/sensor/sensor_program.hpp"

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
        "can_sensor",
        "reads values from CAN frames, and judges whether they can be used",
        R"(
can_sensor reads spindle torques, temperatures and states from frames on a CAN bus, by SocketCAN. A TOML file names the
interfaces and the signals. Each channel has a pin valid: it is true while the value is fresh, plausible, and changes no
faster than the file permits. can_sensor only listens, unless the file permits it to transmit.)",
        hal::Wiring{R"(
  loadusr -W can_sensor --file $(CONFIG_DIR)/drives.toml

  loadrt watchdog num_inputs=1
  loadrt and2     names=load-usable

  setp watchdog.timeout-0 0.5
  setp watchdog.enable-in true

  net sensors-alive can-sensor.drives.heartbeat     => watchdog.input-0
  net sensors-ok    watchdog.ok-out                 => load-usable.in0
  net load-fresh    can-sensor.spindle-torque.valid => load-usable.in1
  net load-valid    load-usable.out
  net spindle-load  can-sensor.spindle-torque.value

  addf watchdog.set-timeouts servo-thread
  addf watchdog.process      servo-thread
  addf load-usable           servo-thread

watchdog(9) is for the case that the program itself dies: HAL then keeps the last values, and valid with them.
$(CONFIG_DIR) is the folder of the INI file. configs/sensors has files for devices.)"},
        hal::SettingUp{R"(
1. Bring the interface up, with the bit rate of the bus:

    ip link set can0 up type can bitrate 500000 restart-ms 100

2. Write the file, copy one from configs/sensors, or take the signals from a DBC file: can_sensor_dbc(1). Keys with a
default may be left out.

    [[link]]
    name = "drives"           # a thread and its pins
    interface = "can0"
    transmit = true           # default false: only listens
    nmt-start = [1]           # CANopen nodes to start; sends
    timeout = 0.3             # s, for the reply to an SDO
    retry = 0.5               # s, after a failure, then doubled
    retry-max = 2             # s, up to this

    [[link.channel]]
    name = "spindle-torque"
    id = 0x181                # extended = true for 29 bits
    start-bit = 16            # as DBC files count bits
    length = 16               # bits
    order = "intel"           # or motorola
    type = "signed"           # unsigned, signed, f32, f64, bit
    scale = 0.1               # value = number * scale + offset
    offset = 0
    unit = "%"
    max-age = 0.1             # s, default 1
    min = -300                # no value outside is valid
    max = 300
    max-rate = 50000          # unit/s

    [[link.channel]]
    name = "zone-two"         # a multiplexed signal
    id = 0x200
    multiplexer = { start-bit = 0, length = 8, value = 2 }
    start-bit = 8
    unit = "degC"

    [[link.channel]]
    name = "coolant"          # a parameter group of J1939
    pgn = 65262
    source = 0                # the sender; default any
    start-bit = 0
    length = 8
    offset = -40
    unit = "degC"

    [[link.channel]]
    name = "motor-temperature"  # asked for by SDO; sends
    sdo = { node = 1, index = 0x2010, subindex = 0 }
    type = "signed"
    length = 16
    every = 1                 # s between two requests
    max-age = 3
    unit = "degC"

3. Check the file: can_sensor --check FILE names the line and the key of an error.
4. Read the bus without HAL: can_sensor --list FILE prints all channels. Compare them with the display of the device.
5. Net value and valid. Never net a value without its valid.)"},
        hal::Behaviour{R"(
- Start: The program is ready before it opens the interface. valid is false until the first frame has come.
- No frame: The last value stays valid until it is older than max-age. Silence is no error of the bus.
- Frame that is too short for a signal: fault 4; the value stays until it is too old.
- Value outside min to max, not a number, or faster than max-rate: valid falls at once. The last accepted value stays.
- Age: It counts from the time at which the kernel received the frame, or from the request of an SDO.
- Interface down, or removed and back: The link goes on by itself, within a second or two.
- Bus-off: connected is false until a frame comes, or the controller reports its restart.
- Other error frames, lost frames: fault of the link for 1 s.
- SDO abort: fault 5; standard error has its code.
- Unknown ids, remote frames and frames of the other id length: The kernel filters them out.
- SIGTERM, unloadusr: The program ends within a second.
- kill -9: HAL keeps the pins. The heartbeat stands still.

Classic and FD frames are read alike. Pins are updated every 10 ms; --period sets that.)"},
        hal::Limits{R"(
SDO replies have at most four bytes; segmented transfers are not supported. An SDO reply that comes later than timeout
and retry together may be taken for the next one.

A CANopen drive sends no PDOs until a master makes it operational. If no PLC does, use nmt-start.

The bit rate and the restart after bus-off are those of the interface: ip-link(8).

HAL cannot remove the pins of a program that was killed: loadusr refuses to load it again until LinuxCNC is restarted.

A file has at most 256 links and channels.)"},
        hal::SeeAlso{
            "can_sensor_dbc(1), modbus_sensor(1), watchdog(9), interlock(9), thermal_displacement(9)"}};

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
