// SPDX-License-Identifier: GPL-2.0-or-later
// Lines of the list of errors that a class of machine, a sheet or a thermometer states, and their part of U.
#pragma once

#include <string>
#include <vector>

#include "components/commissioning/volume/volume_of.hpp"

namespace plumb::commissioning {

// States the lines of the corners by the tilts in force: `given` are those with a value.
struct GivenTilt {
    UncertaintySource::Angle angle;
    std::string name, by;
};
void state_corners(const std::vector<GivenTilt>& given, VolumeQuestion& q);

// States growth and bending by temperatures, and each line that is still unknown by the sources in their
// order: "iso-10791", or a file of lines "error,u,source". Then adds the causes of U of all lines but the
// measured ones. `now` is none if the temperature is not known. Throws std::runtime_error with file, line and
// value.
void assume(const std::vector<std::string>& sources, std::optional<double> now, VolumeQuestion& q);

}  // namespace plumb::commissioning
