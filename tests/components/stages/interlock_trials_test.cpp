// SPDX-License-Identifier: GPL-2.0-or-later
// A trial beside everything else that a machine does: functions that have passed or not, are on, change their
// offsets or wait with one. The client lets go, is killed, hangs or runs into the emergency stop. Nothing
// moves but the stage on trial.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace plumb {
namespace {

constexpr double ramp = 0.1;    // mu/s, of the stages
constexpr double still = 1e-9;  // mu
const std::array<std::string, 3> stages{"x-stage", "y-stage", "z-stage"};

// Functions 0 and 1 share the stages of X and Y, each with a source; other sources are the ones of strangers.
// The stage of Z is one of an axis, with an offset that waits.
class Shop {
public:
    explicit Shop(std::uint64_t seed) : random_(seed), bench_(Bench::Thread::none, with_specimens()) {
        for (const char* line :
             {"loadrt threads name1=servo-thread period1=1000000",
              "loadrt lowpass names=motion-command-handler,motion-controller,x-drive,y-drive",
              "loadrt squareness names=square,other",
              "loadrt joint_offset names=x-stage,y-stage",
              "loadrt axis_offset names=z-stage",
              "loadrt external_offset names=z-axis",
              "loadrt interlock names=interlock functions=2 stages=3",
              "loadrt or2 names=power,homing",
              "addf power servo-thread",
              "addf homing servo-thread",
              "net on power.out interlock.motion-enabled z-axis.on",
              "net homed homing.out interlock.all-homed z-stage.all-homed z-axis.homed",
              "net z-request z-axis.request z-stage.offset-request",
              "net z-offset z-axis.offset z-stage.offset-in-force",
              "net z-enabled z-axis.enabled z-stage.motion-enabled",
              "net z-counts z-stage.counts z-axis.counts",
              "net z-scale z-stage.counts-scale z-axis.scale",
              "net z-enable z-stage.offset-enable z-axis.enable",
              "net trial interlock.trial x-stage.trial y-stage.trial z-stage.trial",
              "setp interlock.function-stages-0 3",
              "setp interlock.function-stages-1 3",
              "setp interlock.function-services-0 0",
              "setp interlock.function-services-1 0",
              "setp interlock.trial-limit 0.05",
              "setp interlock.commissioning true",
              "setp power.in0 1",
              "setp homing.in0 1"})
            bench_.command(line);
        for (int i = 0; i < 3; ++i) {
            const std::string n = std::to_string(i), stage = stages[i];
            bench_.command("net " + stage + "-permit interlock.stage-permit-" + n + " " + stage + ".permit");
            bench_.command("net " + stage + "-state " + stage + ".state interlock.stage-state-" + n);
        }
        for (const std::string letter : {"x", "y"}) {
            const std::string stage = letter + "-stage";
            bench_.command("net " + letter + "-cmd " + stage + ".drive-command " + letter + "-drive.in");
            bench_.command("net " + letter + "-0 square." + letter + "-correction " + stage + ".offset-0");
            bench_.command("net " + letter + "-1 other." + letter + "-correction " + stage + ".offset-1");
            bench_.command("net on " + stage + ".motion-enabled");
            bench_.command("net homed " + stage + ".homed");
            for (const char* setting :
                 {"min-limit -100", "max-limit 100", "joint-acceleration 2000", "offset-acceleration 1000"})
                bench_.command("setp " + stage + "." + setting);
        }
        int number = 0;
        for (const std::string name : {"square", "other"}) {
            const std::string n = std::to_string(number++);
            bench_.command("net " + name + "-permit interlock.function-permit-" + n + " " + name + ".permit");
            bench_.command("net " + name + "-state " + name + ".state interlock.function-state-" + n);
            for (const char* setting : {"all-homed true", "max-speed 100", "z-position 100"})
                bench_.command("setp " + name + "." + setting);
        }
        for (const char* function :
             {"motion-command-handler", "z-axis.update", "x-stage.update-feedback", "y-stage.update-feedback",
              "motion-controller", "square.update", "other.update", "x-stage.update", "y-stage.update",
              "z-stage.update", "interlock.update", "x-drive", "y-drive"})
            bench_.command(std::string("addf ") + function + " servo-thread");
        bench_.command("start");
        bench_.run(4);
    }

    // One trial, from drawn states to the return of the stage.
    void attempt() {
        const bool of_function = random_.index(3) == 0;
        const auto number = static_cast<std::size_t>(random_.index(of_function ? 2 : 3));
        draw_states(of_function, number);
        for (const char* pin : {"trial-stage", "trial-function"}) set(pin, -1);
        set("spindle-speed", 0);
        set("trial-measures", 0);
        bench_.run(random_.uniform(0.02, 1));  // also sooner than a beat is forgotten
        SCOPED_TRACE((of_function ? "function " : "stage ") + std::to_string(number));
        const double size = random_.uniform(-0.05, 0.05);
        set("trial-offset", of_function ? 0 : size);
        set(of_function ? "trial-function" : "trial-stage", static_cast<double>(number));
        bench_.run(random_.uniform(0.001, 0.2));
        press(0.02);
        // While somebody presses, all else goes on changing.
        const double pressed = random_.uniform(0.3, 1.5);
        const auto held = of_function ? std::array<bool, 3>{false, false, true} : all_but(number);
        for (double time = 0; time < pressed; time += 0.1) {
            disturb(of_function ? static_cast<int>(number) : -1);
            stand(press(0.1), held, "while somebody presses");
        }
        if (!of_function && number < 2) {  // no cycle arms it, and nothing else is in it
            const double reached = std::abs(bench_.get(stages[number] + ".applied-offset"));
            EXPECT_LE(reached, std::abs(size) + still) << "beyond the press";
            EXPECT_GE(reached, std::min(std::abs(size), ramp * (pressed - 0.1)) - still) << "it was pressed";
        }
        const bool went_on = end();
        bench_.run(went_on ? 0.02 : 0.5 + 0.02);
        if (!of_function) {
            bench_.run(std::abs(size) / ramp + 0.3);
            for (int i = 0; i < 5; ++i) {  // a beat that comes again begins nothing
                beat();
                bench_.run(0.1);
            }
            EXPECT_LE(std::abs(bench_.get(stages[number] + ".applied-offset")), 2e-4) << "it has not passed";
        } else {
            EXPECT_EQ(bench_.get("interlock.function-enable-" + std::to_string(number)), 0);
        }
        bench_.set("power.in0", 1);
    }

private:
    void set(const std::string& pin, double value) { bench_.set("interlock." + pin, value); }
    void beat() { set("trial-beat", beats_ = !beats_); }

    static std::array<bool, 3> all_but(std::size_t number) {
        std::array<bool, 3> held{true, true, true};
        held[number] = false;
        return held;
    }

    Table press(double seconds) {
        beat();
        return bench_.trace(seconds,
                            {"x-stage.applied-offset", "y-stage.applied-offset", "z-stage.applied-offset"});
    }

    // The stage or function on trial has not passed, as plumb commission takes its pass back; of all others a
    // part has.
    void draw_states(bool of_function, std::size_t number) {
        const auto pass = [&](const std::string& what, std::size_t n, bool passed) {
            const std::string digit = std::to_string(n);
            set(what + "-passed-" + digit,
                passed ? bench_.get("interlock." + what + "-identity-" + digit) : 0);
        };
        for (std::size_t i = 0; i < 3; ++i)
            pass("stage", i, of_function ? i < 2 || random_.index(2) : i != number && random_.index(4));
        for (std::size_t i = 0; i < 2; ++i) {
            pass("function", i, !(of_function && i == number) && random_.index(4));
            set("function-switch-" + std::to_string(i), of_function || random_.index(4));
        }
        set("cycle-running", 0);
        for (const std::string& stage : stages) bench_.set(stage + ".offset-2", 0);
        disturb(-1);
        set("cycle-running", random_.index(2));  // which arms the stage of Z, if a function may act
        bench_.run(random_.uniform(0.2, 1));
        set("cycle-running", 0);
        if (!of_function && number < 2)
            for (const char* pin : {".offset-2"})
                bench_.set(stages[number] + pin, random_.uniform(-0.9, 0.9));
    }

    // Other functions than `but` change their corrections; the offset of Z waits with another value.
    void disturb(int but) {
        if (but != 0) bench_.set("square.eb0z", random_.uniform(-2e-4, 2e-4));
        if (but != 1) bench_.set("other.ea0z", random_.uniform(-2e-4, 2e-4));
        bench_.set("z-stage.offset-0", random_.uniform(-0.05, 0.05));
        if (random_.index(2)) bench_.set("z-stage.offset-2", random_.uniform(-0.05, 0.05));
    }

    static void stand(const Table& table, const std::array<bool, 3>& held, const char* when) {
        for (std::size_t i = 0; i < 3; ++i) {
            if (!held[i]) continue;
            const std::vector<double> place = table.column(stages[i] + ".applied-offset");
            for (const double now : place) ASSERT_NEAR(now, place.front(), still) << stages[i] << " " << when;
        }
    }

    // Somebody lets go; the program is killed; it hangs and wakes; the machine goes off; the spindle starts.
    // Returns whether the beat went on.
    bool end() {
        switch (random_.index(5)) {
            case 0:
                set("trial-stage", -1);
                set("trial-function", -1);
                return false;
            case 1: return false;
            case 2:
                bench_.run(0.7);
                beat();
                return false;
            case 3:
                bench_.set("power.in0", 0);
                press(0.1);
                bench_.set("power.in0", 1);
                go_on();
                return true;
            default:
                set("spindle-speed", random_.uniform(-3000, 3000));
                press(0.1);
                set("spindle-speed", 0);
                go_on();
                return true;
        }
    }

    // Somebody still presses.
    void go_on() {
        for (int i = 0; i < 5; ++i) press(0.1);
    }

    Random random_;
    Bench bench_;
    bool beats_ = false;
};

TEST(InterlockTrials, NothingMovesButTheStageOnTrialAndItReturnsHoweverThePressEnds) {
    const char* const given = std::getenv("TRIALS_SEED");
    const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : 1;
    const int tries = given != nullptr ? 60 : 20;
    Shop shop(seed);
    for (int i = 0; i < tries && !testing::Test::HasFailure(); ++i) {
        SCOPED_TRACE("try " + std::to_string(i) + " of seed " + std::to_string(seed));
        shop.attempt();
    }
    std::printf("cases: %d\n", tries);
}

}  // namespace
}  // namespace plumb
