// SPDX-License-Identifier: GPL-2.0-or-later
// Has a class Filter that is not the one of specimen.cpp: loaded together, each must keep its own.
#include "hal/component.hpp"

namespace plumb {

class Filter {
public:
    double step(double x) noexcept { return 2 * x; }
    virtual ~Filter() = default;
};

struct Rival final : hal::Component {
    static constexpr hal::About about{"rival", "doubles", "The output is twice the input."};

    using Component::Component;

    hal::In<double> in{this, "in", 1, "mu", "Value to double."};
    hal::Out<double> out{this, "out", "mu", "Twice the input."};
    hal::Function run{this, "update", &Rival::update, "Anywhere."};

    void update(double) noexcept { out = filter_->step(in); }

private:
    std::unique_ptr<Filter> filter_ = std::make_unique<Filter>();
};

hal::Model hal::model() {
    return model_of<Rival>();
}

}  // namespace plumb
