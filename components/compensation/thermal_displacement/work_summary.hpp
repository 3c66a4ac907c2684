// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// How a shift of work went: once after each summary-time, at the end of a part.
struct WorkSummary : hal::Group {
    using Group::Group;

    // Once a period. `counts`: a part is made with compensation, and none that verifies; the offset in force
    // and its sigma in mu.
    void step(bool counts, double in_force, double sigma, bool doubted, double dt) noexcept {
        time_ += dt;
        if (counts && !counted_) over = false;
        if (counts) {
            if (std::abs(in_force) > std::abs(largest_)) largest_ = in_force;
            doubted_ |= doubted;
            sigma_ = sigma;
        } else if (counted_) {
            end_part();
        }
        counted_ = counts;
    }

    hal::In<double> interval{
        this, "summary-time", 28800, "s", "Time between two summaries.", hal::expert(hal::Range{0, 1e9})};
    hal::Out<bool> over{this, "summary",
                        "The part that has ended completes a summary-time; until the next part."};
    hal::Out<std::int32_t> parts{this, "summary-parts", "Parts made with compensation in that time."};
    hal::Out<double> offset{this, "summary-offset", "mu", "Largest offset in that time."};
    hal::Out<double> error{this, "summary-sigma", "mu", "Error of the offset to expect in these parts, rms."};
    hal::Out<double> doubt{this, "summary-doubt", "%", "Parts with a doubt."};
    hal::Told told{this, "summary", hal::Tell::text,
                   "Last shift: {summary-parts} parts, offset up to {summary-offset}, expected error "
                   "{summary-sigma}, doubt in {summary-doubt} of the parts."};

private:
    void end_part() noexcept {
        ++count_;
        doubts_ += doubted_;
        squares_ += sigma_ * sigma_;
        doubted_ = false;
        if (!(time_ >= interval)) return;
        over = true;
        parts = count_;
        offset = largest_;
        error = std::sqrt(squares_ / count_);
        doubt = 100.0 * doubts_ / count_;
        time_ = largest_ = squares_ = 0;
        count_ = doubts_ = 0;
    }

    bool counted_ = false, doubted_ = false;
    double time_ = 0, largest_ = 0, sigma_ = 0, squares_ = 0;
    std::int32_t count_ = 0, doubts_ = 0;
};

}  // namespace plumb
