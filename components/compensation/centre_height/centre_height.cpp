// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_procedure.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/pi.hpp"
#include "hal/component.hpp"
#include "pages/centre_height.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace plumb {

// A measured diameter, or the areas of a laser beam that give one.
struct HeightGauge final : hal::Group {
    using Group::Group;

    static constexpr hal::Range kinds{0, 3}, sizes{0, 1000};
    hal::In<std::int32_t> kind{this, "gauge-kind", 0, "0 diameter, 1 radius, 2 rectangular, 3 round beam.",
                               hal::machine(kinds)};
    hal::In<double> diameter{this, "diameter", 0, "mu", "Diameter, or radius, of the cut that was measured."};
    hal::In<double> emitted{this, "emitted-area", 0, "mu2", "Area of the beam before the work."};
    hal::In<double> received{this, "received-area", 0, "mu2", "Area of the beam behind the work."};
    hal::In<double> size{
        this, "beam-size", 0, "mu", "Beam along the work; the radius of a round one.", hal::machine(sizes)};

    struct Reading {
        double diameter = 0;  // mu; NaN if there is none
        bool by_beam = false;
    };

    Reading read() noexcept {
        const std::int32_t given = kind;
        if (given == 2) return {diameter_in_rectangle(emitted, received, size), true};
        if (given == 3) return {diameter_in_circle(emitted, received, size), true};
        return {given == 1 ? 2 * diameter : given == 0 ? diameter : no_diameter, false};
    }

    // An entry is a diameter, or a radius if the gauge gives one.
    double as_diameter(double entry) noexcept { return kind == 1 ? 2 * entry : entry; }
};

// Cuts that an operator enters, for a computation without motion.
struct KeyedCuts final : hal::Group {
    static constexpr std::size_t most = 16;

    KeyedCuts(hal::Owner owner, std::size_t rows) : Group(owner), rows_(rows) {
        if (rows > 0)
            keyed_.emplace(this, "keyed", false,
                           "A compute uses cut-diameter-N, cut-x-N and cut-y-N, not the procedure.");
    }

    hal::In<std::int32_t> count{this, "cuts", 2, "Number of cuts: of cut-N, or those that compute alone."};
    hal::In<double> travel{this, "travel", 0, "mu", "Travel of X between the first two cuts; 0: positions."};

    bool keyed() const noexcept { return keyed_ && *keyed_; }

    TurnedCuts read(const HeightSettings::Values& now, bool by_radius) noexcept {
        TurnedCuts cuts;
        const std::int32_t wanted = count;
        cuts.count = std::min(static_cast<std::size_t>(std::max<std::int32_t>(wanted, 0)), rows_);
        cuts.travel = travel;
        for (std::size_t i = 0; i < cuts.count; ++i) {
            const double entry = diameter_[i];
            cuts.cuts[i] = {x_[i], y_[i], now.radius_of(by_radius ? 2 * entry : entry)};
        }
        return cuts;
    }

private:
    const std::size_t rows_;
    std::optional<hal::In<bool>> keyed_;
    hal::Row<hal::In<double>> diameter_{this, rows_, "cut-diameter", 0, "mu", "Diameter of this cut."};
    hal::Row<hal::In<double>> x_{this, rows_, "cut-x", 0, "mu", "X of this cut, as a radius, outward."};
    hal::Row<hal::In<double>> y_{this, rows_, "cut-y", 0, "mu", "Y of this cut, against the present one."};
};

// The orders of an operator or a program. Each is a rising edge.
struct HeightOrders final : hal::Group {
    using Group::Group;

    hal::In<bool> start{this, "start", false, "A rising edge begins the procedure."};
    hal::In<bool> resume{this, "resume", false, "A rising edge continues after an abort."};
    hal::In<bool> abort{this, "abort", false, "A rising edge interrupts the procedure."};
    hal::In<bool> stored{this, "stored", false,
                         "A rising edge ends the procedure: the program has the height."};
    hal::In<bool> cut_done{this, "cut-done", false, "A rising edge: the tool stands at the end of a cut."};
    hal::In<bool> value_ready{this, "value-ready", false, "A rising edge: the diameter of the cut counts."};
    hal::In<double> entered_diameter{this, "entered-diameter", 0, "mu",
                                     "Diameter, or radius, that the operator or a program enters."};
    hal::In<double> second{this, "second-diameter", 0, "mu",
                           "The same at another angle of the work, a quarter turn further; 0: not read."};
    hal::In<bool> entered{this, "entered", false, "A rising edge: entered-diameter of the cut counts."};
    hal::In<double> entered_cut{this, "entered-cut", 0, "1",
                                "Number of the cut whose diameter entered-diameter replaces, from 1; 0: the "
                                "cut that waits; below 0: the last cut, whose diameter is taken back."};
    hal::In<double> program_method{this, "program-method", 0, "1",
                                   "Method by a word of a program, plus 1; 0: the pin method."};
    hal::In<double> program_cuts{this, "program-cuts", 0, "1",
                                 "Number of cuts by a word of a program; 0: the pin cuts."};
    hal::In<double> program_post{this, "program-post", 0, "1",
                                 "Post by a word of a program, plus 1; 0: the pin post."};
    hal::In<bool> compute{this, "compute", false, "A rising edge computes from the cuts that there are."};

    // Of one period.
    struct Given {
        bool start = false, resume = false, abort = false, stored = false, cut = false, value = false,
             entry = false, compute = false;
        bool cut_done = false, value_ready = false, entered = false;  // as they are
        double cuts = 0;                                              // by a program; 0 for none
        double corrected =
            0;  // number of the cut whose diameter is replaced, or below 0 taken back; 0 for none
    };

    Given read() noexcept {
        Given now;
        now.cut_done = cut_done;
        now.value_ready = value_ready;
        now.entered = entered;
        now.start = start_.rises(start);
        now.resume = resume_.rises(resume);
        now.abort = abort_.rises(abort);
        now.stored = stored_.rises(stored);
        now.cut = cut_.rises(now.cut_done);
        now.value = value_.rises(now.value_ready);
        now.entry = entry_.rises(now.entered);
        now.compute = compute_.rises(compute);
        now.cuts = program_cuts;
        now.corrected = entered_cut;
        return now;
    }

private:
    Edge start_, resume_, abort_, stored_, cut_, value_, entry_, compute_;
};

// The outputs of a procedure: its results, and the next act that it waits for.
struct HeightOutputs final : hal::Group {
    using Group::Group;

    hal::Out<bool> measure{this, "measure", "The last cut waits for its diameter."};
    hal::Out<std::int32_t> cut_number{this, "cut-number", "Number of cuts that have their diameter."};
    hal::Out<bool> fault{this, "fault", "Cuts or an entry are refused; detail-code gives the cause."};
    hal::Code<Detail> detail{
        this, "detail-code",
        "Why there is no height, why Y may not move, or which cuts make the height known; 0 for none."};
    hal::Out<bool> value_valid{this, "value-valid", "The height is valid."};
    hal::Out<bool> sign_known{this, "sign-known", "The height has a sign."};
    hal::Out<bool> move_allowed{this, "move-allowed", "Y may move by y-move."};
    hal::Out<bool> on_centre{
        this, "on-centre", "Y and X of the tool are within tolerance with 99 %, by cuts that met the stock."};
    hal::Out<bool> x_allowed{this, "x-allowed", "X of the tool may change by x-correction."};
    hal::Out<bool> checked_for_air{this, "checked-for-air", "The diameter of the stock is known."};
    hal::Out<bool> cut_due{this, "cut-due", "A cut is due: at next-x and next-y."};
    hal::Out<double> next_x{this, "next-x", "mu", "X of the next cut, as the program calls it, a radius."};
    hal::Out<double> next_y{this, "next-y", "mu", "Y of the next cut, against the present one."};
    hal::Out<double> next_diameter{this, "next-diameter", "mu", "Diameter that the next cut will have."};
    hal::Out<bool> check_due{this, "check-due", "The next cut is a check, which the others predict."};
    hal::Out<bool> reads_twice{
        this, "reads-twice",
        "The cut that waits is entered by hand with two readings, a quarter turn apart."};
    hal::Out<bool> shown{this, "shown", "The land after the store has the programmed diameter."};
    hal::Out<std::int32_t> suspect_cut{
        this, "suspect-cut", "Number of the cut that contradicts the others, or the stock; 0: none."};
    hal::Out<std::int32_t> cuts_needed{this, "cuts-needed", "Number of cuts that detail-code asks for."};
    hal::Out<double> height{this, "height", "mu", "Height of the tip; its size if the sign is unknown."};
    hal::Out<double> size{this, "height-size", "mu", "Size of the height."};
    hal::Out<double> sigma{this, "sigma", "mu", "Sigma of the height."};
    hal::Out<double> within{this, "within", "mu", "Sigma of a height of 0: on centre within."};
    hal::Out<double> tip_x{this, "tip-x", "mu", "Distance of the tip from the axis in X, at the first cut."};
    hal::Out<double> x_sigma{this, "x-sigma", "mu", "Sigma of x-correction."};
    hal::Out<double> theta{this, "theta", "deg", "Angle of the tip above X, at the first cut."};
    hal::Out<double> by_diameter_1{this, "height-by-diameter-1", "1", "Change of height with diameter 1."};
    hal::Out<double> by_diameter_2{this, "height-by-diameter-2", "1", "Change of height with diameter 2."};
    hal::Out<double> by_travel{this, "height-by-travel", "1", "Change of height with the travel."};
    hal::Out<double> smallest_diameter{this, "smallest-diameter", "mu", "Smallest diameter at this height."};
    hal::Out<double> y_move{this, "y-move", "mu", "Move of Y to target-height."};
    hal::Out<double> x_correction{this, "x-correction", "mu",
                                  "Added to the tool's X, as a radius, if x-allowed."};
    hal::Out<double> target_x{this, "target-x", "mu", "Position of X for target-diameter, at this height."};
    hal::Out<bool> target_reachable{this, "target-reachable", "The target-diameter is above the smallest."};
    hal::Out<double> land_1_y{this, "land-1-y", "mu", "Y of the first land, against the present one."};
    hal::Out<double> land_2_y{this, "land-2-y", "mu", "Y of the second land, against the present one."};
    hal::Out<double> predicted{this, "predicted-diameter", "mu", "Diameter of the last cut, by the others."};
    hal::Out<double> disagreement{this, "disagreement", "1", "Disagreement of the cuts, in sigmas."};
    hal::Out<std::int32_t> rejected_cuts{this, "rejected-cuts",
                                         "Number of cuts that do not count, as a burr stands on them."};
    hal::Out<std::int32_t> rejected_cut{this, "rejected-cut", "Number of the first of these cuts; 0: none."};
    hal::Out<bool> bend_known{this, "bend-known", "This tool has a height under the cut and one at rest."};
    hal::Out<double> bend{this, "bend", "mu", "Height at rest less the one under the cut."};
    hal::Out<double> bend_sigma{this, "bend-sigma", "mu", "Sigma of the bend."};

    void show(const HeightProcedure& procedure, const HeightSettings::Values& now) noexcept {
        const TipHeight& result = procedure.result();
        const bool valid = result.valid;
        const auto if_valid = [valid](double x) { return valid ? x : 0; };
        measure = procedure.state() == State::measure;
        cut_number = static_cast<std::int32_t>(procedure.cuts().count);
        fault = procedure.fault() != Detail::none;
        detail = procedure.detail();
        value_valid = valid;
        sign_known = valid && result.signed_;
        const HeightVerdict& verdict = procedure.verdict();
        move_allowed = valid && verdict.y_moves && !now.table_asks;
        x_allowed = valid && verdict.x_changes && !now.table_asks;
        on_centre = valid && verdict.verdict == Verdict::on_centre;
        checked_for_air = now.good && now.stock_diameter > 0;
        cuts_needed = valid ? verdict.cuts_needed : 0;
        cut_due = procedure.cut_due();
        check_due = now.good && procedure.check_due(now);
        reads_twice = procedure.reads_twice();
        shown = valid && verdict.verdict == Verdict::shown;
        suspect_cut = static_cast<std::int32_t>(procedure.suspect());
        const NextCut next = now.good && procedure.cut_due() ? procedure.next(now) : NextCut{};
        next_x = next.x * now.outward();
        next_y = next.y;
        next_diameter = 2 * next.radius;
        x_sigma = if_valid(result.sigma_x);
        height = if_valid(result.height);
        size = if_valid(std::abs(result.height));
        sigma = if_valid(result.sigma);
        within = if_valid(result.within);
        tip_x = if_valid(result.x);
        theta = if_valid(result.theta * (180 / pi));
        by_diameter_1 = result.by_diameter_1;
        by_diameter_2 = result.by_diameter_2;
        by_travel = result.by_travel;
        predicted = result.predicted;
        disagreement = result.disagreement;
        rejected_cuts = valid ? __builtin_popcount(result.rejected) : 0;
        rejected_cut = valid ? __builtin_ffs(static_cast<int>(result.rejected)) : 0;
        smallest_diameter = if_valid(2 * std::abs(result.height));
        y_move = valid && result.signed_ ? procedure.move() : 0;
        x_correction = if_valid(procedure.correction());
        bend_known = procedure.bend().known();
        bend = procedure.bend().bend();
        bend_sigma = procedure.bend().sigma();

        const double target = now.good ? now.target_diameter / 2 : 0;
        const bool reachable = valid && target > std::abs(result.height);
        target_reachable = reachable;
        // The position of the first cut, further by the way of the tip to its new place.
        const double tip = reachable ? std::sqrt((target - result.height) * (target + result.height)) : 0;
        target_x = reachable ? (procedure.cuts()[0].x + tip - result.x) * now.outward() : 0;

        const LandPair lands = now.good ? now.lands() : LandPair{};
        land_1_y = lands.first;
        land_2_y = lands.second;
    }
};

struct CentreHeight final : hal::Component {
    static constexpr hal::About about{"centre_height",
                                      "measures the height of a lathe tool's edge from turned diameters",
                                      page, "Centre height"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::Count posts{this,
                     "posts",
                     1,
                     1,
                     HeightSettings::most_posts,
                     "Number of tool posts, 1 to 4: the rows x-position-N, x-zero-N and so on."};
    hal::Count keyed_cuts{
        this,
        "keyed_cuts",
        0,
        0,
        KeyedCuts::most,
        "Number of cuts that an operator keys in, 0 to 16: the rows cut-diameter-N, cut-x-N and cut-y-N."};
    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Y may be moved; else the value is only shown."};
    HeightOrders orders{this};
    hal::Row<hal::In<double>> x_position{this, posts, "x-position", 0, "mu", "Position of X, as a radius."};
    hal::Row<hal::In<double>> y_position{this, posts, "y-position", 0, "mu", "Position of Y."};
    hal::Row<hal::In<double>> x_zero{
        this, posts, "x-zero", 0, "mu", "Position of X that the program calls 0, tool offset included."};
    hal::In<bool> table_asks{this, "table-asks", false,
                             "The tool table was changed while LinuxCNC was off: nothing is stored."};
    hal::In<double> spindle_load{this, "spindle-load", 0, "%", "Load of the spindle of the work."};
    HeightGauge gauge{this};
    KeyedCuts keyed{this, keyed_cuts};
    HeightSettings settings{this, posts};

    hal::Out<bool> cut_taken{this, "cut-taken",
                             "The position of the cut was taken or refused, while cut-done is true."};
    hal::Out<bool> value_taken{this, "value-taken",
                               "The last diameter was taken, while value-ready is true."};
    HeightOutputs outputs{this};
    hal::Status<HeightStatus> status{this, permission};
    hal::Function run{this, "update", &CentreHeight::update, hal::Place::measurement};

    void update(double) noexcept {
        permission.step();
        HeightSettings::Values now = settings.values(orders.program_post, orders.program_method);
        now.table_asks = table_asks;
        now.automatic = permission.enabled() && !now.table_asks;
        const HeightOrders::Given given = orders.read();

        const double load = spindle_load;
        if (load > load_) load_ = load;
        if (given.start) {
            procedure_.begin(now, y_position[now.post], orders.entered_diameter, x_zero[now.post]);
            load_ = 0;
        }
        if (given.abort)
            procedure_.interrupt();
        else if (given.stored)
            procedure_.store(now);
        else if (given.resume)
            procedure_.go_on(now);
        else if (given.cut)
            take_position(now);
        else if (given.entry && given.corrected > 0)
            taken_ = procedure_.correct(now, entered(given), given.corrected);
        else if (given.entry && given.corrected < 0)
            taken_ = procedure_.take_back(-given.corrected);
        else if ((given.value || given.entry) && procedure_.state() == State::measure)
            take_diameter(now, given);
        else if (given.compute && keyed.keyed())
            procedure_.compute(now, keyed.read(now, gauge.kind == 1));
        else if (given.compute)
            procedure_.compute(now, keyed.travel);
        cut_taken_ &= given.cut_done;
        taken_ &= given.value_ready || given.entered;

        outputs.show(procedure_, now);
        status = status_of({procedure_.state(), procedure_.fault(), procedure_.verdict().verdict,
                            status.of_interlock(), now.table_asks});
        permission.report({});
        cut_taken = cut_taken_;
        value_taken = taken_;
    }

private:
    void take_position(const HeightSettings::Values& now) noexcept {
        cut_taken_ = procedure_.take_position(now, x_position[now.post], y_position[now.post], load_) ||
                     procedure_.fault() == Detail::no_load;
        load_ = 0;
    }

    void take_diameter(const HeightSettings::Values& now, const HeightOrders::Given& given) noexcept {
        HeightProcedure::Entry entry = entered(given);
        if (!given.entry) {
            const HeightGauge::Reading reading = gauge.read();
            entry.diameter = reading.diameter;
            entry.by_beam = reading.by_beam;
        }
        procedure_.take_diameter(now, entry);
        taken_ = true;
    }

    HeightProcedure::Entry entered(const HeightOrders::Given& given) noexcept {
        HeightProcedure::Entry entry;
        entry.given = orders.entered_diameter;
        entry.diameter = gauge.as_diameter(entry.given);
        entry.second = given.entry ? gauge.as_diameter(orders.second) : 0;  // may be left from an entry
        entry.by_hand = given.entry;
        entry.wanted = given.cuts >= 1 ? given.cuts : keyed.count;
        entry.travel = keyed.travel;
        return entry;
    }

    HeightProcedure procedure_;
    double load_ = 0;  // the largest since the last cut
    bool cut_taken_ = false, taken_ = false;
};

hal::Model hal::model() {
    return model_of<CentreHeight>();
}

}  // namespace plumb
