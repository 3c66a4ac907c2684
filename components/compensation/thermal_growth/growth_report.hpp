// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_growth/growth_procedure.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb::growth_test {

// The outputs of a test.
struct TestReport : hal::Group {
    using Group::Group;

    hal::Code<State> state{this, "state-code", "Number of the state; 0 for idle."};
    hal::Codes<Stop> stop_reason{this, "stop-reason", "The test has stopped; stop-reason-code gives why.",
                                 "Number of the reason for the stop; 0 before the test has stopped."};
    hal::Out<bool> done{this, "done", "The machine is warm, or the time is over."};
    hal::Out<std::int32_t> cycle_index{this, "cycle-index", "Number of cycles that ended."};
    hal::Out<std::int32_t> pass{this, "pass", "Number of the present or last pass."};
    hal::Out<std::int32_t> visit{this, "visit", "Number of visits of bores."};
    hal::Out<std::int32_t> touches{this, "touches", "Number of touches that were latched."};
    hal::Out<double> elapsed{this, "elapsed", "s", "Time since the test began."};
    hal::Out<double> change{this, "temperature-change", "K",
                            "Largest change of a temperature in the interval; 1000 while unknown."};
    hal::Axes<hal::Out<double>, 3> touch{this, "touch-%", "mu", "% of the last touch, with compensation."};
    hal::Axes<hal::Out<double>, 3> touch_offset{this, "touch-%-offset", "mu",
                                                "Compensation in % at the last touch."};
    hal::Axes<hal::Out<double>, 3> bore{this, "bore-%", "mu",
                                        "% of the last bore or face, without compensation."};
    hal::Out<double> bore_diameter{this, "bore-diameter", "mu", "Diameter of the last bore."};
    hal::Out<double> bore_scatter{this, "bore-scatter", "mu", "Scatter of its touches about the circle."};
    hal::In<double> ball{this, "ball-diameter", 6, "mu", "Diameter of the ball of the probe."};
    hal::In<bool> boss{this, "outside", false, "The probe touches a boss or a sphere from outside."};
    hal::Out<bool> repeat{this, "repeat", "The last visit does not count; probe the bore again."};
    hal::Out<bool> compensation_request{this, "compensation-request", "Compensation shall be on."};
    hal::Out<bool> cooling_request{this, "cooling-request", "Temperature control shall be on."};
    hal::Out<bool> confirmed{this, "confirmed", "The control confirms both wanted states."};
    hal::Codes<Advice> advice{this, "advice", "The settings are unusual; advice-code gives how.",
                              "Number of the advice; 0 for none."};
    hal::Told told_advice{this, "advice", hal::Tell::behind_panel, "{advice-code}"};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Told told_fault{this, "fault", hal::Tell::text, "{fault-code}"};  // the test goes on
    hal::Out<std::int32_t> fault_bore{this, "fault-bore", "Number of the bore of the fault; 0 for none."};

    void show(const GrowthTest& test, const GrowthTest::Settings& settings) noexcept {
        const bool ended = test.stop() != Stop::none;
        state_ = !test.active()   ? (!test.begun() ? State::idle
                                     : ended       ? State::stopped
                                                   : State::interrupted)
                 : test.in_pass() ? (test.pass() <= 1 ? State::probing_cold : State::probing)
                 : ended          ? State::stopped
                                  : State::warming;
        state = state_;
        stop_reason = test.stop();
        done = ended;
        cycle_index = test.cycles();
        pass = test.pass();
        visit = test.visits();
        touches = test.touches();
        elapsed = test.time();
        repeat = test.repeat();
        fault_bore = test.bore_of_fault();
        advice = hal::first<Advice>({{!settings.stop.usual(), Advice::threshold},
                                     {!settings.stop.by_displacement, Advice::one_rule}});
        if (test.records().size() == shown_) return;
        shown_ = test.records().size();
        change = std::fmin(test.change(settings), 1000);
    }

    void show_touch(const Position& at) noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            touch[i] = at.position[i];
            touch_offset[i] = at.offset[i];
        }
    }

    void show_bore(const GrowthTest::Bore& its) noexcept {
        bore[0] = its.x;
        bore[1] = its.y;
        bore[2] = its.z;
        const double diameter = ball, size = std::abs(diameter) <= 1e6 ? diameter : 0;
        bore_diameter = 2 * its.radius + (boss ? -size : size);
        bore_scatter = its.scatter;
    }

    void show_states(bool wants_compensation, bool wants_cooling, bool both_confirmed) noexcept {
        compensation_request = wants_compensation;
        cooling_request = wants_cooling;
        confirmed = both_confirmed;
    }

    State now() const noexcept { return state_; }

private:
    State state_ = State::idle;
    std::size_t shown_ = SIZE_MAX;  // records at the last computation of temperature-change
};

}  // namespace plumb::growth_test
