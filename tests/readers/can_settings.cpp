// SPDX-License-Identifier: GPL-2.0-or-later
// The TOML file of `can_sensor`.
#include "tests/readers/reader.hpp"

#include "components/io/can_sensor/can_settings.hpp"

#include <cmath>
#include <set>
#include <stdexcept>

namespace plumb::readers {
namespace {

void demand_place(const CanSignal& signal) {
    demand(signal.length >= 1 && signal.length <= 64 && signal.bytes() <= 64, "a frame holds the signal");
}

void read(std::string_view bytes) {
    const FileOf file(bytes);
    CanSettings settings;
    if (!takes<std::runtime_error>([&] { settings = CanSettings::read(file.path()); })) return;
    std::set<std::string> names;
    demand(!settings.links.empty(), "there is a link");
    for (const CanLinkSettings& link : settings.links) {
        demand(names.insert(link.name).second, "all names differ");
        demand(!link.interface.empty() && link.interface.size() < IFNAMSIZ, "an interface has a name");
        demand(link.transmit || link.nmt_start.empty(), "it only listens");
        for (const CanChannel& channel : link.channels) {
            demand(names.insert(channel.name).second, "all names differ");
            demand(link.transmit || !channel.object, "it only listens");
            demand_place(channel.signal);
            if (channel.multiplexer) demand_place(channel.multiplexer->signal);
            demand(!channel.object || channel.signal.bytes() <= 4, "a reply holds the object");
            demand(channel.match.extended || channel.match.id <= CanMatch::standard_bits, "the id exists");
            demand(channel.scale.scale != 0 && std::isfinite(channel.scale.scale), "its scale is a number");
            demand(channel.limits.min < channel.limits.max, "some value is valid");
        }
    }
}

const Reader reader{"can_settings", read};

}  // namespace
}  // namespace plumb::readers
