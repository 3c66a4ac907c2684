// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/guest_offset.hpp"
#include "components/math/blocks/offset_shares.hpp"

#include <cmath>

namespace plumb {

// The own part and the guest's part of LinuxCNC's external offset of an axis: of the offset that LinuxCNC is
// asked for, and of the one in force. Invariant:
//
//     own + guest = asked
class OffsetLedger {
public:
    // LinuxCNC has forgotten all offsets.
    void forget() noexcept {
        guest_.forget();
        shares_.forget();
        own_ = 0;
    }

    // The offset in force. `own_step` is the largest change of the own part in a period, `grain` the step of
    // a count.
    void divide(double in_force, double own_step, double grain) noexcept {
        shares_.divide(in_force, {own_, guest_.request(), guest_.held()}, own_step, grain);
    }

    // The guest, see GuestOffset.
    void listen(const GuestOffset::Given& given, bool takes) noexcept {
        guest_.listen(given, takes, shares_.guest());
    }

    // LinuxCNC is asked for something else than was sent. The guest keeps its part if that leaves an own part
    // within ±limit; it has none if all was cleared.
    void take_stock(double asked, double in_force, double limit, double grain) noexcept {
        const bool cleared = std::abs(asked) <= grain / 2 && std::abs(in_force) <= grain / 2;
        if (cleared) guest_.correct(0);
        own_ = asked - guest_.request();
        if (guest_.request() != 0 && std::abs(own_) > limit) {
            own_ = bounded(own_, limit);
            guest_.correct(asked - own_);
        }
        shares_.correct(guest_.request());
    }

    // Moves the own part towards its target, unless it is ahead of the one in force by more than `lag`.
    void approach(double target, double step, double lag) noexcept {
        const bool ahead =
            std::abs(own_ - shares_.own()) > lag && (target - own_) * (shares_.own() - own_) <= 0;
        if (!ahead) own_ += bounded(target - own_, step);
    }

    double asked() const noexcept { return own_ + guest_.request(); }
    double own() const noexcept { return own_; }
    const GuestOffset& guest() const noexcept { return guest_; }
    double own_in_force() const noexcept { return shares_.own(); }
    double guest_in_force() const noexcept { return shares_.guest(); }

private:
    double own_ = 0;
    GuestOffset guest_;
    OffsetShares shares_;
};

}  // namespace plumb
