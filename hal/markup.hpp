// SPDX-License-Identifier: GPL-2.0-or-later
// Plain text as markup of man(7).
#pragma once

#include <ostream>
#include <sstream>
#include <string>

namespace plumb::hal {

// No character of the result is taken for markup.
inline std::string escaped(const std::string& text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const bool line_begins = i == 0 || text[i - 1] == '\n';
        if (line_begins && (c == '.' || c == '\'')) result += "\\&";
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else if (c == '^')
            result += "\\(ha";
        else if (c == '~')
            result += "\\(ti";
        else
            result += c;
    }
    return result;
}

// With lines of at most 78 characters, where its words are shorter.
inline std::string wrapped(const std::string& text) {
    std::istringstream words(text);
    std::string result;
    std::size_t column = 0;
    for (std::string word; words >> word;) {
        const std::size_t length = escaped(word).size();  // the length of the line in the end
        const bool fits = column + 1 + length <= 78;
        if (column != 0) result += fits ? ' ' : '\n';
        column = column != 0 && fits ? column + 1 + length : length;
        result += word;
    }
    return result;
}

// Whether a line begins a step, "1. text", or an item, "- Term: text"; then writes its markup and leaves the
// text.
inline bool begins_item(std::ostream& out, std::string& line) {
    const std::size_t digits = line.find_first_not_of("0123456789");
    if (digits != 0 && digits != std::string::npos && line.compare(digits, 2, ". ") == 0) {
        out << ".IP " << line.substr(0, digits + 1) << " 4\n";
        line.erase(0, digits + 2);
        return true;
    }
    const std::size_t colon = line.find(": ");
    if (line.compare(0, 2, "- ") != 0 || colon == std::string::npos) return false;
    out << ".TP\n" << escaped(line.substr(2, colon - 2)) << '\n';
    line.erase(0, colon + 2);
    return true;
}

// Paragraphs, steps and items are filled; a run of lines that begin with a blank keeps its shape.
inline void write_description(std::ostream& out, const std::string& text) {
    std::istringstream lines(text);
    bool verbatim = false;
    bool pending_gap = false;
    bool first = true;
    for (std::string line; std::getline(lines, line);) {
        if (line.find_first_not_of(' ') == std::string::npos) {
            pending_gap = !first;
            continue;
        }
        const bool shaped = line.front() == ' ';
        if (!shaped && verbatim) out << ".EE\n";
        const bool item = !shaped && begins_item(out, line);
        if (shaped != verbatim) {
            out << (shaped ? first ? ".EX\n" : ".PP\n.EX\n" : item ? "" : ".PP\n");
        } else if (pending_gap && !item) {
            out << (verbatim ? "\n" : ".PP\n");
        }
        pending_gap = false;
        verbatim = shaped;
        first = false;
        out << escaped(shaped ? line : wrapped(line)) << '\n';
    }
    if (verbatim) out << ".EE\n";
}

}  // namespace plumb::hal
