// SPDX-License-Identifier: GPL-2.0-or-later
// Chains in any order of X, Y, Z and an axis parallel to one of them, on both sides of the bed, with tilts
// and errors of all axes, against rigid bodies one behind the other.
#include "components/math/geometry/tip_correction.hpp"
#include "tests/support/rigid_machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct Guide {
    char axis;
    Vec tilt;
    Vec translation, translation_slope, angles, angles_slope;  // errors at 0, and their change per mm

    Vec direction() const {
        const int d = (axis - 'U') % 3;  // U V W X Y Z
        return {d == 0 ? 1.0 : 0, d == 1 ? 1.0 : 0, d == 2 ? 1.0 : 0};
    }
    Vec travel(double q) const { return direction() * q + translation + translation_slope * q; }
    Vec errors(double q) const { return angles + angles_slope * q; }
    // A vector behind the guide, as the carrier of the guide sees it; and back.
    Vec carry(double q, const Vec& v) const { return turned(tilt, travel(q) + turned(errors(q), v)); }
    Vec see(double q, const Vec& v) const { return turned_back(errors(q), turned_back(tilt, v) + travel(q)); }
};

struct Machine {
    std::vector<Guide> work, tool;  // from the bed outwards

    explicit Machine(std::mt19937& random) {
        std::string axes = "XYZ";
        if (random() % 4) axes += "UVW"[random() % 3];
        std::shuffle(axes.begin(), axes.end(), random);
        std::uniform_real_distribution<double> any(-1, 1);
        const auto vec = [&](double size) { return Vec{any(random), any(random), any(random)} * size; };
        for (const char axis : axes)
            (random() % 2 ? work : tool)
                .push_back({axis, vec(1e-3), vec(0.02), vec(2e-5), vec(1e-4), vec(1e-7)});
    }

    std::string text() const {
        std::string result = "w";
        for (auto guide = work.rbegin(); guide != work.rend(); ++guide) result += {'-', guide->axis};
        result += ".b";
        for (const Guide& guide : tool) result += {'-', guide.axis};
        return result + "-t";
    }
    static double of(const Guide& guide, const Position& q) {
        return q[guide.axis >= 'X' ? static_cast<std::size_t>(guide.axis - 'X') : 3];
    }
    Vec tip(const Position& q, const Vec& t) const {
        Vec v = t;
        for (auto guide = tool.rbegin(); guide != tool.rend(); ++guide) v = guide->carry(of(*guide, q), v);
        for (const Guide& guide : work) v = guide.see(of(guide, q), v);
        return v;
    }
    Vec ideal(const Position& q, const Vec& t) const {
        Vec v = t;
        for (const auto* side : {&work, &tool})
            for (const Guide& guide : *side) v = v + guide.direction() * of(guide, q);
        return v;
    }

    KinematicChain chain() const {
        const auto eigen = [](const Vec& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
        KinematicChain::Settings s;
        s.axes = AxisChainReader::read(text());
        const auto axis_of = [](const Guide& guide) {
            return static_cast<Axis>(std::string("XYZUVW").find(guide.axis));
        };
        for (const auto* side : {&work, &tool})
            for (const Guide& guide : *side)
                s.tilts[static_cast<std::size_t>(coordinate(axis_of(guide)))].angles = eigen(guide.tilt);
        KinematicChain result(s);
        for (const auto* side : {&work, &tool})
            for (const Guide& g : *side)
                result.set_error(axis_of(g), {0,
                                              {eigen(g.translation), eigen(g.angles)},
                                              {eigen(g.translation_slope), eigen(g.angles_slope)}});
        return result;
    }
};

TEST(RandomChain, TipsAreThoseOfRigidBodiesAndAreCorrectedToNothing) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(-500, 500);
    std::set<std::string> orders;
    double worst = 0, corrected = 0, back = 0;
    for (int n = 0; n < 2000; ++n) {
        const Machine machine(random);
        orders.insert(machine.text());
        const KinematicChain chain = machine.chain();
        const TipCorrection correction(chain);
        const AxisPosition q(place(random), place(random), place(random), place(random));
        const Position at{q[0], q[1], q[2], q[3]};
        const Vec tool{place(random) / 10, place(random) / 10, -300};
        const Eigen::Vector3d t(tool.x, tool.y, tool.z);
        const Eigen::Vector3d found = chain.tip(q, t).place;
        worst = std::max(worst, (machine.tip(at, tool) - Vec{found[0], found[1], found[2]}).length());
        const Eigen::Vector3d guess = correction.at(q, t).offset;
        const AxisPosition there = TipCorrection::corrected(q, correction.at(q, t, guess).offset);
        corrected = std::max(
            corrected,
            (machine.tip({there[0], there[1], there[2], there[3]}, tool) - machine.ideal(at, tool)).length());
        back = std::max(back, (correction.un_corrected(there, t) - q).norm());
    }
    std::printf("%zu chains: tips agree to %.2g mm, corrected to %.2g mm, round trip %.2g mm\n",
                orders.size(), worst, corrected, back);
    EXPECT_GT(orders.size(), 300u);  // of 384
    EXPECT_LT(worst, 1e-11);
    EXPECT_LT(corrected, 1e-9);
    EXPECT_LT(back, 1e-9);
}

}  // namespace
}  // namespace plumb
