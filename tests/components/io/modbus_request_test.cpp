// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers in registers, and requests and replies as the bytes that libmodbus sends and receives; the examples
// are those of the specification of Modbus.
#include "components/io/modbus_sensor/modbus_connection.hpp"
#include "components/io/modbus_sensor/modbus_value.hpp"
#include "tests/support/modbus_bytes.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>

#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

namespace plumb {
namespace {

using modbus_bytes::Bytes;
using modbus_bytes::with_checksum;
using Status = ModbusReply::Status;
using Type = ModbusEncoding::Type;

double value_of(std::vector<std::uint16_t> registers, ModbusEncoding encoding) {
    return decoded(registers.data(), encoding);
}

ModbusEncoding encoding(Type type, bool low_word = false, bool low_byte = false, int first_bit = 0,
                        int bits = 0) {
    return {type, low_word, low_byte, first_bit, bits};
}

TEST(ModbusValue, ReadsEveryTypeInEveryOrder) {
    EXPECT_EQ(value_of({65521}, encoding(Type::u16)), 65521);
    EXPECT_EQ(value_of({65521}, encoding(Type::s16)), -15);
    EXPECT_EQ(value_of({0x1234}, encoding(Type::u16, false, true)), 0x3412);
    EXPECT_EQ(value_of({0x1234, 0x5678}, encoding(Type::u32)), 0x12345678);
    EXPECT_EQ(value_of({0x5678, 0x1234}, encoding(Type::u32, true)), 0x12345678);
    EXPECT_EQ(value_of({0x3412, 0x7856}, encoding(Type::u32, false, true)), 0x12345678);
    EXPECT_EQ(value_of({0x7856, 0x3412}, encoding(Type::u32, true, true)), 0x12345678);
    EXPECT_EQ(value_of({0xFFFF, 0xFFFE}, encoding(Type::s32)), -2);
    EXPECT_EQ(value_of({0xFFFF, 0xFFFF}, encoding(Type::u32)), 4294967295.0);
    EXPECT_EQ(value_of({0x4060, 0x0000}, encoding(Type::f32)), 3.5);
    EXPECT_EQ(value_of({0x0000, 0x4060}, encoding(Type::f32, true)), 3.5);
    EXPECT_EQ(value_of({0x400C, 0, 0, 0}, encoding(Type::f64)), 3.5);
    EXPECT_EQ(value_of({0, 0, 0, 0x400C}, encoding(Type::f64, true)), 3.5);
    EXPECT_TRUE(std::isnan(value_of({0x7FC0, 0}, encoding(Type::f32))));
    EXPECT_EQ(value_of({0, 0x0001, 0, 0x0003}, encoding(Type::u64)), 4294967299.0);
    EXPECT_EQ(value_of({0x0003, 0, 0x0001, 0}, encoding(Type::u64, true)), 4294967299.0);
    EXPECT_EQ(value_of({0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF}, encoding(Type::u64)), 18446744073709551616.0);
    EXPECT_EQ(value_of({0xFFFF, 0xFFFF, 0xFFFF, 0xFFFE}, encoding(Type::s64)), -2);
    EXPECT_EQ(value_of({0x1234}, encoding(Type::bcd16)), 1234);
    EXPECT_EQ(value_of({0x0056, 0x9801}, encoding(Type::bcd32)), 569801);
    EXPECT_EQ(value_of({0x9801, 0x0056}, encoding(Type::bcd32, true)), 569801);
    EXPECT_TRUE(std::isnan(value_of({0x12A4}, encoding(Type::bcd16))));
}

TEST(ModbusValue, ReadsBitsAndBitFields) {
    EXPECT_EQ(value_of({0x0008}, encoding(Type::bit, false, false, 3)), 1);
    EXPECT_EQ(value_of({0xFFF7}, encoding(Type::bit, false, false, 3)), 0);
    EXPECT_EQ(value_of({0x0308}, encoding(Type::u16, false, false, 8, 3)), 3);
    EXPECT_EQ(value_of({0x0E00}, encoding(Type::s16, false, false, 9, 3)), -1);
    EXPECT_EQ(value_of({0x8000, 0x0001}, encoding(Type::u32, false, false, 0, 32)), 2147483649.0);
    EXPECT_EQ(value_of({0x8000, 0x0001}, encoding(Type::s32, false, false, 31, 1)), -1);
}

TEST(ModbusValue, WhatIsWrittenIsReadBack) {
    std::mt19937 random(7);
    for (const Type type :
         {Type::u16, Type::s16, Type::u32, Type::s32, Type::bcd16, Type::bcd32, Type::f32, Type::f64})
        for (const bool low_word : {false, true})
            for (const bool low_byte : {false, true})
                for (int i = 0; i < 200; ++i) {
                    const ModbusEncoding its = encoding(type, low_word, low_byte);
                    std::uint16_t registers[4];
                    for (auto& each : registers) each = static_cast<std::uint16_t>(random());
                    const double value = decoded(registers, its);
                    std::uint16_t written[4] = {};
                    if (!std::isfinite(value)) {
                        EXPECT_FALSE(encode(value, its, written));
                        continue;
                    }
                    ASSERT_TRUE(encode(value, its, written)) << value;
                    for (int k = 0; k < its.registers(); ++k) EXPECT_EQ(written[k], registers[k]) << value;
                }
}

TEST(ModbusValue, ANumberThatTheTypeDoesNotHoldIsNotWritten) {
    std::uint16_t word[4] = {};
    EXPECT_TRUE(encode(65535.4, encoding(Type::u16), word));
    EXPECT_EQ(word[0], 65535);
    EXPECT_FALSE(encode(65535.6, encoding(Type::u16), word));
    EXPECT_FALSE(encode(-1, encoding(Type::u16), word));
    EXPECT_TRUE(encode(-32768, encoding(Type::s16), word));
    EXPECT_EQ(word[0], 0x8000);
    EXPECT_FALSE(encode(32768, encoding(Type::s16), word));
    EXPECT_FALSE(encode(4294967296.0, encoding(Type::u32), word));
    EXPECT_FALSE(encode(10000, encoding(Type::bcd16), word));
    EXPECT_FALSE(encode(-1, encoding(Type::bcd32), word));
    EXPECT_FALSE(encode(18446744073709551616.0, encoding(Type::u64), word));
    EXPECT_FALSE(encode(9223372036854775808.0, encoding(Type::s64), word));
    EXPECT_TRUE(encode(-9223372036854775808.0, encoding(Type::s64), word));
    EXPECT_EQ(word[0], 0x8000);
    EXPECT_TRUE(encode(18446744073709549568.0, encoding(Type::u64), word));
    EXPECT_EQ(value_of({word[0], word[1], word[2], word[3]}, encoding(Type::u64)), 18446744073709549568.0);
    EXPECT_FALSE(encode(1e39, encoding(Type::f32), word));
    EXPECT_FALSE(encode(std::numeric_limits<double>::quiet_NaN(), encoding(Type::s32), word));
    EXPECT_FALSE(encode(2, encoding(Type::bit), word));
}

ModbusRequest reading(int device, ModbusTable table, int first, int count) {
    ModbusRequest request;
    request.device = device;
    request.table = table;
    request.first = first;
    request.count = count;
    return request;
}

// A connection, and the device at its other end.
struct Peer {
    explicit Peer(bool its_serial) : serial(its_serial) {
        int ends[2];
        if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) std::abort();
        end = Descriptor(ends[1]);
        connection = ModbusConnection(
            Descriptor(ends[0]), serial ? std::optional<SerialSettings>{SerialSettings()} : std::nullopt);
    }

    Bytes sent(const ModbusRequest& request) {
        EXPECT_TRUE(connection.send(request, pauses, seconds_now() + 1));
        Bytes bytes(300);
        bytes.resize(
            static_cast<std::size_t>(std::max<ssize_t>(read(end.number(), bytes.data(), bytes.size()), 0)));
        return bytes;
    }
    void give(const Bytes& bytes) {
        EXPECT_EQ(write(end.number(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    }
    ModbusReply reply(const ModbusRequest& request, double seconds = 0) {
        return connection.reply(request, pauses, seconds_now() + seconds);
    }

    const bool serial;
    Descriptor end;
    Pauses pauses;
    ModbusConnection connection;
};

TEST(ModbusRequests, AreThoseOfTheSpecification) {
    using testing::ElementsAre;
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 3);
    EXPECT_THAT(Peer(true).sent(request), ElementsAre(0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87));
    Peer server(false);
    const int number = ModbusConnection::numbers_requests;
    EXPECT_THAT(server.sent(request), ElementsAre(0, number, 0, 0, 0, 6, 0x11, 0x03, 0x00, 0x6B, 0x00, 0x03));
    EXPECT_THAT(server.sent(request),
                ElementsAre(0, 2 * number, 0, 0, 0, 6, 0x11, 0x03, 0x00, 0x6B, 0x00, 0x03));
    EXPECT_EQ(reading(1, ModbusTable::coil, 0x13, 0x13).bytes(), (Bytes{1, 1, 0, 0x13, 0, 0x13}));
    EXPECT_EQ(reading(1, ModbusTable::discrete, 0xC4, 0x16).bytes(), (Bytes{1, 2, 0, 0xC4, 0, 0x16}));
    EXPECT_EQ(reading(1, ModbusTable::input, 8, 1).bytes(), (Bytes{1, 4, 0, 8, 0, 1}));
    ModbusRequest writing = reading(1, ModbusTable::coil, 0xAC, 1);
    writing.words = {1};
    EXPECT_EQ(writing.bytes(), (Bytes{1, 5, 0, 0xAC, 0xFF, 0}));
    writing.table = ModbusTable::holding;
    writing.first = 1;
    writing.words = {3};
    EXPECT_EQ(writing.bytes(), (Bytes{1, 6, 0, 1, 0, 3}));
    writing.words = {0x000A, 0x0102};
    EXPECT_EQ(writing.bytes(), (Bytes{1, 16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2}));
    writing.words = {3};
    writing.multiple = true;
    EXPECT_EQ(writing.bytes(), (Bytes{1, 16, 0, 1, 0, 1, 2, 0, 3}));
}

// The judgement of a reply over TCP, whose number and stated size differ from the right ones by so much.
ModbusReply over_tcp(const ModbusRequest& request, const Bytes& body, int number = 0, int size = 0) {
    Peer server(false);
    const Bytes sent = server.sent(request);
    Bytes bytes;
    modbus_bytes::add_word(bytes, (sent[0] << 8 | sent[1]) + number);
    modbus_bytes::add_word(bytes, 0);
    modbus_bytes::add_word(bytes, static_cast<int>(body.size()) + size);
    bytes.insert(bytes.end(), body.begin(), body.end());
    server.give(bytes);
    return server.reply(request);
}

ModbusReply over_serial(const ModbusRequest& request, const Bytes& bytes) {
    Peer device(true);
    device.sent(request);
    device.give(bytes);
    return device.reply(request);
}

TEST(ModbusReplies, ARightReplyGivesItsRegistersAndBits) {
    const ModbusRequest registers = reading(17, ModbusTable::holding, 0x6B, 3);
    const Bytes body{17, 3, 6, 0xAE, 0x41, 0x56, 0x52, 0x43, 0x40};
    for (const ModbusReply& reply :
         {over_tcp(registers, body), over_serial(registers, with_checksum(body))}) {
        EXPECT_EQ(reply.status, Status::good);
        EXPECT_EQ(reply.words, (std::vector<std::uint16_t>{0xAE41, 0x5652, 0x4340}));
    }
    const ModbusReply bits = over_tcp(reading(1, ModbusTable::discrete, 0, 10), {1, 2, 2, 0b10000101, 0b10});
    EXPECT_EQ(bits.words, (std::vector<std::uint16_t>{1, 0, 1, 0, 0, 0, 0, 1, 0, 1}));
    for (const ModbusReply& refusal :
         {over_tcp(registers, {17, 0x83, 2}), over_serial(registers, with_checksum({17, 0x83, 2}))}) {
        EXPECT_EQ(refusal.status, Status::exception);
        EXPECT_EQ(refusal.exception, 2);
    }
}

TEST(ModbusReplies, TheLongestRepliesAreRead) {
    const ModbusRequest registers = reading(17, ModbusTable::holding, 0, MODBUS_MAX_READ_REGISTERS);
    const ModbusRequest bits = reading(17, ModbusTable::coil, 0, MODBUS_MAX_READ_BITS);
    for (const ModbusRequest& request : {registers, bits}) {
        Bytes body{17, static_cast<std::uint8_t>(request.function()), 250};
        body.resize(253, 0xFF);
        for (const ModbusReply& reply :
             {over_tcp(request, body), over_serial(request, with_checksum(body))}) {
            EXPECT_EQ(reply.status, Status::good);
            EXPECT_EQ(reply.words.size(), static_cast<std::size_t>(request.count));
        }
    }
}

// At the end of the time, and not before: the rest may still come.
TEST(ModbusReplies, ABeginningIsWrongWhenTheTimeIsOver) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    for (const bool serial : {false, true}) {
        const Bytes first = Peer(serial).sent(request);
        Bytes whole{17, 3, 2, 0xAE, 0x41};
        if (serial)
            whole = with_checksum(whole);
        else
            whole.insert(whole.begin(), {first[0], first[1], 0, 0, 0, 5});
        EXPECT_EQ(Peer(serial).reply(request, 0.005).status, Status::silent);
        for (std::size_t size = 1; size < whole.size(); ++size) {
            const auto middle = whole.begin() + static_cast<long>(size);
            Peer device(serial);
            device.sent(request);
            device.give({whole.begin(), middle});
            EXPECT_EQ(device.reply(request, 0.01).status, Status::wrong) << serial << size;

            Peer slow(serial);
            slow.sent(request);
            slow.give({whole.begin(), middle});
            std::thread rest([&] {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
                slow.give({middle, whole.end()});
            });
            EXPECT_EQ(slow.reply(request, 5).status, Status::good) << serial << size;
            rest.join();
        }
    }
}

TEST(ModbusReplies, AReplyToAnythingElseIsWrong) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    const Bytes right{17, 3, 2, 0xAE, 0x41};
    EXPECT_EQ(over_tcp(request, right).status, Status::good);
    EXPECT_EQ(over_tcp(request, right, 1).status, Status::wrong) << "another number";
    EXPECT_EQ(over_tcp(request, right, 0, 1).status, Status::wrong) << "another length";
    EXPECT_EQ(over_tcp(request, {18, 3, 2, 0xAE, 0x41}).status, Status::wrong) << "another device";
    EXPECT_EQ(over_tcp(request, {17, 4, 2, 0xAE, 0x41}).status, Status::wrong) << "another function";
    EXPECT_EQ(over_tcp(request, {17, 3, 4, 0xAE, 0x41, 0, 0}).status, Status::wrong) << "another size";
    EXPECT_EQ(over_tcp(request, {17, 3, 1, 0xAE, 0x41}).status, Status::wrong) << "two sizes";
    EXPECT_EQ(over_tcp(request, {17, 3, 2, 0xAE, 0x41, 0}).status, Status::wrong) << "a byte too many";
    EXPECT_EQ(over_tcp(request, {17, 0x84, 2}).status, Status::wrong) << "exception of another function";
    EXPECT_EQ(over_serial(request, with_checksum(right)).status, Status::good);
    EXPECT_EQ(over_serial(request, {17, 3, 2, 0xAE, 0x41, 0, 0}).status, Status::wrong) << "the checksum";
    EXPECT_EQ(over_serial(request, with_checksum({18, 3, 2, 0xAE, 0x41})).status, Status::wrong);
    EXPECT_EQ(over_serial(request, with_checksum({0, 3, 2, 0xAE, 0x41})).status, Status::wrong);
    EXPECT_EQ(over_serial(request, with_checksum({17, 3, 4, 0xAE, 0x41, 0, 0})).status, Status::wrong);
    EXPECT_EQ(over_serial(request, {0xFF}).status, Status::wrong) << "noise";
    for (std::size_t before = 0; before < 6; ++before)
        for (std::size_t behind = 0; before + behind < 6; ++behind) {
            Bytes strays(before, 0);
            const Bytes reply = with_checksum(right);
            strays.insert(strays.end(), reply.begin(), reply.end());
            strays.resize(strays.size() + behind, 0xFF);
            EXPECT_EQ(over_serial(request, strays).status, before + behind < 5 ? Status::good : Status::wrong)
                << before << " stray bytes before the reply, " << behind << " behind it";
        }
    Bytes twice = with_checksum(right);
    twice.insert(twice.end(), twice.begin(), twice.end());
    EXPECT_EQ(over_serial(request, twice).status, Status::wrong) << "two replies";
}

TEST(ModbusReplies, AWriteIsAcknowledgedOnlyByItsOwnEcho) {
    ModbusRequest request = reading(1, ModbusTable::holding, 7, 1);
    request.words = {500};
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 7, 1, 0xF4}).status, Status::good);
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 7, 1, 0xF5}).status, Status::wrong);
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 8, 1, 0xF4}).status, Status::wrong);
    EXPECT_EQ(over_serial(request, with_checksum({1, 6, 0, 7, 1, 0xF4})).status, Status::good);
    request.words = {1, 2};
    EXPECT_EQ(over_tcp(request, {1, 16, 0, 7, 0, 2}).status, Status::good);
    EXPECT_EQ(over_tcp(request, {1, 16, 0, 7, 0, 1}).status, Status::wrong);
}

TEST(ModbusReplies, ALostConnectionIsNoReply) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    for (const bool serial : {false, true})
        for (const Bytes& begun : {Bytes(), Bytes{17, 3, 2}}) {
            Peer device(serial);
            device.sent(request);
            device.give(begun);
            device.end.close();
            const double began = seconds_now();
            EXPECT_THROW(device.reply(request, 10), std::system_error);
            EXPECT_LT(seconds_now() - began, 1);
            if (serial) continue;  // a socket in its place ends the program with SIGPIPE
            EXPECT_THROW(device.connection.send(request, device.pauses, 0), std::system_error);
        }
}

TEST(ModbusReplies, AnotherThreadEndsTheWait) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    for (const Bytes& begun : {Bytes(), Bytes{17, 3, 2}}) {
        Peer device(true);
        device.sent(request);
        device.give(begun);
        std::thread stopper([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            device.pauses.stop();
        });
        const double began = seconds_now();
        EXPECT_EQ(device.reply(request, 10).status, Status::silent);
        EXPECT_LT(seconds_now() - began, 1);
        stopper.join();
    }
}

}  // namespace
}  // namespace plumb
