// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/contact/approach_clock.hpp"
#include "components/math/contact/contact_cycle.hpp"
#include "components/math/contact/contact_onset.hpp"
#include "components/math/contact/descent.hpp"
#include "components/math/contact/load_contact.hpp"
#include "components/math/contact/program_origin.hpp"
#include "components/math/contact/steady_feed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumb {

// From the signals of a machine to its contacts: a rise of the load in an approach, its moment by a fit, and
// the state of the machine then. Reports, too, whether a tool may be in the work.
class ContactFinder {
public:
    struct Settings {
        bool program_clock =
            false;  // the clock starts with the cycle and at each mark, not at the start height
        static constexpr std::size_t exclusions = 4;
        std::array<std::int32_t, exclusions>
            excluded{};           // keys of operations without a gauge of Z; 0 for none
        double load_latency = 0;  // s, age of the load
        LoadContact::Settings contact;

        bool valid() const noexcept { return load_latency >= 0 && load_latency <= 10 && contact.valid(); }
    };

    // The invalid part of a sample; such a sample is not used.
    enum class Lost { nothing, load, position, speed, offset, approach };

    // The signals of one period.
    struct Sample {
        bool enable = false;
        bool learn = false;
        bool cycle_running = false;
        bool cycle_complete = false;  // as the cycle ends: it was not aborted
        MachiningSetup setup;
        std::int32_t motion = 0;  // as LinuxCNC's motion.motion-type
        std::int32_t tool = 0;
        std::int32_t operation = 0;  // key; 0 for none
        double load = 0;             // %
        bool load_valid = true;
        double speed = 0;           // rpm
        double z = 0;               // mu, offset included
        double velocity = 0;        // mu/s, signed, negative towards the work
        double feed_override = 1;   // ratio
        double motor_offset = 0;    // mu, that z contains beside the height of the joint
        double start_height = 0;    // mu, of the joint, without offset
        bool clock_start = false;   // the mark of a program clock: its rising edge
        double applied_offset = 0;  // mu
        double step = 0;            // mu, by which it is displaced on purpose
        double work_offset = 0;     // mu, along Z
        double tool_length = 0;     // mu, along Z, in force
        OriginReason origin_reason = OriginReason::none;  // of a change of these two, while it is given
        double temperature = 20;                          // degC, to remember; the last good one stays
        std::int32_t date = 0;                            // YYYYMMDD, to remember
        bool temperature_valid = false;                   // the growth may follow it

        // By judged().
        Lost lost = Lost::nothing;
        bool load_lost = false;
        bool complete = true;  // it can be used
    };

    // The sample with a judgement of its values, which step() needs.
    static Sample judged(Sample s) noexcept {
        s.lost = lost(s);
        s.load_lost = s.lost == Lost::load || !s.load_valid;
        s.complete = s.lost == Lost::nothing && s.load_valid;
        return s;
    }

    // The result of a period: an end of the noted contact. `lost`: the next one came before it was fitted.
    enum class Found { none, contact, blanked, no_onset, lost };

    // One period of dt > 0, in s. `cycle` numbers the approaches and knows the time constants of its
    // contacts.
    Found step(const Sample& s, ContactCycle& cycle, double feed_tolerance, const Settings& settings,
               double dt) noexcept {
        in_cycle_ = cycle.running();
        if (s.complete) speed_history_.step(std::abs(s.speed), history_time, dt);
        follow_clock(s, settings.program_clock, dt);

        const Travel way = travel(s, settings);
        descent_.step(s.z, feeds_down(s), way == Travel::clear, s.operation, s.tool);
        follow_approach(s, way, cycle);
        if (s.complete) {
            feed_.step(s.velocity, feed_tolerance, dt);
            follow_depth(s, way);
        }

        const double load = s.complete ? s.load : std::numeric_limits<double>::quiet_NaN();
        const LoadContact::Event event = detector_.step(load, s.speed, way, settings.contact, dt);
        const bool approach = s.complete && way == Travel::towards_work && !detector_.blanked();
        note_age_ += dt;
        bool lost_one = false;
        if (event == LoadContact::Event::rise) {
            lost_one = onset_.busy();
            onset_.cancel();
            note(s, settings.load_latency);
        }
        if (event == LoadContact::Event::contact) start_fit(cycle);
        const bool fitted = onset_.step(approach, s.load, s.z, dt);
        if (lost_one) return Found::lost;
        if (event == LoadContact::Event::blanked) return Found::blanked;
        return fitted ? fit(settings.load_latency) : Found::none;
    }

    // A cycle begins, or ends. True if a contact was still being fitted as it ended.
    void begin(bool program_clock) noexcept {
        approaching_ = false;
        descent_.cancel();
        if (program_clock) clock_.start();
    }
    bool end() noexcept {
        const bool busy = onset_.busy();
        onset_.cancel();
        clock_.stop();
        return busy;
    }

    const LoadContact& detector() const noexcept { return detector_; }
    const ContactReference& found() const noexcept { return note_; }  // the last rise
    double steady_time() const noexcept { return steady_time_; }      // s of steady feed before it
    // mu by which it lies lower in truth, because the load rises twice about it; 0 if it does not.
    double misplaced() const noexcept { return misplaced_; }

    // The tool may be cutting, is still lower than at its contact, or feeds down to it. An offset that
    // moves meanwhile changes the feed at the contact, and goes on moving until the load shows it.
    bool in_work() const noexcept { return detector_.in_work() || below_contact_ || descent_.under_way(); }

private:
    static Lost lost(const Sample& s) noexcept {
        const auto bad = [](double x) { return !(std::abs(x) <= 1e6); };
        if (bad(s.load)) return Lost::load;
        if (bad(s.z) || bad(s.velocity) || bad(s.motor_offset) || bad(s.work_offset) || bad(s.tool_length))
            return Lost::position;
        if (bad(s.speed)) return Lost::speed;
        if (bad(s.applied_offset)) return Lost::offset;
        return bad(s.feed_override) || bad(s.start_height) ? Lost::approach : Lost::nothing;
    }

    static constexpr double history_time = 600;         // s
    static constexpr std::int32_t rapid = 1, feed = 2;  // of motion

    void follow_clock(const Sample& s, bool program_clock, double dt) noexcept {
        if (!s.complete || (s.operation != operation_ && !program_clock)) clock_.stop();
        const bool marked = mark_.rises(s.clock_start);
        if (program_clock && s.complete && in_cycle_ && marked) clock_.start();
        operation_ = s.operation;
        clock_.step(s.velocity, dt);
        if (s.complete && !program_clock)
            clock_.start_below(s.z - s.motor_offset - s.applied_offset, s.start_height, s.velocity, dt);
    }

    Travel travel(const Sample& s, const Settings& settings) const noexcept {
        if (s.motion == rapid || (s.velocity > 0 && !detector_.high())) return Travel::clear;
        if (!feeds_down(s)) return Travel::other;
        const auto& excluded = settings.excluded;
        const bool used = std::find(excluded.begin(), excluded.end(), s.operation) == excluded.end();
        return used ? Travel::towards_work : Travel::other;
    }

    // In an operation of a cycle, even if its contacts do not count.
    bool feeds_down(const Sample& s) const noexcept {
        return s.motion == feed && s.velocity < 0 && in_cycle_ && s.operation != 0;
    }

    // An approach begins as Z feeds towards the work for the first time since it was clear of it.
    void follow_approach(const Sample& s, Travel way, ContactCycle& cycle) noexcept {
        if (way == Travel::clear) approaching_ = false;
        if (way != Travel::towards_work || (approaching_ && same_task(s, approach_))) return;
        approaching_ = true;
        approach_ = cycle.approach(s.operation, s.tool);
        feed_.begin();
    }

    // Above its last contact the tool is out of the work; so it is on its way to another one.
    void follow_depth(const Sample& s, Travel way) noexcept {
        const bool leaving = way == Travel::clear && s.operation != 0 && !same_task(s, note_.key);
        if (s.z >= note_.contact.coordinate || leaving) below_contact_ = false;
    }

    static bool same_task(const Sample& s, const ContactKey& key) noexcept {
        return s.operation == key.operation && s.tool == key.tool;
    }

    // Notes the state when the load crossed the threshold, earlier by the age of the load.
    void note(const Sample& s, double load_latency) noexcept {
        const double ago = detector_.since_rise() + load_latency;
        below_contact_ = true;
        note_age_ = 0;
        note_.key = approach_;
        note_.contact.coordinate = s.z - s.velocity * ago;
        note_time_ = clock_.time();
        note_.contact.time = std::max(0.0, note_time_ - ago);
        note_.contact.lost_time = clock_.lost_time(s.velocity);
        note_.contact.feed = s.velocity;
        note_.contact.feed_override = s.feed_override;
        note_.contact.applied_offset = s.applied_offset;
        note_.contact.work_offset = s.work_offset;
        note_.contact.tool_length = s.tool_length;
        steady_time_ = feed_.time() - ago;
        note_.setup = s.setup;
        note_.speed_history = speed_history_.value();
        note_.temperature = usable(s.temperature, 1e3, note_.temperature);
        note_.date = std::max(s.date, 0);
    }

    void start_fit(const ContactCycle& cycle) noexcept {
        const ContactReference* partner = cycle.expected(note_.key);
        if (!partner) return onset_.start(0);
        const auto [least, most] = cycle.time_constants(note_.key.tool);
        onset_.start(partner->contact.time_constant, least, most);
    }

    // The fit moves the noted contact to its true place.
    Found fit(double load_latency) noexcept {
        if (!onset_.found()) return Found::no_onset;
        note_.contact.coordinate = onset_.coordinate() - note_.contact.feed * load_latency;
        if (note_time_ > 0)  // a clock ran
            note_.contact.time = std::max(0.0, note_time_ + note_age_ - onset_.ago() - load_latency);
        note_.contact.sigma = -note_.contact.feed * onset_.sigma();
        note_.contact.time_constant = onset_.time_constant();
        note_.contact.kink = -note_.contact.feed * onset_.kink();
        misplaced_ = -note_.contact.feed * onset_.shift();
        return Found::contact;
    }

    ApproachClock clock_;
    LoadContact detector_;
    ContactOnset onset_;
    Descent descent_;
    SteadyFeed feed_;  // of the approach
    FirstOrderLag speed_history_;
    bool in_cycle_ = false;
    bool approaching_ = false;
    bool below_contact_ = false;
    ContactKey approach_;         // the present one, or the last
    std::int32_t operation_ = 0;  // in the last period
    Edge mark_;                   // of the program's clock

    ContactReference note_;   // the last rise
    double note_age_ = 0;     // s
    double note_time_ = 0;    // s, of the clock then
    double steady_time_ = 0;  // s before that rise
    double misplaced_ = 0;    // mu
};

}  // namespace plumb
