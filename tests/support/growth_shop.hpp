// SPDX-License-Identifier: GPL-2.0-or-later
// A shop that makes a part every five minutes, as the estimator of the growth sees it: contacts of several
// gauges, and the cuts after them, in steps of a second. The growth is that of two plants of different
// structure, or any function.
#pragma once

#include "components/compensation/thermal_displacement/growth_filter.hpp"
#include "components/math/blocks/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace plumb {

// Growth of a machine, mu, and the speed of its spindle, rpm, at a time in s.
struct GrowthTruth {
    std::function<double(double)> growth, speed;
};

// A drawn machine that grows by about `size`: a spindle against its column, or two states of the spindle
// whose quick one shortens it, and a shop whose air swings.
inline GrowthTruth drawn_growth(std::uint64_t seed, double size, bool two_states, double hours) {
    Random random(seed, 7);
    const auto steps = static_cast<std::size_t>(hours * 3600) + 1;
    auto growth = std::make_shared<std::vector<double>>(), speed = std::make_shared<std::vector<double>>();
    const double tau = random.uniform(240, 1200), rest = random.uniform(2700, 5400);
    const double slow = random.uniform(3600, 10800), share = random.uniform(0.2, 0.5);
    const double exponent = random.uniform(1.5, 1.9), dip = random.uniform(0.1, 0.3);
    const double air = size * random.uniform(0.02, 0.08), turn = random.uniform(900, 1500);
    const double day = size * random.uniform(0.05, 0.15), phase = random.uniform(0, 6.28);
    double spindle = 0, other = 0, n = 0, until = 0;
    for (std::size_t t = 0; t < steps; ++t) {
        if (static_cast<double>(t) >= until) {
            n = random.uniform() < 0.12 && t > 0 ? 0 : random.uniform(2000, 8000);
            until = static_cast<double>(t) + random.uniform(1800, 5400);
        }
        const double heat = size * std::pow(n / 8000, exponent);
        if (two_states) {
            spindle += (1.4 * heat - spindle) / slow;
            other += (-dip * heat - other) / (0.5 * tau);
        } else {
            spindle += (heat - spindle) / (n > 0 ? tau : rest);
            other += (-share * heat - other) / slow;
        }
        const double s = static_cast<double>(t);
        growth->push_back(spindle + other + air * std::sin(6.2832 * s / turn + phase) +
                          day * std::sin(6.2832 * s / 86400 + phase));
        speed->push_back(n);
    }
    const auto at = [steps](const auto& list) {
        return [list, steps](double t) {
            return (*list)[std::min(steps - 1, static_cast<std::size_t>(std::max(t, 0.0)))];
        };
    };
    return {at(growth), at(speed)};
}

// A drawn machine that grows by `size` at its largest: parts of either sign with lags from one minute to two
// and a half hours, coolant that comes and goes, and a walk that nothing explains.
inline GrowthTruth many_lags_growth(std::uint64_t seed, double size, double hours) {
    struct Part {
        double lag, share, exponent, state = 0;
    };
    Random random(seed, 9);
    const auto steps = static_cast<std::size_t>(hours * 3600) + 1;
    auto growth = std::make_shared<std::vector<double>>(), speed = std::make_shared<std::vector<double>>();
    std::array<Part, 3> parts{};
    for (Part& part : parts)
        part = {60 * std::pow(150, random.uniform()), random.uniform(-0.4, 1), random.uniform(1, 2)};
    Part coolant{random.uniform(200, 900), random.uniform(-0.2, 0.1), 0};
    const double walk = random.uniform(0, 0.1) / 60;  // of the size, in a second
    double n = 0, wet = 0, n_until = 0, wet_until = 0, walked = 0, largest = 0;
    for (std::size_t step = 0; step < steps; ++step) {
        const auto t = static_cast<double>(step);
        if (t >= n_until) {
            n = random.uniform() < 0.1 && t > 0 ? 0 : random.uniform(1000, 10000);
            n_until = t + random.uniform(600, 7200);
        }
        if (t >= wet_until) {
            wet = random.index(2);
            wet_until = t + random.uniform(1800, 9000);
        }
        for (Part& part : parts)
            part.state += (part.share * std::pow(n / 8000, part.exponent) - part.state) / part.lag;
        coolant.state += (wet * coolant.share - coolant.state) / coolant.lag;
        walked += walk * random.gaussian();
        const double now = parts[0].state + parts[1].state + parts[2].state + coolant.state + walked;
        growth->push_back(now);
        speed->push_back(n);
        largest = std::max(largest, std::abs(now - growth->front()));
    }
    const double scale = size / std::max(largest, 1e-9);
    const auto at = [steps](const auto& list, double t) {
        return (*list)[std::min(steps - 1, static_cast<std::size_t>(std::max(t, 0.0)))];
    };
    return {[=](double t) { return scale * at(growth, t); }, [=](double t) { return at(speed, t); }};
}

struct GrowthShop {
    struct Gauge {
        std::int32_t tool;
        double sigma;          // mu, of its contacts
        double feed = -1.667;  // mu/s
    };
    // A cut, after its contact.
    struct Cut {
        double time, error, without, sigma;  // s, mu
        bool told, asked, known;
        std::int32_t doubt;
    };

    std::vector<Gauge> gauges{{1, 0.0007}, {1, 0.0007}, {4, 0.0007}};
    double blank = 0.001;      // mu, from part to part
    double interval = 300;     // s
    double part_speed = 5000;  // rpm, in a part
    double between = 10;       // s, between two contacts of a part
    GrowthFilter::Settings settings{};
    // Displacement of the contacts of a gauge beside the growth, mu, and what the cuts see of it.
    std::function<double(double time, std::size_t gauge)> shift = [](double, std::size_t) { return 0.0; };
    std::function<void(double, GrowthFilter&)> every_part = [](double, GrowthFilter&) {};
    std::function<void(double, GrowthFilter&)> after_part = every_part;  // 120 s later: it has ended

    std::vector<Cut> run(const GrowthTruth& truth, double hours, std::uint64_t seed, GrowthFilter& growth) {
        Random random(seed, 11);
        std::vector<double> reference(gauges.size(), 0.0), own(gauges.size(), 0.0);
        std::vector<Cut> cuts;
        double offset = 0, blank_now = 0, zero = 0;
        std::int32_t part = 1;
        for (double t = 1; t < hours * 3600; ++t) {
            const double in_part = std::fmod(t, interval);
            const bool in_cycle =
                in_part >= 20 && in_part < 80 + between * static_cast<double>(gauges.size());
            GrowthFilter::Machine machine;
            machine.speed = in_cycle ? part_speed : truth.speed(t);
            machine.in_cycle = in_cycle;
            if (in_part == 0) {
                ++part;
                blank_now = blank * random.gaussian();
                every_part(t, growth);
            }
            if (in_part == 120) after_part(t, growth);
            const double place = (in_part - 30) / between;
            const auto gauge = static_cast<std::size_t>(std::max(place, 0.0));
            const bool contact =
                in_cycle && place >= 0 && place == std::floor(place) && gauge < gauges.size();
            if (!contact) {
                growth.predict(machine, settings, 1);
                growth.apply(machine, settings, 1);
                if (growth.known()) offset = growth.offset();
                continue;
            }
            growth.predict(machine, settings, 1);
            const double grown = truth.growth(t);
            const double z = grown + blank_now + gauges[gauge].sigma * random.gaussian() + shift(t, gauge);
            const double cut_offset = offset;
            const Doubt doubt = growth.doubt();
            const bool known = growth.known();
            const double sigma =
                std::hypot(growth.sigma(settings), growth.apart(), growth.growth() - cut_offset);
            bool accepted = true;
            if (part <= 1) {
                if (gauge == 0) zero = grown;
                reference[gauge] = z;
                own[gauge] = gauges[gauge].sigma;
                if (gauge == 0) growth.begin_at(0, gauges[gauge].sigma, settings);
                if (gauge + 1 == gauges.size()) growth.renew_gauges();
            } else {
                GrowthFilter::Reading r;
                r.growth = z - reference[gauge];
                r.noise = gauges[gauge].sigma;
                r.reference_sigma = std::hypot(own[gauge], settings.repeatability);
                r.gauge = static_cast<std::int32_t>(gauge);
                r.cycle = part;
                r.feed = gauges[gauge].feed;
                for (std::size_t i = 0; i < gauges.size(); ++i) {
                    if (gauges[i].tool == gauges[gauge].tool)
                        r.of_tool |= std::uint64_t{1} << i;
                    else
                        r.other_tools = true;
                }
                accepted = growth.judge(r, settings) == Rejection::none;
                cuts.push_back({t, cut_offset - (grown - zero), -(grown - zero), sigma, doubt != Doubt::none,
                                growth.shift(settings) != Shift::none, known,
                                static_cast<std::int32_t>(doubt)});
            }
            machine.accepted = accepted;
            growth.apply(machine, settings, 1);
            if (part <= 1) offset = 0;
        }
        return cuts;
    }
};

}  // namespace plumb
