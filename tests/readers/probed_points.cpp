// SPDX-License-Identifier: GPL-2.0-or-later
// Probed points of `plumb squareness --points`, and the corner that is made of them.
#include "tests/readers/reader.hpp"

#include "components/io/files/probed_points_file.hpp"

#include <cmath>
#include <stdexcept>

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    const bool inch = !bytes.empty() && bytes.front() == 'i';
    ProbedPointsFile file;
    if (!takes<std::runtime_error>([&] {
            file = probed_points_file::Reader::read("points.csv", bytes.substr(bytes.empty() ? 0 : 1),
                                                    inch ? 25.4 : 1);
        }))
        return;
    demand(!file.shape.points.empty() && file.shape.points.size() == file.lines.size(),
           "each point has its line");
    demand(!parallel(file.shape.a, file.shape.b), "the axes span a plane");
    for (const auto& point : file.shape.points)
        demand(point.place.allFinite() && std::isfinite(point.normal) && std::isfinite(point.turned),
               "a point that is taken has numbers");
    file.shape.uncertainty = 0.002;
    ProbedCorner found;
    if (!takes<std::invalid_argument>([&] { found = corner_from_shape(file.shape); })) return;
    demand(std::isfinite(found.corner.opening) && std::isfinite(found.corner.uncertainty),
           "a corner has numbers");
    demand(found.corner.uncertainty > 0, "a corner has an uncertainty");
    demand(found.worst < file.lines.size(), "the point that lies furthest off is one of the file");
}

const Reader reader{"probed_points", read};

}  // namespace
}  // namespace plumb::readers
