// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/error_table.hpp"

#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

using Function = double (*)(double);

const std::vector<double> uneven = {-120, -100, -35, -30, 0, 7, 90, 200};  // mm

// Each error another multiple of f, so that one taken for another is seen.
ErrorTable table_of(const std::vector<double>& positions, Function f) {
    std::vector<ErrorTable::Row> rows;
    for (const double p : positions) {
        ErrorTable::Row row{p, {}};
        for (std::size_t i = 0; i < row.errors.size(); ++i) row.errors[i] = f(p) * static_cast<double>(i + 1);
        rows.push_back(row);
    }
    return ErrorTable(rows);
}

std::vector<double> even(double spacing, double until) {
    std::vector<double> positions;
    for (int i = 0; i * spacing <= until; ++i) positions.push_back(i * spacing);
    return positions;
}

double wave(double p) {
    return 10 * um * std::sin(2 * pi * p / 300);
}

void expect_all(const ErrorMotions& values, double first, double tolerance) {
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(values[i], first * static_cast<double>(i + 1), tolerance) << "error " << i;
}

TEST(ErrorTable, GivesTheMeasuredErrors) {
    const ErrorTable table = table_of(uneven, wave);
    EXPECT_EQ(table.first(), -120);
    EXPECT_EQ(table.last(), 200);
    for (const double p : uneven) expect_all(table.at(p).errors, wave(p), 1e-12);
}

TEST(ErrorTable, TwoRowsMakeAStraightLine) {
    const ErrorTable table = table_of({-50, 150}, [](double p) { return 0.02 - 1e-4 * p; });
    for (double p = -50; p <= 150; p += 12.5) {
        expect_all(table.at(p).errors, 0.02 - 1e-4 * p, 1e-15);
        expect_all(table.at(p).slopes, -1e-4, 1e-15);
    }
}

TEST(ErrorTable, MeetsParabolasExactlyBetweenUnevenPositions) {
    const ErrorTable table = table_of(uneven, [](double p) { return 0.003 + 2e-5 * p - 4e-7 * p * p; });
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        const double p = random.uniform(-120, 200);
        expect_all(table.at(p).errors, 0.003 + 2e-5 * p - 4e-7 * p * p, 1e-14);
        expect_all(table.at(p).slopes, 2e-5 - 8e-7 * p, 1e-15);
    }
}

TEST(ErrorTable, HalfTheSpacingLeavesAnEighthOfTheError) {
    const auto worst = [](double spacing) {
        const ErrorTable table = table_of(even(spacing, 600), wave);
        double most = 0;
        for (double p = 0; p <= 600; p += 0.7)
            most = std::max(most, std::abs(table.at(p).errors[0] - wave(p)));
        return most;
    };
    const double coarse = worst(25), fine = worst(12.5);
    std::printf("wave of 10 um and 300 mm: off by %.4f um at 25 mm, %.4f um at 12.5 mm\n", coarse / um,
                fine / um);
    EXPECT_LT(coarse, 0.5 * um);
    EXPECT_LT(fine, coarse / 7);
}

TEST(ErrorTable, NeitherValueNorSlopeStepsAtAPosition) {
    const ErrorTable table = table_of(uneven, wave);
    constexpr double near = 1e-9;  // mm
    for (std::size_t i = 1; i + 1 < uneven.size(); ++i) {
        const ErrorTable::Reading before = table.at(uneven[i] - near), after = table.at(uneven[i] + near);
        for (std::size_t k = 0; k < 6; ++k) {
            EXPECT_NEAR(before.errors[k], after.errors[k], 1e-11);
            EXPECT_NEAR(before.slopes[k], after.slopes[k], 1e-13) << "at " << uneven[i];
        }
    }
}

TEST(ErrorTable, TheSlopeIsTheDerivativeOfTheValue) {
    const ErrorTable table = table_of(uneven, wave);
    constexpr double step = 1e-3;  // mm
    for (double p = -119.93; p < 200; p += 0.31) {
        const ErrorMotions a = table.at(p - step).errors, b = table.at(p + step).errors;
        for (std::size_t k = 0; k < 6; ++k)
            EXPECT_NEAR(table.at(p).slopes[k], (b[k] - a[k]) / (2 * step), 1e-8) << "at " << p;
    }
}

TEST(ErrorTable, BeyondItsEndsItHoldsAndHasNoSlope) {
    const ErrorTable table = table_of(uneven, wave);
    for (const double beyond : {1e-9, 1.0, 1e6, static_cast<double>(INFINITY)}) {
        expect_all(table.at(-120 - beyond).errors, wave(-120), 0);
        expect_all(table.at(200 + beyond).errors, wave(200), 1e-15);
        expect_all(table.at(-120 - beyond).slopes, 0, 0);
        expect_all(table.at(200 + beyond).slopes, 0, 0);
    }
    EXPECT_NE(table.at(-120).slopes[0], 0);
    EXPECT_NE(table.at(200).slopes[0], 0);
}

TEST(ErrorTable, WhatIsNotANumberReadsAsBeforeTheFirst) {
    const ErrorTable table = table_of(uneven, wave);
    expect_all(table.at(NAN).errors, wave(-120), 0);
    expect_all(table.at(NAN).slopes, 0, 0);
}

TEST(ErrorTable, ABadReadingSpoilsTwoIntervalsOnEitherSide) {
    const ErrorTable table = table_of(even(10, 100), [](double p) { return p == 50 ? 1.0 : 0.0; });
    for (double p = 0; p <= 100; p += 0.25)
        if (p <= 30 || p >= 70)
            EXPECT_EQ(table.at(p).errors[0], 0) << p;
        else
            EXPECT_NE(p == 40 || p == 60 ? 1.0 : table.at(p).errors[0], 0) << p;
}

TEST(ErrorTable, OvershootsAStepByTwoTwentySevenths) {
    const ErrorTable table = table_of(even(10, 100), [](double p) { return p > 45 ? 1.0 : 0.0; });
    double least = 0, most = 0;
    for (double p = 0; p <= 100; p += 0.01) {
        least = std::min(least, table.at(p).errors[0]);
        most = std::max(most, table.at(p).errors[0]);
    }
    EXPECT_NEAR(least, -2.0 / 27, 1e-6);
    EXPECT_NEAR(most, 1 + 2.0 / 27, 1e-6);
}

}  // namespace
}  // namespace plumb
