// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "components/compensation/thermal_growth/growth_signals.hpp"
#include "components/math/growth/bore_references.hpp"
#include "components/math/growth/touch_latch.hpp"

#include <cmath>
#include <cstdint>

namespace plumb::growth_test {

// The present or last visit of a bore: its number in the test, the bore, the latched touch, and the reason
// for which the visit does not count.
class BoreVisit {
public:
    std::int32_t number() const noexcept { return number_; }
    std::int32_t bore() const noexcept { return bore_; }  // 0 for none
    Fault fault() const noexcept { return fault_; }
    std::int32_t direction() const noexcept { return latch_.direction(); }

    // A new test begins, or a test goes on after this visit.
    void begin() noexcept { number_ = bore_ = 0; }
    void continue_after(std::int32_t number) noexcept { number_ = number; }

    void open(const Signals& now) noexcept {
        ++number_;
        const double key = now.bore_key;
        bore_ = key >= 0.5 && key < BoreReferences::most_bores + 0.5
                    ? static_cast<std::int32_t>(std::lround(key))
                    : 0;
        fault_ = bore_ == 0       ? Fault::bore
                 : !now.oriented  ? Fault::orientation
                 : !now.confirmed ? Fault::unconfirmed
                                  : Fault::none;
    }

    // One period of the open visit. True if a touch was latched.
    bool step(const Signals& now) noexcept {
        if (now.overtravel) fault_ = Fault::overtravel;
        if (now.measuring.rises) latch_.arm();
        const bool touched = now.measuring.now && !latch_.latched() && latches(now);
        if (now.measuring.falls && !latch_.latched()) fault_ = Fault::probe_miss;
        return touched;
    }

    // By the judgement of its touches; none leaves it good.
    void reject(Fault its) noexcept { fault_ = its; }

private:
    bool latches(const Signals& now) noexcept {
        if (!now.at.good) {
            fault_ = Fault::position;
            return false;
        }
        if (!latch_.step(now.probe.now, now.probe.rises, now.at.velocity)) return false;
        if (latch_.direction() == 0) fault_ = Fault::probe_miss;
        return latch_.direction() != 0;
    }

    std::int32_t number_ = 0, bore_ = 0;
    Fault fault_ = Fault::none;
    TouchLatch latch_;
};

}  // namespace plumb::growth_test
