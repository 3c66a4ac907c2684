// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/program.hpp"

#include "tests/support/bench.hpp"
#include "tests/support/folder.hpp"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <sstream>
#include <stdexcept>

namespace plumb {
namespace {

// In the child: becomes the program, which is asked to end if the test is killed.
[[noreturn]] void execute(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                          pid_t test) {
    std::vector<char*> argv;
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != test) _exit(127);  // it was killed before that
    if (chdir(directory.c_str()) == 0) execv(argv[0], argv.data());
    _exit(127);
}

int await_status(pid_t process) {
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

Outcome run_program(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                    const std::function<void(pid_t)>& meanwhile) {
    const Folder folder;
    const auto open_for = [&folder](const char* name) {
        return open((folder / name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    };
    const int output = open_for("output");
    const int errors = open_for("errors");
    const pid_t test = getpid();
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error("fork");
    if (process == 0) {
        dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
        dup2(output, STDOUT_FILENO);
        dup2(errors, STDERR_FILENO);
        execute(arguments, directory, test);
    }
    close(output);
    close(errors);
    try {
        if (meanwhile) meanwhile(process);
    } catch (...) {
        kill(process, SIGTERM);
        await_status(process);
        throw;
    }
    const int status = await_status(process);
    return {status, contents(folder / "output"), contents(folder / "errors")};
}

Outcome run_on_terminal(const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                        const std::string& cue, const std::string& keys) {
    int terminal = -1;
    const pid_t test = getpid();
    const pid_t process = forkpty(&terminal, nullptr, nullptr, nullptr);
    if (process < 0) throw std::runtime_error("forkpty");
    if (process == 0) {
        for (const int its : {SIGHUP, SIGINT, SIGQUIT}) signal(its, SIG_DFL);  // the test may run under nohup
        execute(arguments, directory, test);
    }
    Outcome outcome{};
    char bytes[4096];
    bool typed = keys.empty();
    for (ssize_t n; (n = read(terminal, bytes, sizeof bytes)) > 0;) {  // ends with an error, as terminals do
        outcome.output.append(bytes, static_cast<std::size_t>(n));
        if (typed || outcome.output.find(cue) == std::string::npos) continue;
        typed = write(terminal, keys.data(), keys.size()) == static_cast<ssize_t>(keys.size());
    }
    close(terminal);
    outcome.status = await_status(process);
    return outcome;
}

std::string hal_lines(const std::string& output) {
    std::string found;
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);)
        if (line.rfind("  loadrt ", 0) == 0 || line.rfind("  setp ", 0) == 0) found += line + '\n';
    return found;
}

}  // namespace plumb
