// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/isolation.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

#include "hal/host/holders.hpp"
#include "hal/host/host_folder.hpp"
#include "hal/host/leftovers.hpp"
#include "hal/host/shared_memory.hpp"

namespace plumb::host {

namespace {

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

bool write_file(const char* path, const std::string& text) {
    const int file = open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0) return false;
    const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    close(file);
    return written;
}

bool client_gone(int control_descriptor) {
    pollfd look{control_descriptor, POLLRDHUP, 0};
    return control_descriptor >= 0 && poll(&look, 1, 0) > 0 &&
           (look.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

// The namespaces of the host.
struct Namespaces {
    bool processes_and_memory;
    bool user;
    bool network;
};

// The host's report about its namespaces.
struct Report {
    bool good;
    char reason[256];  // why not
};

// The keeper and the host speak over this pair of sockets while the host is set up. Each holds its own end
// alone, so that it learns of the other's death.
class Setup {
public:
    Setup() {
        if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends_) != 0) fail("socketpair");
    }
    ~Setup() {
        for (const int end : ends_)
            if (end >= 0) close(end);
    }
    Setup(const Setup&) = delete;

    void become_keeper() { drop(1); }
    void become_host() { drop(0); }

    // False when the other is dead.
    template <class Message>
    bool say(const Message& message) const {
        ssize_t count = 0;
        do count = send(end(), &message, sizeof message, MSG_NOSIGNAL);
        while (count < 0 && errno == EINTR);
        if (count < 0 && errno != EPIPE && errno != ECONNRESET)
            std::fprintf(stderr, "plumb-host: the host and its keeper: %s\n", std::strerror(errno));
        return count == sizeof message;
    }
    template <class Message>
    bool hear(Message& message) const {
        ssize_t count = 0;
        do count = recv(end(), &message, sizeof message, 0);
        while (count < 0 && errno == EINTR);
        return count == sizeof message;
    }

private:
    int end() const { return ends_[0] >= 0 ? ends_[0] : ends_[1]; }
    void drop(int which) {
        close(ends_[which]);
        ends_[which] = -1;
    }

    int ends_[2] = {-1, -1};
};

constexpr uid_t nobody = 65534;

// Whether there is a user but root here. In a user namespace there may be none, and LinuxCNC's rtapi_app
// then fails: it does not run as root alone.
bool nobody_exists() {
    std::ifstream map("/proc/self/uid_map");
    unsigned long inside = 0;
    unsigned long outside = 0;
    unsigned long count = 0;
    while (map >> inside >> outside >> count)
        if (inside <= nobody && nobody - inside < count) return true;
    return false;
}

bool bring_loopback_up() {
    const int any = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq loopback{};
    std::strcpy(loopback.ifr_name, "lo");
    loopback.ifr_flags = IFF_UP;
    const bool up = any >= 0 && ioctl(any, SIOCSIFFLAGS, &loopback) == 0;
    if (any >= 0) close(any);
    return up;
}

// In the new namespaces: keeps the user's number, or makes root nobody, and gives /proc the host's own
// processes. Returns why it cannot, or nothing.
std::string furnish_namespaces(Namespaces namespaces, uid_t outer_user, gid_t outer_group) {
    const auto reason = [](const std::string& what) { return what + ": " + std::strerror(errno); };
    if (namespaces.user) {
        const uid_t user = outer_user == 0 ? nobody : outer_user;
        const gid_t group = outer_user == 0 ? nobody : outer_group;
        if (!write_file("/proc/self/setgroups", "deny") ||
            !write_file("/proc/self/uid_map",
                        std::to_string(user) + " " + std::to_string(outer_user) + " 1") ||
            !write_file("/proc/self/gid_map",
                        std::to_string(group) + " " + std::to_string(outer_group) + " 1"))
            return reason("users of its own");
    }
    if (namespaces.network && !bring_loopback_up()) return reason("a loopback of its own");
    if (!namespaces.processes_and_memory) return "";
    if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return reason("mounts of its own");
    if (mount("proc", "/proc", "proc", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr) != 0)
        return reason("a /proc of its own");
    return "";
}

// A clone() that fails like this has failed for good: the kernel, a container or a limit forbids namespaces.
bool forbids_namespaces(int error) {
    return error == EPERM || error == EACCES || error == EINVAL || error == ENOSYS || error == ENOSPC ||
           error == EUSERS;
}

struct Forked {
    pid_t host;           // 0 in the host, its number in the keeper, -1 when the namespaces cannot be had
    std::string refusal;  // then the reason
};

// Forks the host and sends it its number as seen from outside. If namespaces are possible and fail
// nevertheless, throws: a host must not go on without them.
Forked fork_host(Namespaces namespaces, int& number) {
    const uid_t user = geteuid();
    const gid_t group = getegid();
    Setup setup;
    unsigned long flags = SIGCHLD;
    if (namespaces.processes_and_memory) flags |= CLONE_NEWIPC | CLONE_NEWPID | CLONE_NEWNS;
    if (namespaces.user) flags |= CLONE_NEWUSER;
    if (namespaces.network) flags |= CLONE_NEWNET;
    const auto host = static_cast<pid_t>(syscall(SYS_clone, flags, nullptr, nullptr, nullptr, nullptr));
    if (host < 0 && flags != SIGCHLD && forbids_namespaces(errno))
        return {-1, std::string("clone: ") + std::strerror(errno)};
    if (host < 0) fail("cannot fork the host");
    if (host == 0) {
        setup.become_host();
        prctl(PR_SET_PDEATHSIG, SIGTERM);  // a killed keeper clears nothing away: the host does
        const std::string refusal = furnish_namespaces(namespaces, user, group);
        Report report{refusal.empty(), {}};
        refusal.copy(report.reason, sizeof report.reason - 1);
        // Its keeper may have died before that signal was asked for.
        if (!setup.say(report) || !report.good || !setup.hear(number)) _exit(1);
        return {0, {}};
    }
    setup.become_keeper();
    Report report{};
    number = host;
    if (setup.hear(report) && !report.good) {
        waitpid(host, nullptr, 0);
        return {-1, report.reason};
    }
    setup.say(number);
    return {host, {}};  // which may be dead: see keep()
}

// Number of a process with this name, or 0.
pid_t process_called(const std::string& name) {
    DIR* const folder = opendir("/proc");
    if (folder == nullptr) return 0;
    pid_t found = 0;
    while (const dirent* const entry = readdir(folder)) {
        const pid_t process = std::atoi(entry->d_name);
        if (process <= 0) continue;
        std::ifstream file(std::string("/proc/") + entry->d_name + "/comm");
        std::string command;
        if (std::getline(file, command) && command == name) found = process;
    }
    closedir(folder);
    return found;
}

// Number of a realtime master of LinuxCNC, or 0. One that lives for a moment only is a messenger of some
// halcmd.
pid_t realtime_master() {
    constexpr int looks = 10;
    for (int look = 0; look < looks; ++look) {
        if (process_called("rtapi_app") == 0) return 0;
        poll(nullptr, 0, 50);
    }
    return process_called("rtapi_app");
}

// The lock lies in a folder in which every user can make files, and links to another's. Nobody needs to
// write to it, and no file is changed but one made here.
int open_lock(const std::string& path) {
    for (int tries = 0; tries < 100; ++tries) {
        int lock = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (lock < 0 && errno == ELOOP)
            throw std::runtime_error(
                path + " is a symbolic link, and this host's lock file is to be there: remove it");
        if (lock < 0 && errno == ENOENT) {
            lock = open(path.c_str(), O_RDONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
            if (lock < 0 && errno == EEXIST) continue;  // another host was faster
            if (lock >= 0) fchmod(lock, 0644);          // for the next user, with any umask
        }
        struct stat state {};
        if (lock < 0 || fstat(lock, &state) != 0) fail("cannot lock " + path);
        if (S_ISREG(state.st_mode)) return lock;
        close(lock);
        break;
    }
    throw std::runtime_error(path + " is no file, and this host's lock file is to be there: remove it");
}

bool is_ignored(int signal) {
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    return action.sa_handler == SIG_IGN;
}

// The signals that ask a run to end. A signal that the user has it ignore, by nohup or by `&` in a script, is
// none of them: while it is blocked it comes nevertheless.
sigset_t signals_that_end() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    for (const int signal : {SIGHUP, SIGINT})
        if (!is_ignored(signal)) sigaddset(&signals, signal);
    return signals;
}

// Ends this process, which waits, by a signal that has come, as if it had not been blocked.
void obey_signals() {
    const sigset_t signals = signals_that_end();
    const timespec pause{0, 50'000'000};
    const int number = sigtimedwait(&signals, nullptr, &pause);
    if (number > 0) std::exit(128 + number);
}

// Waits for the machine's HAL. The lock lasts until the last process that inherits it ends.
void take_machine_hal(int control_descriptor) {
    const std::string path = access("/run/lock", W_OK) == 0 ? "/run/lock/plumb-host" : "/tmp/plumb-host.lock";
    const int lock = open_lock(path);
    const auto began = std::chrono::steady_clock::now();
    for (bool waiting = false, told = false; flock(lock, LOCK_EX | LOCK_NB) != 0; waiting = true) {
        if (errno != EWOULDBLOCK && errno != EINTR) fail("cannot lock " + path);
        if (!waiting)
            std::fputs("plumb-host: waits until the other host that uses this machine's one HAL has ended\n",
                       stderr);
        if (!told && std::chrono::steady_clock::now() - began > std::chrono::seconds(1)) {
            std::fprintf(stderr, "plumb-host: %s\n", who_holds(path, lock).c_str());
            told = true;
        }
        if (client_gone(control_descriptor)) std::exit(1);
        obey_signals();
    }
    if (const pid_t process = realtime_master())
        throw std::runtime_error("LinuxCNC's realtime runs on this machine (" + description_of(process) +
                                 "), and this host has no namespace to stay apart from it");
    for (const int key : {hal_memory_key, identity_memory_key}) {
        const int segment = shmget(key, 0, 0);
        if (segment < 0 && errno == ENOENT) continue;
        shmid_ds state{};
        if (segment < 0 || shmctl(segment, IPC_STAT, &state) != 0 || state.shm_nattch > 0 ||
            shmctl(segment, IPC_RMID, nullptr) != 0)
            throw std::runtime_error("HAL is in use on this machine (" + who_has_memory(key) +
                                     "), and this host has no namespace to stay apart from it");
    }
}

// A host that was killed together with its keeper has cleared nothing away.
// Returns whether there was one.
bool clear_after_killed_hosts() {
    const char* const home = std::getenv("HOME");
    const bool killed = remove_folders_of_killed_hosts();
    if (killed && home != nullptr && *home == '/') Placeholder::remove(Leftovers::tool_table_in(home));
    return killed;
}

// Kills the rest of the host's programs: this process is their parent once the host is dead.
void kill_orphans() {
    for (;;) {
        while (waitpid(-1, nullptr, WNOHANG) > 0) continue;
        std::ifstream list("/proc/self/task/" + std::to_string(getpid()) + "/children");
        pid_t child = 0;
        bool any = false;
        while (list >> child) {
            any = true;
            kill(child, SIGKILL);
        }
        if (!any) return;
        poll(nullptr, 0, 5);
    }
}

// Signals of a terminal, or its end, are for the program. A handler, unlike SIG_IGN, is not handed on to
// it.
void leave_terminal_signals_to_program() {
    for (const int signal : {SIGINT, SIGQUIT, SIGHUP}) {
        if (is_ignored(signal)) continue;  // as with nohup, and the program is to ignore it, too
        struct sigaction action {};
        action.sa_handler = [](int) {};
        action.sa_flags = SA_RESTART;
        sigaction(signal, &action, nullptr);
    }
}

// `events`: a descriptor that shows ends of processes and signals that end.
[[noreturn]] void keep(pid_t host, int events, bool namespaces, const Isolation& wanted) {
    using Clock = std::chrono::steady_clock;
    // For a host that is to end, unless a module keeps it, or the program on the terminal takes its time.
    const auto patience = std::chrono::seconds(wanted.on_terminal ? 15 : 3);
    const int control_descriptor = wanted.control_descriptor;
    const bool has_client = control_descriptor >= 0;
    std::optional<Clock::time_point> give_up;
    int status = 0;
    while (waitpid(host, &status, WNOHANG) != host) {
        if (give_up && Clock::now() > *give_up) kill(host, SIGKILL);
        pollfd waits[2] = {{events, POLLIN, 0}, {give_up ? -1 : control_descriptor, POLLRDHUP, 0}};
        poll(waits, 2, give_up ? 20 : -1);
        bool end = waits[1].revents != 0;  // the client is gone; the host sees it, too
        for (signalfd_siginfo event; read(events, &event, sizeof event) == sizeof event;) {
            if (event.ssi_signo == SIGCHLD) continue;
            // A terminal's Ctrl-C is the affair of the client, or of the program, which has heard it, too.
            if (event.ssi_signo == SIGINT &&
                (has_client || (wanted.on_terminal && event.ssi_code == SI_KERNEL)))
                continue;
            kill(host, SIGTERM);
            end = true;
        }
        if (end && !give_up) give_up = Clock::now() + patience;
    }
    kill_orphans();
    leftovers().clear_away();
    if (!namespaces) leftovers().clear_machine();
    if (!WIFSIGNALED(status)) _exit(WEXITSTATUS(status));
    if (wanted.on_terminal && WTERMSIG(status) == SIGKILL)
        std::fputs("plumb run: the virtual-time host was killed (signal 9), and the program with it\n",
                   stderr);
    // Ends as the host did, so that the parent of this process learns the signal.
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    signal(WTERMSIG(status), SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    kill(getpid(), WTERMSIG(status));
    _exit(128 + WTERMSIG(status));
}

}  // namespace

Isolated isolate(const Isolation& wanted) {
    const bool killed = clear_after_killed_hosts();
    leftovers().share();
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    sigset_t signals = signals_that_end();
    sigset_t before;
    sigaddset(&signals, SIGCHLD);
    sigprocmask(SIG_BLOCK, &signals, &before);
    const int events = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);  // before there is a host to keep
    if (events < 0) fail("signalfd");

    int number = 0;
    bool namespaces = wanted.namespaces != Isolation::Namespaces::none;
    const bool lonely_root = geteuid() == 0 && !nobody_exists();
    Forked forked{-1, {}};
    if (namespaces) {
        forked = fork_host({true, lonely_root || geteuid() != 0, wanted.own_network}, number);
        namespaces = forked.host >= 0;
        if (!namespaces && wanted.namespaces == Isolation::Namespaces::required)
            throw std::runtime_error(
                "this system gives the run no namespaces (" + forked.refusal +
                "), so the program would have the computer's own devices, network and "
                "HAL; 'plumb doctor' names the remedy. --no-namespaces runs it nevertheless, with "
                "all of these");
        if (!namespaces)
            std::fprintf(
                stderr,
                "plumb-host: this system gives no namespaces (%s); this host uses the computer's one HAL, "
                "one host at a time\n",
                forked.refusal.c_str());
    }
    if (!namespaces) {
        take_machine_hal(wanted.control_descriptor);
        if (killed) Leftovers::clear_memory_of_the_dead();
        if (lonely_root) forked = fork_host({false, true, false}, number);
        if (forked.host < 0) forked = fork_host({false, false, false}, number);
    }
    if (forked.host > 0) keep(forked.host, events, namespaces, wanted);
    close(events);
    // A terminal's Ctrl-C is for the client, or for the program.
    if (wanted.on_terminal)
        leave_terminal_signals_to_program();
    else
        setsid();
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    return {namespaces, number};
}

}  // namespace plumb::host
