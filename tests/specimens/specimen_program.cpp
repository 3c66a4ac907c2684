// SPDX-License-Identifier: GPL-2.0-or-later
// The user-space half of the specimens.
#include "hal/component.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace plumb {

struct SpecimenProgram final : hal::Component {
    static constexpr hal::About about{"specimen_program", "counts its calls", "Counts up once per period."};

    using Component::Component;

    hal::In<double> step{this, "step", 1, "1", "Amount that one call adds."};
    hal::Out<double> calls{this, "calls", "1", "Calls so far."};
    hal::Out<double> period{this, "period", "s", "Time between two calls."};
    hal::Option<double> start{this, "start", 0, "First count."};
    hal::Function run{this, "update", &SpecimenProgram::update, "Once per period."};

    void prepare() override {
        if (start.get() < 0) throw std::runtime_error("start=" + std::to_string(start.get()) + " is below 0");
        count_ = start;
    }

    void update(double dt) noexcept {
        count_ += step;
        calls = count_;
        period = dt;
    }

private:
    double count_ = 0;
};

hal::Model hal::model() {
    return model_of<SpecimenProgram>();
}

}  // namespace plumb
