// SPDX-License-Identifier: GPL-2.0-or-later
// The places of functions in a thread, and their order. A function declares its place once; its manual page,
// interlock and `plumb doctor --running` take the order from here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace plumb::hal {

enum class Place : std::uint8_t {
    none,         // anywhere
    feedback,     // takes an offset from the feedback of a drive
    motion,       // LinuxCNC's motion-controller
    source,       // computes offsets
    stage,        // brings them into an axis
    interlock,    // permits them
    measurement,  // reads positions
    program,      // of a simulated machine, as the next two
    machine,
    load,
};

constexpr unsigned bit(Place place) {
    return 1u << static_cast<unsigned>(place);
}

struct PlaceInfo {
    Place place;
    const char* name;    // for programs
    const char* words;   // for people
    unsigned after;      // the places before it, as a sum of bits
    bool in_its_thread;  // in the thread of motion-controller
    bool needed;         // a function that no thread has is a mistake
};

inline constexpr unsigned before_motion = bit(Place::feedback);
inline constexpr unsigned before_sources = before_motion | bit(Place::motion);
inline constexpr unsigned before_stages = before_sources | bit(Place::source);
inline constexpr unsigned before_interlock = before_stages | bit(Place::stage);
inline constexpr unsigned before_machine = bit(Place::program);
inline constexpr unsigned before_load = before_machine | bit(Place::machine);

// In the order of a thread.
inline constexpr PlaceInfo places[] = {
    {Place::none, "none", "", 0, false, false},
    {Place::feedback, "feedback", "the correction of feedback", 0, true, false},
    {Place::motion, "motion", "motion-controller", before_motion, true, false},
    {Place::source, "source", "all sources of offsets", before_sources, false, true},
    {Place::stage, "stage", "all stages", before_stages, true, true},
    {Place::interlock, "interlock", "interlock", before_interlock, true, true},
    {Place::measurement, "measurement", "measurements", before_sources, false, false},
    {Place::program, "program", "the simulated program", 0, false, false},
    {Place::machine, "machine", "the simulated machine", before_machine, false, false},
    {Place::load, "load", "the simulated load", before_load, false, false},
};

constexpr const PlaceInfo& info(Place place) {
    return places[static_cast<unsigned>(place)];
}

constexpr bool goes_before(Place first, Place second) {
    return (info(second).after & bit(first)) != 0;
}

// Whether the table is in the order of the enum, and what is before a place is before all that comes after
// it.
constexpr bool is_an_order() {
    unsigned number = 0;
    for (const PlaceInfo& one : places) {
        if (static_cast<unsigned>(one.place) != number++) return false;
        for (const PlaceInfo& other : places)
            if (goes_before(one.place, other.place) &&
                ((one.after & ~other.after) != 0 || one.place >= other.place))
                return false;
    }
    return true;
}
static_assert(is_an_order());

// That of no name is none.
inline Place place_named(std::string_view name) {
    for (const PlaceInfo& one : places)
        if (name == one.name) return one.place;
    return Place::none;
}

// LinuxCNC's own functions that have a place.
inline Place place_of_linuxcnc(std::string_view function) {
    return function == "motion-controller" ? Place::motion : Place::none;
}

// "After motion-controller, before all stages and interlock."
inline std::string order_of(Place place) {
    const auto list = [](const char* begin, unsigned these) {
        std::string result;
        for (const PlaceInfo& one : places) {
            if ((these & bit(one.place)) == 0) continue;
            these &= ~bit(one.place);
            result += (result.empty() ? begin : these == 0 ? " and " : ", ") + std::string(one.words);
        }
        return result;
    };
    unsigned later = 0;
    for (const PlaceInfo& one : places)
        if (goes_before(place, one.place)) later |= bit(one.place);
    // What comes after motion-controller comes after feedback, and no measurement minds.
    const std::string after = list("After ", info(place).after & ~bit(Place::feedback));
    const std::string before =
        list(after.empty() ? "Before " : ", before ", later & ~bit(Place::measurement));
    if (after.empty() && before.empty()) return "";
    return after + before + (info(place).in_its_thread ? ", in the thread of motion-controller." : ".");
}

}  // namespace plumb::hal
