// SPDX-License-Identifier: GPL-2.0-or-later
// squareness on the servo thread, at rest or on a path.
#pragma once

#include "components/math/blocks/pi.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/rigid_machine.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace plumb {

constexpr double urad = 1e-6;
constexpr double arcsec = pi / 180 / 3600;
constexpr const char* column_chain = "chain=w-Z.b-X-Y-C-t";
constexpr const char* portal_chain = "chain=w-X.b-W-Y-Z-C-t";

struct Square {
    using Values = std::map<std::string, double>;

    // Homed and enabled; max-rate is 10 mu/s, so that a test need not wait.
    explicit Square(const std::string& options, const client::Start& start = {})
        : axes(linear_axes(options)), bench(Bench::Thread::servo, start) {
        bench.command("loadrt squareness names=square interlock=no " + options);
        bench.command("addf square.update servo-thread");
        set({{"all-homed", 1}, {"enable", 1}, {"max-correction", 5}, {"max-rate", 10}, {"max-speed", 1000}});
    }

    void set(const std::string& pin, double value) { bench.set("square." + pin, value); }
    void set(const Values& values) {
        for (const auto& [pin, value] : values) set(pin, value);
    }
    double get(const std::string& pin) { return bench.get("square." + pin); }
    Vec get_xyz(const std::string& pin) { return {get("x-" + pin), get("y-" + pin), get("z-" + pin)}; }

    // The tool from the gauge point to its tip.
    void set_tool(const Vec& tool) {
        set({{"x-tool-offset", -tool.x}, {"y-tool-offset", -tool.y}, {"z-tool-offset", -tool.z}});
    }
    // As if it had been there always: waits for the rest of a ramp.
    void go(const Position& q) {
        for (std::size_t i = 0; i < axes.size(); ++i) set(axes[i] + "-position", q[i]);
        run(0.002);
        for (int n = 0; n < 100 && get("ramping"); ++n) run(0.05);
        EXPECT_FALSE(get("ramping"));
    }
    Position corrected(Position q) {
        const Vec c = get_xyz("correction");
        return {q[0] + c.x, q[1] + c.y, q[2] + c.z, q[3]};
    }
    void run(double seconds) { bench.run(seconds); }

    // Nothing moves faster than this from now on, as a vector.
    void never_faster_than(double rate) {
        bench.expect(
            "x_rate * x_rate + y_rate * y_rate + z_rate * z_rate <= 1.00001 * " + std::to_string(rate * rate),
            {{"x", "square.x-correction"}, {"y", "square.y-correction"}, {"z", "square.z-correction"}});
    }

    // Moves along a path from now on: position and velocity at a time in seconds.
    struct Moving {
        Position position, velocity;
    };
    void follow(const std::function<Moving(double)>& path, double seconds) {
        std::string text = "time";
        for (const std::string& axis : axes)
            text += ",square." + axis + "-position,square." + axis + "-velocity";
        text += '\n';
        char number[40];
        for (int n = 0; n <= seconds * 1000 + 0.5; ++n) {
            const Moving at = path(n * 0.001);
            text += std::to_string(n * 0.001);
            for (std::size_t i = 0; i < axes.size(); ++i)
                for (const double value : {at.position[i], at.velocity[i]}) {
                    std::snprintf(number, sizeof number, ",%.17g", value);
                    text += number;
                }
            text += '\n';
        }
        bench.client().replay({folder.write("path.csv", text)});
    }

    // Of the chain in these options.
    static std::vector<std::string> linear_axes(const std::string& options) {
        const std::size_t begin = options.find("chain="), end = options.find(' ', begin);
        const std::string chain = begin == std::string::npos ? "" : options.substr(begin, end - begin);
        std::vector<std::string> result{"x", "y", "z"};
        for (const char* letter : {"u", "v", "w"})
            if (chain.find(static_cast<char>(std::toupper(*letter))) != std::string::npos)
                result.emplace_back(letter);
        return result;
    }

    const std::vector<std::string> axes;
    Folder folder;
    Bench bench;
};

// The most that a recorded velocity differs from the derivative of a recorded position, of fourth order.
inline double worst_velocity(const Table& table, const std::string& position, const std::string& velocity) {
    const std::vector<double> p = table.column(position), v = table.column(velocity);
    double worst = 0;
    for (std::size_t i = 4; i + 2 < p.size(); ++i) {
        const double derivative = (8 * (p[i + 1] - p[i - 1]) - (p[i + 2] - p[i - 2])) / (12 * 0.001);
        worst = std::max(worst, std::abs(v[i] - derivative));
    }
    return worst;
}

}  // namespace plumb
