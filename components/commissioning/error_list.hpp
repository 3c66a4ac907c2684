// SPDX-License-Identifier: GPL-2.0-or-later
// The errors of a chain of linear axes, one line each: measured, assumed or unknown. plumb squareness, plumb
// volume and the panel show this list; plumb volume computes U from it.
#pragma once

#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/tilt.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::commissioning {

struct ErrorLine {
    enum class Kind {
        corner,
        scale,
        straightness,
        angle,
        lost_motion,
        repeatability,
        second_axis,
        growth,
        bending,
        drift
    };
    enum class State { unknown, assumed, measured };

    Kind kind = Kind::corner;
    std::string name;  // XY, EXX, lost motion X
    State state = State::unknown;
    double u = 0;    // standard: mm, rad, or mm/mm for growth
    std::string by;  // measured: instrument or file, and date; assumed: the source; unknown: why, or ""

    bool is_like(const ErrorLine& its) const {
        return its.kind == kind && its.state == state && its.u == u && its.by == by;
    }
    bool is_angle() const {
        return kind == Kind::corner || kind == Kind::angle || kind == Kind::bending ||
               (kind == Kind::drift && name.find_first_of("ABC") != std::string::npos);  // drift EC0Y
    }
    const char* unit() const { return kind == Kind::growth ? "um/m" : is_angle() ? "urad" : "um"; }
    double in_unit() const { return u * (is_angle() || kind == Kind::growth ? 1e6 : 1e3); }

    // A word for screens.
    const char* word() const {
        static constexpr const char* words[] = {"corner",      "scale",         "straightness", "angle",
                                                "lost-motion", "repeatability", "second-axis",  "growth",
                                                "bending",     "drift"};
        return words[static_cast<std::size_t>(kind)];
    }
    // How an unknown error becomes a measured one. The panel shows these texts, too (scripts/panel_texts.py).
    const char* how() const {
        static constexpr const char* hows[] = {
            "square and indicator, or diagonals of a part: plumb squareness or the page Measure and set up",
            "laser or gauge blocks: plumb volume import",
            "straightedge and indicator: plumb volume straightedge",
            "level or autocollimator: a table with this column and its u",
            "indicator, from both sides: plumb volume reversal",
            "the same place five times: plumb volume reversal",
            "straightedge or level at both ends of the other axis: --assume or [SQUARENESS]ASSUME",
            "thermometer: # temperature in each table, and --temperature or axis_growth",
            "square, cold and warm: --assume or [SQUARENESS]ASSUME",
            "measure again, or state # drift in the table",
        };
        return hows[static_cast<std::size_t>(kind)];
    }
};

class ErrorList {
public:
    using Kind = ErrorLine::Kind;
    using State = ErrorLine::State;

    // All lines of X, Y and Z in the chain, unknown.
    explicit ErrorList(const AxisChain& chain) {
        std::string axes;
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z})
            if (chain.has(axis)) axes += letter(axis);
        for (std::size_t b = 0; b < axes.size(); ++b)
            for (std::size_t a = 0; a < b; ++a) add(Kind::corner, {axes[a], axes[b]});
        for (const char axis : axes) add(Kind::scale, {'E', axis, axis});
        for (const char axis : axes)
            for (const char across : {'X', 'Y', 'Z'})
                if (across != axis) add(Kind::straightness, {'E', across, axis});
        for (const char axis : axes)
            for (const char about : {'A', 'B', 'C'}) add(Kind::angle, {'E', about, axis});
        for (const char axis : axes) add(Kind::lost_motion, std::string("lost motion ") + axis);
        for (const char axis : axes) add(Kind::repeatability, std::string("repeatability ") + axis);
        add(Kind::second_axis, "second axis");
        add(Kind::growth, "growth");
        add(Kind::bending, "bending");
    }

    const std::vector<ErrorLine>& lines() const { return lines_; }
    ErrorLine* find(std::string_view name) {
        for (ErrorLine& line : lines_)
            if (line.name == name) return &line;
        return nullptr;
    }
    // A line of the list, or a new one at its end.
    ErrorLine& line(Kind kind, const std::string& name) {
        if (ErrorLine* const its = find(name)) return *its;
        add(kind, name);
        return lines_.back();
    }
    // A standard uncertainty of 0 is none: nobody measures without one.
    static void set(ErrorLine& line, State state, double u, const std::string& by) {
        line.state = u > 0 ? state : State::unknown;
        line.u = u;
        line.by = u > 0 ? by : by + (by.empty() ? "" : ", ") + "without u";
    }

    std::vector<const ErrorLine*> unknown() const {
        std::vector<const ErrorLine*> all;
        for (const ErrorLine& line : lines_)
            if (line.state == State::unknown) all.push_back(&line);
        return all;
    }
    // 19 of 33 errors are unknown, the first of them XZ. Empty if none is.
    std::string sentence() const {
        const auto open = unknown();
        if (open.empty()) return "";
        return std::to_string(open.size()) + " of " + std::to_string(lines_.size()) +
               (open.size() == 1 ? " errors is unknown: " : " errors are unknown, the first of them ") +
               open.front()->name + ". To measure " + open.front()->name + ": " + open.front()->how() + '.';
    }

    // A table of at most 100 columns; lines that differ in the name alone are one.
    std::string text() const {
        constexpr std::size_t width = 64, left = 36;
        std::string result = "Errors of this machine   u          by\n";
        for (std::size_t i = 0; i < lines_.size();) {
            const ErrorLine& its = lines_[i];
            std::string names = its.name;
            std::size_t next = i + 1;
            for (; next < lines_.size() && its.is_like(lines_[next]); ++next)
                names += ' ' + lines_[next].name.substr(lines_[next].name.rfind(' ') + 1);
            if (names.size() > 22) {
                result += "  " + names + '\n';
                names.clear();
            }
            char begin[80];
            if (its.state == State::unknown)
                std::snprintf(begin, sizeof begin, "  %-22s %-8s", names.c_str(), "unknown");
            else
                std::snprintf(begin, sizeof begin, "  %-22s %4.3g %-4s", names.c_str(), its.in_unit(),
                              its.unit());
            result += begin;
            std::string words = its.state == State::assumed ? "assumed: " + its.by
                                : its.state == State::measured
                                    ? "measured: " + its.by
                                    : its.by + (its.by.empty() ? "" : "; ") + "measure by: " + its.how();
            for (bool first = true; !words.empty(); first = false) {
                std::size_t end = words.size() <= width ? words.size() : words.rfind(' ', width);
                if (end == std::string::npos) end = width;  // the path of a file
                const std::size_t column =
                    first ? std::max<std::size_t>(std::string(begin).size() + 1, left) : 0;
                result += std::string(first ? column - std::string(begin).size() : left, ' ') +
                          words.substr(0, end) + '\n';
                words.erase(0, std::min(words.size(), end + (end < words.size() && words[end] == ' ')));
            }
            i = next;
        }
        return result;
    }

    nlohmann::ordered_json json() const {
        static constexpr const char* states[] = {"unknown", "assumed", "measured"};
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const ErrorLine& its : lines_)
            all.push_back({{"name", its.name},
                           {"kind", its.word()},
                           {"state", states[static_cast<std::size_t>(its.state)]},
                           {"u", its.state == State::unknown ? nlohmann::ordered_json()
                                                             : nlohmann::ordered_json(its.u)},
                           {"unit", its.kind == Kind::growth ? "1"
                                    : its.is_angle()         ? "rad"
                                                             : "mm"},
                           {"by", its.by},
                           {"how", its.how()}});
        return all;
    }

private:
    void add(Kind kind, const std::string& name) {
        ErrorLine line;
        line.kind = kind;
        line.name = name;
        lines_.push_back(line);
    }

    std::vector<ErrorLine> lines_;
};

}  // namespace plumb::commissioning
