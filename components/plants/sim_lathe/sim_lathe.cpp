// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/sim_lathe/lathe_gauge.hpp"
#include "components/plants/sim_lathe/other_tool.hpp"
#include "components/plants/sim_lathe/turned_stock.hpp"
#include "hal/component.hpp"
#include "pages/sim_lathe.page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

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
    hal::In<bool> inverted{this, "inverted", false,
                           "The tool stands upside down: its cut bends the work to -Y."};
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
    OtherTool other{this};

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
        const OtherTool::Force its = other.cut(stock_);
        OtherTool::Force own{0, 0, z_};
        double leaves = 0;
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
            const double bend = load * compliance(nominal, z_, z_);
            const double by_other = compliance(nominal, z_, its.z);
            const double outward = x_reversed ? -1 : 1, upward = inverted ? -0.9 : 0.9;
            const double y = y_ - upward * bend - its.y * by_other, c_r = 0.4 * bend * sense;
            leaves = std::hypot(x_ + c_r - outward * its.x * by_other - sense * edge_, y);
            own.x = -outward * sense * 0.4 * load;
            own.y = upward * load;
            truth_effective = y;
            truth_bend = bend;
            stock_.cut(from_z_, z_, leaves);
            cut_z_ = z_;
        }
        other.show(leaves, own);
        truth_cutting = cutting_;
        truth_cuts = cuts_;
    }

    // Bend of the work at one Z for a force of 1 N at another one, either way, in mm.
    double compliance(double radius, double at, double from) noexcept {
        const double r = std::max(radius, 0.05);
        const double near = guide_bush ? in_bush : std::max(std::min(at, from), 0.0);
        const double far = guide_bush ? in_bush : std::max(at, from);
        const double inertia = pi * r * r * r * r / 4;
        return 1 / std::max(stiffness(seed_), 1.0) +
               near * near * (3 * far - near) / (6 * elasticity * inertia);
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
