// SPDX-License-Identifier: GPL-2.0-or-later
// The position of a tool's tip in the work on a machine of rigid bodies: a product of poses, body after
// body.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>

namespace plumb {

// The error motion of an axis: EX, EY, EZ in mm and EA, EB, EC in rad.
struct GuideMotion {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
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

// The rotation by EA, EB, EC; computed when they change.
class Turn {
public:
    const Eigen::Matrix3d& by(const Eigen::Vector3d& angles) noexcept {
        using Eigen::AngleAxisd, Eigen::Vector3d;
        if (angles == angles_) return matrix_;
        angles_ = angles;
        matrix_ = (AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
                   AngleAxisd(angles.x(), Vector3d::UnitX()))
                      .toRotationMatrix();
        return matrix_;
    }

private:
    Eigen::Vector3d angles_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d matrix_ = Eigen::Matrix3d::Identity();
};

// Bodies that carry each other, from the bed on.
template <std::size_t N>
class BodyChain {
public:
    using Bodies = std::array<GuidedBody, N>;

    // The pose of the end that carries the tool (side = 1), or the work (side = -1), which travels the
    // other way. Without `whole_bodies`, a guide that is not parallel to a tilted one below it was shimmed
    // true. `to_bed`: the tilt of a guide on a parallel one was measured against the bed.
    Eigen::Isometry3d end(const Bodies& bodies, bool whole_bodies, bool to_bed, double side) noexcept {
        stand(bodies, whole_bodies, to_bed);
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        for (std::size_t k = 0; k < N; ++k) {
            pose.rotate(onto_guide_[k]);
            pose.translate(side * (bodies[k].travel * Eigen::Vector3d::Unit(bodies[k].direction) +
                                   bodies[k].error.translation));
            pose.rotate(errors_[k].by(bodies[k].error.turn));
            pose.rotate(onto_body_[k]);
        }
        pose.rotate(onto_end_);
        return pose;
    }

private:
    // Computed only when the tilts change, for it costs most.
    void stand(const Bodies& bodies, bool whole_bodies, bool to_bed) noexcept {
        const auto stands_so = [](const GuidedBody& before, const GuidedBody& now) {
            return before.direction == now.direction && before.tilt == now.tilt &&
                   before.end_follows == now.end_follows;
        };
        if (stands_ && whole_bodies == whole_bodies_ && to_bed == to_bed_ &&
            std::equal(bodies_.begin(), bodies_.end(), bodies.begin(), stands_so))
            return;
        stands_ = true;
        bodies_ = bodies;
        whole_bodies_ = whole_bodies;
        to_bed_ = to_bed;
        Eigen::Matrix3d below = Eigen::Matrix3d::Identity();  // how the body below stands
        for (std::size_t k = 0; k < N; ++k) {
            const Eigen::Matrix3d body = stance(k, [](const GuidedBody&) { return true; });
            const Eigen::Matrix3d guide = whole_bodies_ ? body : stance(k, [&](const GuidedBody& other) {
                return other.direction == bodies_[k].direction;
            });
            onto_guide_[k] = below.transpose() * guide;
            onto_body_[k] = guide.transpose() * body;
            below = body;
        }
        onto_end_ =
            below.transpose() * stance(N - 1, [](const GuidedBody& body) { return body.end_follows; });
    }

    // The product of the tilts of the bodies up to k that count.
    template <class Counts>
    Eigen::Matrix3d stance(std::size_t k, Counts counts) noexcept {
        Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
        for (std::size_t i = 0; i <= k; ++i)
            if (counts(bodies_[i]) && !replaced(i, k))
                result = (result * tilts_[i].by(bodies_[i].tilt)).eval();
        return result;
    }

    bool replaced(std::size_t i, std::size_t k) const noexcept {
        for (std::size_t rider = i + 1; to_bed_ && rider <= k; ++rider)
            if (bodies_[rider].direction == bodies_[i].direction) return true;
        return false;
    }

    std::array<Turn, N> tilts_, errors_;
    std::array<Eigen::Matrix3d, N> onto_guide_, onto_body_;
    Eigen::Matrix3d onto_end_;
    Bodies bodies_;  // of the matrices
    bool whole_bodies_ = true, to_bed_ = false, stands_ = false;
};

}  // namespace plumb
