// SPDX-License-Identifier: GPL-2.0-or-later
// plumb bench: runs .hal files in virtual time.

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/client/client.hpp"
#include "hal/client/duration.hpp"
#include "hal/command_line.hpp"
#include "hal/commands/command.hpp"
#include "hal/commands/models.hpp"
#include "hal/host/arguments.hpp"
#include "hal/host/decimal.hpp"
#include "hal/host/statement.hpp"
#include "hal/spelling.hpp"

namespace plumb::commands {
namespace {

using namespace client;

using Clock = std::chrono::steady_clock;

struct BenchOptions {
    std::vector<std::string> files;
    std::string ini;
    std::optional<Time> duration;  // of the run; without one, the replay's
    std::vector<std::pair<std::string, double>> settings;
    Replay replay;                    // of no file: none
    std::vector<std::string> expect;  // statements
    std::vector<std::string> record;  // names
    Time every{};
    std::string output;
    std::vector<std::string> modules, module_options;
    bool namespaces = true;
    bool models = false;
};

// While it lives, the first SIGINT or SIGTERM is noted instead of ending the program; the second ends it.
class Interruption {
public:
    Interruption() {
        signal_ = 0;
        struct sigaction note {};
        note.sa_handler = [](int number) { signal_ = number; };
        note.sa_flags = static_cast<int>(SA_RESETHAND);
        sigaction(SIGINT, &note, &interrupt_);
        sigaction(SIGTERM, &note, &terminate_);
    }
    ~Interruption() {
        sigaction(SIGINT, &interrupt_, nullptr);
        sigaction(SIGTERM, &terminate_, nullptr);
    }
    Interruption(const Interruption&) = delete;

    int number() const { return signal_; }  // 0: none

private:
    static inline volatile sig_atomic_t signal_ = 0;
    struct sigaction interrupt_ {};
    struct sigaction terminate_ {};
};

// One line at the foot of a terminal; nothing elsewhere.
class ProgressLine {
public:
    ~ProgressLine() { clear(); }

    void show(const std::string& text) {
        if (!terminal_) return;
        std::fprintf(stderr, "\r%s\033[K", text.c_str());
        shown_ = true;
    }
    void clear() {
        if (shown_) std::fputs("\r\033[K", stderr);
        shown_ = false;
    }

private:
    const bool terminal_ = isatty(STDERR_FILENO);
    bool shown_ = false;
};

double in_seconds(Time time) {
    return std::chrono::duration<double>(time).count();
}

std::string joined(const std::vector<std::string>& words, const std::string& separator = ", ") {
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : separator) + word;
    return result;
}

// Of all pins, parameters and signals.
std::string suggestion(Client& host, const std::string& name) {
    std::vector<std::string> candidates;
    for (const char* kind : {"pin", "param", "sig"}) {
        std::istringstream names(host.halcmd({"list", kind}).output);
        for (std::string candidate; names >> candidate;) candidates.push_back(candidate);
    }
    return hal::suggestion(name, candidates);
}

void require_known(Client& host, const std::string& name, const char* option) try {
    host.read(name);
} catch (const HostDied&) {
    throw;
} catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string(option) + ": " + error.what() + suggestion(host, name));
}

// Whether a thread in `halcmd -s show thread` has a function. A line is a thread: period, floating point,
// name, time and longest time, and its functions. In LinuxCNC 2.10 each function has a line of its own.
bool any_function(const std::string& threads) {
    std::istringstream lines(threads);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        const auto count = std::distance(std::istream_iterator<std::string>(words), {});
        if (count > 5 || count == 1) return true;
    }
    return false;
}

// halcmd says file and line of what it does not like.
void load(Client& host, const std::vector<std::string>& command, const std::string& what) {
    const Halcmd result = host.halcmd(command);
    std::cerr << result.output << std::flush;
    if (result.status != 0)
        throw std::runtime_error(what + " was not loaded: halcmd ended with status " +
                                 std::to_string(result.status));
}

void load_files(Client& host, const BenchOptions& options) {
    for (const std::string& file : options.files) {
        std::vector<std::string> arguments{"-f", file};
        if (!options.ini.empty()) arguments.insert(arguments.begin(), {"-i", options.ini});
        load(host, arguments, file);
    }
}

// Changes into a folder for as long as it lives.
class Inside {
public:
    explicit Inside(const std::string& folder) : before_(std::filesystem::current_path()) {
        std::filesystem::current_path(folder);
    }
    ~Inside() {
        std::error_code gone;
        std::filesystem::current_path(before_, gone);
    }
    Inside(const Inside&) = delete;

private:
    std::filesystem::path before_;
};

// The host of a whole machine: the host and the programs that it starts have the folder and the variables
// that LinuxCNC's script gives them.
std::unique_ptr<Client> host_of(const IniMachine& machine, Start start) {
    for (const auto& [name, value] : machine.environment) setenv(name.c_str(), value.c_str(), 1);
    for (std::string& folder : start.modules) folder = std::filesystem::absolute(folder);
    start.models = machine.models;
    const Inside inside(machine.folder);
    auto host = std::make_unique<Client>(start);
    for (const std::vector<std::string>& command : machine.commands)
        load(*host, command, joined(command, " "));
    return host;
}

bool has_joints(Client& host) try {
    host.read("motion.motion-enabled");
    return true;
} catch (const HostDied&) {
    throw;
} catch (const std::runtime_error&) {
    return false;
}

void prepare(Client& host, const BenchOptions& options) {
    const std::string threads = host.halcmd({"-s", "show", "thread"}).output;
    if (threads.find_first_not_of(" \n") == std::string::npos)
        throw std::runtime_error(
            "nothing would run: no file loads a realtime thread "
            "(for instance: loadrt threads name1=servo-thread period1=1000000)");
    if (!any_function(threads))
        std::cerr << "note: no function was added to a thread (addf), so no component will do anything\n";
    if (has_joints(host))
        std::cerr
            << "note: joints stand: no task (a bench has none; plumb run -- linuxcnc FILE.ini has one)\n";
    host.command("start");
    for (const auto& [name, value] : options.settings) {
        require_known(host, name, "--set");
        host.set(name, value);
    }
    for (const std::string& name : options.record) require_known(host, name, "--record");
    for (const std::string& text : options.expect) {
        const host::Statement statement = host::parse_statement(text);
        for (const auto& [variable, name] : statement.variables) require_known(host, name, "--expect");
        try {
            host.expect(text, statement.expression, statement.variables);
        } catch (const HostDied&) {
            throw;
        } catch (const std::runtime_error& error) {
            throw std::runtime_error("--expect: '" + text + "', read as " + error.what());
        }
    }
}

std::string decimal(double number) {
    std::string text;
    host::append_number(text, number);
    return text;
}

// Prints which statements did not hold. Returns whether all did.
bool report_expectations(Client& host, const std::vector<std::string>& statements) {
    const std::vector<Violation> violations = host.violations();
    for (const Violation& violation : violations) {
        std::cout << "did not hold: " << violation.id << "\n    in " << violation.count
                  << (violation.count == 1 ? " period, at " : " periods, first at ")
                  << in_seconds(violation.first_time) << " s, when ";
        const host::Statement statement = host::parse_statement(violation.id);
        const char* separator = "";
        for (const auto& [variable, name] : statement.variables) {
            std::cout << std::exchange(separator, ", ") << name << " was "
                      << decimal(violation.values.at(variable));
            const auto rate = violation.values.find(variable + "_rate");
            if (rate != violation.values.end())
                std::cout << " and changed by " << decimal(rate->second) << " a second";
        }
        std::cout << '\n';
    }
    if (!statements.empty() && violations.empty())
        std::cout << (statements.size() == 1 ? "the statement" : "all statements")
                  << " held in every period\n";
    return violations.empty();
}

std::string times_real_time(Time simulated, double real_seconds) {
    char text[64];
    const double speed = in_seconds(simulated) / std::max(real_seconds, 1e-6);
    std::snprintf(text, sizeof text, speed < 100 ? "%.2g times real time" : "%.0f times real time", speed);
    return text;
}

Ran run(Client& host, Time duration, const Interruption& interruption) {
    ProgressLine line;
    const auto begin = Clock::now();
    return host.run(duration, [&](Time done) {
        const double real_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        const double left = real_seconds * (in_seconds(duration) / in_seconds(done) - 1);
        line.show(describe_duration(done) + " of " + describe_duration(duration) + ", " +
                  times_real_time(done, real_seconds) + ", " +
                  describe_duration(seconds(std::isfinite(left) ? std::ceil(left) : 0)) + " left");
        return interruption.number() == 0;
    });
}

// A word that is neither an option's value nor a sentence: 1.5, -2e3, 0x10, true, FALSE.
double parse_value(const std::string& text) {
    if (text == "true" || text == "TRUE") return 1;
    if (text == "false" || text == "FALSE") return 0;
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end) throw CLI::ValidationError("--set", "'" + text + "' is not a value");
    return value;
}

// An option whose value is a time.
template <class Assign>
CLI::Option* add_time(CLI::App& command, const std::string& name, Assign assign, const std::string& text) {
    const auto parse = [name, assign](const std::string& value) {
        try {
            assign(parse_duration(value));
        } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError(name, error.what());
        }
    };
    return command.add_option_function<std::string>(name, parse, text)->type_name("TIME");
}

// Declares the arguments of the command, which are parsed into `options`.
void declare_bench(CLI::App& command, BenchOptions& options) {
    command
        .add_option(
            "FILE.hal", options.files,
            "The .hal files, loaded in this order by LinuxCNC's halcmd. Without one, --ini loads a whole "
            "machine.")
        ->check(host::existing_file())
        ->type_name("");
    command
        .add_option(
            "--ini", options.ini,
            "INI file whose values the .hal files use as [SECTION]NAME. Without FILE.hal: the machine to "
            "load.")
        ->check(host::existing_file())
        ->type_name("FILE.ini");
    CLI::Option* const duration = add_time(
        command, "--for", [&](Time time) { options.duration = time; },
        "How long to simulate. With --replay at most as long as the file lasts, and all of it by default.");
    const auto add_setting = [&](const std::vector<std::string>& settings) {
        for (const std::string& setting : settings) {
            const std::size_t equals = setting.find('=');
            if (equals == std::string::npos)
                throw CLI::ValidationError("--set", "'" + setting + "' is not PIN=VALUE");
            options.settings.emplace_back(setting.substr(0, equals), parse_value(setting.substr(equals + 1)));
        }
    };
    command
        .add_option_function<std::vector<std::string>>(
            "--set", add_setting,
            "Sets a pin, parameter or signal once the files are loaded. May be given many times.")
        ->allow_extra_args(false)
        ->type_name("PIN=VALUE");

    CLI::Option* const replay =
        command
            .add_option(
                "--replay", options.replay.file,
                "Before every period, writes the columns of this file into the pins that its header "
                "names; column time is in seconds. Floats change linearly from row to row, bits and integers "
                "hold, and so do floats next to a value that is not finite (nan, inf). The run ends "
                "with the file.")
            ->check(host::existing_file())
            ->type_name("FILE.csv");
    CLI::Option* const columns =
        command
            .add_option("--columns", options.replay.columns,
                        "Pins to write, when the replayed file is from halsampler and has no header.")
            ->delimiter(',')
            ->allow_extra_args(false)
            ->needs(replay)
            ->type_name("PIN,...");
    CLI::Option* const sample_period =
        add_time(
            command, "--sample-period", [&](Time time) { options.replay.sample_period = time; },
            "Time from row to row of such a file.")
            ->needs(replay);
    columns->needs(sample_period);
    sample_period->needs(columns);
    command
        .add_flag("--override", options.replay.override_links,
                  "Replays into pins that are netted as well, against their writers.")
        ->needs(replay);

    command
        .add_option(
            "--expect", options.expect,
            "A statement that must hold after every period, about names in braces and their changes per "
            "second: "
            "abs({pid.out}) <= 10 && abs({pid.out}_rate) < 100. Also finite({pid.out}). May be given many "
            "times.")
        ->allow_extra_args(false)
        ->check([](const std::string& text) {
            try {
                host::parse_statement(text);
                return std::string();
            } catch (const std::invalid_argument& error) {
                return std::string(error.what());
            }
        })
        ->type_name("STATEMENT");

    CLI::Option* const record =
        command.add_option("--record", options.record, "Pins, parameters and signals to record.")
            ->delimiter(',')
            ->allow_extra_args(false)
            ->type_name("PIN,...");
    CLI::Option* const every =
        add_time(
            command, "--every", [&](Time time) { options.every = time; }, "Time from row to row.")
            ->needs(record);
    CLI::Option* const output =
        command
            .add_option("--output", options.output,
                        "Where to record: a CSV file with a header; column time is in seconds.")
            ->needs(record)
            ->type_name("FILE.csv");
    record->needs(every)->needs(output);

    command
        .add_option("--modules", options.modules,
                    "Folder of realtime modules to search first. May be given many times.")
        ->check(host::existing_folder())
        ->allow_extra_args(false)
        ->type_name("DIR");
    command
        .add_option("--option", options.module_options,
                    "Overrides this option of the module's loadrt line: threads.period1=4000000. May be "
                    "given many times.")
        ->allow_extra_args(false)
        ->check(host::option_problem)
        ->type_name("MODULE.NAME=VALUE");
    command.add_flag(
        "--models", options.models,
        "Puts models in the place of drivers whose hardware is not here, and of programs that need a screen "
        "or a device.");
    command.add_flag_callback(
        "--no-namespaces", [&] { options.namespaces = false; },
        "Runs on the computer's one HAL, one bench at a time. Where the system forbids namespaces, this is "
        "the "
        "default, with a note.");
    command.final_callback([duration, replay, &options] {
        if (options.files.empty() && options.ini.empty()) throw CLI::RequiredError("--ini or FILE.hal");
        if (!duration->count() && !replay->count()) throw CLI::RequiredError("--for");
        std::set<std::string> recorded;
        for (const std::string& name : options.record)
            if (!recorded.insert(name).second)
                throw CLI::ValidationError("--record", "'" + name + "' stands there twice");
        std::error_code no_file;
        if (std::filesystem::equivalent(options.output, options.replay.file, no_file))
            throw CLI::ValidationError(
                "--output", "'" + options.output + "' is the file that is replayed: it would be overwritten");
    });
}

hal::CommandPage bench_page() {
    return {
        "plumb-bench",
        "{FILE.hal... | --ini FILE.ini} --for TIME [options]",
        {{"DESCRIPTION",
          R"(plumb bench loads .hal files with LinuxCNC's own halcmd and simulates their realtime threads faster than the
clock. HAL, its threads and the modules are the real ones; only the time is virtual. Each function gets the nominal period,
as on the machine. The threads start even if no file contains start.

A TIME is a number with a unit, ns, us, ms, s, min, h or d; without a unit it is in seconds: 600, 250ms, 10min, 4h.)"},
         {"BEHAVIOUR",
          R"(Two runs of the same files produce identical values on one kind of processor. On another kind, with or without
fused multiply-add, the last digit can differ. A file that starts user-space programs (loadusr) gives no such guarantee,
because they follow the computer's clock; plumb bench then prints a note.

The bench has a HAL of its own. It disturbs no LinuxCNC on the same computer, and no other bench.

Ctrl-C ends the run cleanly and keeps the recording. If a realtime function does not return within 5 s of the computer's
clock, or a module is not loaded within 60 s, the bench names the function or module and ends with 1.)"},
         {"STATEMENTS",
          R"(A statement for --expect is an expression of muParser that is true or false. It is one of these:

  {limit.out} <= 5             a comparison: < <= > >= == !=
  {motion.in-position}         a pin of type bit, 0 or 1
  finite({pid.out})            0 if the value is infinite or not a number
  A && B, A || B, C ? A : B    several; write "not" as == 0

You can use + - * / ^, brackets, and functions such as abs, min, max, sqrt, sin, cos, atan2, exp, ln, log10, sign and rint.
{NAME}_rate is the change of a value per second since the last period.

Expressions that cannot fail or would change a value are refused: a number alone, {NAME} = 5 (write ==), a comma outside
a function, and 0 < {NAME} < 5 (write 0 < {NAME} && {NAME} < 5).)"},
         {"A WHOLE MACHINE",
          R"(With --ini and no FILE.hal, the bench loads the realtime side of the machine as LinuxCNC's script linuxcnc does:
tpmod and homemod or their [TRAJ]TPMOD and [EMCMOT]HOMEMOD, each [HAL]HALFILE in order, .hal and .tcl, also from LIB:, or all
of them with TWOPASS, then each [HAL]HALCMD. They run in the folder of the INI file, with HALLIB_DIR, INI_FILE_NAME and the
other variables of the script. #INCLUDE lines are followed.

A bench has no task, io or halui. Their pins iocontrol.0.* and halui.* are there, and rest, so motion is never enabled; a
note says that joints stand. POSTGUI_HALFILE is not loaded: there is no screen.)"},
         {"MODELS",
          R"(With --models, drivers whose hardware is not here are models; plumb-run(1) says what they do. Joints need the INI
file, by --ini.)"},
         {"EXIT STATUS",
          R"(0 if the whole time was simulated and every statement held; 1 if a statement did not hold, or after an error; 2
for a wrong command line; 130 after Ctrl-C.)"},
         {"EXAMPLES",
          R"(Four hours of a filter, one row a second:

  plumb bench filter.hal --for 4h \
    --record filter.in,filter.out --every 1s --output filter.csv

The HAL of a whole machine, without its hardware:

  plumb bench --ini my.ini --models --for 1min --expect 'finite({joint.0.motor-pos-cmd})'

An hour that passes a test, or reports the first failure:

  plumb bench filter.hal --for 1h --expect 'abs({filter.out}) <= 1' \
    --expect 'abs({filter.out}_rate) <= 20'

A recording of the machine, made with halsampler at 1 kHz, replayed into a component:

  plumb bench component.hal \
    --replay load.txt --columns it.load --sample-period 1ms \
    --record it.contact --every 1ms --output contact.csv)"},
         {"LIMITS",
          R"(A bench has no motion of LinuxCNC unless the files load it, and no G-code. plumb-run(1) runs a complete
LinuxCNC.)"}},
        ".BR plumb (1),\n.BR plumb\\-run (1),\n.BR halcmd (1),\n.BR halsampler (1)"};
}

// Returns the exit status: 0, or 128 + N when signal N ended the run. Throws std::runtime_error.
int bench(const BenchOptions& options) {
    Start start;
    start.modules = options.modules;
    start.module_options = options.module_options;
    start.namespaces = options.namespaces;
    start.show_output = true;
    std::unique_ptr<Client> owned;
    if (options.files.empty()) {
        owned = host_of(machine_of(options.ini, options.models), start);
    } else {
        if (options.models) {
            std::vector<std::string> files = options.files;
            if (!options.ini.empty()) files.insert(files.begin(), options.ini);
            start.models = models_of(files);
        }
        owned = std::make_unique<Client>(start);
        load_files(*owned, options);
    }
    Client& host = *owned;
    prepare(host, options);
    std::vector<std::string> programs = host.programs();

    Time duration = options.duration.value_or(Time::max());
    if (!options.replay.file.empty()) duration = std::min(duration, host.replay(options.replay));
    const Interruption interruption;
    if (!options.record.empty()) host.record("bench", {options.record, options.every, options.output});
    const auto begin = Clock::now();
    const Ran ran = run(host, duration, interruption);
    const double real_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    if (!options.record.empty()) host.record_stop("bench");

    if (!programs.empty())
        std::cerr << "note: user-space programs took part (" << joined(programs)
                  << "), so another run need not give the same values\n";
    std::cout << "simulated " << describe_duration(ran.ran);
    if (interruption.number()) std::cout << " of " << describe_duration(duration) << ", then interrupted,";
    std::cout << " in " << describe_duration(seconds(real_seconds)) << ", "
              << times_real_time(ran.ran, real_seconds) << '\n';
    if (!options.record.empty())
        std::cout << "recorded " << joined(options.record) << " every " << describe_duration(options.every)
                  << " in " << options.output << '\n';
    const bool held = report_expectations(host, options.expect);
    if (interruption.number()) return 128 + interruption.number();
    return held ? 0 : 1;
}

const Command command{"bench", "runs .hal files in virtual time and records pins", [](int argc, char** argv) {
                          CLI::App app(command.summary, "plumb bench");
                          BenchOptions options;
                          declare_bench(app, options);
                          hal::begin_command_line(app, bench_page);
                          return hal::carry_out(app, argc, argv, [&] { return bench(options); });
                      }};

}  // namespace
}  // namespace plumb::commands
