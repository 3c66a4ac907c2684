// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/decimal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace plumb::host {
namespace {

std::string text_of(double number) {
    std::string text;
    append_number(text, number);
    return text;
}

std::string seconds(Nanoseconds time) {
    std::string text;
    append_seconds(text, time);
    return text;
}

TEST(HostDecimal, NumbersReadBackToTheSameBits) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-300.0, 300.0);
    for (int i = 0; i < 10'000; ++i) {
        const double number = std::ldexp(static_cast<double>(random()), static_cast<int>(exponent(random)));
        EXPECT_EQ(number_of(text_of(number)), number);
        EXPECT_EQ(number_of(text_of(-number)), -number);
    }
}

TEST(HostDecimal, NumbersAreAsShortAsTheyCanBe) {
    EXPECT_EQ(text_of(0.1), "0.1");
    EXPECT_EQ(text_of(1.0), "1");
    EXPECT_EQ(text_of(1.0 / 3.0), "0.3333333333333333");
    EXPECT_EQ(text_of(std::numeric_limits<double>::infinity()), "inf");
}

TEST(HostDecimal, TimesAreExact) {
    EXPECT_EQ(seconds(0), "0");
    EXPECT_EQ(seconds(1), "0.000000001");
    EXPECT_EQ(seconds(250'000'000), "0.25");
    EXPECT_EQ(seconds(14'400 * one_second), "14400");
    EXPECT_EQ(seconds(14'400 * one_second + 1'000'000), "14400.001");
    EXPECT_EQ(seconds(-1'500'000'000), "-1.5");
}

TEST(HostDecimal, ATextWithSomethingElseInItIsNoNumber) {
    for (const char* text : {"", "x", "1x", "1 ", " 1", "1,5", "--1", "+-1"})
        EXPECT_FALSE(number_of(text)) << text;
    EXPECT_EQ(number_of("+1.5e3"), 1500.0);
    EXPECT_TRUE(std::isnan(number_of("nan").value()));
}

}  // namespace
}  // namespace plumb::host
