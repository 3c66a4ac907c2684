// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>

namespace plumb::commissioning {

// Where the + ends of X, Y and Z point, as the operator stands before the machine.
class ViewDirections {
public:
    ViewDirections() : ViewDirections("") {}

    // X=right,Y=back,Z=up; an empty text is that. Two of the three are enough. Throws std::invalid_argument.
    explicit ViewDirections(const std::string& text);

    // To the right, to the back, upward.
    const Eigen::Vector3d& of(int direction) const noexcept {
        return sides_[static_cast<std::size_t>(direction)];
    }
    // All three.
    std::string text() const;

private:
    std::array<Eigen::Vector3d, 3> sides_;
};

}  // namespace plumb::commissioning
