// SPDX-License-Identifier: GPL-2.0-or-later
// Contacts in drawn loads of drawn machines: what each fit, and each check of a fit, is worth.
//
//     CONTACT_LOADS=100 build/tests/math_tests --gtest_filter='ContactLoads*'
//
// prints the table of so many machines for each kind of load. CONTACT_SEED=N draws others.
#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/contact_onset.hpp"
#include "components/math/blocks/random.hpp"
#include "components/plants/sample_and_hold.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace plumb {
namespace {

constexpr double um = 1e-3;          // mm
constexpr double harmless = 6 * um;  // of the gate that configs/mill has
constexpr double dt = 0.001;         // s
constexpr double pi = 3.14159265358979;

enum class Upset { none, other_load, teeth, coolant, dip, slow_entry, other_filter };

struct Kind {
    Upset what;
    const char* name;
};
constexpr Kind kinds[]{{Upset::none, "as the reference"},
                       {Upset::other_load, "60 to 140 % of the load"},
                       {Upset::teeth, "teeth"},
                       {Upset::coolant, "coolant comes on"},
                       {Upset::dip, "a dip ends"},
                       {Upset::slow_entry, "a slower entry"},
                       {Upset::other_filter, "another filter"}};

// A drive, a tool and its cut. The load rises as the edge enters, which takes a while, behind two lags.
struct Machine {
    explicit Machine(Random& r)
        : feed(r.uniform(50, 300) / 60),
          lag(0.005 * std::pow(16, r.uniform())),
          second_lag(lag * r.uniform(0, 0.4)),
          entry(r.index(2) == 1 ? r.uniform(0, 0.04) : 0),
          step(2 * std::pow(10, r.uniform())),
          white(r.uniform(0, 0.06) * step),
          flicker(r.uniform(0, 0.03) * step),
          hold(r.index(3) == 0 ? r.uniform(0.002, 0.012) : 0),
          quantum(r.index(3) == 0 ? r.uniform(0.1, 0.5) : 0),
          tooth(60 / r.uniform(1500, 8000) / (2 + r.index(4))),
          runout(r.uniform(0, 0.5)) {}
    double feed, lag, second_lag, entry, step, white, flicker, hold, quantum, tooth, runout;
};

struct Fitted {
    bool found = false;
    double error = 0;  // mm, by which the contact is fitted too high
    Contact contact{};
    double misplaced = 0;  // mm
};

Fitted approach(const Machine& its, Upset upset, double time_constant, Random& r, ContactOnset& onset) {
    const double contact = 1 + dt * r.uniform();
    const double power = upset == Upset::other_load ? its.step * r.uniform(0.6, 1.4) : its.step;
    const double lag = upset == Upset::other_filter ? its.lag * std::exp2(r.uniform(-1, 1)) : its.lag;
    const double entry = upset == Upset::slow_entry ? its.entry + r.uniform(0.02, 0.2) : its.entry;
    const bool other = upset == Upset::coolant || upset == Upset::dip;
    const double on = contact - (other ? r.uniform(0.005, 0.25) : 10);
    const double by = other ? power * r.uniform(0.1, 0.6) : 0;
    const double off = upset == Upset::dip ? on - r.uniform(0.05, 0.3) : 10;
    const double phase = r.uniform(), turn = r.uniform();
    SampleAndHold drive(its.hold * r.uniform());
    double first = 0, second = 0;
    std::array<double, 6> slow{};  // lags of 2 ms to 2 s: together 1/f noise
    constexpr int parts = 5;
    bool done = false, started = false;
    double time = 0, crossed = 0;
    for (int i = 1; !done && time < 4; ++i) {
        for (int part = 1; part <= parts; ++part) {
            time = (i - 1 + static_cast<double>(part) / parts) * dt;
            double cut = power * std::clamp((time - contact) / std::max(entry, 1e-9), 0.0, 1.0);
            if (upset == Upset::teeth) {
                const double turned = time / its.tooth + phase;
                const double heavier = 1 + its.runout * std::sin(2 * pi * (turned / 4 + turn));
                cut *= turned - std::floor(turned) < 0.4 ? heavier / 0.4 : 0;
            }
            if (upset == Upset::coolant && time > on) cut += by;
            if (upset == Upset::dip && time > off && time < on) cut -= by;
            first += (cut - first) * -std::expm1(-dt / parts / lag);
            second = its.second_lag > 0
                         ? second + (first - second) * -std::expm1(-dt / parts / its.second_lag)
                         : first;
        }
        double noise = its.white * r.gaussian(), slowness = 0.002;
        for (double& each : slow) {
            const double kept = std::exp(-dt / slowness);
            each = kept * each + std::sqrt(1 - kept * kept) * r.gaussian();
            noise += its.flicker * each / std::sqrt(6.0);
            slowness *= 4;
        }
        const double load = drive.step(10 + second + noise, its.hold, dt, [&](double sample, double) {
            return its.quantum > 0 ? std::round(sample / its.quantum) * its.quantum : sample;
        });
        // As LoadContact does, which smooths and debounces: late by these times.
        crossed = time > std::min(on, contact) && load > 10 + its.step / 3 ? crossed + dt : 0;
        if (!started && crossed > 0.05) {
            started = true;
            onset.start(time_constant);
        }
        done = onset.step(time < contact + 1, load, -its.feed * time, dt);
    }
    Fitted result;
    if (!done || !onset.found()) return result;
    result.found = true;
    result.error = its.feed * (contact - (time - onset.ago()));
    result.contact.sigma = its.feed * onset.sigma();
    result.contact.kink = its.feed * onset.kink();
    result.contact.time_constant = onset.time_constant();
    result.misplaced = its.feed * onset.shift();
    return result;
}

struct Score {
    int contacts = 0, accepted = 0, within = 0, wrong = 0, machines = 0, poor = 0;
    double squares = 0;

    double rms() const { return std::sqrt(squares / std::max(accepted, 1)) / um; }
    double part(int count) const { return 100.0 * count / std::max(accepted, 1); }
    void print(const char* name) const {
        std::printf(
            "%-26s accepted %5.1f %%, rms %6.2f um, within 2 sigma %5.1f %%, wrong %4.1f %%; under 90 %% "
            "within: "
            "%d of %d machines\n",
            name, 100.0 * accepted / contacts, rms(), part(within), part(wrong), poor, machines);
    }
};

std::uint64_t number(const char* name, std::uint64_t otherwise) {
    const char* given = std::getenv(name);
    return given != nullptr ? std::strtoull(given, nullptr, 10) : otherwise;
}

// A contact is wrong that counts, and lies elsewhere by more than three of its standard deviations and by
// what harms.
TEST(ContactLoads, AreFittedOrRejectedAndKnowTheirUncertainty) {
    const std::uint64_t machines = number("CONTACT_LOADS", 20), seed = number("CONTACT_SEED", 1);
    const auto onset = std::make_unique<ContactOnset>();
    for (const Kind& kind : kinds) {
        Score score;
        const bool teeth = kind.what == Upset::teeth;
        for (std::uint64_t i = 0; i < machines; ++i) {
            Random r(seed + i, 40 + static_cast<std::uint64_t>(kind.what));
            const Machine machine(r);
            const Fitted a = approach(machine, teeth ? Upset::teeth : Upset::none, 0, r, *onset);
            if (!a.found || a.misplaced > harmless || a.contact.sigma > 12 * um)
                continue;  // nothing is learned
            int accepted = 0, within = 0;
            for (int part = 0; part < 20; ++part) {
                const Fitted b = approach(machine, kind.what, a.contact.time_constant, r, *onset);
                ++score.contacts;
                if (!b.found || b.misplaced > harmless || rises_unlike(b.contact, a.contact, 1, harmless))
                    continue;
                const double error = b.error - a.error, sigma = std::hypot(a.contact.sigma, b.contact.sigma);
                ++accepted;
                within += std::abs(error) <= 2 * sigma;
                score.squares += error * error;
                score.wrong += std::abs(error) > std::max(3 * sigma, harmless);
            }
            score.accepted += accepted;
            score.within += within;
            score.machines += accepted > 0;
            score.poor += within < 0.9 * accepted;
        }
        score.print(kind.name);
        const bool usual = kind.what == Upset::none || kind.what == Upset::other_load;
        const bool other_rise =
            kind.what == Upset::coolant || kind.what == Upset::dip || kind.what == Upset::slow_entry;
        EXPECT_GE(score.accepted, (usual || teeth ? 0.95 : 0) * score.contacts) << kind.name;
        EXPECT_LE(score.accepted, (other_rise ? 0.6 : 1) * score.contacts) << kind.name;
        if (usual || teeth) {
            EXPECT_GE(score.within, (teeth ? 0.85 : 0.9) * score.accepted) << kind.name;
            EXPECT_LE(score.wrong, (teeth ? 0.05 : 0.02) * score.accepted) << kind.name;
        }
    }
}

}  // namespace
}  // namespace plumb
