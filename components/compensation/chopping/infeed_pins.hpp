// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/infeed.hpp"
#include "components/compensation/chopping/stroking_axis.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace plumb {

// The pins of the infeed, with infeed=1.
class InfeedPins : hal::Group {
public:
    InfeedPins(hal::Owner owner, std::size_t count, const hal::Out<bool>& limited) : Group(owner) {
        if (count > 0) pins_.emplace(owner, limited);
    }

    Infeed::Settings read() noexcept { return pins_ ? pins_->read() : Infeed::Settings{}; }
    StrokingAxis::InfeedInputs inputs() const noexcept {
        if (!pins_) return {};
        return {pins_->end, pins_->position, pins_->feedback, pins_->applied};
    }
    void show(const Infeed& infeed) noexcept {
        if (!pins_) return;
        pins_->offset = infeed.value();
        pins_->done = infeed.done();
    }

private:
    struct Pins final : hal::Group {
        Pins(hal::Owner owner, const hal::Out<bool>& limited)
            : Group(owner),
              moves{this, hal::MovingPin(offset)
                              .bound(max_offset)
                              .rate(max_rate)
                              .acceleration(max_acceleration)
                              .limited(limited)} {}

        static constexpr double farthest = StrokeValues::farthest;
        static constexpr hal::Range signed_lengths{-farthest, farthest}, lengths{0, farthest},
            rates{1e-3, 1e6}, accelerations{1e-3, 1e9}, dead_points{Infeed::nowhere, Infeed::both};

        hal::In<double> amount{this,
                               "infeed-amount",
                               0,
                               "mu",
                               "Infeed at a dead point; its sign is the direction inward, 0 is none.",
                               hal::machine(signed_lengths)};
        hal::In<double> total{
            this,
            "infeed-total",
            0,
            "mu",
            "Infeed from the start; spark-out strokes and the end of the strokes follow it.",
            hal::machine(lengths)};
        hal::In<std::int32_t> clear{this, "infeed-clear", 0,
                                    "The dead points at which the wheel is clear of the work, and the infeed "
                                    "acts: 0 none, 1 lower, 2 upper, 3 both.",
                                    hal::machine(dead_points)};
        hal::In<bool> end{this, "infeed-end", false,
                          "True ends the infeed, as its total does: for a gauge at the work."};
        hal::In<double> position{this, "infeed-position", 0, "mu",
                                 "Commanded position of the joint of the infeed: joint.N.pos-cmd."};
        hal::In<double> feedback{this, "infeed-feedback", 0, "mu",
                                 "Measured position of this joint, without the offset: joint.N.pos-fb."};
        hal::In<double> applied{this, "infeed-applied", 0, "mu",
                                "Offset that this joint has: applied-offset of its stage."};
        hal::In<double> max_amount{
            this, "infeed-max-amount", 0.05, "mu", "Largest infeed at a dead point.", hal::machine(lengths)};
        hal::In<double> max_offset{
            this, "infeed-max-offset", 1, "mu", "Largest infeed from the start.", hal::machine(lengths)};
        hal::In<double> max_rate{
            this, "infeed-max-rate", 1, "mu/s", "Largest speed of the infeed.", hal::machine(rates)};
        hal::In<double> max_acceleration{this,
                                         "infeed-max-accel",
                                         50,
                                         "mu/s2",
                                         "Largest acceleration of the infeed.",
                                         hal::machine(accelerations)};
        hal::In<double> min_limit{
            this, "infeed-min-limit", 0, "mu", "Lower soft limit of this joint.", hal::must(signed_lengths)};
        hal::In<double> max_limit{
            this, "infeed-max-limit", 0, "mu", "Upper soft limit of this joint.", hal::must(signed_lengths)};
        hal::In<double> tolerance{this,
                                  "infeed-tolerance",
                                  0.002,
                                  "mu",
                                  "The stroke goes on when this joint is as near to its position.",
                                  hal::machine(lengths)};
        hal::In<double> clearance{this,
                                  "infeed-clearance",
                                  0.1,
                                  "mu",
                                  "A start after machine off first takes back so much of the infeed.",
                                  hal::machine(lengths)};
        hal::Out<double> offset{this, "infeed-offset", "mu", "For the stage of the joint of the infeed."};
        hal::Out<bool> done{this, "infeed-done",
                            "The infeed has ended: by its total, a soft limit, infeed-end or an abort."};
        hal::Offset moves;

        Infeed::Settings read() noexcept {
            Infeed::Settings its;
            hal::SettingsReader setting;
            its.amount = setting(amount);
            its.total = setting(total);
            its.clear = setting(clear);
            its.most_amount = setting(max_amount);
            its.most = setting(max_offset);
            its.rate = setting(max_rate);
            its.acceleration = setting(max_acceleration);
            its.lowest = setting(min_limit);
            its.highest = setting(max_limit);
            its.tolerance = setting(tolerance);
            its.clearance = setting(clearance);
            its.in_range = setting.good();
            return its;
        }
    };

    std::optional<Pins> pins_;
};

}  // namespace plumb
