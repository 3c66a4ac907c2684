// SPDX-License-Identifier: GPL-2.0-or-later
// A scale slips on drawn axes, at drawn moments of their strokes. `scripts/campaign strokes` goes on with
// other seeds.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/rounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>

namespace plumb {
namespace {

// How the scale is netted, and how it slips.
struct Way {
    bool in_the_loop = false;  // the position loop closes on it
    bool slowly = false;       // in 0.05 to 0.5 s, else in a period
    bool motor = false;        // the encoder of the motor is netted, too
    double least = 0.01;       // mm, of a slip
};

constexpr Way ways[] = {
    {false, false, false, 0.01}, {true, false, false, 0.01}, {false, true, false, 0.01},
    {false, true, true, 0.02},   {true, true, true, 0.02},   {true, false, true, 0.02},
};

// A drawn axis that strokes between 0 and its length, and learns.
class SlippingAxis {
public:
    SlippingAxis(std::uint64_t seed, const Way& way) : random_(seed), way_(way) {
        const bool grinder = random_.index(2) == 0;
        bench_.command(grinder ? "loadrt sim_grinder names=axis" : "loadrt sim_elastic_axis names=axis");
        for (const char* line : {"loadrt chopping names=chop interlock=no sections=4",
                                 "loadrt sum2 names=scale,drive",
                                 "loadrt limit2 names=creep",
                                 "net slip creep.out => scale.in1 drive.in1",
                                 "net command chop.command => drive.in0",
                                 "net driven drive.out => axis.position-cmd",
                                 "net position axis.position => scale.in0",
                                 "net measured scale.out => chop.joint-feedback",
                                 "setp chop.min-limit -500",
                                 "setp chop.max-limit 500",
                                 "setp chop.homed 1",
                                 "setp chop.motion-enabled 1",
                                 "setp chop.learn 1",
                                 "setp chop.jerk-time 0.01",
                                 "setp chop.max-correction 3",
                                 "addf creep servo-thread",
                                 "addf scale servo-thread",
                                 "addf chop.update servo-thread",
                                 "addf drive servo-thread",
                                 "addf axis.update servo-thread"})
            bench_.command(line);
        if (grinder) bench_.set("axis.load-resonance", 0);
        if (way_.motor) bench_.command("net position chop.motor-feedback");
        bench_.set("axis.seed", 1 + random_.index(1000));
        bench_.set("drive.gain1", way_.in_the_loop ? -1 : 0);
        length_ = random_.uniform(10, 40);
        const double acceleration = random_.uniform(200, 600), feed = std::sqrt(acceleration * length_ / 2);
        cycle_ = 3.1416 * length_ / feed;
        set("upper", length_);
        set("feed", feed);
        set("max-acceleration", acceleration * 1.2);
        bench_.run(0.01);
        set("run", 1);
    }

    // Whether it has learned, without a fault.
    bool learns() {
        for (int i = 0; i < 200 && get("learned") == 0 && get("fault") == 0; ++i) bench_.run(0.5);
        bench_.run(random_.uniform(1, 2) * cycle_);
        return get("learned") != 0 && get("fault") == 0;
    }

    double fault() { return get("fault-code"); }

    void slip() {
        const double size = std::exp(random_.uniform(std::log(way_.least), std::log(0.3)));
        const double slip = random_.index(2) ? size : -size,
                     before[] = {get("upper-correction"), get("lower-correction")};
        bench_.set("creep.maxv", way_.slowly ? size / random_.uniform(0.05, 0.5) : 1e9);
        bench_.set("creep.in", slip);
        await_stop();
        if (get("fault-code") == 21) {  // a slow one is a jam at first
            start();
            await_stop();
        }
        SCOPED_TRACE(std::to_string(slip) + " mm, fault " + std::to_string(get("fault-code")));
        const double beyond =
            std::max(bench_.get("axis.truth-upper") - length_, -bench_.get("axis.truth-lower"));
        if (get("active") != 0) {
            EXPECT_LE(beyond, 5 * um) << "untold";
        } else {
            EXPECT_EQ(get("fault-code"), 19);
            if (get("stroke-count") >= 2) {  // it shows its corrections
                EXPECT_LE(get("upper-correction"), before[0] + 3 * um);
                EXPECT_LE(get("lower-correction"), before[1] + 3 * um);
            }
            start();
            EXPECT_EQ(get("active"), 0) << "it is asked";
        }
        home_again();
    }

private:
    void set(const std::string& pin, double value) { bench_.set("chop." + pin, value); }
    double get(const std::string& pin) { return bench_.get("chop." + pin); }
    void await_stop() {
        for (int i = 0; i < 200 && get("active") != 0; ++i) bench_.run(0.1 * cycle_);
    }
    void start() {
        set("run", 0);
        bench_.run(0.01);
        while (get("active") != 0) bench_.run(0.1);
        set("run", 1);
        bench_.run(0.1);
    }
    void home_again() {
        set("run", 0);
        while (get("active") != 0) bench_.run(0.1);
        set("homed", 0);
        bench_.set("creep.maxv", 1e9);
        bench_.set("creep.in", 0);
        bench_.run(1);
        set("homed", 1);
        start();
    }

    Random random_;
    Way way_;
    Bench bench_;
    double length_ = 0, cycle_ = 0;
};

TEST(ChoppingSlipsAttack, NoSlipOfAScaleTakesAnAxisBeyondADeadPointUntold) {
    const char* const given = std::getenv("CHOPPING_SEED");
    const std::uint64_t first = given ? std::strtoull(given, nullptr, 10) : 1;
    const int slips = given ? 12 : 3;
    int tries = 0;
    for (std::size_t way = 0; way < std::size(ways); ++way) {
        SCOPED_TRACE("way " + std::to_string(way));
        SlippingAxis axis(first * 100 + way, ways[way]);
        if (!axis.learns()) {  // a drive that is too weak, which it says
            EXPECT_NE(axis.fault(), 19) << "nothing has slipped";
            continue;
        }
        for (int i = 0; i < slips; ++i, ++tries) {
            axis.slip();
            EXPECT_TRUE(axis.learns()) << "after homing, fault " << axis.fault();
            if (testing::Test::HasFailure()) return;
        }
    }
    std::cout << "cases: " << tries << "\n";
    EXPECT_GT(tries, 2 * slips);
}

}  // namespace
}  // namespace plumb
