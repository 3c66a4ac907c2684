// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/machine_layout.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;
using Kind = MachinePart::Kind;

const Vector3d right = Vector3d::UnitX(), back = Vector3d::UnitY(), up = Vector3d::UnitZ();

// Sizes are those of a picture. Z points upward or to a side; a machine whose Z points down is drawn so and
// turned over.
class Layout {
public:
    Layout(const AxisChain& chain, const ViewDirections& directions, MachineFrame frame)
        : chain_(chain), directions_(directions), frame_(frame) {
        turned_over_ = directions.of(2)[2] < 0;
        spindle_ = turned_over_ ? up : directions.of(2);
        stands_ = std::abs(spindle_[2]) > 0.5;
    }

    std::vector<MachinePart> parts() {
        for (const Axis axis : chain_.tool) tool_.push_back(axis);
        put_work();
        put_spindle();
        if (stands_ && portal())
            put_portal();
        else
            put_column();
        put_bed();
        if (turned_over_)
            for (MachinePart& part : parts_) {
                const double low = part.low[2];
                part.low[2] = -part.high[2];
                part.high[2] = -low;
            }
        return parts_;
    }

private:
    Vector3d along(Axis axis) const { return directions_.of(direction(axis)).cwiseAbs(); }
    bool lifts(Axis axis) const { return along(axis)[2] > 0.5; }

    MachinePart& put(const Vector3d& low, const Vector3d& high, Kind kind = Kind::fixed) {
        MachinePart part;
        part.low = low.cwiseMin(high);
        part.high = low.cwiseMax(high);
        part.kind = kind;
        parts_.push_back(part);
        return parts_.back();
    }
    MachinePart& put(const Vector3d& low, const Vector3d& high, Axis axis, bool carries_name = true) {
        MachinePart& part = put(low, high, Kind::axis);
        part.axis = axis;
        part.carries_name = carries_name;
        return part;
    }

    std::size_t slabs() const {  // axes that carry a column
        const auto lift = std::find_if(tool_.begin(), tool_.end(), [&](Axis a) { return lifts(a); });
        return lift == tool_.end() ? 0 : static_cast<std::size_t>(lift - tool_.begin());
    }

    void put_work() {
        double height = 0;
        const double raised = stands_ ? 0.3 : 0.5 * static_cast<double>(slabs()) + 1.1;
        put({-1.4, -1.1, 0}, {1.4, 1.1, raised});
        height = raised;
        double size = 1.9;
        for (const Axis axis : chain_.work) {
            const Vector3d half = Vector3d(size, 0.75 * size, 0) +
                                  (lifts(axis) ? Vector3d::Zero() : Vector3d(0.4 * along(axis)));
            const double thick = lifts(axis) ? 1.0 : 0.5;
            put({-half[0], -half[1], height}, {half[0], half[1], height + thick}, axis);
            height += thick;
            size *= 0.86;
        }
        put({-0.7, -0.55, height}, {0.7, 0.55, height + 0.7}, Kind::work);
        tip_ = stands_
                   ? Vector3d(0, 0, height + 0.9)
                   : Vector3d(0, 0, height + 0.35) + spindle_ * (std::abs(spindle_[0]) > 0.5 ? 0.9 : 0.75);
    }

    void put_spindle() {
        const Vector3d across = Vector3d::Ones() - spindle_.cwiseAbs();
        put(tip_ - 0.1 * across, tip_ + 0.6 * spindle_ + 0.1 * across, Kind::tool);
        double length = 1.3;  // to beyond the table, if it lies beside it
        for (const MachinePart& part : parts_)
            if (!stands_)
                length = std::max(length, std::max(part.low.dot(spindle_), part.high.dot(spindle_)) -
                                              tip_.dot(spindle_) + 0.1);
        end_ = tip_ + length * spindle_;
        put(tip_ + 0.6 * spindle_ - 0.35 * across, end_ + 0.35 * across, Kind::tool);
    }

    // The axis along the rail of a portal: the last horizontal one.
    std::optional<Axis> rail() const {
        for (auto axis = tool_.rbegin(); axis != tool_.rend(); ++axis)
            if (!lifts(*axis)) return *axis;
        return {};
    }

    // The usual one: a rail that lifts, two horizontal axes, or one to the side, and then the spindle lifts.
    bool portal() const {
        if (frame_ == MachineFrame::column || !rail()) return false;
        if (frame_ == MachineFrame::portal) return true;
        if (!lifts(tool_.back())) return false;
        if (lifts(tool_.front())) return true;
        const auto level = std::count_if(tool_.begin(), tool_.end(), [&](Axis a) { return !lifts(a); });
        return level > 1 || along(*rail())[0] > 0.5;
    }

    void put_portal() {
        const Axis rail_axis = *rail();
        const Vector3d h = along(rail_axis), g = h[0] > 0.5 ? back : Vector3d(-right), h_size = 0.6 * h;
        const auto at_rail = std::find(tool_.begin(), tool_.end(), rail_axis);
        double top = end_[2];
        for (auto axis = tool_.end() - 1; axis != at_rail; --axis, top += 1) {
            const double half = 0.45 + 0.12 * static_cast<double>(tool_.end() - 1 - axis);
            put({-half, -half, top}, {half, half, top + 1}, *axis);
        }
        if (at_rail + 1 == tool_.end()) top += 0.4;
        const double middle = std::max(end_[2] + 0.5, (end_[2] + top) / 2);
        const auto block = [&](double from, double to, const Vector3d& half, double low, double high) {
            return std::make_pair(Vector3d(g * from - half + up * low), Vector3d(g * to + half + up * high));
        };
        double at = 0.6 + 0.12 * static_cast<double>(tool_.end() - at_rail - 1);
        std::vector<Axis> feet, lifted;
        const auto saddle = block(at, at + 0.35, h_size * 1.3, middle - 0.7, middle + 0.7);
        put(saddle.first, saddle.second, rail_axis);
        if (at_rail + 1 == tool_.end()) {  // the spindle hangs on the saddle
            const auto neck = block(-0.35, at, h_size * 0.6, end_[2], end_[2] + 0.4);
            put(neck.first, neck.second, rail_axis, false);
        }
        at += 0.35;
        for (auto axis = tool_.begin(); axis != at_rail; ++axis) {
            if (lifts(*axis))
                lifted.push_back(*axis);
            else if (along(*axis).dot(h) > 0.5) {
                const auto plate = block(at, at + 0.3, h_size * 2, middle - 0.6, middle + 0.6);
                put(plate.first, plate.second, *axis);
                at += 0.3;
            } else {
                feet.push_back(*axis);
            }
        }
        const double reach = h[0] > 0.5 ? 3.4 : 2.9, foot = 0.5 * static_cast<double>(feet.size());
        const auto bar = block(at, at + 0.8, h * (reach - 0.4), middle - 0.5, middle + 0.5);
        if (!lifted.empty())
            put(bar.first, bar.second, lifted.back());
        else if (!feet.empty())
            put(bar.first, bar.second, feet.back(), false);
        else
            put(bar.first, bar.second);
        for (const int side : {-1, 1}) {
            const Vector3d place = h * reach * side;
            const auto post = block(at, at + 0.8, 0.4 * h, foot, middle + (lifted.empty() ? 0.5 : 1.5));
            if (feet.empty())
                put(post.first + place, post.second + place);
            else
                put(post.first + place, post.second + place, feet.back(), false);
            for (std::size_t i = 0; i < feet.size(); ++i) {
                const double low = 0.5 * static_cast<double>(i);
                const auto shoe = block(at - 0.7, at + 1.5, 0.5 * h, low, low + 0.5);
                put(shoe.first + place, shoe.second + place, feet[i], side == (h[0] > 0.5 ? 1 : -1));
            }
        }
    }

    void put_column() {
        const std::size_t carried = slabs();
        const bool lift = carried < tool_.size() && lifts(tool_[carried]);
        // From the spindle to the column, toward the back or along the spindle.
        const Vector3d out = stands_ ? back : spindle_, side = stands_ || out[1] != 0 ? right : back;
        double at = 0, top = end_[2], clear = 0, slab = 0;  // beyond the table, and a slab before the column
        for (const MachinePart& part : parts_)
            if (part.kind != Kind::tool) clear = std::max({clear, part.low.dot(out), part.high.dot(out)});
        for (std::size_t i = 0; lift && i < carried; ++i)
            slab = std::max(slab, 0.5 * along(tool_[i]).dot(out.cwiseAbs()));
        clear += slab + 0.1;
        const double outer = std::max(1.5, clear);  // of the arms behind a spindle that stands
        for (std::size_t i = tool_.size(); i-- > (lift ? carried : 0);) {
            const Axis axis = tool_[i];
            const bool first = lift && i == carried;
            if (stands_) {
                const double half = lifts(axis) && !first ? 0.45 : 0.65, high = lifts(axis) ? 0.9 : 0.55;
                const double behind = lifts(axis) && !first ? 0.45 : outer;
                const Vector3d wide = side * half + 0.35 * along(axis).cwiseProduct(side);
                put(-wide - 0.45 * out + up * top, wide + behind * out + up * (top + high), axis);
                top += high;
            } else {
                const bool ram = along(axis).dot(out.cwiseAbs()) > 0.5;
                double thick = ram ? 1.0 : 0.45;
                if (i == (lift ? carried : 0)) thick = std::max(thick, clear - end_.dot(out) - at);
                const Vector3d half =
                    0.5 * (side + up) + (ram ? Vector3d::Zero() : Vector3d(0.4 * along(axis)));
                put(end_ + at * out - half, end_ + (at + thick) * out + half, axis).see_through = hides();
                at += thick;
            }
        }
        if (!stands_ && at == 0) {
            at = std::max(0.3, clear - end_.dot(out));
            put(end_ - 0.5 * (side + up), end_ + at * out + 0.5 * (side + up)).see_through = hides();
        }
        const double low = lift ? 0.5 * static_cast<double>(carried) : 0;
        Vector3d foot = stands_ ? Vector3d(outer * out) : Vector3d(end_ + at * out);
        foot[2] = 0;
        const double head = stands_ ? top + (lift ? 0.9 : 0.5) : end_[2] + 1.3;
        if (stands_ && !lift)  // an arm over the axes, or the spindle
            put(-0.6 * side - 0.45 * out + up * top, 0.6 * side + outer * out + up * (top + 0.5));
        const bool moves = lift && carried > 0;
        const Vector3d a = foot - 0.7 * side + up * low, b = foot + 0.7 * side + 1.0 * out + up * head;
        MachinePart& column = moves ? put(a, b, tool_[carried - 1], false) : put(a, b);
        column.see_through = hides();
        for (std::size_t i = 0; lift && i < carried; ++i) {
            const double height = 0.5 * static_cast<double>(i);
            const Vector3d half = 0.9 * side + 0.5 * along(tool_[i]);
            put(foot - half + up * height, foot + half + 1.1 * out + up * (height + 0.5), tool_[i])
                .see_through = hides();
        }
    }

    // The column stands before the work.
    bool hides() const { return spindle_[1] < -0.5; }

    void put_bed() {
        Vector3d low = parts_.front().low, high = parts_.front().high;
        for (const MachinePart& part : parts_) {
            if (part.low[2] > 0.3) continue;
            low = low.cwiseMin(part.low);
            high = high.cwiseMax(part.high);
        }
        put({low[0] - 0.3, low[1] - 0.3, -0.6}, {high[0] + 0.3, high[1] + 0.3, 0});
    }

    AxisChain chain_;
    ViewDirections directions_;
    MachineFrame frame_;
    bool turned_over_ = false, stands_ = true;
    Vector3d spindle_, tip_, end_;
    std::vector<Axis> tool_;
    std::vector<MachinePart> parts_;
};  // namespace

}  // namespace

std::vector<MachinePart> machine_parts(const AxisChain& chain, const ViewDirections& directions,
                                       MachineFrame frame) {
    return Layout(chain, directions, frame).parts();
}

}  // namespace plumb::commissioning
