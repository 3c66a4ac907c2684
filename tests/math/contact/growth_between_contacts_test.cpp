// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/growth_between_contacts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// A spindle with one lag, in a shop whose temperature moves it.
struct Spindle {
    double lag = 600;  // s
    double gain = 30 * um;
    double by_temperature = 0;  // mm/K
    double grown = 0;
    double temperature = 20;
    bool temperature_valid = false;
    double seen_speed = 0;  // when it is not the true one
    bool misread = false;

    GrowthBetweenContacts::Settings settings{};
    GrowthBetweenContacts model{};

    double growth() const { return grown + by_temperature * (temperature - 20); }

    void run(double speed, double seconds) {
        for (int i = 0; i < std::lround(seconds); ++i) {
            const double heat = gain * std::pow(speed / 5000, 1.7);
            grown += (heat - grown) * -std::expm1(-1 / (speed > 0 ? lag : 4 * lag));
            model.step(misread ? seen_speed : speed, temperature, temperature_valid, settings, 1);
        }
    }
    void contact(bool explained = true) { model.correct(growth(), 0.1 * um, {}, explained, settings); }
    void work(double speed, int contacts) {
        for (int i = 0; i < contacts; ++i) {
            run(speed, 300);
            contact();
        }
    }
    double error() const { return model.growth() - growth(); }
};

Spindle learnt(double lag) {
    Spindle spindle;
    spindle.lag = lag;
    spindle.contact(false);
    spindle.work(5000, 6);
    spindle.work(2000, 6);
    spindle.work(0, 4);
    return spindle;
}

TEST(GrowthBetweenContacts, IsKnownFromTheFirstContactOn) {
    Spindle spindle;
    spindle.run(3000, 10);
    EXPECT_FALSE(spindle.model.known());
    spindle.contact();
    EXPECT_TRUE(spindle.model.known());
    EXPECT_NEAR(spindle.error(), 0, 0.1 * um);
    spindle.model.forget();
    EXPECT_FALSE(spindle.model.known());
}

TEST(GrowthBetweenContacts, FindsOutHowFastTheSpindleGrows) {
    for (const double lag : {300.0, 450.0, 600.0, 900.0, 1200.0}) {
        Spindle spindle = learnt(lag);
        const double last = spindle.growth();
        spindle.run(5000, 600);
        EXPECT_LT(std::abs(spindle.error()), 0.15 * std::abs(spindle.growth() - last)) << lag;
    }
}

TEST(GrowthBetweenContacts, TheWeightsDecide) {
    Spindle quick = learnt(300), slow = learnt(1200);
    const double before[] = {quick.model.growth(), slow.model.growth()};
    quick.run(5000, 300);
    slow.run(5000, 300);
    EXPECT_GT(quick.model.growth() - before[0], 1.8 * (slow.model.growth() - before[1]));
}

TEST(GrowthBetweenContacts, SigmaGrowsUntilTheNextContact) {
    Spindle spindle = learnt(600);
    const double after_contact = spindle.model.sigma();
    EXPECT_LT(after_contact, 1 * um);
    spindle.run(8000, 900);
    EXPECT_GT(spindle.model.sigma(), 2 * um);
    EXPECT_LT(std::abs(spindle.error()), 3 * spindle.model.sigma());
    spindle.contact();
    EXPECT_LT(spindle.model.sigma(), 1.1 * um) << "the contact's own, and little more";
}

TEST(GrowthBetweenContacts, NeverJumpsBetweenContacts) {
    Spindle spindle = learnt(600);
    spindle.temperature_valid = true;
    double before = spindle.model.growth();
    const double fastest = 20 * um / 60;  // in a second, on this spindle at 10000 rpm
    for (int i = 0; i < 600; ++i) {
        spindle.misread = i % 7 == 3;
        spindle.seen_speed = i % 2 ? not_a_number : 1e9;
        spindle.temperature = i % 11 == 5 ? not_a_number : i % 11 == 7 ? 1e9 : i % 5 ? 20 : -40;
        spindle.run(i % 3 ? 10000 : 0, 1);
        EXPECT_LT(std::abs(spindle.model.growth() - before), fastest) << i;
        before = spindle.model.growth();
    }
}

TEST(GrowthBetweenContacts, ALostSpeedHoldsAndAfterAMinuteNothingIsKnown) {
    Spindle spindle = learnt(600);
    spindle.run(8000, 60);
    const double before = spindle.model.growth();
    spindle.misread = true;
    spindle.seen_speed = not_a_number;
    spindle.run(8000, 60);
    EXPECT_NEAR(spindle.model.growth(), before, 1e-9 * um);
    EXPECT_TRUE(spindle.model.known());
    spindle.run(8000, 1);
    EXPECT_FALSE(spindle.model.known());
    spindle.misread = false;
    spindle.run(8000, 60);
    EXPECT_FALSE(spindle.model.known());
    spindle.contact();
    EXPECT_NEAR(spindle.error(), 0, 0.5 * um);
}

// In a shop whose temperature moves it by 4 um a kelvin.
Spindle taught_by_temperature() {
    Spindle spindle;
    spindle.by_temperature = 4 * um;
    spindle.temperature_valid = true;
    spindle.contact(false);
    for (int i = 0; i < 20; ++i) {
        spindle.temperature = 20 + 2 * std::sin(0.9 * i);
        spindle.work(3000, 1);
    }
    return spindle;
}

TEST(GrowthBetweenContacts, ATemperatureIsLearntAndHeldWhenItIsLost) {
    Spindle spindle = taught_by_temperature();
    const double warm = spindle.temperature;
    spindle.temperature += 2;
    spindle.run(3000, 250);
    EXPECT_NEAR(spindle.error(), 0, 2 * um) << "of 8 um";
    const double before = spindle.model.growth();
    spindle.temperature = 90;
    spindle.run(3000, 1);
    EXPECT_NEAR(spindle.model.growth(), before, 0.2 * um) << "no shop warms so fast";
    spindle.temperature_valid = false;
    spindle.temperature = warm;
    spindle.run(3000, 60);
    EXPECT_NEAR(spindle.model.growth(), before, 0.5 * um);
}

TEST(GrowthBetweenContacts, ATemperatureThatStaysLostCountsForNothing) {
    Spindle spindle = taught_by_temperature();
    spindle.temperature = 24;
    spindle.run(3000, 900);
    const double held = spindle.model.growth();
    spindle.temperature_valid = false;
    spindle.run(3000, 590);
    EXPECT_NEAR(spindle.model.growth(), held, 0.5 * um);
    spindle.run(3000, 20);
    EXPECT_NEAR(spindle.model.growth(), held, 2 * um) << "it does not jump";
    spindle.run(3000, 500);
    EXPECT_NEAR(spindle.model.growth(), held - 16 * um, 3 * um);
}

TEST(GrowthBetweenContacts, ATemperatureThatIsNeverValidChangesNothing) {
    Spindle with = learnt(600), without = learnt(600);
    with.temperature = 35;
    with.by_temperature = 0;
    with.work(3000, 3);
    without.work(3000, 3);
    EXPECT_EQ(with.model.growth(), without.model.growth());
}

TEST(GrowthBetweenContacts, OtherSettingsStartAgain) {
    Spindle spindle = learnt(600);
    spindle.settings.repeatability = 2 * um;
    spindle.run(3000, 1);
    EXPECT_TRUE(spindle.model.known());
    spindle.settings.expected_growth = 40 * um;
    spindle.run(3000, 1);
    EXPECT_FALSE(spindle.model.known());
}

TEST(GrowthBetweenContacts, StaysSoundForAWeek) {
    Spindle spindle;
    spindle.contact(false);
    for (int day = 0; day < 7; ++day) {
        spindle.work(4000, 96);
        spindle.work(0, 2);
        spindle.run(0, 16 * 3600 - 600);
        EXPECT_GT(spindle.model.sigma(), 0);
    }
    spindle.work(4000, 2);
    spindle.run(4000, 299);
    EXPECT_NEAR(spindle.error(), 0, 2 * um);
}

TEST(GrowthBetweenContacts, SettingsThatMakeNoSenseAreNotValid) {
    using Settings = GrowthBetweenContacts::Settings;
    EXPECT_TRUE(Settings{}.valid());
    for (double Settings::*const each : {&Settings::expected_growth, &Settings::unexplained_growth,
                                         &Settings::repeatability, &Settings::temperature_growth})
        for (const double wrong : {-1.0, 2.0, not_a_number}) {
            Settings settings;
            settings.*each = wrong;
            EXPECT_FALSE(settings.valid()) << wrong;
        }
}

}  // namespace
}  // namespace plumb
