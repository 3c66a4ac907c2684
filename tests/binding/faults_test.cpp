// SPDX-License-Identifier: GPL-2.0-or-later
// Random sequences of faults, toggles and returns against everything that moves an axis, shrunk to the
// shortest one that breaks a rule. RC_PARAMS gives seed and length, as in RC_PARAMS="seed=7
// max_success=1000".
#include "components/math/blocks/pi.hpp"
#include "tests/support/attack.hpp"
#include "tests/support/impossible.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"

#include <rapidcheck.h>
#include <rapidcheck/state.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <optional>
#include <set>

namespace plumb {
namespace {

// All that moves an axis in one HAL: a portal with thermal growth, its corrections, both stages, motion and
// drives.
void bring_all_to_life(Bench& bench) {
    bench.source(source_folder() + "/configs/mill/bench.hal");
    bench.source(source_folder() + "/tests/support/all_live.hal");
    bench.set("program.cycle-interval", 60);
    bench.command("start");
    bench.run(71);
}

const Live all_live{{{"thermal_displacement", "growth"},
                     {"axis_offset", "z-offset-stage"},
                     {"squareness", "square"},
                     {"joint_offset", "x-stage"},
                     {"joint_offset", "y-stage"}},
                    bring_all_to_life,
                    3,
                    5,
                    {{{"x-motion.on", {1, 0}},
                      {"y-motion.on", {1, 0}},
                      {"x-motion.home", {1, 0}},
                      {"z-axis.on", {1, 0}},
                      {"z-homed", {1, 0}},
                      {"x-path.offset", {0, 80, -80}, true},
                      {"x-path.amplitude", {20, 0, 150}, true},
                      {"y-path.offset", {0, 80, -80}, true},
                      {"tools.amplitude", {50, 0}}},
                     {"ramp-rate", "offset-2", "offset-3"},
                     {}}};

// The state: the values of the pins in focus, by number; the length of the sequence is rapidcheck's.
struct Model {
    const Live* live = nullptr;
    std::vector<Attackable> pins;
    std::vector<std::size_t> knobs;
    std::set<std::size_t> given;
};
using Command = rc::state::Command<Model, Attack>;

double seconds_to_wait() {
    return *rc::gen::element(0.001, 0.001, 0.002, 0.003, 0.01, 0.05, 0.2, 0.5, 1.5);
}

void expect_no_complaint(Attack& attack) {
    const std::vector<std::string> complaints = attack.complaints();
    if (complaints.empty()) return;
    std::string all;
    for (const std::string& each : complaints) all += each + "\n";
    RC_FAIL(all);
}

struct Give final : Command {
    explicit Give(const Model& model) : wait(seconds_to_wait()) {
        RC_PRE(!model.pins.empty());
        index = *rc::gen::inRange<std::size_t>(0, model.pins.size());
        const Attackable& target = model.pins[index];
        pin = target.pin;
        if (target.type == hal::Type::bit)
            value = *rc::gen::element(0.0, 1.0);
        else if (target.type == hal::Type::integer)
            value = *rc::gen::element<double>(std::numeric_limits<std::int32_t>::min(), -1, 0, 1,
                                              std::numeric_limits<std::int32_t>::max());
        else if (target.type == hal::Type::word)
            value = *rc::gen::element<double>(0, 1, std::numeric_limits<std::uint32_t>::max());
        else if (target.echo || *rc::gen::inRange(0, 3) == 0)
            value = *rc::gen::elementOf(impossible);
        else
            factor = *rc::gen::element(-10.0, -1.0, -0.3, 0.0, 0.3, 0.5, 2.0, 10.0);
    }
    void apply(Model& model) const override { model.given.insert(index); }
    void run(const Model&, Attack& attack) const override {
        const double own = attack.own(pin);
        attack.set(pin, factor == 1 ? value : own != 0 ? factor * own : factor);
        attack.run(wait);
        expect_no_complaint(attack);
    }
    void show(std::ostream& out) const override {
        out << pin << " = ";
        factor == 1 ? out << value : out << factor << " x its own value, or " << factor << " where that is 0";
        out << "; " << wait << " s";
    }

    std::size_t index = 0;
    std::string pin;
    double value = 0, factor = 1, wait;
};

struct GiveBack final : Command {
    explicit GiveBack(const Model& model) : wait(seconds_to_wait()) {
        RC_PRE(!model.given.empty());
        index = *rc::gen::elementOf(model.given);
        pin = model.pins[index].pin;
    }
    void checkPreconditions(const Model& model) const override { RC_PRE(model.given.count(index) > 0); }
    void apply(Model& model) const override { model.given.erase(index); }
    void run(const Model&, Attack& attack) const override {
        attack.give_back(pin);
        attack.run(wait);
        expect_no_complaint(attack);
    }
    void show(std::ostream& out) const override { out << pin << " is given back; " << wait << " s"; }

    std::size_t index = 0;
    std::string pin;
    double wait;
};

struct Turn final : Command {
    explicit Turn(const Model& model) : wait(seconds_to_wait()) {
        RC_PRE(!model.knobs.empty());
        knob = *rc::gen::elementOf(model.knobs);
        const Live::Knob& its = model.live->around.knobs[knob];
        pin = its.pin;
        value = *rc::gen::elementOf(its.values);
    }
    void run(const Model&, Attack& attack) const override {
        attack.turn(knob, value);
        attack.run(wait);
        expect_no_complaint(attack);
    }
    void show(std::ostream& out) const override { out << pin << " = " << value << "; " << wait << " s"; }

    std::size_t knob = 0;
    std::string pin;
    double value = 0, wait;
};

// One to five inputs, and some knobs of the machine around them.
Model draw_focus(const Live& live, bool smooth) {
    std::vector<Attackable> pins = attackable_inputs(live);
    Model model;
    model.live = &live;
    if (smooth)
        pins.erase(
            std::remove_if(pins.begin(), pins.end(), [](const Attackable& pin) { return !pin.smooth; }),
            pins.end());
    const std::size_t most = std::min<std::size_t>(5, pins.size());
    const std::size_t count = *rc::gen::inRange<std::size_t>(1, most + 1);
    while (model.pins.size() < count) {
        const std::size_t i = *rc::gen::inRange<std::size_t>(0, pins.size());
        model.pins.push_back(pins[i]);
        pins.erase(pins.begin() + static_cast<std::ptrdiff_t>(i));
    }
    for (std::size_t i = 0; i < live.around.knobs.size(); ++i)
        if ((live.around.knobs[i].smooth || !smooth) && *rc::gen::arbitrary<bool>()) model.knobs.push_back(i);
    return model;
}

void survive_an_attack(const Live& live) {
    const bool smooth = !live.around.smooth_inputs.empty() && *rc::gen::arbitrary<bool>();
    const Model model = draw_focus(live, smooth);
    Focus focus;
    focus.smooth = smooth;
    focus.knobs = model.knobs;
    for (const Attackable& each : model.pins) focus.pins.push_back(each.pin);
    Attack attack(live, focus);
    rc::state::check(model, attack, [](const Model& now) {
        return rc::state::gen::execOneOfWithArgs<Give, Give, GiveBack, Turn>()(now);
    });
    attack.end();
    expect_no_complaint(attack);
}

// So many attacks, with a seed of its own: the same ones each time, unless RC_PARAMS has others.
void expect_to_survive(const Live& live, int attacks) {
    rc::detail::TestParams params;
    params.seed = 1;
    params.maxSuccess = attacks;
    params.maxSize = 60;
    params.maxDiscardRatio = 100;
    if (std::getenv("RC_PARAMS")) params = rc::detail::configuration().testParams;
    rc::detail::TestMetadata metadata;
    metadata.id = metadata.description = live.parts[0].module;
    const auto result = rc::detail::checkTestable([&] { survive_an_attack(live); }, metadata, params);
    std::ostringstream message;
    rc::detail::printResultMessage(result, message);
    EXPECT_TRUE(result.template is<rc::detail::SuccessResult>()) << "seed " << params.seed << "\n"
                                                                 << message.str();
}

#ifdef PLUMB_SANITIZED
constexpr int attacks = 2;
#else
constexpr int attacks = 8;
#endif

// Every function that moves an axis, alone.
std::vector<std::string> functions_that_move_an_axis() {
    std::vector<std::string> result;
    for (const std::string& name : built_modules()) {
        const Module module(build_folder() + "/modules/" + name + ".so");
        const hal::Role role = module.model().role;
        if ((role == hal::Role::compensation || role == hal::Role::stage) &&
            !hal::Declarations(module.model()).offsets.empty())
            result.push_back(name);
    }
    return result;
}

class Attacked : public testing::TestWithParam<std::string> {};

TEST_P(Attacked, NoSequenceBreaksIt) {
    const Live* const live = Live::of(GetParam());
    ASSERT_TRUE(live) << "no Live fixture for " << GetParam() << ": see tests/support/live.hpp";
    const bool takes_long = live->span + live->recovery > 10;
    expect_to_survive(*live, takes_long ? attacks / 2 : attacks);
}

INSTANTIATE_TEST_SUITE_P(Faults, Attacked, testing::ValuesIn(functions_that_move_an_axis()),
                         [](const auto& each) { return each.param; });

TEST(Faults, NoSequenceBreaksWhatIsLiveTogether) {
    expect_to_survive(*Live::together(), attacks / 5 + 1);
}

// An input or a knob takes a value; without one an input is given back.
struct Step {
    std::string pin;
    std::optional<double> value;
    double wait;  // s
};

std::vector<std::string> complaints_about(const Live& live, const std::vector<Step>& steps) {
    const auto knob_of = [&](const Step& step) {
        const auto found = std::find_if(live.around.knobs.begin(), live.around.knobs.end(),
                                        [&](const Live::Knob& knob) { return knob.pin == step.pin; });
        return static_cast<std::size_t>(found - live.around.knobs.begin());
    };
    const auto is_knob = [&](const Step& step) { return knob_of(step) < live.around.knobs.size(); };
    Focus focus;
    for (const Step& step : steps)
        if (!is_knob(step)) focus.pins.push_back(step.pin);
    Attack attack(live, focus);
    for (const Step& step : steps) {
        if (is_knob(step))
            attack.turn(knob_of(step), *step.value);
        else if (step.value)
            attack.set(step.pin, *step.value);
        else
            attack.give_back(step.pin);
        attack.run(step.wait);
    }
    attack.end();
    return attack.complaints();
}

// In each of these the counts rightly make another step than the guest's request. At the end all inputs and
// knobs return in one period.
TEST(FaultSequences, ForgettingAGuestAndCatchingUpWithItAreNoFaultsOfTheStage) {
    const std::vector<std::vector<Step>> sequences{
        // LinuxCNC forgets in the period of a cycle start, in that of a guest's step, and a large offset.
        {{"z-stage.arm", 0, 0.2}, {"z-axis.on", 0, 0.001}},
        {{"z-axis.on", 0, 0.1}, {"z-stage.guest-counts", 0, 0.1}},
        {{"z-stage.guest-counts", 200, 0.5}, {"z-axis.on", 0, 0.1}, {"z-axis.on", 1, 0.1}},
        // Only the stage forgets.
        {{"z-stage.arm", 0, 0.2}, {"z-stage.motion-enabled", 0, 0.001}},
        // The guest's request changes while unhomed, and without a valid report.
        {{"zhomed", 0, 0.1}, {"z-stage.guest-clear", 1, 0.1}, {"z-stage.guest-clear", {}, 0.1}},
        {{"z-stage.offset-request", 1e308, 0.1},
         {"z-stage.guest-counts", 40, 0.1},
         {"z-stage.offset-request", {}, 0.1}}};
    for (const std::vector<Step>& steps : sequences)
        EXPECT_EQ(complaints_about(*Live::of("axis_offset"), steps), std::vector<std::string>{})
            << "from " << steps.front().pin << " to " << steps.back().pin;
}

}  // namespace
}  // namespace plumb
