// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/machine_drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "components/commissioning/squareness/machine_layout.hpp"
#include "components/commissioning/squareness/squareness_advice.hpp"
#include "components/commissioning/squareness/squareness_wording.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = MachinePart::Kind;

constexpr double size = 60;  // of a unit of the layout, in pixels
// Colours that the colour-blind can distinguish, from Okabe and Ito.
constexpr std::array<std::array<int, 3>, 6> colours{
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {86, 180, 233}, {230, 159, 0}, {204, 121, 167}}};

// Oblique: a place further back lies higher and to the right.
Vector2d seen(const Vector3d& place) {
    return size * Vector2d(place[0] + 0.45 * place[1], -place[2] - 0.32 * place[1]);
}

std::string colour_of(const MachinePart& part, double light) {
    std::array<int, 3> colour{196, 200, 204};
    if (part.kind == Kind::axis) colour = colours[static_cast<std::size_t>(*part.axis)];
    if (part.kind == Kind::work) colour = {240, 228, 66};
    if (part.kind == Kind::tool) colour = {90, 90, 96};
    const auto shade = [&](int value) {
        return static_cast<int>(light > 0 ? value + light * (255 - value) : value * (1 + light));
    };
    return formatted("#%02x%02x%02x", shade(colour[0]), shade(colour[1]), shade(colour[2]));
}

// Whether one part is to be drawn before the other, which may hide it.
bool is_behind(const MachinePart& one, const MachinePart& other) {
    constexpr double touching = 1e-9;
    return one.low[1] >= other.high[1] - touching || one.high[2] <= other.low[2] + touching ||
           one.high[0] <= other.low[0] + touching;
}

// From the back to the front. Where a part is on one side behind and on another before, the depth decides.
std::vector<MachinePart> sorted(std::vector<MachinePart> parts) {
    std::vector<MachinePart> result;
    while (!parts.empty()) {
        std::size_t next = parts.size();
        for (std::size_t i = 0; i < parts.size() && next == parts.size(); ++i) {
            bool hidden_by_all = true;
            for (std::size_t k = 0; k < parts.size(); ++k)
                if (k != i && is_behind(parts[k], parts[i]) && !is_behind(parts[i], parts[k]))
                    hidden_by_all = false;
            if (hidden_by_all) next = i;
        }
        if (next == parts.size())
            next = static_cast<std::size_t>(
                std::max_element(parts.begin(), parts.end(),
                                 [](const auto& a, const auto& b) { return a.low[1] < b.low[1]; }) -
                parts.begin());
        result.push_back(parts[next]);
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(next));
    }
    return result;
}

class Paper {
public:
    void polygon(const std::vector<Vector3d>& places, const std::string& fill, double opacity) {
        std::string points;
        for (const Vector3d& place : places) points += text(seen(place)) + ' ';
        out_ += "<polygon points=\"" + points + "\" fill=\"" + fill +
                formatted("\" fill-opacity=\"%.2f\"", opacity) +
                " stroke=\"#333\" stroke-width=\"1.2\" stroke-linejoin=\"round\"/>\n";
    }
    void arrow(const Vector3d& from, const Vector3d& to, const std::string& colour, bool dashed) {
        const Vector2d a = seen(from), b = seen(to);
        const Vector2d way = (b - a).normalized(), across(-way[1], way[0]);
        const Vector2d neck = b - 11 * way;
        out_ += "<path d=\"M " + text(a) + " L " + text(neck) + "\" stroke=\"" + colour +
                "\" stroke-width=\"3.5\" fill=\"none\"" + (dashed ? " stroke-dasharray=\"8 5\"" : "") +
                "/>\n<polygon points=\"" + text(b) + ' ' + text(neck + 6 * across) + ' ' +
                text(neck - 6 * across) + "\" fill=\"" + colour + "\"/>\n";
    }
    void words(const Vector2d& at, const std::string& words, int height, const std::string& colour,
               const char* anchor = "middle") {
        include(at -
                Vector2d(anchor == std::string("end") ? 7.0 * static_cast<double>(words.size()) : 8, height));
        include(at +
                Vector2d(anchor == std::string("start") ? 7.0 * static_cast<double>(words.size()) : 8, 6));
        out_ += "<text x=\"" + formatted("%.1f\" y=\"%.1f", at[0], at[1]) +
                formatted("\" font-size=\"%d\" text-anchor=\"", height) + anchor + "\" fill=\"" + colour +
                "\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">" + words + "</text>\n";
    }

    Vector2d low() const { return low_; }
    Vector2d high() const { return high_; }
    std::string svg(const std::string& title) const {
        const Vector2d from = low_ - Vector2d(14, 14), extent = high_ - low_ + Vector2d(28, 28);
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"" + title +
               formatted("\" viewBox=\"%.1f %.1f %.1f %.1f\" width=\"%.0f\" height=\"%.0f\"", from[0],
                         from[1], extent[0], extent[1], extent[0], extent[1]) +
               formatted(
                   " font-family=\"sans-serif\">\n<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"",
                   from[0], from[1], extent[0], extent[1]) +
               " fill=\"#fff\"/>\n" + out_ + "</svg>\n";
    }

private:
    std::string text(const Vector2d& point) {
        include(point);
        return formatted("%.1f,%.1f", point[0], point[1]);
    }
    void include(const Vector2d& point) {
        low_ = low_.cwiseMin(point);
        high_ = high_.cwiseMax(point);
    }

    std::string out_;
    Vector2d low_ = Vector2d::Constant(std::numeric_limits<double>::max());
    Vector2d high_ = -low_;
};

void draw(const MachinePart& part, Paper& paper) {
    const Vector3d &l = part.low, &h = part.high;
    const double opacity = part.see_through ? 0.3 : 1;
    paper.polygon({{l[0], l[1], h[2]}, {h[0], l[1], h[2]}, {h[0], h[1], h[2]}, {l[0], h[1], h[2]}},
                  colour_of(part, 0.45), opacity);
    paper.polygon({{h[0], l[1], l[2]}, {h[0], h[1], l[2]}, {h[0], h[1], h[2]}, {h[0], l[1], h[2]}},
                  colour_of(part, -0.2), opacity);
    paper.polygon({{l[0], l[1], l[2]}, {h[0], l[1], l[2]}, {h[0], l[1], h[2]}, {l[0], l[1], h[2]}},
                  colour_of(part, 0.15), opacity);
}

}  // namespace

std::string MachineDrawing::svg() const {
    const std::vector<MachinePart> parts = sorted(machine_parts(chain, directions, frame));
    Paper paper;
    for (const MachinePart& part : parts) draw(part, paper);
    const std::string lean_colour = "#c00000";
    std::vector<std::string> sentences;
    for (const MachinePart& part : parts) {
        if (!part.carries_name) continue;
        const Vector3d along = directions.of(direction(*part.axis)), half = (part.high - part.low) / 2;
        Vector3d end = part.low + half + along * along.cwiseAbs().dot(half);
        if (along[1] == 0) end[1] = part.low[1];  // on the face in front
        const std::string colour =
            formatted("#%02x%02x%02x", colours[static_cast<std::size_t>(*part.axis)][0],
                      colours[static_cast<std::size_t>(*part.axis)][1],
                      colours[static_cast<std::size_t>(*part.axis)][2]);
        paper.arrow(end - 0.5 * along, end + 0.7 * along, colour, false);
        paper.words(seen(end + 0.95 * along) + Vector2d(0, 6), '+' + letters(*part.axis), 20, "#111");
        Vector3d leaning = Vector3d::Zero();
        std::string where;
        for (const SquarenessQuantity& q : leans) {
            if (q.axis != *part.axis || q.angle == 0) continue;
            const Lean lean = lean_of(q);
            leaning += lean.sign * directions.of(direction(lean.towards));
            where += (where.empty() ? letters(q.axis) + " leans to " : ", ") + name(lean);
        }
        if (where.empty()) continue;
        const Vector3d tip = end + 0.9 * along + 0.55 * leaning;
        paper.arrow(end - 0.5 * along, tip, lean_colour, true);
        sentences.push_back(where);
    }
    std::string shown = directions.text();
    for (std::size_t at = 0; (at = shown.find_first_of("=,", at)) != std::string::npos; ++at)
        shown.replace(at, 1, shown[at] == '=' ? " " : ", ");
    const Vector2d foot(paper.low()[0], paper.high()[1] + 26);
    paper.words(foot, title, 16, "#111", "start");
    paper.words(foot + Vector2d(0, 20), "+ ends: " + shown, 14, "#444", "start");
    double line = 20;
    for (const std::string& sentence : sentences)
        paper.words(foot + Vector2d(0, line += 20), sentence, 14, lean_colour, "start");
    return paper.svg(title);
}

}  // namespace plumb::commissioning
