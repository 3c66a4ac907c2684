// SPDX-License-Identifier: GPL-2.0-or-later
// How messages about squareness write axes, angles and numbers.
#pragma once

#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/tilt.hpp"

#include <cctype>
#include <cstdio>
#include <string>

namespace plumb::commissioning {

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
    char text[160];
    std::snprintf(text, sizeof text, format, numbers...);
    return text;
}

inline std::string letters(Axis axis) {
    return std::string(1, letter(axis));
}

inline std::string arcsec(double angle) {
    return formatted("%.2f arcsec", arcsec_from_angle(angle));
}

inline std::string lower_case(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace plumb::commissioning
