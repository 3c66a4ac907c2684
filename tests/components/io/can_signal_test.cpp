// SPDX-License-Identifier: GPL-2.0-or-later
// Frames without a bus: signals, matches, SDO and the file. can_sensor_test.py has a bus, and compares with
// canmatrix.
#include "components/io/can_sensor/can_link.hpp"
#include "tests/support/folder.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

namespace plumb {
namespace {

using testing::HasSubstr;
using Type = CanSignal::Type;

CanSignal signal(int start, int length, bool motorola, Type type = Type::unsigned_number) {
    return {start, length, motorola, type};
}

double value_of(const CanSignal& its, std::vector<std::uint8_t> bytes) {
    EXPECT_LE(its.bytes(), bytes.size());
    return decoded(its, bytes.data());
}

TEST(CanSignal, IntelNumbersBeginWithTheirLowestBit) {
    EXPECT_EQ(value_of(signal(0, 8, false), {0x12, 0x34}), 0x12);
    EXPECT_EQ(value_of(signal(0, 16, false), {0x12, 0x34}), 0x3412);
    EXPECT_EQ(value_of(signal(4, 8, false), {0x12, 0x34}), 0x41);
    EXPECT_EQ(value_of(signal(3, 1, false), {0x08}), 1);
}

TEST(CanSignal, MotorolaNumbersBeginWithTheirHighestBit) {
    EXPECT_EQ(value_of(signal(7, 8, true), {0x12, 0x34}), 0x12);
    EXPECT_EQ(value_of(signal(7, 16, true), {0x12, 0x34}), 0x1234);
    EXPECT_EQ(value_of(signal(3, 8, true), {0x12, 0x34}), 0x23);
    EXPECT_EQ(value_of(signal(0, 1, true), {0x01}), 1);
}

TEST(CanSignal, SignedNumbersAndFloats) {
    EXPECT_EQ(value_of(signal(0, 16, false, Type::signed_number), {0xF1, 0xFF}), -15);
    EXPECT_EQ(value_of(signal(7, 11, true, Type::signed_number), {0xFF, 0xE0}), -1);
    EXPECT_EQ(value_of(signal(0, 64, false, Type::signed_number), {0xFE, 255, 255, 255, 255, 255, 255, 255}),
              -2);
    EXPECT_EQ(value_of(signal(0, 1, false, Type::signed_number), {1}), -1);
    EXPECT_EQ(value_of(signal(0, 32, false, Type::f32), {0, 0, 0x60, 0x40}), 3.5);
    EXPECT_EQ(value_of(signal(7, 32, true, Type::f32), {0x40, 0x60, 0, 0}), 3.5);
    EXPECT_EQ(value_of(signal(7, 64, true, Type::f64), {0x40, 0x0C, 0, 0, 0, 0, 0, 0}), 3.5);
    EXPECT_TRUE(std::isnan(value_of(signal(7, 32, true, Type::f32), {0x7F, 0xC0, 0, 0})));
}

TEST(CanSignal, NeedsTheBytesUpToItsLastBit) {
    EXPECT_EQ(signal(0, 8, false).bytes(), 1u);
    EXPECT_EQ(signal(7, 2, false).bytes(), 2u);
    EXPECT_EQ(signal(7, 8, true).bytes(), 1u);
    EXPECT_EQ(signal(0, 2, true).bytes(), 2u);
    EXPECT_EQ(signal(511, 1, false).bytes(), 64u);
    EXPECT_EQ(signal(511, 2, false).bytes(), 65u);
}

CanFrame frame(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
    CanFrame result;
    result.id = id;
    result.extended = extended;
    result.size = bytes.size();
    std::copy(bytes.begin(), bytes.end(), result.bytes);
    return result;
}

TEST(CanMatch, AnIdIsThatOfItsLength) {
    CanMatch match;
    match.id = 0x201;
    EXPECT_TRUE(match(frame(0x201, {})));
    EXPECT_FALSE(match(frame(0x202, {})));
    EXPECT_FALSE(match(frame(0x201, {}, true)));
}

TEST(CanMatch, AParameterGroupHasAnyPriorityAndOneSender) {
    const CanMatch any = CanMatch::parameter_group(65262, std::nullopt);  // engine temperature, FEEE
    EXPECT_TRUE(any(frame(0x18FEEE00, {}, true)));
    EXPECT_TRUE(any(frame(0x0CFEEE17, {}, true)));
    EXPECT_FALSE(any(frame(0x18FEEF00, {}, true)));
    EXPECT_FALSE(any(frame(0x19FEEE00, {}, true))) << "another data page";
    const CanMatch one = CanMatch::parameter_group(65262, 0x17);
    EXPECT_TRUE(one(frame(0x18FEEE17, {}, true)));
    EXPECT_FALSE(one(frame(0x18FEEE00, {}, true)));
    const CanMatch to_one =
        CanMatch::parameter_group(0xEF00, std::nullopt);  // the receiver takes the low byte
    EXPECT_TRUE(to_one(frame(0x18EF2117, {}, true)));
    EXPECT_FALSE(to_one(frame(0x18EE2117, {}, true)));
}

TEST(CanopenSdo, AsksAndReadsExpeditedReplies) {
    const CanObject object{5, 0x6077, 2};
    const CanFrame request = canopen::upload_request(object);
    EXPECT_EQ(request.id, 0x605u);
    EXPECT_EQ(std::vector<std::uint8_t>(request.bytes, request.bytes + 8),
              (std::vector<std::uint8_t>{0x40, 0x77, 0x60, 2, 0, 0, 0, 0}));
    using Status = canopen::Upload::Status;
    const auto reply = [&](std::uint8_t command, std::uint32_t id = 0x585, std::uint8_t subindex = 2) {
        return frame(id, {command, 0x77, 0x60, subindex, 0xF1, 0xFF, 0, 0});
    };
    for (const auto& [command, size] :
         std::map<std::uint8_t, int>{{0x4F, 1}, {0x4B, 2}, {0x47, 3}, {0x43, 4}, {0x42, 4}}) {
        const CanFrame its = reply(command);
        const canopen::Upload upload = canopen::upload_reply(object, its);
        EXPECT_EQ(upload.status, Status::good);
        EXPECT_EQ(upload.size, size);
        EXPECT_EQ(upload.data, its.bytes + 4);
    }
    EXPECT_EQ(canopen::upload_reply(object, reply(0x80)).status, Status::abort);
    EXPECT_EQ(canopen::upload_reply(object, reply(0x80)).abort_code, 0xFFF1u);
    EXPECT_EQ(canopen::upload_reply(object, reply(0x41)).status, Status::wrong) << "segmented";
    EXPECT_EQ(canopen::upload_reply(object, reply(0x4B, 0x586)).status, Status::other) << "another node";
    EXPECT_EQ(canopen::upload_reply(object, reply(0x4B, 0x585, 3)).status, Status::other) << "another object";
    EXPECT_EQ(canopen::upload_reply(object, frame(0x585, {0x4B, 0x77})).status, Status::other) << "too short";
}

class CanSettingsFile : public testing::Test {
protected:
    CanSettings read(const std::string& text) {
        std::ofstream(file) << text;
        return CanSettings::read(file);
    }
    std::string refusal(const std::string& text) {
        try {
            read(text);
        } catch (const std::runtime_error& error) {
            return error.what();
        }
        return "taken";
    }

    const Folder folder;
    const std::filesystem::path file = folder / "x.toml";
    const std::string link = "[[link]]\nname = \"a\"\ninterface = \"can0\"\n";
    const std::string channel = "[[link.channel]]\nname = \"c\"\nunit = \"%\"\n";
};

TEST_F(CanSettingsFile, RefusalsNameLineKeyAndTheRight) {
    EXPECT_EQ(refusal(link + channel + "id = 0x181\nstart-bit = 0\n"), "taken");
    EXPECT_THAT(refusal(link + channel + "id = 0x800\nstart-bit = 0\n"), HasSubstr(":7: id is above 0x7FF"));
    EXPECT_EQ(refusal(link + channel + "id = 0x800\nextended = true\nstart-bit = 0\n"), "taken");
    EXPECT_THAT(refusal(link + channel + "start-bit = 0\n"), HasSubstr("id or pgn or sdo"));
    EXPECT_THAT(refusal(link + channel + "id = 1\npgn = 1\nstart-bit = 0\n"), HasSubstr("one of the three"));
    EXPECT_THAT(refusal(link + channel + "id = 1\nstart-bit = 510\nlength = 3\n"),
                HasSubstr("beyond the 64 bytes"));
    EXPECT_THAT(refusal(link + channel + "id = 1\nstart-bit = 0\ntype = \"f32\"\nlength = 16\n"),
                HasSubstr("length differs from the length of the type: 32"));
    EXPECT_THAT(refusal(link + channel + "id = 1\nstart-bit = 0\nstart = 0\n"),
                HasSubstr(":9: unknown key 'start'"));
    EXPECT_THAT(refusal(link + channel + "id = 1\nstart-bit = 0\norder = \"big\"\n"),
                HasSubstr("not one of intel, motorola"));
    EXPECT_THAT(refusal("[[link]]\nname = \"a\"\ninterface = \"can/0\"\n"),
                HasSubstr(":3: interface is 'can/0'"));
}

TEST_F(CanSettingsFile, NothingIsSentUnlessTheFilePermitsIt) {
    const std::string sdo = "sdo = { node = 1, index = 0x6077 }\n";
    EXPECT_THAT(refusal(link + channel + sdo), HasSubstr("set transmit = true"));
    EXPECT_THAT(refusal(link + "nmt-start = [1]\n" + channel + "id = 1\nstart-bit = 0\n"),
                HasSubstr("set transmit = true"));
    EXPECT_EQ(refusal(link + "transmit = true\nnmt-start = [1]\n" + channel + sdo + "max-age = 2.5\n"),
              "taken");
    EXPECT_THAT(refusal(link + "transmit = true\nretry = 0.1\n" + channel + sdo),
                HasSubstr("retry is shorter than timeout"));
    EXPECT_THAT(refusal(link + "transmit = true\n" + channel + sdo + "length = 64\n"),
                HasSubstr("from 1 to 32"));
}

TEST_F(CanSettingsFile, AMultiplexedSignalIsInItsFramesOnly) {
    const CanLinkSettings its = read(link + channel +
                                     "id = 0x200\nmultiplexer = { start-bit = 0, length = 8, value = 2, "
                                     "to = 4 }\nstart-bit = 8\nlength = 8\nscale = 0.5\noffset = 1\n")
                                    .links.at(0);
    const CanDispatch dispatch(its.channels);
    std::vector<double> values;
    int damaged = 0;
    const auto take = [&](const CanFrame& its_frame) {
        dispatch(
            its_frame, [&](std::size_t, double value) { values.push_back(value); },
            [&](std::size_t) { ++damaged; });
    };
    take(frame(0x200, {1, 10}));
    take(frame(0x200, {2, 20}));
    take(frame(0x201, {2, 30}));
    take(frame(0x200, {4, 40}));
    take(frame(0x200, {5, 50}));
    EXPECT_EQ(values, (std::vector<double>{11, 21}));
    EXPECT_EQ(damaged, 0);
    take(frame(0x200, {2}));
    take(frame(0x200, {}));
    EXPECT_EQ(damaged, 2);
}

}  // namespace
}  // namespace plumb
