// SPDX-License-Identifier: GPL-2.0-or-later
// The C++ client and the fixture, against a real host.
#include "tests/support/bench.hpp"

#include "hal/client/duration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>

#include <signal.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// The message with which a call is refused; fails the test if it is not.
template <class Call>
std::string refusal(Call call) {
    try {
        call();
    } catch (const client::HostDied& death) {
        ADD_FAILURE() << death.what();
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    ADD_FAILURE() << "not refused";
    return "";
}

// A filter without lag: out follows in a period later than it is set.
struct ClientOfHost : testing::Test {
    Bench bench;
    client::Client& client = bench.client();

    ClientOfHost() {
        client.command("loadrt lowpass names=it");
        client.command("addf it servo-thread");
        bench.set("it.gain", 1);
    }
};

TEST_F(ClientOfHost, ValuesOfEveryTypeGoThereAndBack) {
    client.command("loadrt not names=not");
    client.command("loadrt conv_s32_u32 names=s32");
    client.command("loadrt conv_u32_s32 names=u32");
    bench.set("not.in", 1);
    bench.set("s32.in", -2147483648.0);
    bench.set("u32.in", 4294967295.0);
    bench.set("it.in", 0.1 + 0.2);
    const auto values = client.read({"not.in", "s32.in", "u32.in", "it.in"});
    const char* const types[] = {"bit", "s32", "u32", "float"};
    const double expected[] = {1, -2147483648.0, 4294967295.0, 0.1 + 0.2};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(values[i].type, types[i]);
        EXPECT_EQ(values[i].value, expected[i]);
    }
}

TEST_F(ClientOfHost, WhatIsNotFiniteGoesThereAndBack) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {infinity, -infinity, 1e308, 5e-324, -0.0}) {
        bench.set("it.in", value);
        EXPECT_EQ(bench.get("it.in"), value);
        bench.run(0.001);
        EXPECT_EQ(std::signbit(bench.get("it.in")), std::signbit(value));
    }
    bench.set("it.in", std::nan(""));
    EXPECT_TRUE(std::isnan(bench.get("it.in")));
}

TEST_F(ClientOfHost, RefusesWhatHalcmdRefusesAndGivesTheReason) {
    client.command("net input it.in");
    EXPECT_THAT(refusal([&] { bench.set("it.in", 1); }),
                AllOf(HasSubstr("it.in"), HasSubstr("connected to a signal")));
    EXPECT_THAT(refusal([&] { bench.set("it.out", 1); }), HasSubstr("it.out"));
    EXPECT_THAT(refusal([&] { bench.set("nothing", 1); }), HasSubstr("nothing"));
    EXPECT_THAT(refusal([&] { bench.get("nothing"); }), HasSubstr("'nothing'"));
    bench.set("input", 3);  // the signal, which has no writer
    EXPECT_EQ(bench.get("it.in"), 3);
}

TEST_F(ClientOfHost, ANameThatBecomesAnOutputsIsRefused) {
    client.command("alias pin it.in it.here");
    bench.set("it.here", 1);
    client.command("unalias pin it.here");
    client.command("alias pin it.out it.here");
    EXPECT_THAT(refusal([&] { bench.set("it.here", 1); }), HasSubstr("not writable"));
}

TEST_F(ClientOfHost, CommandsFailWithHalcmdsMessage) {
    EXPECT_THAT(refusal([&] { client.command("loadrt no_such_module"); }), HasSubstr("no_such_module"));
    EXPECT_THAT(refusal([&] { client.command("addf no-such-function servo-thread"); }),
                HasSubstr("no-such-function"));
    const Folder folder;
    const auto file = folder.write("wrong.hal", "setp it.gain 1\n\nsetp it.gian 1\n");
    EXPECT_THAT(refusal([&] { bench.source(file); }), AllOf(HasSubstr("wrong.hal:3"), HasSubstr("it.gian")));
    EXPECT_THAT(refusal([&] { bench.source(folder / "none.hal"); }), HasSubstr("none.hal"));
    EXPECT_THROW(client.command("setp 'it.gain 1"), std::invalid_argument);
}

TEST_F(ClientOfHost, QuotesKeepWordsTogether) {
    EXPECT_THAT(client.halcmd({"echo"}).output, testing::_);
    client.command("loadrt message names=m messages=\"two words\"");
    EXPECT_EQ(bench.get("m.trigger"), 0);
}

TEST_F(ClientOfHost, ARunReportsItsProgressAndCanBeStopped) {
    std::vector<client::Time> progress;
    const client::Ran ran = client.run(client::seconds(1e8), [&](client::Time done) {
        progress.push_back(done);
        return progress.size() < 3;
    });
    EXPECT_EQ(progress.size(), 3u);
    EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
    EXPECT_GE(ran.ran, progress.back());
    EXPECT_LT(ran.ran, client::seconds(1e8));
    EXPECT_EQ(ran.ran % 1ms, 0ns) << "it stops at a period";
    EXPECT_EQ(ran.ended, "");
    EXPECT_EQ(client.time(), ran.time);  // the answers are still in step with the requests
    EXPECT_EQ(bench.get("it.gain"), 1);
}

TEST_F(ClientOfHost, TimeMovesOnlyInARun) {
    EXPECT_EQ(client.time(), 0ns);
    EXPECT_EQ(client.run(250ms).time, 250ms);
    EXPECT_EQ(client.run(client::seconds(3600)).ran, 1h);
    EXPECT_EQ(bench.time(), 3600.25);
    EXPECT_THROW(client.run(-1ns), std::runtime_error);
    EXPECT_THROW(bench.run(std::nan("")), std::invalid_argument);
    EXPECT_THROW(bench.run(1e12), std::invalid_argument);
}

TEST_F(ClientOfHost, RecordsUntilItIsStopped) {
    const Folder folder;
    bench.set("it.in", 1);
    client.record("r", {{"it.in", "it.out"}, 2ms, folder / "r.csv"});
    bench.run(0.004);
    bench.set("it.in", 2);
    bench.run(0.003);
    client.record_stop("r");
    bench.run(1);
    const Table table = read_table(folder / "r.csv");
    EXPECT_THAT(table.names, ElementsAre("time", "it.in", "it.out"));
    EXPECT_THAT(table.column("time"), ElementsAre(0, 0.002, 0.004, 0.006));
    EXPECT_THAT(table.column("it.out"), ElementsAre(0, 1, 1, 2));
    EXPECT_THROW(table.column("it.gain"), std::out_of_range);
    EXPECT_THAT(refusal([&] {
                    client.record("r", {{"it.in"}, 2ms, folder / "none" / "r.csv"});
                }),
                HasSubstr("none/r.csv"));
    EXPECT_THROW(client.record_stop("r"), std::runtime_error);
}

TEST_F(ClientOfHost, ReplayEndsTheRun) {
    const Folder folder;
    const auto file = folder.write("r.csv", "time,it.in\n0,10\n1,20\n");
    EXPECT_EQ(client.replay({file}), 1s);
    EXPECT_EQ(client.run(400ms).ended, "");
    EXPECT_NEAR(bench.get("it.out"), 14, 0.011);
    const client::Ran ran = client.run(1h);
    EXPECT_EQ(ran.ended, "replay");
    EXPECT_EQ(ran.time, 1s);
    const auto damaged = folder.write("damaged.csv", "time,it.in\n0,10\n1,twenty\n");
    EXPECT_THAT(refusal([&] { client.replay({damaged}); }),
                AllOf(HasSubstr("damaged.csv"), HasSubstr("line 3"), HasSubstr("twenty")));
}

TEST_F(ClientOfHost, ExpectationsAreCheckedInEveryPeriod) {
    client.expect("small", "x < 2.5", {{"x", "it.out"}});
    client.expect("true", "finite(x) && x >= 0", {{"x", "it.out"}});
    for (const double in : {1, 2, 3, 4, 1}) {
        bench.set("it.in", in);
        bench.run(0.001);
    }
    const auto violations = client.violations();
    ASSERT_EQ(violations.size(), 1u);
    EXPECT_EQ(violations[0].id, "small");
    EXPECT_EQ(violations[0].count, 2);
    EXPECT_EQ(violations[0].first_time, 3ms);
    EXPECT_EQ(violations[0].values.at("x"), 3);
    EXPECT_THAT(refusal([&] { client.expect("bad", "x <", {{"x", "it.out"}}); }), HasSubstr("x <"));
    EXPECT_THAT(refusal([&] {
                    client.expect("bad", "x = 5", {{"x", "it.out"}});
                }),
                HasSubstr("'x = 5': = assigns a value"));
    EXPECT_THAT(refusal([&] {
                    client.expect("bad", "1 < 2", {{"x", "it.out"}});
                }),
                HasSubstr("'1 < 2': it is about no pin"));
}

TEST_F(ClientOfHost, ASecondClientSharesTheHostAndLeavesItRunning) {
    {
        client::Client second(client::Attach{client.socket()});
        EXPECT_EQ(second.process(), client.process());
        second.set("it.in", 4);
        second.run(1ms);
    }
    EXPECT_EQ(bench.get("it.out"), 4);
    EXPECT_EQ(client.time(), 1ms);
    EXPECT_THAT(refusal([] { client::Client(client::Attach{"/no/such/socket"}); }),
                HasSubstr("no virtual-time host at /no/such/socket"));
}

TEST_F(ClientOfHost, AfterExitEveryCallFails) {
    client::Client second(client::Attach{client.socket()});
    client.exit();
    EXPECT_THROW(client.get("it.in"), client::HostDied);
    EXPECT_THROW(second.get("it.in"), client::HostDied);
    EXPECT_THROW(second.time(), client::HostDied);
}

TEST_F(ClientOfHost, ADeadHostIsQuotedWithItsLastWords) {
    // Realtime code that prints outside of any halcmd.
    client.command("loadrt message names=m messages=\"the spindle is on fire\"");
    client.command("addf m servo-thread");
    bench.run(0.001);
    bench.set("m.trigger", 1);
    bench.run(0.001);
    kill(client.process(), SIGKILL);
    try {
        bench.run(1);
        ADD_FAILURE() << "it lives";
    } catch (const client::HostDied& death) {
        EXPECT_THAT(death.what(), StartsWith("the virtual-time host died (signal 9); its last words: "));
        EXPECT_THAT(death.what(), HasSubstr("the spindle is on fire"));
    }
    try {
        bench.get("it.in");
        ADD_FAILURE() << "it lives again";
    } catch (const client::HostDied& death) {
        EXPECT_THAT(death.what(), HasSubstr("the spindle is on fire")) << "every call gives the reason";
    }
}

TEST(ClientStart, FailsWithTheReason) {
    client::Start start;
    start.executable = "/no/such/plumb-host";
    EXPECT_THAT(refusal([&] { client::Client client(start); }),
                HasSubstr("cannot start /no/such/plumb-host"));
    start.executable = "/bin/false";
    EXPECT_THROW(client::Client client(start), client::HostDied);
    start.executable = "/bin/ls";  // which prints why it does not understand
    EXPECT_THAT(refusal([&] { client::Client client(start); }), HasSubstr("control-fd"));
}

TEST(ClientStart, ShowsWhatTheHostPrintsOnlyWhenAsked) {
    for (const bool show : {false, true}) {
        client::Start start;
        start.show_output = show;
        testing::internal::CaptureStderr();
        {
            Bench bench(Bench::Thread::servo, start);
            bench.command("loadrt message names=m messages=hello");
            bench.command("addf m servo-thread");
            bench.run(0.001);
            bench.set("m.trigger", 1);
            bench.run(0.001);
        }
        EXPECT_EQ(testing::internal::GetCapturedStderr().find("hello") != std::string::npos, show);
    }
}

TEST(BenchFixture, ABrokenExpectationFailsTheTestOnce) {
    static Bench* bench;  // EXPECT_NONFATAL_FAILURE sees no locals
    const auto owner = std::make_unique<Bench>();
    bench = owner.get();
    bench->command("loadrt lowpass names=it");
    bench->command("addf it servo-thread");
    bench->set("it.gain", 1);
    bench->expect("x_rate < 1", {{"x", "it.out"}});
    bench->run(1);
    bench->set("it.in", 5);
    EXPECT_NONFATAL_FAILURE(bench->run(1),
                            "x_rate < 1 did not hold in 1 periods; first at 1.001 s, x = 5, x_rate = 5000");
    bench->run(1);
}

TEST(BenchFixture, TracesOneRun) {
    Bench bench;
    bench.command("loadrt lowpass names=it");
    bench.command("addf it servo-thread");
    bench.set("it.gain", 0.5);
    bench.set("it.in", 8);
    const Table table = bench.trace(0.003, {"it.out"});
    EXPECT_THAT(table.column("time"), ElementsAre(0, 0.001, 0.002, 0.003));
    EXPECT_THAT(table.column("it.out"), ElementsAre(0, 4, 6, 7));
    EXPECT_THAT(bench.trace(0.002, {"it.out"}, 0.002).column("it.out"), ElementsAre(7, 7.75));
}

TEST(Durations, AreReadInEveryUnit) {
    using client::parse_duration;
    EXPECT_EQ(parse_duration("600"), 10min);
    EXPECT_EQ(parse_duration("10min"), 10min);
    EXPECT_EQ(parse_duration("4h"), 4h);
    EXPECT_EQ(parse_duration("1.5h"), 90min);
    EXPECT_EQ(parse_duration("2d"), 48h);
    EXPECT_EQ(parse_duration("250ms"), 250ms);
    EXPECT_EQ(parse_duration("0.001"), 1ms);
    EXPECT_EQ(parse_duration("25us"), 25us);
    EXPECT_EQ(parse_duration("1e3ns"), 1us);
    EXPECT_EQ(parse_duration("0s"), 0s);
    for (const char* wrong : {"", "s", "-1s", "1 s", "1m", "1h30", "nan", "inf", "1e99h", "0x10", "ten"})
        EXPECT_THROW(parse_duration(wrong), std::invalid_argument) << wrong;
}

TEST(Durations, AreWrittenInTheUnitsThatSuit) {
    using client::describe_duration;
    EXPECT_EQ(describe_duration(4h), "4 h");
    EXPECT_EQ(describe_duration(90min), "1 h 30 min");
    EXPECT_EQ(describe_duration(26h), "1 d 2 h");
    EXPECT_EQ(describe_duration(90s), "1 min 30 s");
    EXPECT_EQ(describe_duration(10min), "10 min");
    EXPECT_EQ(describe_duration(12500ms), "12.5 s");
    EXPECT_EQ(describe_duration(250ms), "250 ms");
    EXPECT_EQ(describe_duration(1us), "1 us");
    EXPECT_EQ(describe_duration(0s), "0 s");
}

}  // namespace
}  // namespace plumb
