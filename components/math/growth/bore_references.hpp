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
        grown_.fill(false);
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
            reference_[value] = last_[value] = at;
        }
        if (passes_[value] == pass) return std::nullopt;
        grown_[value] = passes_[value] > 0;
        change_[value] = grown_[value] ? at - last_[value] : 0;
        passes_[value] = pass;
        last_[value] = at;
        return at - reference_[value];
    }

    // How far a known position is from the last one: as it is, and less the mean change of the other bores at
    // this orientation in this pass, if there are any.
    struct Step {
        double whole = 0;
        std::optional<double> alone;
    };
    Step step(std::size_t value, double at, std::int32_t pass) const noexcept {
        Step step;
        step.whole = at - last_[value];
        double sum = 0;
        int others = 0;
        constexpr std::size_t per_bore = 6;
        for (std::size_t i = value % per_bore; i < last_.size(); i += per_bore) {
            if (i == value || passes_[i] != pass || !grown_[i]) continue;
            sum += change_[i];
            ++others;
        }
        const bool again = passes_[value] == pass;  // the others have not changed since then
        if (again || others > 0) step.alone = step.whole - (again ? 0 : sum / others);
        return step;
    }

private:
    std::array<bool, StopRule::most_values> known_{};
    std::array<bool, StopRule::most_values> grown_{};  // it was known in a pass before
    std::array<double, StopRule::most_values> reference_{}, last_{},
        change_{};                                              // change_: since the pass before
    std::array<std::int32_t, StopRule::most_values> passes_{};  // of the last deviation
};

}  // namespace plumb
