// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_visits.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "components/math/growth/bore_centre.hpp"

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
        BoreTouches circle;
        Vector3d offset = Vector3d::Zero();
        double face = 0, count = 0, faces = 0;
        for (const GrowthRecord* t : touches) {
            if (t->visit != r.visit) continue;
            const Vector3d c = Vector3d(t->offset[0], t->offset[1], t->offset[2]) * log.millimetres;
            const Vector3d p = Vector3d(t->at[0], t->at[1], t->at[2]) * log.millimetres - c;
            offset += c;
            visit.time += t->time;
            ++count;
            if (std::abs(t->item) == 3) {
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

std::vector<GrowthVisit> visits_at_one_time(const std::vector<GrowthVisit>& visits) {
    std::vector<GrowthVisit> result;
    for (std::size_t begin = 0; begin < visits.size();) {
        std::size_t end = begin;
        while (end < visits.size() && visits[end].pass == visits[begin].pass) ++end;
        const double time = (visits[begin].time + visits[end - 1].time) / 2;
        std::map<bool, Vector3d> rates;
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = i + 1; j < end; ++j)
                if (visits[i].key() == visits[j].key() && visits[j].time > visits[i].time)
                    rates[visits[i].compensated] =
                        (visits[j].place - visits[i].place) / (visits[j].time - visits[i].time);
        std::map<GrowthVisit::Key, std::pair<GrowthVisit, int>> merged;
        for (std::size_t i = begin; i < end; ++i) {
            GrowthVisit visit = visits[i];
            const auto rate = rates.find(visit.compensated);
            if (rate != rates.end())
                for (int axis = 0; axis < 3; ++axis)
                    if (std::isfinite(rate->second[axis]))
                        visit.place[axis] -= rate->second[axis] * (visit.time - time);
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
