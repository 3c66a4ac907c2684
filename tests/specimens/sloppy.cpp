// SPDX-License-Identifier: GPL-2.0-or-later
// Breaks the rules that the conformance test holds, so that the rules can be tested.
#include "hal/component.hpp"
#include "hal/offset.hpp"

#include <cstdint>
#include <string>

namespace plumb {

static std::string global = "A text that is destroyed when its process exits.";

enum class Fault : std::int32_t { none, vague };
constexpr const char* sentence(Fault fault) {
    return fault == Fault::vague ? "something" : nullptr;
}

struct Sloppy final : hal::Component {
    static constexpr hal::About about{"sloppy", "trusts any input", "A compensation without a guard."};

    using Component::Component;

    hal::In<double> in{this, "in", 0, "mu", "Goes straight to the output."};
    hal::In<double> max_rate{this, "max-rate", 1, "mu/s", "Is not heeded."};
    static constexpr hal::Range offsets{2, 3};
    hal::In<double> max_offset{this, "max-offset", 1, "mu", "Is not heeded.", offsets};
    hal::In<double> unit{this, "No_Unit", 0, "Has no unit."};
    hal::In<double> wordy{this, "a-name-longer-than-it-may-be", 0, "mu", "Leaves no room for the instance."};
    hal::In<double> nameless{this, "nameless", 0, "mu", "no period"};
    hal::In<double> endless{this, "endless", 0, "mu", "Is a setting without a range.", hal::machine()};
    hal::Row<hal::In<bool>, 9> required{this, "required", false, "Must be set.", hal::must()};
    hal::Out<bool> flag{this, "flag", "mu", "A bit with a unit."};
    hal::Out<double> out{this, "out", "mu", "The input."};
    hal::Out<bool> limited{this, "limited", "Never true."};
    hal::Offset moves{
        this,
        hal::MovingPin(out).bound(max_offset).rate(max_rate).accelerated_by("nothing").limited(limited)};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Out<double> truth{this, "truth-growth", "mu", "A truth."};
    hal::Function run{this, "update", &Sloppy::update, "anywhere"};

    void update(double) noexcept {
        lasting_ += in - lasting_;  // once not a number, for ever not a number
        out = lasting_;
        flag = global.empty();
    }

private:
    double lasting_ = 0;
};

hal::Model hal::model() {
    return model_of<Sloppy>();
}

}  // namespace plumb
