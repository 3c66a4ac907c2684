// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/squareness/squareness_codes.hpp"
#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_motion.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/geometry/tip_correction.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/message.hpp"
#include "hal/offset.hpp"
#include "pages/squareness.page.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// The tip that is held to the contour of G41 or G42. A radius that G40 or the other side contradicts for a
// while in motion is not used. Looks are counted, not seconds: a program that is late contradicts nothing.
struct CompensatedTip final : hal::Group {
    using Group::Group;

    static constexpr double largest = 1e4;  // mu
    static constexpr int patience = 50;     // looks, 1 s: linuxcnc_link sees the side later than motion does

    hal::In<bool> on_contour{this, "tip-on-contour", false,
                             "Correct the radius of a single-point tip that is turned to the contour; never "
                             "for a rotating cutter."};
    hal::In<double> compensation_radius{
        this, "compensation-radius", 0, "mu",
        "Radius of cutter compensation, positive with G41, negative with G42, 0 with G40."};
    hal::In<double> compensation_plane{this, "compensation-plane", 17, "1",
                                       "Plane of cutter compensation, 17, 18 or 19."};
    hal::In<std::int32_t> compensation_side{
        this, "compensation-side", 2,
        "Side in the program: 1 for G41, -1 for G42, 0 for G40, 2 for unknown."};

    hal::In<bool> compensation_heartbeat{
        this, "compensation-heartbeat", false,
        "Changes each time that compensation-side is read: linuxcnc-link.heartbeat."};

    // The inputs of one period; the velocity of the path is finite, in mu/s.
    void step(const Eigen::Vector3d& velocity, bool coordinated) noexcept {
        const bool wanted = on_contour;
        const double given_radius = compensation_radius, given_plane = compensation_plane;
        const std::int32_t side = compensation_side;
        const bool beat = compensation_heartbeat, looked = beat != beat_;
        beat_ = beat;
        const bool radius_known = std::abs(given_radius) <= largest;
        const bool plane_known = given_radius == 0 || ContourTip::is_plane(given_plane);
        if (radius_known) radius_ = given_radius;
        if (ContourTip::is_plane(given_plane)) plane_ = static_cast<int>(given_plane);
        const double radius = wanted && coordinated ? radius_ : 0;

        const bool contradicted = radius != 0 && side >= -1 && side <= 1 && side != (radius > 0 ? 1 : -1);
        if (!contradicted)
            contradictions_ = 0;
        else if (looked && !velocity.isZero(0))
            contradictions_ = std::min(contradictions_ + 1, patience);
        const bool doubtful = contradictions_ == patience;

        tip_.step(velocity, radius, plane_);
        in_use_ = radius != 0 && !doubtful;
        fault_ = !wanted                          ? Fault::none
                 : !(radius_known && plane_known) ? Fault::contour
                 : doubtful                       ? Fault::side
                                                  : Fault::none;
    }

    bool in_use() const noexcept { return in_use_; }  // in the place of radial-offset
    const Eigen::Vector3d& radial() const noexcept {
        return tip_.vector();
    }  // mu, from the tool's axis to the tip
    Fault fault() const noexcept { return fault_; }

private:
    ContourTip tip_;
    double radius_ = 0;  // mu, the last good one
    int plane_ = 17;     // the last good one
    bool beat_ = false;
    int contradictions_ = 0;  // one after the other, in motion
    bool in_use_ = false;
    Fault fault_ = Fault::none;
};

struct Squareness final : hal::Component {
    static constexpr hal::About about{"squareness", "corrects tilted columns and rails, for the tool in use",
                                      page, "Squareness"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::Option<std::string> chain{
        this,
        "chain",
        "w-X-Y.b-Z-C-t",
        "Axes that carry the work, before b, and axes that carry the tool, after b; each has its pins.",
        {{"w-Y.b-U-X-Z-t", "U in chain"}, {"w-X.b-V-Y-Z-t", "V in chain"}, {"w-X.b-W-Y-Z-t", "W in chain"}}};
    hal::Option<std::string> rotary{
        this,
        "rotary",
        "",
        "Axes of the chain that are positioned, as AC; a C that is not named is a spindle, without pins.",
        {{"A chain=w-A-X-Y.b-Z-t", "A in rotary"},
         {"B chain=w-B-X-Y.b-Z-t", "B in rotary"},
         {"C chain=w-C-X-Y.b-Z-t", "C in rotary"}}};
    const AxisChain axes = AxisChainReader::read(chain, rotary);
    const std::string letters = axes.linear_letters();  // by coordinate()
    hal::Option<std::string> table{
        this, "table", "",
        "CSV files of error tables: absolute paths, separated by colons; none for no table."};
    hal::LengthUnit unit{this};

    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Apply the correction; false: it returns to 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    SquarenessSettings settings{this, axes};
    hal::Axes<hal::In<double>, 3> tool_offset{this, "%-tool-offset", 0, "mu",
                                              "Offset of the tool in force, in %."};
    CompensatedTip compensated{this};
    hal::In<bool> stages_ramping{this, "stages-ramping", false, "The stage of an axis is ramping."};
    hal::In<bool> coordinated{this, "coordinated", true,
                              "Programs and MDI move the axes, not jogs: motion.coord-mode."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0, "Kind of motion: motion.motion-type."};
    hal::In<double> path_velocity{this, "path-velocity", 0, "mu/s",
                                  "Speed along the path: motion.current-vel."};
    Reversal reversal{this, letters};
    hal::In<bool> reload{this, "reload", false, "A rising edge reads the tables again."};

    hal::Axes<hal::Out<double>> correction{this, letters, "%-correction", "mu",
                                           "Correction of %, for its stage."};
    hal::Axes<hal::Out<double>> corrected_position{this, letters, "%-corrected-position", "mu",
                                                   "Commanded position of % with its correction."};
    hal::Axes<hal::Out<double>> corrected_velocity{this, letters, "%-corrected-velocity", "mu/s",
                                                   "Commanded velocity of % with its correction."};
    hal::Axes<hal::Out<double>, 3> error{this, "%-error", "mu",
                                         "Error of the tip here without correction, in %."};
    hal::Out<bool> ramping{this, "ramping", "The correction is still ramping to its target."};
    hal::Out<bool> settling{this, "settling", "The next cut must wait for the correction of its tool."};
    hal::Codes<Settling::Ended> unsettled{
        this, "unsettled",
        "Settling ended too early; unsettled-code gives the cause, until the tool changes again."};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<SquarenessStatus> status{this, permission};
    hal::Out<bool> table_fault{this, "table-fault",
                               "The last reload failed; the former tables stay in force."};
    hal::Out<std::int32_t> tables{this, "tables", "Number of axes with a table."};
    hal::Out<std::int32_t> serial{this, "serial", "Number of successful reloads of the tables."};

    hal::Offset moves{this, correction, [this](const auto& its) { return moving(its); }};

    hal::Effects applies{this, hal::Effect::applies, all_homed};
    hal::Effects at_once{this, hal::Effect::at_once, tool_offset, compensated.on_contour, reload};

    hal::Function run{this, "update", &Squareness::update, hal::Place::source};

    void prepare() override {
        tables_.load(table, axes);
        for (const std::string& fact : tables_.take_facts()) hal::report(fact.c_str());
        model_.set(settings.values(), reader_.tool(), false);
    }

    bool has_background() const noexcept override { return tables_.any(); }

    void background() override {
        const std::string reason = tables_.work();
        for (const std::string& fact : tables_.take_facts()) hal::report(fact.c_str());
        if (!reason.empty()) hal::report_error((reason + "; the tables before stay in force").c_str());
    }

    void update(double dt) noexcept {
        permission.step();
        const bool jumped = reader_.read_motion(settings, dt * (1 + play));
        reader_.read_tool(tool_offset);
        const bool by_program = coordinated;
        compensated.step(model_.velocity(reader_.motion()), by_program);
        const bool left_out = reversal.watch_compensation(tables_.in_use());
        const bool edited = settings.judge() || left_out;
        const bool reloaded = take_over_tables();
        reversal.move(settings.values(), reloaded || left_out, dt);
        const bool homed = all_homed, enabled = permission.enabled(), was_active = model_.active();
        follow(edited, enabled && homed && settings.complete(), jumped, reloaded, dt);

        const SquarenessModel::Motion& motion = reader_.motion();
        AxisPosition offset, velocity;
        offset << ramps_.xyz.offset(), ramps_.parallel.offset();
        velocity << ramps_.xyz.velocity(), ramps_.parallel.velocity();
        for (std::size_t i = 0; i < letters.size(); ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            correction[i] = offset[k];
            corrected_position[i] = motion.position[k] + offset[k];
            corrected_velocity[i] = motion.velocity[k] + velocity[k];
        }
        for (int i = 0; i < 3; ++i) error[i] = homed ? result_.error[i] : 0;
        reversal.watch(motion.position - result_.reversal + offset, jumped || left_out,
                       settings.values().reversal_distance, result_);
        ramping = ramps_.ramping();
        report(jumped && was_active);
        settle(by_program, dt);
        show_status(enabled, homed);
        permission.report({false, true, settling_.holds(), ramps_.ramping()});
    }

private:
    static constexpr double play = 0.1;  // of max-speed: blended moves add up

    // The slope of six tilts of max-angle, and of tables.
    hal::MovingPin moving(const hal::Out<double>& its) {
        hal::MovingPin pin(its);
        pin.bound(settings.max_correction).rate(settings.max_rate).limited(limited.active());
        pin.turning(settings.reversal_rate, settings.reversal_acceleration);
        pin.accelerated_by("The stage limits its acceleration, joint_offset(9) by offset-acceleration.");
        for (const SquarenessAxis& axis : settings.axes) pin.motion(axis.position, 0.02);
        for (const SquarenessRotary& axis : settings.rotaries) pin.motion(axis.position, 0.05);  // mu per deg
        return pin;
    }

    bool take_over_tables() noexcept {
        if (reload_.rises(reload)) tables_.ask();
        const bool reloaded = tables_.take_over();
        serial_ += reloaded;
        return reloaded;
    }

    // The correction at the present position, with the former and with the new settings. Motion did not
    // cause their difference, so the ramp takes it.
    void follow(bool edited, bool active, bool jumped, bool reloaded, double dt) noexcept {
        const Eigen::Vector3d mounted = reader_.tool() + settings.radial();
        const Eigen::Vector3d tool =
            compensated.in_use() ? Eigen::Vector3d(reader_.tool() + compensated.radial()) : mounted;
        tool_changed_ = mounted != mounted_;
        mounted_ = mounted;
        const SquarenessModel::Result last = result_;
        SquarenessModel::Result before =
            model_.at(reader_.motion(), reversal.now(), reloaded ? tables_.before() : tables_.in_use());
        result_ = before;
        const bool set_anew = edited || reloaded || active != model_.active();
        if (set_anew || tool != model_.tool()) {
            if (set_anew)
                model_.set(settings.values(), tool, active),
                    model_.leave_out(reversal.twice(), reversal.learned());
            else
                model_.set_tool(tool);
            result_ = model_.at(reader_.motion(), reversal.now(), tables_.in_use());
        }
        if (jumped || before.steady != last.steady) before = last;
        ramps_.step(result_, before, settings.values().max_rate, dt);
    }

    void report(bool jumped) noexcept {
        const bool active = model_.active();
        const Bound bound = hal::first<Bound>({{settings.limited(), Bound::angle},
                                               {ramps_.limited(), Bound::correction},
                                               {active && jumped, Bound::jump},
                                               {active && result_.beyond_table, Bound::table}});
        limited = bound;
        is_limited_ = bound != Bound::none;
        const Fault code = hal::first<Fault>({{!reader_.motion_known(), Fault::motion},
                                              {!reader_.tool_known(), Fault::tool},
                                              {settings.fault() != Fault::none, settings.fault()},
                                              {tables_.refused(), Fault::tables},
                                              {result_.singular, Fault::singular},
                                              {!result_.steady, Fault::steep},
                                              {compensated.fault() != Fault::none, compensated.fault()},
                                              {reversal.any_twice(), Fault::twice},
                                              {reversal.any_learned(), Fault::learned}});
        fault = code;
        has_fault_ = code != Fault::none;
        table_fault = tables_.refused();
        tables = count_ = tables_.count();
        serial = serial_;
    }

    void settle(bool by_program, double dt) noexcept {
        const bool stages_ramp = stages_ramping;
        all_ramping_ = ramps_.ramping() || stages_ramp;
        settling_.step({tool_changed_, all_ramping_, model_.active(), has_fault_, is_limited_, by_program,
                        motion_type, path_velocity, settings.values().settling_time},
                       dt);
        settling = settling_.holds();
        unsettled = settling_.ended();
        cut_in_doubt_ = reversal.cut_in_doubt(settling_.cuts(), dt);
    }

    void show_status(bool enabled, bool homed) noexcept {
        SquarenessSeen seen;
        seen.fault = has_fault_;
        seen.set = settings.any_tilt() || count_ > 0;
        seen.without_effect = count_ == 0 && !model_.displaces() && result_.error.isZero(1e-9);
        seen.enabled = enabled;
        seen.homed = homed;
        seen.ramping = all_ramping_;
        seen.bounded = is_limited_;
        seen.unsettled = settling_.ended() != Settling::Ended{};
        seen.doubtful = reversal.doubtful_now();
        seen.cut_in_doubt = cut_in_doubt_;
        seen.interlock = status.of_interlock();
        status = status_of(seen);
    }

    ErrorTables tables_;
    SquarenessModel model_{axes, unit.millimetres()};
    MotionReader reader_;
    Eigen::Vector3d mounted_ = Eigen::Vector3d::Zero();  // mu, the tool with the radial offset
    SquarenessModel::Result result_;
    CorrectionRamps ramps_;
    Edge reload_{true};                    // a reload that is true already asks for nothing
    std::int32_t serial_ = 0, count_ = 0;  // of reloads, of axes with a table
    Settling settling_;
    bool tool_changed_ = false, has_fault_ = false, is_limited_ = false;  // in this period
    bool all_ramping_ = false;                                            // the stages, too
    bool cut_in_doubt_ = false;
};

hal::Model hal::model() {
    return model_of<Squareness>();
}

}  // namespace plumb
