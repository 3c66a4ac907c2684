// SPDX-License-Identifier: GPL-2.0-or-later
// chopping takes the axis out of the work: enable has fallen, or an operator wants it at point R.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/chopping_axis.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct ChoppingWithdrawal : ChoppingAxis {
    // The rest of each motion into point R above the stroke: from the work, and with no rest in it.
    void expect_withdrawal(double seconds = 4) {
        const Table trace = bench.trace(seconds, {"chop.command", "chop.withdrawing"});
        const std::vector<double> z = trace.column("chop.command");
        const std::vector<double> withdraws = trace.column("chop.withdrawing");
        std::size_t rests = 0;
        for (std::size_t i = 20; i < z.size() && withdraws[i] != 0; ++i) {
            rests = z[i] == z[i - 1] && z[i] < -8.1 ? rests + 1 : 0;
            ASSERT_LE(rests, 2u) << z[i];
        }
        EXPECT_EQ(withdraws[5], 1);
        EXPECT_LE(hardest(z), 1000 * 1.01);
        EXPECT_GE(*std::min_element(z.begin(), z.end()), -20);
        EXPECT_LE(*std::max_element(z.begin(), z.end()), 0);
        EXPECT_EQ(get("offset"), 0);
        EXPECT_EQ(get("at-end"), 1);
        EXPECT_EQ(get("active"), 0);
        EXPECT_EQ(get("withdrawing"), 0);
    }

    void pulse(const std::string& pin) {
        set(pin, 1);
        bench.run(0.01);
        set(pin, 0);
        bench.run(0.01);
    }
};

TEST_F(ChoppingWithdrawal, ALostEnableTakesTheAxisToRWhateverTheStopKind) {
    set("spark-out", 5);
    set("upper-dwell", 0.3);
    set("lower-dwell", 0.4);
    Random random(31);
    for (int i = 0; i < 60; ++i) {
        SCOPED_TRACE(i);
        set("stop-kind", i % 3);
        start();
        bench.run(random.uniform(0.05, 3));
        const double strokes = get("stroke-count");
        set("enable", 0);
        expect_withdrawal();
        EXPECT_LE(get("stroke-count"), strokes + 2) << "no spark-out";
        EXPECT_EQ(get("fault-code"), 0);

        set("enable", 1);
        for (const double z : commands(0.5)) ASSERT_EQ(z, 0) << "nothing starts by itself";
        set("run", 0);
        bench.run(0.01);
        start();
        bench.run(0.5);
        EXPECT_EQ(get("active"), 1);
        EXPECT_EQ(get("withdrawing"), 0);
        set("enable", 0);
        bench.run(4);
        set("enable", 1);
        set("run", 0);
        bench.run(0.01);
    }
}

TEST_F(ChoppingWithdrawal, AnEnableThatReturnsAndAnotherStopDoNotEndIt) {
    Random random(32);
    for (int i = 0; i < 30; ++i) {
        SCOPED_TRACE(i);
        start();
        bench.run(random.uniform(0.05, 2));
        set("enable", 0);
        bench.run(0.002);
        set("stop-kind", 1 + i % 2);
        if (i % 2 == 0) set("enable", 1);
        if (i % 3 == 0) set("run", 0);
        if (i % 5 == 0) pulse("stop");
        expect_withdrawal();
        set("enable", 1);
        set("run", 0);
        set("stop-kind", 0);
        bench.run(0.01);
    }
}

// The command follows by the mean of jerk-time.
TEST_F(ChoppingWithdrawal, ALostEnableTakesAnAxisToRThatIsAboutToStand) {
    set("jerk-time", 0.1);
    set("stop-kind", 2);
    for (int i = 0; i < 20; ++i) {
        SCOPED_TRACE(i);
        start();
        bench.run(1.3);
        set("run", 0);
        bench.run(0.06 + 0.005 * i);
        if (get("active") == 0) {
            EXPECT_GT(i, 8);
            break;
        }
        set("enable", 0);
        bench.run(2);
        EXPECT_EQ(get("command"), 0);
        set("enable", 1);
    }
}

TEST_F(ChoppingWithdrawal, NoHoldKeepsTheAxisInTheWorkWithoutAnEnable) {
    for (const char* pin : {"feed-hold", "override"})
        for (const bool held : {true, false}) {
            SCOPED_TRACE(std::string(pin) + (held ? ", held" : ", withdrawing"));
            const bool hold = std::string(pin) == "feed-hold";
            start();
            bench.run(1.111);
            if (held) set(pin, hold ? 1 : 0);
            if (held) bench.run(0.5);
            EXPECT_EQ(get("held"), held);
            set("enable", 0);
            bench.run(0.002);
            set(pin, hold ? 1 : 0);
            expect_withdrawal();
            EXPECT_EQ(get("held"), 0);
            set("enable", 1);
            set("run", 0);
            set(pin, hold ? 0 : 1);
            bench.run(0.01);
        }
}

TEST_F(ChoppingWithdrawal, AStartBeforeItsEndIsRefused) {
    start();
    bench.run(1.1);
    set("enable", 0);
    bench.run(0.01);
    set("enable", 1);
    set("run", 0);
    bench.run(0.01);
    start();
    expect_withdrawal();
    EXPECT_EQ(get("fault-code"), 18);
    bench.run(0.5);
    EXPECT_EQ(get("active"), 0);
    set("run", 0);
    bench.run(0.01);
    EXPECT_EQ(get("fault-code"), 18) << "until the next start";
    start();
    bench.run(0.5);
    EXPECT_EQ(get("active"), 1);
    EXPECT_EQ(get("fault-code"), 0);
}

TEST_F(ChoppingWithdrawal, GivesNoInfeedAndTakesOverNoRegion) {
    bench.command("loadrt updown names=infeeds");
    bench.command("net infeed chop.upper-pulse => infeeds.countup");
    bench.command("addf infeeds servo-thread");
    start();
    bench.run(2);
    bench.expect("z >= -20.000001", {{"z", "chop.command"}});
    set("upper", -30);
    set("lower", -60);
    const double infeeds = bench.get("infeeds.count");
    EXPECT_GT(infeeds, 1);
    set("enable", 0);
    bench.run(0.001);
    set("shift", 1);
    expect_withdrawal();
    EXPECT_EQ(bench.get("infeeds.count"), infeeds);
}

TEST_F(ChoppingWithdrawal, GoToEndEndsStrokesByTheSameWayUntilTheNextStart) {
    Random random(33);
    for (int i = 0; i < 30; ++i) {
        SCOPED_TRACE(i);
        set("stop-kind", i % 3);
        start();
        bench.run(random.uniform(0.05, 2));
        const bool stops = i % 4 == 0;  // by run, and not yet ended
        if (stops) set("stop-kind", 0);
        if (stops) set("run", 0);
        set("go-to-end", 1);
        expect_withdrawal();
        for (const double z : commands(0.3)) ASSERT_EQ(z, 0);
        set("go-to-end", 0);
        set("run", 0);
        bench.run(0.01);
    }
}

TEST_F(ChoppingWithdrawal, GoToEndGoesBeforeTheHoldThatIsThereAndALaterOneHolds) {
    start();
    bench.run(1.111);
    set("feed-hold", 1);
    bench.run(0.5);
    const double place = get("command");
    EXPECT_LT(place, -8);
    set("go-to-end", 1);
    bench.run(0.03);
    EXPECT_NE(get("command"), place);
    set("feed-hold", 0);
    bench.run(0.01);
    set("feed-hold", 1);
    bench.run(0.5);
    EXPECT_EQ(get("held"), 1);
    EXPECT_EQ(get("withdrawing"), 1);
    const double second = get("command");
    bench.run(0.5);
    EXPECT_EQ(get("command"), second);
    set("feed-hold", 0);
    expect_withdrawal();
}

TEST_F(ChoppingWithdrawal, GoToEndReturnsFromRestWithoutAnEnableAndWithInvalidSettings) {
    set("stop-kind", 2);
    for (const bool invalid : {false, true}) {
        SCOPED_TRACE(invalid);
        start();
        bench.run(1.05);
        set("run", 0);
        bench.run(0.5);
        const double place = get("command");
        EXPECT_LT(place, -8);
        set("enable", 0);
        if (invalid) set("max-acceleration", -1);
        for (const double z : commands(0.3)) ASSERT_EQ(z, place) << "an axis at rest stays";
        set("go-to-end", 1);
        expect_withdrawal();
        EXPECT_EQ(get("fault-code"), invalid ? 3 : 0);
        set("go-to-end", 0);
        set("max-acceleration", 1000);
        set("enable", 1);
        bench.run(0.01);
    }
}

TEST_F(ChoppingWithdrawal, AFollowingErrorStopsItAndGoToEndReturns) {
    set("max-following-error", 5);
    start();
    bench.run(1.1);
    set("enable", 0);
    bench.run(0.02);
    EXPECT_EQ(get("withdrawing"), 1);
    bench.set("axis.enabled", 0);
    bench.run(1);
    EXPECT_EQ(get("fault-code"), 10);
    EXPECT_EQ(get("active"), 0);
    const double place = get("command");
    EXPECT_LT(place, -0.5);
    for (const double z : commands(1)) ASSERT_EQ(z, place);
    bench.set("axis.enabled", 1);
    bench.run(1);
    set("go-to-end", 1);
    bench.run(3);
    EXPECT_EQ(get("offset"), 0);
    EXPECT_EQ(get("at-end"), 1);
}

// The fault comes first, and the stop that it begins is not taken back.
TEST_F(ChoppingWithdrawal, ALostEnableMovesNoAxisThatAFaultHasStopped) {
    set("max-following-error", 5);
    start();
    bench.run(1.1);
    bench.set("axis.enabled", 0);
    for (int i = 0; i < 1000 && get("fault-code") != 10; ++i) bench.run(dt);
    EXPECT_EQ(get("active"), 1) << "it brakes";
    set("enable", 0);
    bench.run(0.5);
    EXPECT_EQ(get("active"), 0);
    EXPECT_LT(get("command"), -8);
}

TEST_F(ChoppingWithdrawal, MachineOffLeavesItWhereTheAxisStandsAndGoToEndReturns) {
    start();
    bench.run(1.1);
    set("enable", 0);
    bench.run(0.02);
    bench.command("net on chop.motion-enabled axis.enabled");
    bench.set("on", 0);
    bench.run(3 * dt);
    const double place = get("offset");
    for (const double z : commands(0.5)) ASSERT_EQ(z, place);
    bench.set("on", 1);
    for (const double z : commands(0.5)) ASSERT_EQ(z, place);
    set("go-to-end", 1);
    expect_withdrawal();
}

TEST_F(ChoppingWithdrawal, StopEndsStrokesAsRunDoesAndRefusesAStart) {
    for (const int kind : {0, 1, 2}) {
        SCOPED_TRACE(kind);
        set("stop-kind", kind);
        start();
        bench.run(1.05);
        pulse("stop");
        bench.run(2);
        EXPECT_EQ(get("active"), 0);
        const double place = get("command");
        if (kind == 0) {
            EXPECT_EQ(place, 0);
        } else if (kind == 1) {
            EXPECT_LT(std::min(std::abs(place + 8), std::abs(place + 20)), nm);
        } else {
            EXPECT_LT(place, -8);
        }
        for (const double z : commands(0.5)) ASSERT_EQ(z, place) << "it waits for an edge of run";
        set("run", 0);
        set("stop", 1);
        bench.run(0.01);
        start();
        bench.run(0.3);
        EXPECT_EQ(get("fault-code"), 1);
        set("stop", 0);
        for (const double z : commands(0.3)) ASSERT_EQ(z, place);
        set("run", 0);
        pulse("go-to-end");
        bench.run(2);
        EXPECT_EQ(get("fault-code"), 1) << "until the next start";
        EXPECT_EQ(get("at-end"), 1);
    }
}

// A drawn machine under drawn orders. Whatever was before, a lost enable takes a moving axis to R, or to the
// dead point that is clear of the work.
class Drawn {
public:
    explicit Drawn(std::uint64_t seed) : random_(seed) {
        wire(bench_);
        for (const char* line :
             {"loadrt ddt names=speed,growth", "net command => speed.in", "net v speed.out growth.in",
              "addf speed servo-thread", "addf growth servo-thread"})
            bench_.command(line);
        end_ = ends[seed % 5];
        set("position", end_);
        set("max-feed", 120);
        set("max-rate", 150);
        set("spark-out", random_.index(4));
        kind_ = static_cast<int>(seed / 5 % 3);
        set("abort-kind", kind_);
        if (random_.index(2) == 0) set("jerk-time", random_.uniform(0.002, 0.03));
        if (random_.index(2) == 0) {
            set("lower-dwell", random_.uniform(0, 0.3));
            set("upper-dwell", random_.uniform(0, 0.3));
        }
        if (random_.index(2) == 0) {
            set("section-0-kind", 2);
            set("section-0-from", -16);
            set("section-0-to", -11);
            set("section-0-ratio", random_.uniform(0.3, 2));
        }
        bench_.set("chop.learn", random_.index(3) == 0);
        lowest_ = std::min({-20.0, end_});
        highest_ = std::max({-8.0, end_});
        bench_.run(0.01);
        bench_.expect("abs(a) <= 1010", {{"a", "growth.out"}});
        bench_.expect("abs(v) <= 120.001", {{"v", "speed.out"}});
        // A learned end may lie outside.
        bench_.expect(
            "z >= " + std::to_string(lowest_ - more) + " && z <= " + std::to_string(highest_ + more),
            {{"z", "chop.command"}});
    }

    void work(int orders) {
        for (int i = 0; i < orders && !testing::Test::HasFatalFailure(); ++i) {
            if (get("active") == 0) start();
            bench_.run(random_.uniform(0, 1.5));
            order();
            bench_.run(random_.uniform(0, 0.7));
            if (random_.index(4) == 0) lose();
        }
    }

    int losses() const { return losses_; }  // while it moved

private:
    static constexpr double inset = 0.61;  // mm, of an end that is not learned: 5 % of the stroke
    static constexpr double more = 1, ends[] = {0, -40, -8, -20, -14};

    void set(const std::string& pin, double value) { bench_.set("chop." + pin, value); }
    double get(const std::string& pin) { return bench_.get("chop." + pin); }

    void start() {
        set("run", 0);
        bench_.run(0.002);
        set("run", 1);
    }

    // The first three start strokes.
    void order(int first = 0) {
        switch (first + random_.index(8 - first)) {
            case 0:
            case 1: start(); break;
            case 2: set("run", random_.index(2)); break;
            case 3: set("stop-kind", random_.index(3)); break;
            case 4: set("feed-hold", random_.index(3) == 0); break;
            case 5: {
                const double parts[] = {1, 1, 0.7, 0.3, 0};
                set("override", parts[random_.index(5)]);
                break;
            }
            case 6: set("go-to-end", random_.index(2)); break;
            case 7:
                set("stop", 1);
                bench_.run(0.002);
                set("stop", 0);
                break;
        }
    }

    void lose() {
        const bool moves = get("active") != 0;
        const double place = get("command");
        set("enable", 0);
        bench_.run(0.001);
        if (moves && random_.index(3) == 0) set("enable", 1);
        if (moves && random_.index(2) == 0) order(3);
        const std::vector<double> z = bench_.trace(0.3, {"chop.command"}).column("chop.command");
        for (int i = 0; i < 600 && get("active") != 0; ++i) order_and_run(moves);
        if (moves) {
            const double rests = get("command");
            const bool clear = kind_ == 1 ? rests <= -20 + inset : kind_ == 2 && rests >= -8 - inset;
            if (!clear) {
                ASSERT_NEAR(rests, end_, nm);
            }
            const bool end_is_clear = kind_ == 0 || (kind_ == 1 ? end_ <= -20 : end_ >= -8);
            if (end_is_clear) {
                ASSERT_EQ(get("at-end"), 1);
            }
            ++losses_;
        } else if (get("at-end") == 0) {
            ASSERT_EQ(z.back(), place);
        }
        bench_.run(0.1);
        set("enable", 1);
    }

    // It may rest only where it turns, and nothing that an operator orders makes it rest elsewhere.
    void order_and_run(bool moves) {
        if (random_.index(3) == 0) set("stop-kind", random_.index(3));
        const std::vector<double> z = bench_.trace(0.1, {"chop.command"}).column("chop.command");
        std::size_t rests = 0;
        for (std::size_t i = 1; moves && i < z.size(); ++i) {
            const bool works = z[i] > -19 && z[i] < -9 && std::abs(z[i] - end_) > 1e-9;
            rests = works && z[i] == z[i - 1] ? rests + 1 : 0;
            ASSERT_LE(rests, 2u) << z[i];
        }
    }

    Random random_;
    Bench bench_;
    double end_ = 0, lowest_ = 0, highest_ = 0;
    int losses_ = 0, kind_ = 0;
};

TEST(ChoppingWithdrawalDrawn, NoSequenceOfOrdersKeepsTheAxisFromRAfterALoss) {
    int losses = 0;
    for (int seed = 1; seed <= 15; ++seed) {
        SCOPED_TRACE(seed);
        Drawn drawn(static_cast<std::uint64_t>(7 * seed));
        drawn.work(60);
        losses += drawn.losses();
        if (testing::Test::HasFailure()) break;
    }
    EXPECT_GT(losses, 40);
}

}  // namespace
}  // namespace plumb
