// SPDX-License-Identifier: GPL-2.0-or-later
// Plays the program of a growth test where no LinuxCNC does: passes over the bores, and work in between. Off
// and on are taken bore by bore, first at B0 and then at B180; the first bore is probed again at the end.
// Mirrored, all bores are taken off and then, in the reverse order, on. After the test the machine may rest
// and be probed as it cools.
#pragma once

#include "hal/component.hpp"

#include <algorithm>
#include <cstdint>

namespace plumb {

class GrowthProgram final : public hal::Group {
public:
    using Group::Group;

    struct Step {
        bool touching = false;  // this period the probe touches
        bool approaching = false;
        bool changed_tool = false;
        int bore = 0;  // from 0
        int side = 0;  // 0 face or top, 1 +X, 2 -X, 3 +Y, 4 -Y
        bool sphere = false;
        bool turned = false, compensated = false;
        bool pass = false;
        double speed = 0, moving = 0;
    };

    // What happens in this period. `repeat`: the last visit does not count.
    Step step(bool repeat, bool done, double dt) noexcept {
        Step now;
        const bool plays = play_;
        const std::int32_t wanted = bores_;
        count_ = std::clamp(wanted, 1, 8);
        both_ = both_states_;
        tables_ = both_orientations_;
        mirrors_ = mirrored_ && both_;
        is_sphere_ = sphere_;
        if (is_sphere_) count_ = 1;
        rests_wanted_ = rests_;
        if (!plays) {
            phase_ = Phase::off;
            show(now, false, false, false);
            return now;
        }
        clock_ += dt;
        bool measuring = false, at_bore = false, cycle = false;
        switch (phase_) {
            case Phase::off:
                phase_ = Phase::start;
                clock_ = 0;
                break;
            case Phase::start:
                if (clock_ >= 60) begin_pass(now);
                break;
            case Phase::settle:  // the table turns, the compensation settles
                if (clock_ >= 10) next(Phase::open);
                break;
            case Phase::open:
                at_bore = true;
                if (clock_ >= dt) next(Phase::travel);
                break;
            case Phase::travel:
                at_bore = true;
                if (clock_ >= std::max(touch_time_ + 0.0, 1.0)) next(Phase::approach);
                break;
            case Phase::approach:
                at_bore = measuring = now.approaching = true;
                next(Phase::touch);
                break;
            case Phase::touch:
                at_bore = measuring = now.touching = true;
                next(Phase::retract);
                break;
            case Phase::retract:
                at_bore = touch_ < last_touch;
                if (touch_ < last_touch) {
                    ++touch_;
                    next(Phase::travel);
                } else {
                    next(Phase::judge);
                }
                break;
            case Phase::judge:
                if (clock_ < 3 * dt) break;
                touch_ = 0;
                if (!repeat || ++tries_ > 3) advance();
                if (phase_ == Phase::judge) next(Phase::settle);
                break;
            case Phase::work:
                now.speed = clock_ < work_time_ - 30 ? speed_ + 0.0 : 0;
                now.moving = 1;
                if (clock_ < work_time_) break;
                cycle = true;
                next(Phase::pause);
                break;
            case Phase::pause:
                if (clock_ < 20) break;
                last_ = done;
                begin_pass(now);
                break;
            case Phase::rest:
                if (clock_ < rest_time_) break;
                ++rested_;
                begin_pass(now);
                break;
            case Phase::finished: break;
        }
        now.bore = bore();
        now.sphere = is_sphere_;
        now.side = std::max(touch_ - 1, 0);  // the face is touched twice
        now.turned = turned();
        now.compensated = compensated();
        now.pass = in_pass();
        show(now, at_bore, measuring, cycle);
        return now;
    }

private:
    enum class Phase {
        off,
        start,
        settle,
        open,
        travel,
        approach,
        touch,
        retract,
        judge,
        work,
        pause,
        rest,
        finished
    };

    static constexpr int last_touch = 5, sphere_key = 9;

    bool in_pass() const noexcept { return phase_ >= Phase::settle && phase_ <= Phase::judge; }
    // Visits of a pass: bores x states at 0, the same at 180, and the first bore again. Mirrored: bores at 0,
    // at 180, and the first bore again; then the same backwards in the other state.
    int states() const noexcept { return both_ ? 2 : 1; }
    int places() const noexcept { return count_ * (tables_ ? 2 : 1); }
    int visits() const noexcept { return states() * (places() + 1); }
    int place() const noexcept {
        if (!mirrors_) return visit_ / states() % places();
        const bool back = visit_ > places();
        return (back ? 2 * places() + 1 - visit_ : visit_) % places();
    }
    int bore() const noexcept { return place() % count_; }
    bool turned() const noexcept { return place() >= count_; }
    bool compensated() const noexcept {
        if (!both_) return single_state_;
        return mirrors_ ? visit_ > places() : visit_ % 2 == 1;
    }

    void next(Phase phase) noexcept {
        phase_ = phase;
        clock_ = 0;
    }
    void begin_pass(Step& now) noexcept {
        now.changed_tool = true;
        visit_ = touch_ = tries_ = 0;
        single_state_ = state_;
        next(Phase::settle);
    }
    void advance() noexcept {
        tries_ = 0;
        if (++visit_ < visits()) return;
        visit_ = 0;
        next(!last_ ? Phase::work : rested_ < rests_wanted_ ? Phase::rest : Phase::finished);
    }

    void show(const Step& now, bool at_bore, bool measuring, bool cycle) noexcept {
        running_ = phase_ != Phase::off && phase_ != Phase::finished;
        pass_ = now.pass;
        at_bore_ = at_bore;
        measuring_ = measuring;
        cycle_ = cycle;
        turned_ = now.turned;
        compensate_ = now.compensated;
        bore_key_ = now.sphere ? sphere_key : now.bore + 1;
        finished_ = phase_ == Phase::finished;
    }

    hal::In<bool> play_{this, "play", false, "Play the test; false: axes, table and spindle are inputs."};
    hal::In<std::int32_t> bores_{this, "bores", 4, "Number of bores that are probed, 1 to 8."};
    hal::In<bool> both_states_{this, "both-states", true, "Probe without and with compensation."};
    hal::In<bool> state_{this, "state", false, "The state, if only one is probed: compensation is on."};
    hal::In<bool> both_orientations_{this, "both-orientations", true, "Probe at B0 and B180."};
    hal::In<bool> mirrored_{this, "mirrored", false,
                            "Probe all bores without, then all with compensation, in the reverse order."};
    hal::In<bool> sphere_{this, "sphere", false, "Probe the sphere, number 9, instead of the bores."};
    hal::In<std::int32_t> rests_{this, "cool-down", 0, "Number of rests after the test, each with a pass."};
    hal::In<double> rest_time_{this, "rest-time", 1200, "s", "Time of such a rest."};
    hal::In<double> touch_time_{this, "touch-time", 10, "s", "Time for each touch."};
    hal::In<double> work_time_{this, "work-time", 1500, "s", "Time of work between two passes."};
    hal::In<double> speed_{this, "work-speed", 8000, "rpm", "Speed of the spindle at work."};
    hal::Out<bool> running_{this, "running", "The program runs."};
    hal::Out<bool> finished_{this, "finished", "The program has ended."};
    hal::Out<bool> pass_{this, "pass-running", "A pass runs."};
    hal::Out<bool> at_bore_{this, "at-bore", "A bore is probed."};
    hal::Out<bool> measuring_{this, "measuring", "The next touch counts."};
    hal::Out<bool> cycle_{this, "cycle", "A cycle of work ends."};
    hal::Out<bool> turned_{this, "turned", "The table shall be at 180 deg."};
    hal::Out<bool> compensate_{this, "compensate", "The program wants compensation."};
    hal::Out<double> bore_key_{this, "bore-key", "1", "Number of the bore."};

    Phase phase_ = Phase::off;
    double clock_ = 0;
    int count_ = 4, visit_ = 0, touch_ = 0, tries_ = 0, rested_ = 0;
    std::int32_t rests_wanted_ = 0;
    bool mirrors_ = false, is_sphere_ = false;
    bool both_ = true, tables_ = true, single_state_ = false,
         last_ = false;  // last_: no work after this pass
};

}  // namespace plumb
