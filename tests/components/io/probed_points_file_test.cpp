// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/files/probed_points_file.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace plumb {
namespace {

ProbedPointsFile read(const std::string& text, double unit = 1) {
    return probed_points_file::Reader::read("/a.csv", text, unit);
}

std::string refusal(const std::string& text) {
    return plumb::refusal<std::runtime_error>([&] { read(text); });
}

TEST(ProbedPointsFile, ColumnsAreKnownByTheirNames) {
    const ProbedPointsFile file =
        read("\xef\xbb\xbf# square\r\n\r\nturned,Z,normal,X\r\n# first\n 90 , 1.5 , -180 , +2e1\n0,3,0,4");
    EXPECT_EQ(file.shape.a, Axis::X);
    EXPECT_EQ(file.shape.b, Axis::Z);
    EXPECT_FALSE(file.shape.ring);
    ASSERT_EQ(file.shape.points.size(), 2u);
    EXPECT_EQ(file.shape.points[0].place, Eigen::Vector2d(20, 1.5));
    EXPECT_NEAR(file.shape.points[0].turned, std::acos(-1) / 2, 1e-15);
    EXPECT_NEAR(file.shape.points[0].normal, -std::acos(-1), 1e-15);
    EXPECT_EQ(file.shape.points[1].place, Eigen::Vector2d(4, 3));
    EXPECT_EQ(file.lines, (std::vector<std::size_t>{5, 6}));
}

TEST(ProbedPointsFile, WithoutNormalsItIsARing) {
    const ProbedPointsFile file = read("Y,W\n1,2\n", 25.4);
    EXPECT_TRUE(file.shape.ring);
    EXPECT_EQ(file.shape.points[0].place, Eigen::Vector2d(25.4, 50.8));
}

TEST(ProbedPointsFile, UnitsAndDecimalCommasAreRead) {
    const ProbedPointsFile file = read("x (in);Y [mm];Normal\n1,5;-2,5;90\n", 25.4);
    EXPECT_TRUE(file.shape.points[0].place.isApprox(Eigen::Vector2d(38.1, -2.5), 1e-12));
    EXPECT_FALSE(file.shape.ring);
}

TEST(ProbedPointsFile, RefusalNamesFileLineReasonAndValue) {
    const std::pair<std::string, std::string> cases[] = {
        {"", "/a.csv: there are no rows in it"},
        {"X,Y\n", "/a.csv: there are no rows in it"},
        {"1,2\n", "/a.csv: line 1: the first line has to name the columns, and is a row"},
        {"X,Y,Normal 1\n1,2,3\n",
         "/a.csv: line 1: 'Normal 1' is no column: there are the two axes of the plane, normal and turned"},
        {"X,normal\n1,2\n", "/a.csv: line 1: 1 axes are named: there must be two, those of the plane"},
        {"X,Y,Z\n1,2,3\n", "/a.csv: line 1: 3 axes are named: there must be two, those of the plane"},
        {"X,X\n1,2\n", "/a.csv: line 1: column 'X' is there twice"},
        {"X,Y,y\n1,2,3\n", "/a.csv: line 1: 3 axes are named: there must be two, those of the plane"},
        {"Z,W\n1,2\n", "/a.csv: line 1: Z and W are parallel and span no plane"},
        {"X (s),Y\n1,2\n", "/a.csv: line 1: 'X (s)' has no unit of a length"},
        {"X,Y\n1,2\n1\n3,4\n", "/a.csv: line 3: 1 value, but line 1 has 2 heads"},
        {"X,Y\n1,2\n1,2,3\n",
         "/a.csv: line 3: 3 values, but line 1 has 2 heads; is the comma a decimal mark? Then "
         "separate by semicolons"},
        {"X,Y\n\n1,\n", "/a.csv: line 3: column Y: there is no value"},
        {"Y,X\n1,1\n1,2 mm\n", "/a.csv: line 3: column X: '2 mm' is no number"},
        {"X,Y\n1,nan\n", "/a.csv: line 2: column Y: there is no value"},
        {"X,Y\n1,1\n1,1e999\n", "/a.csv: line 3: column Y: '1e999' is no number"},
        {"X;Y\n1,5;2.5\n",
         "/a.csv: line 2: '1,5' has a comma and '2.5' a point: which one is the decimal mark?"},
        {"X,Y\n-2e5,0\n", "/a.csv: line 2: column X: '-2e5' is beyond 100000 mm"},
        {"X,Y,normal\n1,2,361\n", "/a.csv: line 2: column normal: '361' is beyond 360 deg"},
    };
    for (const auto& [text, reason] : cases) EXPECT_EQ(refusal(text), reason);
    std::string many = "X,Y\n";
    for (int i = 0; i < 4097; ++i) many += "1,2\n";
    EXPECT_EQ(refusal(many), "/a.csv: line 4098: more than 4096 points");
}

TEST(ProbedPointsFile, FileThatIsNotThereIsNamed) {
    try {
        read_probed_points("/nonexistent.csv", 1);
        ADD_FAILURE();
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string(error.what()), "/nonexistent.csv: No such file or directory");
    }
}

}  // namespace
}  // namespace plumb
