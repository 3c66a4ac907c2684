// SPDX-License-Identifier: GPL-2.0-or-later
// The JSON document of `plumb squareness --input`, and the output that is made of it.
#include "tests/readers/reader.hpp"

#include "components/commissioning/squareness/squareness_document.hpp"

#include <cmath>
#include <stdexcept>

namespace plumb::readers {
namespace {

using namespace commissioning;

// The output, or nothing if no machine can be so. Points stand in files, which are not read here.
std::string output_of(const SquarenessOptions& options) {
    TiltedMachine machine = options.machine;
    for (const auto& measured : options.measured) {
        demand(std::isfinite(measured.corner.opening), "a measured angle is a number");
        machine.measured.push_back(measured.corner);
    }
    std::string output;
    takes<std::invalid_argument>([&] {
        const SquarenessAdvice advice = advice_on(machine);
        for (const LeanState& lean : state_of(machine, advice).leans)
            if (lean.settled) demand(std::abs(lean.settled->angle) < 0.1, "a settled angle is small");
        output = squareness_document(options, machine, advice);
    });
    return output;
}

void read(std::string_view bytes) {
    SquarenessOptions options;
    if (!takes<std::runtime_error>([&] { options = read_squareness_document(bytes); })) return;
    const std::string output = output_of(options);
    if (output.empty()) return;
    demand(output_of(read_squareness_document(output)) == output, "an output gives itself");
}

const Reader reader{"squareness_document", read};

}  // namespace
}  // namespace plumb::readers
