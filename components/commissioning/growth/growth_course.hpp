// SPDX-License-Identifier: GPL-2.0-or-later
// A machine that warms, as a law of temperatures is found from it: by a growth test, or by gauges that are
// read continuously.
#pragma once

#include "components/io/files/growth_log_file.hpp"
#include "components/math/growth/growth_curve.hpp"

#include <Eigen/Core>

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb::commissioning {

using GrowthSamples = std::vector<std::pair<double, double>>;  // time in s, value; in the order of time

struct GrowthCourse {
    struct Sensor {
        std::string name;
        int number = -1;        // of axis_growth, from 0; -1 if the law may number it
        GrowthSamples samples;  // degC
        bool artifact = false;  // whose own expansion is left out
    };
    struct Value {
        double time = 0;  // s
        int group = 0;    // values of a group differ by growth alone: a bore at one orientation
        int pass = 0;
        Eigen::Vector3d place{0, 0, 0};  // mm; not a number where it was not measured
        // Of a second sensor of X and of Y, nearer to the spindle; not a number without one.
        Eigen::Vector2d upper = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    };

    std::string file, machine, begun;
    std::string taken;            // how the columns of a table were read; "" of a log
    double millimetres = 1;       // in a machine unit
    bool places = false;          // the values are positions of the axes
    bool expansion_out = false;   // the artifact's own expansion has been taken out
    std::vector<Sensor> sensors;  // those with a valid value
    GrowthSamples speeds;         // rpm
    std::vector<Value> values;    // in the order of time
};

// The value at a time, straight between samples.
double value_at(const GrowthSamples& samples, double time);
// Lowest and highest value.
std::pair<double, double> range_of(const GrowthSamples& samples);

// See fit_growth_curve().
std::optional<GrowthCurve> curve_of(const GrowthSamples& samples, double expected_noise = 0);

GrowthCourse course_of(const GrowthLog& log);

// A table of gauges: a time, the spindle speed (S, rpm or speed, or a unit such as rpm), temperatures (T1,
// Temp bearing, or a unit such as degC), and growth (X, Y, Z; X1, Y1 at the end of a mandrel, X2, Y2 nearer
// to the spindle). `heads` are read instead of others, such as "ch2" as "Z (um)". Throws std::runtime_error
// with file, line and reason; a unit that decides and is not stated is a reason.
GrowthCourse read_growth_course(const std::string& file,
                                const std::map<std::string, std::string>& heads = {});

// Whether the file begins as a log of thermal_growth_test does; otherwise it is a course.
bool is_growth_log(const std::string& file);

}  // namespace plumb::commissioning
