// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/squareness/error_tables.hpp"
#include "components/compensation/squareness/settling.hpp"
#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/math/blocks/ramped_correction.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"
#include "hal/offset.hpp"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace plumb {

struct Squareness final : hal::Component {
    static constexpr hal::About about{"squareness", "correct tilted columns and rails, with the tool", R"(
On a machine whose columns and rails lean the tip of the tool is not where the axes say, and the longer the tool, the
further off it is.  The operator tells which axes carry the work and which the tool, and by how much each of them leans;
the correction brings the tip to where an ideal machine would have it, tool length and radial offset included:

    tip(q + c) = ideal tip(q)      q = position - pivot      x-, y-, z-correction = c, within max-correction

    tip = (transforms of the work's side)^-1 (transforms of the tool's side) T        T from the gauge point to the tip
    transform of an axis = R(EA0, EB0, EC0) . move by q + (EX, EY, EZ) . R(EA, EB, EC)       R = Rz(EC) Ry(EB) Rx(EA)

solved exactly, not to first order; everything behind an axis turns with it, and on the work's side q and (EX, EY, EZ)
count negative.  The axis parallel to X, Y or Z is clamped when cutting: its share is corrected by X, Y and Z.

The chain is written as in ISO 10791, without primes: w-Z.b-X-Y-C-t is a table that moves in Z, and a column on X that
carries the spindle in Y; w-X.b-W-Y-Z-C-t a portal whose cross rail moves in W.  Before b, the bed, is what carries the
work w, after it what carries the tool t: X, Y and Z in any order, and at most one of U, V and W.

The tilts are the quantities of ISO 230-1, in rad, that is, turns of the axis about X, Y and Z by the right hand.  An axis
leans to where its + end lies:

    Y leans to +X: EC0Y < 0      Z, W lean to +X: EB0Z, EB0W > 0      X leans to +Y: EC0X > 0
    Y leans to +Z: EA0Y > 0      Z, W lean to +Y: EA0Z, EA0W < 0      X leans to +Z: EB0X < 0

A square on the table sees the corner of two axes.  If it shows that the + end of Y lies 20 um per 300 mm towards +X, ec0y
is -66.7e-6 on a column, where Y does not carry X.  Where Y carries X, as in the default chain, that tilt turns X and the
work, too, and alone corrects nothing: there ec0x is 66.7e-6 beside it, which takes them back.  `plumb squareness --square`
tells what to set on which chain.  Check the sign with one move: with enable true the indicator that climbs the square
must stand still.

axis-direction says what a tilt turns: all that the axis carries, so that a rail that leans takes the saddle with it
(false), or only the axes parallel to it, and the tool, so that the saddle stays level (true).  to-bed says against what
the tilt of an axis was measured that rides on one parallel to it, as Z on W: the rail (false), or the bed (true), which
replaces the tilt of the rail.  With L-tool-follows false the spindle, or the table, was set up square in spite of the
tilt of L.  At L-pivot the tilt of L displaces nothing: where the machine was squared, or its origin.

T is minus the tool offset, plus radial-offset in radial-direction: a boring bar's tip, or the cutter's side that cuts
(radial-is-diameter where D words hold diameters).  The reference tool is the one that the origin of the work was set
with, for whoever sets it without the correction: what the tilts do to that tool is in the origin already.

Tables hold all errors of an axis over its position, by the names of ISO 230-1, in mm and rad whatever the machine
unit, such as

    # machine: portal mill 7
    # date: 2026-11-20
    # temperature: 20.1 degC
    # checksum: dd405666
    Y,EXY,EYY,EZY,EAY,EBY,ECY
    0,0,0,0,0,0,0
    50,0.0012,-0.003,0,0,0,1.5e-5
    # end, 2 rows

for Y at its machine positions, whatever the pivot.  The last line counts the rows of all tables in the file.  Without
it, or with another count, a part of the file may be missing: the file is refused, and the message prints the line to
add.  The four lines in front may be left out, and are shown where LinuxCNC was started from when the file is read.  The
checksum is the CRC-32, as in zip, of the lines that do not begin with #, without blanks at their ends, a line feed
behind each.  A wrong one is refused, and the message prints the right one.  They count beside the tilts: do not give the same squareness in both.
Between rows they are cubic; beyond the ends the last value holds.  A rising edge of reload has them read anew, aside:
it takes some 0.1 s and the time to read.  Good ones take over by max-rate, and serial counts up; of bad ones none is
taken, those before stay, and LinuxCNC shows file, line and reason.

Motion is followed without lag: corrected-velocity is that of joint and correction together, from the slopes of the
model, not from differences.  What motion did not cause comes by max-rate, as a vector: enable, homed, an
edited angle, G43, another radial offset or pivot, tables.  An angle may be driven, as by heat; slower than max-rate
it is followed without lag, too.  A position that changes faster than max-speed by more than a tenth did not move.

Wiring, here of X and of the tool; the other axes of the chain likewise:

    setp square.max-speed [TRAJ]MAX_LINEAR_VELOCITY

    net x-position-cmd joint.0.pos-cmd       => square.x-position x-stage.position
    net x-velocity-cmd joint.0.vel-cmd       => square.x-velocity
    net all-homed      motion.is-all-homed   => square.all-homed
    net tool-x         motion.tooloffset.x   => square.x-tool-offset
    net tool-y         motion.tooloffset.y   => square.y-tool-offset
    net tool-z         motion.tooloffset.z   => square.z-tool-offset
    net x-correction   square.x-correction   => x-stage.offset-0

    addf motion-command-handler  servo-thread
    addf x-stage.update-feedback servo-thread
    addf motion-controller       servo-thread
    addf square.update           servo-thread
    addf x-stage.update          servo-thread

The positions are those of joint.N.pos-cmd, which the correction is not in, and not of motor-pos-cmd, which screw
compensation is in.  max-speed is a speed that no axis exceeds, in a joint's jog neither.  The stage is joint_offset: its max-rate must be above the speed of the correction in a rapid, and
its max-offset not below max-correction.  corrected-velocity is for the feed-forward of a drive.

After G43 or G49 the tip comes to its place by max-rate: 50 um take half a second, in which a cut would begin as much off.
settling is true from there until ramping and stages-ramping are false.  Another radial-offset or
direction, as another tool brings it, starts it, too.  With

    net ramping        on-its-way.out     => square.stages-ramping
    net coordinated    motion.coord-mode  => square.coordinated
    net motion-type    motion.motion-type => square.motion-type
    net path-velocity  motion.current-vel => square.path-velocity
    net settling       square.settling    => motion.feed-inhibit motion.feed-hold

LinuxCNC waits at the start of the next move, a rapid too, in programs and MDI.  on-its-way is the or of ramping of all
stages.  Jogs do not wait.

settling is never true in a cut, that is, from the first motion that is no rapid until a rapid or the end of all motion,
a hold in between included.  It ends early, with unsettled, where the correction is switched off, has a fault or is limited,
after settling-time, and where a cut begins all the same.

Net both pins.  LinuxCNC 2.9 ignores feed-inhibit after M49 or M51 P0, and feed-hold after M53 P0.  After M53 P0 with one of
the others nothing holds: the cut begins early, and unsettled-code is 5.  The same goes for threads and rigid taps, which
LinuxCNC never holds: have a move in front of G33 or G33.1.  Ramps of other causes do not make settling true: enable, an
edited angle, new tables, the machine turned on.  A program waits for all of them by M66 on the signal ramping.

Positions, tool offsets, enable and all-homed are no settings, and go on while a set is refused.  The defaults are for
millimetres; on an inch machine set the option unit, and divide max-correction and max-rate by 25.4.

Sources: ISO 230-1 (names and signs), ISO 10791 (chains), JP7448336B2 and US 11,241,766 (tilts by direction and angle,
tool vector; not to the letter: there the turned tool and the length of the tool in the portal are left out).)"};

    using Component::Component;

    hal::Option<std::string> chain{this, "chain", "w-X-Y.b-Z-C-t",
                                   "Which axes carry the work, before b, and the tool, after it."};
    hal::Option<std::string> table{this, "table", "",
                                   "CSV files of error tables, absolute paths, with : between."};
    hal::Option<std::string> unit{this, "unit", "mm", "Machine unit, mm or inch."};

    hal::In<bool> enable{this, "enable", false, "Apply the correction; else 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    SquarenessSettings settings{this};
    hal::Axes<hal::In<double>, 3> tool_offset{this, "%-tool-offset", 0, "mu",
                                              "Offset of the tool in force, in %."};
    hal::In<bool> stages_ramping{this, "stages-ramping", false, "The stage of an axis is ramping."};
    hal::In<bool> coordinated{this, "coordinated", true,
                              "Programs and MDI move the axes, not jogs: motion.coord-mode."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "Kind of motion: motion.motion-type."};
    hal::In<double> path_velocity{this, "path-velocity", 0, "mu/s",
                                  "How fast they do it: motion.current-vel."};
    hal::In<bool> reload{this, "reload", false, "Read the tables anew, when it rises."};

    hal::Axes<hal::Out<double>, 3> correction{this, "%-correction", "mu", "Correction of %, for its stage."};
    hal::Axes<hal::Out<double>, 3> corrected_position{this, "%-corrected-position", "mu",
                                                      "Commanded position of % with its correction."};
    hal::Axes<hal::Out<double>, 3> corrected_velocity{this, "%-corrected-velocity", "mu/s",
                                                      "Commanded velocity of % with its correction."};
    hal::Axes<hal::Out<double>, 3> error{this, "%-error", "mu",
                                         "Error of the tip here without correction, in %."};
    hal::Out<bool> ramping{this, "ramping", "The correction is on its way to what is wanted."};
    hal::Out<bool> settling{this, "settling", "The next cut has to wait for the correction of its tool."};
    hal::Codes<Settling::Ended> unsettled{
        this, "unsettled",
        "Settling ended too early; unsettled-code gives the cause, until the tool changes again."};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Out<bool> table_fault{this, "table-fault", "The tables could not be read anew; those before stay."};
    hal::Out<std::int32_t> tables{this, "tables", "Axes that have a table."};
    hal::Out<std::int32_t> serial{this, "serial", "How often tables were read anew and taken over."};

    hal::Offset moves[3]{
        {this, moving(correction[0])}, {this, moving(correction[1])}, {this, moving(correction[2])}};

    hal::Function run{this, "update", &Squareness::update,
                      "After motion-controller and before the stages of the joints."};

    void prepare() override {
        if (unit.get() != "mm" && unit.get() != "inch")
            throw std::invalid_argument("unit=" + unit.get() + ": mm and inch are possible");
        axes_ = AxisChainReader::read(chain);
        tables_.load(table, axes_);
        for (const std::string& fact : tables_.take_facts()) hal::report(fact.c_str());
        model_ = SquarenessModel(axes_, unit.get() == "inch" ? 25.4 : 1);
        settings.judge(axes_);
        model_.set(settings.values(), tool_, false);
    }

    bool has_background() const noexcept override { return tables_.any(); }

    void background() override {
        const std::string reason = tables_.work();
        for (const std::string& fact : tables_.take_facts()) hal::report(fact.c_str());
        if (!reason.empty()) hal::report_error((reason + "; the tables before stay in force").c_str());
    }

    void update(double dt) noexcept {
        const bool jumped = read_motion(dt);
        const bool tool_known = read_tool();
        const bool edited = settings.judge(axes_);
        const bool reloaded = take_over_tables();
        const bool homed = all_homed, was_active = model_.active();

        follow(edited, enable && homed && settings.complete(), jumped, reloaded, dt);

        for (int i = 0; i < 3; ++i) {
            correction[i] = ramp_.offset()[i];
            corrected_position[i] = motion_.position[i] + ramp_.offset()[i];
            corrected_velocity[i] = motion_.velocity[i] + ramp_.velocity()[i];
            error[i] = homed ? result_.error[i] : 0;
        }
        ramping = ramp_.ramping();
        report(tool_known, jumped && was_active);
        settle(dt);
    }

private:
    static constexpr double play = 0.1;  // of max-speed: blended moves add up

    // The slope of six tilts of max-angle, and of tables.
    hal::MovingPin moving(const hal::Out<double>& its) {
        hal::MovingPin pin(its);
        pin.bound(settings.max_correction).rate(settings.max_rate).limited(limited.active());
        for (const SquarenessAxis& axis : settings.axes) pin.motion(axis.position, 0.02);
        return pin;
    }

    // Positions and velocities of the axes that there are.  Whether one has changed faster than it can move.
    // Of what is not known the last good position stays, and so does not move.
    bool read_motion(double dt) noexcept {
        bool jumped = false;
        motion_known_ = true;
        const double way = settings.values().max_speed * dt * (1 + play);
        for (const AxisBranch* branch : {&axes_.work, &axes_.tool}) {
            for (const Axis axis : *branch) {
                const SquarenessAxis& pins = settings.axes[static_cast<std::size_t>(axis)];
                const double p = pins.position, v = pins.velocity;
                double& position = motion_.position[coordinate(axis)];
                double& velocity = motion_.velocity[coordinate(axis)];
                const double last = position;
                const bool known =
                    std::abs(p) <= SquarenessAxis::farthest && std::abs(v) <= SquarenessAxis::farthest;
                motion_known_ &= known;
                position = usable(p, SquarenessAxis::farthest, position);
                velocity = known ? v : 0;
                jumped |= std::abs(position - last) > way;
            }
        }
        return jumped;
    }

    // False for what cannot be; the last good offset stays.
    bool read_tool() noexcept {
        bool known = true;
        for (int i = 0; i < 3; ++i) {
            const double offset = tool_offset[i];
            known &= std::abs(offset) <= SquarenessSettings::longest;
            tool_[i] = -usable(offset, SquarenessSettings::longest, -tool_[i]);
        }
        return known;
    }

    bool take_over_tables() noexcept {
        const bool reloading = reload;
        if (reloading && !reloading_) tables_.ask();
        reloading_ = reloading;
        const bool reloaded = tables_.take_over();
        serial_ += reloaded;
        return reloaded;
    }

    // The correction by what was in force until now, where the axes are now, and by what is in force from now
    // on: their difference is what motion did not cause.
    void follow(bool edited, bool active, bool jumped, bool reloaded, double dt) noexcept {
        const Eigen::Vector3d tool = tool_ + settings.radial();
        tool_changed_ = tool != model_.tool();
        const SquarenessModel::Result last = result_;
        SquarenessModel::Result before = model_.at(motion_, reloaded ? tables_.before() : tables_.in_use());
        result_ = before;
        if (edited || reloaded || active != model_.active() || tool != model_.tool()) {
            model_.set(settings.values(), tool, active);
            result_ = model_.at(motion_, tables_.in_use());
        }
        if (jumped || before.steady != last.steady) before = last;
        ramp_.step(result_.wanted, before.wanted, settings.values().max_rate, dt);
    }

    void report(bool tool_known, bool jumped) noexcept {
        const bool active = model_.active();
        const Bound bound = hal::first<Bound>({{settings.limited(), Bound::angle},
                                               {ramp_.limited(), Bound::correction},
                                               {active && jumped, Bound::jump},
                                               {active && result_.beyond_table, Bound::table}});
        limited = bound;
        is_limited_ = bound != Bound::none;
        const Fault code = hal::first<Fault>({{!motion_known_, Fault::motion},
                                              {!tool_known, Fault::tool},
                                              {settings.fault() != Fault::none, settings.fault()},
                                              {tables_.refused(), Fault::tables},
                                              {!result_.steady, Fault::steep}});
        fault = code;
        has_fault_ = code != Fault::none;
        table_fault = tables_.refused();
        std::int32_t count = 0;
        for (const auto& its : tables_.in_use()) count += its.has_value();
        tables = count;
        serial = serial_;
    }

    void settle(double dt) noexcept {
        const bool stages_ramp = stages_ramping;
        settling_.step(
            {tool_changed_, ramp_.ramping() || stages_ramp, model_.active(), has_fault_, is_limited_,
             coordinated, motion_type, path_velocity, settings.values().settling_time},
            dt);
        settling = settling_.holds();
        unsettled = settling_.ended();
    }

    AxisChain axes_;
    ErrorTables tables_;
    SquarenessModel model_{AxisChain{}, 1};
    SquarenessModel::Motion motion_;                  // the last good one
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();  // likewise; mu, from the gauge point to the tip
    bool motion_known_ = true;
    SquarenessModel::Result result_;
    RampedCorrection ramp_;
    bool reloading_ = true;  // a reload that is true already asks for nothing
    std::int32_t serial_ = 0;
    Settling settling_;
    bool tool_changed_ = false, has_fault_ = false, is_limited_ = false;  // in this period
};

hal::Model hal::model() {
    return model_of<Squareness>();
}

}  // namespace plumb
