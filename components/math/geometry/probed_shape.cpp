// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/probed_shape.hpp"

#include "components/math/blocks/least_squares.hpp"
#include "components/math/blocks/pi.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace plumb {
namespace {

class ProbedShapeFit {
public:
    explicit ProbedShapeFit(const ProbedShape& shape) : shape_(shape) {
        if (!(shape.uncertainty > 0)) refuse("the uncertainty of a point is not more than 0");
        if (shape.points.empty()) refuse(too_few);
        const Eigen::Vector2d origin = shape.points.front().place;  // far from that of the machine
        std::map<Setup, std::vector<Eigen::Vector2d>> places;
        for (ProbedShape::Point& point : shape_.points) {
            point.place -= origin;
            places[key(point.turned)].push_back(point.place);
        }
        turned_ = places.size() > 1;
        own_open_ = shape.object == MeasuredObject::artifact && (turned_ || shape.own_uncertainty);
        for (const auto& [setup, its] : places) {
            if (shape.ring) {
                add_circle(setup, its);
            } else {
                pose_[setup] = add(0);
            }
        }
        if (shape.ring && own_open_) ovality_ = {add(0), add(0)};
        for (const ProbedShape::Point& point : shape_.points) {
            if (shape.ring) continue;
            const Eigen::Vector2d n = direction_of(point.normal);
            const auto [at, is_new] = distance_.try_emplace({key(point.turned), key(point.normal)}, 0);
            if (is_new) at->second = add(n.dot(point.place));
            if (own_open_ && !own_.count(key(point.normal - point.turned)))
                own_[key(point.normal - point.turned)] = add(0);
        }
    }

    ProbedCorner fitted() const {
        Eigen::VectorXd p =
            Eigen::Map<const Eigen::VectorXd>(start_.data(), static_cast<Eigen::Index>(start_.size()));
        double ratio = 0;
        for (int i = 0; i < 12; ++i) {
            const auto solution = step(p, 1);
            if (!solution) refuse(too_few);
            p += solution->parameters;
            ratio = solution->ratio;
            if (solution->parameters.cwiseAbs().maxCoeff() < settled) break;
        }
        const auto last = step(p, std::max(1.0, ratio));
        ProbedCorner result;
        const double variance = last->covariance(opening, opening);
        result.corner = {shape_.a, shape_.b, p[opening], std::sqrt(variance), ratio, 0};
        if (own_open_ && !turned_) {
            const auto of_points = step(p, std::max(1.0, ratio), 1e-12);
            result.corner.own = std::sqrt(std::max(0.0, variance - of_points->covariance(opening, opening)));
        }
        for (std::size_t i = 0; i < shape_.points.size(); ++i) {
            const double far = distance(p, shape_.points[i]);
            if (std::abs(far) <= std::abs(result.distance)) continue;
            result.worst = i;
            result.distance = far;
        }
        if (!(ratio < worst_ratio) || !(std::abs(p[opening]) < 0.1)) throw ProbedMisfit(result);
        return result;
    }

private:
    static constexpr double any_face = 1e-3;    // rad
    static constexpr double any_ovality = 0.1;  // mm
    static constexpr double any_scales = 1e-4;  // how much two scales differ
    static constexpr double settled = 1e-10;    // mm, rad
    static constexpr double worst_ratio = 20;   // of the scatter to the stated one
    static constexpr Eigen::Index opening = 0, scales = 1;

    using Setup = long;  // by the angle of the turn
    using Face = long;   // by the angle of the normal

    [[noreturn]] static void refuse(const std::string& why) { throw std::invalid_argument(why); }

    // The same for angles that differ by whole turns.
    static long key(double angle) {
        const long steps = std::lround(angle * 180 / pi * 1e4) % 3600000;
        return steps < 0 ? steps + 3600000 : steps;
    }

    static Eigen::Vector2d direction_of(double angle) { return {std::cos(angle), std::sin(angle)}; }

    Eigen::Index add(double value) {
        start_.push_back(value);
        return static_cast<Eigen::Index>(start_.size()) - 1;
    }

    void add_circle(Setup setup, const std::vector<Eigen::Vector2d>& places) {
        Eigen::Vector2d centre = Eigen::Vector2d::Zero();
        for (const Eigen::Vector2d& place : places) centre += place / static_cast<double>(places.size());
        LeastSquares circle(3);  // 2 c p + r^2 - c^2 = p^2
        for (const Eigen::Vector2d& place : places) {
            const Eigen::Vector2d p = place - centre;
            circle.observe(Eigen::Vector3d(2 * p.x(), 2 * p.y(), 1), p.squaredNorm(), 1);
        }
        const auto solution = circle.solve();
        if (!solution) refuse(too_few);
        const Eigen::Vector2d from(solution->parameters[0], solution->parameters[1]);
        centre_[setup] = {add(centre.x() + from.x()), add(centre.y() + from.y())};
        radius_[setup] = add(std::sqrt(std::max(0.0, solution->parameters[2] + from.squaredNorm())));
    }

    Eigen::Vector2d drawn(const Eigen::VectorXd& p, const Eigen::Vector2d& place) const {
        const double sign = shape_.object == MeasuredObject::artifact ? 1 : -1;
        const double g = sign * p[opening], k = sign * p[scales];
        return {(1 + k / 2) * place.x() - std::sin(g) * place.y(), (1 - k / 2) * std::cos(g) * place.y()};
    }

    // By how much a point lies outside of the shape, in mm.
    double distance(const Eigen::VectorXd& p, const ProbedShape::Point& point) const {
        const Setup setup = key(point.turned);
        if (shape_.ring) {
            const auto& [x, y] = centre_.at(setup);
            const Eigen::Vector2d from = drawn(p, point.place - Eigen::Vector2d(p[x], p[y]));
            double radius = p[radius_.at(setup)];
            if (own_open_) {
                const double angle = 2 * (std::atan2(from.y(), from.x()) - point.turned);
                radius += p[ovality_[0]] * std::cos(angle) + p[ovality_[1]] * std::sin(angle);
            }
            return from.norm() - radius;
        }
        double normal = point.normal;
        if (own_open_) normal += p[own_.at(key(point.normal - point.turned))];
        const double pose = p[pose_.at(setup)], far = p[distance_.at({setup, key(point.normal)})];
        if (shape_.object == MeasuredObject::artifact)
            return direction_of(normal + pose).dot(drawn(p, point.place)) - far;
        const Eigen::Vector2d cosine_sine = direction_of(pose);  // the part lies turned by it
        const Eigen::Vector2d place(cosine_sine.dot(point.place),
                                    cosine_sine.x() * point.place.y() - cosine_sine.y() * point.place.x());
        return direction_of(normal).dot(drawn(p, place)) - far;
    }

    // With the artifact's own errors, as uncertain as they are or as `own`.
    std::optional<LeastSquares::Solution> step(const Eigen::VectorXd& p, double ratio,
                                               std::optional<double> own = {}) const {
        if (!own) own = shape_.own_uncertainty;
        LeastSquares fit(p.size());
        for (const ProbedShape::Point& point : shape_.points) {
            Eigen::VectorXd slopes(p.size());
            for (Eigen::Index i = 0; i < p.size(); ++i) {
                const Eigen::VectorXd h = 1e-4 * Eigen::VectorXd::Unit(p.size(), i);
                slopes[i] = (distance(p + h, point) - distance(p - h, point)) / 2e-4;
            }
            fit.observe(slopes, -distance(p, point), shape_.uncertainty * ratio);
        }
        fit.know(scales, -p[scales], any_scales);
        for (const auto& [face, i] : own_) fit.know(i, -p[i], own.value_or(any_face));
        if (shape_.ring && own_open_)
            for (const Eigen::Index i : ovality_) fit.know(i, -p[i], own.value_or(any_ovality));
        return fit.solve();
    }

    static constexpr const char* too_few =
        "the points leave the corner open: it takes two points on each of two faces that are neither "
        "parallel "
        "nor at 45 deg to the axes, or five around a ring";

    ProbedShape shape_;
    std::vector<double> start_ = {0, 0};
    bool turned_ = false, own_open_ = false;
    std::map<Setup, Eigen::Index> pose_, radius_;
    std::map<Setup, std::pair<Eigen::Index, Eigen::Index>> centre_;
    std::map<std::pair<Setup, Face>, Eigen::Index> distance_;
    std::map<Face, Eigen::Index> own_;
    std::array<Eigen::Index, 2> ovality_{};
};

}  // namespace

ProbedCorner corner_from_shape(const ProbedShape& shape) {
    return ProbedShapeFit(shape).fitted();
}

}  // namespace plumb
