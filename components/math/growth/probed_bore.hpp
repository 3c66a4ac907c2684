// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/bore_centre.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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
            if (circle_.add(x, y)) sides_[static_cast<std::size_t>(circle_.count() - 1)] = {x, y, std::abs(direction) == 1};
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
    // How far the touches along X are outside of the circle, less those along Y, in the mean. A touch that is
    // wrong by e changes it by e / 2, the lobes of the probe do not. Only if there is a centre.
    double oval(const BoreTouches::Centre& centre) const noexcept {
        double sum[2]{}, count[2]{};
        for (int i = 0; i < circle_.count(); ++i) {
            const Side& its = sides_[static_cast<std::size_t>(i)];
            sum[its.along_x] += std::hypot(its.x - centre.x, its.y - centre.y) - centre.radius;
            ++count[its.along_x];
        }
        return count[0] > 0 && count[1] > 0 ? sum[1] / count[1] - sum[0] / count[0] : 0;
    }
    // Mean Z of the face, and the difference of its touches; only if there is one.
    double face() const noexcept { return face_ / faces_; }
    double face_range() const noexcept { return face_high_ - face_low_; }

private:
    struct Side {
        double x = 0, y = 0;
        bool along_x = false;
    };

    BoreTouches circle_;
    std::array<Side, BoreTouches::most> sides_{};
    double face_ = 0, face_low_ = 0, face_high_ = 0;
    int faces_ = 0;
};

}  // namespace plumb
