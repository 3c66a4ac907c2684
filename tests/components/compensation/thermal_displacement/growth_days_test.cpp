// SPDX-License-Identifier: GPL-2.0-or-later
// Days of drawn shops on which something happens: the figures beside the constants of GrowthFilter.
//
//     GROWTH_DAYS=150 build/tests/math_tests --gtest_filter='GrowthDays*'
//
// prints the table of so many machines for each kind of day. GROWTH_SEED=N draws others.
#include "tests/support/growth_shop.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

enum class Happens { nothing, work, gauge, tool, door, stop, step };

struct Kind {
    Happens what;
    const char* name;
};
constexpr Kind kinds[]{{Happens::nothing, "nothing"},        {Happens::work, "work of another height"},
                       {Happens::gauge, "one gauge shifts"}, {Happens::tool, "a longer tool"},
                       {Happens::door, "a door opens"},      {Happens::stop, "a stop"},
                       {Happens::step, "growth for 40 min"}};

double part_of(double time, double lasts) {
    return std::clamp(time / lasts, 0.0, 1.0);
}

struct Day {
    GrowthShop shop{};
    GrowthTruth truth{};
    double hours = 0;
};

// Machines of three structures, 5 to 50 um of growth, a part each 90 to 600 s, one to four gauges.
Day drawn_day(Happens what, std::uint64_t seed) {
    Random random(seed, 21);
    Day day;
    GrowthShop& shop = day.shop;
    const double size = std::array{5, 12, 20, 50}[random.index(4)] * um;
    shop.settings.by_speed = true;
    shop.interval = std::array{90, 150, 300, 600}[random.index(4)];
    shop.between = shop.interval < 150 ? 5 : 10;
    shop.gauges.clear();
    const auto gauges = 1 + random.index(4);
    const double noise = random.uniform(0.3, 3) * um;
    for (int i = 0; i < gauges; ++i)
        shop.gauges.push_back({i % 2 == 1 && gauges > 2 ? 4 : 1, noise, -random.uniform(0.8, 2)});
    shop.blank = random.uniform(0.3, 2.5) * um;
    day.hours = shop.interval < 200 ? 3 : 6;
    const auto structure = random.index(3);
    day.truth = structure == 2 ? many_lags_growth(seed, size, day.hours)
                               : drawn_growth(seed, size, structure == 1, day.hours);

    const double begin = random.uniform(0.3, 0.7) * day.hours * 3600;
    const double by = random.uniform(8, 30) * (random.index(2) == 1 ? um : -um);
    const double lasts = random.uniform(300, 2400);
    const auto usual = day.truth.growth;
    const std::vector<GrowthShop::Gauge> its = shop.gauges;
    const auto shifts = [&](const auto& which) {
        shop.shift = [=](double t, std::size_t gauge) { return t > begin && which(gauge) ? by : 0.0; };
    };
    const auto grows = [&](const auto& more) {
        day.truth.growth = [=](double t) { return usual(t) + more(t - begin); };
    };
    switch (what) {
        case Happens::nothing: break;
        case Happens::work: shifts([](std::size_t) { return true; }); break;
        case Happens::gauge: shifts([](std::size_t gauge) { return gauge == 0; }); break;
        case Happens::tool: shifts([its](std::size_t gauge) { return its[gauge].tool == 4; }); break;
        case Happens::door:
            grows([=](double t) { return -18 * um * (part_of(t, 60) - part_of(t - 60 - lasts, 60)); });
            break;
        case Happens::stop:
            grows([](double t) {
                return -16 * um * part_of(t, 300) * std::exp(-std::max(t - 300, 0.0) / 3000);
            });
            break;
        case Happens::step: grows([=](double t) { return t > 0 && t < 2400 ? by : 0.0; }); break;
    }
    return day;
}

struct Score {
    int cuts = 0, machines = 0, worse = 0, bad = 0, told = 0, within = 0;
    double with = 0, without = 0;

    void add(const std::vector<GrowthShop::Cut>& judged) {
        int worse_here = 0;
        for (const GrowthShop::Cut& cut : judged) {
            worse_here += std::abs(cut.error) > std::abs(cut.without) + 5 * um;
            told += cut.told;
            within += std::abs(cut.error) <= 2 * cut.sigma;
            with += cut.error * cut.error;
            without += cut.without * cut.without;
        }
        cuts += static_cast<int>(judged.size());
        worse += worse_here;
        bad += worse_here > 0.01 * static_cast<double>(judged.size());
        ++machines;
    }
    double rms() const { return std::sqrt(with / cuts) / um; }
    void print(const char* name) const {
        std::printf(
            "%-24s rms %5.2f um, none %5.2f; > 5 um worse: %d cuts, > 1 %% of them on %d of %d machines; "
            "told %.1f %%, within 2 sigma %.1f %%\n",
            name, rms(), std::sqrt(without / cuts) / um, worse, bad, machines, 100.0 * told / cuts,
            100.0 * within / cuts);
    }
};

std::uint64_t number(const char* name, std::uint64_t otherwise) {
    const char* given = std::getenv(name);
    return given != nullptr ? std::strtoull(given, nullptr, 10) : otherwise;
}

TEST(GrowthDays, OfDrawnShopsBecomeBetterAndAreRarelyHarmed) {
    const std::uint64_t machines = number("GROWTH_DAYS", 12), first = number("GROWTH_SEED", 1);
    double logs = 0;
    int bad = 0;
    for (const Kind& kind : kinds) {
        Score score;
        for (std::uint64_t i = 0; i < machines; ++i) {
            const Day day = drawn_day(kind.what, first + i + 1000003 * static_cast<std::uint64_t>(kind.what));
            const auto growth = std::make_unique<GrowthFilter>();
            GrowthShop shop = day.shop;
            score.add(shop.run(day.truth, day.hours, first + i, *growth));
        }
        score.print(kind.name);
        logs += std::log(score.rms());
        bad += score.bad;
        EXPECT_LT(score.with, score.without) << kind.name;
        EXPECT_GE(score.within, 0.85 * score.cuts) << kind.name;
        if (kind.what == Happens::nothing) {
            EXPECT_LE(score.worse, 0.002 * score.cuts);
        }
    }
    std::printf("%.2f um in the geometric mean, %d machines with more than 1 %% of worse cuts\n",
                std::exp(logs / std::size(kinds)), bad);
    EXPECT_LE(bad, 0.1 * static_cast<double>(machines * std::size(kinds)));
}

}  // namespace
}  // namespace plumb
