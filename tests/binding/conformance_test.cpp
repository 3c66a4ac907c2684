// SPDX-License-Identifier: GPL-2.0-or-later
// Every shipped module obeys the same rules about names, units, words, time, bad values and truth.
#include "hal/manual.hpp"
#include "hal/markup.hpp"
#include "hal/page.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/hal_pins.hpp"
#include "tests/support/impossible.hpp"
#include "tests/support/live.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"
#include "tests/support/rounds.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace plumb {
namespace {

using testing::IsEmpty;
using testing::Not;
using Complaints = std::vector<std::string>;

// "1" is a ratio.
const std::set<std::string> units{"1",   "%",   "mu",    "mu2",  "mu/s", "mu/s2", "mu/K", "mu/min",
                                  "rad", "deg", "deg/s", "degC", "K",    "N",     "N/mu", "1/K",
                                  "1/s", "K/W", "W",     "s",    "Hz",   "rpm"};

std::string output_of(const std::string& command) {
    std::string result;
    std::array<char, 4096> buffer;
    FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
    while (std::fgets(buffer.data(), buffer.size(), pipe)) result += buffer.data();
    pclose(pipe);
    return result;
}

bool dashed_lower(const std::string& name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return std::islower(c) || std::isdigit(c) || c == '-';
    });
}

bool sentence(const std::string& text) {
    return text.size() > 5 && text.back() == '.' && text.find('\n') == std::string::npos &&
           text.find(' ') != std::string::npos && !std::islower(static_cast<unsigned char>(text.front()));
}

bool has_output(const hal::Declarations& declared, const std::string& name) {
    return std::any_of(declared.pins.begin(), declared.pins.end(),
                       [&](const hal::PinInfo& pin) { return pin.output && pin.name == name; });
}

// Errors in what is told when a bit rises, and in the pins that sentences name in braces.
Complaints about_told(const hal::Declarations& declared) {
    Complaints result;
    std::vector<std::string> sentences;
    for (const hal::CodesInfo& codes : declared.codes)
        for (const auto& [number, text] : codes.sentences) sentences.push_back(text);
    for (const hal::ToldInfo& told : declared.told) {
        if (!has_output(declared, told.pin)) result.push_back("told: there is no pin " + told.pin);
        if (told.sentence.front() != '{' && !sentence(told.sentence))
            result.push_back("told: not one sentence: " + told.sentence);
        sentences.push_back(told.sentence);
    }
    const std::regex braces("\\{([^}]*)\\}");
    for (const std::string& text : sentences)
        for (std::sregex_iterator each(text.begin(), text.end(), braces), end; each != end; ++each)
            if (!has_output(declared, (*each)[1])) result.push_back("there is no pin " + each->str());
    return result;
}

// Errors in the status of a function or stage: each has a sentence, and a remedy unless all is well. A stage
// is off if nobody asks for an offset, which needs no remedy.
Complaints about_status(const hal::Declarations& declared, hal::Role role) {
    Complaints result;
    for (const hal::StatusInfo& info : declared.statuses)
        for (const auto& [number, its] : info.statuses) {
            const std::string which = info.pin + " " + std::to_string(number) + ": ";
            const bool at_rest = role == hal::Role::stage && its.kind == hal::Kind::off;
            const bool remedy_needed = its.kind != hal::Kind::good && !at_rest;
            if (*its.remedy ? !sentence(its.remedy) : remedy_needed)
                result.push_back(which + "its remedy is no sentence: " + its.remedy);
            for (const std::string detail : {its.detail, its.size})
                if (!detail.empty() && !has_output(declared, detail))
                    result.push_back(which + "there is no pin " + detail);
        }
    return result;
}

// Errors in the levels and ranges of the inputs of a function or stage, and too many settings that a user
// must read first.
Complaints about_settings(const hal::Declarations& declared, hal::Role role) {
    Complaints result;
    if (role != hal::Role::compensation && role != hal::Role::stage) return result;
    std::size_t musts = 0;
    for (const hal::PinInfo& pin : declared.pins) {
        const auto& [level, range] = pin.setting;
        musts += level == hal::Level::must;
        const bool bounded = std::isfinite(range.least) && std::isfinite(range.most);
        if (level != hal::Level::signal && pin.type != hal::Type::bit && !bounded)
            result.push_back(pin.name + ": a setting without a range");
        if (level != hal::Level::signal && pin.output) result.push_back(pin.name + ": an output has a level");
    }
    const std::size_t most = role == hal::Role::stage ? 8 : 12;
    if (musts > most)
        result.push_back(std::to_string(musts) + " settings must be set, more than " + std::to_string(most));
    return result;
}

// Errors in the names, units and sentences of a component.
Complaints about_declarations(const hal::Model& model, const std::string& file_name) {
    Complaints result;
    const auto demand = [&](bool holds, const std::string& what) {
        if (!holds) result.push_back(what);
    };
    const hal::Declarations declared(model);
    demand(model.about.name == file_name, "the component calls itself " + std::string(model.about.name));
    for (const hal::PinInfo& pin : declared.pins) {
        demand(dashed_lower(pin.name), pin.name + ": not lower case with dashes");
        demand(pin.name.size() <= 24,
               pin.name + ": longer than 24 characters, which leaves 22 for the instance");
        demand(sentence(pin.doc), pin.name + ": not one sentence: " + pin.doc);
        if (pin.type == hal::Type::real)
            demand(units.count(pin.unit) == 1, pin.name + ": unit '" + pin.unit + "' is not in the list");
        else
            demand(pin.unit.empty(), pin.name + ": a bit or a count has no unit, not '" + pin.unit + "'");
        if (!pin.output)
            demand(pin.setting.range.contains(pin.initial), pin.name + ": its default is out of its range");
    }
    for (const hal::CodesInfo& codes : declared.codes)
        for (const auto& [number, text] : codes.sentences)
            demand(sentence(text), codes.pin + " " + std::to_string(number) + ": not one sentence: " + text);
    for (const hal::OffsetInfo& offset : declared.offsets)
        demand(!offset.acceleration.empty() || sentence(offset.accelerated_by),
               offset.value + ": what limits its acceleration is not one sentence: " + offset.accelerated_by);
    demand(!declared.functions.empty(), "no function");
    demand(model.role != hal::Role::none, "no role");
    const bool has_status = model.role == hal::Role::compensation || model.role == hal::Role::stage;
    demand(declared.statuses.size() == (has_status ? 1 : 0),
           "a function or stage declares one hal::Status, and no other component any");
    for (const std::string& complaint : about_status(declared, model.role)) result.push_back(complaint);
    for (const std::string& complaint : about_told(declared)) result.push_back(complaint);
    for (const std::string& complaint : about_settings(declared, model.role)) result.push_back(complaint);
    const hal::Page page(model.about.page);
    for (const char* heading : {"DESCRIPTION", "WIRING", "BEHAVIOUR"})
        demand(!page.section(heading).empty(), std::string("no ") + heading);
    std::istringstream wiring(page.section("WIRING"));
    for (std::string line; std::getline(wiring, line);)
        demand(line.empty() || line.front() != ' ' || line.size() <= 72,
               "a line of the wiring is too wide: " + line);
    for (const hal::Function* function : declared.functions) {
        demand(dashed_lower(function->name), function->name + ": not lower case with dashes");
        demand(sentence(function->sentence),
               function->name + ": its order is not a sentence: " + function->sentence);
    }
    for (const hal::OptionInfo& option : declared.options)
        demand(sentence(option.doc), option.name + ": not one sentence: " + option.doc);
    return result;
}

// Symbols of a module that others would see, beyond those that LinuxCNC and our tools look for.
Complaints about_symbols(const std::filesystem::path& module) {
    Complaints result;
    std::istringstream lines(output_of("nm -D --defined-only --format=just-symbols " + module.string()));
    for (std::string symbol; std::getline(lines, symbol);)
        if (symbol.rfind("rtapi_info_", 0) != 0 && symbol != "rtapi_app_main" && symbol != "rtapi_app_exit" &&
            symbol != "plumb_model" && symbol != "plumb_options" && symbol != "plumb_place" &&
            symbol != "plumb_turns" && symbol != "plumb_given")
            result.push_back(symbol);
    return result;
}

// Whether a module registers work for the end of its process, as an object with a destructor does that is not
// in a function's frame: rtapi_app calls exit() while its threads run.
bool works_at_exit(const std::filesystem::path& module) {
    std::istringstream lines(output_of("nm -D --undefined-only --format=just-symbols " + module.string()));
    for (std::string symbol; std::getline(lines, symbol);)
        if (symbol.rfind("__cxa_atexit", 0) == 0 || symbol.rfind("__cxa_thread_atexit", 0) == 0) return true;
    return false;
}

// Pins of compensations (and stages) that are netted to a truth pin.
Complaints about_truth(Bench& bench, const std::set<std::string>& compensations) {
    const std::map<std::string, Wired> pins = wiring(bench);
    std::map<std::string, std::string> truths;  // by signal
    for (const auto& [name, pin] : pins)
        if (pin.output && !pin.signal.empty() && name.find(".truth-") != std::string::npos)
            truths[pin.signal] = name;
    Complaints result;
    for (const auto& [name, pin] : pins)
        if (!pin.output && truths.count(pin.signal) && compensations.count(pin.owner))
            result.push_back(name + " reads " + truths[pin.signal]);
    return result;
}

constexpr int most_inputs = 70;      // of a function, without records
constexpr double poison_time = 0.3;  // s, as long as the good value has between two bad ones

// An output that moves an axis, and the setting that limits its change per second; pins of the bench.
struct Moving {
    std::string output, max_rate;
    std::string guest, counts, scale;  // "" without a guest, for whose part it does not hold

    double own(Bench& bench) const { return bench.get(output) - (guest.empty() ? 0 : bench.get(guest)); }
};

std::vector<Moving> moving(Bench& bench, const Live::Part& part) {
    const Module module(build_folder() + "/modules/" + part.module + ".so");
    std::vector<Moving> result;
    for (const hal::OffsetInfo& offset : hal::Declarations(module.model()).offsets) {
        const std::string pin = part.instance + "." + offset.value;
        const std::string signal = offset.counts.empty() ? "" : wiring(bench).at(pin).signal;
        const auto beside_guest = [&](const std::string& name) {
            return offset.guest.empty() ? "" : part.instance + "." + name;
        };
        result.push_back({signal.empty() ? pin : signal, part.instance + "." + offset.rate,
                          beside_guest(offset.guest), beside_guest(offset.counts),
                          beside_guest(offset.scale)});
    }
    return result;
}

// The outputs that a live component has in the end when nothing bad happens; by name.
const std::map<std::string, double>& undisturbed(const Live& live) {
    static std::map<const Live*, std::map<std::string, double>> known;
    std::map<std::string, double>& outputs = known[&live];
    if (outputs.empty()) {
        Bench bench(Bench::Thread::none, with_specimens());
        live.start(bench);
        bench.run(live.span + live.recovery);
        for (const Moving& each : moving(bench, live.parts[0])) outputs[each.output] = bench.get(each.output);
    }
    return outputs;
}

// Errors at the outputs of a live component, and after it, when one input takes impossible values.
Complaints about_poison(const Live& live, const hal::Declarations& declared, const std::string& input) {
    const std::map<std::string, double>& expected_outputs = undisturbed(live);  // first: one host at a time
    Bench bench(Bench::Thread::none, with_specimens());
    live.start(bench);
    const std::string& instance = live.parts[0].instance;
    const std::string pin = instance + "." + input;
    const std::vector<Moving> movings = moving(bench, live.parts[0]);
    const std::map<std::string, Wired> wired = wiring(bench);
    const auto declaration = std::find_if(declared.pins.begin(), declared.pins.end(),
                                          [&](const hal::PinInfo& info) { return info.name == input; });
    // A chain of axes has one of U, V and W; each other fixture has all pins that options give.
    if (!wired.count(pin) && declaration->only_with.find(" in ") != std::string::npos) return {};
    const std::string signal = wired.at(pin).signal;
    const double own = bench.get(pin);
    for (const hal::PinInfo& output : declared.pins)
        if (output.output && output.type == hal::Type::real && wired.count(instance + "." + output.name))
            bench.client().expect("finite " + output.name, "finite(x)",
                                  {{"x", instance + "." + output.name}});
    for (const Moving& each : movings) {
        std::ostringstream bound;
        bound.precision(17);
        std::map<std::string, std::string> variables{{"x", each.output}};
        if (!each.guest.empty()) variables = {{"g", each.guest}, {"c", each.counts}, {"s", each.scale}};
        bound << (each.guest.empty() ? "abs(x_rate)" : "c_rate == 0 || abs(c_rate * s - g_rate) - 1000 * s")
              << " <= " << bench.get(each.max_rate) * (1 + 1e-6) + 1e-12;
        bench.client().expect("rate of " + each.output, bound.str(), variables);
    }

    const std::vector<double> poisons =
        declaration->type == hal::Type::real
            ? std::vector<double>(impossible.begin(), impossible.end())
            : std::vector<double>{std::numeric_limits<std::int32_t>::min(), -1,
                                  std::numeric_limits<std::int32_t>::max()};

    Complaints result;
    const bool alive = std::any_of(movings.begin(), movings.end(),
                                   [&](const Moving& each) { return bench.get(each.output) != 0; });
    if (!alive) result.push_back("the outputs are zero: not alive");
    const double end = bench.time() + live.span;
    while (bench.time() < end)
        for (const double poison : poisons) {
            if (!signal.empty()) bench.command("unlinkp " + pin);
            bench.set(pin, poison);
            bench.client().run(client::seconds(poison_time));
            bench.set(pin, own);
            if (!signal.empty()) bench.command("net " + signal + " " + pin);
            bench.client().run(client::seconds(poison_time));
        }
    bench.client().run(client::seconds(live.recovery - (bench.time() - end)));
    for (const client::Violation& violation : bench.client().violations())
        result.push_back(violation.id + ": " + std::to_string(violation.count) + " periods");
    for (const auto& [output, expected] : expected_outputs) {
        const double found = bench.get(output);
        if (!(std::abs(found - expected) <= 0.1 * std::abs(expected) + 5 * um))
            result.push_back(output + " did not recover: " + std::to_string(found) + " instead of " +
                             std::to_string(expected));
    }
    return result;
}

class Conformance : public testing::TestWithParam<std::string> {
protected:
    const std::string name = GetParam();
    const Module module{build_folder() + "/modules/" + name + ".so"};
};

TEST_P(Conformance, NamesUnitsAndSentences) {
    EXPECT_THAT(about_declarations(module.model(), name), IsEmpty());
}

bool is_of_records(const hal::PinInfo& pin) {  // of plumb-retain
    return std::regex_match(pin.name, std::regex("row|forget|kept|restore(-.*)?"));
}

// An input without a level is a signal: a shipped file nets it, or its page says where it comes from.
TEST_P(Conformance, TheInputsOfAFunctionAreSettingsOrSignals) {
    const hal::AllDeclarations declared(module.model());
    if (module.model().role != hal::Role::compensation) return;
    std::string text = module.model().about.page;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_folder() + "/configs")) {
        const std::string ending = entry.path().extension();
        if (ending != ".hal" && ending != ".toml" && ending != ".ngc") continue;
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);)
            if (line.find("setp") == std::string::npos) text += line + '\n';
    }
    for (const hal::PinInfo& pin : declared.pins) {
        if (pin.output || is_of_records(pin) || pin.setting.level != hal::Level::signal) continue;
        const std::string stem = std::regex_replace(pin.each_name, std::regex("-?[0-9]+$"), "");
        const std::string pattern = std::regex_replace(stem, std::regex("%"), "[a-zL]");
        EXPECT_TRUE(std::regex_search(text, std::regex("\\b" + pattern + "\\b")))
            << pin.name << " has no level, and nothing nets it";
    }
}

// Options give more: an instance has the pins of what its machine has.
TEST_P(Conformance, AFunctionHasFewInputsByDefault) {
    if (module.model().role != hal::Role::compensation) return;
    const hal::Declarations declared(module.model());
    EXPECT_LE(std::count_if(declared.pins.begin(), declared.pins.end(),
                            [](const hal::PinInfo& pin) { return !pin.output && !is_of_records(pin); }),
              most_inputs);
}

TEST_P(Conformance, EachFunctionHasAPlaceInTheOrderOfAThread) {
    for (const hal::Function* function : hal::Declarations(module.model()).functions)
        EXPECT_NE(function->place, hal::Place::none) << function->name;
}

TEST_P(Conformance, OptionsAreKnownToTheLoader) {
    std::string declared;
    for (const hal::OptionInfo& option : hal::Declarations(module.model()).options)
        declared += option.name + ",";
    EXPECT_EQ(module.options(), declared);
}

TEST_P(Conformance, ShowsNothingElseToOtherModules) {
    EXPECT_THAT(about_symbols(module.file), IsEmpty());
}

TEST_P(Conformance, DestroysNothingWhenItsProcessExits) {
    EXPECT_FALSE(works_at_exit(module.file)) << "a global or static object has a destructor";
}

TEST_P(Conformance, HasAManualPageThatNamesEveryPin) {
    const std::filesystem::path page = build_folder() + "/man/" + name + ".9";
    std::ifstream file(page);
    ASSERT_TRUE(file) << "no " << page;
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(text, hal::manual(module.model(), 9));
    EXPECT_THAT(output_of("mandoc -T lint -W warning " + page.string() + " | grep -v 'missing date'"),
                IsEmpty());
    const std::string shown = output_of("mandoc -T ascii " + page.string() + " | col -b");
    const hal::Declarations declared(module.model());
    for (const hal::PinInfo& pin : declared.pins)
        EXPECT_TRUE(std::regex_search(shown, std::regex("(^|[\\s,])" + pin.name + "([\\s,]|$)"))) << pin.name;
    std::ifstream declarations(build_folder() + "/share/plumb/" + name + ".json");
    const auto json = nlohmann::json::parse(declarations);
    EXPECT_EQ(json.contains("moves"), !declared.offsets.empty());
    for (const hal::OffsetInfo& offset : declared.offsets) {
        const bool own = !offset.acceleration.empty();
        const std::string many =
            offset.times == 1 ? "" : std::to_string(std::lround(offset.times)) + " times ";
        EXPECT_THAT(text, testing::HasSubstr(own ? ", its speed by at most " + many +
                                                       hal::escaped(offset.acceleration)
                                                 : hal::escaped(offset.accelerated_by)));
        const auto& moves = json.at("moves").at(offset.counts.empty() ? offset.value : offset.counts);
        EXPECT_EQ(moves.at("bound"), offset.bound);
        EXPECT_EQ(moves.at(own ? "acceleration" : "accelerated_by"),
                  own ? offset.acceleration : offset.accelerated_by);
        EXPECT_EQ(moves.contains("turning"), !offset.turning_rate.empty());
        EXPECT_EQ(text.find("Where motion turns, it changes") != std::string::npos,
                  !offset.turning_rate.empty());
    }
}

TEST_P(Conformance, LoadsTwoInstancesUnloadsAndReloads) {
    Bench bench;
    const hal::Declarations declared(module.model());
    for (int round = 0; round < 2; ++round) {
        SCOPED_TRACE(round);
        bench.command("loadrt " + name + " names=a,b");
        std::map<std::string, double> untouched;
        for (const hal::PinInfo& pin : declared.pins) {
            if (!pin.output) {
                EXPECT_EQ(bench.get("a." + pin.name), pin.initial) << pin.name;
            }
            untouched[pin.name] = bench.get("b." + pin.name);
        }
        for (const hal::Function* function : declared.functions)
            bench.command("addf a." + function->name + " servo-thread");
        for (const hal::PinInfo& pin : declared.pins)
            if (!pin.output)
                bench.set("a." + pin.name, pin.type == hal::Type::bit ? 1 - pin.initial : pin.initial + 1);
        bench.run(1);
        for (const auto& [pin, value] : untouched) EXPECT_EQ(bench.get("b." + pin), value) << "b." << pin;
        bench.command("unloadrt " + name);
    }
}

// Only a simulated machine may be in millimetres alone, and its page says so.
TEST_P(Conformance, DefaultsOfLengthsAreThoseOfTheMachinesUnit) {
    const hal::Declarations declared(module.model());
    const std::vector<hal::PinInfo>& pins = declared.pins;
    if (std::none_of(pins.begin(), pins.end(), hal::has_length_default)) return;
    if (module.options().find("unit,") == std::string::npos) {
        EXPECT_THAT(declared.offsets, IsEmpty()) << "moves an axis, has defaults of lengths, and no unit=";
        EXPECT_THAT(hal::manual(module.model(), 9), testing::HasSubstr("on a machine in mm only"));
        return;
    }
    Bench bench;
    bench.command("loadrt " + name + " names=a unit=inch");
    for (const hal::PinInfo& pin : pins) {
        if (pin.output) continue;
        const bool length = pin.unit == "mu" || pin.unit.rfind("mu/", 0) == 0;
        EXPECT_DOUBLE_EQ(bench.get("a." + pin.name), length ? pin.initial / 25.4 : pin.initial) << pin.name;
    }
}

#ifndef PLUMB_SANITIZED
TEST_P(Conformance, NeitherAllocatesNorCallsTheSystem) {
    client::Start guarded;
    guarded.guard = true;
    Bench bench(Bench::Thread::servo, guarded);
    const hal::Declarations declared(module.model());
    bench.command("loadrt " + name + " names=a");
    for (const hal::Function* function : declared.functions)
        bench.command("addf a." + function->name + " servo-thread");
    for (const hal::PinInfo& pin : declared.pins)
        if (!pin.output && pin.type == hal::Type::bit) {
            bench.run(0.1);
            bench.set("a." + pin.name, 1 - pin.initial);
        }
    bench.run(1);
    for (const client::GuardViolation& violation : bench.client().guard())
        ADD_FAILURE() << violation.function << ": " << violation.what;
}
#endif

TEST(ConformanceRules, CatchBadDeclarations) {
    EXPECT_THAT(
        about_declarations(Module(build_folder() + "/specimens/sloppy.so").model(), "sloppy"),
        testing::UnorderedElementsAre(
            "No_Unit: not lower case with dashes", "No_Unit: unit '' is not in the list",
            "a-name-longer-than-it-may-be: longer than 24 characters, which leaves 22 "
            "for the instance",
            "max-offset: its default is out of its range", "flag: a bit or a count has no unit, not 'mu'",
            "nameless: not one sentence: no period", "fault-code 1: not one sentence: something",
            "out: what limits its acceleration is not one sentence: nothing",
            "update: its order is not a sentence: anywhere", "no role", "no WIRING", "no BEHAVIOUR"));
}

TEST(ConformanceRules, CatchSettingsWithoutARangeAndTooManyThatMustBeSet) {
    const Module module(build_folder() + "/specimens/sloppy.so");
    EXPECT_THAT(about_settings(hal::Declarations(module.model()), hal::Role::stage),
                testing::UnorderedElementsAre("endless: a setting without a range",
                                              "9 settings must be set, more than 8"));
}

TEST(ConformanceRules, CatchWhatIsDestroyedAtExit) {
    EXPECT_TRUE(works_at_exit(build_folder() + "/specimens/sloppy.so"));
}

std::string plain(std::string name) {
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name;
}

INSTANTIATE_TEST_SUITE_P(Each, Conformance, testing::ValuesIn(built_modules()),
                         [](const auto& each) { return plain(each.param); });

// A simulated machine may show nonsense for nonsense; an output that drives an axis may not.

// Some inputs of a module: few enough for a short test, several because they share the undisturbed run.
struct Inputs {
    std::string module;
    std::vector<std::string> pins;
};

std::ostream& operator<<(std::ostream& out, const Inputs& inputs) {
    return out << inputs.module << '.' << inputs.pins.front() << " and those after it";
}

bool has(const hal::Declarations& declared, const std::string& pin) {
    return std::any_of(declared.pins.begin(), declared.pins.end(),
                       [&](const hal::PinInfo& its) { return its.name == pin; });
}

std::vector<Inputs> inputs_of_what_moves_an_axis() {
    constexpr std::size_t together = 8;
    std::vector<Inputs> result;
    for (const std::string& name : built_modules()) {
        const Module module(build_folder() + "/modules/" + name + ".so");
        const hal::AllDeclarations declared(module.model());
        const hal::Declarations alone(module.model(), {{"interlock", "no"}});  // as in the fixture
        if (declared.offsets.empty()) continue;
        int number = 0;
        for (const hal::PinInfo& pin : declared.pins) {
            if (pin.output || pin.type == hal::Type::bit) continue;
            if (pin.only_with.empty() && !has(alone, pin.name)) continue;  // of interlock alone
            if (number++ % rounds(1, 4) != 0) continue;
            if (result.empty() || result.back().module != name || result.back().pins.size() == together)
                result.push_back({name, {}});
            result.back().pins.push_back(pin.name);
        }
    }
    return result;
}

class LiveConformance : public testing::TestWithParam<Inputs> {};

TEST_P(LiveConformance, NoValueReachesAnOutputOrBreaksARate) {
    const Live* const live = Live::of(GetParam().module);
    ASSERT_TRUE(live) << "no Live fixture for " << GetParam().module << ": see tests/live.hpp";
    const Module module(build_folder() + "/modules/" + GetParam().module + ".so");
    for (const std::string& pin : GetParam().pins) {
        EXPECT_THAT(about_poison(*live, hal::AllDeclarations(module.model()), pin), IsEmpty()) << pin;
    }
}

INSTANTIATE_TEST_SUITE_P(Each, LiveConformance, testing::ValuesIn(inputs_of_what_moves_an_axis()),
                         [](const auto& each) {
                             return plain(each.param.module + "_from_" + each.param.pins.front());
                         });

// With or without an acceleration of its own.
std::vector<std::string> what_moves_an_axis(bool accelerates) {
    std::vector<std::string> result;
    for (const std::string& name : built_modules()) {
        const Module module(build_folder() + "/modules/" + name + ".so");
        const hal::Declarations declared(module.model());
        if (!declared.offsets.empty() && declared.offsets.front().acceleration.empty() != accelerates)
            result.push_back(name);
    }
    return result;
}

class Moves : public testing::TestWithParam<std::string> {
protected:
    const Live* const live = Live::of(GetParam());
    const Module module{build_folder() + "/modules/" + GetParam() + ".so"};
    const hal::OffsetInfo offset = hal::Declarations(module.model()).offsets.front();
};
class MovesByItsAcceleration : public Moves {};

TEST_P(Moves, ReturnsWithinAReducedBoundAndReportsThatItIsLimited) {
    ASSERT_TRUE(live) << "no Live fixture for " << GetParam() << ": see tests/live.hpp";
    const std::string instance = live->parts[0].instance + ".";
    Bench bench(Bench::Thread::none, with_specimens());
    live->start(bench);
    const std::vector<Moving> movings = moving(bench, live->parts[0]);
    double largest = 0;
    for (const Moving& each : movings) largest = std::max(largest, std::abs(each.own(bench)));
    ASSERT_GT(largest, 0);
    const double bound = 0.2 * largest;
    bench.set(instance + offset.bound, bound);
    bench.run(live->recovery);
    for (const Moving& each : movings) EXPECT_LE(std::abs(each.own(bench)), bound + 1e-4) << each.output;
    EXPECT_TRUE(bench.get(instance + offset.limited));
}

// The same periods without and with a number that is typed.
TEST_P(MovesByItsAcceleration, RefusesABoundBelowItsOffsetAndMovesNothing) {
    ASSERT_TRUE(live) << "no Live fixture for " << GetParam() << ": see tests/live.hpp";
    const std::string instance = live->parts[0].instance + ".";
    std::vector<std::vector<double>> traces;
    for (const bool typed : {false, true}) {
        Bench bench(Bench::Thread::none, with_specimens());
        live->start(bench);
        const double now = std::abs(bench.get(instance + offset.value));
        ASSERT_GT(now, 0);
        if (typed) bench.set(instance + offset.bound, 0.1 * now);
        traces.push_back(
            bench.trace(live->recovery, {instance + offset.value}).column(instance + offset.value));
        EXPECT_EQ(bench.get(instance + "fault"), typed);
    }
    EXPECT_EQ(traces[0], traces[1]);
}

TEST_P(MovesByItsAcceleration, StopsAtItsBoundWithinItAtEveryPeriod) {
    ASSERT_TRUE(live && live->start_beyond) << "no Live fixture beyond the bound for " << GetParam();
    const std::string instance = live->parts[0].instance + ".", value = instance + offset.value;
    for (const long period : {250'000, 1'000'000, 4'000'000}) {
        SCOPED_TRACE(testing::Message() << period << " ns");
        Bench bench(Bench::Thread::none, with_specimens());
        live->start_beyond(bench, period);
        bench.command("loadrt ddt names=speed-of-it");
        const std::string signal = wiring(bench).at(value).signal;
        bench.command("net " + (signal.empty() ? "its-offset" : signal) + " " + value + " speed-of-it.in");
        bench.command("addf speed-of-it servo-thread");
        bench.run(0.02);
        const double most = bench.get(instance + offset.bound);
        std::ostringstream hardest;
        hardest.precision(17);
        hardest << "abs(v_rate) <= "
                << offset.times * bench.get(instance + offset.acceleration) * (1 + 1e-6) + 1e-4;
        bench.expect(hardest.str(), {{"v", "speed-of-it.out"}});
        bench.expect("abs(x) <= b", {{"x", value}, {"b", instance + offset.bound}});
        double farthest = 0;
        for (const double x : bench.trace(4, {value}, period * 1e-9).column(value))
            farthest = std::max(farthest, std::abs(x));
        EXPECT_EQ(farthest, most);
    }
}

INSTANTIATE_TEST_SUITE_P(Each, Moves, testing::ValuesIn(what_moves_an_axis(false)),
                         [](const auto& each) { return plain(each.param); });
INSTANTIATE_TEST_SUITE_P(Each, MovesByItsAcceleration, testing::ValuesIn(what_moves_an_axis(true)),
                         [](const auto& each) { return plain(each.param); });

// A compensation that trusts its inputs: the rule about bad values must catch it.
TEST(ConformanceRules, CatchACompensationThatTrustsItsInputs) {
    const Live trusting{{{"../specimens/sloppy", "it"}},
                        [](Bench& bench) {
                            bench.command("loadrt threads name1=servo-thread period1=1000000");
                            bench.command("loadrt sloppy names=it");
                            bench.command("addf it.update servo-thread");
                            bench.command("start");
                            bench.set("it.in", 0.1);
                            bench.run(0.1);
                        },
                        1,
                        10};
    const Module module(build_folder() + "/specimens/sloppy.so");
    EXPECT_THAT(about_poison(trusting, hal::Declarations(module.model()), "in"),
                testing::UnorderedElementsAre(testing::StartsWith("finite out"),
                                              testing::StartsWith("rate of it.out"),
                                              testing::StartsWith("it.out did not recover")));
}

// Every configuration, as it is shipped.

std::vector<std::filesystem::path> configurations() {
    std::vector<std::filesystem::path> result;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_folder() + "/configs"))
        if (entry.path().filename() == "bench.hal") result.push_back(entry.path());
    std::sort(result.begin(), result.end());
    return result;
}

// What may not read the truth: every compensation, and every stage that moves an axis.
class Configuration : public testing::TestWithParam<std::filesystem::path> {
protected:
    const std::set<std::string> compensations = [] {
        std::set<std::string> names;
        for (const std::string& name : built_modules()) {
            const Module module(build_folder() + "/modules/" + name + ".so");
            if (!hal::Declarations(module.model()).offsets.empty() ||
                module.model().role == hal::Role::compensation)
                names.insert(name);
        }
        return names;
    }();
};

TEST_P(Configuration, ScoresWithTruthButNeverCompensatesFromIt) {
    Bench bench(Bench::Thread::none);
    bench.source(GetParam());
    EXPECT_THAT(about_truth(bench, compensations), IsEmpty());
    bool compensated = false;
    for (const auto& [name, pin] : wiring(bench)) {
        compensated |= !pin.output && !pin.signal.empty() && compensations.count(pin.owner);
    }
    EXPECT_TRUE(compensated) << "no compensation is wired here";
}

#ifndef PLUMB_SANITIZED
TEST_P(Configuration, NeitherAllocatesNorCallsTheSystemWhileItWorks) {
    client::Start guarded;
    guarded.guard = true;
    Bench bench(Bench::Thread::none, guarded);
    bench.source(GetParam());
    bench.command("start");
    bench.run(700);
    for (const client::GuardViolation& violation : bench.client().guard())
        ADD_FAILURE() << violation.function << ": " << violation.what;
}
#endif

INSTANTIATE_TEST_SUITE_P(Each, Configuration, testing::ValuesIn(configurations()),
                         [](const auto& each) { return plain(each.param.parent_path().filename()); });

TEST(ConformanceRules, CatchACompensationThatReadsTheTruth) {
    Bench bench(Bench::Thread::none, with_specimens());
    bench.command("loadrt sloppy names=it");
    bench.command("loadrt rival names=other");
    bench.command("net growth it.truth-growth => other.in");
    EXPECT_THAT(about_truth(bench, {"rival"}), testing::ElementsAre("other.in reads it.truth-growth"));
    EXPECT_THAT(about_truth(bench, {"specimen"}), IsEmpty());
}

}  // namespace
}  // namespace plumb
