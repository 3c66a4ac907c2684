// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/control.hpp"

#include <rtapi.h>
#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "hal/host/decimal.hpp"
#include "hal/host/faster_clock.hpp"
#include "hal/host/guard.hpp"
#include "hal/host/hal_memory.hpp"
#include "hal/host/ini_file_of.hpp"
#include "hal/host/line_buffer.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/names.hpp"
#include "hal/host/output_of.hpp"
#include "hal/host/request.hpp"
#include "hal/host/run_watch.hpp"
#include "hal/host/scheduler.hpp"

namespace plumb::host {

namespace {

using Json = nlohmann::json;

constexpr int protocol = 1;

Json okay() {
    return {{"ok", true}};
}

Json number(double value) {
    if (std::isfinite(value)) return value;
    std::string text;
    append_number(text, std::isnan(value) ? NAN : value);
    return text;
}

Json value_of(const Cell& cell) {
    const double value = cell.value.number();
    switch (cell.value.type()) {
        case hal::AnyValue::Type::bit: return value != 0.0;
        case hal::AnyValue::Type::real: return number(value);
        default: return static_cast<std::int64_t>(value);
    }
}

// A value from a client, as text for halcmd.
std::string text_of(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
    if (value.is_number_integer()) return value.dump();
    std::string text;
    if (value.is_number()) append_number(text, value.get<double>());
    if (text.empty()) throw std::runtime_error(Request::shown(value) + " is no value of a pin");
    return text;
}

// halcmd's message without its "<commandline>:0: ", its last line and line ends.
std::string sentence(std::string text) {
    const std::string prefix = "<commandline>:0: ";
    for (const std::string last : {"setp failed\n", "sets failed\n"})
        if (const std::size_t at = text.rfind(last); at != std::string::npos) text.erase(at, last.size());
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix))
        text.erase(at, prefix.size());
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text.empty() ? "halcmd refuses without a word" : text;
}

}  // namespace

Control::Control(Settings settings)
    : settings_(std::move(settings)),
      modules_(settings_.module_folders, settings_.module_options, settings_.models),
      timeline_(modules_.models()),
      server_(*this, settings_.control_descriptor) {
    setenv("RTAPI_FIFO_PATH", server_.path().c_str(), 1);
    if (settings_.namespaces) modules_.models().cover_programs();
    if (settings_.speed <= 0.0) return;
    pace_.emplace(settings_.speed);
    set_clock_speed(std::isinf(settings_.speed) ? most_speed : settings_.speed);
    timeline_.begin(never);
}

Control::~Control() {
    programs_.end_all();
}

void Control::serve(int end_descriptor) {
    while (!end_ && !server_.client_gone()) attend(end_descriptor);
    server_.flush();
}

int Control::run_program(const std::vector<std::string>& words, int end_descriptor) {
    using Clock = Pace::Clock;
    constexpr auto patience = std::chrono::seconds(10);
    constexpr auto alone =
        std::chrono::seconds(1);  // a shell hears of a signal only once its own child has ended
    if (settings_.namespaces) files_.emplace(settings_.devices);
    start_program(words);
    const auto began = Clock::now();
    std::optional<Clock::time_point> asked;
    bool asked_all = false;
    RunWatch watch;
    bool given_up = false;
    while (!programs_.program_status() && !(asked && Clock::now() - *asked > patience)) {
        attend(asked ? -1 : end_descriptor);
        if (!end_) {
            if (const auto why = watch.look(programs_, modules_.hal_library_loaded())) {
                std::fprintf(stderr, "plumb run: %s. The run ends.\n", why->c_str());
                end_ = given_up = true;
            }
        }
        if (!end_) continue;
        if (!asked) {
            if (end_by_signal_)
                std::fprintf(
                    stderr,
                    "plumb run: a signal (SIGTERM or SIGHUP) asked the run to end before its program "
                    "had ended\n");
            programs_.ask_program_to_end();
            asked = Clock::now();
        } else if (!asked_all && Clock::now() - *asked > alone) {
            programs_.ask_all_to_end();
            asked_all = true;
        }
    }
    server_.flush();
    report_lost_pace(Clock::now() - began);
    const int status = programs_.program_status().value_or(128 + SIGKILL);  // it will not survive the host
    programs_.end_all();
    const bool complete = !files_ || files_->bring_back();
    return given_up || (status == 0 && !complete) ? 1 : status;
}

void Control::start_program(const std::vector<std::string>& words) {
    std::optional<FasterClock> clock;
    try {
        if (settings_.speed != 1.0 && std::isfinite(settings_.speed)) clock.emplace(settings_.speed);
    } catch (const std::runtime_error& error) {
        std::fprintf(
            stderr, "plumb run: %s, so programs see the computer's own clock (apt-get install libfaketime)\n",
            error.what());
    }
    programs_.start_program(words);
}

void Control::report_lost_pace(std::chrono::nanoseconds real) const {
    constexpr double negligible = 0.05;
    const double lost =
        std::chrono::duration<double>(pace_->given_up()) / std::chrono::duration<double>(real);
    if (lost < negligible) return;
    std::fprintf(stderr,
                 "plumb run: the computer did not keep up: %.3g times its clock's speed instead of %g\n",
                 settings_.speed * (1.0 - lost), settings_.speed);
}

void Control::attend(int end_descriptor) {
    std::vector<pollfd> waits{{end_descriptor, POLLIN, 0}};
    server_.add_to(waits);
    programs_.add_to(waits);
    const auto idle = idle_time();
    const timespec patience{idle / std::chrono::seconds(1), (idle % std::chrono::seconds(1)).count()};
    ppoll(waits.data(), waits.size(), &patience, nullptr);
    if (waits.front().revents != 0) {
        end_ = end_by_signal_ = true;
        return;
    }
    programs_.attend(waits);
    if (timeline_.running()) {
        move([this] { let_time_pass(); });
        show_progress();
    }
    server_.serve(waits);
}

std::chrono::nanoseconds Control::idle_time() {
    using namespace std::chrono_literals;
    if (server_.has_requests()) return 0ns;
    std::chrono::nanoseconds idle = programs_.waits_for_hal() ? 100ms : 1s;
    if (!timeline_.running()) {
        // The next request of a client often comes at once, and going to sleep takes longer.
        constexpr auto awake = 20us;
        return std::chrono::steady_clock::now() - answered_ > awake ? idle : 0ns;
    }
    if (!pace_) return 0ns;
    const Nanoseconds next = timeline_.next_instant();
    if (next == never) return idle;
    if (pace_->free()) return rest();
    constexpr std::chrono::nanoseconds least = 50us;  // going to sleep takes about as long
    const auto until_next = std::max(rest(), pace_->until(next, Pace::Clock::now()));
    return until_next <= 0ns ? 0ns : std::clamp(until_next, least, idle);
}

std::chrono::nanoseconds Control::rest() const {
    return std::max(std::chrono::nanoseconds(0), std::chrono::nanoseconds(rest_until_ - Pace::Clock::now()));
}

void Control::let_time_pass() {
    constexpr auto slice = std::chrono::milliseconds(2);
    constexpr auto between_looks = std::chrono::milliseconds(50);
    constexpr auto task_looks = std::chrono::microseconds(200);
    if (!pace_) {
        timeline_.go_on(slice);
        return;
    }
    const auto now = Pace::Clock::now();
    if (now < rest_until_) return;
    if (timeline_.watches() && now - last_look_ > between_looks) {
        last_look_ = now;
        if (modules_.hal_library_loaded()) timeline_.look_again();
    }
    Scheduler& tasks = scheduler();
    const bool idle = tasks.next_release() == never;  // no period is owed
    const Nanoseconds limit = idle ? pace_->instant(now) : pace_->due(now, tasks.time());
    // Task reads the status twice after its command. A period that began meanwhile would write it again.
    if (timeline_.go_on(slice, limit)) rest_until_ = Pace::Clock::now() + task_looks;
    if (idle && limit != never) tasks.advance(std::max(tasks.time(), limit));
}

void Control::show_progress() {
    constexpr auto between_progress = std::chrono::milliseconds(200);
    const auto now = std::chrono::steady_clock::now();
    if (!runner_ || now - last_progress_ < between_progress) return;
    last_progress_ = now;
    server_.send(*runner_, Json{{"progress", timeline_.ran()}}.dump());
}

void Control::move(const std::function<void()>& timeline_action) {
    Json result;
    try {
        timeline_action();
        if (timeline_.running()) return;
        result = {{"ok", true}, {"time", scheduler().time()}, {"ran", timeline_.ran()}};
        if (timeline_.ended_by_replay()) result["ended"] = "replay";
    } catch (const std::runtime_error& error) {
        result = {{"ok", false}, {"error", error.what()}};
    }
    if (!runner_) return;
    const Server::Connection runner = *runner_;
    runner_.reset();
    answer(runner, result);
}

void Control::stop() {
    move([this] { timeline_.stop(); });
}

void Control::unload_all() {
    modules_.unload_all();
    let_unloaded_go();
}

void Control::let_unloaded_go() {
    if (!modules_.hal_library_loaded()) programs_.let_halcmd_go();
    if (!timeline_.running()) return;
    if (!modules_.hal_library_loaded())
        timeline_.lose_names();
    else if (pace_ && timeline_.watches())
        timeline_.look_again();  // at once: HAL has something else in that memory now
}

RtapiAnswer Control::rtapi_command(const std::vector<std::string>& words, pid_t process) {
    const OutputOf output(process);
    if (words.empty()) return {0};
    const std::string& command = words[0];
    if (command == "exit" && words.size() == 1) {
        // Stock rtapi_app ends, and the next halcmd starts a new one; here the next one finds an empty host.
        realtime_ = false;
        if (programs_.program_runs())
            unload_all();
        else
            end_ = true;
        return {0};
    }
    if (command == "load" && words.size() >= 2) {
        realtime_ = true;
        take_over_ini_file(process);
        const int result = modules_.load(words[1], {words.begin() + 2, words.end()});
        let_unloaded_go();
        return {result};
    }
    if (command == "unload" && words.size() == 2) {
        const int result = modules_.unload(words[1]);
        let_unloaded_go();
        return {result};
    }
    if (command == "newinst" && (words.size() == 3 || words.size() == 4))
        return {modules_.new_instance(words[1], words[2], words.size() == 4 ? words[3] : "")};
    // LinuxCNC 2.10 alone has these.
    if (command == "start" && words.size() == 1) {
        realtime_ = true;
        return {0};
    }
    if (command == "ping" && words.size() == 1) return {realtime_ ? 0 : 1};
    if (command == "check_rt" && words.size() == 1) return {1, "No realtime"};
    if (command == "debug" && words.size() == 2) {
        char* end = nullptr;
        const long level = std::strtol(words[1].c_str(), &end, 10);
        if (words[1].empty() || *end != '\0' || level < RTAPI_MSG_NONE || level > RTAPI_MSG_ALL) {
            print_message("The debug level '" + words[1] + "' is not a number from 0 to 5\n", true);
            return {-EINVAL};
        }
        return {rtapi_set_msg_level(static_cast<int>(level))};
    }
    print_message("Unrecognized command starting with " + command + "\n", true);
    return {-1};
}

void Control::control_request(Server::Connection from, const std::string& line) {
    try {
        const Request request(line);
        if (const auto result = carry_out(from, request)) answer(from, *result);
    } catch (const std::exception& error) {
        answer(from, {{"ok", false}, {"error", error.what()}});
    }
}

void Control::request_too_long(Server::Connection from) {
    answer(from,
           {{"ok", false},
            {"error", "the request is longer than " + std::to_string(LineBuffer::longest >> 20) + " MiB"}});
}

void Control::control_request_waits(const std::string& line) {
    try {
        if (Request(line).what() == "stop" && !pace_) stop();
    } catch (const std::runtime_error&) {
        // It is refused when its turn comes.
    }
}

void Control::closed(Server::Connection connection) {
    if (runner_ != connection) return;
    runner_.reset();  // nobody wants the run any more
    stop();
}

std::optional<Json> Control::carry_out(Server::Connection from, const Request& request) {
    const std::string& what = request.what();
    if (what == "hello") return hello();
    if (what == "halcmd") return halcmd(from, request), std::nullopt;
    if (what == "get") return get(request);
    if (what == "set") return set(request);
    if (what == "run") return run(from, request), std::nullopt;
    if (what == "record") return record(request);
    if (what == "replay") return replay(request);
    if (what == "expect") return expect(request);
    if (what == "violations") return violations();
    if (what == "programs") return programs();
    if (what == "guard") return guard();
    if (what == "record-stop") {
        timeline_.stop_recording(request.required<std::string>("id"));
        return okay();
    }
    if (what == "stop") {
        if (!pace_) stop();
        return okay();
    }
    if (what == "exit") {
        end_ = true;
        return okay();
    }
    throw std::runtime_error("'" + what.substr(0, 60) + "' is no request of this host");
}

void Control::answer(Server::Connection to, const Json& result) {
    server_.answer(to, result.dump(-1, ' ', false, Json::error_handler_t::replace));
    answered_ = std::chrono::steady_clock::now();
}

void Control::need_hal() {
    if (!modules_.need_hal_library()) throw std::runtime_error("LinuxCNC's hal_lib cannot be loaded");
}

Json Control::hello() const {
    return {{"ok", true},
            {"protocol", protocol},
            {"pid", settings_.process},
            {"time", scheduler().time()},
            {"paced", pace_.has_value()},
            {"hal-version", hal_memory() == nullptr ? 0 : hal_memory()->version},
            {"namespaces", settings_.namespaces},
            {"socket", server_.path()},
            {"modules", modules_.folders()}};
}

void Control::halcmd(Server::Connection from, const Request& request) {
    programs_.start_halcmd(
        request.required<std::vector<std::string>>("args"), request.optional<std::string>("cwd", ""),
        [this, from](Finished finished) {
            const auto beside = modules_.hal_library_loaded() ? std::nullopt : realtime_beside(programs_);
            if (beside) finished = {std::max(finished.status, 1), finished.output + *beside + "\n"};
            answer(from, {{"ok", true}, {"status", finished.status}, {"output", finished.output}});
        });
}

Json Control::get(const Request& request) {
    const auto names = request.required<std::vector<std::string>>("names");
    need_hal();
    const Names look;
    Json values = Json::array();
    Json types = Json::array();
    for (const std::string& name : names) {
        const Cell cell = look.need(name);
        values.push_back(value_of(cell));
        types.push_back(cell.value.type_name());
    }
    return {{"ok", true}, {"values", values}, {"types", types}};
}

Json Control::set(const Request& request) {
    const auto name = request.required<std::string>("name");
    set_value(name, request.required<Json>("value"));
    return okay();
}

void Control::set_value(const std::string& name, const Json& value) {
    need_hal();
    const std::optional<Cell> cell = Names().find(name);
    const std::string text = text_of(value);
    const std::optional<double> number = number_of(text);
    const bool signal = cell && cell->kind == Cell::Kind::signal;
    if (cell && number && !cell->linked && cell->value.accepts(*number) && (signal || settable(name))) {
        cell->value.set_number(*number);
        return;
    }
    const Finished halcmd = programs_.halcmd({signal ? "sets" : "setp", name, text});
    if (halcmd.status != 0) throw std::runtime_error(sentence(halcmd.output));
    settable_.insert(name);  // of a user-space program, perhaps, that has made it since
}

bool Control::settable(const std::string& name) {
    const unsigned long now = programs_.halcmds_begun() + modules_.changes();
    if (settable_at_ != now) list_settable();
    settable_at_ = now;
    return settable_.count(name) > 0;
}

void Control::list_settable() {
    settable_.clear();
    for (const char* const kind : {"pin", "param"}) {
        // One line each: owner, type, direction, value, name.
        std::istringstream table(programs_.halcmd({"show", kind}).output);
        for (std::string line; std::getline(table, line);) {
            std::istringstream words(line);
            std::string owner, type, direction, value, name;
            words >> owner >> type >> direction >> value >> name;
            if (direction == "IN" || direction == "I/O" || direction == "RW") settable_.insert(name);
        }
    }
}

void Control::run(Server::Connection from, const Request& request) {
    if (pace_) throw std::runtime_error("time passes by itself in this host");
    if (timeline_.running()) throw std::runtime_error("a run is under way already");
    if (timeline_.watches()) need_hal();
    timeline_.begin(request.span("ns", 0));
    runner_ = from;
    last_progress_ = std::chrono::steady_clock::now();
    move([this] { let_time_pass(); });  // most runs are short
}

Json Control::record(const Request& request) {
    need_hal();
    Recorder::Settings settings{request.required<std::string>("file"),
                                request.required<std::vector<std::string>>("names"), request.span("every", 1),
                                request.optional<bool>("append", false)};
    timeline_.record(request.required<std::string>("id"),
                     std::make_unique<Recorder>(std::move(settings), Names()));
    return okay();
}

Json Control::replay(const Request& request) {
    need_hal();
    Replayer::Settings settings{request.required<std::string>("file"),
                                request.optional<std::vector<std::string>>("columns", {}), 0};
    if (!settings.columns.empty()) settings.sample_period = request.span("sample-period", 1);
    auto replayer = std::make_unique<Replayer>(std::move(settings));
    const bool override_writer = request.optional<bool>("override", false);
    for (const std::string& column : replayer->columns()) make_replayable(column, override_writer);
    replayer->resolve(Names());
    const Nanoseconds duration = replayer->duration();
    timeline_.replay(std::move(replayer));
    return {{"ok", true}, {"duration", duration}};
}

void Control::make_replayable(const std::string& name, bool override_writer) {
    const Cell cell = Names().need(name);
    const std::string signal = cell.kind == Cell::Kind::signal ? name : cell.linked ? signal_of(name) : "";
    if (signal.empty()) {
        set_value(name, number(cell.value.number()));  // halcmd refuses a pin that is no input
        return;
    }
    const std::string writer = writer_of(signal);
    if (writer.empty()) return;  // as with sets
    if (cell.kind == Cell::Kind::signal)
        throw std::runtime_error("signal '" + name + "' is written by pin '" + writer +
                                 "': nothing else can be its source");
    if (writer == name)
        throw std::runtime_error("pin '" + name + "' is an output: it writes signal '" + signal + "'");
    if (!override_writer)
        throw std::runtime_error("pin '" + name + "' is netted to signal '" + signal +
                                 "', which is written by pin '" + writer + "'");
    const Finished unlinked = programs_.halcmd({"unlinkp", name});
    if (unlinked.status != 0) throw std::runtime_error(sentence(unlinked.output));
}

std::string Control::signal_of(const std::string& pin) {
    // One line a pin: owner, type, direction, value, name, and of a linked one an arrow and the signal.
    std::istringstream table(programs_.halcmd({"show", "pin", pin}).output);
    for (std::string line; std::getline(table, line);) {
        std::istringstream words(line);
        std::string word, name, signal;
        if (words >> word >> word >> word >> word >> name >> word >> signal && name == pin) return signal;
    }
    return "";
}

std::string Control::writer_of(const std::string& signal) {
    // One line a signal: type, value, name, and for each linked pin an arrow, "<==" from its writer, and the
    // pin.
    std::istringstream table(programs_.halcmd({"-s", "show", "sig", signal}).output);
    for (std::string line; std::getline(table, line);) {
        std::istringstream words(line);
        std::string word, name, arrow, pin;
        if (!(words >> word >> word >> name) || name != signal) continue;
        while (words >> arrow >> pin)
            if (arrow == "<==") return pin;
    }
    return "";
}

Json Control::expect(const Request& request) {
    need_hal();
    timeline_.expectations().add(request.required<std::string>("id"),
                                 request.required<std::string>("expression"),
                                 request.required<std::map<std::string, std::string>>("variables"), Names());
    return okay();
}

Json Control::violations() {
    Json list = Json::array();
    for (const Violation& violation : timeline_.expectations().violations()) {
        Json values = Json::object();
        for (const auto& [name, value] : violation.values) values[name] = number(value);
        list.push_back({{"id", violation.id},
                        {"count", violation.count},
                        {"first-time", violation.first_time},
                        {"values", values}});
    }
    return {{"ok", true}, {"violations", list}};
}

Json Control::guard() {
    if (!guard_enabled()) throw std::runtime_error("the guard is off: start the host with --guard");
    Json list = Json::array();
    for (const Misdeed& misdeed : misdeeds())
        list.push_back({{"function", misdeed.function}, {"what", misdeed.what}});
    return {{"ok", true}, {"violations", list}};
}

Json Control::programs() {
    return {{"ok", true}, {"names", programs_.alive()}};
}

}  // namespace plumb::host
