// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/usable.hpp"

#include <array>
#include <cstddef>
#include <numeric>

namespace plumb {

// The sum of N sources.  An invalid source keeps its last good value.
template <std::size_t N>
class SourceSum {
public:
    // Reads each of given[0] to given[N - 1] once.  Whether all lie within ±limit.  With `only` above 0 the
    // others stay as they are, and source number `only`, from 1, is read.
    template <class Row>
    bool read(Row&& given, double limit, std::size_t only = 0) noexcept {
        bool good = true;
        for (std::size_t i = 0; i < N; ++i) {
            const double source = given[i];
            if (only != 0 && i + 1 != only) continue;
            sources_[i] = usable(source, limit, sources_[i]);
            good = good && sources_[i] == source;
        }
        return good;
    }

    void clear() noexcept { sources_ = {}; }

    double operator[](std::size_t i) const noexcept { return sources_[i]; }
    // The sum without a source, by its number from 1; 0: with all.
    double without(std::size_t source) const noexcept {
        return value() - (source != 0 ? sources_[source - 1] : 0);
    }
    double value() const noexcept { return std::accumulate(sources_.begin(), sources_.end(), 0.0); }

private:
    std::array<double, N> sources_{};
};

}  // namespace plumb
