// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/standing_halcmd.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace plumb::host {

namespace {

constexpr const char* commands[] = {"addf",   "alias",   "delf",    "delsig", "getp",  "gets",   "linkpp",
                                    "linkps", "linksp",  "list",    "loadrt", "lock",  "net",    "newsig",
                                    "ptype",  "setp",    "sets",    "show",   "start", "status", "stop",
                                    "stype",  "unalias", "unlinkp", "unlock"};

// halcmd takes 32 words in a line, and cuts it at 1024 characters.
constexpr std::size_t most_words = 30;
constexpr std::size_t longest_line = 900;

// A blank ends a word, # begins a comment, $ and [ a variable, a quote a string, and \ continues a line.
bool plain(char c) {
    return c > ' ' && c <= '~' && std::string_view("#$[\"'\\").find(c) == std::string_view::npos;
}

bool plain_word(const std::string& word) {
    return !word.empty() && std::all_of(word.begin(), word.end(), plain);
}

std::string mark_of(unsigned line) {
    return "HALCMD MSG: plumb-host:" + std::to_string(line) + "\n";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
    return text;
}

std::string place(unsigned line) {
    return "<stdin>:" + std::to_string(line) + ": ";
}

// As if the command had been in the arguments.
std::string as_of_arguments(std::string text, unsigned line) {
    return replaced(std::move(text), place(line), "<commandline>:0: ");
}

}  // namespace

bool StandingHalcmd::takes(const std::vector<std::string>& arguments) {
    if (arguments.empty() || arguments.size() > most_words) return false;
    if (std::find(std::begin(commands), std::end(commands), arguments.front()) == std::end(commands))
        return false;
    std::size_t length = 0;
    for (const std::string& word : arguments) length += word.size() + 1;
    return length <= longest_line && std::all_of(arguments.begin(), arguments.end(), plain_word);
}

StandingHalcmd::StandingHalcmd() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    input_ = ends[0];
    given_ = ends[1];
}

StandingHalcmd::~StandingHalcmd() {
    let_go();
    has_begun();
}

void StandingHalcmd::has_begun() {
    if (input_ >= 0) close(std::exchange(input_, -1));
}

bool StandingHalcmd::give(const std::vector<std::string>& arguments) {
    line_ += line_ == 0 ? 1 : 2;
    std::string text;
    for (const std::string& word : arguments) text += word + " ";
    text += "\nprint plumb-host:" + std::to_string(line_) + "\n";
    // It has read all before, so this fits into the pipe.
    return write(given_, text.data(), text.size()) == static_cast<ssize_t>(text.size());
}

std::optional<std::string> StandingHalcmd::whole_output(const std::string& text) const {
    const std::string mark = mark_of(line_);
    const std::size_t at = text.rfind(mark);
    if (at == std::string::npos) return std::nullopt;
    std::string output = text.substr(0, at);
    // halcmd writes place and mark one after the other; a message of a module may stand between them.
    const std::string before = place(line_ + 1);
    if (const std::size_t begin = output.rfind(before); begin != std::string::npos)
        output.erase(begin, before.size());
    return as_of_arguments(output + text.substr(at + mark.size()), line_);
}

std::string StandingHalcmd::last_output(const std::string& text) const {
    return whole_output(text).value_or(as_of_arguments(text, line_));
}

void StandingHalcmd::let_go() {
    if (given_ >= 0) close(std::exchange(given_, -1));
}

}  // namespace plumb::host
