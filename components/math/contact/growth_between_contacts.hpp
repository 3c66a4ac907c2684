// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/slew_limit.hpp"
#include "components/math/contact/speed_driven_growth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace plumb {

// The growth between two contacts, from the speed n of the spindle and, if there is one, a temperature T.
// The drive is u = (n / 5000 rpm)^1.7. The rate at which a spindle grows is unknown: three filters with
// lags of 5, 10 and 20 min, four times that at rest, each have the weight that the contacts gave them,
//
//     g = sum of w_i g_i        w_i ~ product of p_i(z)        p_i(z): how likely filter i held the contact z
//
// (D. T. Magill, IEEE Trans. Automatic Control 10, 1965). A lost speed holds; after a minute the growth is
// unknown until the next contact. A lost temperature holds for ten minutes, and counts for nothing in the
// end; a temperature counts as changing slowly even if it jumps.
class GrowthBetweenContacts {
public:
    struct Settings {
        bool by_speed = false;              // else the last contact holds
        double expected_growth = 0.015;     // mu, of a spindle at 5000 rpm
        double unexplained_growth = 0.006;  // mu, standard deviation of growth without speed, in an hour
        double repeatability = 0.001;  // mu, standard deviation of a contact by all but the noise of the load
        double temperature_growth = 0.003;  // mu/K, about

        bool valid() const noexcept {
            const auto within = [](double x, double least, double most) { return x >= least && x <= most; };
            return within(expected_growth, 1e-6, 1) && within(unexplained_growth, 0, 1) &&
                   within(repeatability, 1e-5, 1) && within(temperature_growth, 0, 0.1);
        }
    };

    // One period of dt > 0 seconds, in which one of the filters has its turn. Speed in rpm, temperature in
    // degC; a value that is invalid, or beyond 1e6, is lost.
    void step(double speed, double temperature, bool temperature_valid, const Settings& settings,
              double dt) noexcept {
        if (!started_ || !same(settings)) start(settings);
        follow_temperature(temperature, temperature_valid, dt);
        const bool speed_valid = std::abs(speed) <= 1e6;
        lost_ = speed_valid ? 0 : lost_ + dt;
        if (lost_ > longest_loss) start(settings);
        if (speed_valid && speed != speed_) {
            speed_ = speed;
            drive_ = std::pow(std::abs(speed) / 5000, 1.7);
        }
        for (double& since : since_) since += dt;
        turn_ = (turn_ + 1) % lags.size();
        SpeedDrivenGrowth& filter = filters_[turn_];
        const double waited = std::exchange(since_[turn_], 0);
        if (speed_valid) filter.step(drive_, lags[turn_] * (std::abs(speed) < 1 ? at_rest : 1), waited);
        filter.wander(waited);
        filter.temperature(temperature_.value());
        estimates_[turn_] = {filter.growth(), filter.variance()};
    }

    using Gauge = SpeedDrivenGrowth::Gauge;
    using Expected = SpeedDrivenGrowth::Expected;

    // Mean and variance that a contact of a gauge is expected to have, but for its noise.
    Expected expected(const Gauge& gauge) const noexcept {
        double mean = 0, square = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) {
            const Expected of_filter = filters_[i].expected(gauge);
            mean += weights_[i] * of_filter.mean;
            square += weights_[i] * (of_filter.variance + of_filter.mean * of_filter.mean);
        }
        return {mean, std::max(0.0, square - mean * mean)};
    }

    // A contact of a gauge was accepted. `sigma` is its standard deviation by the noise of the load. A
    // contact that is not `explained`, as the first one of a new reference or a step, may have moved the
    // growth by any distance.
    void correct(double growth, double sigma, const Gauge& gauge, bool explained,
                 const Settings& settings) noexcept {
        const double variance = sigma * sigma + settings.repeatability * settings.repeatability;
        for (std::size_t i = 0; i < lags.size(); ++i) {
            if (!explained) filters_[i].forget_bias();
            likelihood_[i] += filters_[i].correct(growth, variance, gauge);
            estimates_[i] = {filters_[i].growth(), filters_[i].variance()};
        }
        const double best = *std::max_element(likelihood_.begin(), likelihood_.end());
        double sum = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) {
            likelihood_[i] = std::max(likelihood_[i] - best, least_likely);
            sum += weights_[i] = std::exp(likelihood_[i]);
        }
        for (double& weight : weights_) weight /= sum;
        known_ = true;
    }

    bool known() const noexcept { return known_; }  // a contact was accepted since the start

    // Since the reference, in mu; once known.
    double growth() const noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) sum += weights_[i] * estimates_[i].growth;
        return sum;
    }
    // The growth that a spindle as expected would have by its speed.
    double usual_growth(const Settings& settings) const noexcept {
        return settings.expected_growth * filters_[lags.size() / 2].driven();
    }
    double sigma() const noexcept {
        const double mean = growth();
        double sum = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) {
            const double apart = estimates_[i].growth - mean;
            sum += weights_[i] * (estimates_[i].variance + apart * apart);
        }
        return std::sqrt(std::max(0.0, sum));
    }

    // Changes each filter: change(SpeedDrivenGrowth&).
    template <class Change>
    void change(const Change& change) noexcept {
        for (std::size_t i = 0; i < lags.size(); ++i) {
            change(filters_[i]);
            estimates_[i] = {filters_[i].growth(), filters_[i].variance()};
        }
    }

    // See SpeedDrivenGrowth.
    double shift_of_all(double feed) const noexcept {
        return mean([&](const SpeedDrivenGrowth& filter) { return filter.shift_of_all(feed); });
    }
    double error_of(std::int32_t gauge) const noexcept {
        return mean([&](const SpeedDrivenGrowth& filter) { return filter.error_of(gauge); });
    }
    double effect() const noexcept {
        return mean([](const SpeedDrivenGrowth& filter) { return filter.effect(); });
    }
    double fastest_response() const noexcept { return filters_.front().driven(); }

    // Returns to the state after start.
    void forget() noexcept { started_ = known_ = false; }

private:
    template <class Of>
    double mean(const Of& of) const noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) sum += weights_[i] * of(filters_[i]);
        return sum;
    }

    struct Estimate {
        double growth, variance;
    };

    static constexpr std::array<double, 3> lags{300, 600, 1200};  // s
    static constexpr double at_rest = 4;                          // times the lag: no air is moved
    static constexpr double longest_loss = 60;                    // s
    static constexpr double longest_hold = 600;                   // s of a lost temperature
    static constexpr double fastest = 0.01;                       // K/s, of a temperature
    static constexpr double farthest = 100;                       // K, of a temperature
    static constexpr double least_likely = -10;                   // logarithm: no filter is lost for good
    static constexpr double root_of_hour = 60;                    // sqrt(s)

    bool same(const Settings& s) const noexcept {
        return s.expected_growth == settings_.expected_growth &&
               s.unexplained_growth == settings_.unexplained_growth &&
               s.temperature_growth == settings_.temperature_growth;
    }

    void start(const Settings& settings) noexcept {
        settings_ = settings;
        started_ = true;
        known_ = false;
        likelihood_ = {};
        weights_.fill(1.0 / lags.size());
        for (SpeedDrivenGrowth& filter : filters_)
            filter.start({settings.expected_growth, settings.unexplained_growth / root_of_hour,
                          settings.temperature_growth});
    }

    void follow_temperature(double temperature, bool valid, double dt) noexcept {
        const bool usable = valid && std::abs(temperature) <= 1e6;
        temperature_lost_ = usable ? 0 : temperature_lost_ + dt;
        if (!usable) {
            if (temperature_lost_ > longest_hold) temperature_.step(0, fastest, dt);
            return;
        }
        if (!first_known_) first_ = temperature;
        first_known_ = true;
        temperature_.step(bounded(temperature - first_, farthest), fastest, dt);
    }

    std::array<SpeedDrivenGrowth, lags.size()> filters_;
    std::array<Estimate, lags.size()> estimates_{};
    std::array<double, lags.size()> likelihood_{}, weights_{};
    std::array<double, lags.size()> since_{};  // s that each filter has not been advanced by
    std::size_t turn_ = 0;
    Settings settings_;  // of the last start
    bool started_ = false, known_ = false, first_known_ = false;
    double speed_ = 0, drive_ = 0;
    double lost_ = 0;              // s without a speed
    double first_ = 0;             // degC
    double temperature_lost_ = 0;  // s
    SlewLimit temperature_;        // K, since the first one
};

}  // namespace plumb
