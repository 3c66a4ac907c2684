// SPDX-License-Identifier: GPL-2.0-or-later
// Frames of a CAN bus and the signals in them. The first eight bytes draw the signal, the next four the id.
#include "tests/readers/reader.hpp"

#include "components/io/can_sensor/can_link.hpp"

#include <cmath>
#include <cstring>
#include <vector>

namespace plumb::readers {
namespace {

void read(std::string_view text) {
    if (text.size() < 12) return;
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    CanChannel channel;
    channel.signal.type = static_cast<CanSignal::Type>(bytes[0] & 3);
    channel.signal.motorola = (bytes[0] & 4) != 0;
    channel.signal.start = (bytes[1] | bytes[2] << 8) % CanSignal::most_bits;
    channel.signal.length = 1 + bytes[3] % 64;
    if (channel.signal.type == CanSignal::Type::f32) channel.signal.length = 32;
    if (channel.signal.type == CanSignal::Type::f64) channel.signal.length = 64;
    if (channel.signal.bytes() > 64) return;  // the file is refused
    if ((bytes[0] & 8) != 0) {
        channel.multiplexer.emplace();
        channel.multiplexer->signal = {bytes[4] % 64, 8, (bytes[0] & 16) != 0,
                                       CanSignal::Type::unsigned_number};
        channel.multiplexer->first = channel.multiplexer->last = bytes[5];
    }
    CanFrame frame;
    std::memcpy(&frame.id, bytes.data() + 8, 4);
    frame.extended = (bytes[0] & 32) != 0;
    frame.id &= frame.extended ? CanMatch::extended_bits : CanMatch::standard_bits;
    channel.match.id = frame.id;
    channel.match.extended = frame.extended;
    channel.match.mask = frame.extended ? CanMatch::extended_bits : CanMatch::standard_bits;
    frame.size = std::min<std::size_t>(bytes.size() - 12, 64);
    std::memcpy(frame.bytes, bytes.data() + 12, frame.size);

    const std::vector<CanChannel> channels{channel};
    int used = 0, damaged = 0;
    CanDispatch{channels}(
        frame,
        [&](std::size_t, double value) {
            ++used;
            const double most = std::ldexp(1, channel.signal.length);
            demand(channel.signal.type == CanSignal::Type::f32 ||
                       channel.signal.type == CanSignal::Type::f64 || std::abs(value) <= most,
                   "a number is one of its bits");
            demand(channel.signal.bytes() <= frame.size, "a value lies in its frame");
        },
        [&](std::size_t) { ++damaged; });
    demand(used + damaged <= 1, "a frame has one value of a channel");
    demand(channel.multiplexer || used + damaged == 1, "a matching frame has a value or is damaged");

    const CanObject object{1 + bytes[6] % 127, bytes[1] | bytes[2] << 8, bytes[3]};
    const canopen::Upload upload = canopen::upload_reply(object, frame);
    demand(upload.status != canopen::Upload::Status::good ||
               (upload.size >= 1 && upload.size <= 4 && upload.data == frame.bytes + 4),
           "a reply has up to four bytes");
}

const Reader reader{"can_frame", read};

}  // namespace
}  // namespace plumb::readers
