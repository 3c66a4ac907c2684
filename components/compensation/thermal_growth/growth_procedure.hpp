// SPDX-License-Identifier: GPL-2.0-or-later
// A growth test, from signals to records.
//
//     Signals           the program, the machine and the probe in this period, with their edges
//     BoreVisit         the visit of a bore: opened by the program, closed by its touches or a fault
//     GrowthTest        step(signals) once a period: passes, visits, cycles and the end
//     Record            one for each event; GrowthRow shows it on pins
//
// probed_growth.hpp judges the touches and decides when the machine is warm. All but the present visit
// follows from the records: restored, they give the same test.
#pragma once

#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "components/compensation/thermal_growth/probed_growth.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/records.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb::growth_test {

// A bit of this period, and its change since the last one.
struct Bit {
    bool now = false, rises = false, falls = false;

    static Bit of(Edge& edge, bool now) noexcept {
        const bool changes = edge.changes(now);
        return {now, changes && now, changes && !now};
    }
};

// The position of the machine, and the compensation that it contains.
struct Position {
    std::array<double, 3> position{}, offset{}, velocity{};  // mu, mu, mu/s
    bool good = true;
};

struct Warmth {
    int count = 0;                   // of the sensors
    StopRule::Temperatures value{};  // degC; not a number: invalid
    StopRule::Temperatures age{};    // s
    std::uint32_t decides = 0;       // sensors of the stop rule, a bit each
    double sample_time = 60;         // s
    bool good = true, artifact_good = true;
};

// The program, the probe and the machine in one period.
struct Signals {
    Bit running, pass, bore, measuring, cycle, probe;
    bool resume = false;
    double gap = 0;       // s since the last record of a restored test; below 0: unknown
    double bore_key = 0;  // number of the bore
    double max_pass_time = 0;
    bool turned = false, oriented = false;  // the table is at 180 deg, and where the program wants it
    bool overtravel = false;
    bool compensated = false, cooled = false, wants_compensation = false, wants_cooling = false;
    bool confirmed = false;    // both are as the program wants them
    bool unconfirmed = false;  // for longer than confirm-time, while the test runs
    bool gone = false;         // the program that runs the test has ended without its end
    bool paused = false, resumable = false, acknowledged = false;
    double spindle_speed = 0;
    Position at;
    Warmth warmth;
};

enum class Kind : std::int32_t { touch = 1, temperature = 2, event = 3, speed = 4 };

// The item of a record of an event.
enum class Event : std::int32_t {
    begin = 1,  // of the test
    pass_begin = 2,
    pass_end = 3,
    cycle_end = 4,
    stop = 5,  // x is the reason
    resumed = 6,
    rejected = 7,   // the touches of this visit do not count
    fault = 8,      // x is its code
    end = 9,        // the program of the test ended
    measured = 10,  // the touches of this visit count
};

// One thing that happened. A test is the row of its records: restored, they give the same test.
struct Record {
    std::int32_t kind = 0;
    double time = 0;         // s since the test began
    std::int32_t pass = 0;   // from 1
    std::int32_t visit = 0;  // of a bore; counts up through the test
    std::int32_t bore = 0;
    std::int32_t item = 0;  // direction of a touch, number of a sensor, or an event
    bool turned = false, compensated = false, cooled = false;
    double x = 0, y = 0, z = 0;  // a temperature: value, valid, age; a speed: mean since the last one
    double x_offset = 0, y_offset = 0, z_offset = 0;

    bool usable() const noexcept {
        for (const double value : {time, x, y, z, x_offset, y_offset, z_offset})
            if (!(std::abs(value) <= 1e9)) return false;
        return kind >= 1 && kind <= 4 && time >= 0 && pass >= 0 && visit >= 0 && bore >= 0 && bore <= 16 &&
               item >= -3 && item <= 10;
    }
};

struct GrowthRow final : hal::RecordRow<Record> {
    using RecordRow::RecordRow;

    Field<std::int32_t> kind{this, record.kind, "kind", "",
                             "Kind of the record: 1 touch, 2 temperature, 3 event, 4 speed."};
    Field<double> time{this, record.time, "time", "s", "Time since the test began."};
    Field<std::int32_t> pass{this, record.pass, "pass", "", "Number of the pass."};
    Field<std::int32_t> visit{this, record.visit, "visit", "", "Number of the visit of a bore."};
    Field<std::int32_t> bore{this, record.bore, "bore", "", "Number of the bore."};
    Field<std::int32_t> item{this, record.item, "item", "",
                             "Direction of the touch, number of the sensor, or event."};
    Field<bool> turned{this, record.turned, "turned", "", "The table was at 180 deg."};
    Field<bool> compensated{this, record.compensated, "compensated", "", "The compensation was on."};
    Field<bool> cooled{this, record.cooled, "cooled", "", "The temperature control was on."};
    Field<double> x{this, record.x, "x", "1",
                    "X of a touch in mu, a temperature in degC, a speed in rpm, or a code."};
    Field<double> y{this, record.y, "y", "1", "Y of a touch in mu, or 1 for a valid temperature."};
    Field<double> z{this, record.z, "z", "1", "Z of a touch in mu, or the age of a temperature in s."};
    Field<double> x_offset{this, record.x_offset, "x-offset", "mu", "Compensation in X."};
    Field<double> y_offset{this, record.y_offset, "y-offset", "mu", "Compensation in Y."};
    Field<double> z_offset{this, record.z_offset, "z-offset", "mu", "Compensation in Z."};
};

// The present or last visit of a bore: its number in the test, the bore, the latched touch, and the reason
// for which the visit does not count.
class BoreVisit {
public:
    std::int32_t number() const noexcept { return number_; }
    std::int32_t bore() const noexcept { return bore_; }  // 0 for none
    Fault fault() const noexcept { return fault_; }
    std::int32_t direction() const noexcept { return latch_.direction(); }

    // A new test begins, or a test goes on after this visit.
    void begin() noexcept { number_ = bore_ = 0; }
    void continue_after(std::int32_t number) noexcept { number_ = number; }

    void open(const Signals& now) noexcept {
        ++number_;
        const double key = now.bore_key;
        bore_ = key >= 0.5 && key < BoreReferences::most_bores + 0.5
                    ? static_cast<std::int32_t>(std::lround(key))
                    : 0;
        fault_ = bore_ == 0       ? Fault::bore
                 : !now.oriented  ? Fault::orientation
                 : !now.confirmed ? Fault::unconfirmed
                                  : Fault::none;
    }

    // One period of the open visit. True if a touch was latched.
    bool step(const Signals& now) noexcept {
        if (now.overtravel) fault_ = Fault::overtravel;
        if (now.measuring.rises) latch_.arm();
        const bool touched = now.measuring.now && !latch_.latched() && latches(now);
        if (now.measuring.falls && !latch_.latched()) fault_ = Fault::probe_miss;
        return touched;
    }

    // By the judgement of its touches; none leaves it good.
    void reject(Fault fault) noexcept { fault_ = fault; }

private:
    bool latches(const Signals& now) noexcept {
        if (!now.at.good) {
            fault_ = Fault::position;
            return false;
        }
        if (!latch_.step(now.probe.now, now.probe.rises, now.at.velocity)) return false;
        if (latch_.direction() == 0) fault_ = Fault::probe_miss;
        return latch_.direction() != 0;
    }

    std::int32_t number_ = 0, bore_ = 0;
    Fault fault_ = Fault::none;
    TouchLatch latch_;
};

// A test: its time, its passes, its visits of bores, and its records. All but the present visit follows from
// the records: restored, they give the same test. reserve() allocates; nothing else does.
class GrowthTest {
public:
    static constexpr std::size_t most_records = 50000;

    struct Settings {
        StopRule::Settings stop;
        double most_scatter = 0;  // mu, of the touches of a bore about their circle
        double most_change = 0;   // mu, of the shape of a bore since its first visit
        double farthest = 0;      // mu, of a bore from its first place
        double most_step = 0;     // mu, of a bore since its last pass
        double most_slip = 0;     // mu, the same beyond the step of the other bores
        double least_slip = 0;    // mu, of the whole artifact between two passes
        double least_rise = 0;    // K, of a machine that has warmed

        bool valid() const noexcept {
            return stop.valid() && most_scatter > 0 && most_change > 0 && farthest > 0 && most_step > 0 &&
                   most_slip > 0 && least_slip > 0;
        }
    };

    struct Bore {
        double x = 0, y = 0, z = 0, radius = 0, scatter = 0;  // mu
    };

    // The result of a period.
    enum class Result { none, touch, bore };

    void reserve() {
        records_.reserve(most_records);
        rule_.reserve(most_records);
    }

    const std::vector<Record>& records() const noexcept { return records_; }
    bool begun() const noexcept { return !records_.empty(); }
    bool active() const noexcept { return active_; }
    Stop stop() const noexcept { return stop_; }
    double time() const noexcept {
        return time_;
    }  // s since the test began; of the last record, if not active
    std::int32_t pass() const noexcept { return pass_; }
    bool in_pass() const noexcept { return in_pass_; }
    std::int32_t visits() const noexcept { return visits_; }
    bool repeat() const noexcept { return repeat_; }  // the last visit does not count
    std::int32_t bore_of_fault() const noexcept { return fault_ == Fault::none ? 0 : bore_of_fault_; }
    std::int32_t touches() const noexcept { return touches_; }
    int cycles() const noexcept { return rule_.cycles(); }
    const Bore& bore() const noexcept { return bore_; }
    // It stays until it is acknowledged, or the cause ends.
    Fault fault() const noexcept { return fault_ == Fault::none && slipped_ ? Fault::slipped : fault_; }
    double change(const Settings& settings) const noexcept { return rule_.change(settings.stop); }

    void clear() noexcept {
        records_.clear();
        rule_.clear();
        references_.clear();
        places_.clear();
        shapes_.fill({});
        touched_.clear();
        slips_.clear();
        slipped_ = false;
        work_.clear();
        last_speed_ = 0;
        time_ = 0;
        pass_ = visits_ = touches_ = 0;
        sides_ = 0;
        pass_open_ = false;
        stop_ = Stop::none;
        bore_ = Bore();
    }

    // A record of a test of before. False if it is impossible, or there is no room.
    bool restore(const Record& r, const Settings& settings) noexcept { return !active_ && take(r, settings); }

    void acknowledge() noexcept {
        fault_ = Fault::none;
        slipped_ = false;
    }

    // One period.
    Result step(const Signals& now, const Settings& settings, double dt) noexcept {
        state_ = {now.turned, now.compensated, now.cooled};
        if (now.running.rises) begin(now, settings);
        if (!now.running.now) end(settings);
        if (!active_) return Result::none;
        time_ += dt;
        follow_pass(now, settings, dt);
        const Result result = follow_visit(now, settings);
        if (now.cycle.rises) write(Event::cycle_end, 0, settings);
        speed_.step(std::abs(now.spindle_speed), 1e6, dt);
        sample(now.warmth, settings);
        decide(settings);
        return result;
    }

private:
    struct State {
        bool turned = false, compensated = false, cooled = false;
    };

    void begin(const Signals& now, const Settings& settings) noexcept {
        fault_ = Fault::none;
        repeat_ = in_pass_ = sampled_ = false;
        pass_time_ = 0;
        speed_.clear();
        active_ = true;
        if (now.resume && begun() && stop_ == Stop::none) {
            const bool pause_known = now.gap >= 0 && now.gap < 1e7;
            time_ += pause_known ? now.gap : 0;
            visit_.continue_after(visits_);
            write(Event::resumed, pause_known ? 0 : 1, settings);
        } else {
            clear();
            visit_.begin();
            write(Event::begin, 0, settings);
        }
    }

    void end(const Settings& settings) noexcept {
        if (!active_) return;
        write(Event::end, 0, settings);
        active_ = false;
        time_ = records_.back().time;
    }

    // A pass that was interrupted goes on under its number, as its references belong together.
    void follow_pass(const Signals& now, const Settings& settings, double dt) noexcept {
        if (now.pass.now && !in_pass_) {
            if (!pass_open_) ++pass_;
            write(Event::pass_begin, 0, settings);
        }
        if (!now.pass.now && in_pass_) {
            const bool before = slipped_;
            write(Event::pass_end, 0, settings);
            if (slipped_ && !before) write(Event::fault, static_cast<double>(Fault::slipped), settings);
        }
        in_pass_ = now.pass.now;
        pass_time_ = in_pass_ ? pass_time_ + dt : 0;
        if (pass_time_ > now.max_pass_time) fail(Fault::standstill, settings);
    }

    Result follow_visit(const Signals& now, const Settings& settings) noexcept {
        if (now.bore.rises) {
            visit_.open(now);
            repeat_ = false;
        }
        if (now.bore.falls) return close_visit(settings);
        if (!now.bore.now || !visit_.step(now)) return Result::none;
        Record r = record(Kind::touch, visit_.direction());
        r.x = now.at.position[0], r.y = now.at.position[1], r.z = now.at.position[2];
        r.x_offset = now.at.offset[0], r.y_offset = now.at.offset[1], r.z_offset = now.at.offset[2];
        write(r, settings);
        return Result::touch;
    }

    Result close_visit(const Settings& settings) noexcept {
        if (visit_.fault() == Fault::none) visit_.reject(judged(settings));
        repeat_ = visit_.fault() != Fault::none;
        if (repeat_) {
            write(Event::rejected, 0, settings);
            fail(visit_.fault(), settings);
            return Result::none;
        }
        if (is_of_visit(fault_)) fault_ = Fault::none;
        write(Event::measured, 0, settings);
        return Result::bore;
    }

    // Whether the touches of the visit that ends now give a bore that counts.
    Fault judged(const Settings& settings) const noexcept {
        const bool touched = visits_ == visit_.number() && (touched_.has_circle() || touched_.has_face());
        if (!touched) return Fault::probe_miss;
        const auto centre = touched_.centre();
        if (touched_.has_circle() && !centre) return Fault::probe_miss;
        if (centre && centre->scatter > settings.most_scatter) return Fault::false_trigger;
        if (touched_.has_face() && touched_.face_range() > settings.most_scatter) return Fault::false_trigger;
        if (visit_.bore() == 0) return Fault::bore;  // it was open as the test began
        if (const Fault fault = changed(centre, settings); fault != Fault::none) return fault;
        if (pass_ <= 1 || !decides(state_.compensated)) return Fault::none;
        const std::size_t x = BoreReferences::value(visit_.bore(), state_.turned);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!references_.known(x + axis) && (axis == 2 ? touched_.has_face() : centre.has_value()))
                return Fault::no_reference;
        return Fault::none;
    }

    // Whether the bore of this visit is another one than in its first, by its place or by its shape.
    Fault changed(const std::optional<BoreTouches::Centre>& centre, const Settings& settings) const noexcept {
        const std::size_t x = BoreReferences::value(visit_.bore(), state_.turned);
        const Shape& first = shapes_[x / 3];
        const bool same = !centre || !first.known ||
                          (std::abs(touched_.oval(*centre) - first.oval) <= settings.most_change &&
                           std::abs(centre->radius - first.radius) <= settings.most_change);
        if (!same) return Fault::false_trigger;
        const auto at = place(centre);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!places_.known(x + axis) || !std::isfinite(at[axis])) continue;
            if (std::abs(at[axis] - places_.at(x + axis)) > settings.farthest) return Fault::displaced;
            const BoreReferences::Step step = places_.step(x + axis, at[axis], pass_);
            if (std::abs(step.whole) > settings.most_step) return Fault::displaced;
            if (step.alone && std::abs(*step.alone) > settings.most_slip) return Fault::displaced;
        }
        return Fault::none;
    }

    // Where the axes were, with the compensation: the place of a bore does not depend on its state.
    std::array<double, 3> place(const std::optional<BoreTouches::Centre>& centre) const noexcept {
        const std::array<double, 3> mean{centre ? centre->place.x() : NAN, centre ? centre->place.y() : NAN,
                                         touched_.has_face() ? touched_.face() : NAN};
        std::array<double, 3> all{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            all[axis] = mean[axis] + offsets_[axis] / std::max(of_visit_, 1);
        return all;
    }

    void sample(const Warmth& warmth, const Settings& settings) noexcept {
        const double every = warmth.sample_time;
        if (sampled_ && time_ - last_sample_ < (every >= 1 && every <= 3600 ? every : 60)) return;
        sampled_ = true;
        last_sample_ = time_;
        for (std::int32_t i = 0; i < warmth.count; ++i) {
            const auto sensor = static_cast<std::size_t>(i);
            Record r = record(Kind::temperature, i + 1);
            const bool valid = std::isfinite(warmth.value[sensor]);
            r.x = valid ? warmth.value[sensor] : 0;
            r.y = valid ? 1 : 0;
            r.z = warmth.age[sensor];
            write(r, settings);
        }
        if (const auto mean = speed_.take()) {
            Record r = record(Kind::speed, 0);
            r.x = *mean;
            write(r, settings);
        }
    }

    void decide(const Settings& settings) noexcept {
        if (stop_ != Stop::none || records_.size() == decided_) return;
        decided_ = records_.size();
        const auto stop = static_cast<Stop>(rule_.reason(time_, settings.stop));
        if (stop == Stop::none) return;
        write(Event::stop, static_cast<double>(stop), settings);
        if (stop == Stop::maximum_time) fail(Fault::not_stable, settings);
        if (!rule_.has_risen(settings.least_rise, settings.stop)) fail(Fault::no_warm_up, settings);
    }

    // Faults that a good visit ends.
    static bool is_of_visit(Fault fault) noexcept {
        return fault == Fault::probe_miss || fault == Fault::false_trigger || fault == Fault::overtravel ||
               fault == Fault::orientation || fault == Fault::position || fault == Fault::bore ||
               fault == Fault::unconfirmed || fault == Fault::displaced;
    }

    void fail(Fault fault, const Settings& settings) noexcept {
        if (fault != fault_) write(Event::fault, static_cast<double>(fault), settings);
        fault_ = fault;
        bore_of_fault_ = is_of_visit(fault) || fault == Fault::no_reference ? visit_.bore() : 0;
    }

    Record record(Kind kind, std::int32_t item) const noexcept {
        Record r;
        r.kind = static_cast<std::int32_t>(kind);
        r.item = item;
        r.time = time_;
        r.pass = pass_;
        r.visit = visit_.number();
        r.bore = visit_.bore();
        r.turned = state_.turned;
        r.compensated = state_.compensated;
        r.cooled = state_.cooled;
        return r;
    }

    void write(Event event, double x, const Settings& settings) noexcept {
        Record r = record(Kind::event, static_cast<std::int32_t>(event));
        r.x = x;
        write(r, settings);
    }
    void write(const Record& r, const Settings& settings) noexcept {
        if (!take(r, settings) && full()) fault_ = Fault::full;
    }

    bool full() const noexcept { return records_.size() >= most_records; }

    static bool is(const Record& r, Event event) noexcept {
        return r.kind == static_cast<std::int32_t>(Kind::event) && r.item == static_cast<std::int32_t>(event);
    }

    // From here on a new record and a restored one are the same.
    bool take(const Record& r, const Settings& settings) noexcept {
        if (full() || !r.usable() || r.time < time_) return false;
        if (records_.empty() && !is(r, Event::begin)) return false;
        records_.push_back(r);
        time_ = r.time;
        switch (static_cast<Kind>(r.kind)) {
            case Kind::touch: touch(r); break;
            case Kind::temperature: temperature(r); break;
            case Kind::event: event(r, settings); break;
            case Kind::speed:
                work_.step(r.x, 1e9, r.time - last_speed_);
                last_speed_ = r.time;
                break;
        }
        return true;
    }

    void touch(const Record& r) noexcept {
        if (r.visit != visits_) {
            visits_ = r.visit;
            touched_.clear();
            offsets_.fill(0);
            of_visit_ = 0;
            if (sides_ == 0) sides_ = r.compensated ? 2 : 1;  // the first state decides the rule
        }
        ++touches_;
        ++of_visit_;
        const double offset[] = {r.x_offset, r.y_offset, r.z_offset};
        for (std::size_t axis = 0; axis < 3; ++axis) offsets_[axis] += offset[axis];
        touched_.add(r.item, r.x - r.x_offset, r.y - r.y_offset, r.z - r.z_offset);
    }

    void temperature(const Record& r) noexcept {
        if (r.item < 1 || r.item > StopRule::most_sensors) return;
        rule_.sample(r.time, static_cast<std::size_t>(r.item - 1), r.y != 0 ? r.x : NAN);
    }

    void event(const Record& r, const Settings& settings) noexcept {
        switch (static_cast<Event>(r.item)) {
            case Event::pass_begin:
                pass_ = r.pass;
                pass_open_ = true;
                break;
            case Event::pass_end: end_pass(r, settings); break;
            case Event::resumed: slips_.interrupt(); break;
            case Event::cycle_end: rule_.cycle_ends(r.time); break;
            case Event::stop: stop_ = static_cast<Stop>(std::clamp(static_cast<int>(r.x), 0, 2)); break;
            case Event::measured: measure(r); break;
            case Event::rejected: visits_ = std::max(visits_, r.visit); break;
            default: break;
        }
    }

    // The rule follows one state only: the one of the first visit.
    bool decides(bool compensated) const noexcept { return sides_ == 0 || compensated == (sides_ == 2); }

    void measure(const Record& r) noexcept {
        double at[] = {NAN, NAN, NAN};
        if (const auto centre = touched_.centre()) {
            at[0] = bore_.x = centre->place.x();
            at[1] = bore_.y = centre->place.y();
            bore_.radius = centre->radius;
            bore_.scatter = centre->scatter;
        }
        if (touched_.has_face()) at[2] = bore_.z = touched_.face();
        if (r.bore < 1 || r.bore > BoreReferences::most_bores) return;
        Shape& shape = shapes_[BoreReferences::value(r.bore, r.turned) / 3];
        if (const auto centre = touched_.centre(); centre && !shape.known)
            shape = {touched_.oval(*centre), centre->radius, true};
        const auto now = place(touched_.centre());
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (std::isfinite(now[axis]))
                places_.deviation(BoreReferences::value(r.bore, r.turned) + axis, now[axis], pass_);
        if (!decides(r.compensated)) return;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!std::isfinite(at[axis])) continue;
            const std::size_t value = BoreReferences::value(r.bore, r.turned) + axis;
            const BoreReferences::Step step = references_.step(value, at[axis], pass_);
            if (const auto deviation = references_.deviation(value, at[axis], pass_)) {
                rule_.deviation(r.time, static_cast<int>(value), *deviation);
                slips_.take(static_cast<int>(axis), r.turned, *deviation);
            } else if (references_.known(value)) {
                slips_.take_again(static_cast<int>(axis), step.whole);
            }
        }
    }

    void end_pass(const Record& r, const Settings& settings) noexcept {
        pass_open_ = false;
        // Below this the seat of the probe, which scatters from pass to pass, would look like a slip.
        const double least = std::max(settings.least_slip, 8 * settings.stop.uncertainty);
        if (slips_.end_pass(r.time, work_.take().value_or(NAN), least)) slipped_ = true;
    }

    std::vector<Record> records_;
    StopRule rule_;
    BoreReferences references_, places_;  // places_: with the compensation, in every state
    struct Shape {
        double oval = 0, radius = 0;  // mu
        bool known = false;
    };
    std::array<Shape, 2 * BoreReferences::most_bores>
        shapes_;  // of the first visits, by bore and orientation
    SlipWatch slips_;
    bool slipped_ = false;
    MeanOverTime work_;                // rpm, of the spindle, since the last pass
    double last_speed_ = 0;            // s, time of its last record
    ProbedBore touched_;               // in the last visit with a touch
    std::array<double, 3> offsets_{};  // sum over its touches, mu
    int of_visit_ = 0;                 // number of them
    Bore bore_;
    double time_ = 0;
    std::int32_t pass_ = 0, visits_ = 0, touches_ = 0;
    bool pass_open_ = false;  // it has not ended
    int sides_ = 0;           // 0 unknown, 1 without compensation, 2 with it
    Stop stop_ = Stop::none;

    // While it runs.
    bool active_ = false, in_pass_ = false, repeat_ = false, sampled_ = false;
    State state_;
    BoreVisit visit_;
    MeanOverTime speed_;  // rpm, of the spindle, since the last sample
    double pass_time_ = 0, last_sample_ = 0;
    std::size_t decided_ = 0;  // number of records at the last decision
    Fault fault_ = Fault::none;
    std::int32_t bore_of_fault_ = 0;
};

}  // namespace plumb::growth_test
