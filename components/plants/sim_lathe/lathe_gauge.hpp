// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "hal/component.hpp"

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

}  // namespace plumb
