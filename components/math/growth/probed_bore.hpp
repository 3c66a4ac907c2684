// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/bore_centre.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace plumb {

// The touches of one visit: those of the circle of a bore, and those of its face. Lengths in mu.
class ProbedBore {
public:
    void clear() noexcept {
        circle_.clear();
        face_ = 0;
        faces_ = 0;
    }

    // A touch in Z, direction 3 or -3, is one of the face.
    void add(std::int32_t direction, double x, double y, double z) noexcept {
        if (std::abs(direction) != 3) {
            circle_.add(x, y);
            return;
        }
        face_low_ = faces_ == 0 ? z : std::min(face_low_, z);
        face_high_ = faces_ == 0 ? z : std::max(face_high_, z);
        face_ += z;
        ++faces_;
    }

    bool has_circle() const noexcept { return circle_.count() > 0; }
    bool has_face() const noexcept { return faces_ > 0; }
    // See BoreTouches.
    std::optional<BoreTouches::Centre> centre() const noexcept { return circle_.centre(); }
    // Mean Z of the face, and the difference of its touches; only if there is one.
    double face() const noexcept { return face_ / faces_; }
    double face_range() const noexcept { return face_high_ - face_low_; }

private:
    BoreTouches circle_;
    double face_ = 0, face_low_ = 0, face_high_ = 0;
    int faces_ = 0;
};

}  // namespace plumb
