// SPDX-License-Identifier: GPL-2.0-or-later
// fail_call KIND ERROR N REPORT OURS... -- PROGRAM [argument ...]
// Runs a program whose N-th system call of a kind fails with the number ERROR, as if the system had refused
// it. It counts the calls of programs whose file begins with one of OURS, and of the processes that these
// start; calls for files of the system, below /usr and the like and below OURS, are let through. REPORT is a
// file that gets the number of calls and, if one failed, its name and its file; then the exit status.
//
// Standard error is let through: the program is to report. A write that fails for lack of space (ENOSPC)
// leaves half of its bytes behind, and all later ones fail too, as on a full disk. N = 0 lets all calls
// through. SIGTERM and SIGINT go to the program; the exit status is its own, or 128 + the signal.
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#ifdef __aarch64__
constexpr unsigned processor = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned processor = AUDIT_ARCH_X86_64;
#endif

namespace {

// Where a call names its file.
enum class File { none, path, path_at, descriptor };

struct Call {
    int number;
    const char* name;
    File file;
};

// Calls that a processor lacks are left out.
const std::map<std::string, std::vector<Call>> kinds{
    {"open",
     {
#ifdef SYS_open
         {SYS_open, "open", File::path},
         {SYS_creat, "creat", File::path},
#endif
         {SYS_openat, "openat", File::path_at}}},
    {"read",
     {{SYS_read, "read", File::descriptor},
      {SYS_pread64, "pread", File::descriptor},
      {SYS_readv, "readv", File::descriptor}}},
    {"write",
     {{SYS_write, "write", File::descriptor},
      {SYS_pwrite64, "pwrite", File::descriptor},
      {SYS_writev, "writev", File::descriptor}}},
    {"sync", {{SYS_fsync, "fsync", File::descriptor}, {SYS_fdatasync, "fdatasync", File::descriptor}}},
    {"name",
     {
#ifdef SYS_rename
         {SYS_rename, "rename", File::path},
         {SYS_unlink, "unlink", File::path},
         {SYS_rmdir, "rmdir", File::path},
         {SYS_mkdir, "mkdir", File::path},
#endif
         {SYS_renameat, "renameat", File::path_at},
         {SYS_renameat2, "renameat2", File::path_at},
         {SYS_unlinkat, "unlinkat", File::path_at},
         {SYS_mkdirat, "mkdirat", File::path_at},
         {SYS_linkat, "linkat", File::path_at}}},
    {"state",
     {
#ifdef SYS_stat
         {SYS_stat, "stat", File::path},
         {SYS_lstat, "lstat", File::path},
         {SYS_access, "access", File::path},
         {SYS_chmod, "chmod", File::path},
#endif
         {SYS_newfstatat, "newfstatat", File::path_at},
         {SYS_faccessat, "faccessat", File::path_at},
         {SYS_fstat, "fstat", File::descriptor},
         {SYS_fchmod, "fchmod", File::descriptor},
         {SYS_fchown, "fchown", File::descriptor},
         {SYS_ftruncate, "ftruncate", File::descriptor},
         {SYS_flock, "flock", File::descriptor},
         {SYS_fcntl, "fcntl", File::descriptor},
         {SYS_getdents64, "getdents64", File::descriptor}}},
    {"socket",
     {{SYS_socket, "socket", File::none},
      {SYS_socketpair, "socketpair", File::none},
      {SYS_bind, "bind", File::descriptor},
      {SYS_listen, "listen", File::descriptor},
      {SYS_connect, "connect", File::descriptor},
      {SYS_accept4, "accept4", File::descriptor},
      {SYS_setsockopt, "setsockopt", File::descriptor},
      {SYS_getsockopt, "getsockopt", File::descriptor},
      {SYS_sendto, "sendto", File::descriptor},
      {SYS_sendmsg, "sendmsg", File::descriptor},
      {SYS_recvfrom, "recvfrom", File::descriptor},
      {SYS_recvmsg, "recvmsg", File::descriptor}}},
    {"wait",
     {
#ifdef SYS_poll
         {SYS_poll, "poll", File::none},
#endif
         {SYS_ppoll, "ppoll", File::none}}},
    {"process",
     {
#ifdef SYS_fork
         {SYS_fork, "fork", File::none},
         {SYS_vfork, "vfork", File::none},
#endif
         {SYS_clone, "clone", File::none},
         {SYS_clone3, "clone3", File::none},
         {SYS_execve, "execve", File::none},
         {SYS_pipe2, "pipe2", File::none},
         {SYS_dup, "dup", File::descriptor},
         {SYS_eventfd2, "eventfd2", File::none},
         {SYS_signalfd4, "signalfd4", File::none}}},
    {"memory",
     {{SYS_shmget, "shmget", File::none},
      {SYS_shmat, "shmat", File::none},
      {SYS_shmctl, "shmctl", File::none}}},
};

const std::vector<std::string> of_the_system{"/usr/", "/lib", "/etc/", "/bin/", "/sbin/"};

struct Shared {
    std::atomic<int> listener{-1};
    std::atomic<bool> taken{false};
};

pid_t program = 0;

[[noreturn]] void fail(const char* what) {
    std::fprintf(stderr, "fail_call: %s: %s\n", what, std::strerror(errno));
    _exit(125);
}

int filter_calls(const std::vector<Call>& calls) {
    const auto count = static_cast<unsigned char>(calls.size());
    std::vector<sock_filter> code{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
                                  BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, processor, 1, 0),
                                  BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
                                  BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
    for (unsigned char i = 0; i < count; ++i)
        code.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<unsigned>(calls[i].number),
                                static_cast<unsigned char>(count - i), 0));
    code.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    code.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_USER_NOTIF));
    const sock_fprog filter{static_cast<unsigned short>(code.size()), code.data()};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("no_new_privs");
    constexpr unsigned long wait_killable = 1UL << 5;  // of Linux 5.19: else a signal makes a call come twice
    for (const unsigned long flags :
         {SECCOMP_FILTER_FLAG_NEW_LISTENER | wait_killable, SECCOMP_FILTER_FLAG_NEW_LISTENER}) {
        const long listener = syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, flags, &filter);
        if (listener >= 0) return static_cast<int>(listener);
    }
    fail("this system gives no seccomp listener");
}

// The listener goes by shared memory: the calls that would carry it may be under observation.
[[noreturn]] void become_program(Shared& shared, const std::vector<Call>& calls, char** words) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int listener = filter_calls(calls);
    shared.listener = listener;
    while (!shared.taken) sched_yield();
    close(listener);
    execvp(words[0], words);
    fail(words[0]);
}

std::string link_of(pid_t process, const std::string& name) {
    char text[PATH_MAX];
    const std::string link = "/proc/" + std::to_string(process) + "/" + name;
    const ssize_t length = readlink(link.c_str(), text, sizeof text);
    return length < 0 ? "" : std::string(text, static_cast<std::size_t>(length));
}

bool begins_with_one_of(const std::string& text, const std::vector<std::string>& beginnings) {
    return std::any_of(beginnings.begin(), beginnings.end(),
                       [&](const auto& one) { return text.compare(0, one.size(), one) == 0; });
}

std::string text_at(pid_t process, unsigned long address) {
    std::string text;
    while (text.size() < PATH_MAX) {  // a page at most: the next one may not be there
        char piece[64];
        const std::size_t size = std::min<std::size_t>(sizeof piece, 4096 - address % 4096);
        const iovec here{piece, size};
        const iovec there{reinterpret_cast<void*>(address), size};
        if (process_vm_readv(process, &here, 1, &there, 1, 0) != static_cast<ssize_t>(size)) return text;
        const std::size_t length = strnlen(piece, size);
        text.append(piece, length);
        if (length < size) return text;
        address += size;
    }
    return text;
}

class Fault {
public:
    Fault(const std::vector<Call>& calls, int error, long at, std::string report,
          std::vector<std::string> ours)
        : calls_(calls), error_(error), at_(at), report_(std::move(report)), ours_(std::move(ours)) {
        note("");
    }

    void answer(int listener) {
        seccomp_notif request{};
        seccomp_notif_resp response{};
        if (ioctl(listener, SECCOMP_IOCTL_NOTIF_RECV, &request) != 0) return;
        response.id = request.id;
        response.flags = SECCOMP_USER_NOTIF_FLAG_CONTINUE;
        const auto call = std::find_if(calls_.begin(), calls_.end(),
                                       [&](const Call& each) { return each.number == request.data.nr; });
        std::string file;
        if (counts(*call, request, file)) {
            ++count_;
            const bool lasting = error_ == ENOSPC && at_ > 0 && count_ > at_;
            if (count_ == at_ || lasting) {
                response.flags = 0;
                response.error = -error_;
                if (count_ == at_) {
                    note(std::string(call->name) + " " + file);
                    leave_half(*call, request, response);
                }
            } else {
                note("");
            }
        }
        ioctl(listener, SECCOMP_IOCTL_NOTIF_SEND, &response);
    }

    void end(int status) {
        status_ = std::to_string(status);
        note("");
    }

private:
    bool counts(const Call& call, const seccomp_notif& request, std::string& file) {
        const auto process = static_cast<pid_t>(request.pid);
        if (!begins_with_one_of(link_of(process, "exe"), ours_)) return false;
        const auto& argument = request.data.args;
        if (call.file == File::descriptor && static_cast<int>(argument[0]) == STDERR_FILENO) return false;
        if (call.file == File::path) file = text_at(process, argument[0]);
        if (call.file == File::path_at) file = text_at(process, argument[1]);
        if (call.file == File::path_at && file.empty())
            file = link_of(process, "fd/" + std::to_string(static_cast<int>(argument[0])));
        if (call.file == File::descriptor)
            file = link_of(process, "fd/" + std::to_string(static_cast<int>(argument[0])));
        if (error_ == ENOSPC && !begins_with_one_of(file, {"/"})) return false;  // a pipe
        // The loader looks below the folder of a program.
        return !begins_with_one_of(file, of_the_system) && !begins_with_one_of(file, ours_);
    }

    // A disk that becomes full takes the first bytes.
    void leave_half(const Call& call, const seccomp_notif& request, seccomp_notif_resp& response) const {
        const auto size = static_cast<std::size_t>(request.data.args[2]) / 2;
        if (error_ != ENOSPC || call.number != SYS_write || size == 0) return;
        const auto process = static_cast<pid_t>(request.pid);
        std::string bytes(std::min<std::size_t>(size, 1 << 20), '\0');
        const iovec here{bytes.data(), bytes.size()};
        const iovec there{reinterpret_cast<void*>(request.data.args[1]), bytes.size()};
        const int holder = static_cast<int>(syscall(SYS_pidfd_open, process, 0));
        const int file =
            static_cast<int>(syscall(SYS_pidfd_getfd, holder, static_cast<int>(request.data.args[0]), 0));
        if (file >= 0 &&
            process_vm_readv(process, &here, 1, &there, 1, 0) == static_cast<ssize_t>(bytes.size())) {
            const ssize_t written = write(file, bytes.data(), bytes.size());
            if (written > 0) {
                response.error = 0;
                response.val = written;
            }
        }
        if (file >= 0) close(file);
        if (holder >= 0) close(holder);
    }

    void note(const std::string& failed) {
        if (!failed.empty()) failed_ = failed;
        std::ofstream(report_) << count_ << "\n" << failed_ << "\n" << status_ << "\n";
    }

    const std::vector<Call>& calls_;
    const int error_;
    const long at_;
    const std::string report_;
    const std::vector<std::string> ours_;
    long count_ = 0;
    std::string failed_, status_;
};

}  // namespace

int main(int argc, char** argv) {
    char** const end = argv + argc;
    char** const mark =
        std::find_if(argv, end, [](const char* word) { return std::strcmp(word, "--") == 0; });
    if (mark - argv < 6 || end - mark < 2 || kinds.count(argv[1]) == 0) {
        std::fputs("fail_call KIND ERROR N REPORT OURS... -- PROGRAM [argument ...]\n", stderr);
        return 125;
    }
    const std::vector<Call>& calls = kinds.at(argv[1]);
    void* const memory =
        mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) fail("mmap");
    auto& shared = *new (memory) Shared;
    program = fork();
    if (program < 0) fail("fork");
    if (program == 0) become_program(shared, calls, mark + 1);
    for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
        struct sigaction action {};
        action.sa_handler = [](int signal) { kill(program, signal); };
        sigaction(number, &action, nullptr);
    }
    int status = 0;
    while (shared.listener < 0)
        if (waitpid(program, &status, WNOHANG) == program) return 125;
    const int holder = static_cast<int>(syscall(SYS_pidfd_open, program, 0));
    const int listener = static_cast<int>(syscall(SYS_pidfd_getfd, holder, shared.listener.load(), 0));
    if (listener < 0) fail("pidfd_getfd");
    shared.taken = true;
    Fault fault(calls, std::atoi(argv[2]), std::atol(argv[3]), argv[4], {argv + 5, mark});
    bool ended = false;
    for (;;) {
        pollfd look{listener, POLLIN, 0};
        const int ready = poll(&look, 1, 20);
        if (ready > 0 && (look.revents & POLLIN) != 0)
            fault.answer(listener);
        else if (ready > 0)
            break;  // none of them is left
        ended = ended || waitpid(program, &status, WNOHANG) == program;
    }
    while (!ended && (waitpid(program, &status, 0) == program || errno != EINTR)) ended = true;
    const int result = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    fault.end(result);
    return result;
}
