// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/artifact_expansion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;

constexpr double um = 1e-3;
const Vector3d centre(300, 40, -200), fixed_point(10, -100, 20);

// A test of a bore at both orientations; its artifact is warmer by 4 K in the second pass.
struct Turned {
    GrowthLog log;
    std::vector<GrowthVisit> visits;

    explicit Turned(bool trunnion) {
        log.trunnion = trunnion;
        log.bores[1].place = {80, -60, 60};
        log.artifact = GrowthLog::Artifact{4, 11.5, 1, {fixed_point.x(), fixed_point.y(), fixed_point.z()}};
        for (const double time : {0.0, 1000.0}) {
            GrowthRecord r;
            r.kind = GrowthRecord::temperature;
            r.time = time;
            r.item = 4;
            r.at = {20 + time / 250, 1, 0};
            log.records.push_back(r);
            for (const bool turned : {false, true}) {
                GrowthVisit visit;
                visit.bore = 1;
                visit.turned = turned;
                visit.time = time;
                visit.diameter = 30;
                visit.place = place(turned, time);
                visits.push_back(visit);
            }
        }
    }

    // The axes of a bore, whose face at the second orientation is another one, 110 mm behind the centre.
    Vector3d place(bool turned, double time) const {
        const Vector3d cold(80, -60, turned ? -110 : 60);
        const Vector3d warm = cold + 11.5e-6 * time / 250 * (cold - fixed_point);
        if (!turned) return centre + warm;
        return centre + (log.trunnion ? Vector3d(warm.x(), -warm.y(), -warm.z())
                                      : Vector3d(-warm.x(), warm.y(), -warm.z()));
    }
};

TEST(ArtifactExpansion, IsTakenOutFromTheFixedPointAtBothOrientations) {
    for (const bool trunnion : {false, true}) {
        Turned test(trunnion);
        const ArtifactExpansion its = take_out_expansion(test.log, test.visits);
        ASSERT_TRUE(its.applied);
        EXPECT_NEAR(its.warmest, 4, 1e-9);
        for (std::size_t i = 0; i < test.visits.size(); ++i)
            EXPECT_LT((test.visits[i].place - test.place(i % 2 == 1, 0)).norm(), 0.05 * um) << trunnion << i;
        EXPECT_NEAR(test.visits.back().diameter, 30 * (1 - 4 * 11.5e-6), 1e-9);
        // 130 mm in Z at the second orientation: 1 of 11.5 parts of 4 K, and 0.2 K.
        EXPECT_NEAR(its.uncertainty.z(), 130 * std::hypot(4e-6, 11.5e-6 * 0.2), 0.002 * um);
    }
}

TEST(ArtifactExpansion, IsLeftWhereItIsNotKnownAndTheReasonIsStated) {
    Turned none(false), silent(false), nowhere(false);
    none.log.artifact.reset();
    silent.log.records.clear();
    nowhere.log.bores.clear();
    for (Turned* const test : {&none, &silent, &nowhere}) {
        const Vector3d before = test->visits.back().place;
        const ArtifactExpansion its = take_out_expansion(test->log, test->visits);
        EXPECT_FALSE(its.applied);
        EXPECT_FALSE(its.why_not.empty());
        EXPECT_EQ(test->visits.back().place, before);
    }
}

}  // namespace
}  // namespace plumb::commissioning
