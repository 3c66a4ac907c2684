// SPDX-License-Identifier: GPL-2.0-or-later
// Each status of centre_height, the bad ones first.
#include "components/compensation/centre_height/height_codes.hpp"

#include <gtest/gtest.h>

#include <set>

namespace plumb {
namespace {

using S = HeightStatus;
using hal::Kind;

TEST(HeightStatus, OnlyAToolOnCentreIsGood) {
    const S service = hal::common<S>(hal::of_service(hal::Common::lost, 4));
    const struct {
        HeightSeen seen;
        S status;
        Kind kind;
    } cases[] = {
        {{State::refused, Detail::air_cut, Verdict::none, service}, S::refused, Kind::bad},
        {{State::measure, Detail::radius, Verdict::none, {}}, S::entry_refused, Kind::bad},
        {{State::idle, Detail::none, Verdict::none, service}, service, Kind::bad},
        {{State::aborted, Detail::none, Verdict::none, {}}, S::interrupted, Kind::warn},
        {{State::known, Detail::none, Verdict::held, {}}, S::held, Kind::warn},
        {{State::known, Detail::none, Verdict::both, {}}, S::off_centre, Kind::warn},
        {{State::known, Detail::none, Verdict::y, {}}, S::y_off_centre, Kind::warn},
        {{State::known, Detail::none, Verdict::x, {}}, S::x_off_centre, Kind::warn},
        {{State::known, Detail::none, Verdict::unsure, {}}, S::unsure, Kind::warn},
        {{State::known, Detail::none, Verdict::unchecked, {}}, S::unchecked, Kind::warn},
        {{State::known, Detail::none, Verdict::none, {}}, S::unsure, Kind::warn},
        {{State::known, Detail::none, Verdict::check, {}}, S::check, Kind::wait},
        {{State::cut, Detail::none, Verdict::none, service}, S::cut, Kind::wait},
        {{State::measure, Detail::none, Verdict::none, service}, S::measure, Kind::wait},
        {{State::idle, Detail::none, Verdict::none, {}}, S::idle, Kind::off},
        {{State::known, Detail::none, Verdict::on_centre, {}}, S::on_centre, Kind::good},
        {{State::known, Detail::none, Verdict::shown, {}}, S::shown, Kind::good},
        {{State::known, Detail::none, Verdict::both, {}, true}, S::table, Kind::warn},
    };
    std::set<S> found;
    for (const auto& each : cases) {
        EXPECT_EQ(status_of(each.seen), each.status) << said(each.status).sentence;
        EXPECT_EQ(said(each.status).kind, each.kind) << said(each.status).sentence;
        found.insert(each.status);
    }
    for (std::int32_t number = hal::first_own; number < 100; ++number)
        if (!hal::is_common(number) && said(static_cast<S>(number)).sentence) {
            EXPECT_EQ(found.count(static_cast<S>(number)), 1u) << number;
        }
}

}  // namespace
}  // namespace plumb
