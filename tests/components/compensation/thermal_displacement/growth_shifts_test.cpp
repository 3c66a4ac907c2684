// SPDX-License-Identifier: GPL-2.0-or-later
// Whole shifts of ten hours on drawn machines of two structures, in steps of a second.
#include "tests/support/growth_shop.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace plumb {
namespace {

constexpr double um = 1e-3;   // mm
constexpr int machines = 20;  // also under the sanitizers: the limits are those of so many

GrowthShop shop_with(std::vector<GrowthShop::Gauge> gauges) {
    GrowthShop shop;
    shop.gauges = std::move(gauges);
    shop.settings.by_speed = true;
    return shop;
}
const std::vector<GrowthShop::Gauge> one_tool{{1, 0.7 * um}, {1, 0.7 * um}};
const std::vector<GrowthShop::Gauge> two_tools{{1, 0.7 * um}, {1, 0.7 * um}, {4, 0.7 * um}};

const std::vector<GrowthShop::Gauge> two_feeds{{1, 0.7 * um}, {1, 0.7 * um, -0.833}};

struct Score {
    int cuts = 0, told = 0, worse = 0, silent = 0, asked = 0, within = 0, messages = 0;
    double with = 0, without = 0;

    void add(const std::vector<GrowthShop::Cut>& judged, double from = 0) {
        bool before = false;
        for (const GrowthShop::Cut& cut : judged) {
            if (cut.time < from) continue;
            ++cuts;
            told += cut.told;
            asked += cut.asked;
            // The panel alone shows a growth that is uncertain, or unknown at a start: there is nothing to
            // do.
            const auto doubt = static_cast<Doubt>(cut.doubt);
            const bool message =
                cut.told && doubt != Doubt::uncertain && doubt != Doubt::held_back && doubt != Doubt::unknown;
            messages += message && !before;
            before = message;
            const bool harm = std::abs(cut.error) > std::abs(cut.without) + 5 * um;
            worse += harm;
            silent += harm && !cut.told;
            within += std::abs(cut.error) <= 2 * cut.sigma;
            with += cut.error * cut.error;
            without += cut.without * cut.without;
        }
    }
};

TEST(GrowthShifts, HealthyMachinesAreCorrectedAndNotAccused) {
    for (const double size : {5 * um, 12 * um, 50 * um})
        for (const auto& gauges : {one_tool, two_tools})
            for (const bool two_states : {false, true}) {
                Score score;
                for (int seed = 1; seed <= machines; ++seed) {
                    GrowthShop shop = shop_with(gauges);
                    const auto growth = std::make_unique<GrowthFilter>();
                    score.add(shop.run(drawn_growth(seed, size, two_states, 10), 10, seed, *growth));
                }
                EXPECT_LT(score.with, score.without) << size;
                if (size > 40 * um) {
                    EXPECT_LT(std::sqrt(score.with), 0.22 * std::sqrt(score.without));
                }
                EXPECT_EQ(score.asked, 0) << size << two_states;
                EXPECT_LE(score.told, 0.02 * score.cuts) << size << two_states;
                EXPECT_LE(score.worse, 0.005 * score.cuts) << size << two_states;
                EXPECT_GE(score.within, 0.85 * score.cuts) << size << two_states;
                EXPECT_LE(score.messages, 0.1 * machines) << "one in 100 h";
            }
}

// A structure that no prior was chosen for. A machine that changes its growth by 30 um in five minutes is
// asked, and its question stays open until it is answered or the growth returns.
TEST(GrowthShifts, MachinesOfManyLagsAreCorrectedAndRarelyAsked) {
    for (const double size : {5 * um, 12 * um, 50 * um})
        for (const auto& gauges : {one_tool, two_tools}) {
            Score score;
            for (int seed = 1; seed <= machines; ++seed) {
                GrowthShop shop = shop_with(gauges);
                const auto growth = std::make_unique<GrowthFilter>();
                score.add(shop.run(many_lags_growth(seed, size, 4), 4, seed, *growth));
            }
            EXPECT_LT(score.with, score.without) << size;
            EXPECT_LE(score.asked, (size > 40 * um ? 0.22 : 0) * score.cuts) << size;
            EXPECT_LE(score.told, (size > 40 * um ? 0.22 : 0.02) * score.cuts) << size;
            EXPECT_LE(score.worse, 0.002 * score.cuts) << size;
            EXPECT_LE(score.silent, 0.002 * score.cuts) << size;
            EXPECT_GE(score.within, 0.85 * score.cuts) << size;
        }
}

// A chiller holds the spindle within a micrometre, or cools it too much, or a column takes its growth back
// half an hour later. Its speed says that it should have grown.
TEST(GrowthShifts, ChilledSpindlesAndOpposedGrowthsAreNotAccused) {
    const std::function<double(const GrowthTruth&, double)> kinds[]{
        [](const auto&, double t) { return um * std::sin(6.2832 * t / 900); },
        [](const auto& its, double t) { return -its.growth(t); },
        [](const auto& its, double t) { return its.growth(t) - its.growth(std::max(t - 1800, 0.0)); }};
    for (const auto& kind : kinds) {
        Score score;
        for (int seed = 1; seed <= machines; ++seed) {
            GrowthShop shop = shop_with(two_tools);
            GrowthTruth truth = drawn_growth(seed, 12 * um, seed % 2, 10);
            const GrowthTruth usual = truth;
            truth.growth = [&](double t) { return kind(usual, t); };
            const auto growth = std::make_unique<GrowthFilter>();
            score.add(shop.run(truth, 10, seed, *growth));
        }
        EXPECT_EQ(score.asked, 0) << &kind - kinds;
        EXPECT_LE(score.told, 0.02 * score.cuts) << &kind - kinds;
        EXPECT_LE(score.messages, 1) << &kind - kinds;
        EXPECT_LE(score.worse, 0.005 * score.cuts) << &kind - kinds;
    }
}

// Where growth and shift have opposite signs, no offset is safe: the cuts are as without compensation.
TEST(GrowthShifts, AShiftThatGrowthCannotMakeIsAskedAboutAndHarmsNoPart) {
    struct Case {
        const char* name;
        double distance;
        const std::vector<GrowthShop::Gauge>* gauges;
        std::int32_t tool;  // 0: all
        double delay = 0;   // s, of the load
    };
    const Case cases[]{{"the only tool longer", 30 * um, &one_tool, 0},
                       {"one of two tools longer", 30 * um, &two_tools, 4},
                       {"higher blanks", 25 * um, &two_tools, 0},
                       {"the filter of the drive from 20 to 50 ms", -50 * um, &two_tools, 0},
                       {"15 ms of bus latency", -25 * um, &two_tools, 0},
                       {"15 ms of bus latency, at two feeds", 0, &two_feeds, 0, 0.015},
                       {"higher blanks, at two feeds", 25 * um, &two_feeds, 0},
                       {"a new fixture", 50 * um, &two_tools, 0}};
    for (const double size : {5 * um, 12 * um})
        for (const Case& its : cases) {
            Score score;
            for (int seed = 1; seed <= machines; ++seed) {
                GrowthShop shop = shop_with(*its.gauges);
                const double begin = 7200 + 400 * (seed % 9);
                shop.shift = [&](double t, std::size_t gauge) {
                    const bool its_tool = its.tool == 0 || shop.gauges[gauge].tool == its.tool;
                    return t >= begin && its_tool ? its.distance + its.delay * shop.gauges[gauge].feed : 0.0;
                };
                const auto growth = std::make_unique<GrowthFilter>();
                score.add(shop.run(drawn_growth(seed, size, seed % 2, 6), 6, seed, *growth), begin);
            }
            EXPECT_LE(score.worse, 0.002 * score.cuts) << its.name << size;
            EXPECT_EQ(score.silent, 0) << its.name << size;
            EXPECT_GE(score.asked, (its.tool ? 0.5 : 0.97) * score.cuts) << its.name << size;
            EXPECT_LT(score.with, 1.02 * score.without) << its.name << size;
        }
}

// A machine that warms up fast has shown its estimator little else, and one gauge has no other beside it.
TEST(GrowthShifts, AShiftInTheFirstHourIsAskedAboutOnAFastMachineToo) {
    const std::vector<GrowthShop::Gauge> one_gauge{{1, 0.7 * um}};
    for (const double size : {12 * um, 50 * um})
        for (const auto& gauges : {one_gauge, one_tool, two_tools})
            for (const double distance : {30 * um, -25 * um, 50 * um}) {
                Score score;
                for (int seed = 1; seed <= machines; ++seed) {
                    GrowthShop shop = shop_with(gauges);
                    const double begin = 1800 + 300 * (seed % 5);
                    shop.shift = [=](double t, std::size_t) { return t >= begin ? distance : 0.0; };
                    const auto growth = std::make_unique<GrowthFilter>();
                    score.add(shop.run(drawn_growth(seed, size, seed % 2, 2), 2, seed, *growth), begin);
                }
                EXPECT_GE(score.asked, (size > 40 * um ? 0.8 : 0.9) * score.cuts)
                    << size << ' ' << gauges.size() << ' ' << distance;
                EXPECT_LE(score.worse, 1) << size << ' ' << gauges.size() << ' ' << distance;
                EXPECT_LT(score.with, score.without) << size << ' ' << gauges.size() << ' ' << distance;
            }
}

// A spindle that grows by 20 um at once: no estimator can distinguish that from other work. It is asked
// about, and corrected once the operator has answered.
TEST(GrowthShifts, AStepThatTheOperatorCallsGrowthIsCorrected) {
    for (const double step : {20 * um, -26 * um}) {
        int after = 0;
        for (int seed = 1; seed <= machines; ++seed) {
            GrowthShop shop = shop_with(two_tools);
            GrowthTruth truth = drawn_growth(seed, 12 * um, seed % 2, 5);
            const auto slow = truth.growth;
            truth.growth = [=](double t) { return slow(t) + (t > 9000 ? step : 0.0); };
            double answered = 0;
            int asked = 0;
            shop.every_part = [&](double t, GrowthFilter& growth) {
                if (growth.shift(shop.settings) == Shift::none || ++asked < 2 || answered > 0) return;
                growth.shift_is_growth();
                answered = t;
            };
            const auto growth = std::make_unique<GrowthFilter>();
            const auto cuts = shop.run(truth, 5, seed, *growth);
            ASSERT_GT(answered, 9000) << seed;
            ASSERT_LT(answered, 9000 + 4 * shop.interval) << seed;
            for (const GrowthShop::Cut& cut : cuts) {
                if (cut.time < answered + shop.interval) continue;
                ++after;
                EXPECT_LT(std::abs(cut.error), 10 * um) << seed << ' ' << cut.time;
                EXPECT_FALSE(cut.asked) << seed << ' ' << cut.time;
            }
        }
        EXPECT_GT(after, 200);
    }
}

// A touch of a fixed surface has a standard deviation of 2 um, and a check is the mean of five, right after a
// part: after learning, and while a question is open.
TEST(GrowthShifts, AProbedFixedSurfaceAnswersWithinOnePartWhateverIsTrue) {
    constexpr double noise = 2 * um;
    for (const bool is_growth : {false, true}) {
        int asked = 0, right = 0, wrong = 0;
        for (int seed = 1; asked < 330; ++seed) {
            Random random(static_cast<std::uint64_t>(seed), 31);
            GrowthShop shop = shop_with(seed % 3 ? two_tools : one_tool);
            shop.settings.surface_repeatability = noise / std::sqrt(5);
            const double begin = random.uniform(4000, 7000);
            const double size = random.uniform(12 * um, 50 * um) * (seed % 2 ? 1 : -1);
            GrowthTruth truth = drawn_growth(seed, (seed % 5 ? 12 : 50) * um, seed % 4 < 2, 2.3);
            const auto slow = truth.growth;
            if (is_growth) truth.growth = [=](double t) { return slow(t) + (t >= begin ? size : 0.0); };
            if (!is_growth) shop.shift = [=](double t, std::size_t) { return t >= begin ? size : 0.0; };
            int part = 0;
            bool over = false;
            shop.after_part = [&](double t, GrowthFilter& growth) {
                const bool question = growth.shift(shop.settings) != Shift::none;
                if (over || (part++ != 0 && !question)) return;
                double touches = 0;
                for (int i = 0; i < 5; ++i) touches += noise * random.gaussian() / 5;
                const SurfaceCheck found =
                    growth.check(-200 + truth.growth(t) + touches, 9, false, shop.settings);
                const auto answer = is_growth ? SurfaceCheck::is_growth : SurfaceCheck::is_no_growth;
                const auto other = is_growth ? SurfaceCheck::is_no_growth : SurfaceCheck::is_growth;
                over = question;
                asked += question;
                right += question && found == answer;
                wrong += found == other;
            };
            const auto growth = std::make_unique<GrowthFilter>();
            shop.run(truth, 2.3, seed, *growth);
        }
        EXPECT_GE(right, 0.95 * asked + 1.645 * std::sqrt(0.05 * 0.95 * asked)) << "lower limit of 95 %";
        EXPECT_EQ(wrong, 0);
        RecordProperty(is_growth ? "growth" : "shift", right);
    }
}

}  // namespace
}  // namespace plumb
