// SPDX-License-Identifier: GPL-2.0-or-later
// The programs beside the host: the one that it was started to run, each halcmd that it runs, and all that
// these start. It passes on the output of a halcmd, waits for the dead, and knows who is alive.
#pragma once

#include <poll.h>
#include <sys/types.h>

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb::host {

// The end of a halcmd: its exit status (128 + the signal when it was killed), and all output.
struct Finished {
    int status;
    std::string output;
};

struct ProgramNotFound : std::runtime_error {
    ProgramNotFound(const std::string& what, int exit_status)
        : std::runtime_error(what), status(exit_status) {}
    int status;  // the status of a shell: 127, or 126 for a file that cannot be executed
};

class Programs {
public:
    Programs();
    ~Programs();
    Programs(const Programs&) = delete;

    // Starts the program that the host is there for, on the host's own terminal, standard input and output,
    // in its folder. Throws ProgramNotFound when there is none that could be started. Returns its number.
    void start_program(const std::vector<std::string>& words);

    // Exit status of that program, 128 + the signal when it was killed; nothing while it runs or when there
    // is none.
    std::optional<int> program_status() const { return program_status_; }

    bool program_runs() const { return program_ != 0 && !program_status_; }

    // Asks that program to end, if it runs.
    void ask_program_to_end() const;

    // Asks everything to end but the halcmds that the host runs.
    void ask_all_to_end() const;

    // Gives a command to halcmd, in folder `directory` ("" for the host's own). `done` is called from
    // attend(), once it is carried out. One halcmd takes all commands that load no program and read no file,
    // one after the other. It is gone before another halcmd starts, and 0.2 s after its last command; a host
    // that runs a program has none. So nobody sees more halcmds than if each command had its own. Throws
    // std::runtime_error when there is no halcmd.
    void start_halcmd(const std::vector<std::string>& arguments, const std::string& directory,
                      std::function<void(Finished)> done);

    // Carries out a command that needs nothing from this host's socket (setp, show, unlinkp) and waits for
    // its end. Throws std::runtime_error if there is no halcmd, or it does not end within 10 s.
    Finished halcmd(const std::vector<std::string>& arguments);

    // HAL's memory is gone: no halcmd may keep it.
    void let_halcmd_go();

    // Appends the descriptors that attend() waits for.
    void add_to(std::vector<pollfd>& waits) const;

    // Passes on output, reports the ended, and keeps HAL's lock from being lost. `seen` is what poll() told
    // of the descriptors of add_to(). Never blocks. Call it when something waits, and every 0.1 s while
    // waits_for_hal().
    void attend(const std::vector<pollfd>& seen);

    bool halcmd_runs() const;

    // Whether a program runs that may wait for HAL's lock.
    bool waits_for_hal() const;

    // How many commands halcmd has been given since the host began.
    unsigned long halcmds_begun() const { return halcmds_begun_; }

    // User-space programs that are alive, by the name of their HAL component or else of their program file.
    std::vector<std::string> alive();

    // Numbers of the processes that this host or its programs have started and whose program file has this
    // name.
    std::vector<pid_t> called(const std::string& name) const;

    // Asks all user-space programs to end, and kills those that do not.
    void end_all();

private:
    using Clock = std::chrono::steady_clock;
    struct Command;

    Command& spawn_halcmd(const std::vector<std::string>& words, const std::string& directory, int input);
    Command* standing_halcmd();
    Command& halcmd_for(const std::vector<std::string>& arguments, const std::string& directory);
    void look(int milliseconds);  // waits for that long at most, then attends
    void await_halcmd_gone();
    void attend_standing_halcmd();
    std::vector<pid_t> others() const;
    void read_output(Command& command);
    void reap();

    int child_events_;  // a signalfd for SIGCHLD
    pid_t program_ = 0;
    std::optional<int> program_status_;
    std::list<Command> commands_;
    unsigned long halcmds_begun_ = 0;
};

}  // namespace plumb::host
