// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/programs.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include <cerrno>

#include "hal/host/hal_lock.hpp"
#include "hal/host/is_ready.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/standing_halcmd.hpp"

extern char** environ;

namespace plumb::host {

namespace {

constexpr auto patience_with_halcmd = std::chrono::seconds(10);

int exit_status(int wait_status) {
    return WIFSIGNALED(wait_status) ? 128 + WTERMSIG(wait_status) : WEXITSTATUS(wait_status);
}

// Parent of a process, or -1 when it is gone or a zombie.
pid_t parent_of(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string text;
    std::getline(file, text);
    const std::size_t end_of_name = text.rfind(')');
    if (end_of_name == std::string::npos) return -1;
    std::istringstream rest(text.substr(end_of_name + 1));
    char state = 0;
    pid_t parent = -1;
    rest >> state >> parent;
    return state == 'Z' || state == 'X' ? -1 : parent;
}

std::string program_name(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/comm");
    std::string name;
    std::getline(file, name);
    return name;
}

bool any_called_halcmd(const std::vector<pid_t>& processes) {
    return std::any_of(processes.begin(), processes.end(),
                       [](pid_t process) { return program_name(process) == "halcmd"; });
}

// The output without the greeting of LinuxCNC's rtapi_app each time that root runs it.
std::string without_greeting(const std::string& text) {
    std::istringstream lines(text);
    std::string rest;
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("Running with fallback_uid.", 0) == 0) continue;
        rest += line;
        if (!lines.eof()) rest += '\n';
    }
    return rest;
}

// Lets programs begin with no signal blocked, nor ignored because of the host.
class SpawnSettings {
public:
    SpawnSettings() {
        posix_spawnattr_init(&attributes_);
        sigset_t signals;
        sigemptyset(&signals);
        posix_spawnattr_setsigmask(&attributes_, &signals);
        sigaddset(&signals, SIGPIPE);
        posix_spawnattr_setsigdefault(&attributes_, &signals);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    }
    ~SpawnSettings() { posix_spawnattr_destroy(&attributes_); }
    SpawnSettings(const SpawnSettings&) = delete;

    // Starts the program `words`, looked for in PATH. Returns 0 or an errno.
    int spawn(pid_t& process, const std::vector<std::string>& words,
              const posix_spawn_file_actions_t* actions) const {
        std::vector<char*> argv;
        for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
        argv.push_back(nullptr);
        return posix_spawnp(&process, argv.front(), actions, &attributes_, argv.data(), environ);
    }

private:
    posix_spawnattr_t attributes_;
};

}  // namespace

struct Programs::Command {
    pid_t process;  // 0 once it has ended; its own programs may still print
    int output;     // -1 once nobody holds the other end
    std::function<void(Finished)> done = {};
    std::string text = {};
    std::unique_ptr<StandingHalcmd> stands = {};  // one that takes further commands
    Clock::time_point rests_since = {};

    bool rests() const { return stands && !done; }
    bool runs() const { return process != 0 && !rests(); }
};

Programs::Programs() {
    sigset_t children;
    sigemptyset(&children);
    sigaddset(&children, SIGCHLD);
    sigprocmask(SIG_BLOCK, &children, nullptr);
    child_events_ = signalfd(-1, &children, SFD_CLOEXEC | SFD_NONBLOCK);
    if (child_events_ < 0) throw std::runtime_error(std::string("signalfd: ") + std::strerror(errno));
    set_message_sink([this](std::string_view text, bool) {
        for (auto command = commands_.rbegin(); command != commands_.rend(); ++command) {
            if (!command->runs()) continue;
            read_output(*command);  // the output of halcmd so far
            command->text += text;
            return true;
        }
        return false;
    });
}

Programs::~Programs() {
    set_message_sink({});
    for (Command& command : commands_)
        if (command.output >= 0) close(command.output);
    close(child_events_);
}

void Programs::start_program(const std::vector<std::string>& words) {
    const SpawnSettings settings;
    const int error = settings.spawn(program_, words, nullptr);
    if (error == 0) return;
    throw ProgramNotFound("cannot start " + words.front() + ": " + std::strerror(error),
                          error == ENOENT ? 127 : 126);
}

void Programs::ask_program_to_end() const {
    if (program_runs()) kill(program_, SIGTERM);
}

void Programs::ask_all_to_end() const {
    for (const pid_t process : others()) kill(process, SIGTERM);
}

Programs::Command& Programs::spawn_halcmd(const std::vector<std::string>& words, const std::string& directory,
                                          int input) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!directory.empty()) posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
    if (input >= 0)
        posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    else
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);

    const SpawnSettings settings;
    pid_t process = 0;
    const int error = settings.spawn(process, words, &actions);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (error != 0) {
        close(ends[0]);
        throw std::runtime_error("cannot start halcmd" + (directory.empty() ? "" : " in " + directory) +
                                 ": " + std::strerror(error));
    }
    return commands_.emplace_back(Command{process, ends[0]});
}

Programs::Command* Programs::standing_halcmd() {
    for (Command& command : commands_)
        if (command.process != 0 && command.stands && !command.stands->let_gone()) return &command;
    return nullptr;
}

Programs::Command& Programs::halcmd_for(const std::vector<std::string>& arguments,
                                        const std::string& directory) {
    ++halcmds_begun_;
    Command* const standing = standing_halcmd();
    const bool stays = program_ == 0 && StandingHalcmd::takes(arguments);
    if (stays && standing != nullptr && standing->rests() && standing->stands->give(arguments))
        return *standing;
    await_halcmd_gone();
    if (stays && standing_halcmd() == nullptr) {
        auto stands = std::make_unique<StandingHalcmd>();
        stands->give(arguments);
        Command& command = spawn_halcmd(StandingHalcmd::words(), "", stands->input());
        stands->has_begun();
        command.stands = std::move(stands);
        return command;
    }
    std::vector<std::string> words{"halcmd"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return spawn_halcmd(words, directory, -1);
}

void Programs::start_halcmd(const std::vector<std::string>& arguments, const std::string& directory,
                            std::function<void(Finished)> done) {
    halcmd_for(arguments, directory).done = std::move(done);
}

void Programs::let_halcmd_go() {
    if (Command* const standing = standing_halcmd()) standing->stands->let_go();
}

void Programs::look(int milliseconds) {
    std::vector<pollfd> waits;
    add_to(waits);
    poll(waits.data(), waits.size(), milliseconds);
    attend(waits);
}

void Programs::await_halcmd_gone() {
    if (Command* const standing = standing_halcmd(); standing != nullptr && standing->rests())
        let_halcmd_go();
    const auto goes = [](const Command& command) {
        return command.process != 0 && command.rests() && command.stands->let_gone();
    };
    for (const auto begin = Clock::now(); std::any_of(commands_.begin(), commands_.end(), goes);) {
        for (const Command& command : commands_)
            if (goes(command) && Clock::now() - begin > patience_with_halcmd) kill(command.process, SIGKILL);
        look(100);
    }
}

Finished Programs::halcmd(const std::vector<std::string>& arguments) {
    bool ended = false;
    Finished finished{};
    Command& command = halcmd_for(arguments, "");
    command.done = [&](Finished result) {
        ended = true;
        finished = std::move(result);
    };
    --halcmds_begun_;  // it links nothing
    for (const auto begin = Clock::now(); !ended;) {
        if (Clock::now() - begin > patience_with_halcmd) {
            command.done = [](const Finished&) {};
            kill(command.process, SIGKILL);
            throw std::runtime_error("halcmd " + arguments.front() + " did not end within 10 s");
        }
        look(100);
    }
    return finished;
}

void Programs::add_to(std::vector<pollfd>& waits) const {
    waits.push_back({child_events_, POLLIN, 0});
    for (const Command& command : commands_)
        if (command.output >= 0) waits.push_back({command.output, POLLIN, 0});
}

bool Programs::waits_for_hal() const {
    return program_runs() || std::any_of(commands_.begin(), commands_.end(),
                                         [](const Command& command) { return command.process != 0; });
}

bool Programs::halcmd_runs() const {
    return std::any_of(commands_.begin(), commands_.end(),
                       [](const Command& command) { return command.runs(); });
}

void Programs::read_output(Command& command) {
    char buffer[4096];
    while (command.output >= 0) {
        const ssize_t count = read(command.output, buffer, sizeof buffer);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return;  // nothing more for now
        if (count == 0) {
            close(command.output);
            command.output = -1;
            return;
        }
        const std::string_view text(buffer, static_cast<std::size_t>(count));
        if (command.runs())
            command.text += text;
        else
            print_message(text, false);  // a user-space program that goes on after its halcmd
    }
}

void Programs::attend(const std::vector<pollfd>& seen) {
    // A program of the user's may be late on a busy computer.
    if (waits_for_hal()) watch_hal_lock(std::chrono::seconds(halcmd_runs() ? 1 : 5));
    for (Command& command : commands_)
        if (is_ready(seen, command.output)) read_output(command);
    attend_standing_halcmd();
    if (is_ready(seen, child_events_)) reap();
    commands_.remove_if([](const Command& command) { return command.process == 0 && command.output < 0; });
}

void Programs::attend_standing_halcmd() {
    constexpr auto longest_rest = std::chrono::milliseconds(200);
    Command* const standing = standing_halcmd();
    if (standing == nullptr) return;
    if (standing->rests()) {
        if (Clock::now() - standing->rests_since > longest_rest) let_halcmd_go();
        return;
    }
    const std::optional<std::string> output = standing->stands->whole_output(standing->text);
    if (!output) return;
    standing->text.clear();
    standing->rests_since = Clock::now();
    std::exchange(standing->done, {})({0, without_greeting(*output)});
}

void Programs::reap() {
    signalfd_siginfo event;
    while (read(child_events_, &event, sizeof event) > 0)
        continue;  // one event may stand for several children
    int status = 0;
    for (pid_t process = waitpid(-1, &status, WNOHANG); process > 0;
         process = waitpid(-1, &status, WNOHANG)) {
        if (process == program_) program_status_ = exit_status(status);
        const auto command = std::find_if(commands_.begin(), commands_.end(),
                                          [process](const Command& each) { return each.process == process; });
        if (command == commands_.end()) continue;
        read_output(*command);
        command->process = 0;
        if (command->stands) command->text = command->stands->last_output(command->text);
        Finished finished{exit_status(status), without_greeting(command->text)};
        if (WIFSIGNALED(status))
            finished.output += std::string("halcmd was killed: ") + strsignal(WTERMSIG(status)) + "\n";
        if (const auto done = std::move(command->done)) done(std::move(finished));
    }
}

std::vector<pid_t> Programs::others() const {
    std::map<pid_t, pid_t> parents;
    DIR* const folder = opendir("/proc");
    if (folder == nullptr) return {};
    while (const dirent* const entry = readdir(folder)) {
        const pid_t process = std::atoi(entry->d_name);
        if (process > 0) parents[process] = parent_of(process);
    }
    closedir(folder);

    const pid_t host = getpid();
    std::vector<pid_t> found;
    for (const auto& [process, parent] : parents) {
        if (process == host || parent < 0) continue;
        pid_t ancestor = parent;
        while (ancestor > 0 && ancestor != host) ancestor = parents.count(ancestor) ? parents[ancestor] : 0;
        const bool halcmd =
            std::any_of(commands_.begin(), commands_.end(),
                        [id = process](const Command& command) { return command.process == id; });
        if (ancestor == host && !halcmd) found.push_back(process);
    }
    return found;
}

std::vector<pid_t> Programs::called(const std::string& name) const {
    std::vector<pid_t> processes = others();
    processes.erase(std::remove_if(processes.begin(), processes.end(),
                                   [&](pid_t process) { return program_name(process) != name; }),
                    processes.end());
    return processes;
}

std::vector<std::string> Programs::alive() {
    std::vector<pid_t> processes = others();
    // A halcmd does not wait until a forked process becomes its program.
    constexpr int most_looks = 200;
    for (int look = 0; look < most_looks && any_called_halcmd(processes); ++look) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        processes = others();
    }
    if (processes.empty()) return {};
    std::map<pid_t, std::string> components;
    std::istringstream table(halcmd({"-s", "show", "comp"}).output);
    for (std::string line; std::getline(table, line);) {
        std::istringstream words(line);
        std::string number, type, name;
        pid_t process = 0;
        if (words >> number >> type >> name >> process && type == "User") components[process] = name;
    }
    std::vector<std::string> names;
    for (const pid_t process : processes)
        names.push_back(components.count(process) ? components[process] : program_name(process));
    return names;
}

void Programs::end_all() {
    constexpr auto patience = std::chrono::seconds(1);
    const auto begin = Clock::now();
    ask_all_to_end();
    for (Command& command : commands_) {
        command.done = {};
        if (command.process != 0) kill(command.process, SIGTERM);
    }
    for (;;) {
        look(5);
        std::vector<pid_t> left = others();
        for (const Command& command : commands_)
            if (command.process != 0) left.push_back(command.process);
        if (left.empty()) return;
        if (Clock::now() - begin > patience)
            for (const pid_t process : left) kill(process, SIGKILL);
    }
}

}  // namespace plumb::host
