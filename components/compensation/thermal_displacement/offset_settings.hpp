// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/displacement_law.hpp"
#include "components/math/contact/growth_offset.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// How the offset follows the growth.
struct OffsetSettings : hal::Group {
    using Group::Group;

    struct Values {
        GrowthOffset::Settings offset;
        double time_tolerance = 0;  // s
        double verify_step = 0;     // mu

        // By the time method a change counts as a distance of the feed, too.
        GrowthOffset::Settings at(Method method, double feed) const noexcept {
            GrowthOffset::Settings its = offset;
            if (method == Method::time)
                its.tolerance = std::max(its.tolerance, std::abs(feed) * time_tolerance);
            return its;
        }
    };

    Values read(hal::SettingsReader& setting) noexcept {
        Values s;
        s.offset.tolerance = setting(tolerance);
        s.offset.max_offset = setting(max_offset);
        s.offset.max_rate = setting(max_rate);
        s.time_tolerance = setting(time_tolerance);
        s.verify_step = setting(verify_step);
        return s;
    }

    static constexpr hal::Range steps{-1000, 1000}, lengths{0, 1000}, times{0, 1000}, rates{0, 1};
    hal::In<bool> dry_run{this, "dry-run", false, "Compare and count, but never apply.", hal::must()};
    hal::In<bool> verify{
        this, "verify", false,
        "Displace the offset by verify-step in the next cycle, never for a part that counts.",
        hal::machine()};
    hal::In<double> verify_step{
        this,
        "verify-step",
        0,
        "mu",
        "Displacement that shows which contacts are of the work, at most gate-cap; 0: none.",
        hal::machine(steps)};
    hal::In<bool> constant_in_part{
        this, "constant-in-part", false,
        "The offset changes only at the start of a cycle: an even part, whose error changes.",
        hal::machine()};
    hal::In<double> tolerance{
        this, "tolerance", 0.002, "mu", "Smallest change that is applied.", hal::machine(lengths)};
    hal::In<double> time_tolerance{this,
                                   "time-tolerance",
                                   0,
                                   "s",
                                   "Smallest change that is applied by the time method, as a time.",
                                   hal::expert(times)};
    hal::In<double> max_offset{
        this, "max-offset", 0.15, "mu", "Largest offset either way.", hal::machine(lengths)};
    hal::In<double> max_rate{
        this, "max-rate", 0.01, "mu/s", "Fastest change of the offset.", hal::must(rates)};
    hal::Effects next_cycle{this,      hal::Effect::next_cycle, verify,    verify_step, constant_in_part,
                            tolerance, time_tolerance,          max_offset};
};

}  // namespace plumb
