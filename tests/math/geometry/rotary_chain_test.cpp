// SPDX-License-Identifier: GPL-2.0-or-later
// Chains with rotary axes anywhere, with place errors, tilts and error motions, against a product of poses.
#include "components/math/geometry/tip_correction.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Body {
    char axis = 0;
    bool work = false;
    Vector3d tilt, translation, translation_slope, angles, angles_slope;
    Vector3d point = Vector3d::Zero(), place = Vector3d::Zero();  // of a rotary axis

    bool turns() const { return axis <= 'C'; }
    Axis named() const { return static_cast<Axis>(std::string("XYZUVWABC").find(axis)); }
    Vector3d along() const { return Vector3d::Unit(turns() ? axis - 'A' : (axis - 'U') % 3); }

    static Isometry3d move(const Vector3d& by) { return Isometry3d(Eigen::Translation3d(by)); }
    static Isometry3d turn(const Vector3d& by) {
        return Isometry3d(Eigen::AngleAxisd(by.z(), Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(by.y(), Vector3d::UnitY()) *
                          Eigen::AngleAxisd(by.x(), Vector3d::UnitX()));
    }
    // `q` in mm or deg; `errors` 0: of an ideal machine.
    Isometry3d pose(double q, double errors) const {
        const double sign = work ? -1 : 1;
        const Vector3d moved = errors * sign * (translation + translation_slope * q);
        Vector3d turned = errors * (angles + angles_slope * q);
        if (!turns()) return turn(errors * tilt) * move(sign * q * along() + moved) * turn(turned);
        if (work) turned -= 2 * turned.dot(along()) * along();  // the angle about itself goes with q
        return move(point + errors * place) * turn(errors * tilt) * move(moved) * turn(turned) *
               Isometry3d(Eigen::AngleAxisd(sign * q * std::acos(-1.0) / 180, along())) * move(-point);
    }
};

struct Machine {
    std::vector<Body> bodies;  // of each side from the bed outwards

    explicit Machine(std::mt19937& random) {
        std::string axes = "XYZ";
        if (random() % 2) axes += "UVW"[random() % 3];
        std::string rotary = "ABC";
        std::shuffle(rotary.begin(), rotary.end(), random);
        axes += rotary.substr(0, 1 + random() % 3);
        std::shuffle(axes.begin(), axes.end(), random);
        std::uniform_real_distribution<double> any(-1, 1);
        const auto vec = [&](double size) {
            return Vector3d(Vector3d(any(random), any(random), any(random)) * size);
        };
        for (const char axis : axes) {
            Body body{axis, random() % 2 == 0, vec(1e-3), vec(0.02), vec(2e-5), vec(1e-4), vec(1e-7)};
            if (body.turns()) body.point = vec(300), body.place = vec(0.05);
            bodies.push_back(body);
        }
    }
    std::string text() const {
        std::string work, tool;
        for (const Body& body : bodies)
            if (body.work)
                work = std::string("-") + body.axis + work;
            else
                tool += std::string("-") + body.axis;
        return "w" + work + ".b" + tool + "-t";
    }
    std::string rotary() const {
        std::string result;
        for (const Body& body : bodies)
            if (body.turns()) result += body.axis;
        return result;
    }
    Vector3d tip(const AxisPosition& q, const Vector3d& angles, const Vector3d& tool, double errors) const {
        Isometry3d work = Isometry3d::Identity(), head = Isometry3d::Identity();
        for (const Body& body : bodies) {
            const double at = body.turns() ? angles[body.axis - 'A'] : q[coordinate(body.named())];
            (body.work ? work : head) = (body.work ? work : head) * body.pose(at, errors);
        }
        return work.inverse() * (head * tool);
    }
    TipCorrection correction(const Vector3d& angles) const {
        KinematicChain::Settings s;
        s.axes = AxisChainReader::read(text(), rotary());
        for (const Body& body : bodies)
            if (body.turns())
                s.places[static_cast<std::size_t>(body.axis - 'A')] = {body.point, body.place, body.tilt};
            else
                s.tilts[static_cast<std::size_t>(coordinate(body.named()))].angles = body.tilt;
        KinematicChain chain(s);
        for (const Body& body : bodies) {
            chain.set_error(
                body.named(),
                {0, {body.translation, body.angles}, {body.translation_slope, body.angles_slope}});
            if (body.turns()) chain.set_angle(body.named(), angles[body.axis - 'A']);
        }
        return TipCorrection(chain);
    }
};

TEST(RotaryChain, TipsAreThoseOfAProductOfPosesAndAreCorrectedToNothing) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-400, 400), angle(-180, 180);
    std::set<std::string> orders;
    double worst = 0, ideal = 0, corrected = 0, back = 0, slope = 0;
    int slopes = 0;
    for (int n = 0; n < 1000; ++n) {
        const Machine machine(random);
        orders.insert(machine.text());
        const Vector3d angles(angle(random), angle(random), angle(random)),
            tool(place(random) / 10, place(random) / 10, -300);
        const AxisPosition q(place(random), place(random), place(random), place(random));
        const TipCorrection correction = machine.correction(angles);
        worst =
            std::max(worst, (correction.chain().tip(q, tool).place - machine.tip(q, angles, tool, 1)).norm());
        ideal =
            std::max(ideal, (correction.chain().ideal_tip(q, tool) - machine.tip(q, angles, tool, 0)).norm());
        Vector3d c = Vector3d::Zero();
        for (int step = 0; step < 3; ++step) c = correction.at(q, tool, c).offset;
        const AxisPosition there = TipCorrection::corrected(q, c);
        corrected = std::max(corrected,
                             (machine.tip(there, angles, tool, 1) - machine.tip(q, angles, tool, 0)).norm());
        back = std::max(back, (correction.un_corrected(there, tool) - q).norm());
        const RotarySlopes by_rotary = correction.at(q, tool, c).by_rotary;
        for (const char axis : machine.rotary()) {
            // A rotary axis between linear ones can turn two of them parallel.
            if (std::abs(correction.chain().ideal(q, tool).slopes.leftCols<3>().determinant()) < 0.5)
                continue;
            ++slopes;
            const auto at = [&](double step) {
                const TipCorrection moved = machine.correction(angles + step * Vector3d::Unit(axis - 'A'));
                Vector3d its = c;
                for (int k = 0; k < 3; ++k) its = moved.at(q, tool, its).offset;
                return its;
            };
            slope = std::max(slope, ((at(0.01) - at(-0.01)) / 0.02 - by_rotary.col(axis - 'A')).norm());
        }
    }
    EXPECT_GT(orders.size(), 900u);
    EXPECT_LT(worst, 1e-10);
    EXPECT_LT(ideal, 1e-10);
    EXPECT_LT(corrected, 1e-9);
    EXPECT_LT(back, 1e-9);
    EXPECT_GT(slopes, 1000);
    EXPECT_LT(slope, 1e-7);  // mm/deg, of up to 0.05
}

TEST(RotaryChain, AChainSaysWhatItsRotaryAxesAre) {
    const AxisChain chain = AxisChainReader::read("w-C-A-Y.b-X-Z-t", "AC");
    EXPECT_TRUE(chain.has(Axis::A));
    EXPECT_TRUE(chain.work.has(Axis::C));
    EXPECT_EQ(chain.work.members.axes[0], Axis::Y) << "from the bed outwards";
    EXPECT_EQ(chain.work.size, 1) << "linear axes";
    EXPECT_FALSE(AxisChainReader::read("w-X.b-Y-Z-C-t").has(Axis::C)) << "a spindle moves nothing";
    const auto reason = [](const std::string& text, const std::string& rotary) -> std::string {
        try {
            AxisChainReader::read(text, rotary);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(reason("w-A-X.b-Y-Z-t", "").find("rotary does not name"), std::string::npos);
    EXPECT_NE(reason("w-X.b-Y-Z-t", "C").find("C is missing"), std::string::npos);
    EXPECT_NE(reason("w-C-C-X.b-Y-Z-t", "C").find("named twice"), std::string::npos);
    for (const char* wrong : {"D", "AA", "A,", "A,C", "ac", "A C"})
        EXPECT_NE(reason("w-A-C-X.b-Y-Z-t", wrong).find("each at most once"), std::string::npos) << wrong;
}

}  // namespace
}  // namespace plumb
