// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/squareness/compensated_tip.hpp"
#include "components/compensation/squareness/error_tables.hpp"
#include "components/compensation/squareness/settling.hpp"
#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/math/blocks/ramped_correction.hpp"
#include "hal/component.hpp"
#include "hal/message.hpp"
#include "hal/offset.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace plumb {

struct Squareness final : hal::Component {
    static constexpr hal::About about{"squareness",
                                      "corrects tilted columns and rails, for the tool in use",
                                      R"(
Guides are never quite square. Where a column or a rail leans, the tip of the tool is not where the axes are, and a longer
tool is further off. squareness takes the chain of axes and the tilt of each guide. It outputs the correction of X, Y and
Z that brings the tip to its nominal place, tool length and radial offset included. Error tables can add straightness,
pitch, yaw and scale. It needs no sensor; plumb-squareness(1) computes the settings from measurements.

The theory and the figures are in components/compensation/squareness/README.md of the sources.)",
                                      hal::Wiring{R"(
For X. Wire Y and Z in the same way.

  loadrt squareness names=square chain=w-Z.b-X-Y-C-t \
         unit=[TRAJ]LINEAR_UNITS
  loadrt joint_offset names=x-stage,y-stage,z-stage \
         unit=[TRAJ]LINEAR_UNITS

  setp square.enable    true
  setp square.max-speed [TRAJ]MAX_LINEAR_VELOCITY
  setp square.ec0y      -0.00016

  net x-position    joint.0.pos-cmd     => square.x-position
  net x-position                        => x-stage.position
  net x-velocity    joint.0.vel-cmd     => square.x-velocity
  net all-homed     motion.is-all-homed => square.all-homed
  net x-tool-offset motion.tooloffset.x => square.x-tool-offset
  net x-correction  square.x-correction => x-stage.offset-0
  net ramping       interlock.ramping   => square.stages-ramping
  net coordinated   motion.coord-mode   => square.coordinated
  net motion-type   motion.motion-type  => square.motion-type
  net path-velocity motion.current-vel  => square.path-velocity
  net settling      square.settling     => motion.feed-inhibit
  net settling                          => motion.feed-hold

  addf motion-command-handler  servo-thread
  addf x-stage.update-feedback servo-thread
  addf motion-controller       servo-thread
  addf square.update           servo-thread
  addf x-stage.update          servo-thread

The positions are those of joint.N.pos-cmd: they contain neither the correction nor screw compensation. Do not net
joint.N.motor-pos-cmd. joint_offset(9) has the other lines of a stage. interlock(9) joins ramping of all stages.
max-rate of a stage must be above the speed of the correction in a rapid, and max-offset at least max-correction.
configs/portal/stages.hal has all lines. For the feed-forward of a drive take x-corrected-velocity. A cross rail W that
corrects its own travel needs a stage too, with w-correction; configs/portal/w_axis.hal has its lines.)"},
                                      hal::SettingUp{R"(
1. Write the chain as in ISO 10791: the axes that carry the work before b, the bed; the axes that carry the tool after it.
w-Z.b-X-Y-C-t is a column on X with the spindle head on Y and the work on Z. w-X.b-W-Y-Z-C-t is a portal with a cross
rail W. X, Y and Z come in any order, with at most one of U, V and W.
2. Measure the tilts with enable false. plumb-squareness(1) turns the readings of square, diagonals or probe into setp
lines. The tilts are those of ISO 230-1 in rad, turns about X, Y and Z by the right hand. An axis leans to the side of its
+ end:

    Y to +X: EC0Y < 0   Z, W to +X: EB0Z, EB0W > 0   X to +Y: EC0X > 0
    Y to +Z: EA0Y > 0   Z, W to +Y: EA0Z, EA0W < 0   X to +Z: EB0X < 0

3. Set axis-direction false if all that an axis carries turns with its tilt, and true if the axes across it stay level.
Set to-bed true if the tilt of an axis on a parallel one, such as Z on W, was measured against the bed.
4. Set the pivots to the position where the tilts displace nothing, such as the place where the machine was squared.
Set L-tool-follows false for a spindle or table that was set up square on a leaning guide.
5. Check the sign with one move: with enable true, an indicator that climbs the square stands still.
6. Leave parallel-axis-corrects false if U, V or W is clamped while it cuts: it stays, and X, Y and Z correct for it. With
true it corrects its own travel: what its tilt, some nm, and the scale in its table, such as EZW, take from it.
7. For more than tilts, load tables of the errors of ISO 230-1, in mm and rad on every machine:

    # machine: portal mill 7
    # date: 2026-11-20
    # temperature: 20.1 degC
    Y,EXY,EYY,EZY,EAY,EBY,ECY
    0,0,0,0,0,0,0
    50,0.0012,-0.003,0,0,0,1.5e-5
    # end, seal 3fd7b136, 2 rows

The first column is the machine position. The last line counts the rows of all tables in the file, so that half a copy is
refused. The lines in front are optional. The seal is the CRC-32, as in zip, of all other lines that are not empty, each with a
line feed; with it, a changed or damaged file is refused. plumb squareness --table FILE checks a file, and with --seal writes
the seal. Without a seal, write # end, 2 rows: the table is used, and the load names it. Tables add to the tilts: do not give
one squareness in both. A rising edge of reload reads the tables again.
8. Keep unit=[TRAJ]LINEAR_UNITS in the loadrt line: on an inch machine it converts the defaults and the tables.
9. For a boring bar with its tip in one direction, set radial-offset and radial-direction. For a single-point tool that
the spindle turns to the contour, as in interpolation turning, set tip-on-contour true, and let the program call
o<contour_tip> instead of G41 or G42. configs/portal has the nets, contour_tip.hal, and the subroutine. The radius then
takes the place of radial-offset. See LIMITS.)"},
                                      hal::Behaviour{R"(
- Start, not homed: No correction, and nothing moves.
- All joints homed, enable, edited angle, new table: The correction changes at max-rate, at most. ramping is true meanwhile.
- Motion: The correction follows without lag. corrected-velocity is the velocity of joint and correction together.
- Machine off, emergency stop: joint_offset holds the correction, and turning on moves nothing.
- Abort: The correction stays.
- Another tool (G43, G49) or radial offset: The correction changes at max-rate; 50 um take half a second. settling is
true until ramping and stages-ramping are false, and LinuxCNC waits with the next move. Jogs do not wait.
- In a cut: settling is never true. A cut lasts from the first feed to the next rapid, or to the end of all motion.
- Settling ends early: unsettled is true, and unsettled-code gives the cause.
- tip-on-contour with G41 or G42: The radius points from the tool's axis to the contour, square to the commanded path.
The correction follows an arc without lag, at most at max-rate. At a corner the direction jumps, and the correction
changes at max-rate; 5 um take 50 ms. At rest the direction stays. G40 and jogs have no radius. settling stays false.
- compensation-side contradicts the sign of compensation-radius: After 1 s of motion the correction of the radius returns
to 0 at max-rate, and fault is true until they agree.
- Position faster than max-speed: A position that changes faster, by more than a tenth, did not move. The correction
follows at max-rate.
- Invalid position or tool offset: The last good value stays, and the velocity counts as 0.
- Invalid settings: The last good set stays in force, as a whole. Positions, tools, enable and all-homed go on.
- Invalid tables: None of the new ones is used. The old ones stay, and LinuxCNC shows file, line and reason.
- Position outside a table: The value at the end of the table holds.)"},
                                      hal::Limits{R"(
A square or a diagonal shows the corner between two axes, not which of the two leans. Where one axis carries the other,
its tilt turns both: let plumb-squareness(1) compute the setting.

Net both pins of settling. LinuxCNC 2.9 ignores feed-inhibit after M49 or M51 P0, and feed-hold after M53 P0. After M53 P0
together with one of the others, a cut begins early. LinuxCNC never holds threads and rigid taps: put a move before G33
and G33.1.

Never let o<contour_tip> give the radius of a rotating cutter. A rotating cutter cuts a floor with its lowest point, on
whichever side G41 has it: the correction would make an error of its own. G41 and G42 alone give no radius. The lathe
tools of G18 with an orientation are not supported.

Other ramps do not make settling true: enable, an edited angle, new tables, the machine turned on. Let a program wait
for them with M66 on the signal ramping.

A tilt is valid for the travel over which you measured it. Drift since the measurement remains.)"},
                                      hal::SeeAlso{"plumb-squareness(1), joint_offset(9), linuxcnc_link(1)"}};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::Option<std::string> chain{this, "chain", "w-X-Y.b-Z-C-t",
                                   "Axes that carry the work, before b, and the tool, after it."};
    hal::Option<std::string> table{this, "table", "",
                                   "CSV files of error tables, absolute paths, with : between."};
    hal::LengthUnit unit{this};

    hal::In<bool> enable{this, "enable", false, "Apply the correction; else 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    SquarenessSettings settings{this};
    hal::Axes<hal::In<double>, 3> tool_offset{this, "%-tool-offset", 0, "mu",
                                              "Offset of the tool in force, in %."};
    CompensatedTip compensated{this};
    hal::In<bool> stages_ramping{this, "stages-ramping", false, "The stage of an axis is ramping."};
    hal::In<bool> coordinated{this, "coordinated", true,
                              "Programs and MDI move the axes, not jogs: motion.coord-mode."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "Kind of motion: motion.motion-type."};
    hal::In<double> path_velocity{this, "path-velocity", 0, "mu/s",
                                  "Speed along the path: motion.current-vel."};
    hal::In<bool> reload{this, "reload", false, "A rising edge reads the tables again."};

    hal::Axes<hal::Out<double>, 6> correction{this, "%-correction", "mu", "Correction of %, for its stage."};
    hal::Axes<hal::Out<double>, 6> corrected_position{this, "%-corrected-position", "mu",
                                                      "Commanded position of % with its correction."};
    hal::Axes<hal::Out<double>, 6> corrected_velocity{this, "%-corrected-velocity", "mu/s",
                                                      "Commanded velocity of % with its correction."};
    hal::Axes<hal::Out<double>, 3> error{this, "%-error", "mu",
                                         "Error of the tip here without correction, in %."};
    hal::Out<bool> ramping{this, "ramping", "The correction still changes to its wanted value."};
    hal::Out<bool> settling{this, "settling", "The next cut has to wait for the correction of its tool."};
    hal::Codes<Settling::Ended> unsettled{
        this, "unsettled",
        "Settling ended too early; unsettled-code gives the cause, until the tool changes again."};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Out<bool> table_fault{this, "table-fault",
                               "The last reload failed; the tables before stay in force."};
    hal::Out<std::int32_t> tables{this, "tables", "Axes that have a table."};
    hal::Out<std::int32_t> serial{this, "serial", "Number of successful reloads of the tables."};

    hal::Offset moves[6]{{this, moving(correction[0])}, {this, moving(correction[1])},
                         {this, moving(correction[2])}, {this, moving(correction[3])},
                         {this, moving(correction[4])}, {this, moving(correction[5])}};

    hal::Function run{this, "update", &Squareness::update, hal::Place::source};

    void prepare() override {
        axes_ = AxisChainReader::read(chain);
        tables_.load(table, axes_);
        for (const std::string& fact : tables_.take_facts()) hal::report(fact.c_str());
        parallel_ = axes_.parallel_axis();
        model_ = SquarenessModel(axes_, unit.millimetres());
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
        const bool by_program = coordinated;
        compensated.step(model_.velocity(motion_), by_program);
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
        if (parallel_) {
            const auto i = static_cast<std::size_t>(*parallel_);
            correction[i] = parallel_ramp_.offset()[0];
            corrected_position[i] = motion_.position[3] + parallel_ramp_.offset()[0];
            corrected_velocity[i] = motion_.velocity[3] + parallel_ramp_.velocity()[0];
        }
        ramping = is_ramping();
        report(tool_known, jumped && was_active);
        settle(by_program, dt);
    }

private:
    static constexpr double play = 0.1;  // of max-speed: blended moves add up

    // The slope of six tilts of max-angle, and of tables.
    hal::MovingPin moving(const hal::Out<double>& its) {
        hal::MovingPin pin(its);
        pin.bound(settings.max_correction).rate(settings.max_rate).limited(limited.active());
        pin.accelerated_by("The stage limits its acceleration, joint_offset(9) by offset-acceleration.");
        for (const SquarenessAxis& axis : settings.axes) pin.motion(axis.position, 0.02);
        return pin;
    }

    // Reads positions and velocities of the axes; an invalid position keeps its last good value. Returns
    // whether a position has changed faster than its axis can move.
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

    // False if the tool is invalid; an invalid component keeps its last good value.
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

    // The correction at the present position, with the former and with the new settings. Motion did not
    // cause their difference, so the ramp takes it.
    void follow(bool edited, bool active, bool jumped, bool reloaded, double dt) noexcept {
        const Eigen::Vector3d mounted = tool_ + settings.radial();
        const Eigen::Vector3d tool = compensated.in_use() ? tool_ + compensated.radial() : mounted;
        tool_changed_ = mounted != mounted_;
        mounted_ = mounted;
        const SquarenessModel::Result last = result_;
        SquarenessModel::Result before = model_.at(motion_, reloaded ? tables_.before() : tables_.in_use());
        result_ = before;
        const bool set_anew = edited || reloaded || active != model_.active();
        if (set_anew || tool != model_.tool()) {
            if (set_anew)
                model_.set(settings.values(), tool, active);
            else
                model_.set_tool(tool);
            result_ = model_.at(motion_, tables_.in_use());
        }
        if (jumped || before.steady != last.steady) before = last;
        ramp_.step(result_.wanted, before.wanted, settings.values().max_rate, dt);
        parallel_ramp_.step(result_.wanted_parallel, before.wanted_parallel, settings.values().max_rate, dt);
    }

    bool is_ramping() const noexcept { return ramp_.ramping() || parallel_ramp_.ramping(); }

    void report(bool tool_known, bool jumped) noexcept {
        const bool active = model_.active();
        const Bound bound =
            hal::first<Bound>({{settings.limited(), Bound::angle},
                               {ramp_.limited() || parallel_ramp_.limited(), Bound::correction},
                               {active && jumped, Bound::jump},
                               {active && result_.beyond_table, Bound::table}});
        limited = bound;
        is_limited_ = bound != Bound::none;
        const Fault code = hal::first<Fault>({{!motion_known_, Fault::motion},
                                              {!tool_known, Fault::tool},
                                              {settings.fault() != Fault::none, settings.fault()},
                                              {tables_.refused(), Fault::tables},
                                              {!result_.steady, Fault::steep},
                                              {compensated.fault() != Fault::none, compensated.fault()}});
        fault = code;
        has_fault_ = code != Fault::none;
        table_fault = tables_.refused();
        std::int32_t count = 0;
        for (const auto& its : tables_.in_use()) count += its.has_value();
        tables = count;
        serial = serial_;
    }

    void settle(bool by_program, double dt) noexcept {
        const bool stages_ramp = stages_ramping;
        settling_.step({tool_changed_, is_ramping() || stages_ramp, model_.active(), has_fault_, is_limited_,
                        by_program, motion_type, path_velocity, settings.values().settling_time},
                       dt);
        settling = settling_.holds();
        unsettled = settling_.ended();
    }

    AxisChain axes_;
    std::optional<Axis> parallel_;  // U, V or W
    ErrorTables tables_;
    SquarenessModel model_{AxisChain{}, 1};
    SquarenessModel::Motion motion_;                  // last good values
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();  // mu, from the gauge point to the tip; last good values
    Eigen::Vector3d mounted_ = Eigen::Vector3d::Zero();  // mu, that tool with the radial offset
    bool motion_known_ = true;
    SquarenessModel::Result result_;
    RampedCorrection ramp_;
    RampedCorrectionOf<1> parallel_ramp_;  // of U, V or W
    bool reloading_ = true;                // a reload that is true already asks for nothing
    std::int32_t serial_ = 0;
    Settling settling_;
    bool tool_changed_ = false, has_fault_ = false, is_limited_ = false;  // in this period
};

hal::Model hal::model() {
    return model_of<Squareness>();
}

}  // namespace plumb
