// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/csv.hpp"
#include "components/io/files/direction_rows.hpp"

#include <cctype>
#include <cstddef>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace plumb {

// The joints that an INI file of LinuxCNC compensates by BACKLASH or COMP_FILE, with the files that it includes.
// [KINS]KINEMATICS coordinates= gives the order of the joints; without it, [TRAJ]COORDINATES does.
// Throws std::runtime_error with file, line and reason.
class IniCompensation {
public:
    explicit IniCompensation(const std::string& file) { read(file, 0); }

    // Throws std::runtime_error with file, line and reason if a joint of the axis is compensated.
    void refuse(char axis) const {
        const std::string& letters = by_kinematics_.empty() ? letters_ : by_kinematics_;
        for (const auto& [joint, its] : found_)
            if (static_cast<std::size_t>(joint) < letters.size() &&
                letters[static_cast<std::size_t>(joint)] == axis)
                throw std::runtime_error(its.place + csv::quoted(its.text) + ": LinuxCNC compensates " + axis +
                                         " already, so a table of its scale would correct it twice. Take it "
                                         "over with plumb volume import, and delete this line");
    }

private:
    static constexpr int deepest = 16;  // files that include files

    struct Found {
        std::string place, text;
    };

    void read(const std::string& file, int depth) {
        const std::string text = csv::text_of(file);
        const direction_rows::Lines lines(file, text);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const std::string_view line = lines[i];
            if (line.rfind("#INCLUDE", 0) == 0) {
                if (depth == deepest) lines.refuse(i, "too many files include each other");
                const std::filesystem::path folder = std::filesystem::path(file).parent_path();
                read((folder / std::string(csv::trimmed(line.substr(8)))).string(), depth + 1);
                continue;
            }
            if (line.empty() || line[0] == '#' || line[0] == ';') continue;
            if (line[0] == '[') {
                section_ = line.substr(1, line.find(']') - 1);
                continue;
            }
            const std::size_t equals = line.find('=');
            if (equals == std::string_view::npos) continue;
            take(std::string(csv::trimmed(line.substr(0, equals))), csv::trimmed(line.substr(equals + 1)),
                 {file + ": line " + std::to_string(i + 1) + ": ", std::string(line)});
        }
    }

    void take(const std::string& name, std::string_view value, const Found& its) {
        const std::size_t coordinates = value.find("coordinates=");
        if (section_ == "TRAJ" && name == "COORDINATES" && letters_.empty())
            letters_ += upper(value);
        else if (section_ == "KINS" && name == "KINEMATICS" && coordinates != std::string_view::npos)
            by_kinematics_ += upper(value.substr(coordinates + 12, value.find(' ', coordinates) - coordinates - 12));
        if (section_.rfind("JOINT_", 0) != 0) return;
        const auto joint = csv::number(section_.substr(6));
        if (!joint) return;
        const auto backlash = csv::number(value.substr(0, value.find_first_of(" \t#;")));
        if (name == "COMP_FILE" || (name == "BACKLASH" && !(backlash && *backlash == 0)))
            found_[static_cast<int>(*joint)] = its;
    }

    static std::string upper(std::string_view text) {
        std::string result;
        for (const char c : text)
            if (c != ' ' && c != '\t')
                result += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        return result;
    }

    std::string section_, letters_, by_kinematics_;
    std::map<int, Found> found_;
};

}  // namespace plumb
