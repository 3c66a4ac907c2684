// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/status.hpp"

#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace plumb::support {

// A change of what is seen, and the status with it and without it.
template <class Seen, class E>
struct Case {
    const char* what;
    std::function<void(Seen&)> change;
    E status;
    hal::Kind kind;
};

// Each case goes before all later ones, and the last one is the status when nothing happens.
template <class Seen, class E>
std::set<E> expect_in_order(const Seen& calm, const std::vector<Case<Seen, E>>& cases) {
    std::set<E> found;
    Seen all_later = calm;
    for (auto each = cases.rbegin(); each != cases.rend(); ++each) {
        SCOPED_TRACE(each->what);
        Seen alone = calm;
        each->change(alone);
        each->change(all_later);
        EXPECT_EQ(status_of(alone), each->status) << "alone";
        EXPECT_EQ(status_of(all_later), each->status) << "with all later ones";
        const hal::Said its = said(each->status);
        EXPECT_EQ(its.kind, each->kind) << its.sentence;
        found.insert(each->status);
    }
    return found;
}

// Each status that the function declares is one of these.
template <class E>
void expect_all(const std::set<E>& found) {
    for (std::int32_t number = hal::first_own; number < 100; ++number) {
        const char* const text = hal::is_common(number) ? nullptr : said(static_cast<E>(number)).sentence;
        if (text) {
            EXPECT_EQ(found.count(static_cast<E>(number)), 1u) << "no case of " << text;
        }
    }
}

// The status of interlock in the words of a function.
template <class E>
E of(hal::Common status) {
    return hal::common<E>(status);
}

}  // namespace plumb::support
