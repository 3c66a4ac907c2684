// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/stop_rule.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace plumb {

// The positions of the bores in the first pass, from which those of later passes deviate.
class BoreReferences {
public:
    static constexpr std::int32_t most_bores = 16;

    // Number of X of a bore, 1 to most_bores; Y and Z follow.
    static std::size_t value(std::int32_t bore, bool turned) noexcept {
        return (static_cast<std::size_t>(bore - 1) * 2 + (turned ? 1 : 0)) * 3;
    }

    void clear() noexcept {
        known_.fill(false);
        passes_.fill(0);
    }

    bool known(std::size_t value) const noexcept { return known_[value]; }
    double at(std::size_t value) const noexcept { return reference_[value]; }  // only if known

    // The deviation of a finite position. Nothing if the first pass has none, or if this pass has one
    // already: a bore that is probed again in a pass shows the drift within the pass, not that of the
    // machine.
    std::optional<double> deviation(std::size_t value, double at, std::int32_t pass) noexcept {
        if (!known_[value]) {
            if (pass > 1) return std::nullopt;
            known_[value] = true;
            reference_[value] = at;
        }
        if (passes_[value] == pass) return std::nullopt;
        passes_[value] = pass;
        return at - reference_[value];
    }

private:
    std::array<bool, StopRule::most_values> known_{};
    std::array<double, StopRule::most_values> reference_{};
    std::array<std::int32_t, StopRule::most_values> passes_{};  // of the last deviation
};

}  // namespace plumb
