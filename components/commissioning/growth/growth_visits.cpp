// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_visits.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "components/math/blocks/pseudo_inverse.hpp"
#include "components/math/growth/bore_centre.hpp"
#include "components/math/growth/sphere_centre.hpp"

namespace plumb::commissioning {

using Eigen::Vector3d;

std::vector<GrowthVisit> growth_visits(const GrowthLog& log) {
    std::vector<GrowthVisit> visits;
    std::vector<const GrowthRecord*> touches;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::touch) {
            if (!touches.empty() && touches.front()->visit != r.visit) touches.clear();
            touches.push_back(&r);
        }
        if (r.kind != GrowthRecord::event || r.item != 10) continue;
        GrowthVisit visit;
        visit.pass = r.pass;
        visit.bore = r.bore;
        visit.turned = r.turned;
        visit.compensated = r.compensated;
        visit.cooled = r.cooled;
        const auto named = log.bores.find(r.bore);
        const bool is_sphere = named != log.bores.end() && named->second.sphere;
        BoreTouches circle;
        SphereTouches sphere;
        Vector3d offset = Vector3d::Zero();
        double face = 0, count = 0, faces = 0;
        for (const GrowthRecord* t : touches) {
            if (t->visit != r.visit) continue;
            const Vector3d c = Vector3d(t->offset[0], t->offset[1], t->offset[2]) * log.millimetres;
            const Vector3d p = Vector3d(t->at[0], t->at[1], t->at[2]) * log.millimetres - c;
            offset += c;
            visit.time += t->time;
            ++count;
            if (is_sphere) {
                sphere.add(p);
            } else if (std::abs(t->item) == 3) {
                face += p.z();
                ++faces;
            } else {
                circle.add(p.x(), p.y());
            }
        }
        touches.clear();
        if (count == 0) continue;
        visit.time /= count;
        visit.compensation = offset / count;
        if (const auto centre = sphere.centre()) {
            visit.place = centre->place;
            visit.diameter = centre->diameter(log.ball);
            visit.scatter = centre->scatter;
            visit.checked = sphere.count() > 4;
        }
        if (const auto centre = circle.centre()) {
            visit.place.head<2>() = Eigen::Vector2d(centre->x, centre->y);
            visit.diameter = centre->bore_diameter(log.ball);
            visit.scatter = centre->scatter;
            visit.checked = circle.count() > 3;
        }
        if (faces > 0) visit.place.z() = face / faces;
        visits.push_back(visit);
    }
    return visits;
}

namespace {

// The common slope of y over t, in several groups with a constant each; not a number if none has two times.
class CommonSlope {
public:
    void add(int group, double t, double y) {
        if (std::isfinite(y)) groups_[group].emplace_back(t, y);
    }
    double value() const {
        double ty = 0, tt = 0;
        for (const auto& [group, values] : groups_) {
            double mean_t = 0, mean_y = 0;
            const auto count = static_cast<double>(values.size());
            for (const auto& [t, y] : values) mean_t += t / count, mean_y += y / count;
            for (const auto& [t, y] : values)
                ty += (t - mean_t) * (y - mean_y), tt += (t - mean_t) * (t - mean_t);
        }
        return tt > 1 ? ty / tt : GrowthVisit::none;
    }

private:
    std::map<int, std::vector<std::pair<double, double>>> groups_;
};

using Visits = std::vector<GrowthVisit>;

// How the position at which a bore is found changes within a pass: that is the same in both states. By all
// bores that were visited more than once at an orientation.
double drift_rate(const Visits& visits, std::size_t begin, std::size_t end, int axis) {
    CommonSlope slope;
    for (std::size_t i = begin; i < end; ++i) {
        const GrowthVisit& visit = visits[i];
        slope.add(2 * visit.bore + (visit.turned ? 1 : 0), visit.time,
                  visit.place[axis] + visit.compensation[axis]);
    }
    const double rate = slope.value();
    return std::isfinite(rate) ? rate : 0;
}

// How the compensation of a state changes within a pass: by bores that were visited more than once in it, at
// the beginning and at the end of it; else by all, if it depends on the place of an axis evenly.
double compensation_rate(const Visits& visits, std::size_t begin, std::size_t end, bool state, int axis) {
    CommonSlope slope;
    std::vector<const GrowthVisit*> its;
    std::map<GrowthVisit::Key, std::pair<double, double>> spans;
    double span = 0;
    for (std::size_t i = begin; i < end; ++i) {
        const GrowthVisit& visit = visits[i];
        if (visit.compensated != state) continue;
        its.push_back(&visit);
        slope.add(2 * visit.bore + (visit.turned ? 1 : 0), visit.time, visit.compensation[axis]);
        const auto found = spans.try_emplace(visit.key(), visit.time, visit.time).first;
        found->second.second = visit.time;
        span = std::max(span, found->second.second - found->second.first);
    }
    if (its.size() < 2) return 0;
    const double all = its.back()->time - its.front()->time;
    if (span >= all / 2) return slope.value();
    Eigen::MatrixXd terms(static_cast<Eigen::Index>(its.size()), 3);
    Eigen::VectorXd values(terms.rows());
    for (Eigen::Index i = 0; i < terms.rows(); ++i) {
        const GrowthVisit& visit = *its[static_cast<std::size_t>(i)];
        const double from = visit.place[axis] - its.front()->place[axis];
        terms.row(i) << 1, (visit.time - its.front()->time) / std::max(all, 1.0),
            std::isfinite(from) ? from / 100 : 0;
        values[i] = visit.compensation[axis];
    }
    return pseudo_inverse(terms).row(1).dot(values) / std::max(all, 1.0);
}

}  // namespace

std::vector<GrowthVisit> visits_at_one_time(const std::vector<GrowthVisit>& visits) {
    std::vector<GrowthVisit> result;
    for (std::size_t begin = 0; begin < visits.size();) {
        std::size_t end = begin;
        while (end < visits.size() && visits[end].pass == visits[begin].pass) ++end;
        const double time = (visits[begin].time + visits[end - 1].time) / 2;
        Vector3d drift, compensation[2];
        for (int axis = 0; axis < 3; ++axis) {
            drift[axis] = drift_rate(visits, begin, end, axis);
            for (const bool state : {false, true})
                compensation[state][axis] = compensation_rate(visits, begin, end, state, axis);
        }
        std::map<GrowthVisit::Key, std::pair<GrowthVisit, int>> merged;
        for (std::size_t i = begin; i < end; ++i) {
            GrowthVisit visit = visits[i];
            const Vector3d& rate = compensation[visit.compensated];
            visit.place -= (drift - rate) * (visit.time - time);
            visit.compensation -= rate * (visit.time - time);
            visit.time = time;
            const auto [it, fresh] = merged.try_emplace(visit.key(), visit, 1);
            if (fresh) continue;
            auto& [kept, count] = it->second;
            kept.place = (kept.place * count + visit.place) / (count + 1);
            kept.compensation = (kept.compensation * count + visit.compensation) / (count + 1);
            ++count;
        }
        for (const auto& [key, visit] : merged) result.push_back(visit.first);
        begin = end;
    }
    return result;
}

}  // namespace plumb::commissioning
