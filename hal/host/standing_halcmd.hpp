// SPDX-License-Identifier: GPL-2.0-or-later
// The words between the host and a halcmd that takes one command after the other from its standard input. Its
// start is nine tenths of the cost of a command. The halcmd is as unmodified as any. A command that fails
// ends it with the exit status of the command; behind a command that succeeds, it carries out a `print`. So
// the host knows the status of each command, and the end of its output.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace plumb::host {

class StandingHalcmd {
public:
    // Whether such a halcmd does the same with these arguments as one of their own: a command that loads no
    // program, reads no file, and has no character that halcmd interprets in a line but not in an argument.
    static bool takes(const std::vector<std::string>& arguments);

    // Throws std::runtime_error when the system gives no pipe.
    StandingHalcmd();
    ~StandingHalcmd();
    StandingHalcmd(const StandingHalcmd&) = delete;

    static std::vector<std::string> words() { return {"halcmd", "-f"}; }
    int input() const { return input_; }  // to be its standard input; -1 once it has begun
    void has_begun();

    // Gives it a command. Returns false if it has ended.
    bool give(const std::vector<std::string>& arguments);

    // The output of the last command, as a halcmd of its own writes it, if `text` has it whole.
    std::optional<std::string> whole_output(const std::string& text) const;

    // The same of a halcmd that has ended before it wrote the words behind the command.
    std::string last_output(const std::string& text) const;

    // It ends by itself once it has carried out the last command.
    void let_go();
    bool let_gone() const { return given_ < 0; }

private:
    int input_;
    int given_;          // the other end
    unsigned line_ = 0;  // of the last command, as halcmd counts
};

}  // namespace plumb::host
