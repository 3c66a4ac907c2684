// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/machine.hpp"

#include "tests/support/folder.hpp"
#include "tests/support/place.hpp"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <ostream>
#include <stdexcept>
#include <thread>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto patience = 60s;
constexpr uid_t nobody = 65534;
constexpr int not_furnished = 77;  // exit status
constexpr const char* home = "/var/tmp";
constexpr const char* shared_memory_folder = "/dev/shm";

void need(bool done, const std::string& what) {
    if (!done) throw std::runtime_error(what + ": " + std::strerror(errno));
}

void write_file(const std::string& path, const std::string& text) {
    std::ofstream out(path);
    out << text;
    need(static_cast<bool>(out.flush()), path);
}

// A folder that is at its place again after a folder above it was covered: the clone may lie in /tmp.
class KeptInSight {
public:
    explicit KeptInSight(const std::string& path)
        : path_(path), folder_(open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
        need(folder_ >= 0, path);
    }
    ~KeptInSight() { close(folder_); }
    KeptInSight(const KeptInSight&) = delete;

    void show() const {
        if (std::filesystem::is_directory(path_)) return;
        std::filesystem::create_directories(path_);
        const std::string covered = "/proc/self/fd/" + std::to_string(folder_);
        need(mount(covered.c_str(), path_.c_str(), nullptr, MS_BIND | MS_REC, nullptr) == 0, path_.string());
    }

private:
    std::filesystem::path path_;
    int folder_;
};

void furnish(const MachineOptions& options, uid_t user, gid_t group) {
    if (user != 0 || options.own_users) {
        write_file("/proc/self/setgroups", "deny");
        const std::string inside_user = options.as_root ? "0 " : std::to_string(user) + " ";
        const std::string inside_group = options.as_root ? "0 " : std::to_string(group) + " ";
        write_file("/proc/self/uid_map", inside_user + std::to_string(user) + " 1");
        write_file("/proc/self/gid_map", inside_group + std::to_string(group) + " 1");
    }
    std::vector<std::filesystem::path> programs = options.programs;
    programs.push_back(build_folder() + "/bin/plumb-host");
    std::vector<std::string> copies;  // of programs that may lie below a folder that is about to be covered
    for (const auto& program : programs) copies.push_back(contents(program));
    const KeptInSight source(source_folder());
    const KeptInSight build(build_folder());
    need(mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0, "private mounts");
    need(mount("proc", "/proc", "proc", 0, nullptr) == 0, "/proc");
    if (!options.modules.empty()) {
        const std::string layers = "lowerdir=" + options.modules.string() + ":" STOCK_MODULE_DIR;
        need(mount("overlay", STOCK_MODULE_DIR, "overlay", 0, layers.c_str()) == 0, layers);
    }
    for (const char* folder : {"/tmp", "/run/lock", shared_memory_folder, home})
        if (std::filesystem::is_directory(folder))
            need(mount("tmpfs", folder, "tmpfs", 0, "mode=1777") == 0, folder);
    source.show();
    build.show();
    std::filesystem::create_directory("/tmp/bin");
    for (std::size_t i = 0; i < programs.size(); ++i) {
        const std::filesystem::path copy = "/tmp/bin" / programs[i].filename();
        write_file(copy, copies[i]);
        std::filesystem::permissions(copy, static_cast<std::filesystem::perms>(0755));
    }
    unsetenv("TMPDIR");
    setenv("HOME", home, 1);
    need(chdir("/tmp") == 0, "/tmp");
}

// Ends a forked process without the clean-up of the test program.
[[noreturn]] void end_process(const std::function<void()>& body) {
    try {
        body();
    } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
    }
    std::fflush(nullptr);
    _exit(testing::Test::HasFailure() ? 1 : 0);
}

// Returns whether the process has ended, within the time.
bool await(pid_t process, std::chrono::milliseconds limit, int& status) {
    const auto deadline = Clock::now() + limit;
    while (waitpid(process, &status, WNOHANG) == 0) {
        if (Clock::now() > deadline) return false;
        std::this_thread::sleep_for(2ms);
    }
    return true;
}

// As the first process of the machine, which every orphan falls to.
void reap() {
    siginfo_t ended{};
    while (waitid(P_ALL, 0, &ended, WEXITED | WNOHANG) == 0 && ended.si_pid != 0) ended.si_pid = 0;
}

std::string line_of(const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += word + "  ";
    return line;
}

}  // namespace

std::string name_of(Role role) {
    return role == Role::root ? "AsRoot" : role == Role::user ? "AsUser" : "WithoutNamespaces";
}

void PrintTo(Role role, std::ostream* out) {
    *out << name_of(role);
}

MachineOptions machine_of(Role role) {
    MachineOptions options;
    options.as_root = role != Role::user;
    return options;
}

void on_own_machine(const std::function<void()>& body, const MachineOptions& options) {
    std::fflush(nullptr);
    const uid_t user = geteuid();
    const gid_t group = getegid();
    const unsigned long spaces =
        CLONE_NEWIPC | CLONE_NEWPID | CLONE_NEWNS | (user != 0 || options.own_users ? CLONE_NEWUSER : 0);
    const auto machine =
        static_cast<pid_t>(syscall(SYS_clone, SIGCHLD | spaces, nullptr, nullptr, nullptr, nullptr));
    if (machine < 0) GTEST_SKIP() << "the kernel gives no namespaces: " << std::strerror(errno);
    if (machine == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        try {
            furnish(options, user, group);
        } catch (const std::exception& error) {
            std::printf("%s\n", error.what());
            std::fflush(nullptr);
            _exit(not_furnished);
        }
        end_process(body);
    }
    int status = 0;
    if (!await(machine, options.limit, status)) {
        ::kill(machine, SIGKILL);
        waitpid(machine, &status, 0);
        FAIL() << "still running after " << options.limit.count() << " s";
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == not_furnished)
        GTEST_SKIP() << "the kernel gives no machine of its own (see above)";
    EXPECT_EQ(status, 0) << "see the failures above";
}

std::vector<pid_t> Processes::all() {
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        const pid_t process = std::atoi(entry.path().filename().c_str());
        if (process > 1) found.push_back(process);
    }
    return found;
}

std::string Processes::name(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/comm");
    std::string name;
    std::getline(file, name);  // which fails when the process has just gone
    return name;
}

pid_t Processes::called(const std::string& wanted) {
    for (const auto deadline = Clock::now() + 30s; Clock::now() < deadline;) {
        for (const pid_t process : all())
            if (name(process) == wanted) return process;
        std::this_thread::sleep_for(5ms);
    }
    throw std::runtime_error("no process is called " + wanted);
}

int shared_memory_segments() {
    std::ifstream table("/proc/sysvipc/shm");
    int lines = 0;
    for (std::string line; std::getline(table, line);) ++lines;
    return lines - 1;
}

std::vector<std::string> files() {
    const auto leads_to = [](const std::string& path, const std::string& folder) {
        return (folder + "/").rfind(path + "/", 0) == 0;
    };
    std::vector<std::string> found;
    for (const char* folder : {"/tmp", home, shared_memory_folder})
        for (const auto& entry : std::filesystem::directory_iterator(folder)) {
            const std::string path = entry.path();
            if (path != "/tmp/bin" && !leads_to(path, source_folder()) && !leads_to(path, build_folder()))
                found.push_back(path);
        }
    return found;
}

void expect_nothing_left(const std::vector<std::string>& files_before) {
    const auto deadline = Clock::now() + patience;
    std::vector<std::string> processes;
    std::vector<std::string> left;
    int segments = 0;
    do {
        std::this_thread::sleep_for(5ms);
        reap();
        processes.clear();
        for (const pid_t process : Processes::all()) processes.push_back(Processes::name(process));
        segments = shared_memory_segments();
        left = files();
        for (const std::string& before : files_before)
            left.erase(std::remove(left.begin(), left.end(), before), left.end());
    } while (Clock::now() < deadline && (!processes.empty() || segments || !left.empty()));
    EXPECT_EQ(line_of(processes), "") << "processes are left";
    EXPECT_EQ(segments, 0) << "shared memory is left";
    EXPECT_EQ(line_of(left), "") << "files are left";
}

Child::Child(bool root, const std::function<void(Child& self)>& body) {
    int said[2];
    int gone[2];
    need(pipe2(said, O_CLOEXEC) == 0 && pipe2(gone, O_CLOEXEC) == 0, "pipe");
    std::fflush(nullptr);
    process_ = fork();
    need(process_ >= 0, "fork");
    if (process_ == 0) {
        close(said[0]);
        close(gone[1]);
        said_ = said[1];
        gone_ = gone[0];
        end_process([&] {
            if (!root && geteuid() == 0)
                need(setgroups(0, nullptr) == 0 && setresgid(nobody, nobody, nobody) == 0 &&
                         setresuid(nobody, nobody, nobody) == 0,
                     "becoming an ordinary user");
            body(*this);
        });
    }
    close(said[1]);
    close(gone[0]);
    said_ = said[0];
    gone_ = gone[1];
}

Child::~Child() {
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
    }
    close(said_);
    close(gone_);
}

void Child::say(const std::string& line) {
    const std::string text = line + '\n';
    need(write(said_, text.data(), text.size()) == static_cast<ssize_t>(text.size()), "say");
}

std::string Child::hear() {
    std::string line;
    for (;;) {
        pollfd ready{said_, POLLIN, 0};
        char c = 0;
        if (poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(patience).count())) <= 0)
            throw std::runtime_error("the child is silent");
        if (read(said_, &c, 1) != 1) throw std::runtime_error("the child has ended");
        if (c == '\n') return line;
        line += c;
    }
}

void Child::go() {
    need(write(gone_, "g", 1) == 1, "go");
}

void Child::await_go() {
    char c = 0;
    need(read(gone_, &c, 1) == 1, "await_go");
}

void Child::kill() {
    ::kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = 0;
}

void Child::await_success() {
    int status = 0;
    if (!await(process_, patience, status)) throw std::runtime_error("the child hangs");
    process_ = 0;
    EXPECT_EQ(status, 0) << "see the failures above";
}

}  // namespace plumb
