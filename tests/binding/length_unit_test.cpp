// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/folder.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using testing::HasSubstr;

// In the environment of the programs that start meanwhile, as LinuxCNC has it.
class IniFile {
public:
    explicit IniFile(const std::string& text) : path_(folder_.write("machine.ini", text).string()) {
        setenv("INI_FILE_NAME", path_.c_str(), 1);
    }
    ~IniFile() { unsetenv("INI_FILE_NAME"); }

    const std::string& path() const { return path_; }

private:
    Folder folder_;
    const std::string path_;
};

std::string refusal(Bench& bench, const std::string& unit, const std::string& names = "names=z") {
    std::vector<std::string> words{"loadrt", "axis_offset", names};
    if (!unit.empty()) words.push_back(unit);
    const client::Halcmd answer = bench.client().halcmd(words);
    EXPECT_NE(answer.status, 0) << unit;
    return answer.output;
}

TEST(LengthUnit, HasEverySpellingOfLinuxCncsLinearUnits) {
    for (const auto& [spelling, millimetres] : {std::pair("mm", 1.0),
                                                {"metric", 1.0},
                                                {"MM", 1.0},
                                                {"in", 25.4},
                                                {"inch", 25.4},
                                                {"Imperial", 25.4},
                                                {"1", 1.0},
                                                {"0.1", 10.0},
                                                {"0.03937007874015748", 25.4}}) {
        Bench bench(Bench::Thread::none);
        bench.command(std::string("loadrt axis_offset names=z interlock=no unit=") + spelling);
        EXPECT_NEAR(bench.get("z.max-offset"), 0.15 / millimetres, 1e-12) << spelling;
    }
}

TEST(LengthUnit, AnotherTextIsRefused) {
    Bench bench(Bench::Thread::none);
    for (const char* unit : {"cm", "inches", "0", "-1", "nan", "1e-9", "25.4mm", ""})
        EXPECT_THAT(refusal(bench, std::string("unit=") + unit),
                    HasSubstr("axis_offset: unit=" + std::string(unit) +
                              ": give mm, metric, in, inch, imperial, or the number of machine units"));
}

TEST(LengthUnit, OneValueHoldsForAllInstances) {
    Bench bench(Bench::Thread::none);
    bench.command("loadrt axis_offset names=x,y,z interlock=no unit=inch");
    for (const char* pin : {"x.max-rate", "y.max-rate", "z.max-rate"})
        EXPECT_DOUBLE_EQ(bench.get(pin), 0.1 / 25.4) << pin;
    bench.command("loadrt joint_offset names=a,b interlock=no unit=mm,inch");
    EXPECT_EQ(bench.get("a.max-offset"), 1);
    EXPECT_DOUBLE_EQ(bench.get("b.max-offset"), 1 / 25.4);
    EXPECT_THAT(bench.client().halcmd({"loadrt", "squareness", "names=a,b,c", "unit=mm,inch"}).output,
                HasSubstr("unit=mm,inch gives 2 values for 3 instances"));
}

// Such a machine was 406 um wrong, silently.
TEST(LengthUnit, MillimetresOnAnInchMachineOfLinuxCncAreRefused) {
    const IniFile ini(
        "[EMC]\nLINEAR_UNITS = mm\n[TRAJ]\nCOORDINATES = XYZ\n LINEAR_UNITS =  inch \n[AXIS_Z]\n");
    Bench bench(Bench::Thread::none);
    EXPECT_THAT(refusal(bench, ""),
                HasSubstr("axis_offset: [TRAJ]LINEAR_UNITS is inch in " + ini.path() +
                          ", and the defaults are in mm: add unit=[TRAJ]LINEAR_UNITS to the loadrt line"));
    EXPECT_THAT(refusal(bench, "unit=mm"),
                HasSubstr("axis_offset: unit=mm, but [TRAJ]LINEAR_UNITS is inch in " + ini.path()));
    bench.command("loadrt axis_offset names=z interlock=no unit=0.03937");
    bench.command("loadrt limit1 names=limit");  // without lengths of ours
}

TEST(LengthUnit, InchesOnAMillimetreMachineAreRefused) {
    const IniFile ini("[TRAJ]\nLINEAR_UNITS = metric\n");
    Bench bench(Bench::Thread::none);
    EXPECT_THAT(refusal(bench, "unit=mm,in", "names=x,z"),
                HasSubstr("unit=in, but [TRAJ]LINEAR_UNITS is metric"));
    bench.command("loadrt axis_offset names=z interlock=no");
    bench.command("loadrt joint_offset names=x interlock=no unit=mm");
}

TEST(LengthUnit, WithoutAUnitInTheIniFileNothingIsKnown) {
    for (const char* text :
         {"", "[TRAJ]\n", "[TRAJ]\nLINEAR_UNITS = furlong\n", "[JOINT_0]\nLINEAR_UNITS = inch\n"}) {
        const IniFile ini(text);
        Bench bench(Bench::Thread::none);
        bench.command("loadrt axis_offset names=z interlock=no");
        EXPECT_EQ(bench.get("z.max-offset"), 0.15) << text;
    }
}

}  // namespace
}  // namespace plumb
