// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/tip_height.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/turning/beam_area.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// A measured diameter, or the areas of a laser beam that give one.
struct HeightGauge final : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> kind{this, "gauge-kind", 0, "0 diameter, 1 radius, 2 rectangular, 3 round beam."};
    hal::In<double> diameter{this, "diameter", 0, "mu", "Diameter, or radius, of the cut that was measured."};
    hal::In<double> emitted{this, "emitted-area", 0, "mu2", "Area of the beam before the work."};
    hal::In<double> received{this, "received-area", 0, "mu2", "Area of the beam behind the work."};
    hal::In<double> size{this, "beam-size", 0, "mu", "Beam along the work; the radius of a round one."};

    struct Reading {
        double diameter = 0;  // mu; NaN if there is none
        bool by_beam = false;
    };

    Reading read() noexcept {
        const std::int32_t its = kind;
        if (its == 2) return {diameter_in_rectangle(emitted, received, size), true};
        if (its == 3) return {diameter_in_circle(emitted, received, size), true};
        return {its == 1 ? 2 * diameter : its == 0 ? diameter : no_diameter, false};
    }
};

// Cuts that an operator enters, for a computation without motion.
struct KeyedCuts final : hal::Group {
    using Group::Group;

    static constexpr std::size_t most = 12;

    hal::In<bool> keyed{this, "keyed", false,
                        "A compute uses cut-diameter-N, cut-x-N and cut-y-N, not the procedure."};
    hal::In<std::int32_t> count{this, "cuts", 2, "Number of cuts: of cut-N, or those that compute alone."};
    hal::In<double> travel{this, "travel", 0, "mu", "Travel of X between the first two cuts; 0: positions."};
    hal::Row<hal::In<double>, most> diameter{this, "cut-diameter", 0, "mu", "Diameter of this cut."};
    hal::Row<hal::In<double>, most> x{this, "cut-x", 0, "mu", "X of this cut, as a radius, outward."};
    hal::Row<hal::In<double>, most> y{this, "cut-y", 0, "mu", "Y of this cut, against the present one."};
};

struct CentreHeight final : hal::Component {
    static constexpr hal::About about{"centre_height",
                                      "measures the height of a lathe tool's edge from turned diameters",
                                      R"(
A turning tool that stands above or below the axis of the work leaves wrong diameters, and a nib in the centre. A tip
0.03 mm off centre cannot turn below 0.06 mm diameter. centre_height takes the diameters of a few trial cuts. It outputs
the height of the tip with its sign and uncertainty, the move of Y that corrects it, and the correction of X.

Use it on lathes with a Y axis, with a gauge or with a hand micrometer. It moves nothing: your program does, and stores
the result in the tool table. The theory and the figures are in components/compensation/centre_height/README.md of the
sources.)",
                                      hal::Wiring{R"(
  loadrt centre_height names=centre unit=[TRAJ]LINEAR_UNITS

  net x-position     joint.0.pos-cmd       => centre.x-position-0
  net y-position     joint.1.pos-cmd       => centre.y-position-0
  net height-start   motion.digital-out-08 => centre.start
  net height-cut     motion.digital-out-09 => centre.cut-done
  net height-entered motion.digital-out-10 => centre.entered
  net height-entry   motion.analog-out-08  => centre.entered-diameter
  net height-x-zero  motion.analog-out-09  => centre.x-zero-0
  net height-method  motion.analog-out-10  => centre.program-method
  net height-cuts    motion.analog-out-11  => centre.program-cuts
  net height-stored  motion.digital-out-13 => centre.stored
  net height-measure centre.measure        => motion.digital-in-08
  net height-taken   centre.value-taken    => motion.digital-in-09
  net height-valid   centre.value-valid    => motion.digital-in-10
  net move-allowed   centre.move-allowed   => motion.digital-in-11
  net height-y-move  centre.y-move         => motion.analog-in-08
  net height-x-move  centre.x-correction   => motion.analog-in-09

  addf motion-controller servo-thread
  addf centre.update     servo-thread

LinuxCNC needs num_dio=14 and num_aio=14 in the loadrt line of motmod. A gauge gives diameter and value-ready, and takes
measure as its request. configs/functions/centre_height has all lines, and M-codes for them.)"},
                                      hal::SettingUp{R"(
1. Set method 1, two lands. From the same stock and at the same X, cut a land with Y at land-1-y and one at land-2-y, both
against the present Y. Cut land 1, land 2, land 2, land 1 if you have room: wear and warming cancel.
2. Set gauge-sigma to the uncertainty of your gauge for a diameter. Keep cut-repeatability, unless you have measured it.
3. Set clearance-angle to that of the tool, and land-diameter. land-1-y and land-2-y then avoid the side that rubs.
4. Raise start at the Y for which you want the height. After each cut raise cut-done; measure becomes true. Set
entered-diameter and raise entered, or let a gauge give diameter and value-ready; value-taken becomes true. Lower all
again. When all cuts have their diameter, value-valid or fault becomes true. Set stock-diameter: two lands that the tool
did not reach are equal, as those of a tool on centre.
5. To compute without motion, set keyed, cuts, cut-diameter-N, cut-x-N and cut-y-N, and raise compute. For the two cuts of the
source you can enter travel, as a radius, in place of cut-x-N.
6. Watch height and sigma on a few parts. Then set automatic true, and move Y by y-move when move-allowed is true.
Correct the tool's X by x-correction at the same time.
7. Repeat until on-centre is true.)"},
                                      hal::Behaviour{R"(
- start: The procedure begins. All cuts are forgotten; the present Y is the one for which height is valid.
- cut-done: X and Y of this moment are the positions of the cut. measure is true.
- value-ready: The diameter counts. An entry that is a slip sets fault, and measure stays true: enter it again.
- All cuts have their diameter: height is computed. Each further cut is a check: it must agree with the others within three
sigmas.
- Method 0, two cuts: The height has no sign. Without sign, move-allowed stays false.
- Height and bend: height is the one under the cut, as long as all cuts have the depth of the finished part.
- abort: A rising edge stops the procedure at any step, and no value is valid. A rising edge of resume continues with the cuts
that have their diameter; start begins again.
- stored: A rising edge ends the procedure and forgets the height, so that no program stores it twice.
- height below three sigmas, below twice within for two cuts: hold-code is 3, and move-allowed stays false.
- height within tolerance: on-centre is true, and move-allowed stays false.
- fault: No value is valid, and move-allowed is false.
- Settings: They count at the moment of value-ready and of compute.)"},
                                      hal::Limits{R"(
The height is the one under the cut: the work bends and the tool too. A light cut shows another height than a heavy one.
For the finished part, use the cut of the finished part.

One pair of lands takes wear between the two cuts for height.

With one entry a slip shows only against the programmed radius, with x-is-radius true. A wrong diameter within a factor of
1.4 shows only as a height beyond max-move or as disagreement; two diameters wrong by the same few micrometres never show.
A travel entered in diameter shows against the positions of X, or as a tip past the axis, or as a height near the radius.

Valid settings: method 0 to 3, post 0 to 3, sign -1 to 1, axes-angle 6 to 170, clearance-angle 0 to 85, sigmas 0 to 1,
offsets -100 to 100, factors 0.5 to 2, lengths to 1e5.

Two cuts of a work of D 10 to 5 show heights from 0.3 mm on; of D 1 to 0.2 from 41 um on. Use two lands.)"},
                                      hal::SeeAlso{"motion(9), linuxcnc_link(1)"}};

    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> start{this, "start", false, "A rising edge begins the procedure."};
    hal::In<bool> resume{this, "resume", false, "A rising edge continues after an abort."};
    hal::In<bool> abort{this, "abort", false, "A rising edge interrupts the procedure."};
    hal::In<bool> stored{this, "stored", false,
                         "A rising edge ends the procedure: the program has the height."};
    hal::In<bool> cut_done{this, "cut-done", false, "A rising edge: the tool stands at the end of a cut."};
    hal::In<bool> value_ready{this, "value-ready", false, "A rising edge: the diameter of the cut counts."};
    hal::In<double> entered_diameter{this, "entered-diameter", 0, "mu",
                                     "Diameter, or radius, that the operator or a program enters."};
    hal::In<bool> entered{this, "entered", false, "A rising edge: entered-diameter of the cut counts."};
    hal::In<double> program_method{this, "program-method", 0, "1",
                                   "Method by a word of a program, plus 1; 0: the pin method."};
    hal::In<double> program_cuts{this, "program-cuts", 0, "1",
                                 "Number of cuts by a word of a program; 0: the pin cuts."};
    hal::In<double> program_post{this, "program-post", 0, "1",
                                 "Post by a word of a program, plus 1; 0: the pin post."};
    hal::In<bool> compute{this, "compute", false, "A rising edge computes from the cuts that there are."};
    hal::Row<hal::In<double>, HeightSettings::posts> x_position{this, "x-position", 0, "mu",
                                                                "Position of X, as a radius."};
    hal::Row<hal::In<double>, HeightSettings::posts> y_position{this, "y-position", 0, "mu",
                                                                "Position of Y."};
    hal::Row<hal::In<double>, HeightSettings::posts> x_zero{
        this, "x-zero", 0, "mu", "Position of X that the program calls 0, tool offset included."};
    HeightGauge gauge{this};
    KeyedCuts keyed_cuts{this};
    HeightSettings settings{this};

    hal::Out<bool> measure{this, "measure", "The last cut waits for its diameter."};
    hal::Out<bool> value_taken{this, "value-taken",
                               "The last diameter was taken, while value-ready is true."};
    hal::Out<std::int32_t> cut_number{this, "cut-number", "Number of cuts that have their diameter."};
    hal::Code<State> state{this, "state-code", "State of the procedure."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Codes<Hold> hold{this, "hold", "A height is valid but Y may not move; hold-code gives the cause."};
    hal::Out<bool> value_valid{this, "value-valid", "The height is valid."};
    hal::Out<bool> sign_known{this, "sign-known", "The height has a sign."};
    hal::Out<bool> move_allowed{this, "move-allowed", "Y may move by y-move."};
    hal::Out<bool> on_centre{this, "on-centre", "The height is within tolerance of target-height."};
    hal::Out<double> height{this, "height", "mu", "Height of the tip; its size if the sign is unknown."};
    hal::Out<double> size{this, "height-size", "mu", "Size of the height."};
    hal::Out<double> sigma{this, "sigma", "mu", "Sigma of the height."};
    hal::Out<double> within{this, "within", "mu", "Sigma of a height of 0: on centre within."};
    hal::Out<double> tip_x{this, "tip-x", "mu", "Distance of the tip from the axis in X, at the first cut."};
    hal::Out<double> theta{this, "theta", "deg", "Angle of the tip above X, at the first cut."};
    hal::Out<double> by_diameter_1{this, "height-by-diameter-1", "1", "Change of height with diameter 1."};
    hal::Out<double> by_diameter_2{this, "height-by-diameter-2", "1", "Change of height with diameter 2."};
    hal::Out<double> by_travel{this, "height-by-travel", "1", "Change of height with the travel."};
    hal::Out<double> smallest_diameter{this, "smallest-diameter", "mu", "Smallest diameter at this height."};
    hal::Out<double> y_move{this, "y-move", "mu", "Move of Y to target-height."};
    hal::Out<double> x_correction{this, "x-correction", "mu",
                                  "Added to the tool's X, as a radius, when Y moves."};
    hal::Out<double> target_x{this, "target-x", "mu", "Position of X for target-diameter, at this height."};
    hal::Out<bool> target_reachable{this, "target-reachable", "The target-diameter is above the smallest."};
    hal::Out<double> land_1_y{this, "land-1-y", "mu", "Y of the first land, against the present one."};
    hal::Out<double> land_2_y{this, "land-2-y", "mu", "Y of the second land, against the present one."};
    hal::Out<double> predicted{this, "predicted-diameter", "mu", "Diameter of the last cut, by the others."};
    hal::Out<double> disagreement{this, "disagreement", "1", "Disagreement of the cuts, in sigmas."};

    hal::Function run{this, "update", &CentreHeight::update, "After motion-controller."};

    void update(double) noexcept {
        HeightSettings::Values now = settings.read(program_post);
        take_words(now);
        const bool began = start_.rises(start), aborted = abort_.rises(abort);
        const bool resumed = resume_.rises(resume), cut = cut_.rises(cut_done);
        const bool ended = stored_.rises(stored);
        const bool value = value_.rises(value_ready), typed = typed_.rises(entered);
        const bool computed = compute_.rises(compute);

        if (began) begin(now);
        if (aborted && state_ != State::idle && state_ != State::aborted) interrupt();
        if (aborted) {
        } else if (ended) {
            end();
        } else if (resumed && state_ == State::aborted) {
            go_on(now);
        } else if (cut && (state_ == State::cut || state_ == State::known)) {
            take_position(now);
        } else if (typed && state_ == State::measure) {
            take_diameter(now, HeightGauge::Reading{typed_diameter(), false});
        } else if (value && state_ == State::measure) {
            take_diameter(now, gauge.read());
        } else if (computed) {
            compute_now(now);
        }
        taken_ = taken_ && (value_ready || entered);

        show(now);
    }

private:
    struct Edge {
        bool was = false;
        bool rises(bool now) noexcept {
            const bool rose = now && !was;
            was = now;
            return rose;
        }
    };

    // A program has only numbers with a point.
    void take_words(HeightSettings::Values& now) noexcept {
        const double word = program_method;
        if (word == 0) return;
        now.good = now.good && word > 0.5 && word < 4.5;
        if (now.good) now.method = static_cast<Method>(static_cast<int>(word - 0.5));
    }

    double typed_diameter() noexcept {
        const double typed = entered_diameter;
        return gauge.kind == 1 ? 2 * typed : typed;
    }

    void begin(const HeightSettings::Values& now) noexcept {
        forget();
        cuts_ = TurnedCuts{};
        y_origin_ = y_position[now.post];
        cuts_.x_zero = x_zero[now.post] * now.outward();
        state_ = State::cut;
        if (!now.good) fail(Fault::settings);
        if (!known(y_origin_) || !known(cuts_.x_zero)) fail(Fault::position);
    }

    void forget() noexcept {
        result_ = TipHeight{};
        fault_ = Fault::none;
    }

    // A height is used once: what is stored in the tool table must not be added to it again.
    void end() noexcept {
        forget();
        cuts_ = TurnedCuts{};
        state_ = State::idle;
    }

    void interrupt() noexcept {
        before_abort_ = state_;
        fault_before_abort_ = fault_;
        forget();
        state_ = State::aborted;
    }

    void go_on(const HeightSettings::Values& now) noexcept {
        state_ = before_abort_;
        fault_ = fault_before_abort_;
        if (state_ == State::known) evaluate(now);
    }

    void fail(Fault reason) noexcept {
        forget();
        fault_ = reason;
        state_ = State::refused;
    }

    void take_position(const HeightSettings::Values& now) noexcept {
        if (cuts_.count == CutFit::most) return;
        const double x = x_position[now.post], y = y_position[now.post];
        if (!known(x) || !known(y)) return fail(Fault::position);
        forget();
        Cut& cut = cuts_.cuts[cuts_.count];
        cut.x = x * now.outward();
        cut.y = y - y_origin_;
        state_ = State::measure;
    }

    void take_diameter(const HeightSettings::Values& now, const HeightGauge::Reading& reading) noexcept {
        taken_ = true;
        if (!now.good) return fail(Fault::settings);
        if (reading.by_beam && !(reading.diameter > 0)) {
            fault_ = Fault::beam;  // measure again
            return;
        }
        cuts_.cuts[cuts_.count].radius = (now.diameter_offset + now.diameter_factor * reading.diameter) / 2;
        cuts_.count += 1;
        fault_ = TipHeight::slip(now, cuts_, cuts_.count - 1);
        if (fault_ != Fault::none) {  // enter it again
            cuts_.count -= 1;
            return;
        }
        if (const Fault refusal = TipHeight::refusal(now, cuts_, cuts_.count - 1); refusal != Fault::none)
            return fail(refusal);
        state_ = State::cut;
        const double by_program = program_cuts;
        const double wanted = by_program >= 1 ? by_program : keyed_cuts.count;
        if (static_cast<double>(cuts_.count) >= wanted) evaluate(now);
    }

    void compute_now(const HeightSettings::Values& now) noexcept {
        if (!keyed_cuts.keyed) return state_ == State::aborted ? void() : evaluate(now);
        cuts_ = TurnedCuts{};
        const std::int32_t count = keyed_cuts.count;
        cuts_.count = static_cast<std::size_t>(std::clamp<std::int32_t>(count, 0, KeyedCuts::most));
        for (std::size_t i = 0; i < cuts_.count; ++i) {
            cuts_.cuts[i].x = keyed_cuts.x[i];
            cuts_.cuts[i].y = keyed_cuts.y[i];
            const double keyed = keyed_cuts.diameter[i];
            const double its = gauge.kind == 1 ? 2 * keyed : keyed;
            cuts_.cuts[i].radius = (now.diameter_offset + now.diameter_factor * its) / 2;
        }
        evaluate(now);
    }

    void evaluate(const HeightSettings::Values& now) noexcept {
        if (!now.good) return fail(Fault::settings);
        cuts_.travel = keyed_cuts.travel;
        if (!known(cuts_.travel) || cuts_.travel < 0) return fail(Fault::travel);
        result_ = TipHeight::of(now, cuts_);
        fault_ = result_.fault;
        state_ = fault_ == Fault::none ? State::known : State::refused;
        if (!result_.valid) return;
        const SkewedAxes axes(now.angle);
        const double rise = now.target_height - result_.height;
        move_ = axes.travel_for(rise);
        correction_ = (cuts_.programmed(0) - result_.x - axes.x_of(move_)) * now.outward();
        good_ = std::abs(rise) <= now.tolerance;
        hold_ = reason_to_hold(now, rise);
        if (good_ && hold_ == Hold::insignificant) hold_ = Hold::none;  // nothing is to be moved
    }

    // For two cuts the sigma is that of y squared, twice its root is the smallest height that counts.
    Hold reason_to_hold(const HeightSettings::Values& now, double rise) const noexcept {
        const bool squared = now.method == Method::two_cuts;
        const double least = squared ? 2 * result_.within : 3 * result_.sigma;
        const double found = squared ? std::abs(result_.height) : std::abs(rise);
        return hal::first<Hold>({{!result_.signed_, Hold::sign},
                                 {result_.disagreement > 3, Hold::disagreement},
                                 {!(result_.sigma <= now.max_sigma), Hold::sigma},
                                 {!(std::abs(move_) <= now.max_move), Hold::move},
                                 {!(found >= least), Hold::insignificant},
                                 {!now.automatic, Hold::value_only}});
    }

    void show(const HeightSettings::Values& now) noexcept {
        const bool valid = result_.valid;
        const auto if_valid = [valid](double x) { return valid ? x : 0; };
        measure = state_ == State::measure;
        value_taken = taken_;
        cut_number = static_cast<std::int32_t>(cuts_.count);
        state = state_;
        fault = fault_;
        hold = valid ? hold_ : Hold::none;
        value_valid = valid;
        sign_known = valid && result_.signed_;
        move_allowed = valid && hold_ == Hold::none && !good_;
        on_centre = valid && good_;
        height = if_valid(result_.height);
        size = if_valid(std::abs(result_.height));
        sigma = if_valid(result_.sigma);
        within = if_valid(result_.within);
        tip_x = if_valid(result_.x);
        theta = if_valid(result_.theta * (180 / 3.14159265358979323846));
        by_diameter_1 = result_.by_diameter_1;
        by_diameter_2 = result_.by_diameter_2;
        by_travel = result_.by_travel;
        predicted = result_.predicted;
        disagreement = result_.disagreement;
        smallest_diameter = if_valid(2 * std::abs(result_.height));
        y_move = valid && result_.signed_ ? move_ : 0;
        x_correction = valid && result_.signed_ ? correction_ : 0;

        const double target = now.good ? now.target_diameter / 2 : 0;
        const bool reachable = valid && target > std::abs(result_.height);
        target_reachable = reachable;
        // The position of the first cut, further by the way of the tip to its new place.
        const double tip = reachable ? std::sqrt((target - result_.height) * (target + result_.height)) : 0;
        target_x = reachable ? (cuts_[0].x + tip - result_.x) * now.outward() : 0;

        const LandPair lands =
            now.good ? LandPair::of(now.land_step, now.land_diameter / 2, now.clearance, now.rubbing())
                     : LandPair{};
        land_1_y = lands.first;
        land_2_y = lands.second;
    }

    static bool known(double position) noexcept { return std::abs(position) <= HeightSettings::farthest; }

    Edge start_, abort_, resume_, stored_, cut_, value_, typed_, compute_;
    TurnedCuts cuts_;
    TipHeight result_;
    State state_ = State::idle, before_abort_ = State::idle;
    Fault fault_ = Fault::none, fault_before_abort_ = Fault::none;
    Hold hold_ = Hold::none;
    double y_origin_ = 0, move_ = 0, correction_ = 0;  // mu
    bool taken_ = false, good_ = false;
};

hal::Model hal::model() {
    return model_of<CentreHeight>();
}

}  // namespace plumb
