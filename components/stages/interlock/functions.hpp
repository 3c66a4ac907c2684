// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/stages/interlock/services.hpp"
#include "hal/component.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The functions that compensate.
struct Functions : hal::Group {
    static constexpr std::size_t number = 4;

    using Group::Group;

    hal::Row<hal::In<bool>, number> is_on{this, "function-switch", false,
                                          "The operator has switched the function on."};
    hal::Row<hal::In<bool>, number> suspend{this, "function-suspend", false,
                                            "The part program suspends the function."};
    hal::Row<hal::In<std::int32_t>, number> needs{this, "function-services", Services::all,
                                                  "Services that it needs: the sum of 1 for service 0, 2 for "
                                                  "service 1, 4 for service 2 and 8 for service 3."};
    hal::Row<hal::In<bool>, number> settling{this, "function-settling", false,
                                             "The next cut has to wait for the function."};
    hal::Row<hal::In<bool>, number> ramping{this, "function-ramping", false,
                                            "The function is on its way to what is wanted."};

    hal::Row<hal::Out<bool>, number> enable{this, "function-enable", "The function is to compensate."};
    hal::Row<hal::Out<bool>, number> lost{this, "function-lost",
                                          "The function is off because a service was lost; turn its switch "
                                          "off and on, or start a cycle, when the service is ok."};

    // Of one period.
    struct Now {
        bool starts;   // a cycle does
        bool probing;  // enables stay as they are
    };

    // Once in each period.  False where one needs services that there are not; it needs all of them then.
    bool step(const Services& services, const Now& now) noexcept {
        bool good = true;
        any_permitted_ = any_on_ = changed_ = false;
        all_enabled_ = true;
        for (std::size_t i = 0; i < number; ++i) {
            const std::int32_t given = needs[i];
            const bool known = given >= 0 && given <= Services::all;
            good &= known;
            State& its = its_[i];
            const bool on = is_on[i], suspended = suspend[i];
            const bool served = services.are_ok(known ? given : Services::all);
            const bool renews = now.starts || (on && !its.on);
            its.lost = served ? its.lost && !renews : its.lost || its.served;
            its.on = on;
            its.served = served;
            const bool permitted = on && served && !its.lost, before = its.enabled;
            if (!now.probing) its.enabled = permitted && !suspended;

            any_permitted_ |= permitted;
            any_on_ |= on;
            all_enabled_ &= its.enabled == on;
            changed_ |= its.enabled != before;
            enable[i] = its.enabled;
            lost[i] = its.lost;
        }
        return good;
    }

    bool any_permitted() const noexcept { return any_permitted_; }
    bool all_enabled() const noexcept { return any_on_ && all_enabled_; }  // that are switched on
    bool changed() const noexcept { return changed_; }                     // an enable, in this period

private:
    struct State {
        bool on = false, served = false, lost = false, enabled = false;
    };

    std::array<State, number> its_;
    bool any_permitted_ = false, any_on_ = false, all_enabled_ = false, changed_ = false;
};

}  // namespace plumb
