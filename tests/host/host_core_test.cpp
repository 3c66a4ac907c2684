// SPDX-License-Identifier: GPL-2.0-or-later
// The virtual-time host with stock modules, damaged files, broken requests and killed programs.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/place.hpp"

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// Sends bytes to the host's socket; returns all that it answers until it closes the connection, or until
/// `lines` lines have come.
std::string talk(const std::string& socket_path, const std::vector<std::string>& pieces, int lines = -1) {
    const int peer = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket_path.c_str(), sizeof address.sun_path - 1);
    if (connect(peer, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
        throw std::runtime_error("cannot connect to " + socket_path);
    for (const std::string& piece : pieces) {
        send(peer, piece.data(), piece.size(), MSG_NOSIGNAL);
        usleep(20'000);  // so that it arrives alone
    }
    std::string answer;
    char buffer[4096];
    while (lines != 0) {
        const ssize_t count = recv(peer, buffer, sizeof buffer, 0);
        if (count <= 0) break;
        answer.append(buffer, static_cast<std::size_t>(count));
        if (lines > 0 && std::count(answer.begin(), answer.end(), '\n') >= lines) break;
    }
    close(peer);
    return answer;
}

/// The most memory that a process has had, in kB.
long most_memory(pid_t process) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) return std::stol(line.substr(6));
    throw std::runtime_error("process " + std::to_string(process) + " has no memory");
}

class HostCore : public testing::Test {
protected:
    Bench bench_;
    Folder folder_;
};

TEST_F(HostCore, RealtimeCodeReadsTheVirtualClock) {
    bench_.command("loadrt timedelta");
    bench_.command("addf timedelta.0 servo-thread");
    bench_.run(3600);
    EXPECT_NEAR(bench_.get("timedelta.0.max"), 1e6, 10);
    EXPECT_LE(bench_.get("timedelta.0.jitter"), 10) << "ns: one for each reading of the clock";
}

TEST_F(HostCore, SlowThreadsSeeWhatFastThreadsDidAtTheSameInstant) {
    Bench bench(Bench::Thread::none);
    bench.command("loadrt threads name1=fast period1=100000 name2=slow period2=1000000");
    bench.command("loadrt integ count=2");  // sums in * dt
    bench.command("loadrt sum2");
    for (const char* line :
         {"setp integ.0.in 1", "setp integ.0.gain 1", "net quick integ.0.out => sum2.0.in0",
          "addf integ.0 fast", "addf sum2.0 slow", "start"})
        bench.command(line);
    bench.run(0.005);
    EXPECT_NEAR(bench.get("quick"), 0.005, 1e-12);
    EXPECT_EQ(bench.get("sum2.0.out"), bench.get("quick"));
}

TEST_F(HostCore, WrongModuleParametersAreRefusedInTheWordsOfRtapiApp) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"or2 count=x", "`x' invalid for parameter `count=x'"},
        {"or2 cuont=2", "Unknown parameter `cuont=2'"},
        {"or2 2", "Invalid paramter `2'"},
        {"pid names=a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q", "can only take 16 arguments"},
        {"no_such", "no_such.so: cannot open shared object file"},
        {"../or2", "../or2: Not allowed as module name"},
    };
    for (const auto& [arguments, words] : cases) {
        const std::size_t blank = arguments.find(' ');
        std::vector<std::string> call{"loadrt", arguments.substr(0, blank)};
        if (blank != std::string::npos) call.push_back(arguments.substr(blank + 1));
        const client::Halcmd result = bench_.client().halcmd(call);
        EXPECT_NE(result.status, 0) << arguments;
        EXPECT_THAT(result.output, HasSubstr(words)) << arguments;
    }
    bench_.command("loadrt or2 count=3");
    // halcmd would not wait for the refusal: a component of that name is there and ready.
    EXPECT_EQ(talk(bench_.client().socket(), {"2 4 load3 or2"}), "-1 ");
    bench_.command("unloadrt or2");
    bench_.command("loadrt or2 names=again");
    EXPECT_EQ(bench_.get("again.out"), 0);
}

TEST_F(HostCore, DamagedReplaysAreRefusedWithFileLineColumnAndValue) {
    bench_.command("loadrt sum2");
    bench_.command("loadrt mux2");
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "there is no data in it"},
        {"time,sum2.0.in0\n", "there is no data in it"},
        {"t,sum2.0.in0\n0,1\n", "line 1: the first column is 't', not 'time'"},
        {"time\n0\n", "line 1: no pin is named"},
        {"time,sum2.0.in0,\n0,1,2\n", "line 1: column 3 has no name"},
        {"time,sum2.0.in0,sum2.0.in0\n0,1,2\n", "line 1: 'sum2.0.in0' stands there twice"},
        {"time,sum2.0.in0\n0,1\n\n0,2\n", "line 4: the time does not rise"},
        {"time,sum2.0.in0\n-1,1\n", "line 2: column 'time': '-1' is not a time"},
        {"time,sum2.0.in0\nnan,1\n", "line 2: column 'time': 'nan' is not a time"},
        {"time,sum2.0.in0\n1e300,1\n", "line 2: column 'time': '1e300' is not a time"},
        {"time,sum2.0.in0\n0,1\n1,1.2.3\n", "line 3: column 'sum2.0.in0': '1.2.3' is not a number"},
        {"time,sum2.0.in0\n0,1\n1\n", "line 3: 1 value, but the header has 2"},
        {"time,mux2.0.sel\n0,TRUE\n1,0.5\n", "line 3: column 'mux2.0.sel': 0.5 is no value of a bit pin"},
        {"time,sum2.0.out\n0,1\n", "pin 'sum2.0.out' is not writable"},
        {"time,sum2.0.inn\n0,1\n", "there is no pin, parameter or signal 'sum2.0.inn'"},
    };
    for (const auto& [text, words] : cases) {
        const std::string file = folder_.write("in.csv", text);
        try {
            bench_.client().replay({file});
            ADD_FAILURE() << "not refused: " << text;
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr(words));
        }
    }
}

TEST_F(HostCore, ReplayedFloatsAreLinearInTimeAndBitsHold) {
    bench_.command("loadrt sum2");
    bench_.command("loadrt and2");
    bench_.command("addf sum2.0 servo-thread");
    bench_.run(0.7);  // the file's time counts from the request
    const std::string file =
        folder_.write("in.csv", "time,sum2.0.in0,and2.0.in0\r\n0.5,2,0\r\n1.5,4,TRUE\r\n2,4,false\r\n");
    EXPECT_EQ(bench_.client().replay({file}), 2s);
    const Table table = bench_.trace(2, {"sum2.0.out", "and2.0.in0"}, 0.25);
    EXPECT_THAT(table.column("sum2.0.out"), testing::ElementsAre(0, 2, 2, 2.5, 3, 3.5, 4, 4, 4));
    EXPECT_THAT(table.column("and2.0.in0"), testing::ElementsAre(0, 0, 0, 0, 0, 0, 1, 1, 0));
}

TEST_F(HostCore, ReplayedFloatsHoldNextToWhatIsNotFinite) {
    bench_.command("loadrt sum2");
    bench_.command("addf sum2.0 servo-thread");
    const std::string file =
        folder_.write("in.csv", "time,sum2.0.in0\n0,1\n0.5,2\n1,nan\n1.5,4\n2,inf\n2.5,5\n3,6\n");
    bench_.client().replay({file});
    const Table table = bench_.trace(3, {"sum2.0.out"}, 0.25);
    using testing::IsNan;
    EXPECT_THAT(table.column("sum2.0.out"),
                testing::ElementsAre(0, 1.5, 2, 2, IsNan(), IsNan(), 4, 4, INFINITY, INFINITY, 5, 5.5, 6));
}

TEST_F(HostCore, AReplayMayBeginWithAByteOrderMark) {
    bench_.command("loadrt sum2");
    const std::string file = folder_.write("in.csv", "\xef\xbb\xbftime,sum2.0.in0\n0,1\n1,2\n");
    EXPECT_EQ(bench_.client().replay({file}), 1s);
}

TEST_F(HostCore, SamplesThatAreNotConsecutiveAreRefusedWithBothNumbers) {
    bench_.command("loadrt sum2");
    const auto replay = [&](const std::string& text) {
        const std::string file = folder_.write("in.txt", text);
        return bench_.client().replay({file, {"sum2.0.in0", "sum2.0.in1"}, 1ms});
    };
    EXPECT_EQ(replay("7 1 2\n8 1 2\n\n9 1 2\n"), 2ms);
    EXPECT_EQ(replay("7 1 2\n8 1 2\n9 1"), 1ms);  // where halsampler was killed
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"0 1 2\n1 1 2\n\n5 1 2\n", "in.txt: line 4: sample 5 follows 1: samples are missing"},
        {"0 1 2\n0 1 2\n", "line 2: sample 0 follows 0"},
        {"0 1 2\nx 1 2\n", "line 2: 'x' is not a sample number"},
        {"0 1 2\n1 1\n", "line 2: 1 value for 2 columns"},
        {"1 2\n0 1 2\n", "line 2: 3 values for 2 columns"},
    };
    for (const auto& [text, words] : cases) {
        try {
            replay(text);
            ADD_FAILURE() << "not refused: " << text;
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr(words));
        }
    }
}

TEST_F(HostCore, AnAppendedRecordingGoesOnInTime) {
    bench_.command("loadrt sum2");
    bench_.command("addf sum2.0 servo-thread");
    const std::string file = folder_ / "out.csv";
    client::Client& client = bench_.client();
    client.record("r", {{"sum2.0.out"}, 500ms, file});
    bench_.set("sum2.0.in0", 1);
    bench_.run(1);
    client.record_stop("r");
    bench_.run(10);  // not recorded
    bench_.set("sum2.0.in0", 0.1);
    client.record("r", {{"sum2.0.out"}, 500ms, file, true});
    bench_.run(0.5);
    EXPECT_EQ(contents(file), "time,sum2.0.out\n0,0\n0.5,1\n1,1\n1.5,0.1\n");
    EXPECT_THROW(client.record("s", {{"sum2.0.in0"}, 500ms, file, true}), std::runtime_error);
}

TEST_F(HostCore, AFullDiskEndsTheRunWithASentence) {
    bench_.command("loadrt sum2");
    try {
        bench_.client().record("r", {{"sum2.0.out"}, 1ms, "/dev/full"});
        ADD_FAILURE() << "not refused";
    } catch (const std::runtime_error& refusal) {
        EXPECT_THAT(refusal.what(), HasSubstr("/dev/full: No space left on device"));
    }
}

TEST_F(HostCore, ARecordingThatFailsMeanwhileEndsTheRunAndIsReported) {
    bench_.command("loadrt sum2");
    bench_.command("addf sum2.0 servo-thread");
    const std::string pipe = folder_ / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const auto refusal = [](const auto& action) -> std::string {
        try {
            action();
        } catch (const std::runtime_error& refused) {
            return refused.what();
        }
        return "not refused";
    };
    client::Client& client = bench_.client();
    const auto record = [&] { client.record("r", {{"sum2.0.out"}, 1ms, pipe}); };
    EXPECT_THAT(refusal(record), HasSubstr("pipe: is a pipe or socket that nobody reads"));
    const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    record();
    client.record("other", {{"sum2.0.out"}, 1ms, folder_ / "other.csv"});
    EXPECT_EQ(bench_.client().run(2ms).ran, 2ms);
    close(reader);
    EXPECT_THAT(refusal([&] { client.run(2ms); }), HasSubstr("pipe: Broken pipe"));
    EXPECT_THAT(refusal([&] { client.record_stop("r"); }), HasSubstr("pipe: Broken pipe"));
    EXPECT_THAT(refusal([&] { client.record_stop("r"); }), HasSubstr("there is no recording"));
    EXPECT_EQ(client.run(2ms).ran, 2ms) << "the host goes on";
    client.record_stop("other");
    EXPECT_THAT(contents(folder_ / "other.csv"), HasSubstr("\n0.006,0\n"));
}

TEST_F(HostCore, ARecordingThatBreaksOffIsNotGoneOnWith) {
    bench_.command("loadrt sum2");
    const auto refused = [&](const std::string& text, const std::string& why) {
        const std::string file = folder_.write("out.csv", text);
        try {
            bench_.client().record("r", {{"sum2.0.out"}, 1ms, file, true});
            ADD_FAILURE() << "not refused: " << text;
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr(why));
        }
        EXPECT_EQ(contents(file), text);
    };
    refused("time,sum2.0.out\n0,1\n0.5,", "the last row breaks off");
    refused("time,sum2.0.out\n0,1\n1e300,1\n", "the last row has no time");
    refused("time,sum2.0.out\n0,1\nnan,1\n", "the last row has no time");
}

TEST_F(HostCore, OnlyARegularFileIsReplayed) {
    bench_.command("loadrt sum2");
    const std::string pipe = folder_ / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const std::string long_line = folder_.write("long.csv", std::string(3 << 20, 'x'));
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"/dev/zero", "/dev/zero: is a device, no regular file"},
        {pipe, "pipe: is a pipe, no regular file"},
        {folder_ / "", "is a folder, no regular file"},
        {folder_ / "none.csv", "none.csv: No such file or directory"},
        {long_line, "long.csv: line 1: is longer than 1 MiB"},
    };
    for (const auto& [file, words] : cases) {
        for (const bool samples : {false, true}) {
            try {
                if (samples)
                    bench_.client().replay({file, {"sum2.0.in0"}, 1ms});
                else
                    bench_.client().replay({file});
                ADD_FAILURE() << "not refused: " << file;
            } catch (const std::runtime_error& refusal) {
                EXPECT_THAT(refusal.what(), HasSubstr(words));
            }
        }
    }
}

TEST_F(HostCore, RtapiAppsProtocolMayArriveInPieces) {
    const std::string& socket_path = bench_.client().socket();
    EXPECT_EQ(talk(socket_path, {"2 4 lo", "ad3 or", "2"}), "0 ");
    EXPECT_EQ(bench_.get("or2.0.out"), 0);
    EXPECT_EQ(talk(socket_path, {"1 4 nope"}), "-1 ");
    EXPECT_EQ(talk(socket_path, {"2 6 unload4 none"}), "-1 ");
    EXPECT_EQ(talk(socket_path, {"3 7 newinst4 none3 new"}), "-1 ");
}

TEST_F(HostCore, WhatIsNoProtocolIsHungUpOn) {
    const std::string& socket_path = bench_.client().socket();
    EXPECT_EQ(talk(socket_path, {"1x"}), "");
    EXPECT_EQ(talk(socket_path, {"99999999999999999999 "}), "");
    EXPECT_EQ(talk(socket_path, {"1  "}), "");
    EXPECT_THAT(talk(socket_path, {"{]\n"}, 1), HasSubstr("\"ok\":false"));
    EXPECT_THAT(talk(socket_path, {"{\"do\":\"dance\"}\n"}, 1),
                HasSubstr("'dance' is no request of this host"));
    EXPECT_THAT(talk(socket_path, {"{\"do\":\"run\"}\n"}, 1), HasSubstr("'run' needs \\\"ns\\\""));
    EXPECT_THAT(talk(socket_path, {"{\"do\":\"run\",\"ns\":1.5}\n"}, 1),
                HasSubstr("whole number of nanoseconds"));
    bench_.run(1);  // it lives
}

TEST_F(HostCore, RequestsBeyondAllMeasureAreRefusedAndNotKept) {
    const std::string& socket_path = bench_.client().socket();
    const std::string hello = "{\"do\":\"hello\"}\n";
    const std::string deep =
        "{\"do\":\"get\",\"names\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}\n";
    EXPECT_THAT(talk(socket_path, {deep}, 1), HasSubstr("the request is nested more than 32 deep"));
    const std::string large =
        "{\"do\":\"set\",\"name\":\"" + std::string(40'000'000, 'x') + "\",\"value\":1}\n";
    const long before = most_memory(bench_.client().process());
    const std::string answers = talk(socket_path, {hello + large + hello}, 3);
#ifdef PLUMB_SANITIZED  // The sanitizer keeps what is freed.
    constexpr long kept = 300'000;
#else
    constexpr long kept = 10'000;
#endif
    EXPECT_LT(most_memory(bench_.client().process()) - before, kept) << "a part of it is kept";
    EXPECT_THAT(answers, testing::MatchesRegex(
                             ".*\"ok\":true.*\n.*the request is longer than 1 MiB.*\n.*\"ok\":true.*\n"));
    EXPECT_EQ(talk(socket_path, {"2 4 load900000 " + std::string(300'000, 'x')}), "");
    bench_.run(1);  // it lives
}

TEST_F(HostCore, ALargeRequestAndManyAreCarriedOut) {
    bench_.command("loadrt sum2");
    std::string names = "\"sum2.0.in0\"";
    for (int i = 0; i < 50'000; ++i) names += ",\"sum2.0.out\"";
    const std::string answer =
        talk(bench_.client().socket(), {"{\"do\":\"get\",\"names\":[" + names + "]}\n"}, 1);
    EXPECT_THAT(answer.substr(0, 10), HasSubstr("{\"ok\":true"));
    std::string many;
    for (int i = 0; i < 5'000; ++i) many += "{\"do\":\"get\",\"names\":[\"sum2.0.in0\"]}\n";
    const std::string answers = talk(bench_.client().socket(), {many}, 5'000);
    EXPECT_EQ(std::count(answers.begin(), answers.end(), '\n'), 5'000);
    EXPECT_THAT(answers, testing::Not(HasSubstr("false")));
}

TEST_F(HostCore, RequestsThatAreSentAtOnceAreAnsweredInOrder) {
    const std::string answers = talk(bench_.client().socket(),
                                     {"{\"do\":\"run\",\"ns\":2000000}\n{\"do\":\"get\",\"names\":[\"x\"]}\n"
                                      "{\"do\":\"run\",\"ns\":3000000}\n{\"do\":\"stop\"}\n"},
                                     4);
    EXPECT_THAT(answers,
                testing::MatchesRegex(".*\"ran\":2000000.*\n.*'x'.*\n.*\"ran\":.*\n.*\"ok\":true.*\n"));
}

TEST_F(HostCore, HalsLockIsTakenBackFromAKilledProgram) {
    const std::string program = folder_.write("locker.py", R"(
import ctypes, os, signal
libc = ctypes.CDLL(None)
libc.shmat.restype = ctypes.c_void_p
memory = libc.shmat(libc.shmget(0x48414c32, 0, 0), None, 0)
ctypes.c_ulong.from_address(memory + 8).value |= 1
os.kill(os.getpid(), signal.SIGKILL)
)");
    bench_.command("loadrt or2");
    bench_.client().halcmd({"loadusr", "/usr/bin/python3", program});
    bench_.command("loadrt sum2");
    bench_.client().halcmd(
        {"loadusr", "-w", "/usr/bin/python3", program});  // whose own halcmd waits for the lock
    EXPECT_EQ(bench_.get("or2.0.out"), 0);
    bench_.command("setp or2.0.in0 1");
}

// As by Ctrl-Z at the wrong moment.
TEST_F(HostCore, AStoppedProgramThatHoldsALockOfHalIsNamed) {
    client::Start start;
    start.show_output = true;
    testing::internal::CaptureStderr();
    {
        client::Client host(start);
        host.command("loadrt or2");
        for (const char* const place : {"48414c32 8", "48484c34 0"}) {
            host.command("loadusr -w /usr/bin/python3 " + source_folder() +
                         "/tests/programs/hal_lock_holder.py " + std::string(place));
            host.command(place[3] == '1' ? "loadrt sum2" : "loadrt mult2");
        }
    }
    const std::string words = testing::internal::GetCapturedStderr();
    const std::string stopped = "process [0-9]+, python3, of user [a-z0-9]+ is stopped and held ";
    EXPECT_THAT(words, testing::ContainsRegex(stopped + "HAL's lock; the lock is open again"));
    EXPECT_THAT(words,
                testing::ContainsRegex(stopped + "the lock of HAL's identities; the lock is open again"));
}

}  // namespace
}  // namespace plumb
