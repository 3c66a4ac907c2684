// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_report.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>

#include "components/commissioning/growth/growth_visits.hpp"

namespace plumb::commissioning {
namespace {

// Why the compensation is not determined, and what would determine it.
std::string undetermined_sentence(const GrowthAnalysis& test) {
    const CompensationFinding& its = test.finding;
    const auto passes = [](int count) {
        return std::to_string(count) + (count == 1 ? " more pass" : " more passes");
    };
    const bool any_drift = its.drifts[0] || its.drifts[1] || its.drifts[2];
    if (!any_drift && its.more_passes > 0) return " It needs " + passes(its.more_passes) + " in both states.";
    if (!any_drift)
        return " No axis drifts by " + um(its.larger_drift) + " \u00b5m: work the machine warmer.";
    std::string text = " Its gain is between " + number(its.gain_low, 2) + " and " +
                       number(its.gain_high, 2) + ", 95 of 100; good is " + number(weakest_good_gain, 2) +
                       " to " + number(strongest_good_gain, 2) + ". ";
    if (its.more_passes > 0)
        text +=
            "To determine it, add " + passes(its.more_passes) + " of the warm machine, or work it warmer, to";
    else
        text +=
            "More passes do not determine it, as all have one reference pass. Work the machine warmer, to";
    return text + " a drift of " + um(its.larger_drift) + " \u00b5m.";
}

// A gain is judged over all axes together. An axis with little drift may follow none, or another one.
std::string axes_apart(const GrowthAnalysis& test) {
    std::string text;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const CompensationGain& its = test.gain[axis];
        if (!its.determined || (its.gain + 2 * its.uncertainty >= weakest_good_gain &&
                                its.gain - 2 * its.uncertainty <= strongest_good_gain))
            continue;
        text += std::string(" But ") + letters[axis] + ", which drifts by " + um(test.off[axis].largest) +
                " \u00b5m without it, has a gain of " + number(its.gain, 2) + ".";
    }
    return text;
}

}  // namespace

std::string number(double value, int digits) {
    if (!std::isfinite(value)) return "\u2013";
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}
std::string um(double mm) {
    return number(mm * 1e3);
}

std::string clause(const GrowthLog& log) {
    const std::string what = log.warming == "none"   ? "Environmental temperature variation error"
                             : log.warming == "axes" ? "Thermal distortion caused by moving linear axes"
                                                     : "Thermal distortion caused by rotating spindle";
    return what +
           ", after ISO 230-3. Not an ISO 230-3 test: that reads displacement sensors at a mandrel, and this "
           "a probe "
           "at a stopped spindle";
}

std::string compensation_sentence(const GrowthAnalysis& test) {
    if (!test.has_on || !test.has_off) return "Only one state was probed: the compensation is not judged.";
    std::string text = sentence(test.finding.fault);
    const auto sensor = [&](int column) {
        return column >= 0 && static_cast<std::size_t>(column) < test.logged_sensors.size()
                   ? test.logged_sensors[static_cast<std::size_t>(column)]
                   : std::string();
    };
    if (test.finding.axis >= 0)
        text += " Axes: " + std::string(1, letters[test.finding.axis]) + " and " +
                std::string(1, letters[test.finding.other_axis]) + ".";
    if (test.finding.sensor >= 0)
        text += " Sensor: " + sensor(test.finding.sensor) +
                (test.finding.other_sensor >= 0 ? " and " + sensor(test.finding.other_sensor) : "") + ".";
    if (test.finding.fault == CompensationFault::undetermined) {
        if (test.verdict == GrowthVerdict::pass)
            text =
                "The drift that the compensation leaves is within the tolerances. Its gain is not "
                "determined.";
        text += undetermined_sentence(test);
    }
    if (test.finding.fault == CompensationFault::none) text += axes_apart(test);
    if (test.finding.fault == CompensationFault::too_weak ||
        test.finding.fault == CompensationFault::too_strong)
        text += " Its gain is " + number(test.finding.gain, 2) + ".";
    return text;
}

std::string growth_summary(const GrowthAnalysis& test) {
    std::ostringstream out;
    out << test.log->file << "\n  " << clause(*test.log) << "\n  Verdict: " << word(test.verdict) << '\n';
    for (const std::string& reason : test.reasons) out << "    " << reason << '\n';
    out << "  " << compensation_sentence(test) << '\n';
    if (test.identified)
        for (int axis = 0; axis < 3; ++axis)
            out << "  Identified: " << test.identified->sentence(axis) << '\n';
    else if (!test.not_identified.empty())
        out << "  Identified: nothing, as " << test.not_identified << '\n';
    for (const std::string& note : test.notes) out << "  Note: " << note << '\n';
    return out.str();
}

}  // namespace plumb::commissioning
