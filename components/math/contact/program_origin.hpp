// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace plumb {

// Why the origin of the program along Z has changed: a new zero, or a tool measured again; a correction of the
// growth by hand; or another depth.
enum class OriginReason : std::int32_t { none, zero, by_hand, depth };

// Work offset and tool length, and when they change. A reason holds for a while after it was given, because
// the change may come late from another program.
//
// A zero takes in the growth at that moment, less the offset that is in force: the growth to come is lower by
// as much, unless the zero was corrected by it.
class ProgramOrigin {
public:
    static constexpr double patience = 1;  // s for which a reason holds

    struct Now {
        double work_offset = 0, tool_length = 0;  // mu
        std::int32_t tool = 0;
        OriginReason reason = OriginReason::none;  // that is being given
        double growth = 0, applied_offset = 0;     // mu
    };

    // One period of dt > 0, in s. A length of 0 is a tool without G43.
    void step(const Now& now, double dt) noexcept {
        given_ = now.reason != OriginReason::none && now.reason != now_.reason;
        waited_ = now.reason == OriginReason::none ? waited_ + dt : 0;
        if (now.reason != OriginReason::none) reason_ = now.reason;
        if (waited_ > patience) reason_ = OriginReason::none;
        before_ = now_.work_offset;
        offset_changed_ = known_ && differ(now.work_offset, before_);
        length_changed_ = known_ && now.tool == now_.tool && differ(now.tool_length, now_.tool_length) &&
                          now.tool_length != 0;
        if (offset_changed_) {
            in_offset_ = now.growth - now.applied_offset;
            if (root_holds_) root_ = before_;
            root_holds_ = reason_ != OriginReason::none || !differ(now.work_offset, root_);
        }
        if (length_changed_) in_length_ = now.growth - now.applied_offset;
        now_ = now;
        known_ = true;
    }

    bool offset_changed() const noexcept { return offset_changed_; }  // in this period
    bool length_changed() const noexcept { return length_changed_; }  // of the tool in the spindle
    double offset_before() const noexcept { return before_; }         // mu
    double offset_root() const noexcept { return root_; }             // ... before changes without a reason
    const Now& now() const noexcept { return now_; }

    bool reason_given() const noexcept { return given_; }  // in this period
    OriginReason reason() const noexcept { return reason_; }

    // Growth that the last change has taken in, mu.
    double in_offset() const noexcept { return in_offset_; }
    double in_length() const noexcept { return in_length_; }

    static bool differ(double a, double b) noexcept { return std::abs(a - b) > 1e-6; }  // mu

private:
    Now now_;
    bool known_ = false, offset_changed_ = false, length_changed_ = false, given_ = false;
    OriginReason reason_ = OriginReason::none;
    bool root_holds_ = true;  // no change without a reason has followed it
    double waited_ = 0, before_ = 0, root_ = 0, in_offset_ = 0, in_length_ = 0;
};

}  // namespace plumb
