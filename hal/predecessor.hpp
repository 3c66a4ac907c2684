// SPDX-License-Identifier: GPL-2.0-or-later
// A program that was killed leaves its component in HAL, with its pins and its name, and HAL refuses a second
// component of that name. The program takes the place of its dead predecessor, with its nets.
#pragma once

#include <hal.h>

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb::hal {

class Predecessor {
public:
    // Of a component and of the prefix of its pins. Both names are fit for HAL.
    Predecessor(const std::string& component, const std::string& prefix) {
        for (const auto& words : lines("show comp '" + component + "'"))
            if (words.size() >= 4 && words[1] == "User" && words[2] == component) {
                id_ = number(words[0]);
                process_ = number(words[3]);
            }
        if (!is_dead()) return;
        for (const auto& words : lines("show pin '" + prefix + ".*'"))
            for (std::size_t i = 0; i + 2 < words.size(); ++i)
                if (words[i].rfind(prefix + ".", 0) == 0 && words[i + 1].size() == 3)  // ==> or <== or <=>
                    nets_.emplace_back(words[i], words[i + 2]);
    }

    // It is in HAL, and its process has ended, also where no parent has waited for it yet.
    bool is_dead() const {
        if (process_ <= 0) return false;
        if (kill(process_, 0) != 0) return errno == ESRCH;
        std::ifstream file("/proc/" + std::to_string(process_) + "/stat");
        std::string line;
        std::getline(file, line);
        return line.find(") Z ") != std::string::npos;
    }

    // HAL counts the components of this process, and a foreign one that leaves counts as its own: another
    // entry, without pins, stays in HAL instead.
    void remove() const {
        if (hal_init(("left-by-" + std::to_string(process_)).c_str()) > 0) hal_exit(id_);
    }

    // The pins of the new component join the signals of the old ones.
    void net() const {
        for (const auto& [pin, signal] : nets_) hal_link(pin.c_str(), signal.c_str());
    }

private:
    using Words = std::vector<std::string>;

    static int number(const std::string& text) {
        return static_cast<int>(std::strtol(text.c_str(), nullptr, 10));
    }

    static std::vector<Words> lines(const std::string& command) {
        const std::unique_ptr<FILE, int (*)(FILE*)> shown(
            popen(("halcmd -s " + command + " 2>/dev/null").c_str(), "r"), pclose);
        std::vector<Words> found;
        char line[1024];
        while (shown && std::fgets(line, sizeof line, shown.get())) {
            std::istringstream rest(line);
            Words words;
            for (std::string word; rest >> word;) words.push_back(word);
            found.push_back(words);
        }
        return found;
    }

    int id_ = 0, process_ = 0;
    std::vector<std::pair<std::string, std::string>> nets_;
};

}  // namespace plumb::hal
