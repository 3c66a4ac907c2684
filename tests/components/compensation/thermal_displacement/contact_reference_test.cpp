// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

ContactReference reference(double coordinate, double time = 0.5) {
    ContactReference r;
    r.contact.coordinate = coordinate;
    r.contact.time = time;
    r.contact.feed = -2;
    r.contact.sigma = 3 * um;
    return r;
}

ContactReference mean_of(Method method, const std::vector<ContactReference>& contacts) {
    ContactReference mean = contacts.front();
    for (std::size_t i = 1; i < contacts.size(); ++i) take_in(method, mean, contacts[i]);
    return mean;
}

TEST(ContactReference, TheMeanOfContactsHasTheirSampleStandardDeviation) {
    // 2, 4, 4, 4, 5, 5, 7, 9: mean 5, squares about it 32
    std::vector<ContactReference> contacts;
    for (const double x : {2, 4, 4, 4, 5, 5, 7, 9}) contacts.push_back(reference(-20 + x * um));
    const ContactReference mean = mean_of(Method::coordinate, contacts);
    EXPECT_NEAR(mean.contact.coordinate, -20 + 5 * um, 1e-12);
    EXPECT_NEAR(mean.scatter, std::sqrt(32 / 7.) * um, 1e-12);
    EXPECT_NEAR(mean.contact.sigma, 3 / std::sqrt(8.) * um, 1e-12) << "independent noise averages out";
    EXPECT_EQ(mean.cycles, 8);
}

TEST(ContactReference, ByTimeTheScatterIsThatOfTheTimesOnTheirWay) {
    const ContactReference mean =
        mean_of(Method::time, {reference(-20, 0.500), reference(-21, 0.502), reference(-22, 0.504)});
    EXPECT_NEAR(mean.contact.time, 0.502, 1e-12);
    EXPECT_NEAR(mean.scatter, 2 * 0.002, 1e-9);
}

TEST(ContactReference, RemembersMeansAndTheLastDate) {
    ContactReference warm = reference(-20), cold = reference(-20);
    cold.temperature = 18;
    cold.date = 20261120;
    cold.speed_history = 1000;
    warm.temperature = 22;
    warm.date = 20261121;
    warm.speed_history = 3000;
    const ContactReference mean = mean_of(Method::coordinate, {cold, warm});
    EXPECT_EQ(mean.temperature, 20);
    EXPECT_EQ(mean.speed_history, 2000);
    EXPECT_EQ(mean.date, 20261121);
}

TEST(ContactReference, SigmaOfADisplacementHasTheScatterOfBothEnds) {
    Contact now;
    now.sigma = 3 * um;
    const ContactReference one = reference(-20);
    EXPECT_NEAR(displacement_sigma(now, one), 3 * std::sqrt(2.) * um, 1e-12);
    ContactReference four = reference(-20);
    four.cycles = 4;
    four.scatter = 8 * um;
    four.contact.sigma = 1.5 * um;
    EXPECT_NEAR(displacement_sigma(now, four), std::hypot(8, 4) * um, 1e-12);
    four.scatter = 0;
    EXPECT_NEAR(displacement_sigma(now, four), std::hypot(3, 1.5) * um, 1e-12) << "never below the noise";
}

}  // namespace
}  // namespace plumb
