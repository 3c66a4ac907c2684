// SPDX-License-Identifier: GPL-2.0-or-later
// A part program of plunges on a machine that has grown, as thermal_displacement sees it. Simple and exact,
// so that a test can state the right result; the simulated mill of components/plants is not.
#pragma once

#include "components/compensation/thermal_displacement/growth_by_contact.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

namespace plumb {

struct Milling {
    using Sample = GrowthByContact::Sample;
    // Sees the signals of each period and returns the offset that is applied from then on.
    using Control = std::function<double(const Sample&)>;

    struct Cut {
        std::int32_t operation;
        std::int32_t tool;
        double top;           // mm
        double speed = 3000;  // rpm
        double feed = 0;      // mm/s; 0 for that of the program
        double fixture = 0;   // mm, its coordinate system above the first one
    };
    // A deviation from the program, in one of the cuts.
    struct Upset {
        bool air = false;           // no work
        double height = 0;          // mm that the contact comes early: a chip, odd stock, a longer tool
        double feed_override = 1;   // of this plunge
        double hold = 0;            // s of feed hold
        double hold_height = 1;     // mm above the work where it begins
        bool speed_change = false;  // commanded 0.5 mm above the work
        bool abort = false;         // 0.3 mm below the top
        double zero = 0;            // mm by which somebody changes the zero before it, for good
        bool by_program = false;    // the load rises where the program has the contact, wherever Z is
    };

    std::vector<Cut> program{{10, 1, -20}, {20, 2, -40, 4000}, {30, 1, -20}, {30, 1, -25}};
    std::map<int, Upset> upsets{};  // by index of the cut
    MachiningSetup setup{7, 3};
    bool learn = false;
    double growth = 0;       // mm, of the spindle
    double dt = 0.001;       // s
    double unit = 1;         // of length, per mm: 1 / 25.4 for inches
    double feed = 2;         // mm/s
    double step = 8;         // %, load of a cut
    double latency = 0;      // s, age of the load
    double lag = 0.03;       // s, of the drive's filter
    double noise = 0;        // %, standard deviation
    double change_time = 0;  // s that a tool change takes longer than usual

    // In mm, since the program was written: its zero, and the tool lengths that it uses; and where the work
    // is and how long the tools are.
    double zero = 0, table = 0;
    std::map<std::int32_t, double> lengths{}, tips{};
    OriginReason reason = OriginReason::none;  // of a change, while it is given

    // One cycle, and a while of rest after it.
    void cycle(const Control& control) {
        control_ = &control;
        rest(3);
        now_.cycle_running = true;
        now_.cycle_complete = false;
        now_.learn = learn;
        now_.setup = setup;
        rest(0.1);
        bool aborted = false;
        for (int i = 0; i < static_cast<int>(program.size()) && !aborted; ++i)
            aborted = !plunge(program[i], upsets[i]);
        if (!aborted) travel(home, 50, rapid);
        now_.cycle_running = false;
        now_.cycle_complete = !aborted;
        now_.operation = 0;
        rest(1);
        if (aborted) travel(home, 50, rapid);
        now_.learn = false;
        rest(10);
    }

    double offset = 0;  // mm, applied
    bool cutting = false;

private:
    static constexpr double home = 10, work_offset = -250, tool_length = 62.5;  // mm
    static constexpr std::int32_t none = 0, rapid = 1, feeding = 2;

    // False when it was aborted.
    bool plunge(const Cut& cut, const Upset& upset) {
        now_.operation = cut.operation;
        zero += upset.zero;
        fixture_ = cut.fixture;
        by_program_ = upset.by_program;
        const double top = cut.top + fixture_ + zero + lengths[cut.tool];  // as the program has it
        now_.start_height = unit * (top + 2);
        top_ = upset.air ? -1e9 : cut.top + fixture_ + table + tips[cut.tool] + upset.height;
        travel(top + 6, 50, rapid);
        if (cut.speed != now_.speed || cut.tool != now_.tool) {
            now_.tool = cut.tool;
            now_.speed = cut.speed;
            rest(3 + change_time);
        }
        travel(top + 3, 50, rapid);
        now_.feed_override = upset.feed_override;
        const double speed = (cut.feed > 0 ? cut.feed : feed) * upset.feed_override;
        if (upset.hold > 0) {
            travel(top + upset.hold_height, speed, feeding);
            holding_ = true;
            rest(upset.hold);
            holding_ = false;
        }
        if (upset.speed_change) {
            travel(top + 0.5, speed, feeding);
            now_.speed += 100;
        }
        travel(top - 0.3, speed, feeding);
        if (!upset.abort) {
            travel(top - 1, speed, feeding);
            rest(0.3);
            travel(top + 6, 50, rapid);
        }
        now_.feed_override = 1;
        return !upset.abort;
    }

    // As the program leaves it: tool 1 turns.
    static Sample at_rest() {
        Sample s;
        s.tool = 1;
        s.speed = 3000;
        return s;
    }

    void rest(double seconds) {
        for (int i = 0; i < std::lround(seconds / dt); ++i) period(0, none);
    }

    // At a speed in mm/s, ending within a period of the target.
    void travel(double target, double speed, std::int32_t motion) {
        const double way = target - command_;
        const int periods = static_cast<int>(std::lround(std::abs(way) / speed / dt));
        for (int i = 0; i < periods; ++i) period(std::copysign(speed, way), motion);
    }

    void period(double velocity, std::int32_t motion) {
        command_ += velocity * dt;
        const double z = command_ + offset;
        const double depth = top_ - (by_program_ ? command_ : z - growth);
        const double part = velocity != 0 ? depth / (std::abs(velocity) * dt) : depth * 1e9;  // of the period
        const double cut = holding_ ? 0 : step * std::clamp(part, 0.0, 1.0);
        cut_load_ += (cut - cut_load_) * -std::expm1(-dt / lag);
        cutting = depth > 0;
        past_.push_back(4 + now_.speed / 1000 + cut_load_);
        const auto age = static_cast<std::size_t>(std::lround(latency / dt));
        now_.load = past_.size() > age ? past_[past_.size() - 1 - age] : past_.front();
        if (noise > 0) now_.load += std::normal_distribution<double>(0, noise)(generator_);
        now_.enable = true;
        now_.motion = motion;
        now_.velocity = unit * velocity;
        now_.z = unit * z;
        now_.work_offset = unit * (work_offset + fixture_ + zero);
        now_.tool_length = unit * (tool_length + lengths[now_.tool]);
        now_.origin_reason = reason;
        now_.applied_offset = unit * offset;
        offset = (*control_)(now_) / unit;
    }

    const Control* control_ = nullptr;
    Sample now_ = at_rest();
    double command_ = home;  // mm
    double top_ = -1e9;      // mm, where the work begins in this cut
    double cut_load_ = 0;
    bool holding_ = false;  // the feed: no chip is cut
    bool by_program_ = false;
    double fixture_ = 0;  // mm, of the last cut
    std::vector<double> past_{};
    std::mt19937 generator_{1};
};

}  // namespace plumb
