// SPDX-License-Identifier: GPL-2.0-or-later
// Measurements of a machine with known axes, by a model of its own, give these axes.
#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/math/geometry/corner.hpp"
#include "components/math/geometry/probed_shape.hpp"
#include "components/math/geometry/square_readings.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plumb {
namespace {

constexpr double um = 1e-3;    // mm
constexpr double urad = 1e-6;  // rad

// Two straight guides in a plane: where they take the tool that is sent to (x, y).
struct Guides {
    double opening = 0;  // rad, by which the angle between their + ends exceeds 90 deg
    double x_scale = 1;
    double turn = 0;  // rad, of both

    struct Place {
        double x, y;
    };
    Place drawn(double x, double y) const {
        const double along = turn, across = turn + pi / 2 + opening;
        return {x * x_scale * std::cos(along) + y * std::cos(across),
                x * x_scale * std::sin(along) + y * std::sin(across)};
    }
    // The readings of the scales with the tool at a place.
    Place read(const Place& p) const {
        const double along = turn, across = turn + pi / 2 + opening;
        const double determinant = std::sin(across - along);
        return {(p.x * std::sin(across) - p.y * std::cos(across)) / determinant / x_scale,
                (p.y * std::cos(along) - p.x * std::sin(along)) / determinant};
    }
};

double between(const Guides::Place& a, const Guides::Place& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

TEST(Diagonals, OfAPartGiveTheCornerOfItsAxes) {
    for (const double opening : {-80 * urad, 3000 * urad}) {
        const Guides guides{opening, 1, 0.3};
        for (const double b : {400.0, 250.0}) {
            Diagonals d;
            d.rising = between(guides.drawn(0, 0), guides.drawn(400, b));
            d.falling = between(guides.drawn(400, 0), guides.drawn(0, b));
            d.uncertainty = 1 * um;
            if (b != 400) d.a = 400, d.b = b;
            const Corner corner = corner_from_diagonals(Axis::X, Axis::Y, d, MeasuredObject::part);
            EXPECT_NEAR(corner.opening, opening, 1e-12);
            EXPECT_EQ(corner.opening<0, d.rising> d.falling) << "a closed corner has the longer diagonal";
        }
    }
}

TEST(Diagonals, OfAnArtifactReadTheOtherWayRound) {
    const Guides guides{-80 * urad};
    const double own = 25 * urad;  // the artifact's corner at (0, 0) is wider by it
    const Guides artifact{own};
    const auto read = [&](double x, double y) {
        const Guides::Place p = artifact.drawn(x, y);
        return guides.read({p.x, p.y});
    };
    Diagonals d;
    d.rising = between(read(0, 0), read(300, 300));
    d.falling = between(read(300, 0), read(0, 300));
    d.uncertainty = 1 * um;
    d.own_opening = own;
    d.own_uncertainty = 5 * urad;
    const Corner corner = corner_from_diagonals(Axis::X, Axis::Y, d, MeasuredObject::artifact);
    EXPECT_NEAR(corner.opening, -80 * urad, 0.02 * urad);
    EXPECT_NEAR(corner.uncertainty, std::hypot(5 * urad, 1 * um / 300), 0.01 * urad);
}

TEST(Diagonals, RefuseWhatTheyCannotBe) {
    const auto corner = [](const Diagonals& d) {
        return refusal([&] { corner_from_diagonals(Axis::X, Axis::Y, d, MeasuredObject::part); });
    };
    EXPECT_EQ(corner({0, 1, 0, 0, 1}), "a diagonal is not longer than 0");
    EXPECT_EQ(corner({500, 500, 400, 0, 1}), "a side is not longer than 0");
    EXPECT_EQ(corner({500, 500, 400, 300, 0}), "the uncertainty of the diagonals is not more than 0");
    EXPECT_EQ(corner({510, 510, 400, 300, 1}),
              "diagonals of 510.000000 and 510.000000 mm are not those of sides of 400.000000 and 300.000000 "
              "mm, which are about 500.000000 mm");
    EXPECT_EQ(corner({500, 300, 0, 0, 1}),
              "diagonals of 500.000000 and 300.000000 mm are not those of a rectangle: it would be out of "
              "square by -0.470588 rad");
}

// An indicator on axis Y that leans towards +X by `lean`, on a blade that leans there by `blade`.
SquareReadings readings_of(double lean, double blade, const std::vector<double>& positions, int plunger) {
    SquareReadings square;
    square.plunger.sign = plunger;
    square.positions = positions;
    square.uncertainty = 1 * um;
    for (const double y : positions) {
        square.readings.push_back(0.4 + plunger * y * (std::tan(lean) - std::tan(blade)));
        square.turned.push_back(-0.1 - plunger * y * (std::tan(lean) + std::tan(blade)));
    }
    return square;
}

TEST(SquareReadings, ReadMoreWhereTheAxisLeansTheWayThePlungerPoints) {
    for (const int plunger : {1, -1}) {
        SquareReadings square = readings_of(80 * urad, 0, {0, 300}, plunger);
        square.turned.clear();
        EXPECT_EQ(square.readings[1] > square.readings[0], plunger > 0);
        const Corner corner = corner_from_square(square);
        EXPECT_TRUE(corner.is_of(Axis::X, Axis::Y));
        EXPECT_NEAR(corner.opening, -80 * urad, 1e-9 * urad) << "it closes the corner";
        EXPECT_NEAR(corner.uncertainty, std::sqrt(2) * um / 300, 1e-3 * urad);
        square.square_uncertainty = 10 * urad;
        EXPECT_NEAR(corner_from_square(square).uncertainty, std::hypot(10 * urad, std::sqrt(2) * um / 300),
                    0.01 * urad);
    }
}

TEST(SquareReadings, TurningCancelsTheErrorOfTheSquare) {
    for (const int plunger : {1, -1}) {
        const SquareReadings square = readings_of(-80 * urad, 150 * urad, {100, 300, 420}, plunger);
        EXPECT_NEAR(corner_from_square(square).opening, 80 * urad, 0.1 * urad);
        SquareReadings once = square;
        once.turned.clear();
        EXPECT_NEAR(corner_from_square(once).opening, 230 * urad, 0.1 * urad);
    }
}

TEST(SquareReadings, ScatterWidensTheUncertainty) {
    SquareReadings square = readings_of(0, 0, {0, 100, 200, 300}, 1);
    square.turned.clear();
    const double stated = corner_from_square(square).uncertainty;
    for (const std::size_t i : {0, 3}) square.readings[i] += 20 * um;
    const Corner corner = corner_from_square(square);
    EXPECT_NEAR(corner.scatter, 20 / std::sqrt(2.0), 0.01);
    EXPECT_NEAR(corner.uncertainty / stated, corner.scatter, 0.01);
}

TEST(SquareReadings, RefuseWhatTheyCannotBe) {
    const auto refused = [](auto change) {
        SquareReadings square = readings_of(0, 0, {0, 300}, 1);
        change(square);
        return refusal([&] { corner_from_square(square); });
    };
    EXPECT_EQ(refused([](SquareReadings& s) { s.plunger.towards = Axis::Y; }),
              "the plunger points along Y, the axis that moves");
    EXPECT_EQ(refused([](SquareReadings& s) { s.positions = {1}; }),
              "one position is not enough: at least two show how an axis leans");
    EXPECT_EQ(refused([](SquareReadings& s) { s.readings = {1, 2, 3}; }), "3 readings at 2 positions");
    EXPECT_EQ(refused([](SquareReadings& s) { s.turned = {1}; }),
              "1 readings of the turned square at 2 positions");
    EXPECT_EQ(refused([](SquareReadings& s) { s.positions = {5, 5}; }), "the positions are all the same");
    EXPECT_EQ(refused([](SquareReadings& s) { s.uncertainty = 0; }),
              "the uncertainty of a reading is not more than 0");
}

// Points on the faces of an artifact, read by guides. The artifact lies turned by `pose`; its faces look at
// `normals` and are off by `own`; before the second set of points it was turned by `turn`.
struct Artifact {
    std::vector<double> normals, own;  // rad
    double radius = 150;               // mm
    double pose = 0;
    std::vector<double> along = {-100, -20, 60, 100};  // each face, mm

    void probe(const Guides& guides, double turn, std::vector<ProbedShape::Point>& points) const {
        for (std::size_t face = 0; face < normals.size(); ++face) {
            const double normal = normals[face] + own[face] + pose + turn;
            for (const double at : along) {
                const Guides::Place place{700 + radius * std::cos(normal) - at * std::sin(normal),
                                          -300 + radius * std::sin(normal) + at * std::cos(normal)};
                const Guides::Place read = guides.read(place);
                points.push_back({{read.x, read.y}, normals[face] + turn, turn});
            }
        }
    }
};

const std::vector<double> square_normals = {0, pi / 2, pi, -pi / 2};

ProbedShape shape_of(const Artifact& artifact, const Guides& guides, const std::vector<double>& turns) {
    ProbedShape shape;
    shape.uncertainty = 1 * um;
    for (const double turn : turns) artifact.probe(guides, turn, shape.points);
    return shape;
}

TEST(ProbedShape, SquareGivesTheCornerOfTheAxesThatProbedIt) {
    for (const double pose : {0.0, 0.03}) {
        const Guides guides{-80 * urad};
        const Artifact square{square_normals, {0, 0, 0, 0}, 150, pose};
        const ProbedCorner found = corner_from_shape(shape_of(square, guides, {0}));
        EXPECT_NEAR(found.corner.opening, -80 * urad, 0.01 * urad);
        EXPECT_LT(std::abs(found.distance), 1e-6 * um);
    }
}

TEST(ProbedShape, TurnedSquareSeparatesItsOwnErrorFromThatOfTheAxes) {
    const Guides guides{-80 * urad};
    const Artifact square{square_normals, {30 * urad, -20 * urad, -15 * urad, 60 * urad}, 150, 0.002};
    EXPECT_GT(std::abs(corner_from_shape(shape_of(square, guides, {0})).corner.opening + 80 * urad),
              5 * urad);
    EXPECT_NEAR(corner_from_shape(shape_of(square, guides, {0, pi / 2})).corner.opening, -80 * urad,
                0.1 * urad);
}

TEST(ProbedShape, PolygonSeparatesScalesFromTheCorner) {
    const Guides guides{60 * urad, 1 + 40e-6};
    const double step = pi / 4;
    const Artifact octagon{{step, 2 * step, 3 * step, 4 * step, 5 * step}, {0, 0, 0, 0, 0}, 150, 0.01};
    EXPECT_NEAR(corner_from_shape(shape_of(octagon, guides, {0})).corner.opening, 60 * urad, 0.1 * urad);
}

TEST(ProbedShape, SquareThatLiesAskewReportsThatTheScalesHideTheCorner) {
    const auto uncertainty = [](double askew) {
        const Artifact square{{askew, askew + pi / 2, askew + pi}, {0, 0, 0}, 150, 0};
        return corner_from_shape(shape_of(square, {}, {0})).corner.uncertainty;
    };
    EXPECT_LT(uncertainty(0), 10 * urad);
    EXPECT_GT(uncertainty(pi / 9), 50 * urad);
    EXPECT_THROW(uncertainty(pi / 4), std::invalid_argument) << "there it shows the scales only";
}

ProbedShape ring_of(const Guides& guides, double ovality, double ovality_at, const std::vector<double>& turns,
                    int count = 12) {
    ProbedShape shape;
    shape.ring = true;
    shape.uncertainty = 1 * um;
    for (const double turn : turns) {
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * pi * i / count;
            const double radius = 100 + ovality * std::cos(2 * (angle - ovality_at - turn));
            const Guides::Place read =
                guides.read({-250 + radius * std::cos(angle), 40 + radius * std::sin(angle)});
            shape.points.push_back({{read.x, read.y}, 0, turn});
        }
    }
    return shape;
}

TEST(ProbedShape, RingGivesTheCornerForAnyScales) {
    EXPECT_NEAR(corner_from_shape(ring_of({-80 * urad, 1 - 30e-6}, 0, 0, {0})).corner.opening, -80 * urad,
                0.1 * urad);
    EXPECT_NEAR(corner_from_shape(ring_of({120 * urad}, 0, 0, {0}, 5)).corner.opening, 120 * urad,
                0.1 * urad);
}

TEST(ProbedShape, TurnedRingSeparatesItsOvalityFromTheCorner) {
    const Guides guides{-80 * urad};
    EXPECT_NEAR(corner_from_shape(ring_of(guides, 3 * um, 0.6, {0})).corner.opening, -80 * urad + 56 * urad,
                1 * urad);
    EXPECT_NEAR(corner_from_shape(ring_of(guides, 3 * um, 0.6, {0, pi / 2})).corner.opening, -80 * urad,
                0.2 * urad);
}

TEST(ProbedShape, OwnUncertaintyOfAnArtifactWidensThatOfTheCorner) {
    ProbedShape ring = ring_of({}, 0, 0, {0});
    const double without = corner_from_shape(ring).corner.uncertainty;
    ring.own_uncertainty = 2 * um;
    EXPECT_NEAR(corner_from_shape(ring).corner.uncertainty, std::hypot(without, 2 * 2 * um / 100),
                0.05 * urad);
}

TEST(ProbedShape, PartIsTheMirrorImageOfWhatAnArtifactReads) {
    const Guides guides{-80 * urad, 1, 0.02};  // as the part lies where it is measured
    ProbedShape part;
    part.object = MeasuredObject::part;
    part.uncertainty = 1 * um;
    for (const double t : {-90.0, 0.0, 90.0}) {
        const struct {
            double x, y, normal;
        } points[] = {{150, t, 0}, {-150, t, pi}, {t, 120, pi / 2}, {t, -120, -pi / 2}};
        for (const auto& p : points) {
            const Guides::Place place = guides.drawn(p.x, p.y);
            part.points.push_back({{place.x + 30, place.y - 20}, p.normal, 0});
        }
    }
    EXPECT_NEAR(corner_from_shape(part).corner.opening, -80 * urad, 0.01 * urad);

    ProbedShape circle;
    circle.ring = true;
    circle.object = MeasuredObject::part;
    circle.uncertainty = 1 * um;
    for (int i = 0; i < 9; ++i) {
        const Guides::Place place =
            Guides{-80 * urad}.drawn(90 * std::cos(2 * pi * i / 9), 90 * std::sin(2 * pi * i / 9));
        circle.points.push_back({{place.x, place.y}, 0, 0});
    }
    EXPECT_NEAR(corner_from_shape(circle).corner.opening, -80 * urad, 0.01 * urad);
}

TEST(ProbedShape, RefusesWhatLeavesTheCornerOpenOrDoesNotFit) {
    const auto refused = [](const ProbedShape& shape) { return refusal([&] { corner_from_shape(shape); }); };
    const std::string too_few =
        "the points leave the corner open: it takes two points on each of two faces that are neither "
        "parallel "
        "nor at 45 deg to the axes, or five around a ring";
    EXPECT_EQ(refused(shape_of({{0, pi}, {0, 0}}, {}, {0})), too_few);
    EXPECT_EQ(refused(ring_of({}, 0, 0, {0}, 4)), too_few);
    EXPECT_EQ(refused(ring_of({}, 0, 0, {0}, 2)), too_few);
    ProbedShape none;
    none.uncertainty = 1;
    EXPECT_EQ(refused(none), too_few);
    ProbedShape wrong = shape_of({square_normals, {0, 0, 0, 0}}, {}, {0});
    wrong.points[9].normal = pi / 2;
    try {
        corner_from_shape(wrong);
        ADD_FAILURE() << "accepted";
    } catch (const ProbedMisfit& misfit) {
        EXPECT_GT(misfit.fitted.corner.scatter, 20);
    }
}

// The error is as often within its stated uncertainty, and within twice that, as of a normal distribution; up
// to 2.5 standard deviations of the count. `widened`: added, in 100, for scatter that happens to be large.
template <class Measure>
void expect_stated(Measure measure, double widened = 0, int trials = 600) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise;
    int once = 0, twice = 0;
    for (int i = 0; i < trials; ++i) {
        const double opening = 100 * urad * noise(random);
        const Corner corner = measure(opening, [&] { return noise(random); });
        const double error = std::abs(corner.opening - opening);
        once += error <= corner.uncertainty;
        twice += error <= 2 * corner.uncertainty;
    }
    const auto expect = [&](int count, double in_100, double more) {
        const double deviation = 2.5 * std::sqrt(in_100 * (100 - in_100) / trials);
        EXPECT_GT(100.0 * count / trials, in_100 - deviation);
        EXPECT_LT(100.0 * count / trials, in_100 + deviation + more);
    };
    expect(once, 68.3, 3 * widened);
    expect(twice, 95.4, widened);
}

TEST(StatedUncertainty, CoversTheErrorOfDiagonals) {
    expect_stated([](double opening, auto noise) {
        const Guides guides{opening};
        Diagonals d;
        d.uncertainty = 2 * um;
        d.rising = between(guides.drawn(0, 0), guides.drawn(400, 300)) + 2 * um * noise();
        d.falling = between(guides.drawn(400, 0), guides.drawn(0, 300)) + 2 * um * noise();
        d.a = 400;
        d.b = 300;
        return corner_from_diagonals(Axis::X, Axis::Y, d, MeasuredObject::part);
    });
}

TEST(StatedUncertainty, CoversTheErrorOfSquareAndIndicator) {
    const auto measure = [](double lean, auto noise, bool turned, double blade) {
        SquareReadings square = readings_of(lean, blade, {0, 150, 300}, 1);
        for (double& reading : square.readings) reading += 1 * um * noise();
        for (double& reading : square.turned) reading += 1 * um * noise();
        if (!turned) {
            square.turned.clear();
            square.square_uncertainty = 10 * urad;
        }
        Corner corner = corner_from_square(square);
        corner.opening = -corner.opening;
        return corner;
    };
    expect_stated([&](double lean, auto noise) { return measure(lean, noise, true, 150 * urad); }, 3);
    expect_stated([&](double lean, auto noise) { return measure(lean, noise, false, 10 * urad * noise()); },
                  3);
}

TEST(StatedUncertainty, CoversTheErrorOfProbedPoints) {
    const auto with_noise = [](ProbedShape shape, auto noise) {
        for (ProbedShape::Point& point : shape.points) {
            point.place.x() += 1 * um * noise();
            point.place.y() += 1 * um * noise();
        }
        return corner_from_shape(shape).corner;
    };
    expect_stated(
        [&](double opening, auto noise) {
            return with_noise(ring_of({opening, 1 + 20e-6 * noise()}, 0, 0, {0}, 8), noise);
        },
        3, 300);
    const auto square_of = [](double opening, auto noise, const std::vector<double>& turns) {
        Artifact square{square_normals, {}, 150, 0.001 * noise(), {-100, 100}};
        for (int face = 0; face < 4; ++face) square.own.push_back(10 * urad * noise());
        return shape_of(square, {opening}, turns);
    };
    expect_stated(
        [&](double opening, auto noise) {
            ProbedShape shape = square_of(opening, noise, {0});
            shape.own_uncertainty = 10 * urad;
            return with_noise(shape, noise);
        },
        3, 300);
    expect_stated(
        [&](double opening, auto noise) {
            return with_noise(square_of(opening, noise, {0, pi / 2}), noise);
        },
        3, 300);
}

// The corner of two axes in a chain is that of the directions in which they move the tip over the work.
// By a formula of its own.
double corner_of(const KinematicChain& machine, Axis a, Axis b) {
    const PositionSlopes slopes = machine.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    const Eigen::Vector3d u = slopes.col(coordinate(a)), v = slopes.col(coordinate(b));
    return std::acos(u.dot(v) / u.norm() / v.norm()) - pi / 2;
}

KinematicChain machine_of(const AxisChain& chain, TiltReading reading, TiltDatum datum,
                          const std::vector<SquarenessQuantity>& quantities) {
    KinematicChain::Settings settings;
    settings.axes = chain;
    settings.reading = reading;
    settings.datum = datum;
    for (const SquarenessQuantity& q : quantities)
        settings.tilts[static_cast<std::size_t>(coordinate(q.axis))].angles[q.rotation] = q.angle;
    return KinematicChain(settings);
}

TEST(SquarenessOfChain, MachineOfItsQuantitiesHasTheCornersThatWereMeasured) {
    const std::vector<Axis> orders[] = {{Axis::X, Axis::Y, Axis::Z, Axis::W},
                                        {Axis::W, Axis::Y, Axis::X, Axis::Z},
                                        {Axis::Z, Axis::X, Axis::W, Axis::Y}};
    const std::vector<Corner> corners = {{Axis::X, Axis::Y, 80 * urad, 1 * urad, 0},
                                         {Axis::Z, Axis::Y, -50 * urad, 2 * urad, 0},
                                         {Axis::X, Axis::Z, 30 * urad, 3 * urad, 0},
                                         {Axis::W, Axis::Y, 70 * urad, 4 * urad, 0},
                                         {Axis::X, Axis::W, -20 * urad, 5 * urad, 0}};
    for (const char* text : {"w-X.b-W-Y-Z-C-t", "w-X-Y.b-W-Z-C-t", "w-W-X.b-Z-Y-t", "b-X-Y-Z-W-t"})
        for (const TiltReading reading : {TiltReading::component, TiltReading::axis_direction})
            for (const TiltDatum datum : {TiltDatum::rail, TiltDatum::bed})
                for (const auto& order : orders) {
                    const AxisChain chain = AxisChainReader::read(text);
                    if (std::string(text) == "w-W-X.b-Z-Y-t" && datum == TiltDatum::bed) continue;
                    const auto quantities =
                        SquarenessOfChain(chain, reading, datum, order).quantities(corners, {});
                    const KinematicChain machine = machine_of(chain, reading, datum, quantities);
                    for (const Corner& corner : corners)
                        EXPECT_NEAR(corner_of(machine, corner.a, corner.b), corner.opening, 0.03 * urad)
                            << text << ' ' << name(corner);
                }
}

TEST(SquarenessOfChain, FirstAxisIsTheDatum) {
    const Corner xy{Axis::X, Axis::Y, -80 * urad, 2 * urad, 0};
    const auto quantities = [&](std::vector<Axis> order, const char* chain) {
        return SquarenessOfChain(AxisChainReader::read(chain), TiltReading::component, TiltDatum::rail,
                                 std::move(order))
            .quantities({xy}, {});
    };
    const auto of_y = quantities({Axis::X, Axis::Y, Axis::Z}, "w-X-Y.b-Z-C-t");
    ASSERT_EQ(of_y.size(), 2u) << "X rides on Y, whose tilt it must take back";
    EXPECT_TRUE(of_y[0].is_of(Axis::X, 2));
    EXPECT_NEAR(of_y[0].angle, 80 * urad, 1e-12);
    EXPECT_TRUE(of_y[1].is_of(Axis::Y, 2));
    EXPECT_NEAR(of_y[1].angle, -80 * urad, 1e-12);

    const auto column = quantities({Axis::X, Axis::Y, Axis::Z}, "w-Z.b-X-Y-C-t");
    ASSERT_EQ(column.size(), 1u);
    EXPECT_TRUE(column[0].is_of(Axis::Y, 2));
    EXPECT_NEAR(column[0].angle, -80 * urad, 1e-12) << "the + ends are closer: Y leans to +X, EC0Y is -";
    EXPECT_NEAR(column[0].uncertainty.value(), 2 * urad, 1e-12);

    const auto of_x = quantities({Axis::Y, Axis::X, Axis::Z}, "w-X.b-Y-Z-C-t");
    ASSERT_EQ(of_x.size(), 1u);
    EXPECT_TRUE(of_x[0].is_of(Axis::X, 2));
    EXPECT_NEAR(of_x[0].angle, 80 * urad, 1e-12);
}

TEST(SquarenessOfChain, TiltThatIsKnownOfTheRailIsTakenOff) {
    const Corner yz{Axis::Y, Axis::Z, -50 * urad, 2 * urad, 0};  // Z leans to +Y: EA0Z is -
    const SquarenessOfChain portal(AxisChainReader::read("w-X-Y.b-W-Z-C-t"), TiltReading::component,
                                   TiltDatum::rail, {Axis::X, Axis::Y, Axis::Z, Axis::W});
    const auto quantities = portal.quantities({yz}, {{Axis::W, 0, -30 * urad, {}}});
    ASSERT_EQ(quantities.size(), 2u);
    EXPECT_TRUE(quantities[1].is_of(Axis::Z, 0));
    EXPECT_NEAR(quantities[1].angle, -20 * urad, 1e-12);
}

TEST(Corner, SeveralMeasurementsOfOneAreWeighedAndWidenedWhereTheyDisagree) {
    const Corner a{Axis::X, Axis::Y, 10 * urad, 1 * urad, 0}, b{Axis::X, Axis::Y, 13 * urad, 2 * urad, 0};
    const Corner near = mean_of({a, {Axis::X, Axis::Y, 10.5 * urad, 2 * urad, 0}});
    EXPECT_NEAR(near.opening, 10.1 * urad, 1e-12);
    EXPECT_NEAR(near.uncertainty, urad / std::sqrt(1.25), 1e-12);
    const Corner mean = mean_of({a, b});
    EXPECT_NEAR(mean.opening, 10.6 * urad, 1e-12);
    EXPECT_NEAR(mean.uncertainty, urad / std::sqrt(1.25) * 3 / std::sqrt(5.0), 1e-12);
}

TEST(SquarenessOfChain, DatumThatIsKnownToLeanIsHeldAgainst) {
    const Corner xz{Axis::X, Axis::Z, -80 * urad, 2 * urad, 0, 0};
    const AxisChain chain = AxisChainReader::read("w-X.b-W-Y-Z-C-t");
    const auto quantities = SquarenessOfChain(chain, TiltReading::component, TiltDatum::rail,
                                              {Axis::X, Axis::Y, Axis::Z, Axis::W})
                                .quantities({xz}, {{Axis::X, 1, -50 * urad, {}}});
    ASSERT_EQ(quantities.size(), 2u);
    EXPECT_TRUE(quantities[1].is_of(Axis::Z, 1));
    EXPECT_NEAR(quantities[1].angle, 30 * urad, 1e-12) << "X leans to +Z by 50 of the 80";
    const KinematicChain machine = machine_of(chain, TiltReading::component, TiltDatum::rail, quantities);
    EXPECT_NEAR(corner_of(machine, Axis::X, Axis::Z), xz.opening, 0.03 * urad);
    EXPECT_NEAR(opening_of(machine, Axis::X, Axis::Z), xz.opening, 0.03 * urad);
}

TEST(SquarenessOfChain, DatumThatRidesOnAKnownRailTurnsWithIt) {
    const Corner yz{Axis::Y, Axis::Z, -50 * urad, 2 * urad, 0, 0};
    const AxisChain chain = AxisChainReader::read("w-X.b-W-Y-Z-C-t");
    for (const TiltReading reading : {TiltReading::component, TiltReading::axis_direction}) {
        const auto quantities =
            SquarenessOfChain(chain, reading, TiltDatum::rail, {Axis::X, Axis::Y, Axis::Z, Axis::W})
                .quantities({yz}, {{Axis::W, 0, -30 * urad, {}}});
        ASSERT_EQ(quantities.size(), 2u);
        EXPECT_TRUE(quantities[1].is_of(Axis::Z, 0));
        EXPECT_NEAR(quantities[1].angle, (reading == TiltReading::component ? -50 : -20) * urad, 1e-12);
        const KinematicChain machine = machine_of(chain, reading, TiltDatum::rail, quantities);
        EXPECT_NEAR(corner_of(machine, Axis::Y, Axis::Z), yz.opening, 0.03 * urad);
    }
}

TEST(Corner, UncertaintyOfTheSquareItselfDoesNotAverageOut) {
    const Corner one{Axis::X, Axis::Y, 10 * urad, std::hypot(2, 50) * urad, 0, 50 * urad};
    EXPECT_NEAR(mean_of({one, one, one, one}).uncertainty, std::hypot(1, 50) * urad, 1e-12);
    const Corner turned{Axis::X, Axis::Y, 40 * urad, 2 * urad, 0, 0};
    EXPECT_NEAR(mean_of({turned, one}).opening, 40 * urad, 0.1 * urad);
    EXPECT_NEAR(mean_of({turned, one}).uncertainty, 2 * urad, 0.01 * urad);
    EXPECT_LT(mean_of({turned, one}).scatter, 1) << "the square may be off by that";
    SquareReadings square;
    square.positions = {0, 300};
    square.readings = {0, 24 * um};
    square.uncertainty = 1 * um;
    square.square_uncertainty = 50 * urad;
    EXPECT_NEAR(corner_from_square(square).own, 50 * urad, 1e-12);
    square.turned = {0, -24 * um};
    EXPECT_EQ(corner_from_square(square).own, 0) << "turning shows it";
    Diagonals d;
    d.rising = d.falling = 500;
    d.uncertainty = 1 * um;
    d.own_uncertainty = 5 * urad;
    EXPECT_EQ(corner_from_diagonals(Axis::X, Axis::Y, d, MeasuredObject::artifact).own, 5 * urad);
}

TEST(ProbedShape, GivesTheArtifactsOwnPartOfTheUncertainty) {
    ProbedShape shape;
    shape.uncertainty = 1 * um;
    shape.own_uncertainty = 10 * urad;
    for (const double side : {-100.0, 100.0}) {
        shape.points.push_back({{100, side}, 0, 0});
        shape.points.push_back({{side, 100}, pi / 2, 0});
    }
    const Corner corner = corner_from_shape(shape).corner;
    EXPECT_NEAR(corner.own, std::sqrt(2.0) * 10 * urad, 0.01 * urad) << "two faces";
    EXPECT_NEAR(corner.uncertainty, std::hypot(corner.own, um / 100), 0.01 * urad);
    std::vector<ProbedShape::Point> again = shape.points;
    for (ProbedShape::Point& point : again) {
        point.place = Eigen::Vector2d(-point.place.y(), point.place.x());
        point.normal += pi / 2;
        point.turned = pi / 2;
        shape.points.push_back(point);
    }
    EXPECT_EQ(corner_from_shape(shape).corner.own, 0) << "turning shows it";
}

// The test move, on paper: an axis that leans by 80 urad towards the base is 24 um further there at 300 mm.
TEST(IndicatorOnSquare, ReadsMoreWhereTheAxisLeansTowardsThePlungersEnd) {
    const AxisChain chain = AxisChainReader::read("w-Z.b-X-Y-C-t");
    const auto reading = [&](SquarenessQuantity quantity, Axis moved, Axis base) {
        return indicator_on_square(machine_of(chain, TiltReading::component, TiltDatum::rail, {quantity}),
                                   moved, base, 300);
    };
    EXPECT_NEAR(reading({Axis::Y, 2, -80 * urad, {}}, Axis::Y, Axis::X), 24 * um, 1e-4 * um);
    EXPECT_NEAR(reading({Axis::Y, 0, 60 * urad, {}}, Axis::Y, Axis::Z), 18 * um, 1e-4 * um);
    EXPECT_NEAR(reading({Axis::Z, 1, -50 * urad, {}}, Axis::Z, Axis::X), -15 * um, 1e-4 * um);
    EXPECT_NEAR(reading({Axis::X, 2, 50 * urad, {}}, Axis::X, Axis::Y), 0, 1e-4 * um) << "Y turns with X";
}

}  // namespace
}  // namespace plumb
