// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/machine_drawing.hpp"
#include "components/commissioning/squareness/machine_layout.hpp"

#include <gmock/gmock.h>

#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb::commissioning {
namespace {

const char* const chains[] = {"w-X-Y.b-Z-C-t",   "w-Y-X.b-Z-C-t",   "w-Z-X.b-Y-C-t", "w-X.b-Y-Z-C-t",
                              "w-Y.b-X-Z-C-t",   "w.b-X-Y-Z-C-t",   "w-Z.b-X-Y-C-t", "w-X-Y-Z.b-C-t",
                              "w-X.b-W-Y-Z-C-t", "w-X.b-Y-Z-W-C-t", "w-X.b-U-Y-Z-t", "w-V-Y.b-X-Z-t"};

// All ways in which right-handed axes may point.
std::vector<ViewDirections> all_directions() {
    std::vector<ViewDirections> all;
    for (const std::string x : {"right", "left", "back", "front", "up", "down"})
        for (const std::string y : {"right", "left", "back", "front", "up", "down"}) {
            try {
                all.emplace_back("X=" + x + ",Y=" + y);
            } catch (const std::invalid_argument&) {
            }
        }
    return all;
}

TEST(MachineDrawing, EachAxisHasOnePartAndNoPartsReachIntoEachOther) {
    ASSERT_EQ(all_directions().size(), 24u);
    for (const char* const text : chains) {
        const AxisChain chain = AxisChainReader::read(text);
        for (const ViewDirections& directions : all_directions())
            for (const MachineFrame frame : {MachineFrame::any, MachineFrame::column, MachineFrame::portal}) {
                const std::vector<MachinePart> parts = machine_parts(chain, directions, frame);
                const std::string which = std::string(text) + ' ' + directions.text() + ' ' + name_of(frame);
                for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W}) {
                    int names = 0;
                    for (const MachinePart& part : parts) names += part.carries_name && part.axis == axis;
                    EXPECT_EQ(names, chain.has(axis) ? 1 : 0) << which << ' ' << letter(axis);
                }
                for (std::size_t i = 0; i < parts.size(); ++i) {
                    EXPECT_TRUE(((parts[i].high - parts[i].low).array() > 0.01).all()) << which;
                    for (std::size_t k = 0; k < i; ++k) {
                        const Eigen::Vector3d low = parts[i].low.cwiseMax(parts[k].low);
                        const Eigen::Vector3d high = parts[i].high.cwiseMin(parts[k].high);
                        EXPECT_FALSE(((high - low).array() > 0.01).all())
                            << which << ": parts " << k << " and " << i;
                    }
                }
            }
    }
}

// Where the name of an axis stands, from the left and from the top.
std::pair<double, double> place(const std::string& svg, const std::string& name) {
    std::smatch found;
    const std::regex text("<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"[^>]*>\\" + name + "<");
    if (!std::regex_search(svg, found, text)) throw std::runtime_error("no " + name);
    return {std::stod(found[1]), std::stod(found[2])};
}

TEST(MachineDrawing, AxesPointWhereTheUserSaysTheyDo) {
    MachineDrawing drawing{"w-X-Y.b-Z-C-t", AxisChainReader::read("w-X-Y.b-Z-C-t"), {}, {}, {}};
    const double right = place(drawing.svg(), "+X").first, above = place(drawing.svg(), "+Z").second;
    drawing.directions = ViewDirections("X=left,Z=up");
    EXPECT_LT(place(drawing.svg(), "+X").first, right - 100);
    drawing.directions = ViewDirections("X=right,Z=down");
    EXPECT_GT(place(drawing.svg(), "+Z").second, above + 100);
}

TEST(MachineDrawing, LeansAreArrowsAndSentences) {
    MachineDrawing drawing{
        "w-Z.b-X-Y-C-t", AxisChainReader::read("w-Z.b-X-Y-C-t"), ViewDirections("X=left,Y=up"), {}, {}};
    EXPECT_THAT(drawing.svg(), testing::Not(testing::HasSubstr("dasharray")));
    drawing.leans = {{Axis::Y, 2, -8e-5, {}}, {Axis::Y, 0, 6e-5, {}}, {Axis::X, 2, 0, {}}};
    EXPECT_THAT(drawing.svg(), testing::HasSubstr(">Y leans to +X, +Z<"));
    EXPECT_THAT(drawing.svg(), testing::HasSubstr("dasharray"));
    EXPECT_THAT(drawing.svg(), testing::Not(testing::HasSubstr("X leans")));
    EXPECT_THAT(drawing.svg(), testing::HasSubstr(">+ ends: X left, Y up, Z back<"));
}

}  // namespace
}  // namespace plumb::commissioning
