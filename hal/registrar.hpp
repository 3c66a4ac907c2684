// SPDX-License-Identifier: GPL-2.0-or-later
// The builder of a component decides on the meaning of a declaration: the module creates pins and functions
// in HAL, the manual writes them down, a test counts them.
#pragma once

#include "hal/value.hpp"

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace plumb::hal {

class Component;
class Function;

// Values that an input accepts, both ends included, in the unit of the pin; not NaN.
struct Range {
    double least = -std::numeric_limits<double>::infinity();
    double most = std::numeric_limits<double>::infinity();

    bool contains(double value) const noexcept { return value >= least && value <= most; }
};

// Who sets an input: what has a level is a setting. A signal has none: it is netted, or written by a screen
// or program at work.
enum class Level {
    signal,
    must,     // without it the component does not work on this machine
    machine,  // what this machine, its drives and sensors, or the work decide
    expert,   // the default fits nearly all machines
};

constexpr const char* name(Level level) {
    switch (level) {
        case Level::must: return "must";
        case Level::machine: return "machine";
        case Level::expert: return "expert";
        default: return "";
    }
}

// What an input is besides its default: hal::must(), hal::machine(), hal::expert(), each with the range that
// the component accepts; a range alone is that of a signal.
struct Setting {
    Setting(Level which = Level::signal, const Range& accepted = {}) : level(which), range(accepted) {}
    Setting(const Range& accepted) : range(accepted) {}

    Level level = Level::signal;
    Range range;
};
inline Setting must(const Range& range = {}) {
    return {Level::must, range};
}
inline Setting machine(const Range& range = {}) {
    return {Level::machine, range};
}
inline Setting expert(const Range& range = {}) {
    return {Level::expert, range};
}

// Everything that the outside world may know about a pin.
struct PinInfo {
    Type type;
    bool output;
    std::string name;  // without the instance's name
    std::string unit;  // "" for bits and codes
    double initial;    // of a length in mm, also on an inch machine
    std::string doc;   // one sentence
    Setting setting =
        {};  // of an input; its range is in the machine unit, also where the initial value is not
    std::string each_name = {}, each_doc = {};  // of all axes, with % for the letter
    // Of a pin that there is not otherwise, in manuals alone: OPTION=VALUE, OPTION>=NUMBER, or "W in OPTION",
    // several joined by " or ".
    std::string only_with = {};
};

// A value of an option with which the component has other pins. Other options that it needs stand behind it:
// "A chain=w-A-X-Y.b-Z-t".
struct Other {
    Other(const char* text) : value(text) {}
    Other(std::string text, std::string condition)
        : value(std::move(text)), only_with(std::move(condition)) {}

    std::string value;
    std::string only_with = {};  // of its pins; OPTION=VALUE if it is empty
};

// ... and about a load-time option.
struct OptionInfo {
    std::string name;
    std::string initial;
    std::string doc;
    std::vector<Other> others = {};
    bool counts = false;  // it is a hal::Count: the others are its values, the smallest first
};

// ... and about an offset that an output brings into an axis (see hal/offset.hpp): names of pins, without the
// instance's name, "" for none.
struct OffsetInfo {
    std::string value;          // the offset
    std::string counts, scale;  // where it is brought in by counts
    std::string bound, rate, limited, acceleration;
    double times = 1;                 // of the acceleration
    std::string accelerated_by;       // where the output limits no acceleration: one sentence, what does
    std::string guest;                // the part of it for which bound and rate do not hold
    std::vector<std::string> motion;  // positions that it depends on,
    double slope = 0;                 // by so much at most
    std::string driven, homed;        // inputs: false, or a rise, lets it be where its axis is
    std::string turning_rate, turning_acceleration;  // where a turn of motion changes it besides
    std::string follows_while;                       // an output without which it neither follows nor returns
    bool at_next_cycle = false;                      // it begins to follow when a cycle of the program begins
};

// ... and about a pin that holds a code: its sentences, by number.
struct CodesInfo {
    std::string pin;  // without the instance's name
    std::map<std::int32_t, std::string> sentences;
};

// ... and about an input whose sign or state turns the effect of the component round (see hal/turning.hpp).
struct TurningInfo {
    std::string pin;  // without the instance's name
};

// ... and about an input whose write moves an axis, or must not come in a cycle (see hal/effect.hpp).
struct EffectInfo {
    std::string pin;     // without the instance's name
    const char* effect;  // its name
};

// ... and about a bit that is told when it rises (see hal/told.hpp).
struct ToldInfo {
    std::string pin;   // without the instance's name
    const char* tell;  // its name
    std::string sentence;
};

struct StatusInfo;  // hal/status_pins.hpp

class Registrar {
public:
    virtual Slot add(const PinInfo& pin) = 0;
    virtual void add(Function& function) = 0;
    virtual std::string add(const OptionInfo& option) = 0;  // returns the text given for this instance
    virtual void add(const OffsetInfo&) {}
    virtual void add(const CodesInfo&) {}
    virtual void add(const StatusInfo&) {}
    virtual void add(const TurningInfo&) {}
    virtual void add(const EffectInfo&) {}
    virtual void add(const ToldInfo&) {}
    virtual std::string instance() const { return ""; }  // its name; "" where there is none, as in a manual
    virtual double millimetres() const noexcept { return 1; }  // in a machine unit: hal/length_unit.hpp

protected:
    ~Registrar() = default;
};

Registrar& registrar(Component* component);

}  // namespace plumb::hal
