// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/kinematic_chain.hpp"
#include "tests/support/chain.hpp"
#include "tests/support/near.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double um = 1e-3;        // mm
constexpr double urad = 1e-6;      // rad
constexpr double rounding = 1e-9;  // mm

const std::size_t x = 0, y = 1, z = 2, w = 3;  // in a position

Vector3d error(const KinematicChain& machine, const AxisPosition& q, const Vector3d& tool) {
    return machine.tip(q, tool).place - machine.ideal_tip(q, tool);
}

Matrix3d turned(double ea, double eb, double ec) {
    return (AngleAxisd(ec, Vector3d::UnitZ()) * AngleAxisd(eb, Vector3d::UnitY()) *
            AngleAxisd(ea, Vector3d::UnitX()))
        .toRotationMatrix();
}

TEST(KinematicChain, ColumnThatIsMeasuredBySquareAndIndicator) {
    auto settings = chain("w-Z.b-X-Y-C-t");
    settings.tilts[y].angles = {60 * urad, 0, -80 * urad};
    const KinematicChain column(settings);
    expect_near(error(column, {300, 800, 150, 0}, {0, 25, 250}), Vector3d(65.999, -15.004, 49.4995) * um,
                0.001 * um);
}

TEST(KinematicChain, SmallTiltsOfAColumnGiveTheFirstOrder) {
    const double ea = 3 * urad, ec = -2 * urad;
    auto settings = chain("b-X-Y-C-t");
    settings.tilts[y].angles = {ea, 0, ec};
    const Vector3d t(30, -25, -250);
    const double at = 700;
    expect_near(error(KinematicChain(settings), {100, at, -40, 0}, t),
                {-ec * (at + t.y()), ec * t.x() - ea * t.z(), ea * (at + t.y())}, 1e-5 * um);
}

TEST(KinematicChain, IdealMachineHasNoError) {
    for (const char* text : {"w-Z.b-X-Y-C-t", "w-X.b-W-Y-Z-C-t", "w-X-Y-Z.b-t", "w.b-Y-V-Z-X-t"}) {
        const KinematicChain machine(chain(text));
        expect_near(error(machine, {123, -45, 67, 8}, {1, 2, -300}), Vector3d::Zero(), rounding);
    }
}

TEST(KinematicChain, PivotLeavesTheToolPartAlone) {
    auto settings = chain("w-X.b-W-Y-Z-C-t");
    settings.tilts[w].angles = {50 * urad, 30 * urad, 0};
    settings.tilts[z].angles = {-20 * urad, 70 * urad, 0};
    const KinematicChain portal(settings);
    const Vector3d tool(10, 0, -250);
    expect_near(error(portal, AxisPosition::Zero(), Vector3d::Zero()), Vector3d::Zero(), rounding);
    expect_near(error(portal, AxisPosition::Zero(), tool), portal.tool_displacement(tool), rounding);
    expect_near(
        error(portal, AxisPosition::Zero(), tool),
        (turned(50 * urad, 30 * urad, 0) * turned(-20 * urad, 70 * urad, 0) - Matrix3d::Identity()) * tool,
        rounding);
}

TEST(KinematicChain, ToolThatWasSetUpSquareDoesNotTurn) {
    auto settings = chain("w-Z.b-X-Y-C-t");
    settings.tilts[y].angles = {60 * urad, 0, -80 * urad};
    settings.tilts[y].end_follows = false;
    const KinematicChain column(settings);
    const AxisPosition q(300, 800, 150, 0);
    expect_near(error(column, q, {0, 25, 250}), error(column, q, Vector3d::Zero()), rounding);
    expect_near(column.tool_displacement({0, 25, 250}), Vector3d::Zero(), rounding);
}

TEST(KinematicChain, SaddleStaysLevelInTheAxisDirectionReading) {
    const double ea = 40 * urad;
    auto settings = chain("w-X.b-W-Y-Z-C-t");
    settings.tilts[w].angles = {ea, 0, 0};
    const Vector3d tool(0, 0, -200);
    const AxisPosition q(0, 600, -100, 300);
    const Vector3d component = error(KinematicChain(settings), q, tool);
    settings.reading = TiltReading::axis_direction;
    const Vector3d direction = error(KinematicChain(settings), q, tool);
    EXPECT_NEAR((component - direction).z(), 600 * std::sin(ea), 1e-4 * um);
    EXPECT_NEAR(direction.y(), -std::sin(ea) * (300 - 100 - 200), 1e-4 * um);
}

TEST(KinematicChain, TiltAgainstTheBedReplacesThatOfTheRail) {
    auto settings = chain("w-X.b-W-Y-Z-C-t");
    settings.tilts[w].angles = {40 * urad, 0, 0};
    settings.tilts[z].angles = {40 * urad, 0, 0};
    const AxisPosition q(0, 0, -300, 0);
    EXPECT_NEAR(error(KinematicChain(settings), q, Vector3d::Zero()).y(), 24 * um, 1e-4 * um);
    settings.datum = TiltDatum::bed;
    EXPECT_NEAR(error(KinematicChain(settings), q, Vector3d::Zero()).y(), 12 * um, 1e-4 * um);
}

// The knee of a mill: the guide of Z leans towards +X, and the work goes down along it as z grows.
TEST(KinematicChain, WorkOnATiltedAxisMovesAwayFromTheTip) {
    const Vector3d tool(5, 6, -70);
    const AxisPosition q(11, -22, 330, 0);
    const Matrix3d r = turned(20 * urad, 50 * urad, -10 * urad);
    auto settings = chain("w-Z.b-X-Y-C-t");
    settings.tilts[z].angles = {20 * urad, 50 * urad, -10 * urad};
    expect_near(KinematicChain(settings).tip(q, tool).place,
                r.transpose() * (r * Vector3d(0, 0, 330) + Vector3d(11, -22, 0) + tool), rounding);

    settings.tilts[z].end_follows = false;
    expect_near(KinematicChain(settings).tip(q, tool).place,
                r * Vector3d(0, 0, 330) + Vector3d(11, -22, 0) + tool, rounding);
}

TEST(KinematicChain, ATableOnASaddleIsTheInverseOfItsTransforms) {
    const Vector3d tool(5, 6, -70);
    const AxisPosition q(250, -130, 330, 0);
    const Vector3d ax(0, 25 * urad, 55 * urad), ay(-35 * urad, 0, 45 * urad);
    auto settings = chain("w-X-Y.b-Z-C-t");
    settings.tilts[x].angles = ax;
    settings.tilts[y].angles = ay;
    Eigen::Affine3d table(turned(ay[0], ay[1], ay[2]));
    table.translate(Vector3d(0, 130, 0)).rotate(turned(ax[0], ax[1], ax[2])).translate(Vector3d(-250, 0, 0));
    expect_near(KinematicChain(settings).tip(q, tool).place, table.inverse() * (Vector3d(0, 0, 330) + tool),
                rounding);
}

// A rigid-body error as of a table, with slopes, on each axis of a chain.
AxisError odd_error(double seed) {
    AxisError e;
    e.position = 100 * seed;
    e.value = {Vector3d(7, -5, 3) * seed * um, Vector3d(20, -30, 40) * seed * urad};
    e.slope = {Vector3d(20, 30, -10) * seed * urad, Vector3d(0.05, -0.07, 0.02) * seed * urad};
    return e;
}

TEST(KinematicChain, ErrorsAreTranslationAndThenRotationOfAllBehind) {
    const Vector3d tool(5, 6, -70);
    const AxisPosition q(250, -130, 330, 0);
    KinematicChain machine(chain("w-Z.b-X-Y-C-t"));
    Eigen::Affine3d side[3];
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z}) {
        const int i = coordinate(axis);
        const AxisError e = odd_error(1.5 - i);
        machine.set_error(axis, e);
        const RigidBodyError at = e.at(q[i]);
        Vector3d travel = q[i] * Vector3d::Unit(i) + at.translation;
        if (axis == Axis::Z) travel = -travel;
        side[i] = Eigen::Translation3d(travel) * turned(at.angles[0], at.angles[1], at.angles[2]);
    }
    expect_near(machine.tip(q, tool).place, side[z].inverse() * (side[x] * (side[y] * tool)), rounding);
}

TEST(KinematicChain, TiltIsTheSimplestTableOfErrors) {
    const Vector3d angles(30 * urad, -20 * urad, 50 * urad), tool(10, 20, -150);
    const AxisPosition q(250, -130, 330, 60);
    for (const char* text : {"w-Z.b-X-Y-C-t", "w-X.b-W-Y-Z-C-t", "w-Z-X-Y-W.b-t"}) {
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z}) {
            auto settings = chain(text);
            KinematicChain by_error(settings);
            AxisError e;
            e.value.angles = angles;
            e.slope.translation = (turned(angles[0], angles[1], angles[2]) - Matrix3d::Identity()) *
                                  Vector3d::Unit(direction(axis));
            by_error.set_error(axis, e);
            settings.tilts[static_cast<std::size_t>(coordinate(axis))].angles = angles;
            const KinematicChain by_tilt(settings);
            expect_near(by_error.tip(q, tool).place, by_tilt.tip(q, tool).place, rounding);
        }
    }
}

TEST(KinematicChain, SlopesAreThoseOfTheTip) {
    for (const TiltReading reading : {TiltReading::component, TiltReading::axis_direction}) {
        for (const char* text : {"w-Z.b-X-Y-C-t", "w-X.b-W-Y-Z-C-t", "w-X-Y-Z-W.b-t", "w-Z-W.b-X-Y-t"}) {
            auto settings = chain(text);
            settings.reading = reading;
            for (AxisTilt& tilt : settings.tilts) tilt.angles = Vector3d(400, -300, 500) * urad;
            KinematicChain machine(settings);
            for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::W})
                machine.set_error(axis, odd_error(3.5 - coordinate(axis)));
            const Vector3d tool(10, 20, -150);
            const AxisPosition q(250, -130, 330, 60);
            const PositionSlopes slopes = machine.tip(q, tool).slopes;
            for (int i = 0; i < 4; ++i) {
                const AxisPosition step = 0.5 * AxisPosition::Unit(i);
                const Vector3d difference =
                    machine.tip(q + step, tool).place - machine.tip(q - step, tool).place;
                expect_near(slopes.col(i), difference, 1e-11);
            }
        }
    }
}

}  // namespace
}  // namespace plumb
