// SPDX-License-Identifier: GPL-2.0-or-later
// The TOML file of `modbus_sensor`, and the requests that it leads to.
#include "tests/readers/reader.hpp"

#include "components/io/modbus_sensor/request_plan.hpp"

#include <cmath>
#include <set>
#include <stdexcept>

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    const FileOf file(bytes);
    ModbusSettings settings;
    if (!takes<std::runtime_error>([&] { settings = ModbusSettings::read(file.path()); })) return;
    std::set<std::string> names;
    demand(!settings.links.empty(), "there is a link");
    for (const ModbusLinkSettings& link : settings.links) {
        demand(names.insert(link.name).second, "all names differ");
        demand(link.timeout > 0 && link.retry > 0 && link.retry_max >= link.retry, "times are positive");
        demand(!link.is_serial() || link.retry >= link.timeout, "a late reply is waited out");
        demand(link.is_serial() ? link.path.front() == '/' : !link.host.empty(), "the link has a place");
        demand(!link.channels.empty(), "a link has channels");
        for (const ModbusChannel& channel : link.channels) {
            demand(names.insert(channel.name).second, "all names differ");
            demand(channel.first >= 0 && channel.first + channel.count() <= 65536, "its registers exist");
            demand(channel.limits.max_age > channel.every, "a value is fresh until the next one comes");
            demand(channel.limits.min < channel.limits.max, "some value is valid");
            demand(channel.scale.scale != 0 && std::isfinite(channel.scale.scale),
                   "its scale can be inverted");
            demand(channel.encoding.first_bit + channel.encoding.bits <= 16 * channel.encoding.registers(),
                   "its bits exist");
        }
        std::size_t planned = 0;
        for (const ModbusGroup& group : request_plan(link.channels, link.gap)) {
            const int most = group.request.of_bits() ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS;
            demand(group.request.count >= 1 && group.request.count <= most, "a reply holds the request");
            for (const std::size_t i : group.channels) {
                const ModbusChannel& channel = link.channels[i];
                demand(channel.first >= group.request.first &&
                           channel.first + channel.count() <= group.request.first + group.request.count,
                       "a channel lies in its request");
                ++planned;
            }
        }
        for (const ModbusChannel& channel : link.channels) planned += channel.output;
        demand(planned == link.channels.size(), "each channel is asked for once");
    }
}

const Reader reader{"modbus_settings", read};

}  // namespace
}  // namespace plumb::readers
