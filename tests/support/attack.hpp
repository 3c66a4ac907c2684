// SPDX-License-Identifier: GPL-2.0-or-later
// Attacks live components with faults, toggles and returns of their inputs, and tests the declarations of
// their offsets: bound, rate, acceleration, finite values, return to rest.
#pragma once

#include "hal/manual.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/hal_pins.hpp"
#include "tests/support/live.hpp"
#include "tests/support/module.hpp"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

// The part of a live machine that a sequence plays with: few pins, so that a sequence returns to them.
struct Focus {
    std::vector<std::string> pins;   // inputs of the components
    std::vector<std::size_t> knobs;  // of the machine around them
    bool smooth = false;             // nothing in it may break a declared acceleration
};

// The inputs of a live machine that can be attacked.
struct Attackable {
    std::string pin;
    hal::Type type;
    bool smooth;
    bool echo;  // the answer of LinuxCNC to counts: that it lies within reason is LinuxCNC's business
};
std::vector<Attackable> attackable_inputs(const Live& live);

class Attack {
public:
    Attack(const Live& live, const Focus& focus);

    void set(const std::string& pin, double value);
    void give_back(const std::string& pin);
    void turn(std::size_t knob, double value);
    void run(double seconds);
    // Gives everything back, waits, and looks at the rest.
    void end();

    double own(const std::string& pin) const { return own_.at(pin); }

    // All errors so far.
    std::vector<std::string> complaints();

private:
    struct Watched {
        std::string name, value, counts, scale, guest;    // pins
        std::map<std::string, std::string> beside_guest;  // more of them, by variable
        std::vector<std::string> motion;
        std::string bound, rate, limited, acceleration;  // pins, "" for none
        std::string refusal;        // of a bound below the offset; "" where the offset returns within it
        std::string driven, homed;  // where it may be at once where its axis is
        double slope, bound_in_force, rate_in_force;
    };

    void load_meters();
    void watch(const Live::Part& part, const hal::OffsetInfo& offset);
    void expect(const Watched& watched);
    void follow_settings();
    bool settings_are_whole() const;

    const Live& live_;
    Bench bench_;
    std::map<std::string, Wired> wiring_;
    std::map<std::string, double> own_, given_;  // of the pins in focus; and the values that they were given
    std::vector<Watched> watched_;
    std::vector<std::string> complaints_;
    bool smooth_;
};

}  // namespace plumb
