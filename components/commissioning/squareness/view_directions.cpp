// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/view_directions.hpp"

#include <Eigen/Geometry>

#include <sstream>
#include <stdexcept>
#include <utility>

namespace plumb::commissioning {
namespace {

constexpr const char* names[3][2] = {{"right", "left"}, {"back", "front"}, {"up", "down"}};

Eigen::Vector3d side(const std::string& name) {
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 2; ++k)
            if (name == names[i][k]) return Eigen::Vector3d::Unit(i) * (k == 0 ? 1 : -1);
    throw std::invalid_argument("there is no direction '" + name +
                                "'; there are right, left, back, front, up and down");
}

std::string name(const Eigen::Vector3d& side) {
    Eigen::Index i = 0;
    side.cwiseAbs().maxCoeff(&i);
    return names[i][side[i] > 0 ? 0 : 1];
}

}  // namespace

ViewDirections::ViewDirections(const std::string& text) {
    for (int i = 0; i < 3; ++i) sides_[static_cast<std::size_t>(i)] = Eigen::Vector3d::Unit(i);
    if (text.empty()) return;
    std::array<Eigen::Vector3d, 3> given;
    given.fill(Eigen::Vector3d::Zero());
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');) {
        if (part.size() < 3 || part[1] != '=' || part[0] < 'X' || part[0] > 'Z')
            throw std::invalid_argument("'" + part + "' is not an axis and its direction, such as X=right");
        Eigen::Vector3d& its = given[static_cast<std::size_t>(part[0] - 'X')];
        if (!its.isZero(0)) throw std::invalid_argument(std::string(1, part[0]) + " is there twice");
        its = side(part.substr(2));
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
        if (given[i].isZero(0) && !given[next].isZero(0)) given[i] = given[next].cross(given[last]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3;
        if (given[i].isZero(0) || given[next].isZero(0))
            throw std::invalid_argument(
                "the directions of two axes are necessary, of two lines, such as "
                "X=right,Z=up");
        if (given[i].dot(given[next]) != 0)
            throw std::invalid_argument(std::string("axes ") + "XYZ"[i] + " and " + "XYZ"[next] +
                                        " cannot point " + name(given[i]) + " and " + name(given[next]) +
                                        ": they are at right angles");
    }
    if (given[0].cross(given[1]).dot(given[2]) < 0)
        throw std::invalid_argument("with X " + name(given[0]) + " and Y " + name(given[1]) + ", Z points " +
                                    name(given[0].cross(given[1])) + ", not " + name(given[2]) +
                                    ": the axes of a machine are right-handed");
    sides_ = given;
}

std::string ViewDirections::text() const {
    return "X=" + name(sides_[0]) + ",Y=" + name(sides_[1]) + ",Z=" + name(sides_[2]);
}

}  // namespace plumb::commissioning
