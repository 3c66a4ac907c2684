// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_growth_test/growth_record.hpp"
#include "components/compensation/thermal_growth_test/growth_test_codes.hpp"
#include "components/math/growth/bore_centre.hpp"
#include "components/math/growth/stop_rule.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace plumb::growth_test {

// The state of a test, as its records make it. reserve() allocates; nothing else does.
class GrowthTest {
public:
    static constexpr std::size_t most_records = 50000;

    struct Settings {
        StopRule::Settings stop;
        double most_scatter = 0.01;  // mu, of the touches of a bore about their circle
        double least_rise = 0.5;     // K, of a machine that has warmed
    };

    struct Bore {
        double x = 0, y = 0, z = 0, radius = 0, scatter = 0;  // mu
    };

    void reserve() { records_.reserve(most_records); }

    const std::vector<Record>& records() const noexcept { return records_; }
    bool begun() const noexcept { return !records_.empty(); }
    bool full() const noexcept { return records_.size() >= most_records; }
    Stop stop() const noexcept { return stop_; }
    double time() const noexcept { return records_.empty() ? 0 : records_.back().time; }
    std::int32_t pass() const noexcept { return pass_; }
    // The pass has not ended: an interrupted one goes on under its number, as its references belong together.
    bool pass_open() const noexcept { return pass_open_; }
    std::int32_t visit() const noexcept { return visit_; }
    std::int32_t touches() const noexcept { return touches_; }
    int cycles() const noexcept { return rule_.cycles(); }
    const Bore& bore() const noexcept { return bore_; }
    double change(const Settings& settings) const noexcept { return rule_.change(settings.stop); }
    // Whether a chosen sensor has risen since the test began; true if none was valid.
    bool warmed(const Settings& settings) const noexcept {
        bool any = false;
        for (std::size_t i = 0; i < first_.size(); ++i) {
            if ((settings.stop.sensors >> i & 1U) == 0 || !std::isfinite(first_[i])) continue;
            any = true;
            if (highest_[i] - first_[i] >= settings.least_rise) return true;
        }
        return !any;
    }

    void clear() noexcept {
        records_.clear();
        rule_.clear();
        first_.fill(NAN);
        highest_.fill(-HUGE_VAL);
        now_.fill(NAN);
        known_.fill(false);
        passes_.fill(0);
        circle_.clear();
        pass_ = visit_ = touches_ = 0;
        sides_ = 0;
        pass_open_ = false;
        stop_ = Stop::none;
        bore_ = Bore();
    }

    // Adds a record. False if it is impossible, or there is no room.
    bool take(const Record& r, const Settings& settings) noexcept {
        if (full() || !r.usable() || r.time < time()) return false;
        if (records_.empty() && !is(r, Event::begin)) return false;
        records_.push_back(r);
        switch (static_cast<Kind>(r.kind)) {
            case Kind::touch: touch(r); break;
            case Kind::temperature: temperature(r, settings); break;
            case Kind::event: event(r, settings); break;
            case Kind::speed: break;
        }
        return true;
    }

    // Whether the touches of the visit that ends now give a bore that counts.
    Fault judged(std::int32_t bore, bool turned, bool compensated, const Settings& settings) const noexcept {
        if (circle_.count() == 0 && faces_ == 0) return Fault::probe_miss;
        const auto centre = circle_.centre();
        if (circle_.count() > 0 && !centre) return Fault::probe_miss;
        if (centre && centre->scatter > settings.most_scatter) return Fault::false_trigger;
        if (faces_ > 1 && face_high_ - face_low_ > settings.most_scatter) return Fault::false_trigger;
        if (pass_ <= 1 || !decides(compensated)) return Fault::none;
        const std::size_t base = first_value(bore, turned);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!known_[base + axis] && (axis == 2 ? faces_ > 0 : centre.has_value()))
                return Fault::no_reference;
        return Fault::none;
    }

    // What the rules decide now.
    Stop decision(double time, const Settings& settings) const noexcept {
        return static_cast<Stop>(rule_.reason(time, settings.stop));
    }

private:
    static bool is(const Record& r, Event event) noexcept {
        return r.kind == static_cast<std::int32_t>(Kind::event) && r.item == static_cast<std::int32_t>(event);
    }

    void touch(const Record& r) noexcept {
        if (r.visit != visit_) begin_visit(r);
        ++touches_;
        const double x = r.x - r.x_offset, y = r.y - r.y_offset, z = r.z - r.z_offset;
        if (std::abs(r.item) == 3) {
            face_low_ = faces_ == 0 ? z : std::min(face_low_, z);
            face_high_ = faces_ == 0 ? z : std::max(face_high_, z);
            face_ += z;
            ++faces_;
        } else {
            circle_.add(x, y);
        }
    }

    void begin_visit(const Record& r) noexcept {
        visit_ = r.visit;
        circle_.clear();
        face_ = 0;
        faces_ = 0;
        if (sides_ == 0) sides_ = r.compensated ? 2 : 1;  // the first state decides the rule
    }

    void temperature(const Record& r, const Settings& settings) noexcept {
        const auto sensor = static_cast<std::size_t>(r.item - 1);
        if (r.item < 1 || sensor >= now_.size()) return;
        const bool valid = r.y != 0;
        now_[sensor] = valid ? r.x : NAN;
        if (valid && !std::isfinite(first_[sensor])) first_[sensor] = r.x;
        if (valid) highest_[sensor] = std::max(highest_[sensor], r.x);
        rule_.sample(r.time, now_, settings.stop);
    }

    void event(const Record& r, const Settings& settings) noexcept {
        switch (static_cast<Event>(r.item)) {
            case Event::pass_begin:
                pass_ = r.pass;
                pass_open_ = true;
                break;
            case Event::pass_end: pass_open_ = false; break;
            case Event::cycle_end: rule_.cycle_ends(r.time, settings.stop); break;
            case Event::stop: stop_ = static_cast<Stop>(std::clamp(static_cast<int>(r.x), 0, 2)); break;
            case Event::measured: measure(r); break;
            case Event::rejected: visit_ = std::max(visit_, r.visit); break;
            default: break;
        }
    }

    // The rule follows one state only: the one of the first visit.
    bool decides(bool compensated) const noexcept { return sides_ == 0 || compensated == (sides_ == 2); }

    static std::size_t first_value(std::int32_t bore, bool turned) noexcept {
        return (static_cast<std::size_t>(bore - 1) * 2 + (turned ? 1 : 0)) * 3;
    }

    void measure(const Record& r) noexcept {
        std::array<double, 3> at{NAN, NAN, NAN};
        if (const auto centre = circle_.centre()) {
            at[0] = bore_.x = centre->x;
            at[1] = bore_.y = centre->y;
            bore_.radius = centre->radius;
            bore_.scatter = centre->scatter;
        }
        if (faces_ > 0) at[2] = bore_.z = face_ / faces_;
        if (r.bore < 1 || r.bore > 16 || !decides(r.compensated)) return;
        const std::size_t base = first_value(r.bore, r.turned);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!std::isfinite(at[axis])) continue;
            if (!known_[base + axis]) {
                if (pass_ > 1) continue;
                known_[base + axis] = true;
                reference_[base + axis] = at[axis];
            }
            // A bore that is probed again in a pass shows the drift within the pass, not that of the machine.
            if (passes_[base + axis] == pass_) continue;
            passes_[base + axis] = pass_;
            rule_.deviation(r.time, static_cast<int>(base + axis), at[axis] - reference_[base + axis]);
        }
    }

    std::vector<Record> records_;
    StopRule rule_;
    StopRule::Temperatures first_{}, highest_{}, now_{};
    std::array<bool, StopRule::most_values> known_{};
    std::array<double, StopRule::most_values> reference_{};
    std::array<std::int32_t, StopRule::most_values> passes_{};  // of the last deviation
    BoreTouches circle_;
    double face_ = 0, face_low_ = 0, face_high_ = 0;
    int faces_ = 0;
    std::int32_t pass_ = 0, visit_ = 0, touches_ = 0;
    bool pass_open_ = false;
    int sides_ = 0;  // 0 unknown, 1 without compensation, 2 with it
    Stop stop_ = Stop::none;
    Bore bore_;
};

}  // namespace plumb::growth_test
