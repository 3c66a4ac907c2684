// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/modbus_sensor/request_plan.hpp"
#include "tests/support/folder.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <stdexcept>
#include <string>

namespace plumb {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

const std::string tcp = "[[link]]\nname = \"a\"\ntcp = \"10.0.0.5\"\n";
const std::string serial = "[[link]]\nname = \"a\"\nrtu = \"/dev/ttyUSB0\"\n";

std::string channel(const std::string& name, const std::string& rest,
                    const std::string& unit = "unit = \"degC\"\n") {
    return "[[link.channel]]\nname = \"" + name + "\"\ntable = \"holding\"\n" + unit + rest + "\n";
}
const std::string one = channel("c", "register = 0");

class ModbusSettingsFile : public testing::Test {
protected:
    ModbusSettings read(const std::string& text) {
        std::ofstream(file) << text;
        return ModbusSettings::read(file);
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
};

TEST_F(ModbusSettingsFile, DefaultsAreThoseOfThePage) {
    const ModbusLinkSettings link = read(serial + one).links.at(0);
    EXPECT_EQ(link.path, "/dev/ttyUSB0");
    EXPECT_EQ(link.serial.baud, 19200);
    EXPECT_EQ(link.serial.parity, 'E');
    EXPECT_EQ(link.timeout, 0.3);
    EXPECT_EQ(link.retry, 0.5);
    EXPECT_EQ(link.retry_max, 10);
    const ModbusChannel& its = link.channels.at(0);
    EXPECT_EQ(its.device, 1);
    EXPECT_EQ(its.every, 0.1);
    EXPECT_EQ(its.limits.max_age, 1);
    EXPECT_EQ(its.encoding.type, ModbusEncoding::Type::u16);
}

TEST_F(ModbusSettingsFile, HostsHaveAPortOrTheUsualOne) {
    const auto link = [&](const std::string& host) {
        return read("[[link]]\nname = \"a\"\ntcp = \"" + host + "\"\n" + one).links.at(0);
    };
    EXPECT_EQ(link("plc.local").port, "502");
    EXPECT_EQ(link("plc.local:1502").port, "1502");
    EXPECT_EQ(link("[fe80::1]").host, "fe80::1");
    EXPECT_EQ(link("[fe80::1]:1502").port, "1502");
    for (const std::string wrong :
         {"plc:", "plc:0", "plc:70000", ":502", "plc:5o2", "[fe80", "[fe80]502", "a b"})
        EXPECT_THAT(refusal("[[link]]\nname = \"a\"\ntcp = \"" + wrong + "\"\n" + one),
                    HasSubstr(":3: tcp is '" + wrong + "'"))
            << wrong;
}

TEST(ModbusNumbering, ANumberOfAManualHasAHint) {
    ModbusChannel channel;
    channel.name = "load";
    channel.table = ModbusTable::holding;
    channel.first = 40001;
    EXPECT_EQ(numbering_hint(channel),
              "load: register 40001 of a manual that counts from 40001 is register = 0 here.");
    channel.first = 40000;
    EXPECT_EQ(numbering_hint(channel), "");
    channel.table = ModbusTable::input;
    channel.first = 30053;
    EXPECT_THAT(numbering_hint(channel), HasSubstr("register = 52 here"));
}

TEST_F(ModbusSettingsFile, ARefusalNamesFileLineKeyAndTheRight) {
    EXPECT_EQ(refusal(tcp + channel("c", "register = 70000")),
              file.string() + ":8: register is no whole number from 0 to 65535");
    EXPECT_THAT(refusal(tcp + channel("c", "")),
                HasSubstr(":4: register is missing: it is a whole number from 0"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0\nregistre = 1")),
                HasSubstr(":9: unknown key 'registre'; did you mean 'register'?"));
    EXPECT_THAT(
        refusal(tcp + channel("c", "register = 0\ntype = \"int16\"")),
        HasSubstr(
            ":9: type is 'int16', not one of bit, u16, s16, u32, s32, u64, s64, bcd16, bcd32, f32, f64"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0", "")), HasSubstr("unit is missing"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0", "Unit = \"%\"\n")),
                HasSubstr("unknown key 'Unit': write unit"));
    EXPECT_THAT(refusal(tcp + channel("C", "register = 0")), HasSubstr("names of pins are of a-z"));
    EXPECT_THAT(refusal(tcp + channel("a", "register = 0")), HasSubstr("name 'a' is there twice"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0\nmin = 5\nmax = 5")),
                HasSubstr(":10: max leaves no value"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0\nevery = 1\nmax-age = 1")),
                HasSubstr(":10: max-age is not longer than every"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 65535\ntype = \"u32\"")), HasSubstr("leaves no room"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0\ntype = \"f32\"\nfirst-bit = 0\nbits = 1")),
                HasSubstr("not of a float"));
    EXPECT_THAT(refusal(tcp + channel("c", "register = 0\nfirst-bit = 12\nbits = 5")),
                HasSubstr("bits is no whole number from 1 to 4"));
    EXPECT_THAT(refusal(tcp), EndsWith(":1: channel is missing: write [[link.channel]]"));
    EXPECT_THAT(refusal(""), HasSubstr("link is missing"));
    EXPECT_THAT(refusal("[[link]]\nname = \"a\"\n" + one), HasSubstr("or rtu: a link has one of the two"));
    EXPECT_THAT(refusal("x = [\n"), HasSubstr(file.string() + ":"));
}

TEST_F(ModbusSettingsFile, OddBaudRatesAreRefused) {
    EXPECT_THAT(refusal(serial + "baud = 12345\n" + one),
                HasSubstr(":4: baud is 12345, not one of 1200 2400"));
    EXPECT_THAT(refusal(serial + one + "[[link]]\nname = \"b\"\nrtu = \"/dev/ttyUSB0\"\n"),
                HasSubstr("rtu is '/dev/ttyUSB0', the line of another link"));
    EXPECT_THAT(refusal(serial + "parity = \"mark\"\n" + one), HasSubstr("not one of even, odd, none"));
}

TEST_F(ModbusSettingsFile, ASerialLinkThatDoesNotWaitOutItsDeviceIsRefused) {
    EXPECT_THAT(refusal(serial + "timeout = 0.6\n" + one), HasSubstr("retry is shorter than timeout"));
    EXPECT_EQ(refusal(tcp + "timeout = 0.6\n" + one), "taken");
}

TEST_F(ModbusSettingsFile, AnOutputNeedsItsBounds) {
    const std::string output = "[[link.output]]\nname = \"o\"\nregister = 1\nunit = \"%\"\n";
    EXPECT_THAT(refusal(tcp + output), HasSubstr("min is missing"));
    EXPECT_EQ(refusal(tcp + output + "min = 0\nmax = 100\n"), "taken");
    EXPECT_THAT(refusal(tcp + output + "min = 0\nmax = 1\ntable = \"input\"\n"),
                HasSubstr("not one of holding, coil"));
    EXPECT_THAT(refusal(tcp + output + "min = 0\nmax = 1\ntype = \"bit\"\nfirst-bit = 1\n"),
                HasSubstr("a coil"));
}

TEST_F(ModbusSettingsFile, AdjacentRegistersAreOneRequest) {
    const auto plan = [&](const std::string& text) {
        std::vector<std::string> result;
        for (const ModbusLinkSettings& link : read(text).links)
            for (const ModbusGroup& group : request_plan(link.channels, link.gap)) {
                std::string words = std::to_string(group.request.device) + ":" +
                                    std::to_string(group.request.first) + "+" +
                                    std::to_string(group.request.count);
                for (const std::size_t i : group.channels) words += " " + link.channels[i].name;
                result.push_back(words);
            }
        return result;
    };
    const std::string all = channel("d", "register = 4") + channel("b", "register = 1\ntype = \"f32\"") +
                            channel("c", "register = 0") + channel("e", "register = 5\ndevice = 2") +
                            channel("f", "register = 5\nevery = 0.2") + channel("g", "register = 2");
    EXPECT_THAT(plan(tcp + all), ElementsAre("1:0+3 c b g", "1:4+1 d", "1:5+1 f", "2:5+1 e"));
    EXPECT_THAT(plan(tcp + "gap = 1\n" + all), ElementsAre("1:0+5 c b g d", "1:5+1 f", "2:5+1 e"));
}

TEST_F(ModbusSettingsFile, ARequestIsNoLongerThanAReplyCanBe) {
    std::string text = tcp;
    for (int i = 0; i < 200; ++i)
        text += channel("c" + std::to_string(i), "register = " + std::to_string(2 * i) + "\ntype = \"u32\"");
    const ModbusLinkSettings link = read(text).links.at(0);
    int next = 0;
    for (const ModbusGroup& group : request_plan(link.channels, link.gap)) {
        EXPECT_EQ(group.request.first, next);
        EXPECT_LE(group.request.count, MODBUS_MAX_READ_REGISTERS);
        EXPECT_EQ(group.request.count % 2, 0) << "a number is torn";
        next += group.request.count;
    }
    EXPECT_EQ(next, 400);
}

}  // namespace
}  // namespace plumb
