// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers in registers, and requests and replies as bytes; the examples are those of the specification of
// Modbus.
#include "components/io/modbus_sensor/modbus_frame.hpp"
#include "components/io/modbus_sensor/modbus_value.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace plumb {
namespace {

using Bytes = std::vector<std::uint8_t>;
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
    for (const Type type : {Type::u16, Type::s16, Type::u32, Type::s32, Type::f32, Type::f64})
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

TEST(ModbusFrame, RequestsAreThoseOfTheSpecification) {
    using testing::ElementsAre;
    EXPECT_THAT(rtu_frame(reading(17, ModbusTable::holding, 0x6B, 3)),
                ElementsAre(0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87));
    EXPECT_THAT(tcp_frame(reading(17, ModbusTable::holding, 0x6B, 3), 0x1234),
                ElementsAre(0x12, 0x34, 0, 0, 0, 6, 0x11, 0x03, 0x00, 0x6B, 0x00, 0x03));
    EXPECT_EQ(modbus_frame::body(reading(1, ModbusTable::coil, 0x13, 0x13)), (Bytes{1, 1, 0, 0x13, 0, 0x13}));
    EXPECT_EQ(modbus_frame::body(reading(1, ModbusTable::discrete, 0xC4, 0x16)),
              (Bytes{1, 2, 0, 0xC4, 0, 0x16}));
    EXPECT_EQ(modbus_frame::body(reading(1, ModbusTable::input, 8, 1)), (Bytes{1, 4, 0, 8, 0, 1}));
    ModbusRequest writing = reading(1, ModbusTable::coil, 0xAC, 1);
    writing.words = {1};
    EXPECT_EQ(modbus_frame::body(writing), (Bytes{1, 5, 0, 0xAC, 0xFF, 0}));
    writing.table = ModbusTable::holding;
    writing.first = 1;
    writing.words = {3};
    EXPECT_EQ(modbus_frame::body(writing), (Bytes{1, 6, 0, 1, 0, 3}));
    writing.words = {0x000A, 0x0102};
    EXPECT_EQ(modbus_frame::body(writing), (Bytes{1, 16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2}));
    writing.words = {3};
    writing.multiple = true;
    EXPECT_EQ(modbus_frame::body(writing), (Bytes{1, 16, 0, 1, 0, 1, 2, 0, 3}));
}

// A reply to a request over TCP with the number 5: the bytes after the length.
ModbusReply over_tcp(const ModbusRequest& request, Bytes body, int number = 5, int length = -1) {
    Bytes bytes;
    modbus_frame::add_word(bytes, number);
    modbus_frame::add_word(bytes, 0);
    modbus_frame::add_word(bytes, length < 0 ? static_cast<int>(body.size()) : length);
    bytes.insert(bytes.end(), body.begin(), body.end());
    return tcp_reply(request, 5, bytes.data(), bytes.size());
}

Bytes with_checksum(Bytes body) {
    const std::uint16_t sum = modbus_frame::crc(body.data(), body.size());
    body.push_back(static_cast<std::uint8_t>(sum & 0xFF));
    body.push_back(static_cast<std::uint8_t>(sum >> 8));
    return body;
}

ModbusReply over_serial(const ModbusRequest& request, Bytes bytes) {
    return rtu_reply(request, bytes.data(), bytes.size());
}

TEST(ModbusFrame, ARightReplyGivesItsRegistersAndBits) {
    const ModbusRequest registers = reading(17, ModbusTable::holding, 0x6B, 3);
    const Bytes body{17, 3, 6, 0xAE, 0x41, 0x56, 0x52, 0x43, 0x40};
    for (const ModbusReply& reply :
         {over_tcp(registers, body), over_serial(registers, with_checksum(body))}) {
        EXPECT_EQ(reply.status, Status::good);
        EXPECT_EQ(reply.words, (std::vector<std::uint16_t>{0xAE41, 0x5652, 0x4340}));
    }
    const ModbusReply bits = over_tcp(reading(1, ModbusTable::discrete, 0, 10), {1, 2, 2, 0b10000101, 0b10});
    EXPECT_EQ(bits.words, (std::vector<std::uint16_t>{1, 0, 1, 0, 0, 0, 0, 1, 0, 1}));
    const ModbusReply refusal = over_serial(registers, with_checksum({17, 0x83, 2}));
    EXPECT_EQ(refusal.status, Status::exception);
    EXPECT_EQ(refusal.exception, 2);
}

TEST(ModbusFrame, EveryBeginningOfAReplyIsIncomplete) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    const Bytes serial = with_checksum({17, 3, 2, 0xAE, 0x41});
    const Bytes tcp{0, 5, 0, 0, 0, 5, 17, 3, 2, 0xAE, 0x41};
    for (std::size_t size = 0; size < serial.size(); ++size)
        EXPECT_EQ(rtu_reply(request, serial.data(), size).status, Status::incomplete) << size;
    for (std::size_t size = 0; size < tcp.size(); ++size)
        EXPECT_EQ(tcp_reply(request, 5, tcp.data(), size).status, Status::incomplete) << size;
    EXPECT_EQ(tcp_reply(request, 5, tcp.data(), tcp.size()).status, Status::good);
}

TEST(ModbusFrame, AReplyToAnythingElseIsWrong) {
    const ModbusRequest request = reading(17, ModbusTable::holding, 0x6B, 1);
    const Bytes right{17, 3, 2, 0xAE, 0x41};
    EXPECT_EQ(over_tcp(request, right, 4).status, Status::wrong) << "the request before";
    EXPECT_EQ(over_tcp(request, right, 5, 6).status, Status::wrong) << "another length";
    EXPECT_EQ(over_tcp(request, {18, 3, 2, 0xAE, 0x41}).status, Status::wrong) << "another device";
    EXPECT_EQ(over_tcp(request, {17, 4, 2, 0xAE, 0x41}).status, Status::wrong) << "another function";
    EXPECT_EQ(over_tcp(request, {17, 3, 4, 0xAE, 0x41, 0, 0}).status, Status::wrong) << "another size";
    EXPECT_EQ(over_tcp(request, {17, 3, 2, 0xAE, 0x41, 0}).status, Status::wrong) << "a byte too many";
    EXPECT_EQ(over_serial(request, {17, 3, 2, 0xAE, 0x41, 0, 0}).status, Status::wrong) << "the checksum";
    EXPECT_EQ(over_serial(request, with_checksum({18, 3, 2, 0xAE, 0x41})).status, Status::wrong);
    EXPECT_EQ(over_serial(request, {0xFF}).status, Status::wrong) << "noise";
}

TEST(ModbusFrame, AWriteIsAcknowledgedOnlyByItsOwnEcho) {
    ModbusRequest request = reading(1, ModbusTable::holding, 7, 1);
    request.words = {500};
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 7, 1, 0xF4}).status, Status::good);
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 7, 1, 0xF5}).status, Status::wrong);
    EXPECT_EQ(over_tcp(request, {1, 6, 0, 8, 1, 0xF4}).status, Status::wrong);
    request.words = {1, 2};
    EXPECT_EQ(over_tcp(request, {1, 16, 0, 7, 0, 2}).status, Status::good);
    EXPECT_EQ(over_tcp(request, {1, 16, 0, 7, 0, 1}).status, Status::wrong);
}

}  // namespace
}  // namespace plumb
