// SPDX-License-Identifier: GPL-2.0-or-later
// Pins that belong together are a class of their own, written exactly as a component is:
//
//     struct Limits : hal::Group {
//         using Group::Group;
//         hal::In<double> max_rate{this, "max-rate", 0.1, "mu/s", "Maximum rate."};
//     };
//
// and a member of the component: `Limits limits{this};`.
#pragma once

#include "hal/owner.hpp"

namespace plumb::hal {

class Group {
public:
    Group(Owner owner) : owner_(owner) {}
    Group(const Group&) = delete;
    Group& operator=(const Group&) = delete;

private:
    friend Owner::Owner(const Group*);
    const Owner owner_;  // valid while the component is built
};

inline Owner::Owner(const Group* group) : Owner(group->owner_) {}

}  // namespace plumb::hal
