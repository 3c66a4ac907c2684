// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/axis_growth/axis_growth_codes.hpp"
#include "components/math/blocks/authority.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/ramped_correction.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/growth/growth_law.hpp"
#include "components/math/growth/temperature_watch.hpp"
#include "hal/axes.hpp"
#include "hal/codes.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "hal/told.hpp"
#include "hal/turning.hpp"
#include "pages/axis_growth.page.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

namespace axis_growth {

struct Settings {
    GrowthLaw law;
    SpindleDrive::Settings drive;
    TemperatureWatch::Settings watch;
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();                            // mu
    GrowthLaw::PerSensor growth_sigma = GrowthLaw::PerSensor::Zero();           // mu/K
    Eigen::Vector3d speed_sigma = Eigen::Vector3d::Zero();                      // mu
    GrowthLaw::Temperatures low = GrowthLaw::Temperatures::Zero(), high = low;  // K, of the rises
    double smoothing = 0, max_age = 0, hold_time = 0;                           // s
    double harmless = 0, max_offset = 0, touch_sigma = 0;                       // mu
    double max_rate = 0, max_speed = 0;                                         // mu/s

    bool in_range = false;

    bool valid() const noexcept { return in_range && (low.array() <= high.array()).all(); }
};

// The law of this machine. plumb-growth(1) prints these lines.
struct LawPins : hal::Group {
    LawPins(hal::Owner owner, std::size_t sensors) : Group(owner), sensors_(sensors) {}

private:
    const std::size_t sensors_;  // their number

public:
    static constexpr hal::Range growths{-1, 1}, slopes{-1e-4, 1e-4}, temperatures{-500, 500},
        places{-1e6, 1e6};
    static constexpr hal::Range rises{-600, 600}, limits{0, 600};
    static constexpr hal::Range sigmas{0, 1}, speeds{1, 1e6}, exponents{0.1, 4}, times{1, 1e6};

    struct Sensor : hal::Group {
        Sensor(hal::Owner owner, const std::string& number)
            : Group(owner),
              growth{this,
                     "%-growth" + number,
                     0.0,
                     "mu/K",
                     "Growth of % by the rise of this temperature.",
                     hal::machine(growths)},
              growth_sigma{this,
                           "%-growth-sigma" + number,
                           0.0,
                           "mu/K",
                           "Standard uncertainty of that growth.",
                           hal::machine(sigmas)},
              slope{this,
                    "%-slope" + number,
                    0.0,
                    "1/K",
                    "Growth of % by that rise, per mu of travel.",
                    hal::machine(slopes)},
              turning{this, growth, slope},
              at_once{this, hal::Effect::at_once, growth, slope} {}
        hal::Axes<hal::In<double>, 3> growth, growth_sigma, slope;
        hal::Turning turning;
        hal::Effects at_once;
    };

    // How far a temperature departs from the mean of the others.
    struct Expected : hal::Group {
        Expected(hal::Owner owner, const std::string& number)
            : Group(owner),
              fast{this,
                   "expected-fast" + number,
                   0.0,
                   "K",
                   "Rise of this temperature above the mean of the others in the end at reference-speed, by "
                   "turning-time.",
                   hal::machine(rises)},
              slow{this, "expected-slow" + number, 0.0, "K", "The same, by slow-time.", hal::machine(rises)},
              low{this,
                  "expected-low" + number,
                  0.0,
                  "K",
                  "Lowest difference from the mean of the others in the growth test.",
                  hal::machine(rises)},
              high{this,
                   "expected-high" + number,
                   0.0,
                   "K",
                   "Highest difference from the mean of the others in the growth test.",
                   hal::machine(rises)},
              limit{this,
                    "expected-limit" + number,
                    0.0,
                    "K",
                    "Largest deviation from the expected difference; 0: the sensor is not judged.",
                    hal::machine(limits)} {}
        hal::In<double> fast, slow, low, high, limit;
    };

    hal::Row<Sensor> sensor{this, sensors_, ""};
    hal::Row<hal::In<double>> reference{this,
                                        sensors_,
                                        "reference",
                                        20.0,
                                        "degC",
                                        "This temperature on the cold machine.",
                                        hal::machine(temperatures)};
    hal::Row<hal::In<double>> low{this,
                                  sensors_,
                                  "rise-low",
                                  -600.0,
                                  "K",
                                  "Lowest rise of this temperature in the growth test.",
                                  hal::machine(rises)};
    hal::Row<hal::In<double>> high{this,
                                   sensors_,
                                   "rise-high",
                                   600.0,
                                   "K",
                                   "Highest rise of this temperature in the test.",
                                   hal::machine(rises)};
    hal::Row<Expected> expected{this, sensors_, ""};
    hal::In<double> slow_time{
        this, "slow-time", 7200, "s", "Time constant of expected-slow.", hal::machine(times)};
    hal::Axes<hal::In<double>, 3> pivot{
        this, "%-pivot", 0.0, "mu", "Position of % where its slope displaces nothing.", hal::machine(places)};
    hal::Axes<hal::In<double>, 3> by_speed{this,
                                           "%-speed-growth",
                                           0.0,
                                           "mu",
                                           "Growth of % in the end at reference-speed.",
                                           hal::machine(growths)};
    hal::Turning turning{this, by_speed};
    hal::Axes<hal::In<double>, 3> speed_sigma{
        this, "%-speed-sigma", 0.0, "mu", "Standard uncertainty of that growth.", hal::machine(sigmas)};
    hal::Axes<hal::In<double>, 3> sigma{this,
                                        "%-sigma",
                                        0.002,
                                        "mu",
                                        "Standard uncertainty of % with the temperatures of its zero.",
                                        hal::machine(sigmas)};
    hal::In<double> reference_speed{
        this, "reference-speed", 5000, "rpm", "Speed of the speed-growth.", hal::machine(speeds)};
    hal::In<double> exponent{
        this, "speed-exponent", 1.7, "1", "Exponent of the speed in the growth.", hal::machine(exponents)};
    hal::In<double> turning_time{
        this, "turning-time", 600, "s", "Time constant of the turning spindle.", hal::machine(times)};
    hal::In<double> stopped_time{
        this, "stopped-time", 2400, "s", "Time constant of the spindle at rest.", hal::machine(times)};

    hal::Effects at_once{this, hal::Effect::at_once, reference, pivot, by_speed, reference_speed, exponent};

    void read(Settings& s, hal::SettingsReader& read) noexcept {
        for (std::size_t row = 0; row < sensors_; ++row) {
            const auto i = static_cast<int>(row);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                s.law.growth(static_cast<int>(axis), i) = read(sensor[row].growth[axis]);
                s.law.slope(static_cast<int>(axis), i) = read(sensor[row].slope[axis]);
                s.growth_sigma(static_cast<int>(axis), i) = read(sensor[row].growth_sigma[axis]);
            }
            s.law.reference[i] = read(reference[row]);
            s.low[i] = read(low[row]);
            s.high[i] = read(high[row]);
            s.watch.fast[i] = read(expected[row].fast);
            s.watch.slow[i] = read(expected[row].slow);
            s.watch.low[i] = read(expected[row].low);
            s.watch.high[i] = read(expected[row].high);
            s.watch.limit[i] = read(expected[row].limit);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int k = static_cast<int>(axis);
            s.law.pivot[k] = read(pivot[axis]);
            s.law.by_speed[k] = read(by_speed[axis]);
            s.speed_sigma[k] = read(speed_sigma[axis]);
            s.sigma[k] = read(sigma[axis]);
        }
        s.drive.reference_speed = read(reference_speed);
        s.drive.exponent = read(exponent);
        s.drive.turning_time = read(turning_time);
        s.drive.stopped_time = read(stopped_time);
        s.watch.slow_time = read(slow_time);
    }
};

// The temperatures, each with its doubts: value, valid, age, and whether it contradicts the others. An
// invalid one keeps its last good value.
class Sensors : public hal::Group {
public:
    Sensors(hal::Owner owner, std::size_t number) : Group(owner), number_(number) {}

    // `used`: the law reads this sensor; `x`, `y`: what the spindle has been driven to, also slowly.
    template <class Used>
    void step(const Settings& settings, Used used, double x, double y, double dt) noexcept {
        std::array<double, GrowthLaw::sensors> now{};
        std::array<bool, GrowthLaw::sensors> valid{};
        GrowthLaw::Temperatures rises = GrowthLaw::Temperatures::Zero();
        bool judged = true;
        for (std::size_t row = 0; row < number_; ++row) {
            const auto i = static_cast<int>(row);
            const double age = age_[row];
            now[row] = value_[row];
            valid[row] =
                valid_[row] && now[row] > -100 && now[row] < 500 && age >= 0 && age <= settings.max_age;
            if (valid[row] && !seen_known_[row]) seen_[row].set(now[row]);
            if (valid[row]) seen_[row].step(now[row], settings.smoothing, dt);
            seen_known_[row] |= valid[row];
            rises[i] = seen_[row].value() - settings.law.reference[i];
            judged &= seen_known_[row] && (valid[row] || settings.watch.limit[i] == 0);
        }
        watch_.step(rises, judged, x, y, settings.watch, dt);
        bool good = true, known = true;
        for (std::size_t row = 0; row < number_; ++row) {
            const auto i = static_cast<int>(row);
            const bool fine = valid[row] && !watch_.doubts(i, settings.watch);
            if (fine && !known_[row]) lag_[row].set(now[row]);
            if (fine) lag_[row].step(now[row], settings.smoothing, dt);
            known_[row] |= fine;
            smooth_[i] = known_[row] ? lag_[row].value() : settings.law.reference[i];
            if (!used(i)) continue;
            good &= fine;
            known &= known_[row];
        }
        rises_ = settings.law.rises(smooth_);
        all_known_ = known;
        lost_ = good ? 0 : std::min(lost_ + dt, 1e9);
    }

    const GrowthLaw::Temperatures& values() const noexcept { return smooth_; }  // degC
    const GrowthLaw::Temperatures& rises() const noexcept { return rises_; }    // K, as the law counts them
    bool all_known() const noexcept { return all_known_; }       // each that the law reads was valid once
    double lost() const noexcept { return lost_; }               // s since one of them was fine
    int contradicts() const noexcept { return watch_.named(); }  // the sensor that does, or -1

private:
    const std::size_t number_;
    hal::Row<hal::In<double>> value_{this, number_, "temperature",
                                     20.0, "degC",  "Temperature of this sensor."};
    hal::Effects at_once_{this, hal::Effect::at_once, value_};
    hal::Row<hal::In<bool>> valid_{this, number_, "temperature-valid", true,
                                   "The sensor reports that it is valid."};
    hal::Row<hal::In<double>> age_{this, number_, "temperature-age",
                                   0.0,  "s",     "Time since the sensor was read."};
    std::array<FirstOrderLag, GrowthLaw::sensors> lag_, seen_;
    std::array<bool, GrowthLaw::sensors> known_{}, seen_known_{};
    TemperatureWatch watch_;
    GrowthLaw::Temperatures smooth_ = GrowthLaw::Temperatures::Zero(), rises_ = smooth_;
    double lost_ = 0;
    bool all_known_ = false;
};

// Touches of a reference that is fixed to the machine, and the correction of the law that follows from them.
class Touches : public hal::Group {
public:
    using Group::Group;

    // `line`: the law now; `offset`: in force; `still`: the touch counts; `between`: no part is made; `zero`:
    // a work zero was set.
    void step(const Settings& settings, const GrowthLaw::Line& line, const Eigen::Vector3d& place,
              const Eigen::Vector3d& offset, double driven, bool still, bool between, bool zero,
              double dt) noexcept {
        const Eigen::Vector3d law = line.at(place, settings.law.pivot);
        if (!(settings.law == law_of_)) {
            for (ProbedReference& each : axes_) each.forget();
            law_of_ = settings.law;
            moved_ = false;
        }
        const double number = axis_, position = position_;
        const int axis = number > 0.5 && number < 3.5 ? static_cast<int>(std::lround(number)) - 1 : -1;
        for (int k = 0; k < 3; ++k) {
            ProbedReference& its = axes_[static_cast<std::size_t>(k)];
            its.step(dt, of_axis(settings, k));
            if (zero) its.count_from_zero(line.at(touched_at_, settings.law.pivot)[k], of_axis(settings, k));
        }
        if (touched_.rises(axis >= 0)) {
            outcome_ = Probing::not_now;
            if (still && std::abs(position) <= farthest) {
                ProbedReference& its = axes_[static_cast<std::size_t>(axis)];
                const bool cold = driven < cold_drive &&
                                  (!its.referred() || std::abs(its.since(law[axis])) <= settings.harmless);
                outcome_ = its.probe(position + offset[axis], law[axis], cold, of_axis(settings, axis));
                moved_ = outcome_ == Probing::moved;
                touched_at_[axis] = place[axis];
            }
            told_for_ = told_time;
            for (int k = 0; k < 3; ++k) changes_[k] = axes_[static_cast<std::size_t>(k)].change(law[k]);
        }
        told_for_ = std::max(told_for_ - dt, 0.0);
        for (std::size_t k = 0; k < 3; ++k) {
            change_[k] = changes_[static_cast<int>(k)];
            if (between) axes_[k].take_over();
        }
        code_ = outcome_;
        news_ = told_for_ > 0;
    }

    void correct(GrowthLaw::Line& line) const noexcept {
        for (int k = 0; k < 3; ++k) {
            const ProbedReference& its = axes_[static_cast<std::size_t>(k)];
            line.offset[k] = its.scale() * line.offset[k] + its.shift();
            line.slope[k] *= its.scale();
        }
    }
    // Standard uncertainties, `without` touches at first.
    Eigen::Vector3d sigmas(const Eigen::Vector3d& law, Eigen::Vector3d without) const noexcept {
        for (int k = 0; k < 3; ++k) without[k] = axes_[static_cast<std::size_t>(k)].sigma(law[k], without[k]);
        return without;
    }
    bool moved() const noexcept { return moved_; }
    bool revoked() const noexcept {
        return std::any_of(axes_.begin(), axes_.end(),
                           [](const ProbedReference& its) { return its.revoked(); });
    }

private:
    static constexpr double farthest = 1e6, told_time = 1;  // mu, s
    static constexpr double cold_drive = 0.05;              // of the spindle

    static ProbedReference::Settings of_axis(const Settings& settings, int k) noexcept {
        ProbedReference::Settings its;
        its.uncertainty = settings.touch_sigma;
        its.law_sigma = std::max(settings.sigma[k], settings.harmless);
        its.least_drift = 2 * settings.harmless;
        its.fading = settings.watch.slow_time;
        return its;
    }

    hal::In<double> axis_{
        this, "touched-axis", 0, "1",
        "Axis along which the reference was touched: 1 X, 2 Y, 3 Z; counts when it leaves 0."};
    hal::In<double> position_{this, "touched-position", 0, "mu",
                              "Machine position of that axis at the touch, as LinuxCNC counts."};
    hal::Axes<hal::Out<double>, 3> change_{
        this, "%-touch-change", "mu", "Change of the offset of % by the last touch, from the next part on."};
    hal::Code<Probing> code_{this, "touch-code", "Outcome of the last touch of the reference."};
    hal::Out<bool> news_{this, "touch-news", "The reference was touched; true for a second."};
    hal::Told told_{this, "touch-news", hal::Tell::text, "{touch-code}"};

    std::array<ProbedReference, 3> axes_;
    Eigen::Vector3d changes_ = Eigen::Vector3d::Zero(), touched_at_ = changes_;
    GrowthLaw law_of_;
    Edge touched_;
    Probing outcome_ = Probing::none;
    double told_for_ = 0;
    bool moved_ = false;
};

}  // namespace axis_growth

struct AxisGrowth final : hal::Component {
    static constexpr hal::About about{
        "axis_growth", "compensates thermal growth of X, Y and Z, by temperatures and spindle speed", page,
        "Growth of the axes"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;
    using Fault = axis_growth::Fault;
    using Doubt = axis_growth::Doubt;
    using Settings = axis_growth::Settings;

    hal::LengthUnit unit{this};

    hal::Count number_of_sensors{
        this,
        "sensors",
        1,
        1,
        GrowthLaw::sensors,
        "Number of temperature sensors, 1 to 4: the rows temperature-N, x-growth-N and so on."};
    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Apply the offsets; else 0."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::Axes<hal::In<double>, 3> position{this, "%-position", 0.0, "mu", "Commanded position of %."};
    hal::In<bool> zero_set{this, "zero-set", false,
                           "A rising edge says that a work zero was set: growth counts from here."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm", "Speed of the spindle."};
    axis_growth::Sensors sensors{this, number_of_sensors};
    axis_growth::LawPins law{this, number_of_sensors};
    static constexpr hal::Range smoothings{0, 3600}, ages{0, 1e6}, errors{0, 1}, offsets{0, 100};
    static constexpr hal::Range rates{1e-6, 10}, axis_speeds{1e-6, 1e5}, touch_sigmas{1e-6, 1};
    hal::In<double> smoothing{
        this, "smoothing", 20, "s", "Time constant that smooths the temperatures.", hal::machine(smoothings)};
    hal::In<double> max_age{this, "max-age", 60, "s", "Largest age of a temperature.", hal::machine(ages)};
    hal::In<double> hold_time{this,
                              "hold-time",
                              1800,
                              "s",
                              "Time without a temperature, after which the offset returns to 0.",
                              hal::expert(axis_growth::LawPins::times)};
    hal::In<double> harmless{
        this, "harmless", 0.005, "mu", "An offset this wrong does no harm.", hal::machine(errors)};
    hal::In<double> touch_sigma{this,
                                "touch-sigma",
                                0.002,
                                "mu",
                                "Standard uncertainty of a touch of the reference.",
                                hal::machine(touch_sigmas)};
    hal::In<double> max_offset{
        this, "max-offset", 0.15, "mu", "Largest offset of an axis, either way.", hal::machine(offsets)};
    hal::In<double> max_rate{this,
                             "max-rate",
                             0.002,
                             "mu/s",
                             "Fastest change of the offsets but for motion.",
                             hal::machine(rates)};
    hal::In<double> max_speed{
        this, "max-speed", 1000, "mu/s", "No axis moves faster.", hal::must(axis_speeds)};

    axis_growth::Touches touches{this};

    hal::Axes<hal::Out<double>, 3> offset{this, "%-offset", "mu", "Offset of %, for its stage."};
    hal::Axes<hal::Out<double>, 3> growth{this, "%-growth", "mu", "Growth of % here and now, by the law."};
    hal::Axes<hal::Out<double>, 3> growth_sigma{this, "%-growth-sigma", "mu",
                                                "Standard uncertainty of the growth since the zero."};
    hal::Out<double> authority{
        this, "authority", "1",
        "Part of the growth that is applied, 0 to 1; it falls when a temperature is lost."};
    hal::Out<double> lost_age{this, "lost-age", "s",
                              "Time since a temperature was lost; 0 while all are valid."};
    hal::Out<bool> ramping{this, "ramping", "The offsets still change to their wanted values."};
    hal::Out<bool> limited{this, "limited", "The growth of an axis exceeds max-offset."};
    hal::Codes<Doubt> doubt{this, "doubt", "The growth may be wrong; doubt-code gives the reason."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<AxisGrowthStatus> status{this, permission};

    hal::Offset moves[3]{{this, moving(0)}, {this, moving(1)}, {this, moving(2)}};

    hal::Effects when_it_applies{this, hal::Effect::applies, all_homed};
    hal::Effects at_once{this, hal::Effect::at_once, position, spindle_speed, max_offset};

    hal::Function run{this, "update", &AxisGrowth::update, hal::Place::source};

    void prepare() override { judge(); }

    void update(double dt) noexcept {
        permission.step();
        const bool settings_good = judge();
        const bool jumped = read_position(dt);
        const double speed = spindle_speed;
        const bool speed_good = std::abs(speed) <= 1e6;
        speed_ = speed_good ? speed : speed_;
        const double driven = drive_.step(speed_, settings_.drive, dt);
        SpindleDrive::Settings slow = settings_.drive;
        slow.turning_time = slow.stopped_time = settings_.watch.slow_time;
        sensors.step(
            settings_, [this](int i) noexcept { return settings_.law.uses(i); }, driven,
            slow_drive_.step(speed_, slow, dt), dt);

        GrowthLaw::Line line = settings_.law.at(sensors.rises(), driven);
        const bool zero = zero_edge_.rises(zero_set) && sensors.all_known();
        if (zero) zero_ = {sensors.values(), driven, true};
        const bool homed = all_homed, enabled = permission.enabled();
        const bool applies = enabled && homed && sensors.all_known();
        const bool counts = homed && sensors.all_known() && sensors.lost() == 0 && !ramp_.ramping() &&
                            position_good_ && !settings_.law.is_empty();
        const Eigen::Vector3d by_law = line.at(position_, settings_.law.pivot);
        touches.step(settings_, line, position_, ramp_.offset(), driven, counts, !cycle_running, zero, dt);
        touches.correct(line);
        const double part = trust(driven, applies);
        sigma_ = touches.sigmas(by_law, sigma_);
        follow(line, applies ? part : 0, jumped, dt);

        const Eigen::Vector3d grown = line.at(position_, settings_.law.pivot);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int k = static_cast<int>(axis);
            offset[axis] = ramp_.offset()[k];
            growth[axis] = sensors.all_known() ? grown[k] : 0;
            growth_sigma[axis] = sigma_[k];
        }
        authority = applies ? part : 0;
        lost_age = sensors.lost();
        ramping = ramp_.ramping();
        limited = ramp_.limited();
        const bool uncertain = sigma_.maxCoeff() > settings_.harmless;
        const int wrong = sensors.contradicts();
        const Doubt its_doubt = hal::first<Doubt>({{wrong >= 0, axis_growth::contradiction(wrong)},
                                                   {sensors.lost() > settings_.hold_time, Doubt::old},
                                                   {sensors.lost() > 0, Doubt::sensor},
                                                   {touches.revoked(), Doubt::revoked},
                                                   {touches.moved(), Doubt::moved},
                                                   {applies && uncertain && beyond_, Doubt::range},
                                                   {applies && uncertain, Doubt::uncertain}});
        doubt = its_doubt;
        const Fault its_fault = hal::first<Fault>({{!position_good_, Fault::position},
                                                   {settings_.law.uses_speed() && !speed_good, Fault::speed},
                                                   {!settings_good, Fault::settings}});
        fault = its_fault;
        AxisGrowthSeen seen;
        seen.fault = its_fault != Fault::none;
        seen.has_law = !settings_.law.is_empty();
        seen.enabled = enabled;
        seen.homed = homed;
        seen.temperatures_known = sensors.all_known();
        seen.returns = sensors.lost() > settings_.hold_time;
        seen.held = sensors.lost() > 0 || wrong >= 0;
        seen.moved = touches.moved();
        seen.revoked = touches.revoked();
        seen.uncertain = its_doubt == Doubt::range || its_doubt == Doubt::uncertain;
        seen.bounded = ramp_.limited();
        seen.ramping = ramp_.ramping();
        seen.interlock = status.of_interlock();
        status = status_of(seen);
        permission.report({false, true, false, ramp_.ramping()});
    }

private:
    static constexpr double play = 0.1;  // of max-speed: blended moves add up
    static constexpr double farthest = 1e6;
    static constexpr double bent = 0.3;  // by which a term may deviate outside of its range

    hal::MovingPin moving(std::size_t axis) {
        return hal::MovingPin(offset[axis])
            .bound(max_offset)
            .rate(max_rate)
            .accelerated_by("The stage limits its acceleration, joint_offset(9) by offset-acceleration.")
            .limited(limited)
            .motion(position[axis], GrowthLaw::steepest);
    }

    // False if the settings contradict themselves; the last good set stays in force.
    bool judge() noexcept {
        Settings wanted;
        hal::SettingsReader read;
        law.read(wanted, read);
        wanted.smoothing = read(smoothing);
        wanted.max_age = read(max_age);
        wanted.hold_time = read(hold_time);
        wanted.harmless = read(harmless);
        wanted.touch_sigma = read(touch_sigma);
        wanted.max_offset = read(max_offset);
        wanted.max_rate = read(max_rate);
        wanted.max_speed = read(max_speed);
        wanted.in_range = read.good();
        if (!wanted.valid()) return false;
        settings_ = wanted;
        return true;
    }

    // Whether a position has changed faster than its axis can move.
    bool read_position(double dt) noexcept {
        bool jumped = false;
        position_good_ = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double now = position[axis];
            double& known = position_[static_cast<int>(axis)];
            const double last = known;
            known = usable(now, farthest, known);
            position_good_ &= std::abs(now) <= farthest;
            jumped |= std::abs(known - last) > settings_.max_speed * dt * (1 + play);
        }
        return jumped;
    }

    // The part of the growth that is applied, which falls with the age of a lost temperature. The law
    // predicts better than no law, so all of the growth is applied however uncertain it is. What the law does
    // not know is how the temperatures and the spindle have changed the growth since the work zero, which
    // holds the rest.
    double trust(double driven, bool applies) noexcept {
        const bool holds = cycle_running && applies;
        const GrowthLaw::Temperatures& rise = sensors.rises();
        GrowthLaw::Temperatures since = rise;
        if (zero_.set) since -= settings_.law.rises(zero_.temperatures);
        GrowthLaw::Temperatures outside;
        for (int i = 0; i < GrowthLaw::sensors; ++i)
            outside[i] = std::max({0.0, settings_.low[i] - rise[i], rise[i] - settings_.high[i]});
        const double lost = std::min(sensors.lost() / std::max(settings_.hold_time, 1.0), 1.0);
        beyond_ = false;
        for (int k = 0; k < 3; ++k) {
            const GrowthLaw::Temperatures by = settings_.law.growth.row(k).cwiseAbs().transpose();
            const double terms = settings_.growth_sigma.row(k).transpose().cwiseProduct(since).norm();
            const double by_speed = settings_.speed_sigma[k] * (driven - (zero_.set ? zero_.driven : 0));
            const double beyond = bent * by.dot(outside);
            const double unseen = lost * by.dot(since.cwiseAbs());
            const double known = std::hypot(settings_.sigma[k], std::hypot(terms, by_speed));
            sigma_[k] = std::hypot(known, std::hypot(beyond, unseen));
            beyond_ |= beyond > known;
        }
        return authority_.step({1, 0, sensors.lost(), 1}, holds, {0, 1, 0, settings_.hold_time});
    }

    // Motion moves the offset at once; the ramp takes every other change.
    void follow(const GrowthLaw::Line& line, double part, bool jumped, double dt) noexcept {
        const RampedCorrection::Wanted last = wanted_;
        RampedCorrection::Wanted before = last;
        if (!jumped) before.offset = applied_.at(position_, pivot_);
        applied_ = {part * line.offset, part * line.slope};
        pivot_ = settings_.law.pivot;
        wanted_.offset = applied_.at(position_, pivot_);
        wanted_.most = settings_.max_offset;
        ramp_.step(wanted_, before, settings_.max_rate, dt);
    }

    Settings settings_;  // last good values
    Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), pivot_ = position_;
    Eigen::Vector3d sigma_ = Eigen::Vector3d::Zero();
    struct Zero {
        GrowthLaw::Temperatures temperatures = GrowthLaw::Temperatures::Zero();  // degC
        double driven = 0;
        bool set = false;
    };

    double speed_ = 0;
    bool position_good_ = true, beyond_ = false;
    Zero zero_;
    Edge zero_edge_;
    SpindleDrive drive_, slow_drive_;
    Authority authority_;
    GrowthLaw::Line applied_;
    RampedCorrection::Wanted wanted_;
    RampedCorrection ramp_;
};

hal::Model hal::model() {
    return model_of<AxisGrowth>();
}

}  // namespace plumb
