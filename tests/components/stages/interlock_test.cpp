// SPDX-License-Identifier: GPL-2.0-or-later
// The truth tables of the manual page of interlock: each row is a test, and random sequences are compared
// with them.
#include "hal/bus.hpp"
#include "hal/program_state.hpp"
#include "hal/status.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/place.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>

namespace plumb {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int services = 8, functions = 6, stages = 17;

// The table of the manual page whose first line begins with these words, without blank lines.
std::string page_table(const std::string& first_words) {
    std::ifstream page(source_folder() + "/components/stages/interlock/interlock.page");
    std::string line, table;
    while (std::getline(page, line) && line.find("  " + first_words) != 0) continue;
    for (; page && !line.empty(); std::getline(page, line)) table += line + '\n';
    if (table.empty()) throw std::runtime_error("no table of interlock.page begins with " + first_words);
    return table;
}

const std::string service_table = page_table("beat "), function_table = page_table("services "),
                  arm_table = page_table("before "), request_table = page_table("in-force "),
                  loss_table = page_table("gone "), compensated_table = page_table("functions ");

// By the name of the column.
using Words = std::map<std::string, std::string>;

struct Row {
    Words inputs, outputs;
    std::string text;
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
    return out << row.text;
}

std::vector<Row> rows_of(const std::string& table) {
    std::vector<Row> rows;
    std::vector<std::string> columns;
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream cells(line);
        std::vector<std::string> words{std::istream_iterator<std::string>(cells), {}};
        if (words.empty()) continue;
        if (columns.empty()) {
            columns = words;
            continue;
        }
        Row row{{}, {}, line};
        bool output = false;
        for (std::size_t i = 0; i < words.size(); ++i)
            if (words[i] == "|")
                output = true;
            else
                (output ? row.outputs : row.inputs)[columns.at(i)] = words[i];
        rows.push_back(row);
    }
    return rows;
}

// The inputs of a row, with both values for each "-".
std::vector<Words> cases_of(const Row& row) {
    std::vector<Words> cases{{}};
    for (const auto& [column, word] : row.inputs) {
        std::vector<Words> next;
        for (const Words& each : cases)
            for (const std::string& value :
                 word == "-" ? std::vector<std::string>{"0", "1"} : std::vector{word}) {
                next.push_back(each);
                next.back()[column] = value;
            }
        cases = next;
    }
    return cases;
}

// What a table says of its outputs for these inputs. Rows that apply must not contradict each other.
std::map<std::string, bool> look_up(const std::vector<Row>& rows, const Words& inputs) {
    std::map<std::string, bool> result;
    for (const Row& row : rows) {
        const bool applies = std::all_of(row.inputs.begin(), row.inputs.end(), [&](const auto& cell) {
            return cell.second == "-" || cell.second == inputs.at(cell.first);
        });
        if (!applies) continue;
        for (const auto& [column, word] : row.outputs) {
            if (word == ".") continue;
            const auto [known, is_new] = result.emplace(column, word == "1");
            if (!is_new && known->second != (word == "1")) ADD_FAILURE() << "two rows disagree: " << row.text;
        }
    }
    if (result.size() != rows.front().outputs.size())
        ADD_FAILURE() << "no row for " << testing::PrintToString(inputs);
    return result;
}

std::string numbered(const std::string& stem, int number) {
    return stem + "-" + std::to_string(number);
}

constexpr int first_periods = 4;  // until interlock hears all that it permits

// interlock on a thread that runs, with functions and stages that say what a test wants (the specimen peers).
// pulse-N beats for service N while its in1 is true.
struct Machine {
    explicit Machine(long nanoseconds = 1000000) : period(1e-9 * static_cast<double>(nanoseconds)) {
        std::string pulses;
        bench.command("loadrt threads name1=servo-thread period1=" + std::to_string(nanoseconds));
        for (int i = 0; i < services; ++i) {
            const std::string pulse = numbered("pulse", i);
            pulses += (i ? "," : "") + pulse;
        }
        bench.command("loadrt xor2 names=" + pulses);
        bench.command("loadrt peers names=peers");
        bench.command("addf peers.update servo-thread");
        for (int i = 0; i < services; ++i) {
            const std::string pulse = numbered("pulse", i);
            bench.command("net " + numbered("beat", i) + " " + pulse + ".out => " + pulse + ".in0");
            bench.command("addf " + pulse + " servo-thread");
        }
        bench.command("start");
    }

    // Loads it, or loads it anew, and has it called once these pins are set.
    void load(const std::vector<std::pair<std::string, double>>& pins = {}) {
        if (loaded_) bench.command("unloadrt interlock");
        loaded_ = true;
        bench.command("loadrt interlock names=it functions=" + std::to_string(functions) +
                      " stages=" + std::to_string(stages));
        for (int i = 0; i < functions; ++i) say(numbered("function-state", i));
        for (int i = 0; i < stages; ++i) say(numbered("stage-state", i));
        for (int i = 0; i < services; ++i) {
            bench.command("net " + numbered("beat", i) + " => peers." + numbered("service-heartbeat", i));
            say(numbered("service-state", i));
        }
        for (int i = 0; i < services; ++i) beat(i, false);
        for (const auto& [pin, value] : pins) set(pin, value);
        bench.command("addf it.update servo-thread");
        step(first_periods);
    }

    void set(const std::string& pin, double value) {
        bench.set((is_of_peers(pin) ? "peers." : "it.") + pin, value);
    }
    double get(const std::string& pin) { return bench.get("it." + pin); }
    void beat(int service, bool on) { bench.set(numbered("pulse", service) + ".in1", on); }
    void step(int periods = 1) { bench.run(period * periods); }

    void start_cycle() {
        for (const char* pin : {"motion-enabled", "all-homed"}) set(pin, 1);
        set("cycle-running", 0);
        step();
        set("cycle-running", 1);
        step();
    }

    Bench bench{Bench::Thread::none, with_specimens()};
    const double period;  // s

private:
    static bool is_of_peers(const std::string& pin) {
        const std::string stem = pin.substr(0, pin.rfind('-'));
        return stem == "function-busy" || stem == "function-settling" || stem == "function-ramping" ||
               stem == "service-heartbeat" || stem == "service-ready" || stem == "service-fault" ||
               (stem.rfind("stage-", 0) == 0 && stem != "stage-passed");
    }
    void say(const std::string& word) { bench.command("net " + word + " peers." + word + " it." + word); }

    bool loaded_ = false;
};

class InterlockTable : public testing::TestWithParam<Row> {
protected:
    // Expects what the row says of the outputs, whose pins are given by column.
    void expect(const std::map<std::string, std::string>& pins) {
        for (const auto& [column, pin] : pins) {
            const std::string word = GetParam().outputs.at(column);
            if (word != ".") {
                EXPECT_EQ(machine.get(pin), word == "1") << pin;
            }
        }
    }

    Machine machine;
};

std::string row_name(const testing::TestParamInfo<Row>& row) {
    std::string name = "Row" + std::to_string(row.index + 1);
    for (const char c : row.param.text.substr(0, row.param.text.find('|')))
        name += std::isalnum(static_cast<unsigned char>(c)) ? std::string(1, c) : c == '-' ? "_" : "";
    return name;
}

class InterlockService : public InterlockTable {};
TEST_P(InterlockService, ReportsAsItsRowSays) {
    machine.load();
    for (int i = 0; i < services; ++i)
        for (const Words& words : cases_of(GetParam()))
            for (const bool other_way : {false, true}) {
                SCOPED_TRACE(testing::PrintToString(words) + (other_way ? " in another way" : ""));
                const std::string heartbeat = words.at("beat");
                machine.beat(i, false);
                machine.set(numbered("service-timeout", i), 0);  // forgets what it has heard
                machine.step();
                const bool unwatched = heartbeat == "beats" && other_way;
                machine.set(numbered("service-timeout", i), unwatched ? 0 : 0.05);
                machine.set(numbered("service-ready", i), words.at("ready") == "1");
                machine.set(numbered("service-fault", i), other_way);  // without effect
                machine.beat(i, heartbeat != "waits" && !other_way);
                machine.step(heartbeat == "waits" ? 40 : 200);
                if (heartbeat == "stopped") {
                    machine.beat(i, false);
                    machine.step(60);
                }
                expect({{"ok", numbered("service-ok", i)}, {"lost", numbered("service-lost", i)}});
            }
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockService, testing::ValuesIn(rows_of(service_table)), row_name);

class InterlockFunction : public InterlockTable {};
TEST_P(InterlockFunction, IsEnabledAsItsRowSays) {
    const std::string state = GetParam().inputs.at("services");
    for (const Words& words : cases_of(GetParam()))
        for (const bool by_switch : {false, true}) {
            SCOPED_TRACE(testing::PrintToString(words) + (by_switch ? " by the switch" : " by a cycle"));
            const auto set_all = [&](const std::string& pin, bool value) {
                for (int i = 0; i < functions; ++i) machine.set(numbered(pin, i), value);
            };
            std::vector<std::pair<std::string, double>> pins;
            for (int i = 0; i < functions; ++i) {
                pins.emplace_back(numbered("service-ready", i), state != "missing");
                pins.emplace_back(numbered("function-services", i), 1 << i);
                pins.emplace_back(numbered("function-switch", i), words.at("switch") == "1");
                pins.emplace_back(numbered("function-suspend", i), words.at("suspend") == "1");
                pins.emplace_back(numbered("function-busy", i), state == "kept");
            }
            machine.load(pins);
            if (state == "lost" || state == "kept" || state == "back" || state == "renewed") {
                set_all("service-ready", false);
                machine.step();
            }
            if (state == "back" || state == "renewed") {
                set_all("service-ready", true);
                machine.step();
            }
            if (state == "renewed" && !by_switch) machine.start_cycle();
            if (state == "renewed" && by_switch) {
                for (const bool value : {false, true}) {
                    set_all("function-switch", value);
                    machine.step();
                }
                set_all("function-switch", words.at("switch") == "1");
            }
            for (const int periods : {1, 100}) {
                machine.step(periods);
                for (int i = 0; i < functions; ++i)
                    expect(
                        {{"enable", numbered("function-enable", i)}, {"lost", numbered("function-lost", i)}});
            }
        }
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockFunction, testing::ValuesIn(rows_of(function_table)), row_name);

class InterlockArm : public InterlockTable {};
TEST_P(InterlockArm, RisesAndFallsAsItsRowSays) {
    const std::string cycle = GetParam().inputs.at("cycle-running");
    const bool before = GetParam().inputs.at("before") == "1";
    const bool runs_already = !before && cycle == "1";
    machine.load(
        {{"cycle-running", runs_already}, {"motion-enabled", 1}, {"all-homed", 1}, {"function-switch-2", 1}});
    for (const Words& words : cases_of(GetParam()))
        for (const bool suspended : {false, true}) {
            SCOPED_TRACE(testing::PrintToString(words));
            machine.set("function-suspend-2", suspended);
            machine.set("function-switch-2", 1);
            if (!runs_already) machine.set("cycle-running", 0);
            machine.step();
            if (before) machine.start_cycle();
            EXPECT_EQ(machine.get("arm"), before);
            machine.set("cycle-running", cycle != "0");
            machine.set("motion-enabled", words.at("motion-enabled") == "1");
            machine.set("all-homed", words.at("all-homed") == "1");
            machine.set("function-switch-2", words.at("function") == "1");
            for (const int periods : {1, 100}) {
                machine.step(periods);
                expect({{"arm", "arm"}});
            }
        }
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockArm, testing::ValuesIn(rows_of(arm_table)), row_name);

class InterlockRequest : public InterlockTable {};
TEST_P(InterlockRequest, IsMadeAsItsRowSays) {
    machine.load();
    for (int i = 0; i < stages; ++i)
        for (const Words& words : cases_of(GetParam()))
            for (const bool of_stage : {false, true}) {
                SCOPED_TRACE(testing::PrintToString(words) + " of " + std::to_string(i));
                const int function = i % functions;
                const std::string ramping =
                    of_stage ? numbered("stage-ramping", i) : numbered("function-ramping", function);
                const std::map<std::string, std::string> pins{
                    {"in-force", numbered("stage-in-force", i)},
                    {"ramping", ramping},
                    {"settling", numbered("function-settling", function)},
                    {"refused", numbered("stage-probing-refused", i)}};
                machine.set("service-timeout-6", words.at("loss") == "1" ? 0.05 : 0);
                machine.set("feed-services", 64);
                for (const auto& [column, pin] : pins) machine.set(pin, words.at(column) == "1");
                machine.set("motion-type", words.at("probing") == "1" ? 5 : 2);
                machine.step(150);  // beyond the shortest abort
                expect({{"homing", "homing-inhibit"}, {"feed", "feed-inhibit"}, {"abort", "abort"}});
                EXPECT_EQ(machine.get("feed-service-lost"), words.at("loss") == "1");
                EXPECT_EQ(machine.get("ramping"), words.at("ramping") == "1");
                for (const auto& [column, pin] : pins) machine.set(pin, 0);
            }
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockRequest, testing::ValuesIn(rows_of(request_table)), row_name);

// Services 0 retain, 1 link, 4 task and 5 io; function 0 is busy while its stroke or the program goes on.
class InterlockLoss : public InterlockTable {};
TEST_P(InterlockLoss, HasTheEffectOfItsRow) {
    const std::string function = GetParam().inputs.at("function"), gone = GetParam().inputs.at("gone");
    const bool is_stroke = function == "stroke";
    machine.load({{"service-timeout-0", 0.5},
                  {"service-timeout-1", 0.2},
                  {"service-timeout-4", 0.05},
                  {"service-timeout-5", 0.05},
                  {"feed-services", 48},
                  {"function-services-0", is_stroke               ? 1 + 2 + 16 + 32
                                          : function == "records" ? 1
                                                                  : 0},
                  {"function-urgent-0", is_stroke ? 48 : 0},
                  {"program-running", 1},
                  {"function-switch-0", 1}});
    for (const int service : {0, 1, 4, 5}) machine.beat(service, true);
    machine.step(10);
    machine.set("function-busy-0", 1);
    machine.start_cycle();
    EXPECT_TRUE(machine.get("function-enable-0"));
    EXPECT_FALSE(machine.get("feed-inhibit"));
    const std::map<std::string, std::vector<int>> services_of{
        {"retain", {0}}, {"link", {1}}, {"task", {4}}, {"io", {5}}};
    for (const int service : services_of.at(gone)) machine.beat(service, false);
    machine.bench.run(1);
    expect({{"during", "function-enable-0"}, {"feed", "feed-inhibit"}});
    machine.set("function-busy-0", 0);
    machine.step(2);
    expect({{"after", "function-enable-0"}});
    machine.start_cycle();
    expect({{"again", "function-enable-0"}});
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockLoss, testing::ValuesIn(rows_of(loss_table)), row_name);

// Task, which function 0 needs, is stopped in a cycle and goes on.
void stop_task_for_a_while(Machine& machine) {
    machine.beat(4, true);
    machine.start_cycle();
    machine.beat(4, false);
    machine.step(60);
    EXPECT_FALSE(machine.get("function-enable-0"));
    machine.beat(4, true);
    machine.step(1000);
    EXPECT_TRUE(machine.get("service-ok-4"));
    EXPECT_TRUE(machine.get("feed-inhibit"));
    EXPECT_FALSE(machine.get("function-enable-0"));
}

// The contour must not go on, because the wheel has gone to R.
TEST(Interlock, FeedWaitsAfterAWithdrawalUntilTheProgramEndsOrTheFunctionIsRenewed) {
    for (const bool renewed : {false, true}) {
        Machine machine;
        machine.load({{"service-timeout-4", 0.05},
                      {"feed-services", 16},
                      {"function-services-0", 16},
                      {"function-urgent-0", 16},
                      {"function-busy-0", 1},
                      {"program-running", 1},
                      {"function-switch-0", 1}});
        stop_task_for_a_while(machine);
        if (renewed)
            machine.start_cycle();
        else
            machine.set("program-running", 0);
        machine.step();
        EXPECT_FALSE(machine.get("feed-inhibit"));
        EXPECT_EQ(machine.get("function-enable-0"), renewed);
    }
}

TEST(Interlock, AMoveWaitsAfterAWithdrawalAlsoWhereTaskKnowsOfNone) {
    Machine machine;
    machine.load({{"service-timeout-4", 0.05},
                  {"feed-services", 16},
                  {"function-services-0", 16},
                  {"function-urgent-0", 16},
                  {"motion-type", 2},
                  {"function-switch-0", 1}});
    stop_task_for_a_while(machine);
    machine.set("motion-type", 0);
    machine.step();
    EXPECT_FALSE(machine.get("feed-inhibit")) << "after an abort";
}

TEST(Interlock, FunctionThatWasKeptUntilItsServiceReturnedGoesOn) {
    Machine machine;
    machine.load({{"function-busy-0", 1}, {"function-switch-0", 1}});
    machine.set("service-ready-1", 0);
    machine.step(100);
    EXPECT_TRUE(machine.get("function-enable-0"));
    EXPECT_TRUE(machine.get("function-lost-0"));
    machine.set("service-ready-1", 1);
    machine.step();
    EXPECT_FALSE(machine.get("function-lost-0"));
    machine.set("function-busy-0", 0);
    machine.step(100);
    EXPECT_TRUE(machine.get("function-enable-0"));
}

class InterlockCompensated : public InterlockTable {};
TEST_P(InterlockCompensated, IsShownAsItsRowSays) {
    machine.load({{"function-suspend-3", 1}});
    for (int i = 0; i < stages; ++i)
        for (const Words& words : cases_of(GetParam())) {
            SCOPED_TRACE(testing::PrintToString(words) + " of " + std::to_string(i));
            const std::string which = words.at("functions");
            const std::vector<std::pair<std::string, double>> pins{
                {"function-switch-1", which != "none"},
                {"function-switch-3", which == "some"},
                {"all-homed", words.at("all-homed") == "1"},
                {numbered("stage-fault", i), words.at("stage-fault") == "1"},
                {numbered("stage-uncompensated", i), words.at("uncompensated") == "1"}};
            for (const auto& [pin, value] : pins) machine.set(pin, value);
            machine.step();
            expect({{"compensated", "compensated"}});
            EXPECT_EQ(machine.get("uncompensated-stage"), words.at("uncompensated") == "1" ? i : -1);
            for (const auto& [pin, value] : pins) machine.set(pin, 0);
        }
}
INSTANTIATE_TEST_SUITE_P(Table, InterlockCompensated, testing::ValuesIn(rows_of(compensated_table)),
                         row_name);

TEST(Interlock, EachTableOfThePageIsTested) {
    std::ifstream page(source_folder() + "/components/stages/interlock/interlock.page");
    const std::string text{std::istreambuf_iterator<char>(page), {}};
    std::ptrdiff_t rows = 0;
    for (const std::string& table :
         {service_table, function_table, arm_table, request_table, loss_table, compensated_table})
        rows += std::count(table.begin(), table.end(), '|');
    EXPECT_EQ(std::count(text.begin(), text.end(), '|'), rows);
}

TEST(Interlock, LoadedItEnablesAndRequestsNothing) {
    Machine machine;
    machine.load();
    for (const char* pin : {"function-enable-0", "function-lost-0", "service-lost-0", "arm", "ramping",
                            "homing-inhibit", "feed-inhibit", "feed-service-lost", "abort", "compensated",
                            "uncompensated", "probing-refused", "feed-held", "operation", "fault"})
        EXPECT_EQ(machine.get(pin), 0) << pin;
    EXPECT_EQ(machine.get("heartbeat"), first_periods);
    machine.step(1000);
    EXPECT_EQ(machine.get("heartbeat"), first_periods + 1000);
}

// Function 0 has the stage 1. What of its words interlock takes, stage_permit_test shows for the other
// direction.
TEST(Interlock, WhoIsNotHeardIsNotPermittedAndIsTold) {
    constexpr double silent = 5, unpermitted = 15, stage_fault = 9;  // fault-code, function-status
    Machine machine;
    machine.load({{"function-switch-0", 1}, {"function-stages-0", 2}, {"stage-in-force-1", 1}});
    const auto expect = [&](const char* when, bool enable, double status, double fault, double row) {
        EXPECT_EQ(machine.get("function-enable-0"), enable) << when;
        EXPECT_EQ(machine.get("function-status-0"), status) << when;
        EXPECT_EQ(machine.get("fault-code"), fault) << when;
        EXPECT_EQ(machine.get("silent-row"), row) << when;
        EXPECT_TRUE(machine.get("homing-inhibit")) << when << ": what a stage said last stays";
    };
    const auto holds = [&] {  // the stage 1
        return hal::BusWord::content(static_cast<std::uint32_t>(machine.get("stage-permit-1"))) >> 2 & 1;
    };
    machine.set("motion-enabled", 1);
    machine.set("all-homed", 1);
    machine.bench.run(2);
    expect("all are heard", true, 0, 0, -1);
    EXPECT_EQ(holds(), 0U);
    machine.bench.set("peers.dumb", 1);
    machine.bench.run(0.5);
    expect("a standing beat", false, unpermitted, 0, -1);
    EXPECT_EQ(holds(), 1U);
    machine.bench.run(1);
    expect("a standing beat for long", false, unpermitted, silent, 0);
    machine.bench.set("peers.dumb", 0);
    machine.bench.run(0.1);
    expect("it goes on", true, 0, 0, -1);
    EXPECT_EQ(holds(), 0U);
    for (const char* line : {"unlinkp it.stage-state-1", "unlinkp it.stage-state-2",
                             "net stage-state-1 it.stage-state-2", "net stage-state-2 it.stage-state-1"})
        machine.bench.command(line);
    machine.bench.run(2);
    expect("states of other rows", false, stage_fault, silent, 1);
    EXPECT_EQ(holds(), 1U);
}

// Each goes before all later ones.
TEST(Interlock, StatusNamesTheFirstThatKeepsTheMachineFromBeingCompensated) {
    using Pins = std::vector<std::pair<std::string, double>>;
    struct Cause {
        const char* name;
        Pins pins;
        double status;
        hal::Common common = hal::Common::none;
    };
    const Cause causes[] = {
        {"a fault", {{"operation-key", 1e308}}, 0, hal::Common::fault},
        {"the feed is held", {{"service-timeout-6", 0.01}, {"feed-services", 64}}, 41},
        {"all off", {{"function-switch-0", 0}, {"function-switch-1", 0}}, 42},
        {"a service is missing", {{"service-ready-0", 0}}, 44},
        {"the machine is off", {{"motion-enabled", 0}}, 0, hal::Common::machine_off},
        {"not homed", {{"all-homed", 0}}, 0, hal::Common::not_homed},
        {"a fault of a stage", {{"stage-fault-3", 1}}, 43},
        {"suspended", {{"function-suspend-0", 1}}, 0, hal::Common::suspended},
        {"a probing move", {{"motion-type", 5}, {"function-switch-1", 1}}, 0, hal::Common::probing},
        {"the way", {{"function-settling-0", 1}}, 45},
        {"an axis lacks its offset", {{"stage-uncompensated-3", 1}}, 46},
        {"a soft limit", {{"stage-limited-3", 1}}, 47},
        {"nothing", {}, 40}};
    Pins later;
    for (auto cause = std::rbegin(causes); cause != std::rend(causes); ++cause) {
        later.insert(later.end(), cause->pins.begin(), cause->pins.end());
        for (const Pins& pins : {cause->pins, later}) {
            Machine machine;
            machine.load({{"function-switch-0", 1}, {"motion-enabled", 1}, {"all-homed", 1}});
            for (const auto& [pin, value] : pins) machine.set(pin, value);
            machine.step(30);
            EXPECT_EQ(machine.get("status-code"), cause->status + static_cast<double>(cause->common))
                << cause->name << (pins == later ? " with all later ones" : " alone");
        }
    }
}

// Also where nothing is new, and interlock writes nothing.
TEST(Interlock, AnOutputThatIsNettedLateHasItsValue) {
    Machine machine;
    machine.load({{"function-switch-0", 1}, {"motion-enabled", 1}, {"all-homed", 1}});
    machine.bench.run(1);
    machine.bench.command("loadrt or2 names=lamp");
    for (const char* pin : {"compensated", "service-ok-3", "function-enable-0"}) {
        machine.bench.command("net late lamp.in0");
        machine.bench.command(std::string("net late it.") + pin);
        machine.step();
        EXPECT_EQ(machine.bench.get("lamp.in0"), 1) << pin;
        machine.bench.command("delsig late");
        machine.bench.set("lamp.in0", 0);
    }
}

TEST(Interlock, HeartbeatIsLostAfterItsTimeoutAndNotBefore) {
    Machine machine;
    machine.load({{"service-timeout-1", 30}});
    machine.beat(1, true);
    machine.bench.run(1);
    machine.beat(1, false);
    machine.bench.run(29.9);
    EXPECT_TRUE(machine.get("service-ok-1"));
    machine.bench.run(0.2);
    EXPECT_FALSE(machine.get("service-ok-1"));
    EXPECT_TRUE(machine.get("service-lost-1"));
    machine.beat(1, true);
    machine.step(2);
    EXPECT_TRUE(machine.get("service-ok-1"));
    EXPECT_FALSE(machine.get("service-lost-1"));
}

TEST(Interlock, HeartbeatThatIsTrueAtFirstHasNotBeaten) {
    Machine machine;
    machine.beat(0, true);
    machine.step();
    machine.load({{"service-timeout-0", 30}});
    machine.bench.run(1);
    EXPECT_FALSE(machine.get("service-ok-0"));
    machine.beat(0, true);
    machine.step(2);
    EXPECT_TRUE(machine.get("service-ok-0"));
}

TEST(Interlock, AServiceBeatsByTheWordOfItsOwnProgramAlone) {
    using hal::Direction, hal::Party;
    constexpr std::uint32_t any = hal::BusWord::no_row, turned = 1 << 8;
    Machine machine;
    machine.load({{"service-timeout-1", 0.02}});
    machine.bench.command("unlinkp it.service-state-1");
    struct Case {
        const char* name;
        Party who;
        Direction where;
        std::uint32_t row, bits;  // these bits are turned
        bool beats;
    };
    for (const Case& each :
         {Case{"its own", Party::program, Direction::to_interlock, 1, 0, true},
          Case{"any", Party::program, Direction::to_interlock, any, 0, true},
          Case{"another number", Party::program, Direction::to_interlock, 0, 0, false},
          Case{"a function", Party::function, Direction::to_interlock, 1, 0, false},
          Case{"a stage", Party::stage, Direction::to_interlock, 1, 0, false},
          Case{"to a program", Party::program, Direction::from_interlock, 1, 0, false},
          Case{"a bit turned", Party::program, Direction::to_interlock, 1, turned, false}}) {
        SCOPED_TRACE(each.name);
        for (std::uint32_t beat = 0; beat < 100; ++beat) {
            const std::uint32_t content = hal::ProgramReport{true, false}.content();
            machine.set("service-state-1",
                        hal::BusWord::of(each.who, each.where, each.row, beat, content) ^ each.bits);
            machine.step();
        }
        EXPECT_EQ(machine.get("service-ok-1"), each.beats);
        EXPECT_EQ(machine.get("service-lost-1"), !each.beats);
    }
    machine.set("service-timeout-1", 0);
    for (const bool ready : {false, true}) {
        machine.set("service-state-1", hal::BusWord::of(Party::program, Direction::to_interlock, 1, 0,
                                                        hal::ProgramReport{ready, true}.content()));
        machine.step(2);
        EXPECT_EQ(machine.get("service-ok-1"), ready);
    }
}

TEST(Interlock, AServiceThatComesLateAndDoesNotBeatIsHeard) {
    Machine machine;
    machine.load();
    machine.bench.command("unlinkp it.service-state-1");
    machine.set("service-state-1", 0);
    machine.bench.run(5);
    EXPECT_TRUE(machine.get("service-ok-1")) << "nothing is netted";
    machine.set("service-state-1", hal::BusWord::of(hal::Party::program, hal::Direction::to_interlock, 1, 0,
                                                    hal::ProgramReport{false, false}.content()));
    machine.step(3);
    EXPECT_FALSE(machine.get("service-ok-1")) << "it is not ready";
}

TEST(Interlock, AServiceWithoutARowIsAFaultAndIsNotTakenForOk) {
    Bench bench(Bench::Thread::none, with_specimens());
    bench.command("loadrt threads name1=servo-thread period1=1000000");
    bench.command("loadrt peers names=peers");
    bench.command("loadrt interlock names=it stages=0 services=2");
    bench.command("net state peers.function-state-0 it.function-state-0");
    bench.command("setp it.function-switch-0 1");
    bench.command("addf peers.update servo-thread");
    bench.command("addf it.update servo-thread");
    bench.command("start");
    bench.run(0.1);
    EXPECT_TRUE(bench.get("it.function-enable-0")) << "the default has the rows that there are";
    EXPECT_EQ(bench.get("it.fault-code"), 0);
    for (const char* pin : {"it.function-services-0", "it.function-urgent-0", "it.feed-services"}) {
        SCOPED_TRACE(pin);
        const double own = bench.get(pin);
        bench.set(pin, 32);
        bench.run(0.1);
        EXPECT_EQ(bench.get("it.fault-code"), 2);
        bench.set(pin, own);
        bench.run(0.1);
        EXPECT_EQ(bench.get("it.fault-code"), 0);
    }
    bench.set("it.service-timeout-0", 0.05);
    for (const int sum : {0, 32}) {  // which stands for service 0, too
        bench.set("it.feed-services", sum);
        bench.run(0.1);
        EXPECT_EQ(bench.get("it.feed-inhibit"), sum != 0);
    }
    EXPECT_THROW(bench.get("it.service-ok-2"), std::runtime_error);
    bench.command("stop");
    bench.command(
        "unloadrt interlock");  // halcmd may take a module that is loaded for one that it has loaded
    EXPECT_THROW(bench.client().command("loadrt interlock names=more services=9"), std::runtime_error);
}

TEST(Interlock, FunctionThatLosesItsServiceGoesOffAndTheOtherOneGoesOn) {
    Machine machine;
    machine.load({{"service-timeout-0", 0.05},
                  {"function-switch-0", 1},
                  {"function-switch-1", 1},
                  {"function-services-1", 0}});
    machine.beat(0, true);
    machine.step(10);
    machine.start_cycle();
    EXPECT_TRUE(machine.get("function-enable-0"));
    for (int round = 0; round < 3; ++round) {
        SCOPED_TRACE(round);
        machine.beat(0, false);
        machine.step(60);
        EXPECT_FALSE(machine.get("function-enable-0"));
        EXPECT_TRUE(machine.get("function-enable-1"));
        EXPECT_TRUE(machine.get("arm"));
        machine.start_cycle();  // the service is still lost; the other function works
        EXPECT_FALSE(machine.get("function-enable-0"));
        EXPECT_TRUE(machine.get("arm"));
        machine.beat(0, true);
        machine.bench.run(100);
        EXPECT_TRUE(machine.get("service-ok-0"));
        EXPECT_FALSE(machine.get("function-enable-0"));  // nothing moves because a program returns
        machine.start_cycle();
        EXPECT_TRUE(machine.get("function-enable-0"));
    }
}

TEST(Interlock, FunctionNeedsTheServicesOfItsSum) {
    Machine machine;
    for (const int sum : {0, 1, 2, 3, 8, 15, 16, 37, 128, 240, 255}) {
        machine.load({{"function-switch-2", 1}, {"function-services-2", sum}});
        for (int service = 0; service < services; ++service) {
            machine.set(numbered("service-ready", service), 0);
            machine.step();
            EXPECT_EQ(machine.get("function-enable-2"), !(sum >> service & 1)) << sum << " " << service;
            machine.set(numbered("service-ready", service), 1);
            machine.start_cycle();
            EXPECT_TRUE(machine.get("function-enable-2")) << sum << " " << service;
        }
    }
    for (const int sum : {-1, 256, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()})
        for (const char* pin : {"function-services-2", "function-urgent-2"}) {
            machine.load({{"function-switch-2", 1}, {pin, sum}, {"service-ready-7", 0}});
            EXPECT_FALSE(machine.get("function-enable-2")) << sum;  // it needs all
            EXPECT_EQ(machine.get("fault-code"), 2);
        }
    machine.load({{"function-switch-2", 1}, {"service-ready-4", 0}});
    EXPECT_TRUE(machine.get("function-enable-2")) << "the default has the services 0 to 3";
}

TEST(Interlock, EnablesStayWhileAProbingMoveRuns) {
    Machine machine;
    machine.load({{"function-switch-0", 1}, {"function-switch-1", 0}});
    machine.set("motion-type", 5);
    machine.set("function-switch-0", 0);
    machine.set("function-switch-1", 1);
    machine.step(100);
    EXPECT_TRUE(machine.get("function-enable-0"));
    EXPECT_FALSE(machine.get("function-enable-1"));
    machine.set("motion-type", 0);
    machine.step();
    EXPECT_FALSE(machine.get("function-enable-0"));
    EXPECT_TRUE(machine.get("function-enable-1"));
}

// 2 is a cut, 1 a rapid move.
TEST(Interlock, SwitchedOffInACutTheOffsetHoldsUntilTheToolIsClear) {
    for (const char* const pin : {"function-switch-0", "function-off-0"}) {
        Machine machine;
        machine.load({{"function-switch-0", 1}, {"program-running", 1}, {"motion-type", 2}});
        const bool off = pin == std::string("function-off-0");
        machine.set(pin, off);
        machine.step(100);
        EXPECT_TRUE(machine.get("function-enable-0")) << pin;
        EXPECT_EQ(machine.get("function-status-0"), static_cast<double>(hal::Common::leaves));
        machine.set("motion-type", 1);
        machine.step();
        EXPECT_FALSE(machine.get("function-enable-0")) << pin;
        EXPECT_FALSE(machine.get("feed-inhibit")) << "the rapid move goes on";
        machine.set("function-ramping-0", 1);
        machine.set("motion-type", 2);
        machine.step(100);
        EXPECT_TRUE(machine.get("feed-inhibit")) << "the next cut waits";
        machine.set("function-ramping-0", 0);
        machine.step();
        EXPECT_FALSE(machine.get("feed-inhibit"));
        EXPECT_EQ(machine.get("function-status-0"), static_cast<double>(hal::Common::off));
        machine.set(pin, !off);
        machine.step();
        EXPECT_TRUE(machine.get("function-enable-0")) << pin;
    }
}

TEST(Interlock, SwitchedOffInACutAFunctionGoesOffWithTheProgramAndStrokesAtOnce) {
    Machine machine;
    machine.load({{"function-switch-0", 1},
                  {"function-switch-1", 1},
                  {"function-urgent-1", 1},
                  {"program-running", 1},
                  {"motion-type", 2}});
    for (const char* const pin : {"function-switch-0", "function-switch-1"}) machine.set(pin, 0);
    machine.step();
    EXPECT_TRUE(machine.get("function-enable-0"));
    EXPECT_FALSE(machine.get("function-enable-1"));
    machine.set("program-running", 0);
    machine.step();
    EXPECT_FALSE(machine.get("function-enable-0"));
}

// M66 right after M64 must see the ramp, before the function has begun it.
TEST(Interlock, RampingIsTrueFromThePeriodInWhichAnEnableChanges) {
    Machine machine;
    machine.load({{"function-switch-0", 1}});
    machine.step(10);
    EXPECT_FALSE(machine.get("ramping"));
    for (const double suspended : {1, 0}) {
        machine.set("function-suspend-0", suspended);
        for (const bool expected : {true, true, true, false}) {
            machine.step();
            EXPECT_EQ(machine.get("ramping"), expected) << suspended;
        }
    }
}

TEST(Interlock, MessagesComeWithTheirDelays) {
    Machine machine;
    machine.load();
    const auto expect_after = [&](const std::string& message, double value, double delay) {
        machine.bench.run(delay - 0.01);
        EXPECT_NE(machine.get(message), value) << message;
        machine.bench.run(0.02);
        EXPECT_EQ(machine.get(message), value) << message;
    };
    machine.set("stage-uncompensated-3", 1);
    machine.bench.run(1.9);
    machine.set("stage-uncompensated-3", 0);
    machine.step();
    machine.set("stage-uncompensated-3", 1);
    expect_after("uncompensated", 1, 2);
    EXPECT_EQ(machine.get("uncompensated-stage"), 3);
    machine.set("stage-uncompensated-3", 0);
    machine.step();
    EXPECT_FALSE(machine.get("uncompensated"));

    machine.set("stage-probing-refused-7", 1);
    machine.step();
    EXPECT_TRUE(machine.get("probing-refused"));
    EXPECT_TRUE(machine.get("abort"));
    machine.set("stage-probing-refused-7", 0);
    expect_after("abort", 0, 0.1);
    expect_after("probing-refused", 0, 4.89);

    machine.set("function-settling-2", 1);
    expect_after("feed-held", 1, 5);
    machine.set("function-settling-2", 0);
    machine.step();
    EXPECT_FALSE(machine.get("feed-held"));

    machine.set("uncompensated-delay", 0.5);
    machine.set("stage-uncompensated-0", 1);
    expect_after("uncompensated", 1, 0.5);
}

TEST(Interlock, TimesThatAreOutOfRangeLeaveTheLastGoodOnes) {
    for (const double bad : {nan, infinity, -infinity, -1.0, 3601.0, 1e308}) {
        SCOPED_TRACE(bad);
        Machine machine;
        machine.load({{"service-timeout-0", 0.5}, {"uncompensated-delay", 0.5}});
        machine.beat(0, true);
        machine.step(10);
        EXPECT_EQ(machine.get("fault-code"), 0);
        for (const char* pin : {"uncompensated-delay", "probing-refused-time", "feed-held-delay",
                                "service-timeout-0", "service-timeout-3", "clock-speed"}) {
            const double good = machine.get(pin);
            machine.set(pin, bad);
            machine.step();
            EXPECT_EQ(machine.get("fault-code"), 1) << pin;
            machine.set(pin, good);
            machine.step();
            EXPECT_EQ(machine.get("fault-code"), 0) << pin;
        }
        machine.set("service-timeout-0", bad);
        machine.set("uncompensated-delay", bad);
        machine.set("stage-uncompensated-0", 1);
        machine.beat(0, false);
        machine.bench.run(0.45);
        EXPECT_TRUE(machine.get("service-ok-0"));
        EXPECT_FALSE(machine.get("uncompensated"));
        machine.bench.run(0.1);
        EXPECT_TRUE(machine.get("service-lost-0"));
        EXPECT_TRUE(machine.get("uncompensated"));
    }
}

TEST(Interlock, ServiceHasItsTimeoutByTheComputersClock) {
    for (const double speed : {0.5, 1.0, 10.0}) {
        SCOPED_TRACE(speed);
        Machine machine;
        machine.load({{"service-timeout-0", 0.5}, {"clock-speed", speed}});
        machine.beat(0, true);
        machine.step(10);
        machine.beat(0, false);
        machine.bench.run(0.5 * speed - 0.01);
        EXPECT_FALSE(machine.get("service-lost-0"));
        machine.bench.run(0.02);
        EXPECT_TRUE(machine.get("service-lost-0"));
    }
}

// As M68 sets it, for functions that want a whole number.
// M49, M51 P0 and M53 P0 disable both holds of LinuxCNC. A path that brakes for a hold is none that begins.
TEST(Interlock, AMoveThatBeginsInSpiteOfTheHoldIsAborted) {
    Machine it;
    it.load({{"probing-refused-time", 0.5}});
    const auto move = [&](double type, double speed) {
        it.set("motion-type", type);
        it.set("path-speed", speed);
        it.step();
    };
    move(2, 20);
    it.set("function-settling-0", 1);
    it.step();
    for (const double speed : {20.0, 10.0, 1.0}) {
        move(2, speed);
        EXPECT_EQ(it.get("abort"), 0) << "it brakes";
    }
    move(2, 0);
    EXPECT_EQ(it.get("abort"), 0);
    move(0, 20);
    EXPECT_EQ(it.get("abort"), 0) << "a jog";
    move(2, 0.1);
    EXPECT_EQ(it.get("abort"), 1);
    EXPECT_EQ(it.get("hold-defeated"), 1);
    move(0, 0);
    it.step(99);
    EXPECT_EQ(it.get("abort"), 0);
    EXPECT_EQ(it.get("hold-defeated"), 1);
    it.set("function-settling-0", 0);
    it.step();
    move(2, 20);
    EXPECT_EQ(it.get("abort"), 0) << "nothing is held";
    it.step(500);
    EXPECT_EQ(it.get("hold-defeated"), 0);
}

TEST(Interlock, OperationIsItsKeyRoundedOrNone) {
    Machine machine;
    machine.load();
    const std::vector<std::tuple<double, int, int>> expected{{10, 10, 0},
                                                             {9.9999999, 10, 0},
                                                             {-3, -3, 0},
                                                             {2147483647, 2147483647, 0},
                                                             {-2147483647, -2147483647, 0},
                                                             {2147483648, 0, 3},
                                                             {1e308, 0, 3},
                                                             {nan, 0, 3},
                                                             {infinity, 0, 3},
                                                             {-infinity, 0, 3},
                                                             {20, 20, 0}};
    for (const auto& [key, operation, code] : expected) {
        machine.set("operation-key", key);
        machine.step();
        EXPECT_EQ(machine.get("operation"), operation) << key;
        EXPECT_EQ(machine.get("fault-code"), code) << key;
    }
}

// What the tables say of a history of inputs, period by period. Of interlock it knows the text alone.
class Oracle {
public:
    explicit Oracle(double period) : period_(period) {}

    std::map<std::string, double> inputs;

    void step() {
        Words machine = bits({"motion-enabled", "all-homed"});
        const bool cycle = on("cycle-running"), on_and_homed = on("motion-enabled") && on("all-homed");
        const bool starts = cycle && !cycle_ && on_and_homed;
        const bool probing = inputs["motion-type"] == 5;
        const double type = inputs["motion-type"];
        const bool running = on("program-running"), cuts = running && type != 1 && type != 4;
        bool left = false;
        bool good_times = true, good_sums = true, changed = false, function = false, withdrawn = false;
        int switched = 0, enabled = 0, amiss = 0;

        for (int i = 0; i < services; ++i) {
            const auto its = [&](const std::string& stem) { return numbered("service-" + stem, i); };
            Service& service = services_[i];
            good_times &= take(inputs[its("timeout")], service.timeout);
            const bool beat = on(its("heartbeat"));
            const bool watched = service.timeout > 0;
            if (!watched) service.changes = service.periods = 0;
            if (watched) ++service.periods;
            if (service.seen && beat != service.beat && watched) {
                ++service.changes;
                service.periods = 0;
            }
            service.seen = true;
            service.beat = beat;
            Words words = {{"ready", inputs[its("ready")] ? "1" : "0"}};
            const bool late = service.periods * period_ > service.timeout;
            words["beat"] = !watched ? "beats" : late ? "stopped" : service.changes ? "beats" : "waits";
            for (const auto& [column, value] : look_up(service_rows_, words)) outputs[its(column)] = value;
        }

        for (int i = 0; i < functions; ++i) {
            const auto its = [&](const std::string& stem) { return numbered("function-" + stem, i); };
            Function& its_state = functions_[i];
            const double sum = inputs[its("services")];
            const auto possible = [](double given) { return given >= 0 && given <= 255; };
            const double at_once = inputs[its("urgent")];
            const bool known = possible(sum) && possible(at_once);
            bool urgent = !known;
            for (int service = 0; service < services; ++service)
                if (known && static_cast<int>(at_once) >> service & 1)
                    urgent |= outputs[numbered("service-lost", service)] == 1;
            good_sums &= known;
            bool served = true;
            for (int service = 0; service < services; ++service)
                if (!known || static_cast<int>(sum) >> service & 1)
                    served &= outputs[numbered("service-ok", service)] == 1;
            const bool leaves = its_state.on && outputs[its("enable")] == 1 && cuts && at_once == 0;
            const bool is_on = on(its("switch")) || leaves, turned_on = is_on && !its_state.on;
            left |= its_state.on && !is_on && outputs[its("enable")] == 1;
            its_state.on = is_on;
            std::string& word = its_state.services;
            const bool was_on = its_state.granted;
            if (served)
                word = word == "missing" || word == "kept" ? "ok" : word == "lost" ? "back" : word;
            else if (word != "missing")
                word = was_on && is_on && on(its("busy")) && !urgent ? "kept" : "lost";
            if (word == "back" && (starts || turned_on)) word = "renewed";
            its_state.granted = is_on && (word == "ok" || word == "renewed" || word == "kept");
            if (word == "lost" || word == "back")
                its_state.withdrawn |= was_on && urgent;
            else
                its_state.withdrawn = false;
            withdrawn |= its_state.withdrawn;

            const auto found = look_up(function_rows_, {{"services", word},
                                                        {"switch", is_on ? "1" : "0"},
                                                        {"suspend", on(its("suspend")) ? "1" : "0"}});
            double& enable = outputs[its("enable")];
            changed |= !probing && enable != found.at("enable");
            if (!probing) enable = found.at("enable");
            outputs[its("lost")] = found.at("lost");
            function |= is_on && (word == "ok" || word == "renewed");
            switched += is_on;
            enabled += enable == 1;
            amiss += (enable == 1) != is_on;
        }

        machine["before"] = outputs["arm"] ? "1" : "0";
        machine["cycle-running"] = cycle && !cycle_ ? "rises" : cycle ? "1" : "0";
        machine["function"] = function ? "1" : "0";
        cycle_ = cycle;
        const bool arm = look_up(arm_rows_, machine).at("arm");
        changed |= outputs["arm"] != arm;
        outputs["arm"] = arm;

        const bool refused = any("stage-probing-refused", stages), lacks = any("stage-uncompensated", stages);
        const bool ramps = any("stage-ramping", stages) || any("function-ramping", functions);
        const auto word = [](bool bit) { return bit ? "1" : "0"; };
        const double feed_sum = inputs["feed-services"];
        const bool good_feed_sum = feed_sum >= 0 && feed_sum <= 255;
        good_sums &= good_feed_sum;
        bool loss = withdrawn && (on("program-running") || inputs["motion-type"] != 0);
        for (int service = 0; service < services; ++service)
            if (!good_feed_sum || static_cast<int>(feed_sum) >> service & 1)
                loss |= outputs[numbered("service-lost", service)] == 1;
        outputs["feed-service-lost"] = loss;
        since_change_ = changed ? 0 : since_change_ + 1;
        returns_ = (returns_ || left) && running && (ramps || since_change_ < 3);
        const auto requests = look_up(
            request_rows_, {{"in-force", word(any("stage-in-force", stages))},
                            {"ramping", word(ramps)},
                            {"settling", word(any("function-settling", functions) || (returns_ && cuts))},
                            {"refused", word(refused)},
                            {"probing", word(probing)},
                            {"loss", word(loss)}});
        outputs["homing-inhibit"] = requests.at("homing");
        outputs["feed-inhibit"] = requests.at("feed");
        outputs["ramping"] = ramps || since_change_ < 3;
        const std::string which = switched == 0 ? "none" : amiss == 0 ? "all" : "some";
        outputs["compensated"] =
            look_up(compensated_rows_, {{"functions", which},
                                        {"all-homed", machine.at("all-homed")},
                                        {"stage-fault", word(any("stage-fault", stages))},
                                        {"uncompensated", word(lacks)}})
                .at("compensated");
        outputs["uncompensated-stage"] = -1;
        for (int i = stages; i-- > 0;)
            if (on(numbered("stage-uncompensated", i))) outputs["uncompensated-stage"] = i;

        std::array<double, 3> delays = delays_;
        bool good_delays = true;
        const char* const names[]{"uncompensated-delay", "probing-refused-time", "feed-held-delay"};
        for (std::size_t i = 0; i < 3; ++i) good_delays &= take(inputs[names[i]], delays[i]);
        if (good_delays) delays_ = delays;
        lacking_ = lacks ? lacking_ + 1 : 0;
        held_ = requests.at("feed") ? held_ + 1 : 0;
        unrefused_ = refused ? 0 : unrefused_ + 1;
        outputs["uncompensated"] = lacks && (outputs["uncompensated"] || lacking_ * period_ > delays_[0]);
        outputs["feed-held"] = requests.at("feed") && (outputs["feed-held"] || held_ * period_ > delays_[2]);
        const auto holds = [&](const char* pin, double time) {
            return refused || (outputs[pin] && unrefused_ * period_ <= time);
        };
        outputs["probing-refused"] = holds("probing-refused", delays_[1]);
        outputs["abort"] = holds("abort", 0.1);

        const double key = inputs["operation-key"];
        const bool known_key = std::abs(key) < 2147483648.0;
        outputs["operation"] = known_key ? std::floor(std::abs(key) + 0.5) * (key < 0 ? -1 : 1) : 0;
        outputs["fault-code"] = !(good_times && good_delays) ? 1 : !good_sums ? 2 : !known_key ? 3 : 0;
        outputs["fault"] = outputs["fault-code"] != 0;
        outputs["heartbeat"] += 1;
    }

    std::map<std::string, double> outputs;

private:
    struct Service {
        double timeout = 0;
        int periods = 0, changes = 0;  // since it is watched; since the last change
        bool seen = false, beat = false;
    };
    struct Function {
        std::string services = "missing";
        bool on = false, granted = false, withdrawn = false;
    };

    bool on(const std::string& pin) { return inputs.at(pin) != 0; }
    bool any(const std::string& stem, int number) {
        bool result = false;
        for (int i = 0; i < number; ++i) result |= on(numbered(stem, i));
        return result;
    }
    Words bits(const std::vector<std::string>& pins) {
        Words words;
        for (const std::string& pin : pins) words[pin] = on(pin) ? "1" : "0";
        return words;
    }
    static bool take(double given, double& value) {
        const bool good = given >= 0 && given <= 3600;
        if (good) value = given;
        return good;
    }

    const std::vector<Row> service_rows_ = rows_of(service_table), function_rows_ = rows_of(function_table),
                           arm_rows_ = rows_of(arm_table), request_rows_ = rows_of(request_table),
                           compensated_rows_ = rows_of(compensated_table);
    const double period_;
    std::array<Service, services> services_;
    std::array<Function, functions> functions_;
    std::array<double, 3> delays_{2, 5, 5};
    int since_change_ = 1000, lacking_ = 0, held_ = 0, unrefused_ = 1000;
    bool cycle_ = true, returns_ = false;
};

class InterlockSequence : public testing::TestWithParam<unsigned> {};

TEST_P(InterlockSequence, OfFaultsTogglesAndReturnsAgreesWithTheTables) {
    std::mt19937 random(GetParam());
    const auto below = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
    const auto one_of = [&](const std::vector<double>& values) {
        return values[static_cast<std::size_t>(below(static_cast<int>(values.size())))];
    };
    Machine machine(700000);  // no delay is a multiple of it
    Oracle oracle(machine.period);
    std::vector<std::string> bits;
    const auto declare = [&](const std::string& stem, int number, double initial) {
        for (int i = 0; i < number; ++i) oracle.inputs[number > 1 ? numbered(stem, i) : stem] = initial;
    };
    for (const char* stem : {"service-heartbeat", "service-fault"}) declare(stem, services, 0);
    declare("service-ready", services, 1);
    for (const char* stem :
         {"function-switch", "function-suspend", "function-busy", "function-settling", "function-ramping"})
        declare(stem, functions, 0);
    for (const char* stem :
         {"stage-in-force", "stage-ramping", "stage-uncompensated", "stage-probing-refused", "stage-fault"})
        declare(stem, stages, 0);
    for (const char* pin : {"motion-enabled", "all-homed", "cycle-running", "program-running"})
        declare(pin, 1, 0);
    for (const auto& [pin, value] : oracle.inputs) bits.push_back(pin);
    declare("service-timeout", services, 0);
    declare("function-services", functions, 15);
    declare("function-urgent", functions, 0);
    declare("feed-services", 1, 0);
    for (const char* pin : {"operation-key", "motion-type"}) declare(pin, 1, 0);
    oracle.inputs["uncompensated-delay"] = 2;
    oracle.inputs["probing-refused-time"] = oracle.inputs["feed-held-delay"] = 5;

    machine.load();  // with the defaults that the oracle has
    for (int i = 0; i < services; ++i)
        machine.bench.command("unlinkp peers." + numbered("service-heartbeat", i));
    for (int i = 0; i < first_periods; ++i) oracle.step();

    const auto give = [&](const std::string& pin, double value) {
        machine.set(pin, value);
        oracle.inputs[pin] = value;
    };
    for (int n = 0; n < 700; ++n) {
        for (int changes = 1 + below(3); changes-- > 0;) {
            const int i = below(4), what = below(21);
            if (what < 8)
                give(bits[static_cast<std::size_t>(below(static_cast<int>(bits.size())))], below(3) == 0);
            else if (what < 10)
                give(numbered("service-heartbeat", i), 1 - oracle.inputs[numbered("service-heartbeat", i)]);
            else if (what < 12)
                give(numbered(below(2) ? "function-switch" : "service-ready", i), below(4) != 0);
            else if (what < 14)
                give("cycle-running", below(2));
            else if (what < 16)
                give(below(2) ? "motion-enabled" : "all-homed", below(5) != 0);
            else if (what == 16)
                give("motion-type", one_of({0, 1, 2, 4, 5, 5, -5}));
            else if (what == 17)
                give(numbered("service-timeout", i), one_of({0, 0, 0.0111, 0.05, nan, -1, infinity}));
            else if (what == 18)
                give(numbered("function-services", i), one_of({0, 1, 2, 4, 8, 15, 15, 255, 256, -1}));
            else if (what == 19)
                give(below(2) ? numbered("function-urgent", i) : "feed-services",
                     one_of({0, 0, 1, 2, 3, 15, 255, 256, -1}));
            else
                give(std::vector<std::string>{"operation-key", "uncompensated-delay", "probing-refused-time",
                                              "feed-held-delay"}[static_cast<std::size_t>(i)],
                     one_of({0, 0.0111, 0.05, 10, nan, infinity}));
        }
        const int periods = static_cast<int>(one_of({1, 1, 1, 1, 2, 3, 20, 100}));
        machine.step(periods);
        for (int i = 0; i < periods; ++i) oracle.step();
        for (const auto& [pin, expected] : oracle.outputs)
            ASSERT_EQ(machine.get(pin), expected) << pin << ", step " << n;
    }
}

#ifdef PLUMB_SANITIZED
INSTANTIATE_TEST_SUITE_P(Seed, InterlockSequence, testing::Range(1u, 2u));
#else
INSTANTIATE_TEST_SUITE_P(Seed, InterlockSequence, testing::Range(1u, 4u));
#endif

}  // namespace
}  // namespace plumb
