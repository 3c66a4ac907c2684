// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "pages/sim_face.page.hpp"

#include <algorithm>
#include <cstdint>

namespace plumb {

struct SimFace final : hal::Component {
    static constexpr hal::About about{"sim_face",
                                      "simulated grinding of a face: wear and deflection of the wheel", page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the wheel; 0 is the typical one."};
    hal::In<double> x_position{this, "x-position", 0, "mu", "Position of the wheel towards the face."};
    hal::In<double> z_position{this, "z-position", 0, "mu", "Position of the wheel along the face."};
    hal::In<double> low{this, "low", 0, "mu", "Lower end of the face along Z."};
    hal::In<double> high{this, "high", 0, "mu", "Upper end of the face along Z."};
    hal::In<double> size{this, "size", 0, "mu", "Position of the face at which the gauge acts."};
    hal::In<bool> wheel_on{this, "wheel-on", true, "The wheel turns; one that stands does not cut."};
    hal::In<bool> fresh{this, "fresh", false, "True is a new face and a dressed wheel."};

    Drawn cutting_time{this,
                       "cutting-time",
                       1,
                       0.5,
                       2,
                       "s",
                       "Time in contact in which the wheel cuts away most of its deflection"};
    Drawn wear_ratio{this, "wear-ratio", 0.02, 0.01, 0.05, "1", "Wear of the wheel, part of the cut"};

    hal::Out<bool> at_size{this, "at-size", "The face is at size: for infeed-end of chopping."};
    hal::Out<double> truth_face{this, "truth-face", "mu", "Position of the face, 0 at first."};
    hal::Out<double> truth_wear{this, "truth-wear", "mu", "Radius that the wheel has lost."};
    hal::Out<double> truth_deflection{this, "truth-deflection", "mu",
                                      "Distance by which wheel and work give way, at the last contact."};
    hal::Function run{this, "update", &SimFace::update, hal::Place::machine, "After the axes."};

    void update(double dt) noexcept {
        const std::int32_t number = seed;
        const double time = std::max(cutting_time(number), 1e-3), ratio = wear_ratio(number);
        x_ = usable(x_position, 1e6, x_);
        z_ = usable(z_position, 1e6, z_);
        if (fresh) face_ = wear_ = deflection_ = 0;
        const double from = low, to = high;
        if (z_ >= from && z_ <= to) {
            deflection_ = std::max(face_ - (x_ + wear_), 0.0);
            const double cut = wheel_on ? deflection_ * std::min(dt / time, 1.0) : 0;
            face_ -= cut;
            wear_ += cut * ratio;
        }
        at_size = face_ <= size;
        truth_face = face_;
        truth_wear = wear_;
        truth_deflection = deflection_;
    }

private:
    double x_ = 0, z_ = 0, face_ = 0, wear_ = 0, deflection_ = 0;  // mu
};

hal::Model hal::model() {
    return model_of<SimFace>();
}

}  // namespace plumb
