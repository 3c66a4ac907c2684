// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/stroke_plan.hpp"

#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace plumb {
namespace {

constexpr double nm = 1e-6;  // mm

std::unique_ptr<StrokePlan> planned(const StrokeRequest& request, std::size_t nodes_a_step = 64) {
    auto plan = std::make_unique<StrokePlan>();
    const auto planner = std::make_unique<StrokePlanner>();
    planner->begin(request, *plan);
    std::size_t work = 0;
    while (!planner->step(nodes_a_step)) work += nodes_a_step;
    EXPECT_LE(work, StrokePlanner::most_work);
    return plan;
}

// Both strokes of a region with sections. Its ends may be learned ones.
struct Region {
    Reciprocation base;
    double lower_offset = 0, upper_offset = 0;  // mm, outward
    SpeedSections::Table table{};
    double acceleration = 1e9, largest_speed = 1e9;

    StrokeRequest stroke(bool upward) const {
        StrokeRequest request;
        request.shape = {base.lower - lower_offset, base.upper + upper_offset, base.speed};
        request.from = upward ? request.shape.lower : request.shape.upper;
        request.to = upward ? request.shape.upper : request.shape.lower;
        request.largest_speed = largest_speed;
        request.acceleration = acceleration;
        request.spans = SpeedSections::spans(table, request.shape, upward);
        return request;
    }
};

// A region, every other one with learned ends, and up to four sections in any place, ratios of 0.1 to 5,
// limits from far above to far below what the speed wants.
Region drawn(Random& random) {
    Region region;
    region.base.lower = random.uniform(-300, 300);
    region.base.upper = region.base.lower + std::pow(10, random.uniform(0, 3));
    region.base.speed = std::pow(10, random.uniform(0.5, 3));
    region.acceleration = region.base.peak_acceleration() * std::pow(10, random.uniform(-0.7, 2));
    if (random.uniform() < 0.3) region.largest_speed = region.base.speed * random.uniform(0.5, 3);
    if (random.uniform() < 0.5) {
        region.lower_offset = random.uniform(-0.1, 0.1) * region.base.stroke();
        region.upper_offset = random.uniform(-0.1, 0.1) * region.base.stroke();
    }
    double edge = random.uniform(0, 1), first = edge;
    for (int i = random.index(5); i > 0; --i) {
        const double from = edge + (random.uniform() < 0.3 ? 0 : random.uniform(0, 1));
        edge = from + random.uniform(0.01, 1.5);
        if (edge > first + 2 * pi) break;
        region.table[static_cast<std::size_t>(i - 1)] = {SpeedSection::phase, std::fmod(from, 2 * pi),
                                                         std::fmod(edge, 2 * pi),
                                                         std::pow(10, random.uniform(-1, 0.7))};
    }
    return region;
}

// The square of the fastest speed, in closed form: the bound of each piece is concave, so that the
// tightest line with a slope of 2 a begins at an end of a piece, or at the position itself.
class Fastest {
public:
    explicit Fastest(const StrokeRequest& its) : request_(its) {
        edges_ = {its.shape.lower, its.shape.upper};
        for (const SpeedSpan& span : its.spans) {
            edges_.push_back(span.from);
            edges_.push_back(span.to);
        }
        std::sort(edges_.begin(), edges_.end());
    }

    double squared(double position) const {
        double least = piece_bound(position, position);
        for (std::size_t i = 0; i + 1 < edges_.size(); ++i) {
            if (!(edges_[i] < edges_[i + 1])) continue;
            const double middle = (edges_[i] + edges_[i + 1]) / 2;
            for (const double edge : {edges_[i], edges_[i + 1]})
                least = std::min(
                    least, piece_bound(edge, middle) + 2 * request_.acceleration * std::abs(position - edge));
        }
        return least;
    }

    double time(int steps) const {
        double sum = 0;
        for (int i = 0; i < steps; ++i) {
            const double phase = pi * (i + 0.5) / steps;
            sum += request_.shape.stroke() / 2 * std::sin(phase) /
                   std::sqrt(squared(request_.shape.position(phase)));
        }
        return sum * pi / steps;
    }

    // The bound at a position, with the ratio of the piece that contains `inside`.
    double piece_bound(double position, double inside) const {
        const double ratio = SpeedSections::ratio_at(request_.spans, inside);
        return std::min(ratio * ratio * request_.shape.speed_squared(position),
                        request_.largest_speed * request_.largest_speed);
    }

private:
    StrokeRequest request_;
    std::vector<double> edges_;
};

TEST(StrokePlan, WithoutSectionsAndLimitsIsTheHarmonicStroke) {
    Region region;
    region.base = {20, 120, 200};
    const auto up = planned(region.stroke(true)), down = planned(region.stroke(false));
    EXPECT_NEAR(up->duration(), pi / 4, 1e-9);
    EXPECT_NEAR(down->duration(), up->duration(), 1e-12);
    EXPECT_FALSE(up->limited());
    for (double t = 0.001; t < pi / 4; t += 0.001) {
        EXPECT_NEAR(up->at(t).position, region.base.position(4 * t), 0.02) << t;
        EXPECT_NEAR(up->at(t).velocity, 200 * std::sin(4 * t), 0.2) << t;
        EXPECT_NEAR(up->at(t).acceleration, 800 * std::cos(4 * t), 6) << t;
        EXPECT_NEAR(down->at(t).position, 140 - up->at(t).position, nm) << t;
    }
    EXPECT_NEAR(up->at(1e-6).acceleration, 800, 0.1);
    EXPECT_LE(up->at(1e-6).acceleration, 800);
    EXPECT_NEAR(up->at(up->duration() - 1e-6).acceleration, -800, 0.1);
}

TEST(StrokePlan, BeginsAndEndsAtRestExactlyAtItsDeadPoints) {
    Region region;
    region.base = {-3, 7, 300};
    region.acceleration = 2000;
    const auto up = planned(region.stroke(true));
    for (const double t : {-1.0, 0.0}) {
        EXPECT_EQ(up->at(t).position, -3);
        EXPECT_EQ(up->at(t).velocity, 0);
    }
    for (const double t : {up->duration(), 10.0}) {
        EXPECT_EQ(up->at(t).position, 7);
        EXPECT_EQ(up->at(t).velocity, 0);
    }
    EXPECT_NEAR(up->at(up->duration() - 1e-9).position, 7, nm);
}

TEST(StrokePlan, AnAccelerationTooSmallForTheSpeedMakesATriangle) {
    Region region;
    region.base = {0, 100, 1e4};
    region.acceleration = 1000;
    const auto up = planned(region.stroke(true));
    EXPECT_NEAR(up->duration(), 2 * std::sqrt(100 / 1000.0), 1e-4);
    EXPECT_TRUE(up->limited());
}

TEST(StrokePlan, ALargestSpeedCutsThePeak) {
    Region region;
    region.base = {0, 100, 200};
    region.largest_speed = 120;
    const auto up = planned(region.stroke(true));
    double fastest = 0;
    for (double t = 0; t < up->duration(); t += 1e-4) fastest = std::max(fastest, up->at(t).velocity);
    EXPECT_NEAR(fastest, 120, 1e-9);
    EXPECT_TRUE(up->limited());
}

TEST(StrokePlan, TheSameWhetherPlannedInOneStepOrInMany) {
    Random random(5);
    const StrokeRequest request = drawn(random).stroke(true);
    const auto at_once = planned(request, 1000000), slowly = planned(request, 1);
    EXPECT_EQ(at_once->duration(), slowly->duration());
    for (double part = 0; part < 1; part += 0.01)
        EXPECT_EQ(at_once->at(part * at_once->duration()).position,
                  slowly->at(part * at_once->duration()).position);
}

TEST(StrokePlan, AStrokeFromTheMiddleKeepsTheSectionsWhereTheyAre) {
    Region region;
    region.base = {0, 100, 200};
    region.acceleration = 5000;
    region.table[0] = {SpeedSection::height, 60, 80, 0.25};
    StrokeRequest request = region.stroke(true);
    request.from = 37;
    const auto part = planned(request);
    EXPECT_EQ(part->at(0).position, 37);
    EXPECT_EQ(part->at(part->duration()).position, 100);
    const double slow = std::sqrt(region.base.speed_squared(70)) / 4;
    for (double t = 0; t < part->duration(); t += 1e-3) {
        const StrokePlan::Moment now = part->at(t);
        EXPECT_LE(std::abs(now.acceleration), 5000 * (1 + 1e-9));
        if (std::abs(now.position - 70) < 1) {
            EXPECT_NEAR(now.velocity, slow, 0.03 * slow);
        }
    }
}

// What every plan keeps: acceleration and speed, inside the region, position and speed without a step, slow
// sections at their speed, fast ones never above.
void examine(const Region& region, const StrokeRequest& request, const StrokePlan& plan) {
    const double amax = region.acceleration, length = request.shape.stroke();
    StrokePlan::Moment before = plan.at(0);
    constexpr int samples = 200;
    const double dt = plan.duration() / samples;
    for (int i = 1; i <= samples; ++i) {
        const StrokePlan::Moment now = plan.at(i * dt);
        ASSERT_LE(std::abs(now.acceleration), amax * (1 + 1e-6));
        ASSERT_LE(std::abs(now.velocity - before.velocity), amax * dt * (1 + 1e-6));
        ASSERT_LE(std::abs(now.velocity), region.largest_speed * (1 + 1e-9));
        ASSERT_GE(now.position, request.shape.lower - 1e-9 * length);
        ASSERT_LE(now.position, request.shape.upper + 1e-9 * length);
        ASSERT_GE((now.position - before.position) * (plan.upward() ? 1 : -1), 0);
        // Exactly at an edge rounding decides which ratio holds.
        const double clear = 1e-6 * length;
        for (const double near : {-clear, clear}) {
            const double ratio = SpeedSections::ratio_at(request.spans, now.position + near);
            const double wanted = ratio * std::sqrt(request.shape.speed_squared(now.position));
            if (ratio == SpeedSections::ratio_at(request.spans, now.position - near)) {
                ASSERT_LE(std::abs(now.velocity), wanted * (1 + 1e-3) + 1e-3 * request.shape.speed * ratio);
            }
        }
        before = now;
    }
}

TEST(StrokePlan, NoDrawnTableBreaksALimit) {
    Random random(1);
    StrokePlan plan;
    StrokePlanner planner;
    for (int i = 0; i < 10000; ++i) {
        SCOPED_TRACE(i);
        const Region region = drawn(random);
        for (const bool upward : {true, false}) {
            const StrokeRequest request = region.stroke(upward);
            planner.begin(request, plan);
            ASSERT_TRUE(planner.step(StrokePlanner::most_work));
            ASSERT_NO_FATAL_FAILURE(examine(region, request, plan));
        }
    }
}

TEST(StrokePlan, TimeIsWithinHalfAPercentOfTheFastest) {
    Random random(2);
    double worst = 0;
    for (int i = 0; i < 1000; ++i) {
        SCOPED_TRACE(i);
        const Region region = drawn(random);
        const StrokeRequest up = region.stroke(true), down = region.stroke(false);
        const double time = planned(up)->duration() + planned(down)->duration();
        const double fastest = Fastest(up).time(2000) + Fastest(down).time(2000);
        EXPECT_NEAR(time, fastest, 0.005 * fastest);
        worst = std::max(worst, std::abs(time / fastest - 1));
    }
    RecordProperty("worst_percent", std::to_string(100 * worst));
}

// The slow-down ends where the section begins, and the speed-up starts where it ends.
TEST(StrokePlan, ASlowSectionIsSlowOverItsWholeLengthAndNoSlower) {
    Random random(3);
    for (int i = 0; i < 500; ++i) {
        SCOPED_TRACE(i);
        Region region;
        region.base = {0, 100, std::pow(10, random.uniform(1, 2.7))};
        const double ratio = random.uniform(0.1, 0.8), from = random.uniform(15, 50);
        const double to = from + random.uniform(5, 35);
        region.acceleration = region.base.peak_acceleration() * random.uniform(1.05, 10);
        region.table[0] = {SpeedSection::height, from, to, ratio};
        for (const bool upward : {true, false}) {
            const auto plan = planned(region.stroke(upward));
            EXPECT_FALSE(plan->limited());
            for (double t = 0; t < plan->duration(); t += plan->duration() / 1000) {
                const StrokePlan::Moment now = plan->at(t);
                if (now.position < from || now.position > to) continue;
                const double wanted = ratio * std::sqrt(region.base.speed_squared(now.position));
                ASSERT_NEAR(std::abs(now.velocity), wanted, 0.01 * wanted) << now.position;
            }
        }
    }
}

// What the axis has not shown yet, it accelerates by and does not brake by.
TEST(StrokePlan, BrakesByAPartOfItsAcceleration) {
    Random random(5);
    for (int i = 0; i < 400; ++i) {
        SCOPED_TRACE(i);
        const Region region = drawn(random);
        for (const bool upward : {true, false}) {
            StrokeRequest request = region.stroke(upward);
            request.acceleration = std::min(request.acceleration, request.shape.peak_acceleration() * 4);
            request.braking = random.uniform(0.5, 1);
            const auto plan = planned(request);
            const double most = request.acceleration * (1 + 1e-3);
            for (double part = 0; part < 1; part += 0.002) {
                const StrokePlan::Moment now = plan->at(part * plan->duration());
                const double along = upward ? now.acceleration : -now.acceleration;
                ASSERT_LE(along, most);
                ASSERT_GE(along, -most * request.braking) << part;
            }
            EXPECT_NEAR(plan->at(plan->duration() - 1e-9).position, request.to, nm);
        }
    }
}

// Of a crank without sections: from half of its acceleration on, the deceleration is largest at the end.
TEST(StrokePlan, ACrankThatBrakesByAPartKeepsItsOtherHalf) {
    StrokeRequest request;
    request.shape = {0, 40, 100};
    request.to = 40;
    request.largest_speed = 1e9;
    request.acceleration = 1e9;
    for (const double braking : {0.5, 0.7, 1.0}) {
        request.braking = braking;
        const auto plan = planned(request);
        const double hardest = request.shape.peak_acceleration();
        EXPECT_NEAR(plan->at(1e-6).acceleration, hardest, 1e-3 * hardest);
        for (double time = 0; time < plan->duration(); time += 1e-3)
            ASSERT_GE(plan->at(time).acceleration, -braking * hardest * (1 + 1e-3)) << braking << " " << time;
    }
}

}  // namespace
}  // namespace plumb
