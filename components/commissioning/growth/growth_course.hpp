// SPDX-License-Identifier: GPL-2.0-or-later
// A machine that warms, as a law of temperatures is found from it: by a growth test, or by gauges that are
// read continuously.
#pragma once

#include "components/io/files/growth_log_file.hpp"

#include <Eigen/Core>

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plumb::commissioning {

using GrowthSamples = std::vector<std::pair<double, double>>;  // time in s, value; in the order of time

struct GrowthCourse {
    struct Sensor {
        std::string name;
        int number = -1;        // of axis_growth, from 0; -1 if the law may number it
        GrowthSamples samples;  // degC, smoothed as axis_growth does it
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
    double millimetres = 1;       // in a machine unit
    bool places = false;          // the values are positions of the axes
    bool expansion_out = false;   // the artifact's own expansion has been taken out
    std::vector<Sensor> sensors;  // those with a valid value
    GrowthSamples speeds;         // rpm
    std::vector<Value> values;    // in the order of time
};

// The value at a time, straight between samples.
double value_at(const GrowthSamples& samples, double time);

GrowthCourse course_of(const GrowthLog& log);

// CSV whose first line names the columns: a time (a name that ends in _s, _min or _h; else min), the spindle
// speed (S, rpm or speed, or a name that ends in _rpm), temperatures (T and a number, or a name that ends in
// _degC), and growth in um (X, Y, Z, or x_um, y_um, z_um; X1, Y1 at the end of a mandrel, X2, Y2 nearer to
// the spindle). A field that is no number is a missing value. Throws std::runtime_error with file, line and
// reason.
GrowthCourse read_growth_course(const std::string& file);

// Whether the file begins as a log of thermal_growth_test does; otherwise it is a course.
bool is_growth_log(const std::string& file);

}  // namespace plumb::commissioning
