// SPDX-License-Identifier: GPL-2.0-or-later
// A machine of a test's own: processes, shared memory, HOME and /tmp that nobody else has, so that the
// leftovers of a host can be counted, and a stock LinuxCNC can run beside anything else.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace plumb {

struct MachineOptions {
    std::filesystem::path modules = {};                // to lie over LinuxCNC's own folder of modules
    std::vector<std::filesystem::path> programs = {};  // to be copied to /tmp/bin
    bool as_root = true;             // else as an ordinary user, if the test itself is not root's
    bool own_users = false;          // with users of its own, so that it may change limits of the kernel
    std::chrono::seconds limit{60};  // after which all its processes are killed
};

// Whom a host meets on the machine: root, an ordinary user, or root where namespaces are not used.
enum class Role { root, user, no_namespaces };
std::string name_of(Role role);
void PrintTo(Role role, std::ostream* out);

// For hosts of this role.
MachineOptions machine_of(Role role);

// Runs `body` as the first process of such a machine; failed expectations in it fail this test. It finds
// plumb-host as host_of_machine(). Skips the test, with the reason, where the kernel gives no namespaces.
void on_own_machine(const std::function<void()>& body, const MachineOptions& options = {});

inline const char* const host_of_machine = "/tmp/bin/plumb-host";

// The processes of the machine, to be called on it.
struct Processes {
    static std::vector<pid_t> all();               // but the first
    static pid_t called(const std::string& name);  // waits for it to be there, for 5 s
    static std::string name(pid_t process);
};
int shared_memory_segments();
std::vector<std::string> files();  // in /tmp, but the programs and the clone, in HOME and in /dev/shm

// Waits until no process, no segment and no file is left, for 20 s; fails the test if any is.
void expect_nothing_left(const std::vector<std::string>& files_before);

// A process of the machine. Its failed expectations and exceptions fail the test as soon as it is awaited.
class Child {
public:
    // Runs as root, or as a user without any rights; `body` may say() lines to its parent.
    Child(bool root, const std::function<void(Child& self)>& body);
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void say(const std::string& line);  // child: to the parent
    std::string hear();                 // parent: the next line; throws at the end, or after 20 s
    void go();                          // parent: lets the child go on
    void await_go();                    // child: waits for that
    void kill();                        // parent: with signal 9
    void await_success();               // parent: within 20 s

    pid_t process() const { return process_; }

private:
    pid_t process_ = 0;
    int said_ = -1;
    int gone_ = -1;
};

}  // namespace plumb
