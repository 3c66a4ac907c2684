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

// The frame of a chart, and the scales of its axes.
class Drawing {
public:
    explicit Drawing(const GrowthChart& chart) : chart_(chart) {
        bool any = false;
        for (const GrowthChart::Line& line : chart.lines)
            for (const auto& [x, y] : line.points) {
                if (!std::isfinite(y)) continue;
                last_ = std::max(last_, x);
                low_ = any ? std::min(low_, y) : y;
                high_ = any ? std::max(high_, y) : y;
                any = true;
            }
        if (chart.band > 0)
            low_ = std::min(low_, -1.15 * chart.band), high_ = std::max(high_, 1.15 * chart.band);
        every_ = step_of(std::max(high_ - low_, 1e-6), 6);
        low_ = std::floor(low_ / every_) * every_;
        high_ = std::max(std::ceil(high_ / every_) * every_, low_ + every_);
    }

    std::string svg(bool alone) {
        open(alone);
        draw_band();
        draw_grid();
        draw_axes();
        double legend = top + 8;
        for (const GrowthChart::Line& line : chart_.lines) {
            draw(line);
            name(line, legend);
            legend += 17;
        }
        out_ << "</svg>\n";
        return out_.str();
    }

private:
    double x_of(double x) const { return left + (width - left - right) * x / last_; }
    double y_of(double y) const {
        return height - bottom - (height - top - bottom) * (y - low_) / (high_ - low_);
    }
    static std::size_t colour_of(const GrowthChart::Line& line) {
        return static_cast<std::size_t>(line.colour % static_cast<int>(colours.size()));
    }
    static const char* dash_of(const GrowthChart::Line& line) {
        return line.dashed ? " stroke-dasharray=\"6 4\"" : "";
    }

    void open(bool alone) {
        out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height
             << "\" role=\"img\" aria-label=\"" << escaped_xml(chart_.title) << "\" class=\"chart\"";
        if (alone) {
            out_ << " width=\"" << 2 * width << "\" height=\"" << 2 * height
                 << "\" font-family=\"sans-serif\"><style>"
                 << ".g{stroke:#ddd}.a{stroke:#555}.t{fill:#222}.b{fill:#009e73;fill-opacity:.13}";
            for (std::size_t i = 0; i < colours.size(); ++i)
                out_ << ".l" << i << "{stroke:" << colours[i] << ";fill:" << colours[i] << "}";
            out_ << "</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>";
        } else {
            out_ << ">";
        }
        out_ << "<text class=\"t\" x=\"" << left << "\" y=\"18\" font-size=\"14\" font-weight=\"bold\">"
             << escaped_xml(chart_.title) << "</text>\n";
    }

    void draw_band() {
        if (chart_.band > 0)
            out_ << "<rect class=\"b\" x=\"" << left << "\" y=\"" << number(y_of(chart_.band))
                 << "\" width=\"" << width - left - right << "\" height=\""
                 << number(y_of(-chart_.band) - y_of(chart_.band)) << "\"><title>tolerance \u00b1"
                 << number(chart_.band) << ' ' << chart_.unit << "</title></rect>\n";
    }

    void draw_grid() {
        const int digits = every_ < 1 ? every_ < 0.1 ? 2 : 1 : 0;
        for (double y = low_; y <= high_ + every_ / 2; y += every_)
            out_ << "<line class=\"g\" x1=\"" << left << "\" x2=\"" << width - right << "\" y1=\""
                 << number(y_of(y)) << "\" y2=\"" << number(y_of(y)) << "\"/><text class=\"t\" x=\""
                 << left - 6 << "\" y=\"" << number(y_of(y) + 4) << "\" font-size=\"11\" text-anchor=\"end\">"
                 << number(y, digits) << "</text>\n";
        const double hours = step_of(last_, 8);
        for (double x = 0; x <= last_ + 1e-9; x += hours)
            out_ << "<line class=\"g\" x1=\"" << number(x_of(x)) << "\" x2=\"" << number(x_of(x))
                 << "\" y1=\"" << top << "\" y2=\"" << height - bottom << "\"/><text class=\"t\" x=\""
                 << number(x_of(x)) << "\" y=\"" << height - bottom + 16
                 << "\" font-size=\"11\" text-anchor=\"middle\">"
                 << number(x, hours < 0.1 ? 2
                              : hours < 1 ? 1
                                          : 0)
                 << "</text>\n";
    }

    void draw_axes() {
        out_ << "<line class=\"a\" x1=\"" << left << "\" x2=\"" << width - right << "\" y1=\""
             << number(y_of(std::max(low_, 0.0))) << "\" y2=\"" << number(y_of(std::max(low_, 0.0)))
             << "\"/><text class=\"t\" x=\"" << (left + width - right) / 2 << "\" y=\"" << height - 8
             << "\" font-size=\"11\" text-anchor=\"middle\">time in h</text><text class=\"t\" x=\"14\" y=\""
             << height / 2 << "\" font-size=\"11\" text-anchor=\"middle\" transform=\"rotate(-90 14 "
             << height / 2 << ")\">" << escaped_xml(chart_.unit) << "</text>\n";
    }

    // A gap where y is not a number, and circles where there are few points.
    void draw(const GrowthChart::Line& line) {
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
        if (!path.empty())
            out_ << "<path class=\"l" << colour_of(line) << "\" d=\"" << path.substr(1)
                 << "\" style=\"fill:none\" stroke-width=\"1.8\"" << dash_of(line) << "><title>"
                 << escaped_xml(line.name) << "</title></path>\n";
        if (line.points.size() <= 60)
            for (const auto& [x, y] : line.points)
                if (std::isfinite(y))
                    out_ << "<circle class=\"l" << colour_of(line) << "\" cx=\"" << number(x_of(x))
                         << "\" cy=\"" << number(y_of(y)) << "\" r=\"2.4\"/>";
    }

    void name(const GrowthChart::Line& line, double legend) {
        out_ << "<line class=\"l" << colour_of(line) << "\" x1=\"" << width - right + 12 << "\" x2=\""
             << width - right + 34 << "\" y1=\"" << legend << "\" y2=\"" << legend << "\" stroke-width=\"2\""
             << dash_of(line) << "/><text class=\"t\" x=\"" << width - right + 40 << "\" y=\"" << legend + 4
             << "\" font-size=\"11\">" << escaped_xml(line.name) << "</text>\n";
    }

    const GrowthChart& chart_;
    double last_ = 0.1, low_ = 0, high_ = 0, every_ = 1;
    std::ostringstream out_;
};

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
    return Drawing(*this).svg(alone);
}

}  // namespace plumb::commissioning
