// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/tilt.hpp"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Angles and lengths as people write them: a number with a decimal point, and a unit.
namespace plumb {
namespace quantity_text {

struct Unit {
    std::string_view name;
    double size;  // rad, mm
};

inline const std::vector<Unit>& angle_units() {
    static const std::vector<Unit> units = {{"rad", 1},
                                            {"mrad", 1e-3},
                                            {"urad", 1e-6},
                                            {"deg", angle_from_arcsec(3600)},
                                            {"arcmin", angle_from_arcsec(60)},
                                            {"arcsec", angle_from_arcsec(1)}};
    return units;
}

inline const std::vector<Unit>& length_units() {
    static const std::vector<Unit> units = {{"um", 1e-3}, {"mm", 1},     {"cm", 10},      {"m", 1e3},
                                            {"in", 25.4}, {"ft", 304.8}, {"thou", 0.0254}};
    return units;
}

[[noreturn]] inline void refuse(std::string_view text, const std::string& why) {
    throw std::invalid_argument('\'' + std::string(text) + "' " + why);
}

inline std::string names(const std::vector<Unit>& units) {
    std::string result;
    for (const Unit& unit : units) result += (result.empty() ? "" : " ") + std::string(unit.name);
    return result;
}

// Without blanks; the micro sign and the Greek letter, as UTF-8, are a u, the degree sign is deg.
inline std::string plain(std::string_view text) {
    static constexpr std::pair<std::string_view, std::string_view> signs[] = {
        {"\xc2\xb5", "u"}, {"\xce\xbc", "u"}, {"\xc2\xb0", "deg"}, {" ", ""}, {"\t", ""}};
    std::string result(text);
    for (const auto& [sign, word] : signs)
        for (std::size_t at = 0; (at = result.find(sign, at)) != std::string::npos;)
            result.replace(at, sign.size(), word);
    return result;
}

struct Measure {
    bool has_number = false;
    double number = 1;
    std::string unit;
};

inline Measure measure(const std::string& part, std::string_view text) {
    std::string_view rest = part;
    if (rest.size() > 1 && rest[0] == '+' && rest[1] != '-') rest.remove_prefix(1);
    Measure result;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), result.number);
    if (error == std::errc::result_out_of_range || !std::isfinite(result.number))
        refuse(text, "is beyond all numbers");
    result.has_number = error == std::errc();
    if (result.has_number) rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    if (!rest.empty() && rest[0] == ',') refuse(text, "has a comma: a decimal point is a point");
    result.unit = rest;
    return result;
}

inline double size(const std::string& name, const std::vector<Unit>& units, std::string_view text) {
    for (const Unit& unit : units)
        if (unit.name == name) return unit.size;
    refuse(text, (name.empty() ? "has no unit" : "has an unknown unit, '" + name + '\'') +
                     "; there are: " + names(units));
}

inline double ratio(const std::string& upper_part, const std::string& lower_part, std::string_view text) {
    const Measure upper = measure(upper_part, text), lower = measure(lower_part, text);
    if (!upper.has_number) refuse(text, "does not begin with a number");
    if (!lower.has_number && lower.unit.empty()) refuse(text, "has nothing behind /");
    if (!(lower.number > 0)) refuse(text, "is not per a length of more than 0");
    if (upper.unit.empty() && lower.unit.empty()) return upper.number / lower.number;
    if (upper.unit.empty() || lower.unit.empty())
        refuse(text, "has a unit on one side of / only, such as 0.02mm/300mm has on both");
    return upper.number * size(upper.unit, length_units(), text) /
           (lower.number * size(lower.unit, length_units(), text));
}

}  // namespace quantity_text

// In rad: 12.5arcsec, 0.06 mrad, 60um/m, 0.02mm/300mm, 0.001in/ft, 0.02/300 or 0. Throws
// std::invalid_argument with the text and the reason.
inline double angle_of(std::string_view text) {
    using namespace quantity_text;
    const std::string all = plain(text);
    const std::size_t slash = all.find('/');
    if (slash != std::string::npos)
        return angle_from_slope(ratio(all.substr(0, slash), all.substr(slash + 1), text));
    const Measure angle = measure(all, text);
    if (!angle.has_number) refuse(text, "does not begin with a number");
    if (angle.number == 0 && angle.unit.empty()) return 0;
    for (const Unit& unit : angle_units())
        if (unit.name == angle.unit) return angle.number * unit.size;
    refuse(text, (angle.unit.empty() ? "has no unit" : "has an unknown unit, '" + angle.unit + '\'') +
                     "; there are: " + names(angle_units()) +
                     ", or a length per length, such as 0.02mm/300mm");
}

// In mm: 0.02mm, 300 mm, 5um, 12in; a text without a unit is in `unit` (mm), if there is one. Throws
// std::invalid_argument with the text and the reason.
inline double length_of(std::string_view text, const std::string& unit = "") {
    using namespace quantity_text;
    const Measure length = measure(plain(text), text);
    if (!length.has_number) refuse(text, "does not begin with a number");
    if (length.number == 0 && length.unit.empty()) return 0;
    const double result =
        length.number * size(length.unit.empty() ? unit : length.unit, length_units(), text);
    if (!(std::abs(result) <= 1e6)) refuse(text, "is longer than 1 km");
    return result;
}

// Several lengths with : between them, as in 0:150:300mm; one without a unit has the unit of the last one.
inline std::vector<double> lengths_of(std::string_view text) {
    using namespace quantity_text;
    const std::string unit = measure(plain(text.substr(text.rfind(':') + 1)), text).unit;
    std::vector<double> lengths;
    for (std::size_t from = 0;;) {
        const std::size_t to = text.find(':', from);
        lengths.push_back(length_of(text.substr(from, to - from), unit));
        if (to == std::string_view::npos) return lengths;
        from = to + 1;
    }
}

}  // namespace plumb
