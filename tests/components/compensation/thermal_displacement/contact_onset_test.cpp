// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_onset.hpp"

#include "components/math/blocks/random.hpp"
#include "components/plants/sample_and_hold.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double feed = 100.0 / 60;  // mm/s
constexpr double us = 1e-6;          // s

// A tool that feeds towards the work for a second and meets it, at a moment that has nothing to do with the
// samples; the load as its drive shows it.
struct Approach {
    double dt = 0.001;
    double lag = 0.03;
    double step = 8;        // %
    double noise = 0;       // %, standard deviation
    double quantum = 0;     // %
    double hold = 0;        // s
    double ends_after = 1;  // s after the contact
    double late = 0.01;     // s, of the start
    double before = 1;      // s, from its beginning to the contact
    double coolant = 0;     // %, from a while before the contact on
    double coolant_before = 0;
    bool filtered = false;  // so is the coolant's load
    double tooth = 0;       // s from one to the next: each cuts for 40 % of that, from the contact on

    Random random{1};
    ContactOnset onset{};
    int periods = 0;  // from the end of the record to the result

    // Returns the error in s.
    double fit(double time_constant = 0) {
        const double contact = before + dt * random.uniform();
        SampleAndHold drive(hold * random.uniform());
        bool done = false, started = false;
        periods = 0;
        double time = 0, milled = 0;
        const double phase = random.uniform();
        for (int i = 1; !done && time < before + ends_after + 2; ++i) {
            time = i * dt;
            double cut = time > contact ? -step * std::expm1(-(time - contact) / lag) : 0;
            for (int part = 0; tooth > 0 && part < 10; ++part) {
                const double now = time + (part - 9) * dt / 10, turned = now / tooth + phase;
                const bool cuts = now > contact && turned - std::floor(turned) < 0.4;
                cut = milled += (cuts * step / 0.4 - milled) * -std::expm1(-dt / 10 / lag);
            }
            const double on = time - contact + coolant_before;
            const double other = !(on > 0) ? 0 : filtered ? -coolant * std::expm1(-on / lag) : coolant;
            const double load = drive.step(5 + cut + other, hold, dt, [&](double sample, double) {
                const double noisy = noise > 0 ? sample + noise * random.gaussian() : sample;
                return quantum > 0 ? std::round(noisy / quantum) * quantum : noisy;
            });
            if (!started && time > contact + late) {
                started = true;
                onset.start(time_constant);
            }
            const bool recording = time < contact + std::min(ends_after, late + ContactOnset::after);
            periods += !recording;
            done = onset.step(time < contact + ends_after, load, -feed * time, dt);
        }
        EXPECT_TRUE(done);
        EXPECT_FALSE(onset.busy());
        if (onset.found()) {
            EXPECT_NEAR(onset.coordinate(), -feed * (time - onset.ago()), 1e-9);
        }
        return time - onset.ago() - contact;
    }
};

struct Scatter {
    double rms = 0;    // s
    double sigma = 0;  // s, by the fits
};
Scatter scatter_of_pairs(Approach& approach, int pairs, double lower) {
    Scatter s;
    const double step = approach.step;
    for (int i = 0; i < pairs; ++i) {
        approach.step = step;
        const double reference = approach.fit();
        const double sigma = approach.onset.sigma();
        approach.step = lower * step;
        const double contact = approach.fit(approach.onset.time_constant());
        s.rms += std::pow(contact - reference, 2) / pairs;
        s.sigma += (std::pow(sigma, 2) + std::pow(approach.onset.sigma(), 2)) / pairs;
    }
    approach.step = step;
    return {std::sqrt(s.rms), std::sqrt(s.sigma)};
}

TEST(ContactOnset, IsExactWithoutNoise) {
    for (const double dt : {0.0006, 0.001, 0.002, 0.004})
        for (const double lag : {0.005, 0.03, 0.1}) {
            Approach approach;
            approach.dt = dt;
            approach.lag = lag;
            for (int i = 0; i < 10; ++i) {
                EXPECT_NEAR(approach.fit(lag), 0, 1e-3 * us) << dt << ' ' << lag;
                EXPECT_TRUE(approach.onset.found());
            }
        }
}

TEST(ContactOnset, FindsTheTimeConstantThatItIsNotGiven) {
    for (const double lag : {0.004, 0.01, 0.03, 0.08}) {
        Approach approach;
        approach.lag = lag;
        const double error = approach.fit();
        EXPECT_NEAR(approach.onset.time_constant(), lag, 0.05 * lag);
        EXPECT_NEAR(error, 0, 0.05 * lag);
    }
}

TEST(ContactOnset, DoesNotDependOnTheLoadForAnyTimeConstant) {
    for (const double given : {0.01, 0.03, 0.09}) {
        Approach usual, soft;
        usual.lag = soft.lag = given * 1.09;  // which is too little to be seen
        soft.step = 0.5 * usual.step;
        EXPECT_NEAR(soft.fit(given), usual.fit(given), 1e-3 * us);
    }
}

TEST(ContactOnset, AClearlyOtherTimeConstantIsFittedAgain) {
    for (const double lag : {0.01, 0.015, 0.02, 0.045, 0.06, 0.09}) {
        Approach approach;
        approach.lag = lag;
        approach.noise = 0.1;
        double error = 0, sigma = 0;
        for (int i = 0; i < 200; ++i) {
            error += std::pow(approach.fit(0.03), 2) / 200;
            sigma += std::pow(approach.onset.sigma(), 2) / 200;
            EXPECT_NEAR(approach.onset.time_constant(), lag, 0.1 * lag);
        }
        EXPECT_LT(std::sqrt(error), 700 * us) << lag << ", which shifts the contact by 20 times that else";
        EXPECT_NEAR(std::sqrt(sigma / error), 1, 0.3) << lag;
    }
}

TEST(ContactOnset, NoiseIsNoOtherTimeConstant) {
    Approach approach;
    approach.noise = 0.5;
    int fitted = 0;
    for (int i = 0; i < 400; ++i) {
        approach.fit(0.03);
        fitted += approach.onset.time_constant() != 0.03;
    }
    EXPECT_LE(fitted, 2);
}

// Coolant comes on before the contact: the load leaves its baseline before it rises as the fit has it.
TEST(ContactOnset, ALoadThatRisesBeforeTheContactHasAKink) {
    for (const double ends : {0.01, 0.02, 0.05})
        for (const double lag : {0.02, 0.03, 0.04}) {
            Approach approach;
            approach.lag = lag;
            approach.noise = 0.1;
            double clean2 = 0, least = 1;
            for (int i = 0; i < 50; ++i) {
                approach.coolant = 0;
                approach.fit(lag);
                clean2 += std::pow(approach.onset.kink(), 2) / 50;
                approach.coolant_before = ends;
                approach.coolant = 1;
                approach.fit(lag);
                least = std::min(least, approach.onset.kink());
            }
            EXPECT_LT(std::sqrt(clean2), 200 * us) << lag;
            EXPECT_GT(least, (ends < 0.02 ? 250 : 500) * us) << ends << ' ' << lag;
        }
}

// Coolant comes on, or a dip ends, so shortly before that one step explains the load too, at another moment.
TEST(ContactOnset, OfALoadThatRisesTwiceItFindsWhereTheContactIs) {
    for (const bool known : {false, true})
        for (const double size : {2.0, 4.0, 6.0})
            for (const double ends : {0.025, 0.04, 0.06, 0.09, 0.15}) {
                Approach approach;
                approach.lag = 0.02;
                approach.noise = 0.2;
                approach.coolant = size;
                approach.coolant_before = ends;
                approach.filtered = true;
                int found = 0;
                double error = 0;
                for (int i = 0; i < 40; ++i) {
                    const double fitted = approach.fit(known ? approach.lag : 0);
                    if (approach.onset.shift() == 0) continue;
                    ++found;
                    error += std::pow(fitted + approach.onset.shift(), 2);
                }
                EXPECT_GE(found, 38) << known << ' ' << size << ' ' << ends;
                EXPECT_LT(std::sqrt(error / found), 700 * us) << known << ' ' << size << ' ' << ends;
            }
}

// The load is poor. One step explains it, from the coolant on: the contact would be 90 ms early.
TEST(ContactOnset, ARiseThatIsFarFromTheContactNeedsLessToBeFound) {
    Approach approach;
    approach.lag = 0.02;
    approach.step = 6;
    approach.noise = 0.8;
    approach.quantum = 0.5;
    approach.hold = 0.01;
    approach.coolant = 6;
    approach.coolant_before = 0.09;
    approach.filtered = true;
    int found = 0;
    for (int i = 0; i < 100; ++i) {
        approach.fit();
        found += approach.onset.shift() != 0;
    }
    EXPECT_GE(found, 80);
}

TEST(ContactOnset, AHealthyLoadDoesNotRiseTwice) {
    int found = 0, fits = 0;
    for (const double lag : {0.01, 0.03, 0.08})
        for (const double hold : {0.0, 0.004, 0.012})
            for (const double noise : {0.0, 0.1, 0.5})
                for (const double dt : {0.001, 0.002, 0.004})
                    for (const bool known : {false, true}) {
                        Approach approach;
                        approach.lag = lag;
                        approach.hold = hold;
                        approach.noise = noise;
                        approach.quantum = noise;
                        approach.dt = dt;
                        for (int i = 0; i < 10; ++i, ++fits) {
                            approach.fit(known ? lag : 0);
                            found += approach.onset.shift() != 0;
                        }
                    }
    EXPECT_LE(found, fits / 500) << "of " << fits;
}

TEST(ContactOnset, AnotherFilterIsNoSecondRise) {
    for (const double lag : {0.015, 0.02, 0.045, 0.06}) {
        Approach approach;
        approach.lag = lag;
        approach.noise = 0.1;
        for (int i = 0; i < 40; ++i) {
            approach.fit(0.03);
            EXPECT_EQ(approach.onset.shift(), 0) << lag;
        }
    }
}

TEST(ContactOnset, ScattersAsTheBoundForWhiteNoise) {
    Approach approach;
    approach.noise = 0.3;
    const double one = approach.noise / approach.step * std::sqrt(2 * approach.lag * approach.dt);
    const double bound = one * std::hypot(1, 1 / 0.8);
    const Scatter pairs = scatter_of_pairs(approach, 300, 0.8);
    EXPECT_LT(pairs.rms, 1.2 * bound);
    EXPECT_GT(pairs.rms, 0.85 * bound);
    EXPECT_NEAR(pairs.sigma, pairs.rms, 0.25 * pairs.rms);
}

TEST(ContactOnset, ScattersAsTheBoundForALoadThatIsHeldAndCoarse) {
    Approach approach;
    approach.noise = 0.3;
    approach.hold = 0.008;
    approach.quantum = 0.5;
    const Scatter pairs = scatter_of_pairs(approach, 300, 0.8);
    EXPECT_LT(1000 * feed * pairs.rms, 3.2) << "um; 2.75 in the long run";
    EXPECT_NEAR(pairs.sigma, pairs.rms, 0.25 * pairs.rms);
}

// A tooth that comes late makes the whole rise late. The residuals alone show a third of that.
TEST(ContactOnset, TheTeethOfInterruptedMillingMakeTheContactLessCertain) {
    for (const double tooth : {0.008, 0.02, 0.04}) {
        Approach approach;
        approach.noise = 0.1;
        approach.tooth = tooth;
        const Scatter pairs = scatter_of_pairs(approach, 300, 0.8);
        EXPECT_GT(pairs.sigma, 0.8 * pairs.rms) << tooth;
        EXPECT_LT(pairs.sigma, 1.5 * pairs.rms) << tooth;
    }
}

// Counting each period that a sample is held puts the rise anywhere between two samples: 4.8 um.
TEST(ContactOnset, CountsASampleThatIsHeldOnce) {
    Approach approach;
    approach.lag = 0.01;
    approach.noise = 0.1;
    approach.hold = 0.016;
    const Scatter pairs = scatter_of_pairs(approach, 300, 0.8);
    EXPECT_LT(1000 * feed * pairs.rms, 3) << "um";
    EXPECT_GT(pairs.sigma, 0.9 * pairs.rms);
    EXPECT_LT(pairs.sigma, 2 * pairs.rms);
}

// Some samples are held for a period more than others: each would count twice, at its begin and at its end.
TEST(ContactOnset, CountsASampleOnceThatIsHeldForNoWholeNumberOfPeriods) {
    for (const auto& [hold, most] : {std::pair(0.0099, 2.6), std::pair(0.0159, 4.0)}) {  // s, um
        Approach approach;
        approach.noise = 0.3;
        approach.quantum = 0.1;
        approach.hold = hold;
        const Scatter pairs = scatter_of_pairs(approach, 300, 1);
        EXPECT_LT(1000 * feed * pairs.rms, most) << hold;
        EXPECT_GT(pairs.sigma, 0.85 * pairs.rms) << hold;
        EXPECT_LT(pairs.sigma, 1.4 * pairs.rms) << hold;
    }
}

TEST(ContactOnset, LooksThroughPeriodsShorterThanItHasRoomFor) {
    Approach approach;
    approach.dt = 0.0001;
    approach.noise = 0.3;
    EXPECT_NEAR(approach.fit(0.03), 0, 500 * us);
    approach.noise = 0;
    EXPECT_NEAR(approach.fit(0.03), 0, 50 * us);
}

TEST(ContactOnset, MakesDoWithAnApproachThatEndsEarlyOrBeginsLate) {
    Approach early;
    early.ends_after = 0.06;
    EXPECT_NEAR(early.fit(0.03), 0, 1e-3 * us);
    EXPECT_TRUE(early.onset.found());
    Approach late;
    late.before = 0.02;
    EXPECT_NEAR(late.fit(0.03), 0, 1e-3 * us);
    EXPECT_TRUE(late.onset.found());
}

TEST(ContactOnset, WorksAPieceInEachPeriod) {
    Approach approach;
    approach.fit(0.03);
    EXPECT_GE(approach.periods, 7 * 9) << "passes over 600 samples: four, and the search of a second rise";
    EXPECT_LE(approach.periods, 140);
    approach.fit();
    EXPECT_GE(approach.periods, 24 * 9);
    EXPECT_LE(approach.periods, 420);
}

TEST(ContactOnset, FindsNoneWithoutARiseOrWithoutSamples) {
    Approach flat;
    flat.step = 0;
    for (const double noise : {0.0, 0.3})
        for (int i = 0; i < 20; ++i) {
            flat.noise = noise;
            flat.fit();
            EXPECT_FALSE(flat.onset.found());
        }
    Approach falling;
    falling.step = -8;
    falling.fit();
    EXPECT_FALSE(falling.onset.found());
    ContactOnset onset;
    onset.start(0);
    bool done = false;
    for (int i = 0; i < 100; ++i) done |= onset.step(false, 5, 0, 0.001);
    EXPECT_TRUE(done);
    EXPECT_FALSE(onset.found());
}

TEST(ContactOnset, WhatWasGivenUpLeavesNothing) {
    Approach approach;
    for (int i = 0; i < 900; ++i) approach.onset.step(true, 80, 0, 0.001);
    approach.onset.start(0.03);
    for (int i = 0; i < 50; ++i) approach.onset.step(true, 90, 0, 0.001);
    approach.onset.cancel();
    EXPECT_FALSE(approach.onset.busy());
    EXPECT_NEAR(approach.fit(0.03), 0, 1e-3 * us);
}

}  // namespace
}  // namespace plumb
