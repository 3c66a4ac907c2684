// SPDX-License-Identifier: GPL-2.0-or-later
// `plumb bench` as its users meet it.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <signal.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const std::string plumb_program = build_folder() + "/bin/plumb";

// A first-order lag of 1 s at 1 kHz: gain = 1 - exp(-0.001).
const char* const lag = R"(loadrt threads name1=servo-thread period1=1000000
loadrt lowpass names=lag
setp lag.gain 0.0009995001666250082
addf lag servo-thread
)";

struct PlumbBench : testing::Test {
    const Folder folder;

    PlumbBench() { folder.write("lag.hal", lag); }

    Outcome bench(std::vector<std::string> arguments, const std::function<void(pid_t)>& meanwhile = {}) {
        arguments.insert(arguments.begin(), {plumb_program, "bench"});
        Outcome outcome = run_program(arguments, folder.path(), meanwhile);
        // The message where the system forbids namespaces, as containers do.
        const std::string beginning = "plumb-host: this system gives no namespaces";
        if (outcome.errors.rfind(beginning, 0) == 0) outcome.errors.erase(0, outcome.errors.find('\n') + 1);
        return outcome;
    }

    // A row a second of the lag after a step to 1.
    std::vector<std::string> step(const std::string& file) {
        return {"lag.hal",        "--for",   "5",  "--set",    "lag.in=1", "--record",
                "lag.in,lag.out", "--every", "1s", "--output", file};
    }
};

TEST_F(PlumbBench, RecordsTheStepResponseOfAFilter) {
    const Outcome outcome = bench(step("out.csv"));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.errors, "");
    EXPECT_THAT(outcome.output, HasSubstr("simulated 5 s in "));
    EXPECT_THAT(outcome.output, HasSubstr("recorded lag.in, lag.out every 1 s in out.csv\n"));
    const Table table = read_table(folder / "out.csv");
    EXPECT_THAT(table.names, ElementsAre("time", "lag.in", "lag.out"));
    EXPECT_THAT(table.column("time"), ElementsAre(0, 1, 2, 3, 4, 5));
    EXPECT_THAT(table.column("lag.in"), ElementsAre(1, 1, 1, 1, 1, 1));
    for (const auto& row : table.rows) EXPECT_NEAR(row[2], 1 - std::exp(-row[0]), 1e-9);
}

TEST_F(PlumbBench, TwoRunsGiveTheSameBytes) {
    folder.write("noise.hal",
                 "loadrt threads name1=servo-thread period1=1000000\n"
                 "loadrt siggen names=g\nloadrt pid names=p\nloadrt limit3 names=l\n"
                 "setp g.frequency 0.7310585\nsetp p.Pgain 3\nsetp p.Igain 7\nsetp p.enable 1\n"
                 "setp l.maxv 2\nsetp l.maxa 30\n"
                 "net a g.sine => l.in\nnet b l.out => p.command\nnet c p.output => p.feedback\n"
                 "addf g.update servo-thread\naddf l servo-thread\naddf p.do-pid-calcs servo-thread\n");
    for (const char* file : {"1.csv", "2.csv"})
        EXPECT_EQ(bench({"noise.hal", "--for", "30", "--record", "a,b,c", "--every", "1ms", "--output", file})
                      .status,
                  0);
    const std::string first = contents(folder / "1.csv");
    EXPECT_GT(first.size(), 1'000'000u);
    EXPECT_EQ(first, contents(folder / "2.csv"));
}

TEST_F(PlumbBench, LoadsSeveralFilesWithTheValuesOfAnIniFile) {
    folder.write("machine.ini", "[FILTER]\nGAIN = 1\nINPUT = 42\n");
    folder.write("more.hal", "setp lag.gain [FILTER]GAIN\nsetp lag.in [FILTER](INPUT)\n");
    const Outcome outcome = bench({"lag.hal", "more.hal", "--ini", "machine.ini", "--for", "1ms", "--record",
                                   "lag.out", "--every", "1ms", "--output", "out.csv"});
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_THAT(read_table(folder / "out.csv").column("lag.out"), ElementsAre(0, 42));
}

TEST_F(PlumbBench, ErrorsInAFileAreHalcmdsOwnWithFileAndLine) {
    folder.write("wrong.hal", std::string(lag) + "setp lag.gian 1\n");
    const Outcome outcome = bench({"wrong.hal", "--for", "1"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.errors, AllOf(HasSubstr("wrong.hal:5:"), HasSubstr("lag.gian")));
    EXPECT_EQ(outcome.output, "");
}

TEST_F(PlumbBench, UnknownNamesAreRefusedWithTheNearestOne) {
    const Outcome record =
        bench({"lag.hal", "--for", "1", "--record", "lag.uot", "--every", "1s", "--output", "out.csv"});
    EXPECT_EQ(record.status, 1);
    EXPECT_THAT(record.errors,
                AllOf(HasSubstr("--record"), HasSubstr("'lag.uot'"), HasSubstr("did you mean 'lag.out'?")));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
    const Outcome set = bench({"lag.hal", "--for", "1", "--set", "utterly-different=1"});
    EXPECT_EQ(set.status, 1);
    EXPECT_THAT(set.errors,
                AllOf(HasSubstr("--set"), HasSubstr("'utterly-different'"), Not(HasSubstr("did you mean"))));
}

TEST_F(PlumbBench, SettingWhatIsNettedIsRefused) {
    folder.write("netted.hal", std::string(lag) + "net input lag.in\n");
    const Outcome outcome = bench({"netted.hal", "--for", "1", "--set", "lag.in=1"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.errors, AllOf(HasSubstr("lag.in"), HasSubstr("connected to a signal")));
}

TEST_F(PlumbBench, FilesWithoutAThreadAreRefused) {
    folder.write("still.hal", "loadrt lowpass\n");
    const Outcome outcome = bench({"still.hal", "--for", "1"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.errors, HasSubstr("no file loads a realtime thread"));
}

TEST_F(PlumbBench, ThreadsWithoutAFunctionAreRemarkedOn) {
    folder.write("idle.hal", "loadrt threads name1=servo-thread period1=1000000\nloadrt lowpass names=lag\n");
    const Outcome outcome = bench({"idle.hal", "--for", "1"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.errors, HasSubstr("no function was added to a thread (addf)"));
}

// As halcmd of LinuxCNC 2.10 does, which has another socket.
TEST(PlumbBenchOnAMachine, ARealtimeThatHalcmdStartsItselfIsRefusedByName) {
    MachineOptions options;
    options.as_root = false;  // a stock realtime does not run where root is the only user
    options.programs = {plumb_program};
    on_own_machine(
        [] {
            setenv("RTAPI_UID", "65534", 1);  // which a stock realtime of root's asks for
            std::ofstream("/tmp/lag.hal") << lag;
            std::filesystem::create_directory("/tmp/later");
            std::ofstream("/tmp/later/halcmd")
                << "#!/bin/sh\nunset RTAPI_FIFO_PATH\nexec /usr/bin/halcmd \"$@\"\n";
            std::filesystem::permissions("/tmp/later/halcmd", static_cast<std::filesystem::perms>(0755));
            setenv("PATH", ("/tmp/later:" + std::string(std::getenv("PATH"))).c_str(), 1);
            const auto expect_refusal = [](const Outcome& outcome) {
                EXPECT_EQ(outcome.status, 1);
                EXPECT_THAT(outcome.errors,
                            HasSubstr("halcmd has started a realtime of LinuxCNC's own (rtapi_app)"));
                EXPECT_THAT(outcome.output, Not(HasSubstr("simulated")));
            };
            expect_refusal(run_program({"/tmp/bin/plumb", "bench", "lag.hal", "--for", "1"}, "/tmp"));
            expect_refusal(
                run_program({"/tmp/bin/plumb", "run", "sh", "-c", "halcmd -f lag.hal; sleep 100"}, "/tmp"));
        },
        options);
}

TEST_F(PlumbBench, WrongCommandLinesAreOneSentenceEach) {
    const auto refused = [&](const std::vector<std::string>& arguments, const std::string& word) {
        const Outcome outcome = bench(arguments);
        EXPECT_EQ(outcome.status, 2) << word;
        EXPECT_THAT(outcome.errors, HasSubstr(word));
    };
    refused({}, "FILE.hal is required");
    refused({"lag.hal"}, "--for is required");
    refused({"none.hal", "--for", "1"}, "File does not exist: none.hal");
    refused({"lag.hal", "--replay", "/dev/zero"}, "/dev/zero: is a device, no regular file");
    refused({"lag.hal", "--for", "1", "--ini", "/dev/zero"}, "/dev/zero: is a device, no regular file");
    refused({"lag.hal", "--for", "soon"}, "'soon' is not a time");
    refused({"lag.hal", "--for", "10 min"}, "'10 min' is not a time");
    refused({"lag.hal", "--for", "-1"}, "'-1' is not a time");
    refused({"lag.hal", "--for", "1", "--set", "lag.in"}, "'lag.in' is not PIN=VALUE");
    refused({"lag.hal", "--for", "1", "--set", "lag.in=one"}, "'one' is not a value");
    refused({"lag.hal", "--for", "1", "--record", "lag.out"}, "--record requires --every");
    refused({"lag.hal", "--for", "1", "--output", "x.csv"}, "--output requires --record");
    refused({"lag.hal", "--for", "1", "--columns", "lag.in"}, "--columns requires --replay");
    refused({"lag.hal", "--replay", "lag.hal", "--columns", "lag.in"}, "--columns requires --sample-period");
    refused(
        {"lag.hal", "--for", "1", "--record", "lag.in,lag.out,lag.in", "--every", "1", "--output", "x.csv"},
        "'lag.in' stands there twice");
}

TEST_F(PlumbBench, TheReplayedFileIsNotOverwritten) {
    const char* const ramp = "time,lag.in\n0,0\n2,4\n";
    folder.write("ramp.csv", ramp);
    std::filesystem::create_symlink("ramp.csv", folder / "same.csv");
    for (const char* output : {"ramp.csv", "./ramp.csv", "same.csv"}) {
        const Outcome outcome = bench(
            {"lag.hal", "--replay", "ramp.csv", "--record", "lag.out", "--every", "1", "--output", output});
        EXPECT_EQ(outcome.status, 2) << output;
        EXPECT_THAT(outcome.errors, HasSubstr(std::string("'") + output + "' is the file that is replayed"));
        EXPECT_EQ(contents(folder / "ramp.csv"), ramp);
    }
}

TEST_F(PlumbBench, StatementsThatHoldAreSaidToHold) {
    const Outcome outcome = bench({"lag.hal", "--for", "5", "--set", "lag.in=1", "--expect",
                                   "{lag.out} < {lag.in} && {lag.out}_rate <= 1 && {lag.in}_rate == 0"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.errors, "");
    EXPECT_THAT(outcome.output, HasSubstr("\nthe statement held in every period\n"));
}

TEST_F(PlumbBench, StatementsThatDoNotHoldAreReportedAndFailIt) {
    // 1 - exp(-t) is above a half from ln 2 = 0.6931 s on.
    const Outcome outcome = bench({"lag.hal", "--for", "5", "--set", "lag.in=1", "--expect",
                                   "{lag.out} <= 0.5", "--expect", "{lag.in} == 1"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.output,
                HasSubstr("did not hold: {lag.out} <= 0.5\n"
                          "    in 4307 periods, first at 0.694 s, when lag.out was 0.500426"));
    EXPECT_THAT(outcome.output, Not(HasSubstr("{lag.in}")));

    const Outcome rate =
        bench({"lag.hal", "--for", "5", "--set", "lag.in=1", "--expect", "{lag.out}_rate <= 0.5"});
    EXPECT_THAT(rate.output, HasSubstr("first at 0.001 s, when lag.out was 0.00099950"));
    EXPECT_THAT(rate.output, HasSubstr(" and changed by 0.9995"));
}

TEST_F(PlumbBench, StatementsThatCannotBeReadAreRefusedWithTheReason) {
    const auto expect = [this](const std::string& statement) {
        return bench({"lag.hal", "--for", "5", "--expect", statement});
    };
    EXPECT_THAT(expect("lag.out < 1").errors, HasSubstr("'lag.out < 1' names no pin"));
    EXPECT_THAT(expect("{lag.out < 1").errors, HasSubstr("has a { without a }"));
    EXPECT_THAT(expect("{} < 1").errors, HasSubstr("has no name between { and }"));
    EXPECT_EQ(expect("{} < 1").status, 2);
    EXPECT_THAT(
        expect("{lag.oot} < 1").errors,
        HasSubstr("--expect: there is no pin, parameter or signal 'lag.oot'; did you mean 'lag.out'?"));
    EXPECT_THAT(expect("{lag.out} <").errors, HasSubstr("--expect: '{lag.out} <': it breaks off"));
    EXPECT_EQ(expect("{lag.out} <").status, 2);
    EXPECT_THAT(expect("lowest({lag.out}) < 1").errors,
                HasSubstr("--expect: 'lowest({lag.out}) < 1', read as 'lowest(v0) < 1': Unexpected token"));
}

TEST_F(PlumbBench, AStatementThatCouldNotFailIsRefused) {
    const auto refused = [this](const std::string& statement, const std::string& why, int status = 2) {
        const Outcome outcome = bench({"lag.hal", "--for", "1ms", "--expect", statement});
        EXPECT_EQ(outcome.status, status) << statement;
        EXPECT_THAT(outcome.errors, AllOf(HasSubstr('\'' + statement + '\''), HasSubstr(why)));
    };
    refused("{lag.out} = 5", ": = assigns a value, which always holds; write == to compare, as in x == 5");
    refused("({lag.gain} = 7) || {lag.out} > 1", "= assigns a value");
    refused("abs({lag.out}) <= 0.5, 1", "a comma stands between the arguments of a function only");
    refused("abs({lag.out} <= 0.5), 1", "a comma stands between the arguments of a function only");
    refused("abs({lag.out})", "its value is a number, which would always hold unless it is 0; compare it");
    refused("{lag.out}_rate", "its value is a number");
    refused("min({lag.out} < 1, 1)", "its value is a number");
    refused("{lag.out} > 5 || 1", "'1' beside || is a number; compare it, as in x <= 5");
    refused("1 < {lag.out} < 5", "'1 < {lag.out}' is compared once more; join two comparisons by &&");
    refused("{lag.out} < 1 ? 1 : 2", "its value is a number");
    refused("!{lag.out}", "there is no !; not is == 0");
    refused("{lag.out}1 < 5", "'{lag.out}1' is unknown");
    refused("v0 < {lag.out}", "'v0' is unknown");
    refused(std::string(200, '(') + "{lag.out} < 1" + std::string(200, ')'), "nested more than 100 deep");
    refused("{lag.out}", "its value is a number", 1);  // which only the host knows
    refused("{lag.in} == 0 && {lag.out}", "beside && is a number", 1);
}

TEST_F(PlumbBench, ABitOrAChoiceIsAStatement) {
    folder.write("bits.hal", std::string(lag) + "loadrt comp names=above\naddf above servo-thread\n");
    for (const char* statement :
         {"{above.out} == 0", "{above.out} || {lag.out} >= 0", "({lag.out} < 1) == ({lag.in} < 1)",
          "{lag.in} > 1 ? {above.out} : 1", "min({lag.in}, -{lag.out}^2) <= 1e0", "finite({lag.out}_rate)"}) {
        const Outcome outcome = bench({"bits.hal", "--for", "10ms", "--expect", statement});
        EXPECT_EQ(outcome.status, 0) << statement << outcome.errors;
    }
    EXPECT_THAT(bench({"bits.hal", "--for", "10ms", "--expect", "{above.out}"}).output,
                HasSubstr("did not hold: {above.out}\n    in 10 periods"));
}

TEST_F(PlumbBench, ReplaysARecordingUpToItsEnd) {
    folder.write("ramp.csv", "time,lag.in\n0,0\n2,4\n");
    folder.write("direct.hal", std::string(lag) + "setp lag.gain 1\n");
    const Outcome outcome = bench({"direct.hal", "--replay", "ramp.csv", "--for", "1h", "--record", "lag.out",
                                   "--every", "500ms", "--output", "out.csv"});
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_THAT(outcome.output, HasSubstr("simulated 2 s in"));
    const Table table = read_table(folder / "out.csv");
    EXPECT_THAT(table.column("time"), ElementsAre(0, 0.5, 1, 1.5, 2));
    for (const auto& row : table.rows) EXPECT_NEAR(row[1], 2 * row[0], 0.0021) << "within a period";
}

TEST_F(PlumbBench, ReplaysWhatHalsamplerWrote) {
    folder.write("samples.txt", "0 5.000000 1\n1 6.000000 0\n2 7.000000 1\n");
    folder.write("direct.hal",
                 std::string(lag) + "setp lag.gain 1\nloadrt not names=not\naddf not servo-thread\n");
    const Outcome outcome =
        bench({"direct.hal", "--replay", "samples.txt", "--columns", "lag.in,not.in", "--sample-period",
               "1ms", "--record", "lag.out,not.in", "--every", "1ms", "--output", "out.csv"});
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    const Table table = read_table(folder / "out.csv");
    EXPECT_THAT(table.column("lag.out"), testing::Contains(6));
    EXPECT_THAT(table.column("not.in"), testing::Contains(0));
}

TEST_F(PlumbBench, ReplayIntoANettedPinNamesItsWriterUnlessOverridden) {
    folder.write("ramp.csv", "time,lag.in\n0,0\n2,4\n");
    folder.write("netted.hal", std::string(lag) +
                                   "setp lag.gain 1\nloadrt siggen names=wave\n"
                                   "net input wave.square => lag.in\n");
    const Outcome refused = bench({"netted.hal", "--replay", "ramp.csv"});
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("lag.in"), HasSubstr("wave.square")));
    const Outcome outcome = bench({"netted.hal", "--replay", "ramp.csv", "--override", "--record", "lag.out",
                                   "--every", "1s", "--output", "out.csv"});
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_NEAR(read_table(folder / "out.csv").column("lag.out").at(1), 2, 0.0021);
}

TEST_F(PlumbBench, InterruptKeepsWhatWasRecorded) {
    for (const int signal : {SIGINT, SIGTERM}) {
        const Outcome outcome = bench(
            {"lag.hal", "--for", "1000000h", "--record", "lag.out", "--every", "1s", "--output", "out.csv"},
            [&](pid_t process) {
                const auto file = folder / "out.csv";
                while (!std::filesystem::exists(file)) std::this_thread::sleep_for(5ms);
                std::this_thread::sleep_for(300ms);
                kill(process, signal);
            });
        EXPECT_EQ(outcome.status, 128 + signal);
        EXPECT_THAT(outcome.output, HasSubstr("interrupted"));
        EXPECT_THAT(outcome.output, HasSubstr("recorded lag.out every 1 s in out.csv"));
        EXPECT_GT(read_table(folder / "out.csv").rows.size(), 10u);  // and every row is whole
        std::filesystem::remove(folder / "out.csv");
    }
}

TEST_F(PlumbBench, ControlCOnATerminalEndsItCleanly) {
    const Outcome outcome = run_on_terminal({plumb_program, "bench", "lag.hal", "--for", "1000000h",
                                             "--record", "lag.out", "--every", "1s", "--output", "out.csv"},
                                            folder.path(), "times real time", "\x03");
    EXPECT_EQ(outcome.status, 128 + SIGINT);
    EXPECT_THAT(outcome.output, HasSubstr("interrupted"));
    EXPECT_THAT(outcome.output, Not(HasSubstr("died")));
    EXPECT_GT(read_table(folder / "out.csv").rows.size(), 10u);
}

TEST_F(PlumbBench, UserSpaceProgramsMakeItReportThatItIsNotDeterministic) {
    folder.write("program.hal", std::string(lag) + "loadusr sleep 1000\n");
    const Outcome outcome = bench({"program.hal", "--for", "1"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.errors, AllOf(HasSubstr("user-space programs took part (sleep)"),
                                      HasSubstr("another run need not give the same values")));
    EXPECT_EQ(bench({"lag.hal", "--for", "1"}).errors, "");
}

TEST_F(PlumbBench, LongRunsShowTheirProgressOnATerminalOnly) {
    const std::vector<std::string> arguments{plumb_program, "bench", "lag.hal", "--for", "4h"};
    const Outcome shown = run_on_terminal(arguments, folder.path());
    EXPECT_EQ(shown.status, 0);
    EXPECT_THAT(shown.output,
                ContainsRegex("\r[0-9][^\r\n]* of 4 h, [0-9]+ times real time, [0-9.]+ (s|ms|min) left"));
    EXPECT_THAT(shown.output, HasSubstr("\r\033[Ksimulated 4 h in "));
    const Outcome quiet = bench({"lag.hal", "--for", "4h"});
    EXPECT_EQ(quiet.errors, "");
    EXPECT_THAT(quiet.output, Not(HasSubstr("left")));
}

TEST_F(PlumbBench, SearchesGivenFoldersForModulesFirst) {
    std::filesystem::create_directory(folder / "mine");
    folder.write("mine/lowpass.so", "no module");
    EXPECT_EQ(bench({"lag.hal", "--for", "1"}).status, 0);
    const Outcome mine = bench({"lag.hal", "--for", "1", "--modules", "mine"});
    EXPECT_EQ(mine.status, 1);
    EXPECT_THAT(mine.errors, HasSubstr("mine/lowpass.so"));
}

TEST_F(PlumbBench, LoadsModulesWithGivenOptionsInThePlaceOfThoseOfTheFile) {
    const Outcome other = bench({"lag.hal", "--option", "lowpass.names=other", "--for", "1"});
    EXPECT_EQ(other.status, 1);
    EXPECT_THAT(other.errors, HasSubstr("lag.hal:"));  // whose further lines know the old name
    const Outcome wrong = bench({"lag.hal", "--option", "lowpass.nmaes=other", "--for", "1"});
    EXPECT_THAT(wrong.errors, HasSubstr("Unknown parameter `nmaes=other'"));
    for (const char* text : {"names=other", ".names=other", "lowpass.=other", "lowpass.names"})
        EXPECT_EQ(bench({"lag.hal", "--option", text, "--for", "1"}).status, 2) << text;
}

TEST(PlumbProgram, ManualPagesAreWithoutFault) {
    for (const char* command :
         {"plumb", "plumb bench", "plumb doctor", "plumb run", "plumb squareness", "plumb-host"}) {
        const Folder folder;
        const std::string page = (folder / "page.1").string();
        ASSERT_EQ(std::system((build_folder() + "/bin/" + std::string(command) + " --man > " + page).c_str()),
                  0);
        const Outcome lint = run_program({"/usr/bin/mandoc", "-T", "lint", page}, "/");
        EXPECT_EQ(lint.output, "");
        EXPECT_EQ(lint.status, 0);
        const Outcome man = run_program({"/usr/bin/man", "--warnings", "--no-hyphenation", "-l", page}, "/");
        EXPECT_EQ(man.errors, "");
        EXPECT_THAT(man.output, HasSubstr("halcmd(1)"));
    }
}

TEST(PlumbProgram, HelpAndManualNameEveryOption) {
    const Outcome help = run_program({plumb_program, "bench", "--help"}, "/");
    const Outcome man = run_program({plumb_program, "bench", "--man"}, "/");
    EXPECT_EQ(help.status, 0);
    EXPECT_EQ(man.status, 0);
    for (const char* option : {"ini", "for", "set", "replay", "columns", "sample-period", "override",
                               "expect", "record", "every", "output", "modules", "option", "no-namespaces"}) {
        EXPECT_THAT(help.output, HasSubstr(std::string("--") + option));
        std::string escaped;  // as the page writes it
        for (const char c : "--" + std::string(option))
            escaped += c == '-' ? std::string("\\-") : std::string(1, c);
        EXPECT_THAT(man.output, HasSubstr(escaped));
    }
    EXPECT_EQ(run_program({plumb_program, "--help"}, "/").status, 0);
    EXPECT_THAT(run_program({build_folder() + "/bin/plumb-host", "--help"}, "/").output,
                Not(HasSubstr(build_folder())));
    EXPECT_THAT(run_program({plumb_program, "--version"}, "/").output, ContainsRegex("^plumb [0-9]"));
    EXPECT_THAT(run_program({build_folder() + "/bin/plumb-host", "--version"}, "/").output,
                ContainsRegex("^plumb-host [0-9]"));
    EXPECT_EQ(run_program({plumb_program}, "/").status, 2);
    EXPECT_EQ(run_program({plumb_program, "dance"}, "/").status, 2);
}

}  // namespace
}  // namespace plumb
