// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/axis_chain.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <string>

namespace plumb {
namespace {

std::string letters(const AxisBranch& branch) {
    std::string result;
    for (const Axis axis : branch) result += letter(axis);
    return result;
}

struct Sides {
    std::string work, tool;  // from the bed outwards
};

Sides sides(const std::string& text) {
    const AxisChain chain = AxisChainReader::read(text);
    return {letters(chain.work), letters(chain.tool)};
}

TEST(AxisChain, WorkStandsBeforeTheBedToolBehindIt) {
    const Sides column = sides("w-Z.b-X-Y-C-t");
    EXPECT_EQ(column.work, "Z");
    EXPECT_EQ(column.tool, "XY");
    const Sides portal = sides("w-X.b-W-Y-Z-C-t");
    EXPECT_EQ(portal.work, "X");
    EXPECT_EQ(portal.tool, "WYZ");
}

TEST(AxisChain, WorkSideIsReadFromTheBedOutwards) {
    const Sides knee = sides("w-X-Y-Z.b-C-t");
    EXPECT_EQ(knee.work, "ZYX");
    EXPECT_EQ(knee.tool, "");
}

TEST(AxisChain, AllAxesMayCarryTheTool) {
    for (const char* text : {"w.b-X-W-Y-Z-C-t", "w-b-X-W-Y-Z-t"}) {
        EXPECT_EQ(sides(text).work, "");
        EXPECT_EQ(sides(text).tool, "XWYZ");
    }
}

TEST(AxisChain, SpindleMovesNothingAndMayCarryTheWork) {
    EXPECT_EQ(sides("w-C.b-Z-X-Y-t").tool, "ZXY");
    EXPECT_EQ(sides("w-C.b-Z-X-Y-t").work, "");
}

TEST(AxisChain, AxesThatAToolSideLeavesOutCarryTheWork) {
    EXPECT_EQ(sides("b-X-Y-C-t").work, "Z");
    EXPECT_EQ(sides("b-X-Y-C-t").tool, "XY");
    EXPECT_EQ(sides("b-V-Z-t").work, "XY");
    EXPECT_EQ(sides("b-t").work, "XYZ");
}

TEST(AxisChain, RefusalNamesTextPlaceAndReason) {
    const auto message = [](const std::string& text, const std::string& at, const std::string& reason) {
        return "chain \"" + text + "\", character " + at + ": " + reason;
    };
    const struct {
        const char *text, *at, *reason;
    } cases[] = {
        {"", "1", "it is empty; a chain is for instance w-Z.b-X-Y-C-t"},
        {"X-Y-t", "1", "a chain begins with w, the work, or b, the bed, not with \"X\""},
        {"w-Z.b-X-Q-C-t", "9", "expected one of X Y Z U V W C, not \"Q\""},
        {"w-Z.b-X-y-C-t", "9", "expected one of X Y Z U V W C, not \"y\""},
        {"w-Z.b-X-", "9", "expected one of X Y Z U V W C, not the end"},
        {"w-Z.b-X-Y-X-t", "11", "\"X\" is named twice"},
        {"w-Z.b-X-Z-Y-t", "9", "\"Z\" is named twice"},
        {"w-C.b-X-C-t", "9", "\"C\" is named twice"},
        {"w-U.b-X-W-Y-Z-t", "9",
         "\"W\" is too many: only one of U, V and W is possible, and U is named already"},
        {"w-Z.X-Y-t", "5", "after . comes b, the bed, not \"X\""},
        {"w-Z.", "5", "after . comes b, the bed, not the end"},
        {"w-Z", "4", "expected -, not the end"},
        {"wZ.b-X-Y-t", "2", "expected -, not \"Z\""},
        {"w-Z.b-XY-t", "8", "expected -, not \"Y\""},
        {"w-Z.b-X-Y", "10", "expected -, not the end"},
        {"b-X-Y-t ", "8", "after t, the tool, comes nothing, not \" \""},
        {"w-Z.b-X-t", "10", "axis Y is missing"},
        {"w-X.b-W-Y-t", "12", "axis Z is missing"},
    };
    for (const auto& c : cases)
        EXPECT_EQ(refusal([&] { AxisChainReader::read(c.text); }), message(c.text, c.at, c.reason));
}

}  // namespace
}  // namespace plumb
