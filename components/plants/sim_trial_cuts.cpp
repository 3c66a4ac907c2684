// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "pages/sim_trial_cuts.page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

struct SimTrialCuts final : hal::Component {
    static constexpr hal::About about{"sim_trial_cuts",
                                      "trial cuts of a simulated lathe, where no LinuxCNC moves it", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<bool> start{this, "start", false, "A rising edge begins the trial cuts."};
    hal::In<std::int32_t> plan{this, "plan", 1, "0 two cuts, 1 lands, 2 step of Y, 3 eight cuts."};
    hal::In<std::int32_t> pairs{this, "pairs", 2, "Pairs of lands, 1 to 6."};
    hal::In<double> diameter{this, "diameter", 10, "mu", "Diameter of lands and of the first cut."};
    hal::In<double> second_diameter{this, "second-diameter", 5, "mu", "Diameter of the deepest cut."};
    hal::In<double> finish_diameter{this, "finish-diameter", 8, "mu", "Diameter after the correction."};
    hal::In<double> stock_diameter{this, "stock-diameter", 12, "mu", "Diameter of the stock."};
    hal::In<double> pass_depth{this, "pass-depth", 0.05, "mu", "Depth of the passes of a cut."};
    hal::In<double> first_z{this, "first-z", 50, "mu", "Z of the first land, towards the chuck from there."};
    hal::In<double> spacing{this, "spacing", 2, "mu", "Distance of the lands, above 1."};
    hal::In<double> cut_time{this, "cut-time", 40, "s", "Time of a cut and its measurement."};
    hal::In<bool> correct{this, "correct", true, "Move Y and correct X if centre_height allows it."};
    hal::In<double> land_1{this, "land-1-y", 0.2, "mu", "Y of the first land."};
    hal::In<double> land_2{this, "land-2-y", -0.2, "mu", "Y of the second land."};
    hal::In<bool> measure{this, "measure", false, "The last cut waits for its diameter."};
    hal::In<bool> fault{this, "fault", false, "The cuts give no height."};
    hal::In<bool> move_allowed{this, "move-allowed", false, "Y may move."};
    hal::In<bool> check_due{this, "check-due", false, "A check is due behind these cuts."};
    hal::In<double> next_x{this, "next-x", 0, "mu", "X of the check, a radius."};
    hal::In<double> next_y{this, "next-y", 0, "mu", "Y of the check."};
    hal::In<double> y_move{this, "y-move", 0, "mu", "Move of Y."};
    hal::In<double> x_correction{this, "x-correction", 0, "mu", "Correction of X."};
    hal::In<double> lathe_effective{this, "effective-height", 0, "mu",
                                    "Effective height of the last cut, of the lathe."};

    hal::Out<double> x_position{this, "x-position", "mu", "Position of X, as a radius."};
    hal::Out<double> y_position{this, "y-position", "mu", "Position of Y."};
    hal::Out<double> z_position{this, "z-position", "mu", "Position of Z."};
    hal::Out<double> elapsed{this, "elapsed", "s", "Time that the cuts have taken."};
    hal::Out<bool> new_stock{this, "new-stock", "A new bar is put in."};
    hal::Out<bool> begin{this, "begin", "The procedure begins."};
    hal::Out<bool> cut_done{this, "cut-done", "The tool stands at the end of a cut."};
    hal::Out<std::int32_t> cuts{this, "cuts", "Number of trial cuts."};
    hal::Out<std::int32_t> method{this, "method", "The method, as in centre_height."};
    hal::Out<bool> same_land{this, "same-land", "All cuts are of one land."};
    hal::Out<double> x_zero{this, "x-zero", "mu", "Position of X that the program calls 0."};
    hal::Out<bool> moved{this, "moved", "Y has moved, and X is corrected."};
    hal::Out<bool> done{this, "done", "The finishing land is turned."};
    hal::Out<double> truth_effective{this, "truth-effective-height", "mu",
                                     "Mean of the effective heights of the cuts, at the Y before the move."};
    hal::Function run{this, "update", &SimTrialCuts::update, hal::Place::program};

    void update(double) noexcept {
        if (starting_.rises(start)) restart();
        if (s_.phase == Phase::measure && !s_.left) {
            if (s_.index < s_.planned) {
                s_.height_sum += lathe_effective - aim().y;
                s_.heights += 1;
            }
            s_.left = true;
            s_.x =
                stock_diameter / 2 + clear;  // at once, so that the work does not spring back into the tool
        }
        s_.waited |= s_.phase == Phase::measure && measure;
        s_.odd = !s_.odd;
        if (s_.phase != Phase::rest && s_.odd) advance();

        x_position = s_.x + s_.correction;
        y_position = s_.y + s_.moved_by;
        z_position = s_.z;
        elapsed = s_.elapsed;
        new_stock = s_.phase == Phase::begin;
        begin = s_.phase == Phase::begin;
        cut_done = s_.phase == Phase::measure;
        cuts = static_cast<std::int32_t>(s_.count);
        const std::int32_t its_plan = plan;
        method = its_plan;
        same_land = its_plan == 0 || its_plan == 2;
        x_zero = s_.correction;
        moved = s_.moved;
        done = s_.phase == Phase::rest && s_.finished;
        truth_effective = s_.heights > 0 ? s_.height_sum / s_.heights : 0;
    }

private:
    enum class Phase { rest, begin, approach, at_y, at_z, plunge, measure, leave };

    struct Aim {
        double x = 0, y = 0;
        bool same_land = false;
    };

    static constexpr double clear = 1;  // mm

    void restart() noexcept {
        s_ = State{};
        s_.phase = Phase::begin;
        s_.x = usable(stock_diameter, 1e4, 12) / 2 + clear;
    }

    void make_plan() noexcept {
        const double x = diameter / 2, deepest = second_diameter / 2, one = land_1, two = land_2;
        const auto add = [this](double to_x, double to_y, bool same) {
            s_.aims[s_.count++] = {to_x, to_y, same};
        };
        switch (plan) {
            case 0:
                add(x, 0, false);
                add(deepest, 0, true);
                break;
            case 2:
                add(x, 0, false);
                add((x + deepest) / 2, 0, true);
                add(deepest, 0.75 * (one != 0 ? one : two), true);  // less, so that it is no air cut
                break;
            case 3:
                for (const int k : {0, 3, 2, 1, 1, 2, 3, 0})  // levels of X, Y and order do not correlate
                    add(k == 0 || k == 1 ? x : deepest, k == 0 || k == 2 ? one : two, false);
                break;
            default:
                for (int k = 0; k < 2 * std::clamp<std::int32_t>(pairs, 1, 6); ++k)
                    add(x, k % 4 == 0 || k % 4 == 3 ? one : two, false);
        }
    }

    const Aim aim() const noexcept {
        return s_.index < s_.count ? s_.aims[s_.index] : Aim{finish_diameter / 2, 0};
    }

    void advance() noexcept {
        const Aim its = aim();
        switch (s_.phase) {
            case Phase::begin:
                make_plan();
                s_.planned = s_.count;
                s_.phase = Phase::approach;
                break;
            case Phase::approach:  // from below, so that backlash does not count
                s_.y = its.y - 0.1;
                if (!its.same_land || s_.index == 0)
                    s_.z = first_z - std::max(usable(spacing, 100, 2), 1.1) * static_cast<double>(s_.lands++);
                s_.phase = Phase::at_y;
                break;
            case Phase::at_y:
                s_.y = its.y;
                s_.phase = Phase::at_z;
                break;
            case Phase::at_z:
                s_.x = std::max(its.x, (its.same_land ? s_.aims[s_.index - 1].x : stock_diameter / 2));
                s_.phase = Phase::plunge;
                break;
            case Phase::plunge:
                s_.x = std::max(its.x, s_.x - std::max(usable(pass_depth, 100, 0.05), 1e-3));
                if (s_.x > its.x) break;
                if (s_.index < s_.count) {
                    s_.elapsed += usable(cut_time, 1e5, 0);
                    s_.waited = s_.left = false;
                    s_.phase = Phase::measure;
                } else {
                    s_.phase = Phase::leave;
                }
                break;
            case Phase::measure:
                if (fault) {
                    s_.index = s_.count;
                    s_.phase = Phase::leave;
                } else if (s_.waited && !measure) {
                    s_.index += 1;
                    s_.phase = Phase::leave;
                }
                break;
            case Phase::leave:
                if (s_.index == s_.count && !s_.finished && check_due && s_.count < s_.aims.size())
                    s_.aims[s_.count++] = {next_x, next_y, true};  // deeper into the last land
                s_.x = stock_diameter / 2 + clear;
                if (s_.index == s_.count && s_.finished) {
                    s_.phase = Phase::rest;
                } else {
                    s_.phase = Phase::approach;
                    if (s_.index == s_.count) finish();
                }
                break;
            case Phase::rest: break;
        }
    }

    // The last trial cut is measured: corrects, and turns the finishing land.
    void finish() noexcept {
        s_.finished = true;
        if (!correct || !move_allowed) return;
        s_.moved = true;
        s_.moved_by = usable(y_move, 10, 0);
        s_.correction = usable(x_correction, 10, 0);
    }

    struct State {
        std::array<Aim, 16> aims;
        std::size_t count = 0, planned = 0, index = 0;
        double x = 100, y = 0, z = 0, elapsed = 0, correction = 0, moved_by = 0;
        double height_sum = 0;
        int heights = 0, lands = 0;
        bool moved = false, finished = false, odd = true, waited = false, left = false;
        Phase phase = Phase::rest;
    };

    State s_;
    Edge starting_;
};

hal::Model hal::model() {
    return model_of<SimTrialCuts>();
}

}  // namespace plumb
