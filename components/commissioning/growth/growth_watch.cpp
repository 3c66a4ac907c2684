// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_watch.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb::commissioning {
namespace {

using PerSensor = TemperatureWatch::PerSensor;

constexpr double step = 60;  // s
constexpr int blocks = 5;    // of a day; each from the third on is predicted by those before
// A limit is what moves an axis by `harm`, but between 1.5 and 4 times the largest error of the hours that
// were left out, and 0.25 K more for noise: on 24 drawn machines the largest error of another day was 0.3 to
// 3.4 times as large. A sensor that no law reads does no harm, and has the largest limit.
constexpr double harm = 0.007;  // mm
constexpr double least = 1.5, most = 4, noise = 0.25;

struct Moment {
    PerSensor contrast = PerSensor::Zero();
    Eigen::Vector2d drive = Eigen::Vector2d::Zero();
    int block = 0;
};

struct Fit {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Identity() * 1e-6;
    Eigen::Matrix<double, 2, TemperatureWatch::sensors> right =
        Eigen::Matrix<double, 2, TemperatureWatch::sensors>::Zero();

    void add(const Moment& moment) {
        normal += moment.drive * moment.drive.transpose();
        right += moment.drive * moment.contrast.transpose();
    }
    Eigen::Matrix<double, 2, TemperatureWatch::sensors> solved() const { return normal.ldlt().solve(right); }
};

double speed_at(const GrowthSamples& speeds, double time) {
    const auto next = std::upper_bound(speeds.begin(), speeds.end(), std::pair(time, HUGE_VAL));
    return next == speeds.begin() ? next->second : (next - 1)->second;
}

}  // namespace

std::optional<GrowthWatch> learned_watch(const std::vector<const GrowthObservations::Sensor*>& sensors,
                                         const std::vector<double>& growths,
                                         const std::vector<GrowthSamples>& speeds,
                                         const std::optional<SpindleDrive::Settings>& drive) {
    if (sensors.size() < 2) return {};
    if (std::any_of(speeds.begin(), speeds.end(), [](const auto& day) { return day.empty(); })) return {};
    const auto count = static_cast<Eigen::Index>(sensors.size());
    TemperatureWatch::Settings judged;
    judged.limit.head(count).setOnes();
    std::vector<std::vector<Moment>> days(speeds.size());
    for (std::size_t day = 0; day < speeds.size(); ++day) {
        const GrowthSamples& samples = sensors.front()->days[day];
        const double begin = samples.front().first, span = samples.back().first - begin;
        for (double t = begin; t <= samples.back().first; t += step) {
            PerSensor rises = PerSensor::Zero();
            for (Eigen::Index i = 0; i < count; ++i)
                rises[i] = sensors[static_cast<std::size_t>(i)]->rise(day, t);
            Moment moment;
            moment.contrast = TemperatureWatch::contrasts(rises, judged);
            moment.block =
                std::min(static_cast<int>((t - begin) / std::max(span, step) * blocks), blocks - 1);
            days[day].push_back(moment);
        }
    }
    const auto try_drive = [&](const SpindleDrive::Settings& its, double slow_time, GrowthWatch& watch) {
        SpindleDrive::Settings slow = its;
        slow.turning_time = slow.stopped_time = slow_time;
        for (std::size_t day = 0; day < days.size(); ++day) {
            SpindleDrive fast_drive, slow_drive;
            double t = sensors.front()->days[day].front().first;
            for (Moment& moment : days[day]) {
                const double speed = speed_at(speeds[day], t);
                moment.drive = {fast_drive.value(), slow_drive.value()};
                fast_drive.step(speed, its, step);
                slow_drive.step(speed, slow, step);
                t += step;
            }
        }
        Fit fit;
        double squares = 0;
        PerSensor largest = PerSensor::Zero();
        for (int block = 0; block < blocks; ++block) {
            const auto by = fit.solved();
            for (const auto& day : days)
                for (const Moment& moment : day) {
                    if (moment.block != block) continue;
                    fit.add(moment);
                    if (block < 2) continue;
                    const PerSensor rest = moment.contrast - by.transpose() * moment.drive;
                    squares += rest.squaredNorm();
                    largest = largest.cwiseMax(rest.cwiseAbs());
                }
        }
        const auto by = fit.solved();
        watch.settings.fast = by.row(0).transpose();
        watch.settings.slow = by.row(1).transpose();
        watch.settings.slow_time = slow_time;
        watch.drive = its;
        watch.settings.low = watch.settings.high = PerSensor::Zero();
        for (const auto& day : days)
            for (const Moment& moment : day) {
                watch.settings.low = watch.settings.low.cwiseMin(moment.contrast);
                watch.settings.high = watch.settings.high.cwiseMax(moment.contrast);
                largest = largest.cwiseMax((moment.contrast - by.transpose() * moment.drive).cwiseAbs());
            }
        watch.settings.limit = PerSensor::Zero();
        for (Eigen::Index i = 0; i < count; ++i) {
            const double growth = growths[static_cast<std::size_t>(i)];
            const double harmful = growth > 0 ? harm / growth : HUGE_VAL;
            watch.settings.limit[i] =
                std::clamp(harmful, least * largest[i] + noise, most * largest[i] + noise);
        }
        return squares;
    };
    GrowthWatch best;
    double fewest = std::numeric_limits<double>::infinity();
    const auto improve = [&](const SpindleDrive::Settings& its) {
        for (const double slow_time : {3600.0, 7200.0}) {
            GrowthWatch watch;
            const double squares = try_drive(its, slow_time, watch);
            if (squares >= fewest) continue;
            fewest = squares;
            best = watch;
        }
    };
    if (drive)
        improve(*drive);
    else
        for (const double turning : {300.0, 600.0, 1200.0, 2400.0})
            for (const double ratio : {1.0, 2.0, 4.0})
                for (const double power : {1.0, SpindleDrive::Settings().exponent}) {
                    SpindleDrive::Settings its;
                    its.exponent = power;
                    its.turning_time = turning;
                    its.stopped_time = ratio * turning;
                    improve(its);
                }
    return best;
}

}  // namespace plumb::commissioning
