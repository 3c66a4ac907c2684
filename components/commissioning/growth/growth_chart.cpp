// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace plumb::commissioning {
namespace {

constexpr double width = 760, height = 330, left = 62, right = 170, top = 34, bottom = 44;
// Colours that the colour-blind can distinguish, from Okabe and Ito.
constexpr std::array<const char*, 8> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#56b4e9", "#e69f00", "#8a6d00", "#555555"};

std::string number(double value, int digits = 1) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return std::string(text) == "-0" ? "0" : text;
}

// Steps of 1, 2 or 5 that give about `count` of them.
double step_of(double range, int count) {
    const double raw = std::max(range, 1e-9) / count, power = std::pow(10, std::floor(std::log10(raw)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (raw <= factor * power) return factor * power;
    return 10 * power;
}

}  // namespace

std::string escaped_xml(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&')
            result += "&amp;";
        else if (c == '<')
            result += "&lt;";
        else if (c == '>')
            result += "&gt;";
        else if (c == '"')
            result += "&quot;";
        else
            result += c;
    }
    return result;
}

std::string GrowthChart::svg(bool alone) const {
    double last = 0.1, low = 0, high = 0;
    bool any = false;
    for (const Line& line : lines)
        for (const auto& [x, y] : line.points) {
            if (!std::isfinite(y)) continue;
            last = std::max(last, x);
            low = any ? std::min(low, y) : y;
            high = any ? std::max(high, y) : y;
            any = true;
        }
    if (band > 0) low = std::min(low, -1.15 * band), high = std::max(high, 1.15 * band);
    const double every = step_of(std::max(high - low, 1e-6), 6);
    low = std::floor(low / every) * every;
    high = std::max(std::ceil(high / every) * every, low + every);
    const auto x_of = [&](double x) { return left + (width - left - right) * x / last; };
    const auto y_of = [&](double y) {
        return height - bottom - (height - top - bottom) * (y - low) / (high - low);
    };
    const int digits = every < 1 ? every < 0.1 ? 2 : 1 : 0;

    std::ostringstream out;
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height
        << "\" role=\"img\" aria-label=\"" << escaped_xml(title) << "\" class=\"chart\"";
    if (alone) {
        out << " width=\"" << 2 * width << "\" height=\"" << 2 * height
            << "\" font-family=\"sans-serif\"><style>"
            << ".g{stroke:#ddd}.a{stroke:#555}.t{fill:#222}.b{fill:#009e73;fill-opacity:.13}";
        for (std::size_t i = 0; i < colours.size(); ++i)
            out << ".l" << i << "{stroke:" << colours[i] << ";fill:" << colours[i] << "}";
        out << "</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>";
    } else {
        out << ">";
    }
    out << "<text class=\"t\" x=\"" << left << "\" y=\"18\" font-size=\"14\" font-weight=\"bold\">"
        << escaped_xml(title) << "</text>\n";
    if (band > 0)
        out << "<rect class=\"b\" x=\"" << left << "\" y=\"" << number(y_of(band)) << "\" width=\""
            << width - left - right << "\" height=\"" << number(y_of(-band) - y_of(band))
            << "\"><title>tolerance \u00b1" << number(band) << ' ' << unit << "</title></rect>\n";
    for (double y = low; y <= high + every / 2; y += every)
        out << "<line class=\"g\" x1=\"" << left << "\" x2=\"" << width - right << "\" y1=\""
            << number(y_of(y)) << "\" y2=\"" << number(y_of(y)) << "\"/><text class=\"t\" x=\"" << left - 6
            << "\" y=\"" << number(y_of(y) + 4) << "\" font-size=\"11\" text-anchor=\"end\">"
            << number(y, digits) << "</text>\n";
    const double hours = step_of(last, 8);
    for (double x = 0; x <= last + 1e-9; x += hours)
        out << "<line class=\"g\" x1=\"" << number(x_of(x)) << "\" x2=\"" << number(x_of(x)) << "\" y1=\""
            << top << "\" y2=\"" << height - bottom << "\"/><text class=\"t\" x=\"" << number(x_of(x))
            << "\" y=\"" << height - bottom + 16 << "\" font-size=\"11\" text-anchor=\"middle\">"
            << number(x, hours < 0.1 ? 2
                         : hours < 1 ? 1
                                     : 0)
            << "</text>\n";
    out << "<line class=\"a\" x1=\"" << left << "\" x2=\"" << width - right << "\" y1=\""
        << number(y_of(std::max(low, 0.0))) << "\" y2=\"" << number(y_of(std::max(low, 0.0)))
        << "\"/><text class=\"t\" x=\"" << (left + width - right) / 2 << "\" y=\"" << height - 8
        << "\" font-size=\"11\" text-anchor=\"middle\">time in h</text><text class=\"t\" x=\"14\" y=\""
        << height / 2 << "\" font-size=\"11\" text-anchor=\"middle\" transform=\"rotate(-90 14 " << height / 2
        << ")\">" << escaped_xml(unit) << "</text>\n";
    double legend = top + 8;
    for (const Line& line : lines) {
        const int colour = line.colour % static_cast<int>(colours.size());
        std::string path;
        bool pen = false;
        for (const auto& [x, y] : line.points) {
            if (!std::isfinite(y)) {
                pen = false;
                continue;
            }
            path += (pen ? " L" : " M") + number(x_of(x)) + ' ' + number(y_of(y));
            pen = true;
        }
        const std::string dash = line.dashed ? " stroke-dasharray=\"6 4\"" : "";
        if (!path.empty())
            out << "<path class=\"l" << colour << "\" d=\"" << path.substr(1)
                << "\" style=\"fill:none\" stroke-width=\"1.8\"" << dash << "><title>"
                << escaped_xml(line.name) << "</title></path>\n";
        if (line.points.size() <= 60)
            for (const auto& [x, y] : line.points)
                if (std::isfinite(y))
                    out << "<circle class=\"l" << colour << "\" cx=\"" << number(x_of(x)) << "\" cy=\""
                        << number(y_of(y)) << "\" r=\"2.4\"/>";
        out << "<line class=\"l" << colour << "\" x1=\"" << width - right + 12 << "\" x2=\""
            << width - right + 34 << "\" y1=\"" << legend << "\" y2=\"" << legend << "\" stroke-width=\"2\""
            << dash << "/><text class=\"t\" x=\"" << width - right + 40 << "\" y=\"" << legend + 4
            << "\" font-size=\"11\">" << escaped_xml(line.name) << "</text>\n";
        legend += 17;
    }
    out << "</svg>\n";
    return out.str();
}

}  // namespace plumb::commissioning
