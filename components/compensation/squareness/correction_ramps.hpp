// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_model.hpp"
#include "components/math/blocks/ramped_correction.hpp"

namespace plumb {

// The corrections of X, Y and Z, as a vector, and of U, V or W: each on its way to the wanted correction.
struct CorrectionRamps {
    RampedCorrection xyz;
    RampedCorrectionOf<1> parallel;

    // `before` is the result at this position with the former settings.
    void step(const SquarenessModel::Result& now, const SquarenessModel::Result& before, double max_rate,
              double dt) noexcept {
        xyz.step(now.wanted, before.wanted, max_rate, dt);
        parallel.step(now.wanted_parallel, before.wanted_parallel, max_rate, dt);
    }
    bool ramping() const noexcept { return xyz.ramping() || parallel.ramping(); }
    bool limited() const noexcept { return xyz.limited() || parallel.limited(); }
};

}  // namespace plumb
