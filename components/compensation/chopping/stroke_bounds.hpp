// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"

namespace plumb {

// Why an axis does less than its stroke asks for. A stroke that began late counts until the axis rests.
class StrokeBounds {
public:
    // The bounds that are active in a period.
    struct Active {
        bool offset = false;  // by its largest value or rate
        bool stage = false, soft_limit = false, learning = false, speed = false, arrival = false;
        bool late = false;  // a plan was not ready at a dead point
        bool infeed_cut = false, infeed_late = false;
    };

    // `runs`: the axis moves.
    void step(const Active& now, bool runs) noexcept {
        late_ = runs && (late_ || now.late);
        bound_ = now.offset        ? Bound::offset
                 : !runs           ? Bound::none
                 : now.stage       ? Bound::stage
                 : now.soft_limit  ? Bound::soft_limit
                 : now.learning    ? Bound::learning
                 : now.speed       ? Bound::speed
                 : late_           ? Bound::plan
                 : now.arrival     ? Bound::arrival
                 : now.infeed_late ? Bound::infeed_late
                 : now.infeed_cut  ? Bound::infeed_cut
                                   : Bound::none;
    }

    Bound bound() const noexcept { return bound_; }
    // A stroke that began late is over.
    bool hinders_infeed() const noexcept {
        return bound_ != Bound::none && bound_ != Bound::plan && bound_ < Bound::infeed_late;
    }

private:
    Bound bound_ = Bound::none;
    bool late_ = false;
};

}  // namespace plumb
