// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/compensation_effect.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace plumb {
namespace {

using Eigen::VectorXd;

constexpr double um = 1e-3;

TEST(CompensationGain, IsThatOfTheTextbook) {
    const VectorXd off = (VectorXd(5) << 0, 20, 35, 45, 50).finished() * um;
    for (const double gain : {-1.0, 0.0, 0.8, 1.0, 1.3}) {
        const CompensationGain found = compensation_gain(off, (1 - gain) * off, 0.7 * um);
        EXPECT_TRUE(found.determined);
        EXPECT_NEAR(found.gain, gain, 1e-9);
        EXPECT_NEAR(found.effectiveness, 1 - std::abs(1 - gain), 1e-9);
    }
}

TEST(CompensationGain, TwoUncertaintiesCoverIt) {
    Random random(5);
    int covered = 0;
    constexpr int tests = 500;
    for (int i = 0; i < tests; ++i) {
        const double gain = random.uniform(-1, 1.5), s = 0.8 * um;
        const double size = random.uniform(15, 70) * um, reference = s * random.gaussian();
        const double reference_on = s * random.gaussian();
        VectorXd off(9), on(9);
        for (int k = 0; k < 9; ++k) {
            const double drift = -size * std::expm1(-0.4 * k);
            off[k] = drift + s * random.gaussian() - reference;
            on[k] = (1 - gain) * drift + s * random.gaussian() - reference_on;
        }
        const CompensationGain found = compensation_gain(off, on, s);
        if (std::abs(found.gain - gain) <= 2 * found.uncertainty) ++covered;
    }
    EXPECT_GE(covered, 0.9 * tests);
}

TEST(CompensationGain, WithoutDriftThereIsNone) {
    EXPECT_FALSE(compensation_gain(VectorXd::Constant(6, um), VectorXd::Zero(6), um).determined);
    EXPECT_FALSE(compensation_gain(VectorXd::Ones(1), VectorXd::Zero(1), um).determined);
}

// A machine whose three axes follow its spindle and its bed, and a compensation by two of three sensors.
struct Machine {
    enum Sensor { spindle, bed, air };
    CompensationRecord record;
    Eigen::Matrix<double, 2, 3> law;
    Eigen::MatrixX2d seen;  // temperatures for the compensation
    Random random;

    explicit Machine(std::uint64_t seed) : random(seed) {
        constexpr int passes = 10;
        const double spindle_rise = random.uniform(8, 20), bed_rise = random.uniform(3, 8);
        const double spindle_tau = random.uniform(600, 1500), bed_tau = random.uniform(4000, 9000);
        record.drift.resize(passes, 3);
        record.compensation.resize(passes, 3);
        record.temperatures.resize(passes, 3);
        seen.resize(passes, 2);
        const double sizes[3] = {random.uniform(5, 15), random.uniform(8, 25), random.uniform(30, 60)};
        for (int axis = 0; axis < 3; ++axis) {
            const double share = random.uniform(0.4, 0.8), sign = random.index(2) == 0 ? 1 : -1;
            law(spindle, axis) = sign * sizes[axis] * share / spindle_rise * um;
            law(bed, axis) = sign * sizes[axis] * (1 - share) / bed_rise * um * random.uniform(-0.6, 1);
        }
        const double begin = random.uniform(18, 24);
        for (int k = 0; k < passes; ++k) {
            const double t = 1800.0 * k;
            record.temperatures(k, spindle) = begin - spindle_rise * std::expm1(-t / spindle_tau);
            record.temperatures(k, bed) = begin - bed_rise * std::expm1(-t / bed_tau);
            record.temperatures(k, air) = begin + 0.5 * std::sin(t / 4000);
            record.drift.row(k) = rise(k) * law;
        }
        seen = record.temperatures.leftCols<2>();
        for (int sensor = 0; sensor < 3; ++sensor) noisy(sensor);
        const Eigen::MatrixX3d truth = record.drift;
        for (int k = 0; k < passes; ++k)
            for (int axis = 0; axis < 3; ++axis)
                record.drift(k, axis) = truth(k, axis) + 0.8 * um * random.gaussian();
        record.drift.rowwise() -= record.drift.row(0).eval();
        compensate();
    }

    Eigen::RowVector2d rise(int k) const {
        return record.temperatures.row(k).leftCols<2>() - record.temperatures.row(0).leftCols<2>();
    }
    void noisy(int sensor) {
        const double offset = 0.3 * random.gaussian() / 2;
        for (int k = 0; k < record.temperatures.rows(); ++k)
            record.temperatures(k, sensor) += offset + 0.05 * random.gaussian();
    }
    // By the temperatures as the compensation gets them; it was set to 0 on a machine of 21 degC.
    void compensate() {
        const Eigen::RowVector2d cold = seen.row(0);
        for (int k = 0; k < seen.rows(); ++k) record.compensation.row(k) = (seen.row(k) - cold) * law * 0.97;
    }
    CompensationFault judged() const { return judged_compensation(record).fault; }
};

template <class Spoil>
void expect_named(CompensationFault expected, const Spoil& spoil) {
    int named = 0, machines = 0;
    for (int seed = 1; seed <= 200; ++seed) {
        Machine machine(static_cast<std::uint64_t>(seed));
        const Eigen::MatrixX3d good = machine.record.compensation;
        spoil(machine);
        // Sensors that change the compensation by less than a fifth of the drift when they are swapped are no
        // fault that a test could see.
        const double change = (machine.record.compensation - good).norm();
        if (expected == CompensationFault::swapped_sensors && change < machine.record.drift.norm() / 5)
            continue;
        ++machines;
        const CompensationFault found = machine.judged();
        if (found == expected) ++named;
        if (expected != CompensationFault::none) {
            EXPECT_NE(found, CompensationFault::none) << "machine " << seed;
        }
    }
    EXPECT_GE(machines, 120);
    EXPECT_GE(named, 0.95 * machines);
}

TEST(JudgedCompensation, CallsAGoodOneGood) {
    expect_named(CompensationFault::none, [](Machine&) {});
}
// A machine that drifts by 30 um along Z in eight passes, or in more, the further ones as warm as the eighth.
// Each pass and the reference have the uncertainty s.
CompensationRecord of_30_um(int seed, double gain, double s, int more_passes = 0, double scale = 1) {
    constexpr int passes = 8;
    Random random(static_cast<std::uint64_t>(seed), 8);
    CompensationRecord record;
    record.uncertainty = std::sqrt(2.0) * s;
    record.drift = record.compensation = Eigen::MatrixX3d::Zero(passes + more_passes, 3);
    record.temperatures.resize(passes + more_passes, 0);
    const double reference = s * random.gaussian();
    for (int k = 1; k < passes + more_passes; ++k) {
        const double drift = -30 * um * scale * std::expm1(-0.4 * std::min(k, passes - 1));
        record.drift(k, 2) = drift + s * random.gaussian() - reference;
        record.compensation(k, 2) = gain * drift;
    }
    return record;
}
int called_good(double gain, double s, int tests) {
    int good = 0;
    for (int seed = 1; seed <= tests; ++seed)
        good += judged_compensation(of_30_um(seed, gain, s)).fault == CompensationFault::none;
    return good;
}

TEST(JudgedCompensation, CallsAWeakOrAStrongOneGoodInOneOf40AtMostHoweverUncertainItIs) {
    constexpr int tests = 4000;
    for (const double s : {0.5, 1.0, 1.5, 2.0, 3.0})
        for (const double gain : {0.8, 1.25})
            EXPECT_LE(called_good(gain, s * um, tests), tests / 40) << gain << ' ' << s;
}
TEST(JudgedCompensation, CallsAPerfectOneGoodWhereItsUncertaintyIsWellWithinTheLimits) {
    constexpr int tests = 400;
    EXPECT_EQ(called_good(1, 0.5 * um, tests), tests);
    EXPECT_GE(called_good(1, 1.0 * um, tests), 0.95 * tests);
    EXPECT_GE(called_good(1, 1.5 * um, tests), 0.75 * tests);
    EXPECT_LE(called_good(1, 3.0 * um, tests), 0.1 * tests);  // 2u of the gain is wider than the limits
}
TEST(JudgedCompensation, NinetyFiveOf100GainsAreBetweenItsLimits) {
    constexpr int tests = 4000;
    for (const double gain : {0.5, 0.8, 1.0, 1.25, 1.4})
        for (const double s : {0.5, 1.5}) {
            int covered = 0;
            for (int seed = 1; seed <= tests; ++seed) {
                const CompensationFinding found = judged_compensation(of_30_um(seed, gain, s * um));
                covered += found.gain_low <= gain && gain <= found.gain_high;
            }
            EXPECT_GE(covered, 0.94 * tests) << gain << ' ' << s;
            EXPECT_LE(covered, 0.97 * tests) << gain << ' ' << s;
        }
}
TEST(JudgedCompensation, CallsASmallOneOfTheWrongSignTooWeak) {
    for (int seed = 1; seed <= 50; ++seed) {
        const CompensationFinding found = judged_compensation(of_30_um(seed, -0.15, 0.5 * um));
        EXPECT_EQ(found.fault, CompensationFault::too_weak);
        EXPECT_LT(found.gain, 0);
    }
}
// If the next passes show the gain of the passes so far, the compensation is determined with as many as the
// finding says, and not with one less; and so with the drift that it says.
TEST(JudgedCompensation, SaysWhatWouldDetermineIt) {
    int by_passes = 0, by_drift = 0, none = 0;
    const auto judged = [](double gain, double s, int more, double scale) {
        CompensationRecord record =
            of_30_um(1, gain, 0, more, scale);  // the noise is known, and happens to be 0
        record.uncertainty = std::sqrt(2.0) * s;
        return judged_compensation(record);
    };
    for (const double gain : {0.85, 0.95, 1.0, 1.1, 1.2})
        for (const double s : {1.5, 2.0, 2.4, 3.0, 3.4}) {
            const CompensationFinding found = judged(gain, s * um, 0, 1);
            if (found.fault != CompensationFault::undetermined || !found.drifts[2]) continue;
            if (found.more_passes > 0) {
                ++by_passes;
                EXPECT_NE(judged(gain, s * um, found.more_passes, 1).fault, CompensationFault::undetermined);
                EXPECT_EQ(judged(gain, s * um, found.more_passes - 1, 1).fault,
                          CompensationFault::undetermined);
            } else {
                ++none;
                EXPECT_EQ(judged(gain, s * um, 50, 1).fault, CompensationFault::undetermined);
            }
            ++by_drift;
            const double usual = 30 * um * -std::expm1(-0.4 * 7), scale = found.larger_drift / usual;
            EXPECT_GT(scale, 1);
            EXPECT_NE(judged(gain, s * um, 0, 1.01 * scale).fault, CompensationFault::undetermined);
            EXPECT_EQ(judged(gain, s * um, 0, 0.99 * scale).fault, CompensationFault::undetermined);
        }
    EXPECT_GE(by_passes, 4);
    EXPECT_GE(none, 4);
    EXPECT_GE(by_drift, 10);
}
TEST(JudgedCompensation, NamesOneThatIsAbsent) {
    expect_named(CompensationFault::absent, [](Machine& its) { its.record.compensation.setZero(); });
}
TEST(JudgedCompensation, NamesAWrongSign) {
    expect_named(CompensationFault::wrong_sign, [](Machine& its) { its.record.compensation *= -1; });
}
TEST(JudgedCompensation, NamesOneThatIsTooWeak) {
    expect_named(CompensationFault::too_weak, [](Machine& its) { its.record.compensation *= 0.8 / 0.97; });
}
TEST(JudgedCompensation, NamesOneThatIsTooStrong) {
    expect_named(CompensationFault::too_strong, [](Machine& its) { its.record.compensation *= 1.3 / 0.97; });
}
TEST(JudgedCompensation, NamesSwappedAxes) {
    expect_named(CompensationFault::swapped_axes,
                 [](Machine& its) { its.record.compensation.col(1).swap(its.record.compensation.col(2)); });
}
TEST(JudgedCompensation, NamesSwappedAxesWhoseCompensationIsTooWeakToo) {
    CompensationRecord record;
    record.uncertainty = 0.3 * um;
    record.drift.resize(10, 3);
    for (int k = 0; k < 10; ++k)
        record.drift.row(k) << 0, -25 * um * std::expm1(-0.17 * k), -60 * um * std::expm1(-0.9 * k);
    record.compensation = 0.6 * record.drift;
    EXPECT_EQ(judged_compensation(record).fault, CompensationFault::too_weak);
    record.compensation.col(1).swap(record.compensation.col(2));
    const CompensationFinding found = judged_compensation(record);
    EXPECT_EQ(found.fault, CompensationFault::swapped_axes);
    EXPECT_EQ(found.axis, 1);
    EXPECT_EQ(found.other_axis, 2);
}
TEST(JudgedCompensation, NamesAFrozenSensorThatIsLogged) {
    expect_named(CompensationFault::frozen_sensor, [](Machine& its) {
        its.record.temperatures.col(Machine::spindle).setConstant(20.1);
        its.seen.setConstant(20.1);
        its.compensate();
    });
}
TEST(JudgedCompensation, CallsAFrozenSensorAbsentIfItIsNotLogged) {
    expect_named(CompensationFault::absent, [](Machine& its) {
        its.record.temperatures = its.record.temperatures.rightCols<2>().eval();
        its.seen.setConstant(20.1);
        its.compensate();
    });
}
TEST(JudgedCompensation, NamesAnOffsetOfASensor) {
    expect_named(CompensationFault::sensor_offset, [](Machine& its) {
        its.record.temperatures.col(Machine::spindle).array() += 4;
        its.record.compensation.rowwise() += (Eigen::RowVector2d(4, 0) * its.law).eval();
    });
}
TEST(JudgedCompensation, NamesSwappedSensors) {
    expect_named(CompensationFault::swapped_sensors, [](Machine& its) {
        its.seen.col(0).swap(its.seen.col(1));
        its.record.temperatures.col(0).swap(its.record.temperatures.col(1));
        its.compensate();
    });
}

TEST(JudgedCompensation, NamesSwappedSensorsBesideOneThatWarmsLikeThem) {
    expect_named(CompensationFault::swapped_sensors, [](Machine& its) {
        Eigen::MatrixXd& temperatures = its.record.temperatures;
        temperatures.conservativeResize(Eigen::NoChange, 4);
        for (int k = 0; k < temperatures.rows(); ++k)
            temperatures(k, 3) = 0.7 * temperatures(k, Machine::bed) + 6 + 0.05 * its.random.gaussian();
        its.seen.col(0).swap(its.seen.col(1));
        temperatures.col(0).swap(temperatures.col(1));
        its.compensate();
    });
}

TEST(JudgedCompensation, ThreePassesAndAStillMachineAreNotJudged) {
    Machine machine(1);
    CompensationRecord few = machine.record;
    few.drift = machine.record.drift.topRows(3).eval();
    few.compensation = machine.record.compensation.topRows(3).eval();
    few.temperatures = machine.record.temperatures.topRows(3).eval();
    EXPECT_EQ(judged_compensation(few).fault, CompensationFault::undetermined);
    EXPECT_EQ(judged_compensation(few).more_passes, 1);
    machine.record.drift *= 0.02;
    EXPECT_EQ(machine.judged(), CompensationFault::undetermined);
    EXPECT_NEAR(judged_compensation(machine.record).larger_drift,
                std::max(6 * machine.record.uncertainty, 3 * um), 1e-9);
}

TEST(CompensationFault, EachHasASentence) {
    std::set<std::string> all;
    for (int i = 0; i <= static_cast<int>(CompensationFault::other); ++i) {
        const std::string text = sentence(static_cast<CompensationFault>(i));
        EXPECT_GT(text.size(), 10u);
        all.insert(text);
    }
    EXPECT_EQ(all.size(), 11u);
}

}  // namespace
}  // namespace plumb
