// SPDX-License-Identifier: GPL-2.0-or-later
// An output that moves an axis declares it, with its bound, its rate and its acceleration:
//
//     hal::Offset moves{this, hal::MovingPin(applied_offset)
//                                 .bound(max_offset)
//                                 .rate(max_rate)
//                                 .acceleration(offset_acceleration)
//                                 .limited(limited)};
//
// None of them may be missing: such a module does not load, and has no page. The manual page and the tests
// read it: random sequences of faults attack every component that declares one, and test its declaration.
#pragma once

#include "hal/pin.hpp"
#include "hal/registrar.hpp"

#include <stdexcept>
#include <string>

namespace plumb::hal {

// Describes the offset that an output brings into an axis.
class MovingPin {
public:
    explicit MovingPin(const Out<double>& value) { info_.value = value.name(); }
    // In counts of LinuxCNC's external offsets, of `scale` each; `taken` is the offset that LinuxCNC has made
    // of them.
    MovingPin(const Out<std::int32_t>& counts, const Out<double>& scale, const In<double>& taken) {
        info_.value = taken.name();
        info_.counts = counts.name();
        info_.scale = scale.name();
    }

    // |offset| never grows beyond this setting.
    MovingPin& bound(const Pin<double>& pin) { return set(info_.bound, pin.name()); }
    // Apart from motion, the offset changes by at most this setting per second.
    MovingPin& rate(const Pin<double>& pin) { return set(info_.rate, pin.name()); }
    // True while the offset is kept from its wanted value.
    MovingPin& limited(const Out<bool>& pin) { return set(info_.limited, pin.name()); }
    // The rate itself changes by at most this setting per second, or so many times it, at the bound too. A
    // bound below the present offset is refused.
    MovingPin& acceleration(const Pin<double>& pin, double times = 1) {
        info_.times = times;
        return set(info_.acceleration, pin.name());
    }
    // In the place of acceleration(), where the output limits none: a sentence that names what does.
    MovingPin& accelerated_by(const std::string& sentence) { return set(info_.accelerated_by, sentence); }
    // While this position moves the offset may change besides, by at most `slope` of that movement. Optional.
    MovingPin& motion(const In<double>& position, double slope) {
        info_.motion.push_back(position.name());
        info_.slope = slope;
        return *this;
    }

    // While `driven` is false, and when `homed` rises, the offset may be at once where its axis is. Optional.
    MovingPin& undriven(const In<bool>& driven, const In<bool>& homed) {
        info_.homed = homed.name();
        return set(info_.driven, driven.name());
    }

    // Where motion turns, the offset may change besides: by at most the first setting per second, and its
    // rate by at most the second one. Optional.
    MovingPin& turning(const Pin<double>& rate, const Pin<double>& acceleration) {
        info_.turning_rate = rate.name();
        info_.turning_acceleration = acceleration.name();
        return *this;
    }

    // Without this output it neither follows nor returns when it is switched off. Optional.
    MovingPin& follows_while(const Out<bool>& pin) { return set(info_.follows_while, pin.name()); }
    // Switched on, it follows when the next cycle of the program begins. Optional.
    MovingPin& at_next_cycle() {
        info_.at_next_cycle = true;
        return *this;
    }

    // This output shows the part of the offset that is another user's of the axis: bound and rate hold for
    // the rest. Optional.
    MovingPin& guest(const Out<double>& part) { return set(info_.guest, part.name()); }

    const OffsetInfo& info() const { return info_; }

private:
    MovingPin& set(std::string& member, const std::string& name) {
        member = name;
        return *this;
    }

    OffsetInfo info_;
};

class Offset {
public:
    Offset(Owner owner, const MovingPin& pin) {
        const OffsetInfo& its = pin.info();
        const auto demand = [&](bool declared, const std::string& what) {
            if (!declared) throw std::invalid_argument(its.value + " moves an axis and declares no " + what);
        };
        demand(!its.bound.empty(), "bound");
        demand(!its.rate.empty(), "rate");
        demand(!its.limited.empty(), "bit that it is limited");
        demand(!its.acceleration.empty() || !its.accelerated_by.empty(), "acceleration");
        owner.registrar().add(its);
    }
    // Of each output of a row; `describe` makes its MovingPin.
    template <class Row, class Describe>
    Offset(Owner owner, const Row& row, const Describe& describe) {
        for (const auto& pin : row) Offset(owner, describe(pin));
    }
    Offset(const Offset&) = delete;
    Offset& operator=(const Offset&) = delete;
};

}  // namespace plumb::hal
