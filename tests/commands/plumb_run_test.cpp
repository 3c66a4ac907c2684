// SPDX-License-Identifier: GPL-2.0-or-later
// `plumb run` as its users meet it: its command line, its clocks, its clients, and its isolation.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>

#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Clock = std::chrono::steady_clock;

template <typename Condition>
void await(const Condition& condition, const std::string& what) {
    for (const auto deadline = Clock::now() + 20s; !condition();) {
        if (Clock::now() > deadline) throw std::runtime_error("no " + what + " within 20 s");
        std::this_thread::sleep_for(5ms);
    }
}

void await_file(const std::filesystem::path& file) {
    await([&] { return std::filesystem::exists(file); }, file.string());
}

struct PlumbRun : testing::Test {
    const Folder folder;

    // Where the system forbids namespaces, as containers do, a run goes without them.
    static bool namespaces() {
        static const bool have =
            run_program({build_folder() + "/bin/plumb", "run", "true"}, "/").errors.find("no namespaces") ==
            std::string::npos;
        return have;
    }

    Outcome run(std::vector<std::string> words, const std::function<void(pid_t)>& meanwhile = {}) {
        if (!namespaces()) words.insert(words.begin(), "--no-namespaces");
        words.insert(words.begin(), {build_folder() + "/bin/plumb", "run"});
        return run_program(words, folder.path(), meanwhile);
    }

    // Options of plumb run, and a script.
    Outcome run_script(std::vector<std::string> words, const std::string& script,
                       const std::function<void(pid_t)>& meanwhile = {}) {
        words.insert(words.end(), {"sh", folder.write("script", script)});
        return run(words, meanwhile);
    }

    // Runs HAL commands, and does something as a client of the host before the run ends.
    Outcome run_with_client(const std::string& options, const std::string& hal,
                            const std::function<void(client::Client&)>& work) {
        folder.write("file.hal", hal);
        std::istringstream words(options);
        const std::vector<std::string> list{std::istream_iterator<std::string>(words), {}};
        const std::string script = R"(
halcmd -f file.hal || exit
echo "$RTAPI_FIFO_PATH" > begun
mv begun socket
while [ ! -e end ]; do sleep 0.2; done
halcmd unload all
)";
        return run_script(list, script, [&](pid_t) {
            await_file(folder / "socket");
            std::string socket = contents(folder / "socket");
            socket.pop_back();
            client::Client client(client::Attach{socket});
            work(client);
            folder.write("end", "");
        });
    }
};

// --- the command line ---

TEST_F(PlumbRun, AnIniFileThatLinuxCncCannotReadIsNamed) {
    std::filesystem::create_directory(folder / "my machine");
    folder.write("my machine/it.ini", "#INCLUDE more.inc\n");
    const Outcome outcome = run({"linuxcnc", folder / "my machine/it.ini"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.errors, "plumb run: the path " + (folder / "my machine/it.ini").string() +
                                  " has a blank, and LinuxCNC reads no #INCLUDE there; rename the folder\n");
    folder.write("my machine/it.ini", "[HAL]\n");  // LinuxCNC reads it, and misses a display
    EXPECT_THAT(run({"linuxcnc", folder / "my machine/it.ini"}).errors, Not(HasSubstr("rename the folder")));
}

TEST_F(PlumbRun, ExitStatusIsThatOfTheProgram) {
    EXPECT_EQ(run({"true"}).status, 0);
    EXPECT_EQ(run_script({}, "exit 7").status, 7);
    EXPECT_EQ(run_script({"--free"}, "kill -9 $$").status, 128 + SIGKILL);
    EXPECT_EQ(run_script({"--speed", "10"}, "kill -15 $$").status, 128 + SIGTERM);
}

TEST_F(PlumbRun, EndsWithItsTerminalUnlessItIsStartedUnderNohup) {
    const auto ends_with_terminal = [this](const std::string& disposition) {
        std::filesystem::remove(folder / "begun");
        std::vector<std::string> words{"/usr/bin/env", disposition, build_folder() + "/bin/plumb", "run"};
        if (!namespaces()) words.push_back("--no-namespaces");
        words.insert(words.end(), {"sh", "-c", "touch begun; sleep 0.5; exit 7"});
        return run_program(words, folder.path(), [this](pid_t keeper) {
            await_file(folder / "begun");
            kill(keeper, SIGHUP);
        });
    };
    EXPECT_EQ(ends_with_terminal("--default-signal=HUP").status, 128 + SIGTERM);
    EXPECT_EQ(ends_with_terminal("--ignore-signal=HUP").status, 7);
}

TEST_F(PlumbRun, ProgramsThatCannotBeStartedAreASentence) {
    const Outcome missing = run({"./no-such-program"});
    EXPECT_EQ(missing.status, 127);
    EXPECT_EQ(missing.errors, "plumb run: cannot start ./no-such-program: No such file or directory\n");
    const std::string plain = folder.write("plain", "no program");
    const Outcome refused = run({plain});
    EXPECT_EQ(refused.status, 126);
    EXPECT_EQ(refused.errors, "plumb run: cannot start " + plain + ": Permission denied\n");
}

TEST_F(PlumbRun, WrongCommandLinesAreOneSentenceEach) {
    const auto refused = [&](const std::vector<std::string>& arguments, const std::string& word) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.status, 2) << word;
        EXPECT_THAT(outcome.errors, HasSubstr(word));
    };
    refused({}, "no program is given");
    refused({"--"}, "no program is given");
    refused({"--speed", "0", "true"}, "0 is not a speed");
    refused({"--speed", "-1", "true"}, "-1 is not a speed");
    refused({"--speed", "nan", "true"}, "nan is not a speed");
    refused({"--speed", "1001", "true"}, "1001 is not a speed");
    refused({"--speed", "fast", "true"}, "fast is not a speed");
    refused({"--speed", "10", "--free", "true"}, "--speed excludes --free");
    refused({"--fast", "true"}, "--fast");
    refused({"--modules", "no-folder", "true"}, "no-folder");
}

TEST_F(PlumbRun, AHalcmdDoesNotWaitForEverForAProgramThatIsStopped) {
    const Outcome outcome = run_script({}, R"(
halcmd loadrt or2 || exit
/usr/bin/python3 )" + source_folder() + R"(/tests/programs/hal_lock_holder.py 48414c32 8 || exit
halcmd -s show pin or2.0.out
)");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.output, HasSubstr("or2.0.out"));
    EXPECT_THAT(outcome.errors,
                testing::ContainsRegex("plumb-host: process [0-9]+, python3, of user [a-z0-9]+ is "
                                       "stopped and held HAL's lock; the lock is open again"));
}

TEST_F(PlumbRun, WordsAfterTheProgramAreItsOwn) {
    EXPECT_EQ(run({"echo", "--speed", "0", "--free", "-h"}).output, "--speed 0 --free -h\n");
    EXPECT_EQ(run({"--", "echo", "--network"}).output, "--network\n");
    EXPECT_EQ(run({"echo", "a", "--", "--speed"}).output, "a -- --speed\n");
    EXPECT_EQ(run({"--speed", "2", "--", "echo", "--", "a b", ""}).output, "-- a b \n");
    EXPECT_EQ(run({"--", "sh", "-c", "echo $#", "name", "--", "bench"}).output, "2\n");
}

TEST_F(PlumbRun, TheProgramHasFolderInputAndEnvironmentOfTheCaller) {
    setenv("OF_THE_CALLER", "seen", 1);
    const Outcome outcome = run_script({}, "echo $OF_THE_CALLER; pwd; cat; echo said >&2");
    unsetenv("OF_THE_CALLER");
    EXPECT_EQ(outcome.output, "seen\n" + folder.path().string() + "\n");
    EXPECT_THAT(outcome.errors, HasSubstr("said\n"));
}

// --- time ---

// Prints how far three clocks have moved while the program slept 5 s: its own, the computer's, the host's.
// Each span lies within the one before.
const char* const three_clocks = R"(
import os, time, plumb
def uptime():
    return float(open("/proc/uptime").read().split()[0])
with plumb.Host(attach=os.environ["RTAPI_FIFO_PATH"]) as host:
    host.command("loadrt threads name1=servo-thread period1=1000000")
    host.command("start")
    begin = time.time(), uptime(), host.time
    time.sleep(5)
    end = host.time, uptime(), time.time()
    print(end[2] - begin[0], end[1] - begin[1], end[0] - begin[2])
)";

TEST_F(PlumbRun, ClocksOfTheProgramAndOfTheHostAgree) {
    const Outcome outcome =
        run({"--speed", "10", "/usr/bin/python3", folder.write("clocks.py", three_clocks)});
    ASSERT_EQ(outcome.status, 0) << outcome.errors;
    double program = 0, computer = 0, host = 0;
    ASSERT_TRUE(std::istringstream(outcome.output) >> program >> computer >> host) << outcome.output;
    EXPECT_GE(program, 5);
    EXPECT_GT(program, 8 * computer);
    EXPECT_LT(host, program + 1.5) << "though it may have made up arrears, of 100 ms times 10";
    EXPECT_GT(host, 0.4 * program) << "though a busy computer may make it give up time";
}

TEST_F(PlumbRun, SubshellsShareTheClockOfThePrograms) {
    const Outcome outcome = run_script({"--speed", "20"}, R"(
for round in 1 2 3; do
    inner=$(bash -c 'exec date +%s')
done
sleep 10
later=$(bash -c 'exec date +%s')
ls /dev/shm | grep -c faketime_shm_
echo $((later - inner)))");
    int memories = 0, seconds = 0;
    ASSERT_TRUE(std::istringstream(outcome.output) >> memories >> seconds)
        << outcome.output << outcome.errors;
    EXPECT_EQ(memories, 1);
    EXPECT_GE(seconds, 9);
}

TEST_F(PlumbRun, AtSpeedOneProgramsKeepTheirClock) {
    const Outcome outcome = run_script({}, "env");
    EXPECT_THAT(outcome.output, AllOf(HasSubstr("RTAPI_FIFO_PATH="), Not(HasSubstr("FAKETIME"))));
}

TEST_F(PlumbRun, ModulesKnowHowFastTimePasses) {
    const std::string hal = "loadrt interlock names=interlock\nsetp interlock.service-timeout-0 30\n";
    const Outcome outcome = run_with_client("--speed 12.5", hal, [](client::Client& client) {
        EXPECT_EQ(client.get("interlock.clock-speed"), 12.5);
        EXPECT_EQ(client.get("interlock.service-timeout-0"), 30);
    });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
}

TEST_F(PlumbRun, FreeTimeOutrunsTheComputer) {
    const Outcome outcome = run_with_client(
        "--free", "loadrt threads name1=servo-thread period1=1000000\nloadrt interlock\nstart\n",
        [](client::Client& client) {
            EXPECT_EQ(client.get("interlock.0.clock-speed"), 1000);
            const auto begin = client.time();
            const auto real = Clock::now();
            std::this_thread::sleep_for(200ms);
            const auto ran = client.time() - begin;
            EXPECT_GT(ran, 20 * (Clock::now() - real));
        });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_THAT(run_script({"--free"}, "env").output, Not(HasSubstr("FAKETIME")));
}

TEST(PlumbRunOnAMachine, WithoutLibfaketimeItReportsItAndGoesOn) {
    on_own_machine(
        [] {
            for (const std::string folder : {"/usr/lib", "/usr/local/lib"}) {
                for (const auto& entry : std::filesystem::directory_iterator(folder)) {
                    const auto library = entry.path() / "faketime";
                    if (!std::filesystem::is_directory(library)) continue;
                    ASSERT_EQ(mount("none", library.c_str(), "tmpfs", 0, nullptr), 0);
                }
            }
            const Outcome outcome =
                run_program({"/tmp/bin/plumb", "run", "--speed", "10", "sh", "-c", "echo on; env"}, "/tmp");
            EXPECT_EQ(outcome.status, 0);
            EXPECT_THAT(outcome.output, AllOf(HasSubstr("on\n"), Not(HasSubstr("FAKETIME"))));
            EXPECT_THAT(outcome.errors, HasSubstr("libfaketime is not installed, so programs see"));
            EXPECT_EQ(run_program({"/tmp/bin/plumb", "run", "true"}, "/tmp").errors, "");
        },
        {{}, {build_folder() + "/bin/plumb"}});
}

// --- clients ---

// In each period, integ.0.out grows by 0.001.
const char* const growing = R"(
loadrt threads name1=servo-thread period1=1000000
loadrt integ
loadrt lowpass names=filter
addf integ.0 servo-thread
addf filter servo-thread
setp integ.0.gain 1
setp integ.0.in 1
setp filter.gain 1
start
)";

void expect_every_period(const Table& table) {
    ASSERT_GT(table.rows.size(), 100u);
    for (std::size_t i = 1; i < table.rows.size(); ++i) {
        ASSERT_NEAR(table.rows[i][0] - table.rows[i - 1][0], 0.001, 1e-9) << "row " << i;
        ASSERT_NEAR(table.rows[i][1] - table.rows[i - 1][1], 0.001, 1e-9) << "row " << i;
    }
}

TEST_F(PlumbRun, AClientWatchesEveryPeriodWhileTimePasses) {
    const auto work = [&](client::Client& client) {
        try {
            client.run(client::seconds(1));
            ADD_FAILURE() << "it runs";
        } catch (const std::runtime_error& refusal) {
            EXPECT_STREQ(refusal.what(), "time passes by itself in this host");
        }
        client.record("growth", {{"integ.0.out"}, client::seconds(0.001), folder / "growth.csv"});
        client.expect("holds", "x > -1", {{"x", "integ.0.out"}});
        client.expect("fails", "x < 0.5", {{"x", "filter.out"}});
        EXPECT_THAT(client.violations(), ElementsAre());
        client.set("filter.in", 0.75);
        await([&] { return client.get("filter.out") == 0.75; }, "effect");
        await([&] { return client.get("integ.0.out") > 1; }, "growth");
        client.record_stop("growth");
        const auto violations = client.violations();
        ASSERT_EQ(violations.size(), 1u);
        EXPECT_EQ(violations[0].id, "fails");
        EXPECT_GT(violations[0].count, 0);
        EXPECT_THAT(violations[0].values, ElementsAre(std::make_pair("x", 0.75)));
        folder.write("ramp.csv", "time,filter.in\n0,3\n0.2,5\n");
        client.record("ramp", {{"filter.out"}, client::seconds(0.001), folder / "ramp.csv.out"});
        EXPECT_EQ(client.replay({(folder / "ramp.csv").string()}), client::seconds(0.2));
        await([&] { return client.get("filter.out") == 5; }, "end of the replay");
        client.record_stop("ramp");
    };
    const Outcome outcome = run_with_client("--speed 10", growing, work);
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    expect_every_period(read_table(folder / "growth.csv"));
    const auto ramp = read_table(folder / "ramp.csv.out").column("filter.out");
    const auto begin = std::find_if(ramp.begin(), ramp.end(), [](double value) { return value >= 3; });
    ASSERT_GT(ramp.end() - begin, 200);
    for (auto value = begin + 1; value < ramp.end(); ++value)
        EXPECT_NEAR(*value - *(value - 1), *(value - 1) < 5 ? 0.01 : 0, 1e-9);
    EXPECT_EQ(ramp.back(), 5);
}

TEST_F(PlumbRun, ARecordingThatCannotBeWrittenEndsAloneAndIsReported) {
    const std::string pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const Outcome outcome = run_with_client("--speed 10", growing, [&](client::Client& client) {
        const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
        client.record("lost", {{"integ.0.out"}, client::seconds(0.001), pipe});
        client.record("kept", {{"filter.out"}, client::seconds(0.001), folder / "kept.csv"});
        close(reader);
        const auto closed = client.time();
        await([&] { return client.time() > closed + client::seconds(10); }, "more than the host keeps");
        try {
            client.record_stop("lost");
            ADD_FAILURE() << "no error is reported";
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr("pipe: Broken pipe"));
        }
        client.record_stop("kept");
    });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_THAT(outcome.output + outcome.errors, HasSubstr("pipe: Broken pipe: the recording ends here"));
    EXPECT_GT(read_table(folder / "kept.csv").rows.size(), 9'000u);
}

TEST_F(PlumbRun, ARecordingFollowsANetThatIsMadeMeanwhile) {
    const Outcome outcome = run_with_client("--speed 10", growing, [&](client::Client& client) {
        client.record("input", {{"filter.in"}, client::seconds(0.001), folder / "input.csv"});
        client.command("net link integ.0.out => filter.in");
        const auto netted = client.time();
        await([&] { return client.time() > netted + client::seconds(5); }, "half a second of the clock");
        client.record_stop("input");
    });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    const auto input = read_table(folder / "input.csv").column("filter.in");
    EXPECT_EQ(input.front(), 0);
    ASSERT_GT(input.size(), 100u);
    for (std::size_t i = input.size() - 50; i < input.size(); ++i)
        EXPECT_NEAR(input[i] - input[i - 1], 0.001, 1e-9);
}

TEST_F(PlumbRun, WhatIsUnloadedEndsItsRecordingAndItsExpectation) {
    const Outcome outcome = run_with_client("--speed 10", growing, [&](client::Client& client) {
        client.record("lost", {{"integ.0.out"}, client::seconds(0.001), folder / "lost.csv"});
        client.record("kept", {{"filter.out"}, client::seconds(0.001), folder / "kept.csv"});
        client.expect("lost", "x >= 0", {{"x", "integ.0.out"}});
        await([&] { return client.get("integ.0.out") > 1; }, "growth");
        client.command("unloadrt integ");
        const auto unloaded = client.time();
        await([&] { return client.time() > unloaded + client::seconds(5); }, "half a second of the clock");
        client.record_stop("lost");
        client.record_stop("kept");
        EXPECT_THROW(client.record_stop("lost"), std::runtime_error);
        EXPECT_THAT(client.violations(), ElementsAre());
    });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    const Table lost = read_table(folder / "lost.csv");
    const Table kept = read_table(folder / "kept.csv");
    expect_every_period(lost);
    EXPECT_GT(kept.rows.back()[0], lost.rows.back()[0] + 3);
}

TEST_F(PlumbRun, HalCanBeUnloadedAndLoadedAgainWhileAClientRecords) {
    const Outcome outcome = run_with_client("--speed 10", growing, [&](client::Client& client) {
        for (const std::string round : {"first", "second", "third"}) {
            client.record(round, {{"integ.0.out"}, client::seconds(0.001), folder / (round + ".csv")});
            client.command("newsig beyond_modules float");
            const std::string signal = "signal in the " + round;
            client.record(signal, {{"beyond_modules"}, client::seconds(0.001), folder / (signal + ".csv")});
            client.expect(round, "x >= 0", {{"x", "integ.0.out"}});
            await([&] { return client.get("integ.0.out") > 0.5; }, "growth");
            client.command(round == "second" ? "unloadrt all" : "unload all");
            EXPECT_THROW(client.get("integ.0.out"), std::runtime_error);
            const double unloaded = std::chrono::duration<double>(client.time()).count();
            client.record_stop(round);
            folder.write("again.hal", growing);
            client.source(folder / "again.hal");
            client.record_stop(signal);
            EXPECT_LE(read_table(folder / (signal + ".csv")).rows.back()[0], unloaded);
        }
        EXPECT_THAT(client.violations(), ElementsAre());
    });
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    for (const std::string round : {"first", "second", "third"})
        expect_every_period(read_table(folder / (round + ".csv")));
}

TEST_F(PlumbRun, OneHalrunAfterTheOtherBeginsAfresh) {
    folder.write("one.hal", std::string(growing) + "net made integ.0.out => filter.in\nshow thread\n");
    const Outcome outcome = run_script({"--speed", "10"}, R"(
set -e
halrun one.hal
halrun one.hal
halcmd -f one.hal
halrun -U
if halcmd -s show sig | grep made; then exit 3; fi
halrun one.hal
echo good
)");
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_THAT(outcome.output, HasSubstr("good\n"));
    EXPECT_THAT(outcome.errors, Not(HasSubstr("uplicate")));
}

// --- files ---

// On a machine of its own, where /tmp, /dev/shm and HOME can be anything.
class PlumbRunFiles : public testing::TestWithParam<Role> {
protected:
    void on_machine(const std::function<void()>& body) {
        MachineOptions options = machine_of(GetParam());
        options.programs = {build_folder() + "/bin/plumb"};
        const bool root = GetParam() != Role::user;
        on_own_machine([&] { Child(root, [&](Child&) { body(); }).await_success(); }, options);
    }
};

// Runs a script in /tmp/inner.
Outcome run_on_machine(const std::string& script, const std::function<void(pid_t)>& meanwhile = {}) {
    return run_program({"/tmp/bin/plumb", "run", "sh", "-c", script}, "/tmp/inner", meanwhile);
}

TEST_P(PlumbRunFiles, TmpShowsWhatIsThereAndTakesWhatIsNew) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        std::ofstream("/tmp/old") << "old\n";
        std::ofstream("/tmp/linuxcnc.lock") << "another LinuxCNC's\n";
        std::ofstream("/tmp/inner/file") << "inner\n";
        const auto before = files();
        const Outcome outcome = run_on_machine(R"(
pwd; cat file /tmp/old
[ -e /tmp/linuxcnc.lock ] && exit 1
echo more >> /tmp/old
echo more > other
echo mine > /tmp/linuxcnc.lock
echo new > /tmp/new
mkdir -p /tmp/folder/deep; echo deep > /tmp/folder/deep/file; ln -s new /tmp/link
while [ ! -e inside ]; do sleep 0.02; done
)",
                                               [](pid_t) {
                                                   await_file("/tmp/inner/other");
                                                   std::ofstream("/tmp/new") << "of another\n";
                                                   std::ofstream("/tmp/inner/inside");
                                               });
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
        EXPECT_EQ(outcome.output, "/tmp/inner\ninner\nold\n");
        EXPECT_EQ(contents("/tmp/old"), "old\nmore\n");
        EXPECT_EQ(contents("/tmp/inner/other"), "more\n");
        EXPECT_EQ(contents("/tmp/linuxcnc.lock"), "another LinuxCNC's\n");
        EXPECT_EQ(contents("/tmp/folder/deep/file"), "deep\n");
        EXPECT_EQ(std::filesystem::read_symlink("/tmp/link"), "new");
        EXPECT_EQ(contents("/tmp/new"), "of another\n");
        EXPECT_EQ(contents("/tmp/new.plumb-1"), "new\n");
        EXPECT_EQ(outcome.errors,
                  "plumb run: /tmp/new is another's meanwhile; the program's is /tmp/new.plumb-1\n");
        EXPECT_EQ(files().size(), before.size() + 4) << "both new, folder and link";
    });
}

TEST_P(PlumbRunFiles, WhatIsNewInTmpKeepsItsRightsAndItsTime) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        const Outcome outcome = run_on_machine(R"(
mkdir /tmp/folder; mkfifo /tmp/folder/b; for name in a c; do echo $name > /tmp/folder/$name; done; chmod 750 /tmp/folder
echo log > /tmp/linuxcnc.report; echo six > /tmp/plumb-report; echo x > /tmp/.Xresources; echo lock > /tmp/.X3-lock; echo log > /tmp/linuxcnc.print.x
chmod 640 /tmp/.Xresources; touch -d '2020-01-02 03:04:05 UTC' /tmp/linuxcnc.report
)");
        EXPECT_EQ(outcome.status, 0);
        EXPECT_EQ(outcome.errors, "");
        EXPECT_EQ(contents("/tmp/folder/a") + contents("/tmp/folder/c"), "a\nc\n");
        EXPECT_FALSE(std::filesystem::exists("/tmp/folder/b"));
        struct stat state {};
        EXPECT_EQ(stat("/tmp/folder", &state), 0);
        EXPECT_EQ(state.st_mode & 07777, 0750u);
        EXPECT_EQ(stat("/tmp/.Xresources", &state), 0);
        EXPECT_EQ(state.st_mode & 07777, 0640u);
        EXPECT_EQ(stat("/tmp/linuxcnc.report", &state), 0);
        EXPECT_EQ(state.st_mtime, 1577934245);
        EXPECT_EQ(contents("/tmp/plumb-report"), "six\n");
        EXPECT_FALSE(std::filesystem::exists("/tmp/.X3-lock"));
        EXPECT_FALSE(std::filesystem::exists("/tmp/linuxcnc.print.x"));
    });
}

TEST_P(PlumbRunFiles, AFileThatAFullTmpDoesNotTakeIsReportedAndFailsTheRun) {
    MachineOptions options = machine_of(GetParam());
    options.programs = {build_folder() + "/bin/plumb"};
    const auto run = [] {
        std::filesystem::create_directory("/tmp/inner");
        const std::string write =
            "echo few > /tmp/few; mkdir /tmp/folder; head -c 1000000 /dev/zero | tee /tmp/result > ";
        const Outcome outcome = run_on_machine(write + "/tmp/folder/result");
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.errors,
                    AllOf(HasSubstr("plumb run: /tmp/result is lost: No space left on device\n"),
                          HasSubstr("plumb run: /tmp/folder/result is lost: No space left on device\n"),
                          Not(HasSubstr("few"))));
        EXPECT_EQ(contents("/tmp/few"), "few\n");
        EXPECT_FALSE(std::filesystem::exists("/tmp/result")) << "half of it";
        EXPECT_FALSE(std::filesystem::exists("/tmp/folder/result")) << "half of it";
        EXPECT_EQ(run_on_machine("head -c 1000000 /dev/zero > /tmp/result; exit 7").status, 7);
    };
    on_own_machine(
        [&] {
            struct statvfs state {};
            ASSERT_EQ(statvfs("/tmp", &state), 0);
            const auto used = (state.f_blocks - state.f_bfree) * state.f_frsize;
            const std::string size = "size=" + std::to_string(used + 200'000);
            ASSERT_EQ(mount("none", "/tmp", nullptr, MS_REMOUNT, size.c_str()), 0);
            Child(GetParam() != Role::user, [&](Child&) { run(); }).await_success();
        },
        options);
}

TEST_P(PlumbRunFiles, NoLinkThatIsPutIntoTmpMeanwhileIsFollowed) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        std::filesystem::create_directory("/tmp/inner/elsewhere");
        const Outcome outcome = run_on_machine(
            "mkdir /tmp/folder; echo file | tee /tmp/file > /tmp/folder/file; touch ready; while [ ! -e go "
            "]; do sleep "
            "0.02; done",
            [](pid_t) {
                await_file("/tmp/inner/ready");
                std::filesystem::create_symlink("/tmp/inner/elsewhere", "/tmp/folder");
                std::filesystem::create_symlink("/tmp/inner/elsewhere/new", "/tmp/file");
                std::ofstream("/tmp/inner/go");
            });
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
        EXPECT_TRUE(std::filesystem::is_empty("/tmp/inner/elsewhere"));
        EXPECT_EQ(contents("/tmp/folder.plumb-1/file") + contents("/tmp/file.plumb-1"), "file\nfile\n");
    });
}

TEST_P(PlumbRunFiles, DevicesAreHarmlessUnlessTheyAreAskedFor) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        const std::string script =
            "echo x > /dev/null; head -c 3 /dev/zero | wc -c; find /dev/ -maxdepth 1 -type b -o "
            "-maxdepth 1 -name 'tty[A-Z0-9]*' | head -1";
        EXPECT_EQ(run_on_machine(script).output, "3\n");
        EXPECT_THAT(run_on_machine("script -qec tty /dev/null").output, HasSubstr("/dev/pts/"));
        const std::string devices = run_program({"/bin/ls", "/dev"}, "/").output;
        EXPECT_EQ(run_program({"/tmp/bin/plumb", "run", "--devices", "ls", "/dev"}, "/").output, devices);
    });
}

TEST_P(PlumbRunFiles, ARunInsideARunHasItsOwnHalAndTheComputersClock) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        // The kernel's own clock stands around the time that HAL integrates and that a program sleeps.
        std::ofstream("/tmp/inner/time.hal")
            << "loadrt integ\nloadrt threads name1=t period1=1000000\naddf integ.0 t\nsetp integ.0.in 1\n"
               "loadusr -w cat /proc/uptime\nstart\nloadusr -w sleep 5\ngetp integ.0.out\n"
               "loadusr -w cat /proc/uptime\n";
        const std::string run = "/tmp/bin/plumb run --speed 10 -- ";
        // A sanitized program, as the inner run may be, minds that libfaketime is loaded before its own
        // library.
        const Outcome outcome = run_on_machine(
            "set -e; export ASAN_OPTIONS=verify_asan_link_order=0; halcmd loadrt threads name1=t "
            "period1=1000000; " +
            run + run + "halrun -f time.hal; halcmd -s show thread");
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
        std::istringstream output(outcome.output);
        double began = 0, seconds = 0, ended = 0, idle = 0;
        ASSERT_TRUE(output >> began >> idle >> seconds >> ended) << outcome.output;
        EXPECT_GT(ended - began, 0.45)
            << "a program's clock is ten times the computer's, not a hundred times";
        EXPECT_LT(seconds, 10 * (ended - began) + 1.2) << "so is HAL's, which may owe 100 ms";
        const bool kept_up = outcome.errors.find("did not keep up") == std::string::npos;
        EXPECT_GT(seconds, kept_up ? 2 : 0) << outcome.errors;
        EXPECT_THAT(outcome.output, HasSubstr(" t "));
    });
}

TEST_P(PlumbRunFiles, SharedMemoryFilesAreItsOwn) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        std::ofstream("/dev/shm/theirs") << "theirs\n";
        const Outcome outcome = run_on_machine("ls /dev/shm; echo mine > /dev/shm/mine");
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
        EXPECT_EQ(outcome.output, "");
        EXPECT_EQ(contents("/dev/shm/theirs"), "theirs\n");
        EXPECT_FALSE(std::filesystem::exists("/dev/shm/mine"));
    });
}

const std::filesystem::path tool_table() {
    return std::filesystem::path(std::getenv("HOME")) / ".tool.mmap";
}

TEST_P(PlumbRunFiles, TheToolTableOfARunningLinuxCncKeepsItsBytes) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        std::ofstream(tool_table()) << "tools of a running LinuxCNC";
        const Outcome outcome =
            run_on_machine("wc -c < $HOME/.tool.mmap; echo mine > $HOME/.tool.mmap; rm -f $HOME/.tool.mmap");
        EXPECT_EQ(outcome.output, "0\n");
        EXPECT_EQ(contents(tool_table()), "tools of a running LinuxCNC");
    });
}

TEST_P(PlumbRunFiles, TwoRunsDoNotShareTheToolTableAndTheLastRemovesIt) {
    on_machine([] {
        std::filesystem::create_directory("/tmp/inner");
        const auto run = [](const std::string& name) {
            return run_on_machine("echo " + name + " > $HOME/.tool.mmap; touch " + name +
                                  "; while [ ! -e end-" + name +
                                  " ]; do sleep 0.02; done; cat $HOME/.tool.mmap");
        };
        Outcome first{}, second{};
        std::thread one([&] { first = run("first"); });
        await_file("/tmp/inner/first");
        std::thread other([&] { second = run("second"); });
        await_file("/tmp/inner/second");
        std::ofstream("/tmp/inner/end-first");
        one.join();
        EXPECT_EQ(first.output, "first\n");
        EXPECT_EQ(contents(tool_table()), "");
        EXPECT_TRUE(std::filesystem::exists(tool_table())) << "the second run needs it";
        std::ofstream("/tmp/inner/end-second");
        other.join();
        EXPECT_EQ(second.output, "second\n");
        EXPECT_FALSE(std::filesystem::exists(tool_table()));
    });
}

INSTANTIATE_TEST_SUITE_P(, PlumbRunFiles, testing::Values(Role::root, Role::user),
                         [](const auto& instance) { return name_of(instance.param); });

// --- other things that a computer has one of ---

std::vector<std::string> interfaces(const std::string& table) {
    std::vector<std::string> names;
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos) continue;
        const std::size_t begin = line.find_first_not_of(' ');
        names.push_back(line.substr(begin, colon - begin));
    }
    return names;
}

TEST_F(PlumbRun, TheNetworkIsALoopbackUnlessItIsAskedFor) {
    const std::string python =
        "import socket\n"
        "server = socket.create_server(('127.0.0.1', 0))\n"
        "socket.create_connection(server.getsockname())\n"
        "print(open('/proc/net/dev').read())\n";
    if (!namespaces()) GTEST_SKIP() << "the kernel gives no namespaces";
    const std::string script = folder.write("network.py", python);
    const Outcome own = run({"/usr/bin/python3", script});
    EXPECT_EQ(own.status, 0) << own.errors;
    EXPECT_THAT(interfaces(own.output), ElementsAre("lo"));
    EXPECT_EQ(interfaces(run({"--network", "/usr/bin/python3", script}).output),
              interfaces(contents("/proc/net/dev")));
}

TEST(PlumbRunBesideLinuxCnc, NeitherSeesTheOther) {
    MachineOptions options;
    options.as_root = false;  // a stock realtime does not run where root is the only user
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [] {
            setenv("RTAPI_UID", "65534", 1);  // which a stock realtime of root's asks for
            std::filesystem::create_directory("/tmp/inner");
            std::ofstream("/tmp/inner/stock.hal") << "loadrt threads name1=servo-thread period1=1000000\n"
                                                     "loadrt lowpass names=stock\nstart\n";
            std::ofstream("/tmp/inner/run.hal") << "loadrt threads name1=servo-thread period1=1000000\n"
                                                   "loadrt lowpass names=mine\nstart\nshow comp\n";
            ASSERT_EQ(std::system("halcmd -f /tmp/inner/stock.hal"), 0);
            const Outcome outcome = run_on_machine("halrun -f run.hal; ps -e -o comm; halrun -U");
            EXPECT_EQ(outcome.status, 0) << outcome.errors;
            EXPECT_THAT(outcome.output, AllOf(HasSubstr("lowpass"), Not(HasSubstr("rtapi_app"))));
            EXPECT_EQ(std::system("halcmd -s show pin stock.out | grep -q stock.out"), 0)
                << "it was disturbed";
            EXPECT_NE(std::system("halcmd -s show pin mine.out | grep -q mine.out"), 0) << "it sees the run";
            const Outcome refused = run_program({"/tmp/bin/plumb", "run", "--no-namespaces", "true"}, "/tmp");
            EXPECT_EQ(refused.status, 1);
            EXPECT_THAT(refused.errors, HasSubstr("plumb run: LinuxCNC's realtime runs on this machine"));
            EXPECT_EQ(std::system("halcmd unloadrt all"), 0);
        },
        options);
}

// The linuxcnc script writes into files in HOME where its input is no terminal, and prints nothing.
TEST_F(PlumbRun, WithoutATerminalTheOutputOfLinuxcncStaysHere) {
    const std::filesystem::path script = folder.path() / "linuxcnc";
    std::ofstream(script) << "#!/bin/sh\necho given: \"$@\"\n";
    std::filesystem::permissions(script, static_cast<std::filesystem::perms>(0755));
    EXPECT_THAT(run({script, "grinder.ini"}).output, HasSubstr("given: -r grinder.ini"));
    EXPECT_THAT(run({"--speed", "10", "--", script, "-v", "my.ini"}).output,
                HasSubstr("given: -r -v my.ini"));
    EXPECT_THAT(run({"echo", "grinder.ini"}).output, HasSubstr("grinder.ini"));
    EXPECT_THAT(run({"echo", "grinder.ini"}).output, Not(HasSubstr("-r")));

    std::vector<std::string> words{build_folder() + "/bin/plumb", "run"};
    if (!namespaces()) words.push_back("--no-namespaces");
    words.insert(words.end(), {script, "grinder.ini"});
    EXPECT_THAT(run_on_terminal(words, folder.path()).output, HasSubstr("given: grinder.ini"));
}

// A LinuxCNC outside that starts or ends sends SIGTERM to all that pidof calls milltask.
TEST(PlumbRunBesideLinuxCnc, ARunWhoseTaskIsEndedByItEndsAndReportsIt) {
    MachineOptions options;
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [] {
            std::filesystem::create_directory("/tmp/inner");
            std::filesystem::create_symlink("/bin/sleep", "/tmp/inner/milltask");
            std::ofstream("/tmp/inner/linuxcnc")
                << "#!/bin/bash\nhalcmd loadrt threads name1=t period1=1000000\n"
                   "./milltask 1000 &\nsleep 1000\n";
            std::filesystem::permissions("/tmp/inner/linuxcnc", static_cast<std::filesystem::perms>(0755));
            const Outcome outcome = run_on_machine("./linuxcnc", [](pid_t) {
                const pid_t task = Processes::called("milltask");
                std::this_thread::sleep_for(1200ms);  // so that it was seen
                kill(task, SIGTERM);
            });
            EXPECT_NE(outcome.status, 0);
            EXPECT_THAT(outcome.errors,
                        HasSubstr("plumb run: milltask has ended, and linuxcnc waits without it"));
        },
        options);
}

TEST(PlumbRunBesideLinuxCnc, ALinuxCncThatCleansUpSlowlyIsNotGivenUp) {
    MachineOptions options;
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [] {
            std::filesystem::create_directory("/tmp/inner");
            std::filesystem::create_symlink("/bin/sleep", "/tmp/inner/milltask");
            std::ofstream("/tmp/inner/linuxcnc")
                << "#!/bin/bash\nhalcmd loadrt threads name1=t period1=1000000\n"
                   "./milltask 1.2\nfor i in {1..70}; do sleep 0.1; done\n";
            std::filesystem::permissions("/tmp/inner/linuxcnc", static_cast<std::filesystem::perms>(0755));
            const Outcome outcome = run_on_machine("./linuxcnc");
            EXPECT_EQ(outcome.status, 0) << outcome.errors;
        },
        options);
}

}  // namespace
}  // namespace plumb
