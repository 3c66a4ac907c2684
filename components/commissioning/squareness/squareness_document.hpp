// SPDX-License-Identifier: GPL-2.0-or-later
// A machine with all its leans and measurements, as JSON: read from a document, and written with the results.
#pragma once

#include "components/commissioning/squareness/squareness_advice.hpp"
#include "components/commissioning/squareness/squareness_arguments.hpp"
#include "components/commissioning/squareness/squareness_state.hpp"

#include <string>
#include <string_view>

namespace plumb::commissioning {

// Reads a document, or the "input" of an output. Throws std::runtime_error with the place and the reason.
SquarenessOptions read_squareness_document(std::string_view text);

// `machine` has the measurements.
std::string squareness_document(const SquarenessOptions& options, const TiltedMachine& machine,
                                const SquarenessAdvice& advice);

}  // namespace plumb::commissioning
