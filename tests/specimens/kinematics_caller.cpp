// SPDX-License-Identifier: GPL-2.0-or-later
// Calls the kinematics that is loaded, as motion-controller does in each period: for the benchmark.
#include "hal/component.hpp"

#include <emcpos.h>
extern "C" {
#include <kinematics.h>
}

namespace plumb {

struct KinematicsCaller final : hal::Component {
    static constexpr hal::About about{"kinematics_caller", "calls the kinematics", "Inverse, then forward."};

    using Component::Component;

    hal::In<double> x{this, "x", 0, "mu", "Place of the tip in X."};
    hal::In<double> y{this, "y", 0, "mu", "The same in Y."};
    hal::In<double> z{this, "z", 0, "mu", "The same in Z."};
    hal::In<double> b{this, "b", 0, "deg", "Turn about Y."};
    hal::In<double> c{this, "c", 0, "deg", "Turn about Z."};
    hal::Out<double> z_joint{this, "z-joint", "mu", "Place of joint 2."};
    hal::Out<double> z_tip{this, "z-tip", "mu", "Z of the tip from there."};
    hal::Function run{this, "update", &KinematicsCaller::update, "Anywhere."};

    void update(double) noexcept {
        EmcPose wanted{}, found{};
        wanted.tran = {x, y, z};
        wanted.b = b;
        wanted.c = c;
        double joints[9]{};
        KINEMATICS_FORWARD_FLAGS forward = 0;
        KINEMATICS_INVERSE_FLAGS inverse = 0;
        kinematicsInverse(&wanted, joints, &inverse, &forward);
        kinematicsForward(joints, &found, &forward, &inverse);
        z_joint = joints[2];
        z_tip = found.tran.z;
    }
};

hal::Model hal::model() {
    return model_of<KinematicsCaller>();
}

}  // namespace plumb
