// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/client/client.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "hal/socket_folder.hpp"

namespace plumb::client {
namespace {

using Json = nlohmann::json;
using Progress = std::function<bool(Time)>;

constexpr int control_in_host = 3;                  // the descriptor on which the host finds its client
constexpr std::size_t kept_words = 4000;            // of the host's output
constexpr Time patience = std::chrono::seconds(5);  // for a host to unload and end

[[noreturn]] void fail(const std::string& what) {
    throw std::system_error(errno, std::generic_category(), what);
}

// A file descriptor that is closed when it goes out of scope.
class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() { close(); }

    int operator*() const { return number_; }
    void close() {
        if (number_ >= 0) ::close(std::exchange(number_, -1));
    }

private:
    int number_ = -1;
};

std::string trimmed(const std::string& text) {
    const char* const blanks = " \t\r\n";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string::npos) return "";
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string absolute(const std::string& file) {
    return std::filesystem::absolute(file);
}

// JSON has no word for infinite values and NaN.
Json to_json(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    return value;
}

double to_double(const Json& value) {
    if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
    if (value == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (value == "inf") return std::numeric_limits<double>::infinity();
    if (value == "-inf") return -std::numeric_limits<double>::infinity();
    return value.get<double>();
}

Time to_time(const Json& nanoseconds) {
    return Time(nanoseconds.get<std::int64_t>());
}

// The words of a line of a .hal file: blanks separate, quotes keep together.
std::vector<std::string> words_of(const std::string& line) {
    std::vector<std::string> words;
    bool inside = false;
    char quote = 0;
    for (const char c : line) {
        const bool blank = c == ' ' || c == '\t';
        if (!inside && blank) continue;
        if (!inside) words.emplace_back();
        inside = quote || !blank;
        if (quote ? c == quote : c == '"' || c == '\'')
            quote = quote ? 0 : c;
        else if (inside)
            words.back() += c;
    }
    if (quote) throw std::invalid_argument("unterminated quote in: " + line);
    return words;
}

void succeed(const Halcmd& result, const std::string& what) {
    if (result.status == 0) return;
    const std::string output = trimmed(result.output);
    throw std::runtime_error(
        output.empty() ? what + ": halcmd ended with status " + std::to_string(result.status) : output);
}

}  // namespace

std::string find_host() {
    std::error_code error;
    const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    for (const char* folder : {".", "bin", "../bin"}) {
        const std::filesystem::path candidate = (here / folder / "plumb-host").lexically_normal();
        if (access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string candidate = folder + "/plumb-host";
        if (access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    throw std::runtime_error("cannot find plumb-host beside " + here.string() + " or in PATH");
}

Time seconds(double seconds) {
    const double nanoseconds = std::round(seconds * 1e9);
    if (!(std::abs(nanoseconds) < 9.2e18))
        throw std::invalid_argument("a time of " + std::to_string(seconds) + " s cannot be represented");
    return Time(static_cast<std::int64_t>(nanoseconds));
}

// The socket to the host, and the process at its other end.
class Client::Connection {
public:
    explicit Connection(const Start& start) : show_output_(start.show_output) {
        launch(start);
        greet();
    }

    explicit Connection(const Attach& attach) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        if (attach.socket.size() >= sizeof address.sun_path)
            throw std::invalid_argument("the path of a socket is too long: " + attach.socket);
        std::copy(attach.socket.begin(), attach.socket.end(), address.sun_path);
        control_ = Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
        if (connect(*control_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
            fail("no virtual-time host at " + attach.socket);
        require_own_host(attach.socket);
        greet();
    }

    ~Connection() { end(); }

    // The host's answer. Throws with its sentence if it refuses.
    Json request(const Json& request, const Progress& progress = {}) {
        if (!death_.empty()) throw HostDied(death_);
        send(request);
        bool stopping = false;
        Json answer = receive();
        while (answer.contains("progress")) {
            if (progress && !progress(to_time(answer["progress"])) && !std::exchange(stopping, true))
                send({{"do", "stop"}});
            answer = receive();
        }
        if (stopping) receive();
        if (!answer.at("ok").get<bool>()) throw std::runtime_error(answer.at("error").get<std::string>());
        return answer;
    }

    // Lets the host unload and end, for as long as patience lasts.
    void end() noexcept {
        shutdown(*control_, SHUT_RDWR);  // closing is not enough while a forked process has a copy
        control_.close();
        if (process_ > 0) await_end();
        output_.close();
    }

    std::string socket;
    bool namespaces = true;
    std::vector<std::string> modules;
    pid_t host = 0;

private:
    void launch(const Start& start) {
        const std::string executable = start.executable.empty() ? find_host() : start.executable;
        std::vector<std::string> arguments{executable, "--control-fd", std::to_string(control_in_host)};
        for (const std::string& folder : start.modules) {
            arguments.push_back("--modules");
            arguments.push_back(absolute(folder));
        }
        for (const std::string& option : start.module_options) {
            arguments.push_back("--option");
            arguments.push_back(option);
        }
        if (!start.models.empty()) arguments.insert(arguments.end(), {"--models", start.models});
        if (!start.namespaces) arguments.push_back("--no-namespaces");
        if (start.guard) arguments.push_back("--guard");
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);

        int control[2];
        int output[2];
        if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, control) != 0) fail("socketpair");
        control_ = Descriptor(control[0]);
        const Descriptor hosts_control(control[1]);
        if (pipe2(output, O_CLOEXEC) != 0) fail("pipe2");
        output_ = Descriptor(output[0]);
        const Descriptor hosts_output(output[1]);
        fcntl(*output_, F_SETFL, O_NONBLOCK);

        // Apart from the terminal, so that Ctrl-C reaches only the client, which ends the host in order.
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        sigset_t none;
        sigemptyset(&none);
        sigset_t all;
        sigfillset(&all);
        posix_spawnattr_setsigmask(&attributes, &none);
        posix_spawnattr_setsigdefault(&attributes, &all);
        posix_spawnattr_setflags(&attributes,
                                 POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, *hosts_output, STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, *hosts_output, STDERR_FILENO);
        posix_spawn_file_actions_adddup2(&actions, *hosts_control, control_in_host);
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        errno = posix_spawn(&process_, executable.c_str(), &actions, &attributes, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        posix_spawnattr_destroy(&attributes);
        if (errno) {
            process_ = 0;
            fail("cannot start " + executable);
        }
    }

    // Any program may listen where a host was; the system knows its process.
    void require_own_host(const std::string& path) const {
        ucred peer{};
        socklen_t size = sizeof peer;
        if (getsockopt(*control_, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) fail(path);
        if (peer.uid != geteuid() && peer.uid != 0)
            throw std::runtime_error(path + " belongs to user " + std::to_string(peer.uid) +
                                     ", and is no host of yours");
    }

    void greet() try {
        const Json answer = request({{"do", "hello"}});
        if (answer.at("protocol") != 1)
            throw std::runtime_error("the virtual-time host speaks protocol " + answer.at("protocol").dump() +
                                     ", this client speaks 1");
        socket = answer.at("socket").get<std::string>();
        namespaces = answer.at("namespaces").get<bool>();
        host = answer.at("pid").get<pid_t>();
        modules = answer.at("modules").get<std::vector<std::string>>();
    } catch (const HostDied&) {
        end();
        const std::string words = trimmed(last_words_);
        if (words.empty()) throw;
        throw std::runtime_error(words);
    }

    void send(const Json& request) {
        const std::string line = request.dump() + '\n';
        for (std::size_t sent = 0; sent < line.size();) {
            const ssize_t n = ::send(*control_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) die();
            sent += static_cast<std::size_t>(n);
        }
    }

    Json receive() {
        // Going to sleep takes longer than the answer to a short request.
        const auto awake = std::chrono::steady_clock::now() + std::chrono::microseconds(20);
        std::size_t end;
        while ((end = unread_.find('\n')) == std::string::npos) {
            pollfd ready[] = {{*control_, POLLIN, 0}, {*output_, POLLIN, 0}};
            const int patience = std::chrono::steady_clock::now() < awake ? 0 : -1;
            if (poll(ready, 2, patience) < 0 && errno != EINTR) fail("poll");
            if (ready[1].revents) listen();
            if (!ready[0].revents) continue;
            char bytes[4096];
            const ssize_t n = recv(*control_, bytes, sizeof bytes, MSG_DONTWAIT);
            if (n > 0)
                unread_.append(bytes, static_cast<std::size_t>(n));
            else if (n == 0 || (errno != EINTR && errno != EAGAIN))
                die();
        }
        const std::string line = unread_.substr(0, end);
        unread_.erase(0, end + 1);
        return Json::parse(line);
    }

    // Takes in the output of the host.
    void listen() noexcept {
        char bytes[4096];
        ssize_t n;
        while ((n = ::read(*output_, bytes, sizeof bytes)) > 0) {
            if (show_output_ && ::write(STDERR_FILENO, bytes, static_cast<std::size_t>(n)) < 0)
                show_output_ = false;
            last_words_.append(bytes, static_cast<std::size_t>(n));
            if (last_words_.size() > 2 * kept_words) last_words_.erase(0, last_words_.size() - kept_words);
        }
        if (n == 0) output_.close();
    }

    // Waits for the process to end, listening meanwhile; kills it when patience is at an end.
    int await_end() noexcept {
        const Descriptor ended(static_cast<int>(syscall(SYS_pidfd_open, process_, 0)));
        const auto deadline = std::chrono::steady_clock::now() + patience;
        for (;;) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
                deadline - std::chrono::steady_clock::now());
            pollfd ready[] = {{*ended, POLLIN, 0}, {*output_, POLLIN, 0}};
            const int n = left.count() > 0 ? poll(ready, 2, static_cast<int>(left.count())) : 0;
            if (n < 0 && errno == EINTR) continue;
            if (n > 0 && ready[1].revents) listen();
            if (n > 0 && !ready[0].revents) continue;
            if (n <= 0) kill(process_, SIGKILL);
            int status = 0;
            while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
            }
            if (*output_ >= 0) listen();
            process_ = 0;
            return status;
        }
    }

    [[noreturn]] void die() {
        if (process_ == 0) {
            death_ = "the virtual-time host at " + socket + " is gone";
            throw HostDied(death_);
        }
        control_.close();
        const int status = await_end();
        const std::string cause = WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                                                      : "exit status " + std::to_string(WEXITSTATUS(status));
        // The host itself clears up after its death, unless that part of it was killed as well.
        hal::remove_socket_folder(std::filesystem::path(socket).parent_path());
        std::string words = trimmed(last_words_);
        if (words.size() > kept_words) words.erase(0, words.size() - kept_words);
        death_ = "the virtual-time host died (" + cause + "); " +
                 (words.empty()  ? "it left no words"
                  : show_output_ ? "its last words stand above"
                                 : "its last words: " + words);
        throw HostDied(death_);
    }

    Descriptor control_;  // requests and answers
    Descriptor output_;   // the output of the host
    bool show_output_ = false;
    pid_t process_ = 0;       // the one started here, 0 if none: it ends when the host does
    std::string unread_;      // received from control_, less than a line
    std::string last_words_;  // the end of the host's output
    std::string death_;       // why it is dead, once it is
};

Client::Client(const Start& start) : connection_(std::make_unique<Connection>(start)) {}
Client::Client(const Attach& attach) : connection_(std::make_unique<Connection>(attach)) {}
Client::~Client() = default;

const std::string& Client::socket() const {
    return connection_->socket;
}

bool Client::namespaces() const {
    return connection_->namespaces;
}

const std::vector<std::string>& Client::modules() const {
    return connection_->modules;
}

pid_t Client::process() const {
    return connection_->host;
}

int Client::hal_version() {
    return connection_->request({{"do", "hello"}}).at("hal-version");
}

Time Client::time() {
    return to_time(connection_->request({{"do", "hello"}}).at("time"));
}

Halcmd Client::halcmd(const std::vector<std::string>& arguments) {
    const Json answer = connection_->request(
        {{"do", "halcmd"}, {"args", arguments}, {"cwd", std::filesystem::current_path().string()}});
    return {answer.at("status").get<int>(), answer.at("output").get<std::string>()};
}

void Client::command(const std::string& line) {
    succeed(halcmd(words_of(line)), line);
}

void Client::source(const std::string& file, const std::string& ini) {
    succeed(halcmd(ini.empty() ? std::vector<std::string>{"-f", file}
                               : std::vector<std::string>{"-i", ini, "-f", file}),
            file);
}

Value Client::read(const std::string& name) {
    return read(std::vector<std::string>{name}).front();
}

std::vector<Value> Client::read(const std::vector<std::string>& names) {
    const Json answer = connection_->request({{"do", "get"}, {"names", names}});
    std::vector<Value> values;
    for (std::size_t i = 0; i < names.size(); ++i)
        values.push_back({to_double(answer.at("values").at(i)), answer.at("types").at(i).get<std::string>()});
    return values;
}

void Client::set(const std::string& name, double value) {
    connection_->request({{"do", "set"}, {"name", name}, {"value", to_json(value)}});
}

Ran Client::run(Time time, const Progress& progress) {
    const Json answer = connection_->request({{"do", "run"}, {"ns", time.count()}}, progress);
    return {to_time(answer.at("time")), to_time(answer.at("ran")), answer.value("ended", "")};
}

void Client::record(const std::string& id, const Record& record) {
    connection_->request({{"do", "record"},
                          {"id", id},
                          {"names", record.names},
                          {"every", record.every.count()},
                          {"file", absolute(record.file)},
                          {"append", record.append}});
}

void Client::record_stop(const std::string& id) {
    connection_->request({{"do", "record-stop"}, {"id", id}});
}

Time Client::replay(const Replay& replay) {
    Json request{{"do", "replay"},
                 {"file", absolute(replay.file)},
                 {"columns", nullptr},
                 {"sample-period", nullptr},
                 {"override", replay.override_links}};
    if (!replay.columns.empty()) request["columns"] = replay.columns;
    if (replay.sample_period) request["sample-period"] = replay.sample_period->count();
    return to_time(connection_->request(request).at("duration"));
}

void Client::expect(const std::string& id, const std::string& expression,
                    const std::map<std::string, std::string>& variables) {
    connection_->request(
        {{"do", "expect"}, {"id", id}, {"expression", expression}, {"variables", variables}});
}

std::vector<Violation> Client::violations() {
    std::vector<Violation> violations;
    const Json answer = connection_->request({{"do", "violations"}});
    for (const Json& json : answer.at("violations")) {
        Violation& violation = violations.emplace_back();
        violation.id = json.at("id").get<std::string>();
        violation.count = json.at("count").get<std::int64_t>();
        violation.first_time = to_time(json.at("first-time"));
        for (const auto& [name, value] : json.at("values").items()) violation.values[name] = to_double(value);
    }
    return violations;
}

std::vector<GuardViolation> Client::guard() {
    std::vector<GuardViolation> violations;
    const Json answer = connection_->request({{"do", "guard"}});
    for (const Json& json : answer.at("violations"))
        violations.push_back({json.at("function").get<std::string>(), json.at("what").get<std::string>()});
    return violations;
}

std::vector<std::string> Client::programs() {
    return connection_->request({{"do", "programs"}}).at("names").get<std::vector<std::string>>();
}

void Client::exit() {
    connection_->request({{"do", "exit"}});
    connection_->end();
}

}  // namespace plumb::client
