// SPDX-License-Identifier: GPL-2.0-or-later
// From the signals of a machine to its contacts.
//
// 1. ApproachClock, SteadyFeed and Descent follow Z on its way to the work.
// 2. LoadContact sees a rise of the load over its baseline.
// 3. ContactFinder notes the machine at that rise, and moves the noted contact to where ContactOnset fits it.
#pragma once

#include "components/compensation/thermal_displacement/contact_cycle.hpp"
#include "components/compensation/thermal_displacement/contact_onset.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// The clock of the time method. It starts when Z passes a height on its way to the work, between two
// samples if need be, or by start(). It also integrates the commanded path, which gives the time without
// feed: a feed hold, a tool change or an override shows as lost time, growth does not.
class ApproachClock {
public:
    void start() noexcept { begin(0, 0); }

    void stop() noexcept {
        running_ = false;
        height_ = -std::numeric_limits<double>::infinity();
    }

    // One period of dt > 0, in s. velocity in mu/s, signed, negative towards the work.
    void step(double velocity, double dt) noexcept {
        time_ += dt;
        path_ += velocity * dt;
    }

    // After step(): starts the clock again if `height` has come down to or through `start_height` in this
    // period. Heights in mu, without the applied offset.
    void start_below(double height, double start_height, double velocity, double dt) noexcept {
        if (height_ > start_height && height <= start_height)
            begin(velocity, dt * (start_height - height) / (height_ - height));
        height_ = height;
    }

    bool running() const noexcept { return running_; }
    double time() const noexcept { return running_ ? time_ : 0; }  // s

    // Time in s without feeding at `feed`, which must not be zero.
    double lost_time(double feed) const noexcept { return running_ ? time_ - path_ / feed : 0; }

private:
    void begin(double velocity, double ago) noexcept {
        running_ = true;
        time_ = ago;
        path_ = velocity * ago;
    }

    bool running_ = false;
    double time_ = 0;
    double path_ = 0;                                           // mu, signed
    double height_ = -std::numeric_limits<double>::infinity();  // in the last period; unknown: below all
};

// How long Z has fed steadily on its way to the work since a disturbance: a feed hold, a stop, a turn of
// the override. After one, servo and load need a while before a rise of the load shows the surface of the
// work. A tool that was stopped in the work, before the load showed it, seems to meet it where it goes on.
// The start of an approach is no such disturbance: it is the same in each cycle.
class SteadyFeed {
public:
    // An approach begins.
    void begin() noexcept { *this = SteadyFeed(); }

    // One period of dt > 0, in s. velocity in mu/s; tolerance is the part of it that counts as steady.
    void step(double velocity, double tolerance, double dt) noexcept {
        lasted_ += dt;
        if (std::abs(velocity - velocity_) <= tolerance * std::abs(velocity_)) {
            started_ = started_ || lasted_ >= start_time;
            return;
        }
        disturbed_ = disturbed_ || started_;
        velocity_ = velocity;
        lasted_ = 0;
    }

    // In s; infinite without a disturbance.
    double time() const noexcept { return disturbed_ ? lasted_ : std::numeric_limits<double>::infinity(); }

private:
    static constexpr double start_time = 0.05;  // s that a start is steady when it is over

    double velocity_ = 0;
    double lasted_ = 0;
    bool started_ = false;
    bool disturbed_ = false;
};

// Whether a tool that fed down can still be in the work. A descent begins as Z feeds down. It ends when Z
// moves away and is back at the height where the last feed down began, or is in another operation or has
// another tool. So the tool counts as in the work while it dwells at depth, and while it leaves a hole.
class Descent {
public:
    // `z` in mu; one that is not finite counts as the last one.
    void step(double z, bool feeds_down, bool moves_away, std::int32_t operation,
              std::int32_t tool) noexcept {
        z_ = std::isfinite(z) ? z : z_;
        if (feeds_down && (!under_way_ || moved_away_)) {
            under_way_ = true;
            operation_ = operation;
            tool_ = tool;
            top_ = bottom_ = z_;
        }
        moved_away_ = moves_away;
        bottom_ = std::min(bottom_, z_);
        const bool back = z_ >= top_ - margin * (top_ - bottom_);
        const bool elsewhere = operation != operation_ || tool != tool_;
        if (moves_away && (back || elsewhere)) under_way_ = false;
    }

    void cancel() noexcept { under_way_ = false; }

    bool under_way() const noexcept { return under_way_; }

private:
    static constexpr double margin = 0.05;  // of the descent: noise of the feedback at the retract height

    bool under_way_ = false, moved_away_ = false;
    std::int32_t operation_ = 0, tool_ = 0;
    double z_ = 0, top_ = 0, bottom_ = 0;  // mu
};

// How Z moves. `clear` means that the tool cannot be in the work: a rapid, or away from the work.
enum class Travel { towards_work, other, clear };

// Finds the contact of a tool with the work in the load of a motor: a rise over a running baseline.
//
//  - One contact per approach: after one, Z must have been clear before another counts. A rise while a
//    change of speed disturbs the load is none; one that follows when the load has fallen is.
//  - Only while Z feeds towards the work, and not while a change of spindle speed still disturbs the load.
//  - A rise must last for the debounce time without falling below the release level. Its moment is that
//    at which it crossed the threshold, interpolated between samples.
//    That moment is a first guess: behind a lag τ a threshold h is crossed -τ ln(1 - h/P) late, and the step
//    P differs from part to part.
//  - The threshold is never below four standard deviations of the noise that the smoothing has left. Only
//    the load below the baseline counts as noise: a cut that begins slowly lies above it.
//  - A further rise in the same approach, by a third of the first one at least, means that the program raises
//  the
//    load too: coolant, say. Which of them is the work, the load does not show.
//  - The baseline stands still while the load is high, and follows ten times faster while Z is clear,
//    after a change of speed, and when the load has fallen.
class LoadContact {
public:
    // A rise is reported when it begins, so that the caller can note the place; then whether it was a
    // contact.
    enum class Event { none, rise, contact, blanked };

    // One period of dt > 0, in s. load in % and speed in rpm; a value that is not finite ends a rise, and
    // blanks as a change of speed does.
    Event step(double load, double speed, Travel travel, const DisplacementSettings& settings,
               double dt) noexcept {
        const bool usable = std::abs(load) <= largest && std::abs(speed) <= largest;
        if (!usable || std::abs(speed - speed_) > same_speed) {
            blanking_left_ = settings.blanking_time;
            if (usable) speed_ = speed;
        } else {
            blanking_left_ -= dt;
        }
        if (travel == Travel::clear) armed_ = true;
        if (!usable) {
            high_ = rising_ = false;
            judge_in_work(travel);
            return Event::none;
        }
        if (!known_) {
            smoothed_.set(load);
            baseline_.set(load);
        }
        known_ = true;

        const double threshold = std::max(settings.threshold, 4 * noise_);
        const double release = threshold / settings.threshold * settings.release;
        const double level = smoothed_.step(load, settings.smoothing, dt);
        const double rise = level - baseline_.value();
        const Event event = judge_rise(rise, threshold, release, travel, settings.debounce, dt);
        judge_in_work(travel);
        follow(level, rise, threshold, travel, settings.baseline_time, dt);
        follow_cut(rise, threshold, travel, settings.baseline_time, dt);
        rise_ = rise;
        return event;
    }

    bool rose_again() const noexcept { return again_ > lasting; }  // in this approach

    // The rise of the last report.
    double since_rise() const noexcept { return since_rise_; }  // s from its crossing to the present sample

    double noise() const noexcept { return noise_; }  // %, standard deviation about the baseline
    bool high() const noexcept { return high_; }  // above the threshold, and not yet below the release level
    bool blanked() const noexcept { return blanking_left_ > 0; }
    bool in_work() const noexcept { return in_work_; }  // the tool may be cutting

private:
    static constexpr double largest = 1e6;      // of load and speed; a larger value is invalid
    static constexpr double same_speed = 1;     // rpm
    static constexpr double noise_memory = 5;   // s
    static constexpr double quick = 0.1;        // of the baseline's time constant
    static constexpr double settles = 0.3;      // s after a contact until the load of the cut stands
    static constexpr double lasting = 0.1;      // s that a further rise must last
    static constexpr double further = 1.0 / 3;  // of the first rise

    Event judge_rise(double rise, double threshold, double release, Travel travel, double debounce,
                     double dt) noexcept {
        since_rise_ += dt;
        if (travel == Travel::clear || rise < release) {
            high_ = rising_ = false;
        } else if (!high_ && rise > threshold) {
            high_ = true;
            rising_ = armed_ && travel == Travel::towards_work;
            if (!rising_) return Event::none;
            since_rise_ = dt * std::min(1.0, (rise - threshold) / (rise - std::min(rise_, threshold)));
            rise_blanked_ = blanked();
            return Event::rise;
        } else if (rising_) {
            rise_blanked_ |= blanked();
            if (since_rise_ < debounce) return Event::none;
            rising_ = false;
            armed_ = rise_blanked_;  // a pulse of the spindle is no contact, and one may still come
            return rise_blanked_ ? Event::blanked : Event::contact;
        }
        return Event::none;
    }

    // High load means that the tool cuts. A change of speed spoils the baseline, which would show the end
    // of the cut: then only leaving the work ends it.
    void judge_in_work(Travel travel) noexcept {
        if (travel == Travel::clear) {
            in_work_ = end_unseen_ = false;
        } else if (in_work_) {
            end_unseen_ |= blanked();
            in_work_ = high_ || end_unseen_;
        } else {
            in_work_ = high_ && (rising_ || !blanked());
        }
    }

    void follow(double level, double rise, double threshold, Travel travel, double baseline_time,
                double dt) noexcept {
        if (blanked() || travel == Travel::clear || rise < -threshold) {
            baseline_.step(level, quick * baseline_time, dt);
        } else if (!high_) {
            baseline_.step(level, baseline_time, dt);
            if (rise < 0) learn_noise(rise, dt);
        }
    }

    // The load of a cut, which stands until the tool leaves the work.
    void follow_cut(double rise, double threshold, Travel travel, double baseline_time, double dt) noexcept {
        const bool cuts = travel == Travel::towards_work && high_ && !rising_ && !blanked();
        if (!cuts || since_rise_ < settles) {
            cut_.set(rise);
            again_ = 0;
        } else if (rise > cut_.value() + std::max(threshold, further * cut_.value())) {
            again_ += dt;
        } else if (again_ <= lasting) {
            again_ = 0;
            cut_.step(rise, baseline_time, dt);
        }
    }

    void learn_noise(double rise, double dt) noexcept {
        noise_age_ = std::min(noise_age_ + dt, noise_memory);
        variance_ += (rise * rise - variance_) * std::min(1.0, dt / noise_age_);
        noise_ = std::sqrt(variance_);
    }

    FirstOrderLag smoothed_;  // %
    FirstOrderLag baseline_;  // %
    FirstOrderLag cut_;       // % over the baseline, while the tool cuts
    double again_ = 0;        // s for which a further rise has lasted
    bool known_ = false;      // both of them
    double speed_ = 0;        // rpm
    double blanking_left_ = 0;
    double variance_ = 0;  // %²
    double noise_ = 0;
    double noise_age_ = 0;  // s

    bool armed_ = true;  // Z has been clear since the last contact
    bool high_ = false;
    bool rising_ = false;        // high for less than the debounce time, while feeding towards the work
    bool rise_blanked_ = false;  // in part while blanked
    double rise_ = 0;            // % over the baseline, in the last period
    double since_rise_ = 0;
    bool in_work_ = false;
    bool end_unseen_ = false;  // the baseline cannot show the end of this cut
};

// From the signals of a machine to its contacts: a rise of the load in an approach, its moment by a fit, and
// the state of the machine then. Reports, too, whether a tool may be in the work.
class ContactFinder {
public:
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

        Lost lost = Lost::nothing;
        bool load_lost = false;
        bool complete = true;  // it can be used

        // Sets these three from the others, as step() needs.
        void judge() noexcept {
            lost = ContactFinder::lost(*this);
            load_lost = lost == Lost::load || !load_valid;
            complete = lost == Lost::nothing && load_valid;
        }
    };

    // The result of a period: an end of the noted contact. `lost`: the next one came before it was fitted.
    enum class Found { none, contact, blanked, no_onset, lost };

    // One period of dt > 0, in s. `cycle` numbers the approaches and knows the time constants of its
    // contacts.
    Found step(const Sample& s, ContactCycle& cycle, const DisplacementSettings& settings,
               double dt) noexcept {
        in_cycle_ = cycle.running();
        if (s.complete) speed_history_.step(std::abs(s.speed), history_time, dt);
        follow_clock(s, settings.program_clock, dt);

        const Travel way = travel(s, settings);
        descent_.step(s.z, feeds_down(s), way == Travel::clear, s.operation, s.tool);
        follow_approach(s, way, cycle);
        if (s.complete) {
            feed_.step(s.velocity, settings.feed_tolerance, dt);
            follow_depth(s, way);
        }

        const double load = s.complete ? s.load : std::numeric_limits<double>::quiet_NaN();
        const LoadContact::Event event = detector_.step(load, s.speed, way, settings, dt);
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

    Travel travel(const Sample& s, const DisplacementSettings& settings) const noexcept {
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
