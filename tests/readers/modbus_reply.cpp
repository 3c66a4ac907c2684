// SPDX-License-Identifier: GPL-2.0-or-later
// Replies of Modbus devices, over TCP and a serial line, as libmodbus receives them and we judge them. The
// first four bytes draw the request.
#include "tests/readers/reader.hpp"

#include "components/io/modbus_sensor/modbus_connection.hpp"
#include "components/io/modbus_sensor/modbus_value.hpp"

#include <sys/socket.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

namespace plumb::readers {
namespace {

using Status = ModbusReply::Status;

void demand_reply(const ModbusRequest& request, const ModbusReply& reply) {
    if (reply.status != Status::good) return demand(reply.words.empty(), "only a good reply has values");
    demand(reply.words.size() == (request.writes() ? 0 : static_cast<std::size_t>(request.count)),
           "a good reply has the values that were asked for");
    if (request.of_bits())
        for (const std::uint16_t bit : reply.words) demand(bit <= 1, "a bit is 0 or 1");
}

// Of a device that has sent these bytes when the time is over.
ModbusReply received(const ModbusRequest& request, bool serial, std::uint8_t number,
                     std::vector<std::uint8_t> bytes) {
    static Pauses pauses;
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends) != 0) std::abort();
    const Descriptor device(ends[1]);
    ModbusConnection connection(Descriptor{ends[0]},
                                serial ? std::optional<SerialSettings>{SerialSettings()} : std::nullopt);
    std::uint8_t sent[300];
    demand(connection.send(request, pauses, 0), "a request is sent");
    demand(::read(device.number(), sent, sizeof sent) > 0, "it comes");
    if (!serial && bytes.size() >= 2 && bytes[0] == 0 && bytes[1] == number) bytes[1] = sent[1];
    bytes.resize(std::min<std::size_t>(bytes.size(), 4096));
    if (!bytes.empty())
        demand(write(device.number(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
               "the device sends its bytes");
    return connection.reply(request, pauses, 0);
}

void read(std::string_view bytes) {
    if (bytes.size() < 4) return;
    ModbusRequest request;
    request.table = static_cast<ModbusTable>(bytes[0] & 3);
    request.count = 1 + (bytes[1] & 0x7F) % (request.of_bits() ? 128 : MODBUS_MAX_READ_REGISTERS);
    request.first = static_cast<unsigned char>(bytes[3]);
    if ((bytes[0] & 4) != 0) {
        request.table = (bytes[0] & 1) != 0 ? ModbusTable::coil : ModbusTable::holding;
        const bool coil = request.table == ModbusTable::coil;
        request.words.assign(coil ? 1 : static_cast<std::size_t>(request.count % 4 + 1), coil ? 1 : 0x1234);
    }
    const auto number = static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[2]));
    const std::vector<std::uint8_t> reply(bytes.begin() + 4, bytes.end());
    for (const bool serial : {false, true}) {
        const ModbusReply whole = received(request, serial, static_cast<std::uint8_t>(number), reply);
        demand_reply(request, whole);
        demand(whole.status != Status::good || reply.size() == request.reply_size() + (serial ? 2 : 6),
               "a good reply has neither more nor fewer bytes");
        demand((whole.status == Status::silent) == reply.empty(), "a device that sends bytes is not silent");
    }
    for (std::size_t size = 0; size <= std::min<std::size_t>(reply.size(), 300); ++size) {
        // Of its own size, beyond which the sanitizer sees every step.
        const std::vector<std::uint8_t> begun(reply.begin(), reply.begin() + static_cast<long>(size));
        demand_reply(request, modbus_reply_of(request, begun.data(), size));
        demand_reply(request, modbus_tcp_reply_of(request, number, begun.data(), size));
    }
    if (reply.size() < 8) return;
    std::uint16_t words[4];
    for (std::size_t i = 0; i < 4; ++i)
        words[i] = static_cast<std::uint16_t>(reply[2 * i] << 8 | reply[2 * i + 1]);
    for (int type = 0; type < 7; ++type)
        for (int order = 0; order < 4; ++order) {
            ModbusEncoding encoding{static_cast<ModbusEncoding::Type>(type), (order & 1) != 0,
                                    (order & 2) != 0, 0, 0};
            const double value = decoded(words, encoding);
            std::uint16_t written[4];
            if (encoding.type == ModbusEncoding::Type::bit || !std::isfinite(value)) continue;
            demand(encode(value, encoding, written), "a number that was read can be written");
            demand(decoded(written, encoding) == value, "it is read back");
        }
}

const Reader reader{"modbus_reply", read};

}  // namespace
}  // namespace plumb::readers
