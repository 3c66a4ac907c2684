// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_visits.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "components/math/growth/bore_centre.hpp"

#include <Eigen/QR>

namespace plumb::commissioning {

using Eigen::Vector3d;

std::vector<GrowthVisit> growth_visits(const GrowthLog& log) {
    std::vector<GrowthVisit> visits;
    std::vector<const GrowthRecord*> touches;
    int part = 0;
    double before = 0;
    bool stopped = false, worked = false, cooling_down = false;
    for (const GrowthRecord& r : log.records) {
        if (r.kind == GrowthRecord::event) {
            stopped |= r.item == 5;
            // Work ends with a cycle; a rest of the cool-down does not.
            if (r.item == 2) cooling_down |= stopped && !worked;
            if (r.item == 3 || r.item == 4) worked = r.item == 4;
        }
        const bool resumed = r.kind == GrowthRecord::event && r.item == 6;
        if (resumed && (r.at[0] != 0 || r.time - before > longest_break)) ++part;
        before = r.time;
        if (r.kind == GrowthRecord::touch) {
            if (!touches.empty() && touches.front()->visit != r.visit) touches.clear();
            touches.push_back(&r);
        }
        if (r.kind != GrowthRecord::event || r.item != 10) continue;
        GrowthVisit visit;
        visit.pass = r.pass;
        visit.part = part;
        visit.bore = r.bore;
        visit.turned = r.turned;
        visit.compensated = r.compensated;
        visit.cooled = r.cooled;
        visit.cooling_down = cooling_down;
        const auto named = log.bores.find(r.bore);
        const bool is_sphere = named != log.bores.end() && named->second.sphere;
        BoreTouches circle;
        SphereTouches sphere;
        Vector3d offset = Vector3d::Zero();
        double face = 0, count = 0, faces = 0;
        std::vector<std::pair<int, Vector3d>> places;
        for (const GrowthRecord* t : touches) {
            if (t->visit != r.visit) continue;
            const Vector3d c = Vector3d(t->offset[0], t->offset[1], t->offset[2]) * log.millimetres;
            const Vector3d p = Vector3d(t->at[0], t->at[1], t->at[2]) * log.millimetres - c;
            offset += c;
            visit.time += t->time;
            ++count;
            places.emplace_back(t->item, p);
            if (is_sphere) {
                sphere.add(p);
            } else if (std::abs(t->item) == 3) {
                face += p.z();
                ++faces;
            } else {
                circle.add(p.head<2>());
            }
        }
        touches.clear();
        if (count == 0) continue;
        visit.time /= count;
        visit.compensation = offset / count;
        if (const auto centre = sphere.centre()) {
            visit.place = centre->place;
            visit.diameter = 2 * centre->radius - log.ball;
            visit.scatter = centre->scatter;
            visit.checked = sphere.count() > 4;
        }
        if (const auto centre = circle.centre()) {
            visit.place.head<2>() = centre->place;
            visit.diameter = 2 * centre->radius + log.ball;
            visit.scatter = centre->scatter;
            visit.checked = circle.count() > 3;
            visit.x_per_touch = centre->per_unit.x();
            visit.y_per_touch = centre->per_unit.y();
            for (const auto& [side, p] : places)
                if (std::abs(side) != 3)
                    visit.rests[side].push_back((p - visit.place).head<2>().norm() - centre->radius);
        }
        if (faces > 0) {
            visit.place.z() = face / faces;
            visit.z_per_touch = 1 / std::sqrt(faces);
            for (const auto& [side, p] : places)
                if (std::abs(side) == 3) visit.rests[side].push_back(p.z() - visit.place.z());
        }
        if (is_sphere)
            visit.x_per_touch = visit.y_per_touch = std::sqrt(0.5), visit.z_per_touch = std::sqrt(1.25);
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

// Visits that follow each other, of one pass, without a break.
std::size_t end_of_pass(const Visits& visits, std::size_t begin) {
    std::size_t end = begin;
    while (end < visits.size() && visits[end].pass == visits[begin].pass &&
           visits[end].part == visits[begin].part)
        ++end;
    return end;
}

// How the position at which a bore is found changes within a pass: that is the same in both states. By all
// bores that were visited more than once at an orientation.
// Not a number if there is none.
double drift_rate(const Visits& visits, std::size_t begin, std::size_t end, int axis) {
    CommonSlope slope;
    for (std::size_t i = begin; i < end; ++i) {
        const GrowthVisit& visit = visits[i];
        slope.add(2 * visit.bore + (visit.turned ? 1 : 0), visit.time,
                  visit.place[axis] + visit.compensation[axis]);
    }
    return slope.value();
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
    return terms.completeOrthogonalDecomposition().solve(values)[1] / std::max(all, 1.0);
}

}  // namespace

std::vector<GrowthVisit> visits_at_one_time(const std::vector<GrowthVisit>& visits) {
    std::vector<GrowthVisit> result;
    for (std::size_t begin = 0; begin < visits.size();) {
        const std::size_t end = end_of_pass(visits, begin);
        const double time = (visits[begin].time + visits[end - 1].time) / 2;
        Vector3d drift, compensation[2];
        for (int axis = 0; axis < 3; ++axis) {
            const double rate = drift_rate(visits, begin, end, axis);
            drift[axis] = std::isfinite(rate) ? rate : 0;
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

TouchRepeats touch_repeats(const std::vector<GrowthVisit>& visits) {
    // Each visit's touches against each other, as a row by direction; and the mean of these rows.
    struct Rows {
        std::vector<double> sum;
        double squares = 0, count = 0,
               loose = 0;  // loose: touches, less the parameters of the circle or face
    };
    std::map<std::pair<GrowthVisit::Key, bool>, Rows> all;
    for (const GrowthVisit& visit : visits)
        for (const bool face : {false, true}) {
            std::vector<double> row;
            for (const auto& [side, rests] : visit.rests)
                if ((std::abs(side) == 3) == face) row.insert(row.end(), rests.begin(), rests.end());
            const double loose = static_cast<double>(row.size()) - (face ? 1 : 3);
            if (loose < 1) continue;
            Rows& its = all[{visit.key(), face}];
            if (its.sum.empty()) its.sum.resize(row.size()), its.loose = loose;
            if (its.sum.size() != row.size()) continue;
            for (std::size_t i = 0; i < row.size(); ++i) its.sum[i] += row[i], its.squares += row[i] * row[i];
            ++its.count;
        }
    TouchRepeats found;
    double squares = 0;
    for (const auto& [key, its] : all) {
        if (its.count < 2) continue;
        squares += its.squares;
        for (const double sum : its.sum) squares -= sum * sum / its.count;
        found.freedom += (its.count - 1) * its.loose;
    }
    if (found.freedom > 0) found.sigma = std::sqrt(std::max(squares, 0.0) / found.freedom);
    return found;
}

DriftInPass drift_in_passes(const std::vector<GrowthVisit>& visits) {
    DriftInPass found;
    for (std::size_t begin = 0; begin < visits.size();) {
        const std::size_t end = end_of_pass(visits, begin);
        const double time = visits[end - 1].time - visits[begin].time;
        for (int axis = 0; axis < 3 && end - begin > 1; ++axis) {
            const double rate = drift_rate(visits, begin, end, axis);
            if (std::isfinite(rate))
                found.largest[axis] = std::max(found.largest[axis], std::abs(rate) * time);
            else if (std::isfinite(visits[begin].place[axis]))
                found.known = false;
        }
        begin = end;
    }
    return found;
}

}  // namespace plumb::commissioning
