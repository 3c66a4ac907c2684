// SPDX-License-Identifier: GPL-2.0-or-later
// What a log of a growth test shows. Lengths are millimetres, times s since the test began.
#pragma once

#include "components/commissioning/growth/artifact_expansion.hpp"
#include "components/commissioning/growth/growth_identify.hpp"
#include "components/commissioning/growth/growth_visits.hpp"
#include "components/compensation/thermal_growth/growth_codes.hpp"
#include "components/io/files/growth_log_file.hpp"
#include "components/math/growth/compensation_effect.hpp"
#include "components/math/growth/coverage_factor.hpp"
#include "components/math/growth/growth_curve.hpp"
#include "components/math/growth/turned_table.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace plumb::commissioning {

// One bore at one orientation in one state, in one pass.
struct GrowthPoint {
    int pass = 0;
    int part = 0;                        // of the test, between two breaks
    double time = 0;                     // of the pass, to which the drift within it was removed
    Eigen::Vector3d deviation{0, 0, 0};  // from the first pass; not a number where it was not probed
    Eigen::Vector3d compensation{0, 0, 0};
    double diameter = 0, scatter = 0;
};

struct GrowthSeries {
    int bore = 0;
    bool turned = false, compensated = false, sphere = false;
    std::vector<GrowthPoint> points;     // of the machine that warms
    std::vector<GrowthPoint> cool_down;  // after the stop, with the machine at rest

    std::string name() const;
};

enum class GrowthVerdict { undetermined, pass, fail };
std::string word(GrowthVerdict verdict);

// One axis in one state, over all bores and orientations.
struct GrowthOfAxis {
    bool probed = false;
    double largest = 0;  // of |deviation|
    double at_1_hour = 0, at_4_hours = 0,
           at_end = 0;                 // deviation of the worst bore then; not a number if not reached
    double range = 0, rate = 0;        // largest of a bore; rate in mm/h between two passes
    std::optional<GrowthCurve> curve;  // of the mean over bores, since the last break
};

// The uncertainty of a deviation of one bore along one axis: standard uncertainties in mm, by their source.
// The reference pass has seat, touch and drift once more.
struct GrowthBudget {
    double touch = 0;                // of the touches
    double seat = 0;                 // of the probe in the spindle, with all other changes from pass to pass
    double drift = 0;                // within the pass, left by its removal
    double artifact = 0, probe = 0;  // of a deviation: by the artifact's expansion, by the probe's own drift
    double freedom = 1;              // degrees of freedom of all

    double pass() const { return std::sqrt(touch * touch + seat * seat + drift * drift); }
    double standard() const { return std::sqrt(2 * pass() * pass() + artifact * artifact + probe * probe); }
    double expanded() const { return coverage_factor(freedom) * standard(); }  // U, 95 %
};

// All bores moved at once along an axis, before a pass: the artifact has slipped, or the probe has changed.
struct GrowthSlip {
    int pass = 0;
    double size = 0;  // mm
};

// Whether the probe itself changed in the test: by the diameter of each bore, which a machine that grows does
// not change.
struct ProbeDrift {
    struct Pass {
        int number = 0;
        double time = 0;    // s
        double change = 0;  // mm, of the diameters since the first pass; the mean over the bores
    };
    std::vector<Pass> passes;  // from the second one on; empty if no circle was probed twice
    double sigma = 0;          // mm, standard, of the least certain change

    double largest() const;
    bool seen() const { return std::abs(largest()) > 3 * sigma; }
};

// What ISO 230-3 asks for beside the growth of the machine that works: its cool-down, the ends of the travel
// of each axis, and the environment alone. Lengths are millimetres.
struct GrowthPractice {
    // One axis, in the mean over the bores, in the state that decides when the machine is warm.
    struct CoolDown {
        double warm = 0, left = 0;  // deviation in the last warm pass, and in the last pass of all
        double rate = 0;            // largest, mm/h
    };
    struct Ends {
        int low = 0, high = 0;                // bores with the least and the largest place along the axis
        double distance = 0;                  // between them
        double at_low = 0, at_high = 0;       // deviation in the last warm pass
        double strain = 0, strain_sigma = 0;  // of the axis, mm in a mm; standard
    };
    double cooled_for = 0;  // s, between the last warm pass and the last one; 0: no cool-down was recorded
    std::array<std::optional<CoolDown>, 3> cool_down;
    std::array<std::optional<Ends>, 3> ends;
    // By sensor: the range of its temperature over the test, K.
    std::vector<std::pair<std::string, double>> ranges;
};

struct GrowthAnalysis {
    const GrowthLog* log = nullptr;
    std::vector<GrowthSeries> series;
    int passes = 0, visits = 0, rejected = 0, faults = 0, resumed = 0, unknown_breaks = 0;
    int parts = 1;               // between breaks in which the machine cools
    std::vector<double> breaks;  // s, the ends of these breaks
    double duration = 0;
    growth_test::Stop stop = growth_test::Stop::none;
    bool cooling_toggled = false;
    std::array<GrowthBudget, 3> budgets;  // of a deviation of each axis
    std::array<double, 3> of_mean{};      // standard uncertainty of a deviation in the mean of all bores
    double uncertainty = 0;               // standard, of a deviation of the worst axis
    std::array<std::optional<GrowthSlip>, 3> slips;
    ArtifactExpansion expansion;
    ProbeDrift probe;
    GrowthPractice practice;
    bool duty_changed = false;  // the spindle speed of the work between the passes
    double last_hour = 0;       // largest change of a deviation in it; not a number if it is not known
    double touch_scatter = 0;   // rms about the circles
    std::array<GrowthOfAxis, 3> off, on;
    bool has_off = false, has_on = false;
    std::array<CompensationGain, 3> gain;
    CompensationFinding finding;
    std::vector<std::string> logged_sensors;  // columns of the temperatures of the finding
    std::array<GrowthVerdict, 3> verdicts{};
    GrowthVerdict verdict = GrowthVerdict::undetermined;
    std::vector<std::string> reasons;
    struct Turned {
        int bore;
        TurnedTable table;
        std::optional<double> tilt;  // about X
    };
    std::vector<Turned> turned;  // in the last pass, without compensation where there is that
    // Temperatures: time and value, by sensor.
    std::map<int, std::vector<std::pair<double, double>>> temperatures;
    std::vector<std::string> notes;
    // The law of the machine, if the caller had it identified; else why there is none.
    std::optional<GrowthIdentified> identified;
    std::string not_identified;

    std::string sensor_name(int sensor) const;
    // Standard uncertainty of the mean of all bores in one pass; a deviation has it twice, by the reference.
    double of_one_pass(std::size_t axis) const { return of_mean[axis] / std::sqrt(2.0); }
};

// The log must outlive the analysis.
GrowthAnalysis analysed(const GrowthLog& log);

// Adds the law of the machine, with the options that plumb growth identify has by itself. Takes up to
// seconds.
void identify_law(GrowthAnalysis& analysis);

}  // namespace plumb::commissioning
