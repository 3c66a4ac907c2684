// SPDX-License-Identifier: GPL-2.0-or-later
// What a joint_offset does now, the bad first; axis_offset_test and interlock_test have the others.
#include "hal/status.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

enum { applies = hal::first_own, limited, ramping, nothing };

struct Cause {
    const char* name;
    std::pair<const char*, double> pin;
    int status;
};

int of(hal::Common status) {
    return static_cast<int>(status);
}

// With its offset of 0.02 mm, and these changes.
double status_with(const std::vector<std::pair<const char*, double>>& changes, double seconds) {
    Bench bench;
    bench.command("loadrt joint_offset names=it interlock=no");
    for (const auto& [pin, value] : {std::pair{"min-limit", -100.0},
                                     {"max-limit", 100.0},
                                     {"joint-acceleration", 2000.0},
                                     {"offset-acceleration", 1000.0},
                                     {"homed", 1.0},
                                     {"motion-enabled", 1.0},
                                     {"offset-0", 0.02}})
        bench.set(std::string("it.") + pin, value);
    bench.command("addf it.update servo-thread");
    for (const auto& [pin, value] : changes) bench.set(std::string("it.") + pin, value);
    bench.run(seconds);
    return bench.get("it.status-code");
}

// Each goes before all later ones.
TEST(JointOffsetStatus, NamesTheFirstThatKeepsTheJointFromItsOffset) {
    const Cause causes[] = {
        {"a fault", {"max-rate", -1}, of(hal::Common::fault)},
        {"off", {"enable", 0}, of(hal::Common::off)},
        {"the machine is off", {"motion-enabled", 0}, of(hal::Common::machine_off)},
        {"not homed", {"homed", 0}, of(hal::Common::not_homed)},
        {"max-offset", {"offset-0", 3}, limited},
    };
    std::vector<std::pair<const char*, double>> later;
    for (auto cause = std::rbegin(causes); cause != std::rend(causes); ++cause) {
        later.push_back(cause->pin);
        EXPECT_EQ(status_with({cause->pin}, 20), cause->status) << cause->name;
        EXPECT_EQ(status_with(later, 20), cause->status) << cause->name << " with all later ones";
    }
    EXPECT_EQ(status_with({}, 0.02), ramping);
    EXPECT_EQ(status_with({{"offset-0", 0}}, 1), nothing);
    EXPECT_EQ(status_with({}, 1), applies);
}

TEST(StageStatus, HasNoneThatInterlockGivesAFunction) {
    for (std::int32_t number = -1; number < hal::first_own; ++number)
        EXPECT_FALSE(hal::said_of_stage(static_cast<hal::Common>(number)).sentence &&
                     hal::is_of_service(number))
            << number;
}

}  // namespace
}  // namespace plumb
