// SPDX-License-Identifier: GPL-2.0-or-later
// The text of a machine's chain of axes.
#include "tests/readers/reader.hpp"

#include "components/math/geometry/axis_chain.hpp"

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    AxisChain chain;
    if (!takes<std::invalid_argument>([&] { chain = AxisChainReader::read(std::string(bytes)); })) return;
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z}) demand(chain.has(axis), "a chain has X, Y and Z");
    const int size = chain.work.size + chain.tool.size;
    demand(size == 3 || size == 4, "a chain has three axes or four");
    int count = 0;
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
        count += chain.has(axis) ? 1 : 0;
    demand(count == size, "a chain has no axis twice");
}

const Reader reader{"chain", read};

}  // namespace
}  // namespace plumb::readers
