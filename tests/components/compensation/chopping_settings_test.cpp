// SPDX-License-Identifier: GPL-2.0-or-later
// Each setting of chopping changes in each phase of its strokes. `scripts/campaign strokes` goes on with
// other seeds.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/chopping_axis.hpp"
#include "tests/support/hal_pins.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace plumb {
namespace {

// Further values of each setting, possible and impossible ones.
const std::map<std::string, std::vector<double>> settings{
    {"upper", {-4, -25, 1e7}},
    {"lower", {-30, -6}},
    {"by-centre", {1}},
    {"centre", {-10}},
    {"stroke", {10}},
    {"speed-kind", {1, 2, 4, 9}},
    {"feed", {30, 5, 110, 1e5, -1}},
    {"frequency", {1, 0}},
    {"cycle-time", {1, 0}},
    {"override", {0.3, 0, 1.5, 3, -1}},
    {"lower-dwell", {0.1, -1}},
    {"upper-dwell", {0.1, 1e5}},
    {"exact-stop", {0.01, -1}},
    {"exact-stop-time", {0.01, 0}},
    {"strokes", {1, 3, -1}},
    {"spark-out", {2, -1}},
    {"upward-first", {1}},
    {"stop-kind", {0, 1, 2, 3, 4, 9}},
    {"hold-kind", {0, 9}},
    {"abort-kind", {1, 2, 9}},
    {"without-wheel", {1}},
    {"at-speed-time", {0, -1}},
    {"refuse-slower", {1}},
    {"section-0-kind", {0, 1, 3, 4, 9}},
    {"section-0-from", {-19, -10}},
    {"section-0-to", {-9, -17}},
    {"section-0-ratio", {0.1, 3, -1}},
    {"section-1-kind", {2, 3}},
    {"section-1-from", {-15}},
    {"section-1-to", {-9}},
    {"section-1-ratio", {3}},
    {"max-feed", {80, 20, -1}},
    {"max-acceleration", {400, 10, -1}},
    {"jerk-time", {0.01, 0.05, 1}},
    {"lead", {0.002, 0.01, 0.5}},
    {"max-lead", {0.001, -1}},
    {"max-output-accel", {500, 1e8}},
    {"min-limit", {-21, -10}},
    {"max-limit", {0, -10}},
    {"taper", {3, 200}},
    {"max-offset", {25, 19, 5, 0, -1}},
    {"max-rate", {61, 10, 1e7}},
    {"learn", {0, 1}},
    {"gain", {0.1, 2}},
    {"inset", {0, 2, -1}},
    {"max-correction", {0, 1e5}},
    {"tolerance", {0, 1}},
    {"max-beyond", {0, 1}},
    {"max-drift", {0}},
    {"max-following-error", {5, 0.01, -1}},
    {"infeed-amount", {0.02, 0, -0.06, 1e7}},
    {"infeed-total", {0.05, 0, 2, -1}},
    {"infeed-clear", {0, 1, 3, 9}},
    {"infeed-max-amount", {0.005, 0, -1}},
    {"infeed-max-offset", {0.05, 0, -1}},
    {"infeed-max-rate", {0.05, 0, 1e7}},
    {"infeed-max-accel", {2, 0, 1e10}},
    {"infeed-min-limit", {-0.03, 20}},
    {"infeed-max-limit", {-20, 0}},
    {"infeed-tolerance", {0, -1}},
    {"infeed-clearance", {0, -1}},
};

// Inputs that are orders, measurements or records.
const std::set<std::string> others{"run",
                                   "stop",
                                   "enable",
                                   "motion-enabled",
                                   "spindle-on",
                                   "spindle-at-speed",
                                   "homed",
                                   "joint-velocity",
                                   "feed-hold",
                                   "emergency-hold",
                                   "go-to-end",
                                   "shift",
                                   "shift-at-crossing",
                                   "crossing-position",
                                   "crossing-at",
                                   "program-running",
                                   "outlast",
                                   "position",
                                   "joint-feedback",
                                   "motor-feedback",
                                   "applied-offset",
                                   "stage-limited",
                                   "stage-released",
                                   "program-word",
                                   "program-value",
                                   "infeed-end",
                                   "infeed-position",
                                   "infeed-feedback",
                                   "infeed-applied",
                                   "row",
                                   "forget",
                                   "restore",
                                   "kept"};

enum class Phase { rest_at_r, first_way, stroking, stopping, returning, held, rest_away, count };

struct Case {
    std::string setting;
    double value;
    Phase phase;
};

std::vector<Case> cases() {
    std::vector<Case> result;
    for (const auto& [setting, values] : settings)
        for (const double value : values)
            for (int phase = 0; phase < static_cast<int>(Phase::count); ++phase)
                result.push_back({setting, value, static_cast<Phase>(phase)});
    return result;
}

// An extra joint that strokes from -20 to -8 below R, with a section, at most at 120 mm/s.
struct Axis {
    bool learned = false, leads = false;
    bool feeds = false;  // another axis feeds in by 10 um at each upper dead point

    friend void PrintTo(const Axis& its, std::ostream* out) {
        *out << (its.learned ? "learned" : its.leads ? "leads" : its.feeds ? "feeds in" : "plain");
    }
};

class Attacked {
public:
    Attacked(std::uint64_t seed, const Axis& axis) : random_(seed) {
        const auto& [learned, leads, feeds] = axis;
        wire(bench_);
        for (const char* line : {"setp chop.max-feed 120",
                                 "setp chop.max-rate 150",
                                 "setp chop.section-0-kind 2",
                                 "setp chop.section-0-from -16",
                                 "setp chop.section-0-to -12",
                                 "setp chop.section-0-ratio 0.6",
                                 "setp chop.section-1-from -19",
                                 "setp chop.section-1-to -18",
                                 "setp chop.section-1-ratio 2",
                                 "loadrt ddt names=speed,growth,infeed-speed,infeed-growth",
                                 "net command => speed.in",
                                 "net v speed.out growth.in",
                                 "addf speed servo-thread",
                                 "addf growth servo-thread",
                                 "net infeed chop.infeed-offset => infeed-speed.in",
                                 "net infeed => chop.infeed-applied",
                                 "net infeed-v infeed-speed.out infeed-growth.in",
                                 "addf infeed-speed servo-thread",
                                 "addf infeed-growth servo-thread",
                                 "setp chop.infeed-min-limit -10",
                                 "setp chop.infeed-max-limit 10"})
            bench_.command(line);
        if (feeds) {
            set("infeed-amount", -0.01);
            set("infeed-total", 1);
            set("infeed-clear", 2);
        }
        if (leads) {
            set("lead", 0.005);
            set("jerk-time", 0.02);
        }
        bench_.run(0.01);
        // A learned end may lie outside, and a lead passes R by a lead^2 / 2.
        const std::string beyond = learned ? "1" : leads ? "0.0126" : "1e-9";
        bench_.expect(leads ? "abs(a) <= 3030" : "abs(a) <= 1010", {{"a", "growth.out"}});
        bench_.expect(leads ? "abs(v) <= 150.001" : "abs(v) <= 120.001", {{"v", "speed.out"}});
        bench_.expect("z >= -20 - " + beyond + " && z <= " + beyond, {{"z", "chop.command"}});
        bench_.expect("z >= -20.005 && z <= 0.005", {{"z", "axis.truth-position"}});
        bench_.expect("abs(x) <= 1", {{"x", "infeed-speed.in"}});
        bench_.expect("abs(v) <= 1.001", {{"v", "infeed-speed.out"}});
        bench_.expect("abs(a) <= 50.1", {{"a", "infeed-growth.out"}});
        if (learned) learn();
        for (const auto& [setting, values] : settings) usual_[setting] = get(setting);
    }

    // The setting has another value for a while, and its own one again. Now and then another one has, too.
    void attack(const Case& its, const Case& other) {
        enter(its.phase);
        const bool rests = its.phase == Phase::rest_at_r || its.phase == Phase::rest_away;
        const bool both = random_.index(2) == 0;
        change(its.setting, its.value, rests);
        if (both) change(other.setting, other.value, rests);
        if (!rests) bench_.run(random_.uniform(0.01, 1.2));
        change(its.setting, usual_[its.setting], rests);
        if (both) change(other.setting, usual_[other.setting], rests);
        leave();
    }
    const Case& any_of(const std::vector<Case>& all) {
        return all[static_cast<std::size_t>(random_.index(static_cast<int>(all.size())))];
    }

private:
    void set(const std::string& pin, double value) { bench_.set("chop." + pin, value); }
    double get(const std::string& pin) { return bench_.get("chop." + pin); }

    void learn() {
        set("learn", 1);
        set("run", 1);
        bench_.run(40);
        ASSERT_EQ(get("learned"), 1);
        set("run", 0);
        await("at-end", 10);
    }

    void change(const std::string& setting, double value, bool rests) {
        if (!rests) return set(setting, value);
        const double place = get("command");
        set(setting, value);
        for (const double z : bench_.trace(0.02, {"chop.command"}).column("chop.command"))
            EXPECT_EQ(z, place);
    }

    void enter(Phase phase) {
        if (phase == Phase::rest_at_r) return;
        set("run", 1);
        bench_.run(random_.uniform(0.01, 0.3));
        ASSERT_EQ(get("active"), 1) << get("fault-code");
        if (phase == Phase::first_way) return;
        bench_.run(random_.uniform(0.3, 1.5));
        if (phase == Phase::stopping) set("run", 0);
        if (phase == Phase::returning) set("enable", 0);
        if (phase == Phase::stopping || phase == Phase::returning) bench_.run(random_.uniform(0.001, 0.7));
        if (phase == Phase::held) {
            set("feed-hold", 1);
            await("held", 10);
        }
        if (phase != Phase::rest_away) return;
        set("stop-kind", 1);
        set("run", 0);
        bench_.run(0.01);
        await_not("active", 10);
        set("stop-kind", usual_["stop-kind"]);
        bench_.run(0.01);
        ASSERT_EQ(get("at-end"), 0);
    }

    // To R by its own, or by an order where the setting has left the axis elsewhere.
    void leave() {
        for (const char* order : {"feed-hold", "run"}) set(order, 0);
        set("enable", 1);
        bench_.run(0.01);
        await_not("active", 30);
        set("go-to-end", 1);
        await("at-end", 30);
        set("go-to-end", 0);
        bench_.run(0.01);
    }

    void await(const std::string& pin, double longest) {
        for (int i = 0; i < longest / 0.05 && get(pin) == 0; ++i) bench_.run(0.05);
        ASSERT_NE(get(pin), 0) << pin;
    }
    void await_not(const std::string& pin, double longest) {
        for (int i = 0; i < longest / 0.05 && get(pin) != 0; ++i) bench_.run(0.05);
        ASSERT_EQ(get(pin), 0) << pin;
    }

    Random random_;
    Bench bench_;
    std::map<std::string, double> usual_;
};

// Every so many of the cases, from the first one that the seed gives.
void attack_every(int stride, std::uint64_t seed, const Axis& its) {
    Attacked axis(seed, its);
    const std::vector<Case> all = cases();
    std::cout << "cases: " << all.size() / static_cast<std::size_t>(stride) << "\n";
    for (std::size_t i = seed % static_cast<std::uint64_t>(stride); i < all.size();
         i += static_cast<std::size_t>(stride)) {
        SCOPED_TRACE(all[i].setting + " " + std::to_string(all[i].value) + " in phase " +
                     std::to_string(static_cast<int>(all[i].phase)));
        const Case& other = axis.any_of(all);
        SCOPED_TRACE(other.setting + " " + std::to_string(other.value));
        axis.attack(all[i], other);
        if (testing::Test::HasFailure()) return;
    }
}

struct ChoppingSettingsAttack : testing::TestWithParam<Axis> {};

TEST_P(ChoppingSettingsAttack, NoSettingThatChangesInAnyPhaseBreaksALimitOrMovesAnAxisAtRest) {
    const char* const seed = std::getenv("CHOPPING_SEED");
    if (seed)
        attack_every(1, std::strtoull(seed, nullptr, 10), GetParam());
    else
        attack_every(9, 1, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Strokes, ChoppingSettingsAttack,
                         testing::Values(Axis{}, Axis{true}, Axis{false, true}, Axis{false, false, true}));

TEST(ChoppingSettingsAttack, LeavesOutNoSetting) {
    Bench bench;
    bench.command("loadrt chopping names=chop interlock=no sections=4 infeed=1");
    int count = 0;
    for (const auto& [name, wired] : wiring(bench)) {
        const std::string pin = name.substr(name.find('.') + 1);
        if (wired.output || name.find("chop.") != 0 || pin.find("restore-") == 0 || others.count(pin) > 0)
            continue;
        const std::string like =
            pin.find("section-") == 0 && pin[8] > '1' ? "section-1" + pin.substr(9) : pin;
        EXPECT_EQ(settings.count(like), 1u) << pin;
        ++count;
    }
    EXPECT_GT(count, 50);
}

}  // namespace
}  // namespace plumb
