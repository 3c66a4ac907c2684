// SPDX-License-Identifier: GPL-2.0-or-later
// A client of the virtual-time host: starts a plumb-host of its own, or attaches to one that runs.
//
// A client talks to the host through a socket and touches no HAL memory, so it may be killed at any time
// and needs no namespace. Every call blocks until the host has answered, and throws std::runtime_error with
// the host's sentence if it refuses. Once the host is dead every call throws HostDied at once, with the
// host's last words. Not for use from several threads at a time.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb::client {

using Time = std::chrono::nanoseconds;  // virtual time; counts from the start of the host

// The nearest whole nanosecond. Throws std::invalid_argument unless seconds is finite and fits.
Time seconds(double seconds);

struct HostDied : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Path of plumb-host: beside this program, in the bin folder of its build, or in PATH. Throws
// std::runtime_error when it is nowhere.
std::string find_host();

// How to start a host.
struct Start {
    std::vector<std::string> modules;         // folders of modules, searched before build and LinuxCNC's own
    std::vector<std::string> module_options;  // MODULE.NAME=VALUE, in the place of those in loadrt lines
    std::string models;                       // list of models of drivers; empty: none
    bool namespaces = true;                   // false: in the machine's one HAL, one host at a time
    bool guard = false;        // watch for allocations and, on x86-64, system calls in realtime functions
    bool show_output = false;  // pass output of the host and its programs on to stderr
    std::string executable;    // plumb-host; empty: beside this program, else in PATH
};

// How to find a host that runs.
struct Attach {
    std::string socket;  // its RTAPI_FIFO_PATH
};

// The output of halcmd; status 0 is success.
struct Halcmd {
    int status;
    std::string output;  // stdout and stderr, and output of modules meanwhile
};

// The value of a pin, parameter or signal. Every HAL type fits in a double; bits are 0 and 1.
struct Value {
    double value;
    std::string type;  // "float", "bit", "s32" or "u32"
};

// The result of a run.
struct Ran {
    Time time;          // virtual time at its end
    Time ran;           // span of the run
    std::string ended;  // "replay" if the end of the replayed file ended it, else ""
};

// Columns of values to be written to a CSV file, a row at once and one after each `every`.
struct Record {
    std::vector<std::string> names;
    Time every;
    std::string file;
    bool append = false;
};

// A file of values to be written into pins before each period, from now on.
struct Replay {
    std::string file;
    std::vector<std::string> columns = {};   // for a halsampler file, which has no header
    std::optional<Time> sample_period = {};  // with columns: the time from row to row
    bool override_links = false;             // write pins that are netted as well
};

struct Violation {
    std::string id;
    std::int64_t count;  // periods in which the expectation did not hold
    Time first_time;
    std::map<std::string, double> values;  // of its variables, then; and of x_rate, if it uses that
};

// An allocation or a system call in a realtime function.
struct GuardViolation {
    std::string function;
    std::string what;
};

class Client {
public:
    // Throws std::runtime_error, with the host's words, when it does not start.
    explicit Client(const Start& start = {});
    explicit Client(const Attach& attach);
    // Ends the host if this client started it.
    ~Client();
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    const std::string& socket() const;                // RTAPI_FIFO_PATH of the host
    bool namespaces() const;                          // whether it has a HAL of its own
    const std::vector<std::string>& modules() const;  // the folders it searches
    pid_t process() const;                            // the host's number, as seen from here
    Time time();
    // Version of the layout of HAL's memory, HAL_VER in LinuxCNC's source; 0 before the first module is
    // loaded.
    int hal_version();

    // Runs the real halcmd beside the host, in this process's working directory.
    Halcmd halcmd(const std::vector<std::string>& arguments);
    // One line of a .hal file. Throws with halcmd's message when it fails.
    void command(const std::string& line);
    // A .hal file, with the values of an INI file if one is named. Throws with halcmd's message when it
    // fails.
    void source(const std::string& file, const std::string& ini = "");

    // By the name of a pin, a parameter or a signal, in this order.
    double get(const std::string& name) { return read(name).value; }
    Value read(const std::string& name);
    std::vector<Value> read(const std::vector<std::string>& names);
    // Refuses a value that `halcmd setp` and `halcmd sets` refuse, in their words.
    void set(const std::string& name, double value);

    // Moves virtual time. Calls `progress` with the virtual time done, about five times a second of real
    // time; if it returns false the run stops at the next period.
    Ran run(Time time, const std::function<bool(Time done)>& progress = {});

    void record(const std::string& id, const Record& record);
    void record_stop(const std::string& id);
    // Returns how long the replay lasts.
    Time replay(const Replay& replay);

    // Checks a statement after every period: an expression that is true or false. Besides each variable x
    // it may use x_rate, the change of x per second, and finite(x).
    void expect(const std::string& id, const std::string& expression,
                const std::map<std::string, std::string>& variables);
    std::vector<Violation> violations();
    std::vector<GuardViolation> guard();

    // User-space HAL programs that are alive.
    std::vector<std::string> programs();

    // Lets the host unload its modules and end; the destructor does the same.
    void exit();

private:
    class Connection;
    std::unique_ptr<Connection> connection_;
};

}  // namespace plumb::client
