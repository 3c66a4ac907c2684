// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/height_gauge.hpp"
#include "components/compensation/centre_height/height_orders.hpp"
#include "components/compensation/centre_height/height_outputs.hpp"
#include "components/compensation/centre_height/height_procedure.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "hal/component.hpp"

namespace plumb {

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
  net height-at-rest motion.digital-out-14 => centre.at-rest
  net height-stock   motion.analog-out-15  => centre.program-stock
  net height-measure centre.measure        => motion.digital-in-08
  net height-at-cut  centre.cut-taken      => motion.digital-in-14
  net height-taken   centre.value-taken    => motion.digital-in-09
  net height-valid   centre.value-valid    => motion.digital-in-10
  net move-allowed   centre.move-allowed   => motion.digital-in-11
  net height-y-move  centre.y-move         => motion.analog-in-08
  net height-x-move  centre.x-correction   => motion.analog-in-09

  addf motion-controller servo-thread
  addf centre.update     servo-thread

LinuxCNC needs num_dio=15 and num_aio=16 in the loadrt line of motmod. A gauge gives diameter and value-ready, and takes
measure as its request. configs/functions/centre_height has all lines, and M-codes for them.)"},
                                      hal::SettingUp{R"(
1. Set method 1, two lands. From the same stock and at the same X, cut a land with Y at land-1-y and one at land-2-y, both
against the present Y. Cut land 1, land 2, land 2, land 1 if you have room: wear and warming cancel.
2. Set gauge-sigma to the uncertainty of your gauge for a diameter. Keep cut-repeatability, unless you have measured it.
3. Set clearance-angle to that of the tool, and land-diameter. land-1-y and land-2-y then avoid the side that rubs.
4. Raise start at the Y for which you want the height. After each cut raise cut-done; measure becomes true. Set
entered-diameter and raise entered, or let a gauge give diameter and value-ready; value-taken becomes true. Lower all
again. When all cuts have their diameter, value-valid or fault becomes true. Set stock-diameter or program-stock to the
measured diameter of the stock: two lands that the tool did not reach are equal, as those of a tool on centre.
5. To compute without motion, set keyed, cuts, cut-diameter-N, cut-x-N and cut-y-N, and raise compute. For the two cuts of the
source you can enter travel, as a radius, in place of cut-x-N.
6. Watch height and sigma on a few parts. Then set automatic true, and move Y by y-move when move-allowed is true.
Correct the tool's X by x-correction when x-allowed is true.
7. Repeat until on-centre is true. If verdict-code is 5, the cuts do not show it: cut as many as cuts-needed.
8. Cut all diameters with a last pass of the same depth, and set pass-depth to it. The work bends by the depth of a pass; unequal
depths count in sigma by bend-per-depth.)"},
                                      hal::Behaviour{R"(
- start: The procedure begins. All cuts are forgotten; the present Y is the one for which height is valid.
- cut-done: X and Y of this moment are the positions of the cut. cut-taken and measure are true. A fast gauge answers at once, and
measure is false again; cut-taken stays until you lower cut-done.
- value-ready: The diameter counts. An entry that is a slip sets fault, and measure stays true: enter it again.
- All cuts have their diameter: height is computed. Each further cut is a check: it must agree with the others within three
sigmas.
- Method 0, two cuts: The height has no sign. Without sign, move-allowed stays false.
- Height and bend: height is the one under the cut, as long as all cuts have the depth of the finished part. Measure once more
with at-rest true, by spring passes: bend is then the difference of both heights of this tool. Y does not move by the one at rest.
- abort: A rising edge stops the procedure at any step, and no value is valid. A rising edge of resume continues with the cuts
that have their diameter; start begins again.
- stored: A rising edge ends the procedure and forgets the height, so that no program stores it twice.
- verdict-code: Y and X are two answers, each by its own sigma. The error of each is known to be within tolerance if its size
and 1.645 sigmas are at most tolerance, or known to be wrong if it is at least three sigmas, for Y by two cuts twice within.
- on-centre: Y and X are within tolerance. X counts if x-is-radius is true. Without the diameter of the stock on-centre stays false.
- Neither within tolerance nor wrong: hold-code is 3, nothing may be stored, and cuts-needed with remedy-code give the cuts that would
do, if the height is as measured. Further cuts belong to the same procedure.
- A cut counts only if its diameter is below that of the stock, by three sigmas of both, and follows from X of the tool within
max-x-correction and max-move; else fault 16 or 20.
- fault: No value is valid, and move-allowed is false.
- Settings: They count at the moment of value-ready and of compute.)"},
                                      hal::Limits{R"(
The height is the one under the cut: the work bends and the tool too. A light cut shows another height than a heavy one.
For the finished part, use the cut of the finished part.

One pair of lands takes wear between the two cuts for height.

With one entry a slip shows only against land-diameter, for two lands, or against the programmed radius, with x-is-radius
true. A wrong diameter within a factor of 1.4 shows only as a height beyond max-move or as disagreement; two diameters wrong
by the same few micrometres never show, nor do swapped diameters of one pair of lands, which reverse the sign. A travel entered in diameter shows against the positions of X, or as a tip past the axis, or as a height near the radius.

Two cuts of a work of D 10 to 5 move Y for heights from 0.28 mm on with a laser of 0.3 um, from 0.30 mm on with a
micrometer; of D 1 to 0.2 from 42 um on. Use two lands.)"},
                                      hal::SeeAlso{"motion(9), linuxcnc_link(1)"}};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    HeightOrders orders{this};
    hal::Row<hal::In<double>, HeightSettings::posts> x_position{this, "x-position", 0, "mu",
                                                                "Position of X, as a radius."};
    hal::Row<hal::In<double>, HeightSettings::posts> y_position{this, "y-position", 0, "mu",
                                                                "Position of Y."};
    hal::Row<hal::In<double>, HeightSettings::posts> x_zero{
        this, "x-zero", 0, "mu", "Position of X that the program calls 0, tool offset included."};
    HeightGauge gauge{this};
    KeyedCuts keyed_cuts{this};
    HeightSettings settings{this};

    hal::Out<bool> cut_taken{this, "cut-taken", "The position of the cut was taken, while cut-done is true."};
    hal::Out<bool> value_taken{this, "value-taken",
                               "The last diameter was taken, while value-ready is true."};
    HeightOutputs outputs{this};
    hal::Function run{this, "update", &CentreHeight::update, hal::Place::measurement};

    void update(double) noexcept {
        const HeightSettings::Values now = settings.values(orders.program_post, orders.program_method);
        const HeightOrders::Given given = orders.read();

        if (given.start) procedure_.begin(now, y_position[now.post], x_zero[now.post]);
        if (given.abort)
            procedure_.interrupt();
        else if (given.stored)
            procedure_.end();
        else if (given.resume)
            procedure_.go_on(now);
        else if (given.cut)
            cut_taken_ = procedure_.take_position(now, x_position[now.post], y_position[now.post]);
        else if ((given.value || given.entry) && procedure_.state() == State::measure)
            take_diameter(now, given);
        else if (given.compute && keyed_cuts.keyed)
            procedure_.compute(now, keyed_cuts.read(now, gauge.kind == 1));
        else if (given.compute)
            procedure_.compute(now, keyed_cuts.travel);
        cut_taken_ &= given.cut_done;
        taken_ &= given.value_ready || given.entered;

        outputs.show(procedure_, now);
        cut_taken = cut_taken_;
        value_taken = taken_;
    }

private:
    void take_diameter(const HeightSettings::Values& now, const HeightOrders::Given& given) noexcept {
        HeightProcedure::Entry entry;
        if (given.entry) {
            entry.diameter = gauge.as_diameter(orders.entered_diameter);
        } else {
            const HeightGauge::Reading reading = gauge.read();
            entry.diameter = reading.diameter;
            entry.by_beam = reading.by_beam;
        }
        entry.wanted = given.cuts >= 1 ? given.cuts : keyed_cuts.count;
        entry.travel = keyed_cuts.travel;
        procedure_.take_diameter(now, entry);
        taken_ = true;
    }

    HeightProcedure procedure_;
    bool cut_taken_ = false, taken_ = false;
};

hal::Model hal::model() {
    return model_of<CentreHeight>();
}

}  // namespace plumb
