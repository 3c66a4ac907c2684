// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of other controls: LinuxCNC's COMP_FILE and Renishaw's .rtl.
#include "components/io/files/comp_file.hpp"
#include "components/io/files/ini_compensation.hpp"
#include "components/io/files/rtl_file.hpp"
#include "components/math/blocks/random.hpp"

#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

std::string refused(const std::string& text, int type = 1) {
    return refusal<std::runtime_error>([&] { comp_file::read("x.comp", text, type, 1); });
}

TEST(CompFile, TrimsOfTypeOneAreMinusTheError) {
    const DirectionRows rows = comp_file::read("x.comp", "0 0 0.01\n100\t-0.002  0.008\r\n", 1, 1);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_DOUBLE_EQ(rows[1].up, 0.002);
    EXPECT_DOUBLE_EQ(rows[1].down, -0.008);
}

TEST(CompFile, PlacesOfTypeZeroAreNominalPlusError) {
    const DirectionRows rows = comp_file::read("x.comp", "0 0.001 0.002\n1 0.9999 1.0002\n", 0, 25.4);
    EXPECT_DOUBLE_EQ(rows[0].up, 0.0254);
    EXPECT_DOUBLE_EQ(rows[1].position, 25.4);
    EXPECT_NEAR(rows[1].up, -0.00254, 1e-12);
    EXPECT_NEAR(rows[1].down, 0.00508, 1e-12);
}

TEST(CompFile, IsRefusedWithTheLineWhereLinuxCNCWouldEndWithoutAWord) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"0 0 0\n1 0\n2 0 0\n", "line 2: 2 values, not nominal, forward and reverse"},
        {"0 0 0\n1,5 0 0\n", "line 2: '1,5' is no number; the decimal mark is a point"},
        {"0 0 0\n# 1 0 0\n", "line 2: '#' is no number"},
        {"0 0 0\n\n1 0 0\n", "line 2: the line is empty, and LinuxCNC reads nothing behind it"},
        {"0 0 0\n1 0 0\n1 0 0\n", "line 3: 1 is not beyond 1"},
        {"0 0 0\n1 nan 0\n", "line 2: 'nan' is no number"},
        {"0 0 0\n", "there are fewer than 2 lines in it"},
        {"", "there are fewer than 2 lines in it"},
        {"0 0 0\n100 100 100\n", "line 2: an error of -100 mm is beyond 10 mm; is it type 0?"},
    };
    for (const auto& [text, reason] : cases) EXPECT_EQ(refused(text), "x.comp: " + reason) << text;
    EXPECT_THAT(refused("0 0 0\n100 0 0\n", 0),
                EndsWith("line 2: an error of -100 mm is beyond 10 mm; is it type 1?"));
    EXPECT_THAT(refused("0 0 0\n1 0 0\n", 2), EndsWith("COMP_FILE_TYPE 2 does not exist: it is 0 or 1"));
    std::string many;
    for (int i = 0; i < 257; ++i) many += std::to_string(i) + " 0 0\n";
    EXPECT_THAT(refused(many), EndsWith("line 257: LinuxCNC takes no more than 256 lines"));
}

DirectionRows drawn(Random& random) {
    DirectionRows rows;
    double position = random.uniform(-500, 0);
    const int count = 2 + random.index(40);
    for (int i = 0; i < count; ++i) {
        const double mean = random.uniform(-0.05, 0.05), half = random.uniform(-0.01, 0.01);
        rows.push_back({position, mean + half, mean - half});
        position += random.uniform(1, 60);
    }
    return rows;
}

TEST(CompFile, WritesWhatItReadsWithinItsResolution) {
    Random random(11);
    for (int n = 0; n < 100; ++n) {
        const DirectionRows rows = drawn(random);
        const int type = n % 2;
        const double unit = n % 3 == 0 ? 25.4 : 1;
        const DirectionRows back = comp_file::read("x", comp_file::text(rows, type, unit), type, unit);
        ASSERT_EQ(back.size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            EXPECT_NEAR(back[i].position, rows[i].position, 1e-7);
            EXPECT_NEAR(back[i].up, rows[i].up, 1e-7);
            EXPECT_NEAR(back[i].down, rows[i].down, 1e-7);
        }
    }
}

const std::string rtl =
    "HEADER::\nMachine: mill\nTARGET DATA::\nTarget-count: 6\nTargets :\n0.0 50.0 100.0 150.0 200.0\n250.0\n"
    "Flags: 1 2 3 4\nUSER-TEXT::\nRUNS::\nRun-count: 2\nDEVIATIONS::\nRun Target Data:\n"
    "1 1 0.0\n1 2 1.5\n1 3 2.5\n1 4 3.0\n1 5 4.0\n1 6 5.0\n2 6 9.0\n2 5 8.0\n2 4 7.0\n2 3 6.5\n2 2 5.5\n2 1 "
    "4.0\n"
    "ENVIRONMENT::\nAir: 20\nEOF::\n";

TEST(RtlFile, OddRunsRiseAndEvenRunsComeBack) {
    const std::vector<BothWays> places = rtl_file::read("a.rtl", rtl);
    ASSERT_EQ(places.size(), 6U);
    EXPECT_EQ(places[5].position, 250);
    EXPECT_THAT(places[5].up, testing::ElementsAre(0.005));
    EXPECT_THAT(places[5].down, testing::ElementsAre(0.009));
    EXPECT_THAT(places[0].down, testing::ElementsAre(0.004));
}

std::string with(const std::string& from, const std::string& to) {
    std::string text = rtl;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return refusal<std::runtime_error>([&] { rtl_file::read("a.rtl", text.replace(at, from.size(), to)); });
}

TEST(RtlFile, IsRefusedWithTheLine) {
    EXPECT_EQ(with("TARGET DATA::", "TARGETS::"), "a.rtl: there is no line 'TARGET DATA::'");
    EXPECT_EQ(with("Machine: mill", "Type: Angular pitch"),
              "a.rtl: line 2: 'Type: Angular pitch' is no linear measurement: its unit is not um. "
              "Give --error and --unit");
    EXPECT_EQ(with("Target-count: 6", "Target-count: 7").substr(0, 14), "a.rtl: line 8:");
    EXPECT_EQ(with("Target-count: 6", "Target-count: 5"),
              "a.rtl: line 19: run 1, target 6, where run 2, target 1 comes next");
    EXPECT_EQ(with("1 2 1.5\n", ""), "a.rtl: line 15: run 1, target 3, where run 1, target 2 comes next");
    EXPECT_EQ(with("1 2 1.5", "1 2 1,5"), "a.rtl: line 15: '1,5' is no number; the decimal mark is a point");
    EXPECT_EQ(with("1 2 1.5", "1 2 15000"), "a.rtl: line 15: 15000 um is beyond 10 mm; is it in um?");
    EXPECT_EQ(with("2 1 4.0\n", ""), "a.rtl: 11 readings, but 2 runs of 6 targets are announced");
    EXPECT_EQ(with("EOF::\n", "").substr(0, 28), "a.rtl: there is no line 'EOF");
    EXPECT_EQ(with("50.0 100.0", "100.0 50.0"), "a.rtl: line 6: 50 is not beyond 100: targets rise or fall");
    EXPECT_EQ(with("Run-count: 2", "Run-count: two"),
              "a.rtl: line 11: 'Run-count: two' states no number from 1 to 1000");
}

TEST(RtlFile, WritesWhatItReadsWithinATenthOfAMicrometre) {
    Random random(12);
    for (int n = 0; n < 100; ++n) {
        const DirectionRows rows = drawn(random);
        std::string text = rtl_file::text(rows);
        if (n % 2 == 0)  // as DOS writes it
            for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
                text.replace(at, 1, "\r\n");
        const std::vector<BothWays> back = rtl_file::read("x", text);
        ASSERT_EQ(back.size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            EXPECT_NEAR(back[i].position, rows[i].position, 1e-6);
            EXPECT_NEAR(back[i].up[0], rows[i].up, 1e-4);
            EXPECT_NEAR(back[i].down[0], rows[i].down, 1e-4);
        }
    }
}

TEST(DirectionRows, AreZeroAtTheReferencePlaceAndMakeASealedTable) {
    const DirectionRows rows = direction_rows::zeroed({{0, 0.002, 0.006}, {100, 0.006, 0.010}}, 50);
    EXPECT_NEAR(rows[0].up, -0.004, 1e-12);
    EXPECT_NEAR(rows[1].down, 0.004, 1e-12);
    EXPECT_THAT(refusal<std::runtime_error>([&] { direction_rows::zeroed(rows, 101); }),
                HasSubstr("the zero at 101 mm is not within the positions of the table, 0 to 100 mm"));
    const std::string text = direction_rows::table_text('X', "EXX", rows, "# u: EXX+ 0.0002\n");
    EXPECT_THAT(text,
                testing::StartsWith("# u: EXX+ 0.0002\nX,EXX+,EXX-\n0,-0.004,0\n100,0,0.004\n# end, seal "));
    EXPECT_THAT(direction_rows::table_text('X', "EXX", {{0, 0, 0}, {9, 0.001, 0.001}}, ""),
                testing::StartsWith("X,EXX\n0,0\n9,0.001\n# end, seal "));
}

TEST(IniCompensation, AnAxisThatLinuxCNCCompensatesIsRefusedWithItsLine) {
    const Folder folder;
    const auto refused = [&](const std::string& text, char axis) {
        const auto file = folder.write("a.ini", text);
        std::string sentence = refusal<std::runtime_error>([&] { IniCompensation(file.string()).refuse(axis); });
        const std::size_t colon = sentence.find(": line");
        return colon == std::string::npos ? sentence : sentence.substr(colon + 2, 7 + 22);
    };
    const std::string kins = "[KINS]\nKINEMATICS = trivkins coordinates=xyyz kinstype=both\n";
    EXPECT_EQ(refused(kins + "[JOINT_2]\nBACKLASH = 0.01\n", 'Y'), "line 4: 'BACKLASH = 0.01': Li");
    EXPECT_EQ(refused(kins + "[JOINT_2]\nBACKLASH = 0.01\n", 'Z'), "accepted");
    EXPECT_EQ(refused(kins + "[JOINT_3]\nBACKLASH = 0.000 # none\n", 'Z'), "accepted");
    EXPECT_EQ(refused("[TRAJ]\nCOORDINATES = X Z\n[JOINT_1]\n COMP_FILE = z.comp\n", 'Z'),
              "line 4: 'COMP_FILE = z.comp':");
    EXPECT_EQ(refused("[TRAJ]\nCOORDINATES = X Z\n[JOINT_1]\n# COMP_FILE = z.comp\n", 'Z'), "accepted");
}

}  // namespace
}  // namespace plumb
