// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace plumb {

// Whether the next cut has to wait: from a change of the tool until all ramps have ended. LinuxCNC changes
// the offset of a tool at rest, between two moves, and the next move begins a period later.
class Settling {
public:
    // The unsettled-code.
    enum class Ended : std::int32_t { in_force, disabled, fault, limited, late, by_a_cut, in_a_cut };
    friend constexpr const char* sentence(Ended ended) {
        switch (ended) {
            case Ended::disabled: return "The correction was switched off, or a joint is not homed any more.";
            case Ended::fault: return "The correction has a fault.";
            case Ended::limited: return "The correction is limited.";
            case Ended::late: return "Settling took longer than settling-time.";
            case Ended::by_a_cut: return "A cut began: after M53 P0 with M49 or M51 P0, or a thread.";
            case Ended::in_a_cut: return "The tool changed in a cut.";
            default: return nullptr;
        }
    }

    // The inputs of one period.
    struct Inputs {
        bool tool_changed, ramping;
        bool active, fault, limited;  // of the correction
        bool coordinated;             // by a program or MDI; else by jogs
        std::int32_t motion_type;     // of LinuxCNC, below
        double path_velocity;         // mu/s
        double longest;               // s
    };

    void step(const Inputs& now, double dt) noexcept {
        watch_cut(now);
        const Ended end = reason(now);
        if (now.tool_changed) {
            waits_ = now.ramping && now.active;
            waited_ = 0;
            ended_ = Ended::in_force;
            if (waits_ && end != Ended::in_force) stop(end == Ended::by_a_cut ? Ended::in_a_cut : end);
        } else if (waits_) {
            waited_ += dt;
            if (end != Ended::in_force)
                stop(end);
            else if (!now.ramping)
                waits_ = false;
            else if (waited_ >= now.longest)
                stop(Ended::late);
        }
        holds_ = waits_ && now.coordinated;
    }

    bool holds() const noexcept { return holds_; }
    bool cuts() const noexcept { return cuts_; }
    Ended ended() const noexcept {
        return ended_;
    }  // of the last change: why it was not waited for to the end

private:
    enum MotionType : std::int32_t { none = 0, rapid = 1, tool_change = 4, index_rotary = 6 };

    // From the first motion that is no rapid until LinuxCNC does something else: a hold in between belongs
    // to the cut. A rigid tap has no type, and other moves have none in their first period.
    void watch_cut(const Inputs& now) noexcept {
        const bool moves = !(std::abs(now.path_velocity) <= still), goes_on = moves && moved_;
        const bool works =
            now.motion_type != rapid && now.motion_type != tool_change && now.motion_type != index_rotary;
        if (!now.coordinated || !works || (now.motion_type == none && !moves))
            cuts_ = false;
        else if (now.motion_type == none ? goes_on : moves)
            cuts_ = true;
        moved_ = moves;
    }

    Ended reason(const Inputs& now) const noexcept {
        return !now.active   ? Ended::disabled
               : now.fault   ? Ended::fault
               : now.limited ? Ended::limited
               : cuts_       ? Ended::by_a_cut
                             : Ended::in_force;
    }

    void stop(Ended why) noexcept {
        waits_ = false;
        ended_ = why;
    }

    static constexpr double still = 1e-9;  // mu/s

    bool moved_ = false, cuts_ = false, waits_ = false, holds_ = false;
    double waited_ = 0;  // s
    Ended ended_ = Ended::in_force;
};

}  // namespace plumb
