// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/csv.hpp"
#include "components/io/files/direction_rows.hpp"

#include <cctype>
#include <cstddef>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace plumb {

// Throws std::runtime_error with file, line and reason if the INI file of LinuxCNC compensates a joint of the
// axis by BACKLASH or COMP_FILE. The joints are those of [KINS]KINEMATICS coordinates=, or of trivkins: in
// the order XYZABCUVW of the letters in [TRAJ]COORDINATES.
inline void refuse_compensated(const std::string& file, char axis) {
    const std::string text = csv::text_of(file);
    const direction_rows::Lines lines(file, text);
    std::string section, letters, by_kinematics;
    struct Found {
        std::size_t line;
        std::string text;
    };
    std::map<int, Found> found;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::string_view line = lines[i];
        if (line.empty() || line[0] == '#' || line[0] == ';') continue;
        if (line[0] == '[') {
            section = line.substr(1, line.find(']') - 1);
            continue;
        }
        const std::size_t equals = line.find('=');
        if (equals == std::string_view::npos) continue;
        const std::string name(csv::trimmed(line.substr(0, equals)));
        const std::string_view value = csv::trimmed(line.substr(equals + 1));
        if (section == "TRAJ" && name == "COORDINATES")
            for (const char c : value)
                if (c != ' ' && c != '\t')
                    letters += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        const std::size_t coordinates = value.find("coordinates=");
        if (section == "KINS" && name == "KINEMATICS" && coordinates != std::string_view::npos)
            for (const char c :
                 value.substr(coordinates + 12, value.find(' ', coordinates) - coordinates - 12))
                by_kinematics += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        if (section.rfind("JOINT_", 0) != 0) continue;
        const auto joint = csv::number(section.substr(6));
        if (!joint) continue;
        const auto backlash = csv::number(value.substr(0, value.find_first_of(" \t#;")));
        if (name == "COMP_FILE" || (name == "BACKLASH" && !(backlash && *backlash == 0)))
            found[static_cast<int>(*joint)] = {i, std::string(line)};
    }
    if (!by_kinematics.empty()) letters = by_kinematics;
    for (const auto& [joint, its] : found)
        if (static_cast<std::size_t>(joint) < letters.size() &&
            letters[static_cast<std::size_t>(joint)] == axis)
            lines.refuse(its.line,
                         csv::quoted(its.text) + ": LinuxCNC compensates " + axis +
                             " already, so a table of its scale would correct it twice. Take it over "
                             "with plumb volume import, and delete this line");
}

}  // namespace plumb
