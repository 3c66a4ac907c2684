// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/tip_correction.hpp"

#include "components/math/blocks/pi.hpp"
#include "tests/support/chain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace plumb {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double um = 1e-3;    // mm
constexpr double urad = 1e-6;  // rad
constexpr double arcsec = pi / 180 / 3600;

const std::size_t x = 0, y = 1, z = 2, w = 3;  // in a position

Matrix3d about_x(double angle) {
    return AngleAxisd(angle, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d about_y(double angle) {
    return AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d about_z(double angle) {
    return AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

// The machines themselves, each written out for its own construction.
struct Column {
    double ea0y, ec0y;

    Vector3d tip(const AxisPosition& q, const Vector3d& tool) const {
        const Matrix3d r = about_z(ec0y) * about_x(ea0y);
        return Vector3d(q[0], 0, 0) + r * (Vector3d(0, q[1], 0) + tool) + Vector3d(0, 0, q[2]);
    }
};

struct Portal {
    double ea0w, eb0w, ea0z, eb0z;
    TiltReading reading;
    TiltDatum datum;

    Vector3d tip(const AxisPosition& q, const Vector3d& tool) const {
        const Matrix3d rail = about_y(eb0w) * about_x(ea0w);
        const Matrix3d ram = about_y(eb0z) * about_x(ea0z);
        const Matrix3d ram_on_bed = datum == TiltDatum::bed ? ram : Matrix3d(rail * ram);
        const Vector3d saddle(0, q[1], 0);
        const Vector3d along_rail = reading == TiltReading::component ? Vector3d(rail * saddle) : saddle;
        return Vector3d(q[0], 0, 0) + rail * Vector3d(0, 0, q[3]) + along_rail +
               ram_on_bed * (Vector3d(0, 0, q[2]) + tool);
    }
};

Vector3d ideal(const AxisPosition& q, const Vector3d& tool) {
    return Vector3d(q[0], q[1], q[2] + q[3]) + tool;
}

// Over a cube of 1 m with tools of 400 mm that are 50 mm out of centre.
struct Worst {
    double uncorrected = 0, corrected = 0, round_trip = 0;

    template <typename Machine>
    void judge(const TipCorrection& correction, const Machine& machine, double parallel) {
        for (const double px : {-500.0, 0.0, 500.0})
            for (const double py : {-500.0, 0.0, 500.0})
                for (const double pz : {-500.0, 0.0, 500.0})
                    for (const Vector3d& tool : {Vector3d(50, 0, -400), Vector3d(-35, -35, -400)})
                        judge_at(correction, machine, {px, py, pz, parallel * px}, tool);
    }

    template <typename Machine>
    void judge_at(const TipCorrection& correction, const Machine& machine, const AxisPosition& q,
                  const Vector3d& tool) {
        const AxisPosition there = TipCorrection::corrected(q, correction.at(q, tool).offset);
        raise(uncorrected, machine.tip(q, tool) - ideal(q, tool));
        raise(corrected, machine.tip(there, tool) - ideal(q, tool));
        raise(round_trip, (correction.un_corrected(there, tool) - q).head<3>());
    }

    static void raise(double& worst, const Vector3d& error) { worst = std::max(worst, error.norm()); }

    void hold(const char* name) const {
        std::printf("%s: worst error %.1f um, corrected %.2g um, round trip %.2g mm\n", name,
                    uncorrected / um, corrected / um, round_trip);
        EXPECT_GT(uncorrected, 400 * um);
        EXPECT_LT(corrected, 1e-6 * um);
        EXPECT_LT(round_trip, 1e-9);
    }
};

TEST(TipCorrection, EveryTiltOfAColumnLeavesNothing) {
    Worst worst;
    for (const int ea : {-1, 0, 1}) {
        for (const int ec : {-1, 0, 1}) {
            if (ea == 0 && ec == 0) continue;
            const Column machine{ea * 100 * arcsec, ec * 100 * arcsec};
            auto settings = chain("w-Z.b-X-Y-C-t");
            settings.tilts[y].angles = {machine.ea0y, 0, machine.ec0y};
            const KinematicChain model(settings);
            worst.judge(TipCorrection(model), machine, 0);
        }
    }
    worst.hold("column");
}

void every_tilt_of_a_portal_leaves_nothing(TiltReading reading, TiltDatum datum) {
    Worst worst;
    for (int combination = 0; combination < 81; ++combination) {
        const auto angle = [&](int divisor) { return (combination / divisor % 3 - 1) * 100 * arcsec; };
        const Portal machine{angle(27), angle(9), angle(3), angle(1), reading, datum};
        auto settings = chain("w-X.b-W-Y-Z-C-t");
        settings.reading = reading;
        settings.datum = datum;
        settings.tilts[w].angles = {machine.ea0w, machine.eb0w, 0};
        settings.tilts[z].angles = {machine.ea0z, machine.eb0z, 0};
        const KinematicChain model(settings);
        worst.judge(TipCorrection(model), machine, 0.5);
    }
    worst.hold(reading == TiltReading::component ? "portal, component" : "portal, axis direction");
}

TEST(TipCorrection, EveryTiltOfAPortalLeavesNothingInAllReadings) {
    for (const TiltReading reading : {TiltReading::component, TiltReading::axis_direction})
        for (const TiltDatum datum : {TiltDatum::rail, TiltDatum::bed}) {
            SCOPED_TRACE(datum == TiltDatum::rail ? "to the rail" : "to the bed");
            every_tilt_of_a_portal_leaves_nothing(reading, datum);
        }
}

TEST(TipCorrection, FirstOrderIsTheNegativeOfTheError) {
    const double ea = 60 * urad, ec = -80 * urad;
    auto settings = chain("w-Z.b-X-Y-C-t");
    settings.tilts[y].angles = {ea, 0, ec};
    const KinematicChain model(settings);
    const TipCorrection correction(model);
    const AxisPosition q(0, 800, 0, 0);
    const Vector3d tool(0, 25, 250);
    const Vector3d expected = -Vector3d(-ec * 825, -ea * 250, ea * 825);
    EXPECT_LT((correction.at(q, tool).offset - expected).norm(), 0.02 * um);
    EXPECT_LT((correction.at(q, tool).error + expected).norm(), 0.02 * um);
    EXPECT_LT((correction.at(q, tool, {1, -2, 3}).error + expected).norm(), 0.02 * um);
}

TEST(TipCorrection, ParallelAxisStaysClamped) {
    auto settings = chain("w-X.b-W-Y-Z-C-t");
    settings.tilts[w].angles = {80 * arcsec, -60 * arcsec, 0};
    const KinematicChain model(settings);
    const AxisPosition q(10, 20, -30, 400);
    const AxisPosition there = TipCorrection::corrected(q, TipCorrection(model).at(q, {0, 0, -200}).offset);
    EXPECT_EQ(there[3], 400);
}

// A rail of 500 mm that leans by 100 arcsec either way is 0.12 um too low.
TEST(TipCorrection, ParallelAxisTakesWhatItsTiltTakesFromItsTravel) {
    for (const TiltDatum datum : {TiltDatum::rail, TiltDatum::bed})
        for (const TiltReading reading : {TiltReading::component, TiltReading::axis_direction}) {
            const double ea = 100 * arcsec, eb = -100 * arcsec;
            const Portal machine{ea, eb, -60 * arcsec, 80 * arcsec, reading, datum};
            auto settings = chain("w-X.b-W-Y-Z-C-t");
            settings.reading = reading;
            settings.datum = datum;
            settings.tilts[w].angles = {machine.ea0w, machine.eb0w, 0};
            settings.tilts[z].angles = {machine.ea0z, machine.eb0z, 0};
            const TipCorrection correction{KinematicChain(settings)};
            const Vector3d tool(50, 0, -400);
            const AxisPosition q(100, -200, -300, 500);

            const TipCorrection::Share share = correction.share(Axis::W, q);
            EXPECT_NEAR(share.offset, 500 / (std::cos(ea) * std::cos(eb)) - 500, 1e-12);
            EXPECT_GT(share.offset, 0.1 * um);
            EXPECT_NEAR(share.slope, share.offset / 500, 1e-15);
            const auto c = correction.at(q, tool, Vector3d::Zero(), share), clamped = correction.at(q, tool);
            const AxisPosition there = TipCorrection::corrected(q, c.offset, share.offset);
            EXPECT_LT((machine.tip(there, tool) - ideal(q, tool)).norm(), 1e-6 * um);
            EXPECT_LT((c.error - clamped.error).norm(), 1e-6 * um);
            EXPECT_NEAR(clamped.offset.z() - c.offset.z(), share.offset, 1e-3 * share.offset);

            // It is a matter of the rail alone.
            const AxisPosition elsewhere(-100, 300, 50, 500);
            EXPECT_EQ(correction.share(Axis::W, elsewhere).offset, share.offset);
        }
}

TEST(TipCorrection, ReferenceToolIsNotDisplacedAtThePivot) {
    auto settings = chain("w-Z.b-X-Y-C-t");
    settings.tilts[y].angles = {60 * arcsec, 0, -80 * arcsec};
    const KinematicChain model(settings);
    const Vector3d reference(0, 0, -150), longer(0, 0, -250);
    const TipCorrection correction(model, reference);
    EXPECT_LT(correction.at(AxisPosition::Zero(), reference).offset.norm(), 1e-9);
    EXPECT_NEAR(correction.at(AxisPosition::Zero(), longer).offset.y(), std::sin(60 * arcsec) * -100,
                0.05 * um);
    const AxisPosition q(100, 200, -300, 0);
    const AxisPosition there = TipCorrection::corrected(q, correction.at(q, longer).offset);
    EXPECT_LT((correction.un_corrected(there, longer) - q).norm(), 1e-9);
}

// A portal with all tilts, and all errors of a worn machine on each axis, drawn again at each place.
class Worn {
public:
    Worn() : model_(settings()) {}

    const KinematicChain& at(const AxisPosition& q) {
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::W}) {
            const int i = coordinate(axis);
            model_.set_error(axis, error(q[i], 1 + 0.3 * i));
        }
        return model_;
    }

private:
    static KinematicChain::Settings settings() {
        auto s = chain("w-X.b-W-Y-Z-C-t");
        for (AxisTilt& tilt : s.tilts) tilt.angles = Vector3d(100, -100, 100) * arcsec;
        return s;
    }

    // A wave of 20 um and 50 urad over 600 mm.
    static AxisError error(double position, double phase) {
        const double k = 2 * pi / 600, s = std::sin(k * position + phase), c = std::cos(k * position + phase);
        const Vector3d um_each(20 * um, -15 * um, 10 * um), urad_each(50 * urad, 40 * urad, -30 * urad);
        return {position, {s * um_each, c * urad_each}, {k * c * um_each, -k * s * urad_each}};
    }

    KinematicChain model_;
};

const Vector3d long_tool(40, 30, -400);

// With the errors of where the axes are to go, as after the first of many periods.
struct Corrected {
    Corrected(Worn& machine, const AxisPosition& q) {
        c = TipCorrection(machine.at(q)).at(q, long_tool).offset;
        const auto correction = TipCorrection(machine.at(TipCorrection::corrected(q, c))).at(q, long_tool, c);
        c = correction.offset;
        slopes = correction.slopes;
    }

    Vector3d c;
    PositionSlopes slopes;
};

TEST(TipCorrection, TablesLeaveNothingAndRoundTrip) {
    Worn machine;
    Worst worst;
    for (double s = -500; s <= 500; s += 50) {
        const AxisPosition q(s, -0.7 * s, 0.3 * s, 0.5 * s);
        const AxisPosition there = TipCorrection::corrected(q, Corrected(machine, q).c);
        const KinematicChain& model = machine.at(there);
        Worst::raise(worst.uncorrected, TipCorrection(machine.at(q)).at(q, long_tool).error);
        machine.at(there);
        Worst::raise(worst.corrected, model.tip(there, long_tool).place - ideal(q, long_tool));
        Worst::raise(worst.round_trip, (TipCorrection(model).un_corrected(there, long_tool) - q).head<3>());
    }
    worst.hold("tables");
}

TEST(TipCorrection, SlopesAreThoseOfTheCorrection) {
    Worn machine;
    for (const double s : {-400.0, -30.0, 250.0}) {
        const AxisPosition q(s, -0.7 * s, 0.3 * s, 0.5 * s);
        const PositionSlopes slopes = Corrected(machine, q).slopes;
        for (int i = 0; i < 4; ++i) {
            const AxisPosition step = 0.1 * AxisPosition::Unit(i);
            const Vector3d difference =
                (Corrected(machine, q + step).c - Corrected(machine, q - step).c) / 0.2;
            EXPECT_LT((slopes.col(i) - difference).norm(), 1e-8) << i;
        }
    }
}

// With the errors of where the axes are to go, W with its share.
struct CorrectedWithShare {
    CorrectedWithShare(Worn& machine, const AxisPosition& q) : c(Vector3d::Zero()), share{0, 0} {
        for (int step = 0; step < 4; ++step) {
            const TipCorrection correction(machine.at(TipCorrection::corrected(q, c, share.offset)));
            share = correction.share(Axis::W, q, share.offset);
            const auto next = correction.at(q, long_tool, c, share);
            c = next.offset;
            slopes = next.slopes;
        }
    }

    Vector3d c;
    TipCorrection::Share share;
    PositionSlopes slopes;
};

TEST(TipCorrection, ParallelAxisTakesTheErrorsOfItsTravelByTables) {
    Worn machine;
    double most = 0;
    for (double s = -500; s <= 500; s += 50) {
        const AxisPosition q(s, -0.7 * s, 0.3 * s, 0.5 * s);
        const CorrectedWithShare its(machine, q);
        const AxisPosition there = TipCorrection::corrected(q, its.c, its.share.offset);
        const KinematicChain& model = machine.at(there);
        EXPECT_LT((model.tip(there, long_tool).place - ideal(q, long_tool)).norm(), 1e-6 * um) << s;
        EXPECT_NEAR(model.own_travel(Axis::W, there[3]).distance, q[3], 1e-6 * um) << s;
        most = std::max(most, std::abs(its.share.offset));
        for (int i = 0; i < 4; ++i) {
            const AxisPosition step = 0.1 * AxisPosition::Unit(i);
            const CorrectedWithShare after(machine, q + step), before(machine, q - step);
            EXPECT_LT((its.slopes.col(i) - (after.c - before.c) / 0.2).norm(), 1e-8) << i;
            EXPECT_NEAR(i == 3 ? its.share.slope : 0, (after.share.offset - before.share.offset) / 0.2, 1e-8);
        }
    }
    EXPECT_GT(most, 5 * um);
}

// Errors of the axes that differ by direction; d is that of each axis.
struct WornBothWays {
    WornBothWays(const KinematicChain::Settings& settings, const AxisPosition& q, const AxisPosition& d)
        : chain(settings) {
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::W}) {
            const double phase = static_cast<double>(direction(axis)) + 1;
            AxisError error = {q[coordinate(axis)],
                               {Vector3d(0.004, -0.003, 0.002) * phase, Vector3d(3e-5, 2e-5, -4e-5)},
                               {Vector3d(1e-5, 2e-5, -1e-5), Vector3d(1e-7, -2e-7, 1e-7)},
                               {Vector3d(-0.005, 0.002, 0.001) * phase, Vector3d(1e-5, -2e-5, 3e-5)}};
            error.value.translation += d[coordinate(axis)] * error.half.translation;
            error.value.angles += d[coordinate(axis)] * error.half.angles;
            chain.set_error(axis, error);
        }
    }
    KinematicChain chain;
};

TEST(TipCorrection, ChangesWithTheDirectionsOfMotionAsItSays) {
    KinematicChain::Settings settings;
    settings.axes = AxisChainReader::read("w-X.b-W-Y-Z-C-t");
    settings.tilts[3] = {Vector3d(1e-4, -2e-4, 3e-4), true};
    const AxisPosition q(300, -200, 150, 80), d(0.2, -0.4, 1, 0.3);
    const auto corrected = [&](const AxisPosition& directions) {
        Vector3d c = Vector3d::Zero();
        TipCorrection::Share share{};
        PositionSlopes by_direction;
        for (int i = 0; i < 4; ++i) {
            const TipCorrection correction(WornBothWays(settings, q, directions).chain);
            share = correction.share(Axis::W, q, share.offset);
            const auto next = correction.at(q, long_tool, c, share);
            c = next.offset;
            by_direction = next.by_direction;
        }
        return std::tuple(c, share, by_direction);
    };
    const auto [c, share, by_direction] = corrected(d);
    for (int i = 0; i < 4; ++i) {
        const AxisPosition step = 0.1 * AxisPosition::Unit(i);
        const auto [up, share_up, slopes_up] = corrected(d + step);
        const auto [down, share_down, slopes_down] = corrected(d - step);
        EXPECT_LT((by_direction.col(i) - (up - down) / 0.2).norm(), 1e-9) << i;
        EXPECT_GT(by_direction.col(i).norm(), 1e-3);
        EXPECT_NEAR(i == 3 ? share.by_direction : 0, (share_up.offset - share_down.offset) / 0.2, 1e-9);
    }
}

TEST(TipCorrection, VelocityOnACircleIsThatOfTheCorrection) {
    Worn machine;
    const double radius = 200, rate = 0.5;  // mm, rad/s: 100 mm/s
    const auto q = [&](double t) {
        return AxisPosition(radius * std::cos(rate * t), radius * std::sin(rate * t), -100, 50);
    };
    const double dt = 0.001;
    double worst = 0, fastest = 0;
    for (double t = 0; t < 12.6; t += 0.1) {
        const AxisPosition velocity(-radius * rate * std::sin(rate * t), radius * rate * std::cos(rate * t),
                                    0, 0);
        const Vector3d by_slopes = Corrected(machine, q(t)).slopes * velocity;
        const Vector3d by_difference =
            (Corrected(machine, q(t + dt)).c - Corrected(machine, q(t - dt)).c) / (2 * dt);
        worst = std::max(worst, (by_slopes - by_difference).norm());
        fastest = std::max(fastest, by_slopes.norm());
    }
    std::printf("circle: correction moves at up to %.1f um/s, slopes and difference differ by %.2g um/s\n",
                fastest / um, worst / um);
    EXPECT_LT(worst, 0.001 * um);
}

}  // namespace
}  // namespace plumb
