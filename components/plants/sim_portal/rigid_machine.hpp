// SPDX-License-Identifier: GPL-2.0-or-later
// Where a machine of rigid bodies has the tip of its tool in the work: a product of poses, body after body.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>

namespace plumb {

// The error motion of an axis: EX, EY, EZ in mm and EA, EB, EC in rad.
struct GuideMotion {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
};

// A body on its guide.
struct GuidedBody {
    int direction = 0;                               // in which it moves: X, Y, Z
    double travel = 0;                               // mm, from the pivot
    Eigen::Vector3d tilt = Eigen::Vector3d::Zero();  // rad, EA0, EB0, EC0 of its guide
    bool end_follows = true;                         // false: tool or work were shimmed square on it
    GuideMotion error;
};

// Bodies that carry each other, from the bed on.
template <std::size_t N>
class BodyChain {
public:
    // Without `whole_bodies` a guide that is not parallel to a tilted one below it was shimmed true again.
    // `to_bed`: the tilt of a guide on a parallel one was measured against the bed.
    BodyChain(const std::array<GuidedBody, N>& bodies, bool whole_bodies, bool to_bed) noexcept
        : bodies_(bodies), whole_bodies_(whole_bodies), to_bed_(to_bed) {}

    // Of the end, that carries the tool (side = 1), or the work (side = -1), which travels the other way.
    Eigen::Isometry3d end(double side) const noexcept {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        Eigen::Matrix3d below = Eigen::Matrix3d::Identity();  // how the body below stands
        for (std::size_t k = 0; k < N; ++k) {
            const Eigen::Matrix3d body = stance(k, [](const GuidedBody&) { return true; });
            const Eigen::Matrix3d guide = whole_bodies_ ? body : stance(k, [&](const GuidedBody& other) {
                return other.direction == bodies_[k].direction;
            });
            pose.rotate(below.transpose() * guide);
            pose.translate(side * (bodies_[k].travel * Eigen::Vector3d::Unit(bodies_[k].direction) +
                                   bodies_[k].error.shift));
            pose.rotate(turned(bodies_[k].error.turn));
            pose.rotate(guide.transpose() * body);
            below = body;
        }
        pose.rotate(below.transpose() *
                    stance(N - 1, [](const GuidedBody& body) { return body.end_follows; }));
        return pose;
    }

private:
    static Eigen::Matrix3d turned(const Eigen::Vector3d& angles) noexcept {
        using Eigen::AngleAxisd, Eigen::Vector3d;
        return (AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
                AngleAxisd(angles.x(), Vector3d::UnitX()))
            .toRotationMatrix();
    }

    // What the tilts of the bodies up to k make, of those that count.
    template <class Counts>
    Eigen::Matrix3d stance(std::size_t k, Counts counts) const noexcept {
        Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
        for (std::size_t i = 0; i <= k; ++i)
            if (counts(bodies_[i]) && !replaced(i, k)) result = (result * turned(bodies_[i].tilt)).eval();
        return result;
    }

    bool replaced(std::size_t i, std::size_t k) const noexcept {
        for (std::size_t rider = i + 1; to_bed_ && rider <= k; ++rider)
            if (bodies_[rider].direction == bodies_[i].direction) return true;
        return false;
    }

    const std::array<GuidedBody, N>& bodies_;
    const bool whole_bodies_, to_bed_;
};

}  // namespace plumb
