// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/first_order_lag.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

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
    struct Settings {
        double threshold = 0;      // % over the baseline
        double release = 0;        // % over the baseline, not above the threshold
        double smoothing = 0;      // s, time constant of a filter on the load
        double debounce = 0;       // s
        double baseline_time = 0;  // s, time constant
        double blanking_time = 0;  // s after a change of speed

        bool valid() const noexcept {
            return threshold > 0 && threshold <= 1e3 && release >= 0 && release <= threshold &&
                   smoothing >= 0 && smoothing <= 10 && debounce >= 0 && debounce <= 10 &&
                   baseline_time > 0 && baseline_time <= 1e3 && blanking_time >= 0 && blanking_time <= 1e3;
        }
    };

    // A rise is reported when it begins, so that the caller can note the place; then whether it was a
    // contact.
    enum class Event { none, rise, contact, blanked };

    // One period of dt > 0, in s. load in % and speed in rpm; a value that is not finite ends a rise, and
    // blanks as a change of speed does.
    Event step(double load, double speed, Travel travel, const Settings& settings, double dt) noexcept {
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

}  // namespace plumb
