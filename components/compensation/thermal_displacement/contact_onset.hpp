// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/earlier_step.hpp"
#include "components/compensation/thermal_displacement/onset_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

// The moment at which a tool met the work, fitted to the load before and after it (see OnsetFit). The power
// of the cut and the load of the idling spindle have no influence. The time constant is that of the
// contact's reference; for the reference itself it is fitted too. So an error of it, or of the shape
// of the rise, shifts both alike. If the load rises clearly faster or slower than at all references of its
// tool, the filter of the drive has changed: then the time constant is fitted again (see OnsetShape).
//
//  - A load that the drive samples and holds counts once per sample: where it changes, and where it would
//    have changed, by the shortest times between two changes.
//  - At last a load that rises twice is looked for (see EarlierStep).
//  - No period does more than a piece of the work, so the result comes some periods late.
class ContactOnset {
public:
    static constexpr double before = 0.3;  // s before the start that count, if recorded
    static constexpr double after = 0.3;   // s after the start that are waited for, if the approach lasts

    // One period of dt > 0, in s, with load in % and z in mu. Both are recorded while `approach` is true;
    // the record ends with it. True when a fit has ended.
    bool step(bool approach, double load, double z, double dt) noexcept {
        age_ += dt;
        if (stage_ > Stage::waiting) return work();
        if (approach) record(load, z, dt);
        if (stage_ == Stage::waiting && ((waited_ += dt) >= after || !approach)) begin();
        if (!approach && stage_ == Stage::recording) clear();
        return false;
    }

    // The load has risen. `time_constant` is in s, or 0 for the one that fits best; the others are the least
    // and the largest of all references of this tool, which the same drive and the same teeth have made.
    void start(double time_constant, double least, double most) noexcept {
        stage_ = Stage::waiting;
        waited_ = 0;
        time_constant_ = given_ = time_constant;
        least_ = least / (1 + same_filter);
        most_ = most * (1 + same_filter);
        free_ = !(time_constant > 0);
        refits_ = 0;
        refit_ = Refit::possible;
    }
    void start(double time_constant) noexcept { start(time_constant, time_constant, time_constant); }
    void cancel() noexcept {
        if (!busy()) return;
        stage_ = Stage::recording;
        clear();
    }
    bool busy() const noexcept { return stage_ != Stage::recording; }

    // The last fit that has ended: whether it found a rise beyond the noise, and its results if it did.
    bool found() const noexcept { return found_; }
    double ago() const noexcept { return age_ + onset_age_; }         // s, to the present period
    double coordinate() const noexcept { return coordinate_; }        // mu
    double sigma() const noexcept { return sigma_; }                  // s, standard deviation by noise
    double time_constant() const noexcept { return time_constant_; }  // s
    double kink() const noexcept { return kink_; }                    // s, see OnsetShape
    // s by which the contact comes later than fitted, because the load rises twice; 0 if it does not.
    double shift() const noexcept { return shift_; }

private:
    static constexpr int capacity = 1024;
    static constexpr int piece = 64;                        // slots per period
    static constexpr double shortest = 0.002, ratio = 1.5;  // s; of the time constants that are tried
    static constexpr int trials = 12;
    static constexpr double clear_rise = 5;     // standard deviations
    static constexpr double other_filter = 6;   // standard deviations, of the change of a time constant
    static constexpr double same_filter = 0.1;  // part of a time constant: a smaller change is none
    static constexpr double settled = 0.005;    // ... in further steps
    static constexpr int most_refits = 6;
    // By simulation: the variance that a small rise adds when its time constant is not known.
    static constexpr double free_noise = 600;

    enum class Refit { possible, none };
    enum class Stage { recording, waiting, hold, total, trial, fit, residuals, earlier, between };

    // A mean over so many periods that all that counts has room.
    struct Slot {
        double load = 0, z = 0;
        int held = 0;  // number of slots before this one with the same load
    };

    void record(double load, double z, double dt) noexcept {
        if (size_ == 0 && filled_ == 0) {
            per_slot_ = static_cast<int>(std::ceil((before + after) / dt / (capacity - 1)));
            spacing_ = dt * per_slot_;
        }
        sum_.load += load;
        sum_.z += z;
        if (++filled_ < per_slot_) return;
        Slot now{sum_.load / per_slot_, sum_.z / per_slot_};
        if (size_ > 0 && now.load == slot(0).load) now.held = std::min(slot(0).held + 1, capacity);
        newest_ = (newest_ + 1) % capacity;
        slots_[newest_] = now;
        size_ = std::min(size_ + 1, capacity);
        sum_ = {};
        filled_ = 0;
        age_ = 0.5 * (spacing_ - dt);
    }

    void clear() noexcept {
        size_ = filled_ = 0;
        sum_ = {};
    }

    // The k-th before the newest, 0 ≤ k < capacity.
    const Slot& slot(int k) const noexcept { return slots_[(newest_ - k + capacity) % capacity]; }

    void begin() noexcept {
        size_ = std::min(size_, static_cast<int>((before + after) / spacing_) + 1);
        hold_ = capacity;
        longer_ = false;
        total_ = {};
        trial_ = 0;
        enter(Stage::hold);
    }

    void enter(Stage stage) noexcept {
        stage_ = stage;
        k_ = 0;
    }

    void enter_fit(Stage stage, double time_constant) noexcept {
        enter(stage);
        fit_.begin(total_, spacing_, time_constant);
    }

    // One piece. True when it was the last.
    bool work() noexcept {
        if (stage_ == Stage::between) return look_earlier();
        const int end = std::min(k_ + piece, size_);
        for (; k_ < end; ++k_) take(slot(k_));
        if (k_ < size_) return false;
        switch (stage_) {
            case Stage::hold: enter(Stage::total); break;
            case Stage::total:
                if (time_constant_ > 0)
                    enter_fit(Stage::fit, time_constant_);
                else
                    enter_fit(Stage::trial, shortest);
                break;
            case Stage::trial: end_trial(); break;
            case Stage::fit:
                fit_.finish();
                e_ = fit_.share() * std::pow(fit_.q(), fit_.first());
                s_ = fit_.first() * spacing_ / time_constant_ - std::log(fit_.share());
                residuals_ = {};
                ripple_ = {};
                shape_.begin(std::max(1.0, 2 * hold_ * spacing_ / time_constant_));
                enter(Stage::residuals);
                break;
            case Stage::residuals:
                if (refits()) break;
                conclude();
                if (found_) {
                    begin_earlier();
                    break;
                }
                cancel();
                return true;
            default: return look_earlier();
        }
        return false;
    }

    void begin_earlier() noexcept {
        EarlierStep::Contact contact;
        contact.free = free_;
        contact.time_constant = free_ ? time_constant_ : given_;
        contact.onset = onset_age_;
        contact.gain = fit_.gain();
        contact.explained = fit_.explained();
        contact.sigma = noise_;
        contact.variance = variance();
        const double interval = spacing_ * period();
        earlier_.begin(contact, total_, total_.yy - total_.y * total_.y / total_.n, spacing_, size_,
                       interval);
        enter(Stage::earlier);
    }

    bool look_earlier() noexcept {
        switch (earlier_.work()) {
            case EarlierStep::Next::between: stage_ = Stage::between; return false;
            case EarlierStep::Next::pass: enter(Stage::earlier); return false;
            default:
                shift_ = earlier_.shift();
                cancel();
                return true;
        }
    }

    // Steps towards the time constant that fits best. It is of another filter if it explains the load better
    // by more than noise does; else that of the reference stays. True if there is another fit to come.
    bool refits() noexcept {
        const bool seldom = 2 * hold_ * spacing_ >= given_;  // the drive samples: then a rise shows no shape
        if (free_ || !fit_.found() || seldom || refit_ == Refit::none) return false;
        const double change = shape_.information() > 0 ? shape_.change(fit_.gain()) : 0;
        if (refits_ == 0) explained_by_given_ = fit_.explained();
        if (refits_ < most_refits && std::abs(change) > (refits_ == 0 ? same_filter : settled)) {
            ++refits_;
            time_constant_ =
                std::clamp(time_constant_ * std::exp(std::clamp(change, -0.5, 0.5)), shortest, after);
        } else {
            const double better = fit_.explained() - explained_by_given_;
            const bool other = time_constant_ < least_ || time_constant_ > most_;
            if (refits_ == 0 || (other && better > other_filter * other_filter * variance())) return false;
            refit_ = Refit::none;
            time_constant_ = given_;
        }
        enter_fit(Stage::fit, time_constant_);
        return true;
    }
    double change_sigma() const noexcept {
        return std::sqrt(variance() / shape_.information()) / fit_.gain();
    }

    void take(const Slot& s) noexcept {
        if (stage_ == Stage::hold) {
            if (s.held == 0 && k_ + 1 < size_) hold(slot(k_ + 1).held + 1);
            return;
        }
        const double weight = s.held % period() == 0 ? 1 : 0;
        const double load = s.load - slot(0).load;  // a load that does not change gives sums of exactly 0
        if (stage_ == Stage::total) {
            total_.n += weight;
            total_.y += weight * load;
            total_.yy += weight * load * load;
        } else if (stage_ == Stage::residuals) {
            const double rise = k_ <= fit_.first() ? fit_.gain() * (1 - e_) : 0;
            const double residual = load - fit_.baseline() - rise;
            residuals_.take(weight, residual, fit_.q());
            if (weight > 0) ripple_.take(residual, k_ <= fit_.first());
            shape_.take(weight, residual, s_, k_ <= fit_.first() ? e_ : 0);
            e_ /= fit_.q();
            s_ -= spacing_ / time_constant_;
        } else if (stage_ == Stage::earlier) {
            earlier_.take(weight, load);
        } else {
            fit_.take(weight, load);
        }
    }

    // The drive has held a sample for so many slots: the least, or one more if its time is no multiple of
    // them.
    void hold(int slots) noexcept {
        if (slots < hold_) longer_ = slots + 1 == hold_;
        longer_ |= slots == hold_ + 1;
        hold_ = std::min(hold_, slots);
    }

    // Slots after which it has taken another sample, whether or not that has another value.
    int period() const noexcept { return hold_ > 1 && longer_ ? hold_ + 1 : hold_; }

    // Time constants in a geometric row; then the top of the parabola through the best and its neighbours.
    void end_trial() noexcept {
        fit_.finish();
        explained_[trial_++] = fit_.explained();
        if (trial_ < trials) return enter_fit(Stage::trial, shortest * std::pow(ratio, trial_));
        const auto best = std::max_element(explained_.begin() + 1, explained_.end() - 1);
        const double bend = best[-1] - 2 * best[0] + best[1];
        const double aside = bend < 0 ? std::clamp(0.5 * (best[-1] - best[1]) / bend, -1.0, 1.0) : 0;
        const double top = static_cast<double>(best - explained_.begin()) + aside;
        time_constant_ = shortest * std::pow(ratio, top);
        enter_fit(Stage::fit, time_constant_);
    }

    double variance() const noexcept {
        return residuals_.variance(total_.n, 3, time_constant_ / (size_ * spacing_));
    }

    // Standard deviation of the onset, because the moments at which the drive samples are known to a slot
    // only. The second term, by simulation, is for a load that rises faster than the drive samples.
    double sampling() const noexcept {
        if (hold_ == 1) return 0;
        const double interval = hold_ * spacing_;
        return (spacing_ + interval * std::exp(-3 * time_constant_ / interval)) / std::sqrt(12);
    }

    void conclude() noexcept {
        const double tau = time_constant_, disturbance = variance();
        const double small = free_ ? free_noise * disturbance / fit_.explained() : 0;
        noise_ = tau / fit_.gain() * std::sqrt((1 + small) * disturbance / fit_.information());
        const double of_filter =
            refits_ > 0 && refit_ != Refit::none ? tau * shape_.bend() * change_sigma() : 0;
        const double of_teeth = ripple_.shift(tau, spacing_ * period()) / fit_.gain();
        sigma_ = std::hypot(std::hypot(noise_, of_teeth), sampling(), of_filter);
        kink_ = tau * shape_.kink(fit_.gain());
        found_ = fit_.found() && fit_.explained() > clear_rise * clear_rise * disturbance;
        if (found_) {
            const double between = -tau * std::log(fit_.share());
            const Slot& first = slot(fit_.first());
            const Slot& last = slot(std::min(fit_.first() + 1, size_ - 1));
            onset_age_ = fit_.first() * spacing_ + between;
            coordinate_ = first.z + (last.z - first.z) * between / spacing_;
        }
        shift_ = 0;
    }

    std::array<Slot, capacity> slots_{};
    int newest_ = 0;
    int size_ = 0;
    int per_slot_ = 1;    // periods
    int filled_ = 0;      // of these
    Slot sum_;            // over these
    double spacing_ = 1;  // s, of the slots
    double age_ = 0;      // s, of the newest one
    double waited_ = 0;   // s

    Stage stage_ = Stage::recording;
    int k_ = 0;            // of the slot that comes next
    int hold_ = 1;         // slots for which the drive holds a sample, at least
    bool longer_ = false;  // some are held for one more
    double time_constant_ = 0;
    bool free_ = false;  // it is fitted
    OnsetFit::Total total_;
    OnsetFit fit_;
    int trial_ = 0;
    std::array<double, trials> explained_{};
    double e_ = 0;  // exp(-(t - t0) / τ) at that slot
    double s_ = 0;  // (t - t0) / τ there
    ResidualNoise residuals_;
    CutRipple ripple_;
    OnsetShape shape_;
    Refit refit_ = Refit::none;
    int refits_ = 0;
    double given_ = 0, least_ = 0, most_ = 0;  // s, time constants of the references
    double explained_by_given_ = 0;

    bool found_ = false;
    double onset_age_ = 0;  // s, before the newest slot
    double coordinate_ = 0;
    double sigma_ = 0;
    double kink_ = 0;   // s
    double noise_ = 0;  // s, of sigma_ that part
    EarlierStep earlier_;
    double shift_ = 0;  // s
};

}  // namespace plumb
