// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/sim_lathe/turned_stock.hpp"
#include "hal/component.hpp"
#include "pages/sim_lathe.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Measures a land: a laser gauge, or an operator with a micrometer who may make a slip.
struct LatheGauge final : hal::Group {
    using Group::Group;

    hal::In<bool> measure{this, "measure", false, "A rising edge asks for the diameter."};
    hal::In<double> gauge_time{this, "gauge-time", 0.5, "s", "Time until the diameter is there."};
    hal::In<bool> micrometer{this, "micrometer", false, "An operator measures with a micrometer."};
    hal::In<std::int32_t> slip{this, "slip", 0,
                               "Slip of the operator: 1 the radius, 2 inches, 3 the land before, 4 mm."};
    hal::In<double> beam_size{this, "beam-size", 20, "mu", "Width of a rectangular beam, radius of a round."};
    hal::In<bool> beam_round{this, "beam-round", false, "The beam is round, not rectangular."};
    hal::In<double> beam_height{this, "beam-height", 2, "mu", "Rectangular beam along the work."};
    hal::In<double> beam_offset{this, "beam-offset", 0, "mu",
                                "Distance from the middle of the beam to the middle of the work."};

    Drawn laser_noise{this, "laser-noise", 0.0003, 0.0001, 0.0005, "mu", "Noise of the laser"};
    Drawn linearity{this, "linearity", 0.0007, 0.0005, 0.001, "mu", "Amplitude of its nonlinearity"};
    Drawn micrometer_noise{this, "micrometer-noise", 0.0015, 0.001, 0.002, "mu", "Noise of the micrometer"};
    Drawn film{this, "coolant-film", 0.0005, 0, 0.001, "mu", "Film of coolant on the diameter"};
    Drawn warmth{this, "work-warmth", 5, 0, 10, "K", "Work above 20 degC"};

    hal::Out<double> diameter{this, "diameter", "mu", "Measured diameter, as the operator enters it."};
    hal::Out<bool> value_ready{this, "value-ready", "The diameter is there, until measure falls."};
    hal::Out<double> emitted{this, "emitted-area", "mu2", "Area of the laser beam before the work."};
    hal::Out<double> received{this, "received-area", "mu2", "Area of the laser beam behind the work."};

    void step(double true_diameter, std::int32_t seed, Random& random, double dt) noexcept {
        const bool asked = measure;
        if (asking_.rises(asked)) left_ = std::max(usable(gauge_time, 1e5, 0), 0.0);
        if (asked && !ready_) {
            left_ -= dt;
            if (left_ <= dt / 2) read(true_diameter, seed, random);
        }
        if (!asked) ready_ = false;
        value_ready = ready_;
    }

private:
    void read(double truth, std::int32_t seed, Random& random) noexcept {
        const double warm = truth * (1 + 11.5e-6 * warmth(seed));
        const double phase = 2 * pi * (warm / 10 + std::fmod(seed * 0.618, 1));
        const double found = micrometer ? warm + micrometer_noise(seed) * random.gaussian()
                                        : warm + film(seed) + linearity(seed) * std::sin(phase) +
                                              laser_noise(seed) * random.gaussian();
        const std::int32_t its = slip;
        diameter = its == 1   ? found / 2
                   : its == 2 ? found / 25.4
                   : its == 3 ? before_
                   : its == 4 ? found * 25.4
                              : found;
        before_ = found;
        beam(found);
        ready_ = true;
    }

    // What a strip of this width leaves of the beam; the strip may stand off the middle.
    void beam(double width) noexcept {
        const double size = std::max(usable(beam_size, 1e4, 0), 0.0), from = beam_offset - width / 2;
        const double edges[] = {std::clamp(from, -size, size), std::clamp(from + width, -size, size)};
        if (beam_round) {
            const auto area = [size](double a) {
                return a * std::sqrt(size * size - a * a) + size * size * std::asin(size > 0 ? a / size : 0);
            };
            emitted = pi * size * size;
            received = pi * size * size - (area(edges[1]) - area(edges[0]));
        } else {
            const double height = beam_height, half = size / 2;
            const double covered = std::clamp(edges[1], -half, half) - std::clamp(edges[0], -half, half);
            emitted = size * height;
            received = (size - covered) * height;
        }
    }

    double left_ = 0, before_ = 0;
    Edge asking_;
    bool ready_ = false;
};

struct SimLathe final : hal::Component {
    static constexpr hal::About about{"sim_lathe", "simulated lathe whose tool is not on centre", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the lathe."};
    hal::In<double> x_position{this, "x-position", 100, "mu", "Position of X, as a radius outward."};
    hal::In<double> y_position{this, "y-position", 0, "mu", "Position of Y."};
    hal::In<double> z_position{this, "z-position", 0, "mu", "Position of Z from the chuck."};
    hal::In<double> elapsed{this, "elapsed", 0, "s", "Time since the start besides the simulated one."};
    hal::In<double> spindle_speed{this, "spindle-speed", 1000, "rpm",
                                  "Speed of the work; a tool cuts only turning work."};
    hal::In<bool> new_stock{this, "new-stock", false, "A rising edge gives new stock."};
    hal::In<double> stock_diameter{this, "stock-diameter", 12, "mu", "Diameter of the stock, or its bore."};
    hal::In<double> stock_length{this, "stock-length", 100, "mu", "Length of the stock."};
    hal::In<bool> inside{this, "inside", false, "The tool turns the bore."};
    hal::In<bool> guide_bush{this, "guide-bush", false, "A guide bush holds the work at the tool."};
    hal::In<bool> x_reversed{this, "x-reversed", false, "The tool is on the side of -X."};
    hal::In<double> gauge_z{this, "gauge-z", -1, "mu", "Z of the gauge; negative: at the last cut."};
    hal::In<double> gauge_offset{this, "gauge-offset", 0, "mu",
                                 "Distance of the gauge from the last cut, away from the chuck."};

    Drawn height_error{this, "height-error", 0.1, 0, 0.5, "mu", "Size of the tool's height error"};
    hal::In<std::int32_t> side{this, "side", 0,
                               "Side of the height error: 1, -1, or 0 by the seed; + for lathe 0."};
    hal::In<double> x_error{this, "x-error", 0, "mu", "Error of the tool's X, outward."};
    hal::In<double> skew{this, "axes-angle", 90, "deg", "Angle from outward X to +Y."};
    Drawn x_scale{this, "x-scale", 1e-5, 0, 2e-5, "1", "Scale error of X"};
    Drawn x_backlash{this, "x-backlash", 0.0015, 0, 0.003, "mu", "Backlash of X"};
    Drawn y_scale{this, "y-scale", 2.5e-5, 0, 5e-5, "1", "Scale error of Y"};
    Drawn y_backlash{this, "y-backlash", 0.0025, 0, 0.005, "mu", "Backlash of Y"};
    Drawn x_growth{this, "x-growth", 0.015, 0.005, 0.03, "mu", "Growth of X in 30 min"};
    Drawn lift{this, "spindle-lift", 0.008, 0.002, 0.015, "mu", "Lift of the spindle's axis in 30 min"};
    Drawn stiffness{
        this, "chuck-stiffness", 50000, 20000, 100000, "N/mu", "Force that bends the chuck by a length"};
    Drawn force{this, "cutting-force", 20, 1, 50, "N", "Force of a cut 0.1 mm deep"};
    hal::In<double> edge{this, "built-up-edge", 0.005, "mu",
                         "Largest built-up edge; each cut has one from a fifth of it on."};
    Drawn wear{this, "wear", 0.0005, 0.0002, 0.001, "mu", "Wear of the tool by each cut"};
    LatheGauge gauge{this};

    hal::Out<double> spindle_load{this, "spindle-load", "%", "Load of the spindle, of 200 W; 2 % idle."};
    hal::Out<double> truth_height{this, "truth-height", "mu", "Height of the tip above the axis now."};
    hal::Out<double> truth_effective{this, "truth-effective-height", "mu",
                                     "Height in the last cut, with the bend of the work."};
    hal::Out<double> truth_x{this, "truth-x", "mu", "Distance of the tip from the axis in X now."};
    hal::Out<double> truth_diameter{this, "truth-diameter", "mu", "Diameter at the gauge."};
    hal::Out<double> truth_bend{this, "truth-bend", "mu", "Bend of the work in the last cut."};
    hal::Out<bool> truth_cutting{this, "truth-cutting", "The tool cuts."};
    hal::Out<std::int32_t> truth_cuts{this, "truth-cuts", "Cuts of this stock."};
    hal::Function run{this, "update", &SimLathe::update, hal::Place::machine,
                      "After the positions of the axes."};

    void update(double dt) noexcept {
        if (seed_ != seed || !started_) start(seed);
        if (fresh_.rises(new_stock)) fill();
        time_ += dt;
        passed_ = usable(elapsed, 1e9, passed_);
        const double warm = 1 - std::exp(-(time_ + passed_) / warming);

        move(warm);
        turn();

        const double place = usable(gauge_z, 1e5, -1);
        const double diameter = 2 * stock_.radius(place < 0 ? cut_z_ + usable(gauge_offset, 100, 0) : place);
        spindle_load = load_;
        truth_height = y_;
        truth_x = x_;
        truth_diameter = diameter;
        gauge.step(diameter, seed_, gauge_random_, dt);
    }

private:
    static constexpr double warming = 900;       // s
    static constexpr double elasticity = 206e3;  // N/mm2
    static constexpr double clear = 0.2;         // mm, of a tool that has left the work
    static constexpr double in_bush = 1;         // mm, from the guide bush to the tool

    // A drive that moves its slide behind some play.
    struct Play {
        double at = 0;
        double step(double to, double play) noexcept {
            at = std::clamp(at, to - play / 2, to + play / 2);
            return at;
        }
    };

    void start(std::int32_t number) noexcept {
        started_ = true;
        seed_ = number;
        random_ = Random(static_cast<std::uint32_t>(number), 'l');
        gauge_random_ = Random(static_cast<std::uint32_t>(number), 'g');
        time_ = wear_ = edge_ = 0;
        side_ = number != 0 && Random(static_cast<std::uint32_t>(number), 's').uniform() < 0.5 ? -1 : 1;
        fill();
    }

    void fill() noexcept {
        stock_.fill(usable(stock_diameter, 1e4, 12) / 2, 0, usable(stock_length, 1e4, 100), inside);
        cuts_ = 0;
        cutting_ = false;
    }

    // Where the tip is against the axis of the spindle.
    void move(double warm) noexcept {
        px_ = usable(x_position, 1e5, px_);
        py_ = usable(y_position, 1e5, py_);
        const double last_z = z_;
        z_ = usable(z_position, 1e5, z_);
        from_z_ = std::abs(z_ - last_z) <= 1 ? last_z : z_;
        if (from_z_ == z_ && z_ != last_z) cutting_ = false;
        const double angle = std::clamp(usable(skew, 180, 90), 10.0, 170.0) * (pi / 180);
        const double outward = x_reversed ? -px_ : px_;
        const double y_travel = y_play_.step(py_ * (1 + y_scale(seed_)), y_backlash(seed_));
        const double x_travel = x_play_.step(outward * (1 + x_scale(seed_)), x_backlash(seed_));
        const double error = height_error(seed_) * side_of_tool();
        // 30 min bring 86 % of all growth.
        x_ = x_travel + usable(x_error, 1e4, 0) - x_growth(seed_) * warm / 0.86 + wear_ +
             y_travel * std::cos(angle);
        y_ = y_travel * std::sin(angle) + error - lift(seed_) * warm / 0.86;
    }

    double side_of_tool() noexcept {
        const std::int32_t given = side;
        return given > 0 ? 1 : given < 0 ? -1 : side_;
    }

    void turn() noexcept {
        const double sense = inside ? -1 : 1;
        const double nominal = std::hypot(x_, y_);
        const double reach = stock_.depth(z_, nominal - sense * edge_);
        const double speed = std::abs(usable(spindle_speed, 1e6, 0));
        const bool turns = speed > 1;
        load_ = turns ? 2 : 0;
        if (!turns || !(reach > 0)) {
            if (!turns || !(reach > -clear)) cutting_ = false;  // else it rests between two passes
        } else {
            if (!cutting_) {
                edge_ = std::max(usable(edge, 1, 0), 0.0) * random_.uniform(0.2, 1);
                wear_ += wear(seed_) * sense;
                cuts_ += 1;
            }
            cutting_ = true;
            // A tool that feeds along Z takes each disc in one pass; one that stands still lets it spring
            // back.
            if (!stock_.same(z_, disc_z_)) before_ = stock_.radius(z_);
            disc_z_ = z_;
            const double depth =
                z_ != from_z_ ? stock_.depth_against(before_, nominal) : stock_.depth(z_, nominal);
            const double load = force(seed_) * std::max(depth, 0.0) / 0.1;
            load_ += load * nominal / 1000 * speed * (2 * pi / 60) / 2;  // 2 W are 1 %
            const double bend = load * compliance(nominal);
            const double c_t = 0.9 * bend, c_r = 0.4 * bend * sense;
            const double leaves = std::hypot(x_ + c_r - sense * edge_, y_ - c_t);
            truth_effective = y_ - c_t;
            truth_bend = bend;
            const double step = z_ > from_z_ ? TurnedStock::length / 2 : -TurnedStock::length / 2;
            for (double z = from_z_; (z_ - z) * step > 0; z += step) stock_.cut(z, leaves);
            stock_.cut(z_, leaves);
            cut_z_ = z_;
        }
        truth_cutting = cutting_;
        truth_cuts = cuts_;
    }

    // Bend of the work at the tool for a force of 1 N, in mm.
    double compliance(double radius) noexcept {
        const double r = std::max(radius, 0.05), overhang = guide_bush ? in_bush : std::max(z_, 0.0);
        const double inertia = pi * r * r * r * r / 4;
        return 1 / std::max(stiffness(seed_), 1.0) +
               overhang * overhang * overhang / (3 * elasticity * inertia);
    }

    TurnedStock stock_;
    Random random_, gauge_random_;
    Play x_play_, y_play_;
    double px_ = 100, py_ = 0, z_ = 0, from_z_ = 0;  // last good positions
    double x_ = 100, y_ = 0, cut_z_ = 0;
    double load_ = 0;
    double disc_z_ = 1e6, before_ = 0;  // the disc at the tool, and its radius when the tool came
    double time_ = 0, passed_ = 0, wear_ = 0, edge_ = 0, side_ = 1;
    std::int32_t seed_ = 0, cuts_ = 0;
    Edge fresh_;
    bool started_ = false, cutting_ = false;
};

hal::Model hal::model() {
    return model_of<SimLathe>();
}

}  // namespace plumb
