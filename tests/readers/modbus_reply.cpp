// SPDX-License-Identifier: GPL-2.0-or-later
// Replies of Modbus devices, over TCP and a serial line. The first four bytes draw the request.
#include "tests/readers/reader.hpp"

#include "components/io/modbus_sensor/modbus_frame.hpp"
#include "components/io/modbus_sensor/modbus_value.hpp"

#include <cmath>
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

void read(std::string_view bytes) {
    if (bytes.size() < 4) return;
    ModbusRequest request;
    request.table = static_cast<ModbusTable>(bytes[0] & 3);
    request.count = 1 + (bytes[1] & 0x7F) % (request.of_bits() ? 128 : ModbusRequest::most_registers);
    request.first = static_cast<unsigned char>(bytes[3]);
    if ((bytes[0] & 4) != 0) {
        request.table = (bytes[0] & 1) != 0 ? ModbusTable::coil : ModbusTable::holding;
        const bool coil = request.table == ModbusTable::coil;
        request.words.assign(coil ? 1 : static_cast<std::size_t>(request.count % 4 + 1), coil ? 1 : 0x1234);
    }
    const auto number = static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[2]));
    // A copy of its own size, beyond which the sanitizer sees every step.
    const std::vector<std::uint8_t> reply(bytes.begin() + 4, bytes.end());
    for (const bool serial : {false, true}) {
        const auto of = [&](std::size_t size) {
            return serial ? rtu_reply(request, reply.data(), size)
                          : tcp_reply(request, number, reply.data(), size);
        };
        const ModbusReply whole = of(reply.size());
        demand_reply(request, whole);
        // What is known to be wrong stays so with more bytes, as the link does not wait for them.
        bool wrong = false;
        for (std::size_t size = 0; size <= std::min<std::size_t>(reply.size(), 300); ++size) {
            const Status status = of(size).status;
            demand(!wrong || status == Status::wrong, "no byte makes a wrong reply right");
            wrong = status == Status::wrong;
        }
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
