// SPDX-License-Identifier: GPL-2.0-or-later
// The unit of length of a machine, as [TRAJ]LINEAR_UNITS has it:
//
//     hal::LengthUnit unit{this};
//
// gives a component the option unit=. Defaults are declared in millimetres; those of pins whose unit begins
// with mu are converted when the pin is made.
#pragma once

#include "hal/registrar.hpp"

#include <strings.h>

#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>

namespace plumb::hal {

constexpr const char* length_option = "unit";

// Millimetres in a unit, by all spellings that LinuxCNC accepts for [TRAJ]LINEAR_UNITS; a number is that of
// units in a millimetre. Nothing for any other text.
inline std::optional<double> millimetres_of(const std::string& unit) {
    for (const char* metric : {"mm", "metric"})
        if (strcasecmp(unit.c_str(), metric) == 0) return 1;
    for (const char* imperial : {"in", "inch", "imperial"})
        if (strcasecmp(unit.c_str(), imperial) == 0) return 25.4;
    char* end = nullptr;
    const double units = std::strtod(unit.c_str(), &end);
    if (unit.empty() || *end != '\0' || !(units >= 1e-3 && units <= 1e3)) return std::nullopt;
    return 1 / units;
}

// Likewise, of a unit= in a loadrt line; throws.
inline double millimetres_of_option(const std::string& unit) {
    if (const auto millimetres = millimetres_of(unit)) return *millimetres;
    throw std::invalid_argument("unit=" + unit +
                                ": give mm, metric, in, inch, imperial, or the number of machine units in a "
                                "millimetre (0.001 to 1000)");
}

// Whether a pin's unit is a length, or a length divided by something.
inline bool is_length(const std::string& unit) {
    return unit == "mu" || unit.compare(0, 3, "mu/") == 0;
}

// The unit in which a pin's default is declared and shown.
inline std::string default_unit(const std::string& unit) {
    return is_length(unit) ? "mm" + unit.substr(2) : unit;
}

class LengthUnit {
public:
    explicit LengthUnit(Component* owner)
        : millimetres_(millimetres_of_option(registrar(owner).add(OptionInfo{
              length_option, "mm",
              "Machine unit of length: mm or inch, or as [TRAJ]LINEAR_UNITS has it. A unit that differs from LinuxCNC's INI file is refused."}))) {}
    LengthUnit(const LengthUnit&) = delete;
    LengthUnit& operator=(const LengthUnit&) = delete;

    double millimetres() const noexcept { return millimetres_; }  // in a machine unit

private:
    const double millimetres_;
};

}  // namespace plumb::hal
