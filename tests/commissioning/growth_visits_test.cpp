// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_visits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;

constexpr double um = 1e-3;
constexpr double pause = 45;  // s between two visits

// A pass of a machine that drifts by a constant rate, with a compensation that follows, later by a part.
struct Pass {
    std::vector<GrowthVisit> visits;
    Vector3d rate = Vector3d(2, -3, 15) * um / 600, follows = Vector3d(1.5, -2, 9) * um / 600;
    double slope = 0;  // of the compensation, over the travel

    Vector3d bore(int number, bool turned) const {
        return {(turned ? -80.0 : 80.0) * (number - 1), 60.0 * number, -140 + 10.0 * number};
    }
    Vector3d compensation(int number, bool turned, double t) const {
        return Vector3d(12, 7, 25) * um + follows * t + slope * bore(number, turned);
    }
    void visit(int number, bool turned, bool compensated) {
        GrowthVisit its;
        its.pass = 1;
        its.bore = number;
        its.turned = turned;
        its.compensated = compensated;
        its.time = 1000 + pause * static_cast<double>(visits.size());
        if (compensated) its.compensation = compensation(number, turned, its.time);
        its.place = bore(number, turned) + rate * its.time - its.compensation;
        visits.push_back(its);
    }
    void expect_one_time() const {
        const double middle = (visits.front().time + visits.back().time) / 2;
        for (const GrowthVisit& its : visits_at_one_time(visits)) {
            const Vector3d c =
                its.compensated ? compensation(its.bore, its.turned, middle) : Vector3d::Zero();
            EXPECT_LT((its.compensation - c).norm(), 1e-4 * um) << its.bore << its.turned << its.compensated;
            EXPECT_LT((its.place - bore(its.bore, its.turned) - rate * middle + c).norm(), 1e-4 * um);
            EXPECT_EQ(its.time, middle);
        }
    }
};

TEST(VisitsAtOneTime, BoreByBoreWithTheFirstOneAgain) {
    Pass pass;
    pass.slope = 20e-6;
    for (const bool turned : {false, true})
        for (const int bore : {1, 2, 3})
            for (const bool compensated : {false, true}) pass.visit(bore, turned, compensated);
    for (const bool compensated : {false, true}) pass.visit(1, false, compensated);
    EXPECT_EQ(visits_at_one_time(pass.visits).size(), 12u);
    pass.expect_one_time();
}

TEST(VisitsAtOneTime, MirroredPasses) {
    for (const int bores : {1, 2, 4}) {
        Pass pass;
        pass.slope = bores > 2 ? 20e-6 : 0;  // fewer bores do not show a time and a place
        for (const bool turned : {false, true})
            for (int bore = 1; bore <= bores; ++bore) pass.visit(bore, turned, false);
        for (const bool turned : {true, false})
            for (int bore = bores; bore >= 1; --bore) pass.visit(bore, turned, true);
        EXPECT_EQ(visits_at_one_time(pass.visits).size(), 4u * static_cast<unsigned>(bores));
        pass.expect_one_time();
    }
}

TEST(VisitsAtOneTime, WhatIsVisitedOnceIsLeftAsItIs) {
    Pass pass;
    pass.visit(1, false, false);
    pass.visit(2, false, false);
    const auto found = visits_at_one_time(pass.visits);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].place, pass.visits[0].place);
    EXPECT_EQ(found[1].place, pass.visits[1].place);
}

TEST(GrowthVisitsOfALog, CentreOfASphereIsItsPlaceWithoutTheCompensation) {
    GrowthLog log;
    log.bores[3].sphere = true;
    const Vector3d centre(7, -8, -120), offset(0.01, -0.02, 0.03);
    const double r = 13, miss = 0.5, side = std::sqrt(r * r - miss * miss);
    const Vector3d places[] = {
        {side, 0, miss}, {-side, 0, miss}, {0, side, miss}, {0, -side, miss}, {miss, 0, side}};
    GrowthRecord record;
    record.visit = 1, record.pass = 1, record.bore = 3, record.compensated = true;
    for (const Vector3d& place : places) {
        record.kind = GrowthRecord::touch;
        record.item = place.z() > miss ? -3 : 1;
        record.time += 4;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            record.at[i] = (centre + place + offset)[k];
            record.offset[i] = offset[k];
        }
        log.records.push_back(record);
    }
    record.kind = GrowthRecord::event;
    record.item = 10;
    log.records.push_back(record);
    const auto visits = growth_visits(log);
    ASSERT_EQ(visits.size(), 1u);
    EXPECT_LT((visits[0].place - centre).norm(), 1e-6);
    EXPECT_LT((visits[0].compensation - offset).norm(), 1e-9);
    EXPECT_NEAR(visits[0].diameter, 20, 1e-6);
    EXPECT_TRUE(visits[0].checked);
    log.bores[3].sphere = false;  // by the face alone Z is that of the touch
    EXPECT_NEAR(growth_visits(log)[0].place.z(), centre.z() + side, 1e-6);
}

}  // namespace
}  // namespace plumb::commissioning
