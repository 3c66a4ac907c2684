// SPDX-License-Identifier: GPL-2.0-or-later
// The texts that describe a machine and its measurements, as options or a document give them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace plumb::commissioning {

struct SquarenessGiven {
    // `where` names the text in a refusal: an option, or a place in a document.
    struct Text {
        std::string where, text;
    };
    struct Angle {
        std::string where;
        std::string name;         // Y+X or EC0Y
        std::string angle;        // 0.02mm/300mm
        std::string uncertainty;  // ANGLE, standard; may be empty

        std::string text() const { return name + '=' + angle; }
    };
    struct Fields {
        std::string where;
        std::vector<std::pair<std::string, std::string>> fields;
        std::string text;  // as in the command line; empty if a document gave the fields
    };

    Text chain{"--chain", "w-X-Y.b-Z-C-t"};
    Text datum{"--datum", ""};
    Text gantry{"--gantry", ""};
    Text travel{"--travel", ""};
    Text directions{"--directions", ""};
    std::vector<Angle> leans, quantities, in_force;
    std::vector<Fields> diagonals, squares, openings, points;
};

}  // namespace plumb::commissioning
