// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "components/plants/sim_portal/box_artifact.hpp"
#include "components/plants/sim_portal/portal_axis.hpp"
#include "pages/sim_portal.page.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

struct SimPortal final : hal::Component {
    static constexpr hal::About about{"sim_portal", "simulated machine with tilted columns and rails", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine; 0 has no error but its tilts."};
    hal::In<bool> portal{this, "portal", false, "The machine is the portal, not the column."};
    hal::In<bool> axis_direction{this, "axis-direction", false,
                                 "Guides that cross a tilted one below them were shimmed true."};
    hal::In<bool> to_bed{this, "to-bed", false,
                         "The tilt of Z on W is the one against the bed, not against the rail."};
    PortalAxis x{{this, 'x'}, 0}, y{{this, 'y'}, 1}, z{{this, 'z'}, 2}, w{{this, 'w'}, 2};
    hal::In<bool> w_clamped{this, "w-clamped", false, "W stands clamped, at any command."};
    hal::In<double> tool_length{this, "tool-length", 0, "mu",
                                "True length of the tool towards -Z; negative towards +Z."};
    hal::In<double> radial_offset{this, "radial-offset", 0, "mu",
                                  "True distance of the tip from the spindle's axis."};
    hal::In<double> radial_direction{this, "radial-direction", 0, "deg",
                                     "Direction of the tip from the axis, from +X towards +Y."};
    hal::In<double> drift_start{this, "drift-start", 0, "s",
                                "Time since the tilts were measured, when the machine starts."};
    hal::In<std::int32_t> gauge_axis{this, "gauge-axis", 0, "Axis under the instrument: 0 X, 1 Y, 2 Z, 3 W."};
    hal::In<double> gauge_position{this, "gauge-position", 0, "mu", "Position of that axis."};
    hal::In<double> gauge_noise{this, "gauge-noise", 0, "mu", "Noise of the indicators on the tip, rms."};
    hal::In<double> gauge_scale{this, "gauge-scale", 0, "1", "Scale error that the indicators share."};
    hal::In<double> gauge_drift{this, "gauge-drift", 0, "mu/s", "Drift of the zeros of the indicators."};

    Drawn servo_gain{this, "servo-gain", 30, 17, 60, "1/s", "Gain of the position loops"};
    Drawn ram_sag{
        this, "ram-sag", 0, 0.01, 0.03, "mu", "Bend of the portal's ram, all of Z's travel outside"};
    Drawn tilt_drift{this, "tilt-drift", 0, 2e-6, 10e-6, "rad", "Largest change of each tilt in an hour"};

    hal::Axes<hal::Out<double>, 3> truth_tip{this, "truth-%-tip", "mu", "% of the tip in the work."};
    hal::Axes<hal::Out<double>, 3> truth_nominal{this, "truth-%-nominal", "mu",
                                                 "% that the tip should have."};
    hal::Axes<hal::Out<double>, 3> truth_error{this, "truth-%-error", "mu", "Error of the tip in %."};
    hal::Axes<hal::Out<double>, 3> truth_beyond{
        this, "truth-%-beyond-tilts", "mu",
        "The part of the error that the tilts of the start do not cause."};
    hal::Axes<hal::Out<double>, 3> indicator{
        this, "%-indicator", "mu", "Tip error in % as an indicator reads it, with noise, scale and drift."};
    hal::Out<double> gauge_ex{this, "truth-gauge-ex", "mu", "EX of the gauged axis there."};
    hal::Out<double> gauge_ey{this, "truth-gauge-ey", "mu", "EY of the gauged axis there."};
    hal::Out<double> gauge_ez{this, "truth-gauge-ez", "mu", "EZ of the gauged axis there."};
    hal::Out<double> gauge_ea{this, "truth-gauge-ea", "rad", "EA of the gauged axis there."};
    hal::Out<double> gauge_eb{this, "truth-gauge-eb", "rad", "EB of the gauged axis there."};
    hal::Out<double> gauge_ec{this, "truth-gauge-ec", "rad", "EC of the gauged axis there."};
    BoxArtifact artifact{this};
    hal::Function run{this, "update", &SimPortal::update, hal::Place::machine,
                      "After the commands of the axes."};

    void update(double dt) noexcept {
        if (seed_ != seed || !started_) start(seed);
        time_ += dt;
        drift_began_ = usable(drift_start, 1e8, drift_began_);
        is_portal_ = portal;
        whole_ = !axis_direction;
        against_bed_ = to_bed;
        const double gain = std::max(servo_gain(seed_), 1.0);
        const double hours = (drift_began_ + time_) / 3600;
        const double drift = std::clamp(tilt_drift(seed_) * hours, -largest_drift, largest_drift);
        x.move(gain, 0, false, dt);
        y.move(gain, is_portal_ ? 0 : drift, false, dt);
        z.move(gain, is_portal_ ? drift : 0, false, dt);
        w.move(gain, is_portal_ ? drift : 0, w_clamped, dt);

        const double rail = is_portal_ ? 1 : 0;
        const Eigen::Vector3d mounted = tool();
        const Eigen::Vector3d pivot(x.pivot(), y.pivot(), z.pivot() + rail * w.pivot());
        const Eigen::Vector3d ideal(x.ideal_position(), y.ideal_position(),
                                    z.ideal_position() + rail * w.ideal_position());
        const auto as_is = [](PortalAxis& axis, const Eigen::Vector3d& bent) { return axis.as_is(bent); };
        const auto by_tilts = [](PortalAxis& axis, const Eigen::Vector3d&) { return axis.by_tilts(); };
        const Eigen::Vector3d tip = tip_of(mounted, as_is, is_) + pivot;
        show(tip, ideal + mounted, tip_of(mounted, by_tilts, tilted_) + pivot);
        measure();
        indicate();
        artifact.meet(tip);
    }

private:
    static constexpr double largest_drift = 1e-3;  // rad

    // The machine at its start: its axes are at rest at their commands.
    void start(std::int32_t number) noexcept {
        for (PortalAxis* const axis : {&x, &y, &z, &w}) axis->start(number, !started_);
        started_ = true;
        seed_ = number;
        random_ = Random(static_cast<std::uint32_t>(number), 'i');
    }

    Eigen::Vector3d tool() noexcept {
        length_ = usable(tool_length, 1e4, length_);
        radius_ = usable(radial_offset, 1e4, radius_);
        direction_ = usable(radial_direction, 1e5, direction_);
        const double angle = direction_ * pi / 180;
        return {radius_ * std::cos(angle), radius_ * std::sin(angle), -length_};
    }

    // The bodies of both machines.
    struct Chains {
        BodyChain<3> portal_head;
        BodyChain<2> column_head;
        BodyChain<1> table;
    };

    template <class BodyOf>
    Eigen::Vector3d tip_of(const Eigen::Vector3d& mounted, BodyOf body, Chains& chains) noexcept {
        const Eigen::Vector3d none = Eigen::Vector3d::Zero();
        if (is_portal_) {
            const std::array<GuidedBody, 3> head{body(w, none), body(y, none), body(z, bend(z.position()))};
            const std::array<GuidedBody, 1> table{body(x, none)};
            return chains.table.end(table, whole_, against_bed_, -1).inverse() *
                   (chains.portal_head.end(head, whole_, against_bed_, 1) * mounted);
        }
        const std::array<GuidedBody, 2> head{body(x, none), body(y, none)};
        const std::array<GuidedBody, 1> table{body(z, none)};
        return chains.table.end(table, whole_, against_bed_, -1).inverse() *
               (chains.column_head.end(head, whole_, against_bed_, 1) * mounted);
    }

    // The bend of the ram's nose, against the pivot.
    Eigen::Vector3d bend(double position) noexcept {
        const double here = z.above(position), there = z.above(z.pivot());
        return ram_sag(seed_) * (here * here - there * there) * Eigen::Vector3d::UnitX();
    }

    void show(const Eigen::Vector3d& tip, const Eigen::Vector3d& nominal,
              const Eigen::Vector3d& tilted) noexcept {
        for (int i = 0; i < 3; ++i) {
            truth_tip[i] = tip[i];
            truth_nominal[i] = nominal[i];
            truth_error[i] = error_[i] = tip[i] - nominal[i];
            truth_beyond[i] = tip[i] - tilted[i];
        }
    }

    void measure() noexcept {
        gauged_ = usable(gauge_position, 1e5, gauged_);
        PortalAxis* const axes[] = {&x, &y, &z, &w};
        const std::int32_t number = gauge_axis;
        GuideMotion motion;
        if (number >= 0 && number < 4) motion = axes[number]->errors_at(gauged_);
        if (number == 2 && is_portal_) motion.translation += bend(gauged_);
        gauge_ex = motion.translation.x();
        gauge_ey = motion.translation.y();
        gauge_ez = motion.translation.z();
        gauge_ea = motion.turn.x();
        gauge_eb = motion.turn.y();
        gauge_ec = motion.turn.z();
    }

    void indicate() noexcept {
        noise_ = usable(gauge_noise, 1, noise_);
        scale_ = usable(gauge_scale, 0.1, scale_);
        drift_ = usable(gauge_drift, 1, drift_);
        for (int i = 0; i < 3; ++i)
            indicator[i] = error_[i] * (1 + scale_) + drift_ * time_ + noise_ * random_.gaussian();
    }

    double length_ = 0, radius_ = 0, direction_ = 0, drift_began_ = 0, gauged_ = 0;  // last good inputs
    double time_ = 0, noise_ = 0, scale_ = 0, drift_ = 0;
    Eigen::Vector3d error_ = Eigen::Vector3d::Zero();  // mu, of the tip
    Random random_{0, 'i'};
    bool started_ = false, is_portal_ = false, whole_ = true, against_bed_ = false;
    std::int32_t seed_ = 0;
    Chains is_, tilted_;  // the real machine, and the one that its tilts describe
};

hal::Model hal::model() {
    return model_of<SimPortal>();
}

}  // namespace plumb
