// SPDX-License-Identifier: GPL-2.0-or-later
// The promises of the binding to every component, shown on specimens.
#include "hal/component.hpp"
#include "hal/manual.hpp"
#include "hal/offset.hpp"
#include "hal/page.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"

#include <gmock/gmock.h>

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include <nlohmann/json.hpp>

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <map>
#include <utility>

namespace plumb {
namespace {

using testing::HasSubstr;

std::string output_of(const std::string& command) {
    FILE* const pipe = popen(command.c_str(), "r");
    std::string text;
    char bytes[4096];
    for (std::size_t n; (n = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;) text.append(bytes, n);
    EXPECT_EQ(pclose(pipe), 0) << command;
    return text;
}

struct Binding : testing::Test {
    Module module{build_folder() + "/specimens/specimen.so"};
    Bench bench{Bench::Thread::servo, with_specimens()};

    std::string refusal(const std::string& line) {
        try {
            bench.client().command(line);
        } catch (const std::runtime_error& error) {
            return error.what();
        }
        return "accepted: " + line;
    }

    hal::Declarations declared() const { return hal::Declarations(module.model()); }
};

TEST_F(Binding, InstancesAreNumberedUnlessNamed) {
    bench.command("loadrt specimen count=2");
    EXPECT_EQ(bench.get("specimen.0.in"), 1.5);
    EXPECT_EQ(bench.get("specimen.1.in"), 1.5);
    bench.command("unloadrt specimen");
    bench.command("loadrt specimen");
    EXPECT_EQ(bench.get("specimen.0.in"), 1.5);
    EXPECT_ANY_THROW(bench.get("specimen.1.in"));
}

TEST_F(Binding, RefusesNamesAndCountsThatAreWrongAndNamesThem) {
    const auto expect_refused = [&](const std::string& arguments, const std::string& why) {
        SCOPED_TRACE(arguments);
        EXPECT_THAT(refusal("loadrt specimen " + arguments), HasSubstr(why));
    };
    expect_refused("count=0", "count=0 is below 1");
    expect_refused("count=-1", "count=-1 is below 1");
    expect_refused("count=-99999999999999999999", "is below 1");
    expect_refused("count=65", "count=65: at most 64 instances are possible");
    expect_refused("count=99999999999", "count=99999999999: at most 64 instances are possible");
    expect_refused("count=99999999999999999999", "count=99999999999999999999: at most 64");
    expect_refused("count=4294967297", "count=4294967297: at most 64");
    expect_refused("taps=0", "taps=0: give 1 to 14");
    expect_refused("taps=15", "taps=15: give 1 to 14");
    expect_refused("taps=two", "taps=two: not a number");
    expect_refused("count=two", "count=two: not a whole number");
    expect_refused("count=2.5", "count=2.5: not a whole number");
    expect_refused("count=", "count=: not a whole number");
    expect_refused("count=2 names=a,b", "exclude each other");
    expect_refused("names=a,,b", "name '' is empty");
    expect_refused("names=a,", "name '' is empty");
    expect_refused("names=a,b,a", "name 'a' is given twice");
    std::string many = "names=a0";
    for (int i = 1; i <= 64; ++i) many += ",a" + std::to_string(i);
    expect_refused(many, "names= gives 65 names: at most 64 instances are possible");
    expect_refused("names=A_b", "name 'A_b' has a 'A'");
    expect_refused("names=a_b", "name 'a_b' has a '_'");
    expect_refused("names=a..b", "name 'a..b' has an empty level");
    expect_refused("names=" + std::string(40, 'x'), "is too long");
    expect_refused("length=3", "length");
    bench.command("loadrt specimen names=still-fine");
    EXPECT_EQ(bench.get("still-fine.in"), 1.5);
}

TEST_F(Binding, FunctionsRunInTheOrderOfTheThread) {
    bench.command("loadrt specimen names=it");
    bench.command("addf it.latch servo-thread");
    bench.command("addf it.update servo-thread");
    bench.run(0.003);
    EXPECT_EQ(bench.get("it.sum"), 4.5);
    EXPECT_EQ(bench.get("it.latched"), 3);
}

TEST_F(Binding, ARowHasAsManyPinsAsItsOptionSays) {
    bench.command("loadrt specimen names=it,few taps=12,2");
    bench.command("addf it.update servo-thread");
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.tap-11"), 11);
    EXPECT_EQ(bench.get("it.tap-0"), 0);
    EXPECT_ANY_THROW(bench.get("it.tap-12"));
    EXPECT_EQ(bench.get("few.tap-1"), 0);
    EXPECT_ANY_THROW(bench.get("few.tap-2"));
}

TEST_F(Binding, PinsOfAxesAreNamedByTheirLetters) {
    bench.command("loadrt specimen names=it");
    bench.command("addf it.update servo-thread");
    EXPECT_EQ(bench.get("it.y-offset"), 0.5);
    bench.set("it.x-offset", 1);
    bench.set("it.z-offset", 3);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.twice-x"), 2);
    EXPECT_EQ(bench.get("it.twice-y"), 1);
    EXPECT_EQ(bench.get("it.twice-z"), 6);
    EXPECT_ANY_THROW(bench.get("it.a-offset"));
    EXPECT_ANY_THROW(bench.get("it.%-offset"));
}

TEST_F(Binding, ThreeSixAndNineAxesHaveTheLettersOfLinuxCNC) {
    std::map<std::string, std::string> letters;
    for (const hal::PinInfo& pin : declared().pins)
        for (const std::string stem : {"-offset", "-position", "-moved"})
            if (pin.name.substr(1) == stem) letters[stem] += pin.name[0];
    EXPECT_EQ(letters["-offset"], "xyz");
    EXPECT_EQ(letters["-position"], "xyzuvws");
    EXPECT_EQ(letters["-moved"], "xyzabcuvw");
}

TEST_F(Binding, GroupsInGroupsBelongToTheirAxis) {
    bench.command("loadrt specimen names=it");
    bench.command("addf it.update servo-thread");
    EXPECT_EQ(bench.get("it.w-highest"), 10);
    for (const char* const axis : {"it.x", "it.w", "it.s"}) bench.set(axis + std::string("-wanted"), 50);
    bench.set("it.w-highest", 20);
    bench.set("it.s-highest", 30);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.x-position"), 10);
    EXPECT_EQ(bench.get("it.w-position"), 20);
    EXPECT_EQ(bench.get("it.s-position"), 30);
    EXPECT_EQ(bench.get("it.v-position"), 0);
}

TEST_F(Binding, SentencesNameTheAxisByItsCapital) {
    std::map<std::string, std::string> sentences;
    for (const hal::PinInfo& pin : declared().pins) sentences[pin.name] = pin.doc;
    EXPECT_EQ(sentences["twice-y"], "Twice the offset of Y.");
    EXPECT_EQ(sentences["w-highest"], "Highest position of W.");
    EXPECT_EQ(sentences["w-lowest"], "Lowest w-position of W.") << "the name of a pin";
    EXPECT_EQ(sentences["s-position"], "Position of S, within its limits.");
}

TEST_F(Binding, TheFirstCodeThatAppliesIsShownWithItsBit) {
    bench.command("loadrt specimen names=it");
    bench.command("addf it.update servo-thread");
    for (const auto& [given, code] : {std::pair(1.5, 0), {200.0, 3}, {-200.0, 1}, {-1.5, 0}}) {
        SCOPED_TRACE(given);
        bench.set("it.in", given);
        bench.run(0.001);
        EXPECT_EQ(bench.get("it.fault-code"), code);
        EXPECT_EQ(bench.get("it.fault"), code != 0);
    }
    bench.set("it.order", 60);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.half"), 2);
}

TEST_F(Binding, SentencesOfCodesAreDeclared) {
    std::map<std::string, std::map<std::int32_t, std::string>> sentences;
    for (const hal::CodesInfo& codes : declared().codes) sentences[codes.pin] = codes.sentences;
    const std::map<std::string, std::map<std::int32_t, std::string>> expected{
        {"fault-code", {{1, "The value to add is below -100."}, {3, "The value to add is beyond +-100."}}},
        {"half", {{1, "The order is below 50."}, {2, "The order is 50 or more."}}}};
    EXPECT_EQ(sentences, expected);
}

TEST(Page, HasATextForEachHeading) {
    const hal::Page page(
        "\nOne value.\n\nIT STANDS here.\n\nWIRING\n  net a\n\n  LIMITS\n\nSEE ALSO\nmotion(9)\n");
    EXPECT_EQ(page.section("DESCRIPTION"), "\nOne value.\n\nIT STANDS here.\n\n");
    EXPECT_EQ(page.section("WIRING"), "  net a\n\n  LIMITS\n\n");
    EXPECT_EQ(page.section("SEE ALSO"), "motion(9)\n");
    EXPECT_EQ(page.section("LIMITS"), "");
    EXPECT_EQ(hal::Page("\nDESCRIPTION\nTwo.\n").section("DESCRIPTION"), "\nTwo.\n");
}

TEST(Page, RefusesAHeadingThatIsUnknownOrStandsTwice) {
    const auto message = [](const char* text) -> std::string {
        try {
            hal::Page{text};
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message("One.\n\nLIMTS\nNone.\n"),
              "the heading LIMTS is not one of DESCRIPTION, WIRING, SETTING UP, "
              "BEHAVIOUR, LIMITS, SEE ALSO");
    EXPECT_EQ(message("One.\n\nDESCRIPTION\nTwo.\n"), "the heading DESCRIPTION stands there twice");
    EXPECT_EQ(message("\nLIMITS\nA.\n\nLIMITS\nB.\n"), "the heading LIMITS stands there twice");
}

TEST_F(Binding, CodesAreListedOnTheManualPage) {
    const std::string page = hal::manual(module.model(), 9);
    EXPECT_THAT(page, HasSubstr("\n.SH FAULTS\n.TP 4\n1\nThe value to add is below \\-100.\n.TP 4\n3\n"));
    EXPECT_THAT(page, HasSubstr("\n.SH CODES OF half\n.TP 4\n1\nThe order is below 50.\n"));
    EXPECT_THAT(page, HasSubstr("\\fBfault\\-code\\fR\n"));
}

TEST_F(Binding, RangeOfASettingIsOnThePageAndForPrograms) {
    EXPECT_THAT(hal::manual(module.model(), 9), HasSubstr(R"(.RI ( s32 ", default 0" ", 0 to 1000" ))"));
    const auto pins = nlohmann::json::parse(hal::declarations(module.model())).at("pins");
    EXPECT_EQ(pins.at("order").at("minimum"), 0);
    EXPECT_EQ(pins.at("order").at("maximum"), 1000);
    EXPECT_FALSE(pins.at("in").contains("minimum"));
    const hal::Range all, from_one{1};
    EXPECT_TRUE(all.contains(-1e308));
    EXPECT_TRUE(from_one.contains(1));
    EXPECT_FALSE(from_one.contains(0.999));
    EXPECT_FALSE(all.contains(std::nan("")));
}

TEST(Settings, ThatMustBeSetComeFirstOnThePageAndTheOthersInTables) {
    const Module sloppy(build_folder() + "/specimens/sloppy.so");
    const std::string page = hal::manual(sloppy.model(), 9);
    const std::size_t required = page.find(".SH \"REQUIRED SETTINGS\"\n.TS\n"),
                      pins = page.find(".SH PINS\n"),
                      others = page.find(".SH \"SETTINGS OF THE MACHINE\"\n.TS\n");
    ASSERT_NE(others, std::string::npos);
    EXPECT_LT(required, pins);
    EXPECT_LT(pins, others);
    EXPECT_LT(page.find("required\\-0, required\\-1, "), pins);
    EXPECT_GT(page.find("endless\tmu\t0\t"), others);
    const auto declared = nlohmann::json::parse(hal::declarations(sloppy.model())).at("pins");
    EXPECT_EQ(declared.at("required-8").at("level"), "must");
    EXPECT_EQ(declared.at("endless").at("level"), "machine");
    EXPECT_FALSE(declared.at("in").contains("level"));
}

TEST_F(Binding, DeclarationsArePrintedForPrograms) {
    const auto found = nlohmann::json::parse(
        output_of(build_folder() + "/hal/manual --json " + build_folder() + "/specimens/specimen.so"));
    const nlohmann::json y_offset{{"type", "float"}, {"output", false},      {"unit", "mu"},
                                  {"default", 0.5},  {"default_unit", "mm"}, {"sentence", "Offset of Y."}};
    EXPECT_EQ(found.at("name"), "specimen");
    EXPECT_EQ(found.at("pins").at("y-offset"), y_offset);
    EXPECT_EQ(found.at("pins").at("fault-code").at("type"), "s32");
    EXPECT_EQ(found.at("pins").size(), declared().pins.size() + 2) << "taps 12 and 13 of another load line";
    EXPECT_FALSE(found.at("pins").at("tap-0").contains("only_with"));
    EXPECT_EQ(found.at("pins").at("tap-1").at("only_with"), "taps>=2");
    EXPECT_EQ(found.at("pins").at("tap-13").at("only_with"), "taps>=14");
    EXPECT_EQ(found.at("codes").at("fault-code").at("3"), "The value to add is beyond +-100.");
    EXPECT_EQ(found.at("codes").size(), 2);
    EXPECT_EQ(found.at("options").at("gain").at("sentence"), "Factor.");
    EXPECT_EQ(found.at("functions").at("latch").at("sentence"), "After update.");
}

// Its declaration lacks a part, by its first letter.
template <char missing>
struct Incomplete final : hal::Component {
    static constexpr hal::About about{"incomplete", "moves an axis", "By a declaration that lacks a part."};

    using Component::Component;

    hal::In<double> setting{this, "setting", 1, "mu", "Bound, rate and acceleration."};
    hal::Out<double> out{this, "out", "mu", "The offset."};
    hal::Out<bool> bit{this, "bit", "It is limited."};
    hal::Offset moves{this, declaration()};

    hal::MovingPin declaration() {
        hal::MovingPin pin(out);
        if (missing != 'b') pin.bound(setting);
        if (missing != 'r') pin.rate(setting);
        if (missing != 'l') pin.limited(bit);
        if (missing != 'a') pin.acceleration(setting);
        return pin;
    }
};

template <char missing>
std::string refusal_without() {
    try {
        hal::Declarations{hal::model_of<Incomplete<missing>>()};
    } catch (const std::exception& error) {
        return error.what();
    }
    return "";
}

TEST(MovingPin, LacksNeitherBoundNorRateNorAcceleration) {
    EXPECT_EQ(refusal_without<' '>(), "");
    EXPECT_EQ(refusal_without<'b'>(), "out moves an axis and declares no bound");
    EXPECT_EQ(refusal_without<'r'>(), "out moves an axis and declares no rate");
    EXPECT_EQ(refusal_without<'l'>(), "out moves an axis and declares no bit that it is limited");
    EXPECT_EQ(refusal_without<'a'>(), "out moves an axis and declares no acceleration");
}

TEST_F(Binding, OptionsAreOnePerInstance) {
    bench.command("loadrt specimen names=a,b gain=2,0.5 table=/t/a.csv,/t/b.csv");
    bench.command("addf a.update servo-thread");
    bench.command("addf b.update servo-thread");
    bench.run(0.001);
    EXPECT_EQ(bench.get("a.gain-found"), 2);
    EXPECT_EQ(bench.get("b.gain-found"), 0.5);
}

TEST_F(Binding, OneValueOfAnOptionHoldsForAllInstances) {
    bench.command("loadrt specimen names=a,b gain=2");
    bench.command("addf a.update servo-thread");
    bench.command("addf b.update servo-thread");
    bench.run(0.001);
    EXPECT_EQ(bench.get("a.gain-found"), 2);
    EXPECT_EQ(bench.get("b.gain-found"), 2);
}

TEST_F(Binding, OptionsThatDoNotFitAreRefusedByValue) {
    EXPECT_THAT(refusal("loadrt specimen names=a,b,c gain=2,1"),
                HasSubstr("gain=2,1 gives 2 values for 3 instances"));
    EXPECT_THAT(refusal("loadrt specimen gain=fast"), HasSubstr("gain=fast: not a number"));
    EXPECT_THAT(refusal("loadrt specimen table=a.csv"), HasSubstr("table=a.csv: give an absolute path"));
}

TEST_F(Binding, NoExceptionLeavesAModule) {
    EXPECT_THAT(refusal("loadrt specimen gain=13"), HasSubstr("specimen: gain=13: unlucky"));
    EXPECT_THAT(refusal("loadrt specimen gain=14"), HasSubstr("unknown exception"));
    bench.command("loadrt specimen");
}

TEST_F(Binding, ReloadedModuleStartsAfresh) {
    for (int round = 0; round < 3; ++round) {
        bench.command("loadrt specimen names=it");
        bench.command("addf it.update servo-thread");
        bench.set("it.in", 2);
        bench.run(0.005);
        EXPECT_EQ(bench.get("it.sum"), 10);
        bench.command("unloadrt specimen");
    }
}

TEST_F(Binding, ModulesWithTheSameClassNameKeepTheirOwn) {
    bench.command("loadrt specimen names=first");
    bench.command("loadrt rival names=second");
    bench.command("addf first.update servo-thread");
    bench.command("addf second.update servo-thread");
    bench.set("first.in", 5);
    bench.set("second.in", 5);
    bench.run(0.001);
    EXPECT_EQ(bench.get("first.sum"), 5);
    EXPECT_EQ(bench.get("second.out"), 10);
}

TEST_F(Binding, BackgroundWorkIsDoneBetweenTwoPeriods) {
    bench.command("loadrt specimen names=it");
    bench.command("addf it.update servo-thread");
    bench.set("it.order", 7);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.done"), 0);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.done"), 49);
}

TEST(BackgroundWork, ThatFailsIsReportedOnceAndTriedAgain) {
    client::Start shown = with_specimens();
    shown.show_output = true;
    Bench bench(Bench::Thread::servo, shown);
    bench.command("loadrt specimen names=it");
    bench.command("addf it.update servo-thread");
    for (const auto& [order, words] : {std::pair(13, "bad_alloc"), std::pair(14, "unknown exception")}) {
        SCOPED_TRACE(order);
        testing::internal::CaptureStderr();
        bench.set("it.order", order);
        bench.run(0.01);
        const std::string said = testing::internal::GetCapturedStderr();
        EXPECT_THAT(said, HasSubstr(words));
        EXPECT_EQ(said.find("specimen: "), said.rfind("specimen: ")) << said;
        bench.set("it.order", 7);
        bench.run(0.002);
        EXPECT_EQ(bench.get("it.done"), 49);
        bench.set("it.order", 0);
        bench.run(0.002);
    }
}

TEST_F(Binding, BackgroundWorkEndsWithTheModule) {
    for (int round = 0; round < 3; ++round) {
        bench.command("loadrt specimen names=it");
        bench.run(0.01);
        bench.command("unloadrt specimen");
        bench.run(0.01);
    }
}

struct Walk : Binding {
    Walk() {
        bench.command("loadrt specimen names=it");
        bench.command("addf it.update servo-thread");
    }

    void restore(int tool, double length) {
        bench.set("it.restore-tool", tool);
        bench.set("it.restore-length", length);
        bench.set("it.restore", 1);
        bench.run(0.002);
        bench.set("it.restore", 0);
        bench.run(0.001);
    }

    double shown(int row, const std::string& pin) {
        bench.set("it.row", row);
        bench.run(0.001);
        return bench.get(pin);
    }
};

TEST_F(Walk, RecordsComeBackAsTheyWereGiven) {
    restore(3, 30.5);
    restore(4, 40.5);
    EXPECT_EQ(bench.get("it.rows"), 2);
    EXPECT_EQ(bench.get("it.restores"), 2);
    EXPECT_EQ(shown(0, "it.row-tool"), 3);
    EXPECT_EQ(shown(1, "it.row-length"), 40.5);
    EXPECT_EQ(bench.get("it.row-shown"), 1);
}

TEST_F(Walk, ARowThatIsNotThereIsNotShown) {
    restore(3, 30.5);
    EXPECT_EQ(shown(1, "it.row-shown"), -1);
    EXPECT_EQ(shown(-1, "it.row-shown"), -1);
    EXPECT_EQ(shown(2147483647, "it.row-shown"), -1);
    EXPECT_EQ(shown(0, "it.row-shown"), 0);
}

TEST_F(Walk, ARefusedRecordIsCountedAndLeavesTheOthers) {
    restore(3, 30.5);
    restore(4, -1);
    EXPECT_EQ(bench.get("it.rows"), 1);
    EXPECT_EQ(bench.get("it.restores-refused"), 1);
}

TEST_F(Walk, ForgetEmptiesTheList) {
    restore(3, 30.5);
    bench.set("it.forget", 1);
    bench.run(0.001);
    EXPECT_EQ(bench.get("it.rows"), 0);
    restore(4, 40.5);
    EXPECT_EQ(bench.get("it.rows"), 1) << "forget acts on its edge, not on its level";
}

TEST_F(Binding, ProgramsTakeNamePeriodAndOptions) {
    bench.command("loadusr -W " + build_folder() + "/specimens/specimen_program --start 40");
    EXPECT_GE(bench.get("specimen-program.calls"), 41);
    EXPECT_EQ(bench.get("specimen-program.period"), 0.1);
    bench.command("loadusr -Wn mine " + build_folder() + "/specimens/specimen_program mine --period 0.01");
    EXPECT_EQ(bench.get("mine.period"), 0.01);
    EXPECT_THAT(bench.client().programs(), testing::UnorderedElementsAre("specimen_program", "mine"));
    bench.command("unloadusr mine");
}

TEST_F(Binding, AProgramThatCannotStartGivesTheReason) {
    EXPECT_THAT(refusal("loadusr -W " + build_folder() + "/specimens/specimen_program --start -1"),
                HasSubstr("is below 0"));
    EXPECT_THAT(refusal("loadusr -Wn No " + build_folder() + "/specimens/specimen_program No"),
                HasSubstr("has a 'N'"));
}

#ifndef PLUMB_SANITIZED  // a sanitizer allocates and calls on its own account

struct Guard : testing::Test {
    Bench bench{Bench::Thread::servo, with_specimens(true)};

    Guard() {
        bench.command("loadrt specimen names=it");
        bench.command("addf it.update servo-thread");
    }
};

TEST_F(Guard, IsSilentWhileAFunctionBehaves) {
    bench.run(0.01);
    EXPECT_TRUE(bench.client().guard().empty());
}

TEST_F(Guard, SeesAnAllocation) {
    bench.set("it.allocate", 1);
    bench.run(0.001);
    ASSERT_FALSE(bench.client().guard().empty());
    EXPECT_EQ(bench.client().guard().front().function, "it.update");
    EXPECT_THAT(bench.client().guard().front().what, HasSubstr("16 bytes"));
}

TEST_F(Guard, SeesASystemCall) {
#ifndef __x86_64__
    GTEST_SKIP() << "only the kernel of x86-64 dispatches system calls";
#endif
    bench.set("it.call-system", 1);
    bench.run(0.001);
    ASSERT_FALSE(bench.client().guard().empty());
    EXPECT_EQ(bench.client().guard().front().function, "it.update");
    EXPECT_THAT(bench.client().guard().front().what, HasSubstr("system call"));
}

// From now on the kernel refuses to dispatch system calls, as all but that of x86-64 do.
void forbid_dispatch() {
    sock_filter filter[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                            BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_prctl, 0, 3),
                            BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[0])),
                            BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 59, 0, 1),  // PR_SET_SYSCALL_USER_DISPATCH
                            BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EINVAL),
                            BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
    const sock_fprog program{static_cast<unsigned short>(std::size(filter)), filter};
    ASSERT_EQ(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
    ASSERT_EQ(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program), 0);
}

TEST(GuardWithoutDispatch, SeesAllocationsAndReportsThatItDoesNotSeeSystemCalls) {
    Child child(true, [](Child&) {
        forbid_dispatch();
        client::Start start = with_specimens(true);
        start.show_output = true;
        testing::internal::CaptureStderr();
        Bench bench(Bench::Thread::servo, start);
        bench.command("loadrt specimen names=it");
        bench.command("addf it.update servo-thread");
        bench.set("it.call-system", 1);
        bench.run(0.001);
        EXPECT_TRUE(bench.client().guard().empty());
        bench.set("it.allocate", 1);
        bench.run(0.001);
        EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("but not system calls"));
        ASSERT_FALSE(bench.client().guard().empty());
        EXPECT_THAT(bench.client().guard().front().what, HasSubstr("16 bytes"));
    });
    child.await_success();
}

#endif

}  // namespace
}  // namespace plumb
