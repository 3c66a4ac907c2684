// SPDX-License-Identifier: GPL-2.0-or-later
// The text of a manual page that the declarations do not give: sections, each below its heading. A heading is
// a line of capitals after an empty line. Text before the first heading is the DESCRIPTION. A text consists
// of paragraphs; lines that begin with blanks keep their shape, "1. " begins a step, "- " begins an item
// "Term: text". SEE ALSO names pages: halcmd(1), motion(9).
#pragma once

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace plumb::hal {

class Page {
public:
    static constexpr const char* headings[] = {"DESCRIPTION", "WIRING", "SETTING UP",
                                               "BEHAVIOUR",   "LIMITS", "SEE ALSO"};

    explicit Page(const std::string& text) {
        std::string heading = headings[0];
        bool after_gap = true;
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            if (after_gap && is_heading(line)) {
                check(line);
                heading = line;
            } else {
                sections_[heading] += line + '\n';
            }
            after_gap = line.empty();
        }
    }

    // "" if the page has none.
    std::string section(const std::string& heading) const {
        const auto found = sections_.find(heading);
        return found == sections_.end() ? "" : found->second;
    }

private:
    static bool is_heading(const std::string& line) {
        return line.size() > 1 && line.front() != ' ' &&
               line.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ ") == std::string::npos;
    }

    void check(const std::string& heading) const {
        if (std::find(std::begin(headings), std::end(headings), heading) == std::end(headings)) {
            std::string all;
            for (const char* each : headings) all += (all.empty() ? "" : ", ") + std::string(each);
            throw std::invalid_argument("the heading " + heading + " is not one of " + all);
        }
        const auto found = sections_.find(heading);
        if (found != sections_.end() && found->second.find_first_not_of('\n') != std::string::npos)
            throw std::invalid_argument("the heading " + heading + " stands there twice");
    }

    std::map<std::string, std::string> sections_;
};

}  // namespace plumb::hal
