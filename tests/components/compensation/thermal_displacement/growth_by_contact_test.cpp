// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"

#include "tests/support/milling.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

using Event = GrowthByContact::Event;
using Lost = GrowthByContact::Lost;

constexpr double um = 1e-3;  // mm

GrowthByContact::Sample judged(GrowthByContact::Sample sample) {
    sample.judge();
    return sample;
}

GrowthByContact::Settings settings(Method method = Method::coordinate, double unit = 1) {
    GrowthByContact::Settings s;
    s.by_time = method == Method::time;
    s.by_speed = false;
    s.window = unit * 0.5;
    s.max_growth_rate = unit * 0.2 * um;
    s.floor = unit * 15 * um;
    s.cap = unit * 60 * um;
    s.max_correction = unit * 0.1;
    s.unexplained_growth = unit * 1;  // a growth may come at once
    return s;
}

// A mill whose offset is the last accepted growth, at once when the tool is out of the work.
struct Shop {
    Milling mill{};
    GrowthByContact::Settings used = settings();
    GrowthByContact measured{};
    double target = 0;
    std::vector<double> accepted{};                               // mm
    std::function<void(Milling::Sample&)> tamper = [](auto&) {};  // with the sample

    void cycle(double growth, std::map<int, Milling::Upset> upsets = {}) {
        mill.growth = growth;
        mill.upsets = std::move(upsets);
        const double unit = mill.unit;
        mill.cycle([&](const Milling::Sample& true_sample) {
            Milling::Sample sample = true_sample;
            tamper(sample);
            const double offset = unit * mill.offset;
            if (measured.step(judged(sample), used, mill.dt) == Event::accepted) {
                accepted.push_back(measured.growth() / unit);
                target = measured.growth();
            }
            return measured.in_work() ? offset : target;
        });
    }
    void learn() {
        mill.learn = true;
        cycle(0);
        mill.learn = false;
    }
    const CycleTally::Counts& counts() const { return measured.tally().counts(); }
};

Shop learnt(Method method = Method::coordinate) {
    Shop shop;
    shop.used = settings(method);
    shop.learn();
    return shop;
}

// It has grown by 10 um, and does not grow by more than a spindle can.
Shop settled(Method method, double noise = 0, int parts = 3) {
    Shop shop;
    shop.mill.noise = noise;
    shop.used = settings(method);
    shop.used.unexplained_growth = 6 * um;
    shop.learn();
    for (int n = 1; n <= parts; ++n) shop.cycle(10 * um * n / parts);
    return shop;
}

TEST(GrowthByContact, MeasuresGrowthByEitherMethodAtAnyPeriod) {
    for (const Method method : {Method::coordinate, Method::time})
        for (const double dt : {0.0005, 0.001, 0.002}) {
            Shop shop;
            shop.mill.dt = dt;
            shop.used = settings(method);
            shop.learn();
            ASSERT_TRUE(shop.measured.cycle().references().made_with(shop.mill.setup));
            for (int n = 0; n < 3; ++n) shop.cycle(12 * um);
            ASSERT_EQ(shop.accepted.size(), 12u);
            for (const double g : shop.accepted) EXPECT_NEAR(g, 12 * um, 0.5 * um) << dt;
            EXPECT_EQ(shop.counts().missed, 0);
        }
}

TEST(GrowthByContact, MeasuresInInches) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop;
        shop.mill.unit = 1 / 25.4;
        shop.used = settings(method, 1 / 25.4);
        shop.learn();
        for (int n = 0; n < 2; ++n) shop.cycle(12 * um);
        ASSERT_EQ(shop.accepted.size(), 8u);
        for (const double g : shop.accepted) EXPECT_NEAR(g, 12 * um, 0.5 * um);
    }
}

TEST(GrowthByContact, AConstantGrowthStaysConstantForAThousandContacts) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop;
        shop.mill.dt = 0.002;
        shop.used = settings(method);
        shop.learn();
        constexpr int cycles = 250;
        for (int n = 0; n < cycles; ++n) shop.cycle(14 * um);
        ASSERT_EQ(shop.accepted.size(), 4u * cycles);
        for (const double g : shop.accepted) ASSERT_NEAR(g, 14 * um, 0.5 * um);
    }
}

TEST(GrowthByContact, AConstantGrowthKeepsANoisyOffsetWithinToleranceAndThreeSigmaForAThousandCycles) {
    constexpr double tolerance = 2 * um;
    Shop shop;
    shop.mill.program = {{10, 1, -20}};
    shop.mill.noise = 0.3;
    shop.mill.dt = 0.004;
    shop.used.by_speed = true;
    shop.learn();
    constexpr int cycles = 1000;
    double offset = 0, largest = 0, variance = 0;
    for (int n = 0; n < cycles; ++n) {
        shop.cycle(14 * um);
        ASSERT_EQ(shop.counts().accepted, n + 1);
        const double estimate = shop.measured.filter().growth();
        if (std::abs(estimate - offset) > tolerance) offset = estimate;
        largest = std::max(largest, std::abs(offset - 14 * um));
        variance += shop.measured.sigma() * shop.measured.sigma() / cycles;
    }
    EXPECT_LE(largest, tolerance + 3 * std::sqrt(variance));
    EXPECT_GT(largest, 0.5 * um) << "there is noise";
}

TEST(GrowthByContact, ScatterOfContactsIsAsLargeAsSigma) {
    Shop shop;
    shop.mill.noise = 0.3;
    shop.mill.dt = 0.002;
    shop.learn();
    for (int n = 0; n < 50; ++n) shop.cycle(15 * um);
    ASSERT_EQ(shop.accepted.size(), 200u);
    double variance = 0;
    for (const double g : shop.accepted) variance += (g - 15 * um) * (g - 15 * um) / 200;
    EXPECT_LT(std::sqrt(variance), 2 * um);
    EXPECT_GT(shop.measured.sigma(), 0.5 * std::sqrt(variance));
    EXPECT_LT(shop.measured.sigma(), 3 * std::sqrt(variance));
}

TEST(GrowthByContact, AnAirCutIsMissedAndShiftsNothingElse) {
    Shop shop = learnt();
    shop.cycle(10 * um, {{1, {true}}});
    EXPECT_EQ(shop.counts().missed, 1);
    ASSERT_EQ(shop.accepted.size(), 3u);
    for (const double g : shop.accepted) EXPECT_NEAR(g, 10 * um, 0.5 * um);
}

// Trap 6 in the small: counted by contacts, the second plunge would be taken for the first and shift by -2
// um.
TEST(GrowthByContact, AnAirCutIsNotMistakenForTheNextPlungeOfTheSameOperation) {
    Shop shop;
    shop.mill.program = {{30, 1, -20}, {30, 1, -20.012}};
    shop.learn();
    shop.cycle(10 * um, {{0, {true}}});
    ASSERT_EQ(shop.accepted.size(), 1u);
    EXPECT_NEAR(shop.accepted[0], 10 * um, 0.5 * um);
    EXPECT_EQ(shop.counts().missed, 1);
}

TEST(GrowthByContact, TheToolIsInTheWorkUntilItIsAboveTheContact) {
    Shop shop;
    shop.mill.program = {{30, 1, -20}, {30, 1, -20}};
    shop.learn();
    shop.mill.growth = 10 * um;
    int early = 0;  // periods of retraction in which the tool was taken to be out
    shop.mill.cycle([&](const Milling::Sample& sample) {
        shop.measured.step(judged(sample), shop.used, shop.mill.dt);
        early += shop.mill.cutting && sample.velocity > 0 && !shop.measured.in_work();
        return 0.0;
    });
    EXPECT_LE(early, 2) << "one in each of two cuts: a contact is seen a little late, and so a little low";
    EXPECT_FALSE(shop.measured.in_work());
}

TEST(GrowthByContact, AnOffsetHasToWaitWhileTheToolFeedsDownWhetherItsContactsCountOrNot) {
    Shop shop = learnt();
    shop.used.excluded[0] = shop.mill.program.front().operation;
    int periods = 0, free = 0;
    shop.mill.cycle([&](const Milling::Sample& sample) {
        shop.measured.step(judged(sample), shop.used, shop.mill.dt);
        const bool down = sample.cycle_running && sample.motion == 2 && sample.velocity < 0;
        periods += down;
        free += down && !shop.measured.in_work();
        return 0.0;
    });
    EXPECT_GT(periods, 1000);
    EXPECT_EQ(free, 0);
}

TEST(GrowthByContact, AnOffsetHasToWaitUntilTheToolHasLeftTheWorkWhetherItsContactsCountOrNot) {
    Shop shop = learnt();
    for (std::size_t i = 0; i < shop.mill.program.size(); ++i)
        shop.used.excluded.at(i) = shop.mill.program[i].operation;
    int periods = 0, free = 0;
    bool in_cut = false;  // not only below the top of the next work, on the way to it
    shop.mill.cycle([&](const Milling::Sample& sample) {
        shop.measured.step(judged(sample), shop.used, shop.mill.dt);
        in_cut = shop.mill.cutting && (in_cut || sample.motion == 2);
        periods += in_cut;
        free += in_cut && !shop.measured.in_work();
        return 0.0;
    });
    EXPECT_GT(periods, 1000);
    EXPECT_EQ(free, 0);
    EXPECT_FALSE(shop.measured.in_work());
}

TEST(GrowthByContact, EventsBeyondTheGateAreRejectedEvenIfTheyLast) {
    const std::pair<double, Rejection> cases[]{{5, Rejection::outside_window},
                                               {-5, Rejection::outside_window},
                                               {0.3, Rejection::too_large},
                                               {0.08, Rejection::beyond_gate},
                                               {-0.08, Rejection::beyond_gate}};
    for (const auto& [height, reason] : cases) {
        Shop shop = learnt();
        shop.cycle(10 * um);
        const double before = shop.target;
        for (int n = 0; n < 5; ++n) {
            Milling::Upset upset;
            upset.height = height < -0.6 ? 0 : height;
            upset.air = height < -0.6;
            shop.cycle(10 * um, {{0, upset}});
            EXPECT_NEAR(shop.target, before, 0.5 * um) << height;
        }
        const Rejection found = shop.measured.tally().rejection();
        const bool gave_up = found == Rejection::withdrawn && reason == Rejection::beyond_gate;
        if (height > -0.6) {
            EXPECT_TRUE(found == reason || gave_up) << height;
        }
    }
}

TEST(GrowthByContact, WithinTheGateAChipShiftsByItsHeightUntilTheNextContact) {
    Shop shop = learnt();
    shop.cycle(10 * um);
    Milling::Upset chip;
    chip.height = 12 * um;
    shop.cycle(10 * um, {{3, chip}});
    EXPECT_NEAR(shop.target, 22 * um, 0.5 * um) << "nobody can know";
    shop.cycle(10 * um);
    EXPECT_NEAR(shop.target, 10 * um, 0.5 * um);
}

TEST(GrowthByContact, ReportsThatNoContactCounts) {
    Shop shop = learnt();
    shop.cycle(10 * um);
    for (int n = 0; n < 2; ++n) shop.cycle(-150 * um);
    shop.cycle(-150 * um, {{0, {true}}, {1, {true}}, {2, {true}}, {3, {true}}});  // proves nothing either way
    EXPECT_FALSE(shop.measured.tally().lost_track());
    shop.cycle(-150 * um);
    EXPECT_TRUE(shop.measured.tally().lost_track());
    shop.cycle(10 * um, {{3, {false, 0.2}}});
    EXPECT_FALSE(shop.measured.tally().lost_track()) << "one rejected contact among others does not count";
}

TEST(GrowthByContact, AShiftBeyondTheGateIsAskedAboutAndAnswered) {
    for (const Method method : {Method::coordinate, Method::time})
        for (const int answer : {0, 1, 2}) {
            const bool growth = answer == 1, elsewhere = answer == 2;
            Shop shop;
            shop.used = settings(method);
            shop.used.unexplained_growth = 6 * um;
            shop.learn();
            for (int n = 0; n < 3; ++n) shop.cycle(3 * um);
            const double before = shop.target;
            for (int n = 0; n < 3; ++n) shop.cycle(53 * um);
            const GrowthFilter& found = shop.measured.filter();
            EXPECT_EQ(found.shift(shop.used), Shift::all);
            EXPECT_NEAR(found.shift_size(), 50 * um, 1 * um);
            EXPECT_LT(std::abs(found.offset() - before), 3 * um + 5 * um)
                << "a part of 3 um is not worse by 5";
            EXPECT_FALSE(shop.measured.tally().lost_track());
            shop.mill.setup.program += elsewhere;
            if (elsewhere) shop.cycle(53 * um);  // a program without a reference
            if (growth)
                shop.measured.shift_is_growth();
            else
                shop.measured.shift_is_not_growth();
            shop.mill.setup.program -= elsewhere;
            for (int n = 0; n < 3; ++n) shop.cycle(53 * um);
            EXPECT_EQ(found.shift(shop.used), Shift::none);
            EXPECT_NEAR(shop.measured.filter().growth(), (growth ? 53 : 3) * um, 1 * um);
            EXPECT_NEAR(shop.accepted.back(), (growth ? 53 : 3) * um, 1 * um);
        }
}

// The table 30 um higher and its zero probed, or a new insert that was measured: nothing of it is growth, and
// nothing is asked.
TEST(GrowthByContact, ANewZeroOrAMeasuredToolMovesTheReferenceAndNothingElse) {
    for (const Method method : {Method::coordinate, Method::time})
        for (const bool tool : {false, true})
            for (const double moved : {30 * um, 8 * um, -3.0, 40.0}) {
                SCOPED_TRACE(std::to_string(moved) + (tool ? " tool" : " table"));
                Shop shop = settled(method);
                shop.mill.reason = OriginReason::zero;
                (tool ? shop.mill.lengths[2] : shop.mill.zero) = moved;
                (tool ? shop.mill.tips[2] : shop.mill.table) = moved;
                int seen = 0;  // it is measured in the spindle
                if (tool)
                    shop.tamper = [&](Milling::Sample& its) {
                        if (its.tool == 2 && ++seen < 100) its.tool_length -= moved;
                    };
                shop.cycle(10 * um);
                shop.mill.reason = OriginReason::none;
                shop.tamper = [](auto&) {};
                for (int n = 0; n < 2; ++n) shop.cycle(10 * um);
                EXPECT_NEAR(shop.measured.filter().growth(), 10 * um, 1 * um);
                EXPECT_EQ(shop.measured.filter().shift(shop.used), Shift::none);
                EXPECT_EQ(shop.measured.origin_change(), 0);
                EXPECT_EQ(shop.counts().rejected, 0);
                EXPECT_EQ(shop.accepted.size(), 24u);
            }
}

TEST(GrowthByContact, AZeroReplacesAChangeBeforeIt) {
    Shop shop = settled(Method::coordinate);
    shop.mill.zero = -12 * um;  // where the probe is to begin
    shop.mill.program = {{10, 1, -20}};
    shop.cycle(10 * um, {{0, {true}}});
    shop.mill.program = Milling().program;
    shop.mill.reason = OriginReason::zero;
    shop.mill.zero = shop.mill.table = 5 * um;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.measured.origin_change(), 0);
    EXPECT_NEAR(shop.measured.filter().growth(), 10 * um, 1 * um);
}

TEST(GrowthByContact, AnotherDepthKeepsTheGrowth) {
    for (const Method method : {Method::coordinate, Method::time})
        for (const bool tool : {false, true}) {
            Shop shop = settled(method);
            shop.mill.reason = OriginReason::depth;
            (tool ? shop.mill.lengths[1] : shop.mill.zero) = -20 * um;
            for (int n = 0; n < 3; ++n) shop.cycle(10 * um);
            EXPECT_NEAR(shop.measured.filter().growth(), 10 * um, 1 * um) << tool;
            EXPECT_EQ(shop.measured.origin_change(), 0);
            EXPECT_EQ(shop.counts().rejected, 0);
        }
}

TEST(GrowthByContact, GrowthThatWasCorrectedByHandCountsOnce) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop = settled(method);
        const double before = shop.measured.filter().growth();
        shop.mill.reason = OriginReason::by_hand;
        shop.mill.zero = 6 * um;
        shop.cycle(10 * um, {{0, {true}}, {1, {true}}, {2, {true}}, {3, {true}}});
        EXPECT_NEAR(shop.measured.filter().growth(), before - 6 * um, 0.1 * um)
            << "before a contact has shown it";
        shop.mill.reason = OriginReason::none;
        for (int n = 0; n < 2; ++n) shop.cycle(10 * um);
        EXPECT_NEAR(shop.measured.filter().growth(), 4 * um, 1 * um);
        EXPECT_EQ(shop.counts().rejected, 0);
    }
}

// The contact shows whether the work is higher by as much; if not, only the operator knows what he wanted.
TEST(GrowthByContact, AChangeOfTheOriginWithoutAReasonIsAskedAboutUnlessTheContactExplainsIt) {
    for (const Method method : {Method::coordinate, Method::time})
        for (const bool tool : {false, true}) {
            Shop moved = settled(method);
            (tool ? moved.mill.lengths[2] : moved.mill.zero) =
                (tool ? moved.mill.tips[2] : moved.mill.table) = 40 * um;
            for (int n = 0; n < 2; ++n) moved.cycle(10 * um);
            EXPECT_EQ(moved.measured.origin_change(), 0);
            EXPECT_NEAR(moved.measured.filter().growth(), 10 * um, 1 * um);
            EXPECT_EQ(moved.counts().rejected, 0);

            for (const OriginReason answer :
                 {OriginReason::zero, OriginReason::by_hand, OriginReason::depth}) {
                Shop shop = settled(method);
                (tool ? shop.mill.lengths[1] : shop.mill.zero) = -8 * um;
                for (int n = 0; n < 2; ++n) shop.cycle(10 * um);
                EXPECT_NEAR(shop.measured.origin_change(), -8 * um, 0.01 * um);
                EXPECT_NEAR(shop.measured.filter().growth(), 10 * um, 1 * um)
                    << "the offset keeps the growth";
                EXPECT_EQ(shop.measured.filter().doubt(), Doubt::origin);
                shop.mill.reason = answer;
                shop.cycle(10 * um);
                shop.mill.reason = OriginReason::none;
                EXPECT_EQ(shop.measured.origin_change(), 0);
                for (int n = 0; n < 3; ++n) shop.cycle(10 * um);
                const bool in_program =
                    answer == OriginReason::zero || (!tool && answer == OriginReason::by_hand);
                if (!tool) {
                    EXPECT_NEAR(shop.accepted.back(), (in_program ? 18 : 10) * um, 1 * um);
                }
                EXPECT_EQ(shop.measured.origin_change(), 0);
            }
            Shop back = settled(method);
            (tool ? back.mill.lengths[1] : back.mill.zero) = -8 * um;
            back.cycle(10 * um);
            back.mill.zero = back.mill.lengths[1] = 0;
            back.cycle(10 * um);
            EXPECT_EQ(back.measured.origin_change(), 0) << "it was taken back";
        }
}

// A zero that somebody touched off on a grown machine contains the growth that was not compensated then.
TEST(GrowthByContact, AForeignZeroContainsTheGrowthOfItsMoment) {
    Shop shop = settled(Method::coordinate);
    const double target = std::exchange(shop.target, 0.0);
    shop.mill.offset = 0;
    EXPECT_NEAR(target, 10 * um, 1 * um);
    shop.mill.table = 100 * um;
    shop.mill.zero = 110 * um;
    shop.cycle(10 * um, {{1, {true}}, {2, {true}}, {3, {true}}});  // one contact says it all
    EXPECT_EQ(shop.measured.origin_change(), 0);
    EXPECT_NEAR(shop.measured.filter().growth(), 0, 1.5 * um);
    EXPECT_EQ(shop.measured.filter().doubt(), Doubt::none);
}

TEST(GrowthByContact, ARecordWithoutAnOriginTakesThatOfItsFirstContact) {
    Shop shop = learnt();
    ContactReferences known = shop.measured.cycle().references();
    Shop restored;
    for (std::int32_t i = 0; i < known.size(); ++i) {
        known[i].contact.work_offset = known[i].contact.tool_length = 0;
        ASSERT_TRUE(restored.measured.restore(known[i]));
    }
    for (int n = 0; n < 2; ++n) restored.cycle(10 * um);
    EXPECT_NEAR(restored.measured.filter().growth(), 10 * um, 1 * um);
    EXPECT_EQ(restored.measured.origin_change(), 0);
    EXPECT_EQ(restored.measured.cycle().references()[0].contact.work_offset, -250);
}

// The time until the tool meets the work, s, in a plunge of this program.
double until_contact(const Milling::Sample& s, double growth) {
    const double top = s.operation == 20 ? -40 : s.operation == 30 && s.z < -21.5 ? -25 : -20;
    return (s.z - top - growth) / 2;
}

// A dip of the load or a rise by coolant right before the contacts, once or from now on.
TEST(GrowthByContact, ALoadThatChangesRightBeforeTheContactMovesNothingAndIsReported) {
    for (const bool coolant : {false, true})
        for (const double ends : {0.02, 0.05, 0.2})
            for (const double size : {1.0, 4.0})  // %
                for (const bool once : {false, true}) {
                    SCOPED_TRACE(std::to_string(ends) + (coolant ? " coolant " : " dip ") +
                                 std::to_string(size));
                    Shop shop = settled(Method::coordinate, 0.2);
                    shop.used.by_speed = true;
                    for (int n = 0; n < 8; ++n) shop.cycle(10 * um);
                    const double before = shop.measured.filter().offset();
                    shop.tamper = [&](Milling::Sample& s) {
                        if (s.motion != 2 || s.velocity >= 0 || (once && s.operation != 10)) return;
                        const double left = until_contact(s, 10 * um);
                        if (coolant && left < ends) s.load += size;
                        if (!coolant && left > ends && left < ends + 0.2) s.load -= size;
                    };
                    for (int n = 0; n < (once ? 1 : 8); ++n) shop.cycle(10 * um);
                    EXPECT_NEAR(shop.measured.filter().offset(), before, (once ? 2.5 : 5) * um);
                    if (!once) {
                        EXPECT_NE(shop.measured.filter().doubt(), Doubt::none);
                    }
                }
}

// Coolant comes on at the same height in each plunge, in the learning cycle too: such contacts do not move
// with the machine. The load rises again as the tool meets the work.
TEST(GrowthByContact, AnEventOfTheProgramIsNotLearnt) {
    for (const double height : {0.8, 1.5, 2.5})  // mm above the work
        for (const double size : {2.0, 6.0}) {   // %
            SCOPED_TRACE(std::to_string(height) + ' ' + std::to_string(size));
            Shop shop;
            shop.mill.noise = 0.2;
            bool excluded = false;
            double load = 0;
            shop.tamper = [&](Milling::Sample& s) {
                const bool on = s.motion == 2 && s.velocity <= 0 && (!excluded || s.operation == 10) &&
                                until_contact(s, shop.mill.growth) < height / 2;
                load += (on ? size - load : -load) * 0.033;
                s.load += load;
            };
            shop.learn();
            EXPECT_EQ(shop.measured.tally().learning_fault(), LearningFault::rises_twice);
            EXPECT_EQ(shop.measured.cycle().references().size(), 0);
            excluded = true;
            shop.used.excluded[0] = 10;
            shop.learn();
            EXPECT_EQ(shop.measured.tally().learning_fault(), LearningFault::none);
            EXPECT_EQ(shop.measured.cycle().references().size(), 3);
        }
}

// It comes shortly before the contact, where the fit sees two rises.
TEST(GrowthByContact, AnEventShortlyBeforeTheContactIsNotLearnt) {
    for (const double before : {0.06, 0.09, 0.15, 0.2, 0.3})  // s
        for (const double size : {2.0, 6.0}) {                // %
            Shop shop;
            shop.mill.noise = 0.2;
            double load = 0;
            shop.tamper = [&](Milling::Sample& s) {
                const bool on =
                    s.motion == 2 && s.velocity <= 0 && until_contact(s, shop.mill.growth) < before;
                load += (on ? size - load : -load) * 0.033;
                s.load += load;
            };
            shop.learn();
            EXPECT_NE(shop.measured.tally().learning_fault(), LearningFault::none) << before << ' ' << size;
            EXPECT_EQ(shop.measured.cycle().references().size(), 0);
            if (before < 0.1) {
                EXPECT_EQ(shop.measured.tally().learning_fault(), LearningFault::rises_twice);
                EXPECT_EQ(shop.measured.tally().rejection(), Rejection::rises_twice);
            }
            shop.tamper = [](auto&) {};
            shop.learn();
            EXPECT_EQ(shop.measured.tally().learning_fault(), LearningFault::none);
            EXPECT_EQ(shop.measured.cycle().references().size(), 4);
        }
}

// It comes after learning: such a contact is rejected, and moves nothing.
TEST(GrowthByContact, AContactAtWhichTheLoadRisesTwiceIsRejected) {
    Shop shop = settled(Method::coordinate, 0.2);
    const double before = shop.measured.filter().offset();
    double load = 0;
    shop.tamper = [&](Milling::Sample& s) {
        const bool on = s.motion == 2 && s.velocity <= 0 && until_contact(s, shop.mill.growth) < 0.06;
        load += (on ? 4 - load : -load) * 0.033;
        s.load += load;
    };
    const std::int32_t accepted = shop.counts().accepted;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, accepted);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::rises_twice);
    EXPECT_NEAR(shop.measured.filter().offset(), before, 1 * um);
    shop.tamper = [](auto&) {};
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, accepted + 4);
}

// The filter of the drive is another one from now on: each contact is fitted with it, and shows the growth.
TEST(GrowthByContact, AnotherFilterOfTheDriveShiftsNothing) {
    for (const double lag : {0.015, 0.02, 0.024, 0.03, 0.036, 0.045, 0.06}) {
        SCOPED_TRACE(lag);
        Shop shop = settled(Method::coordinate, 0.2, 8);
        shop.used.by_speed = true;
        for (int n = 0; n < 3; ++n) shop.cycle(10 * um);
        shop.mill.lag = lag;
        for (int n = 0; n < 4; ++n) {
            shop.cycle(10 * um);
            EXPECT_NEAR(shop.measured.growth(), 10 * um, 3 * um) << n;
            EXPECT_NEAR(shop.measured.contact().time_constant, lag, 0.15 * lag) << n;
        }
        EXPECT_NEAR(shop.measured.filter().growth(), 10 * um, 2 * um);
        EXPECT_EQ(shop.measured.filter().doubt(), Doubt::none);
        EXPECT_EQ(shop.counts().rejected, 0);
    }
}

// The load of tool 2 rises more slowly than that of tool 1, as at the teeth of a face mill.
TEST(GrowthByContact, AnotherFilterIsFoundByTheReferencesOfItsOwnTool) {
    Shop shop;
    shop.used.by_speed = true;
    shop.used.unexplained_growth = 6 * um;
    shop.mill.noise = 0.2;
    double slow = 0;
    shop.tamper = [&](Milling::Sample& s) {
        slow += (s.load - slow) * -std::expm1(-shop.mill.dt / 0.04);
        if (s.tool == 2) s.load = slow;
    };
    shop.learn();
    for (int n = 1; n <= 3; ++n) shop.cycle(3 * n * um);
    shop.mill.lag = 0.06;  // tool 1 now rises as tool 2 did
    for (int n = 0; n < 4; ++n) shop.cycle(9 * um);
    EXPECT_NEAR(shop.measured.filter().offset(), 9 * um, 5 * um);
    EXPECT_EQ(shop.measured.filter().doubt(), Doubt::none);
}

// Its load rings from now on, as behind a belt that has become loose: contacts shift by less than matters, or
// are asked about.
TEST(GrowthByContact, AResonanceThatComesLaterShiftsLittleOrIsAskedAbout) {
    for (const double frequency : {25.0, 50.0, 100.0, 250.0})
        for (const double quality : {1.0, 2.0, 4.0}) {
            Shop shop = settled(Method::coordinate, 0.2, 8);
            shop.used.by_speed = true;
            for (int n = 0; n < 3; ++n) shop.cycle(10 * um);
            double load = 0, rate = 0;
            shop.tamper = [&](Milling::Sample& s) {
                const double w = 6.2832 * frequency;
                for (int i = 0; i < 20; ++i) {
                    const double dt = shop.mill.dt / 20;
                    rate += dt * (w * w * (s.load - load) - w / quality * rate);
                    load += dt * rate;
                }
                s.load = load;
            };
            for (int n = 0; n < 8; ++n) shop.cycle(10 * um);
            const bool asked = shop.measured.filter().doubt() != Doubt::none;
            const double error = shop.measured.filter().offset() - 10 * um;
            EXPECT_LT(std::abs(error), (asked ? 10.1 : 6) * um) << frequency << ' ' << quality;
        }
}

TEST(GrowthByContact, FeedingUpwardsInTheCutDoesNotLeaveTheWork) {
    Shop shop = learnt();
    bool in_the_cut = false;
    shop.tamper = [&](Milling::Sample& sample) {
        const bool at_the_bottom = sample.operation == 20 && shop.mill.cutting && sample.velocity == 0;
        if (!at_the_bottom) return;
        in_the_cut = true;
        sample.velocity = 0.001;
        sample.motion = 2;
    };
    shop.mill.cycle([&](const Milling::Sample& true_sample) {
        Milling::Sample sample = true_sample;
        shop.tamper(sample);
        shop.measured.step(judged(sample), shop.used, shop.mill.dt);
        if (sample.velocity == 0.001) {
            EXPECT_TRUE(shop.measured.in_work());
            EXPECT_TRUE(shop.measured.detector().in_work());
        }
        return 0.0;
    });
    EXPECT_TRUE(in_the_cut);
}

TEST(GrowthByContact, TimeDoesNotMakeAShiftGrowth) {
    Shop shop;
    shop.used.unexplained_growth = 6 * um;
    shop.learn();
    for (int n = 0; n < 8; ++n) shop.cycle(25 * um);
    EXPECT_EQ(shop.measured.filter().offset(), 0) << "it harms no part, whatever the shift is";
    EXPECT_EQ(shop.measured.filter().shift(shop.used), Shift::all);
}

TEST(GrowthByContact, AnotherFeedIsRejectedByTimeAndComparedByCoordinate) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop = learnt(method);
        Milling::Upset slow;
        slow.feed_override = 0.7;
        shop.cycle(10 * um, {{0, slow}});
        const bool compared = method == Method::coordinate;
        EXPECT_EQ(shop.counts().rejected, compared ? 0 : 1);
        EXPECT_EQ(shop.measured.tally().rejection(), compared ? Rejection::none : Rejection::feed_differs);
        EXPECT_EQ(shop.counts().accepted, compared ? 4 : 3);
        EXPECT_NEAR(shop.accepted.front(), 10 * um, 0.5 * um);
    }
}

TEST(GrowthByContact, AFeedHoldIsNoGrowth) {
    Milling::Upset held;
    held.hold = 0.05;  // 100 um at 2 mm/s, to a clock
    Shop timed = learnt(Method::time);
    timed.cycle(10 * um, {{0, held}});
    EXPECT_EQ(timed.measured.tally().rejection(), Rejection::time_differs);
    EXPECT_EQ(timed.counts().accepted, 3);
    Shop placed = learnt(Method::coordinate);
    placed.cycle(10 * um, {{0, held}});
    EXPECT_EQ(placed.counts().accepted, 4) << "the coordinate does not care";
    EXPECT_NEAR(placed.accepted[0], 10 * um, 0.5 * um);
}

// Held just after it has met the work, before the load shows it, the tool seems to meet it where it goes on.
TEST(GrowthByContact, AFeedHoldInTheContactIsRejected) {
    Milling::Upset held;
    held.hold = 3;
    double worst = 0;  // of any growth that would be accepted
    const Shop before = learnt();
    constexpr double between = 0.4 / 40;
    for (double height = 0.2; height > -0.2; height -= between) {
        held.hold_height = height;
        for (const double steady_time : {0.0, 0.2}) {
            Shop shop = before;
            shop.used.steady_time = steady_time;
            shop.cycle(10 * um, {{0, held}});
            ASSERT_GE(shop.accepted.size(), steady_time == 0 ? 1u : 3u);
            const double error = std::abs(shop.accepted[0] - 10 * um);
            if (steady_time == 0)
                worst = std::max(worst, error);
            else
                EXPECT_LT(error, 0.5 * um) << height;
        }
    }
    EXPECT_GT(worst, 10 * um) << "as far as the gate lets it";
    held.hold_height = 0.45;
    Shop above = learnt();
    above.cycle(10 * um, {{0, held}});
    EXPECT_EQ(above.counts().accepted, 4) << "0.2 s at 2 mm/s before the contact";
    held.hold_height = 0.35;
    above.cycle(10 * um, {{0, held}});
    EXPECT_EQ(above.measured.tally().rejection(), Rejection::unsteady_feed);
    EXPECT_EQ(above.counts().accepted, 7);
}

TEST(GrowthByContact, AClockThatMissedItsStartIsRejected) {
    Shop shop;
    shop.used = settings(Method::time);
    shop.used.blanking_time = 0;
    shop.learn();
    shop.tamper = [](Milling::Sample& s) {
        if (s.motion == 2 && std::abs(s.z - s.start_height) < 0.1)
            s.z = std::numeric_limits<double>::quiet_NaN();
    };
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 0);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::no_clock);
}

TEST(GrowthByContact, ByTimeNothingIsLearntWithoutAClock) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop;
        shop.used = settings(method);
        shop.tamper = [](Milling::Sample& s) { s.start_height = -1000; };  // which Z never passes
        shop.learn();
        const bool timed = method == Method::time;
        EXPECT_EQ(shop.measured.tally().learning_fault(),
                  timed ? LearningFault::no_clock : LearningFault::none);
        EXPECT_EQ(shop.measured.cycle().references().size(), timed ? 0 : 4);
        EXPECT_EQ(shop.measured.tally().rejection(), timed ? Rejection::no_clock : Rejection::none);
    }
}

// As a program does that learned before its start height was netted.
TEST(GrowthByContact, AReferenceWithoutATimeIsNotComparedByTime) {
    Shop shop;
    const std::function<void(Milling::Sample&)> clocked = shop.tamper;
    shop.tamper = [](Milling::Sample& s) { s.start_height = -1000; };
    shop.learn();
    shop.tamper = clocked;
    shop.used.by_time = true;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().rejected, 4);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::no_clock);
}

// The program clock, started by its mark as each plunge begins to feed.
TEST(GrowthByContact, AMarkStartsTheProgramClockSoThatALongerToolChangeIsNoGrowth) {
    for (const bool marked : {false, true}) {
        Shop shop;
        shop.used = settings(Method::time);
        shop.used.program_clock = true;
        shop.tamper = [&](Milling::Sample& s) { s.clock_start = marked && s.motion == 2; };
        shop.learn();
        shop.mill.change_time = 0.02;
        shop.cycle(10 * um);
        EXPECT_EQ(shop.counts().accepted, marked ? 4 : 1) << "the first cut has no tool change before it";
        EXPECT_EQ(shop.measured.tally().rejection(), marked ? Rejection::none : Rejection::time_differs);
        EXPECT_NEAR(shop.accepted.back(), 10 * um, 0.5 * um);
    }
}

TEST(GrowthByContact, AStartHeightIsOfTheJointWhateverHomingFound) {
    for (const double motor_offset : {-31.5, 0.0, 7.25}) {
        Shop shop;
        shop.used = settings(Method::time);
        shop.tamper = [&](Milling::Sample& s) {
            s.motor_offset = motor_offset;
            s.z += motor_offset;
        };
        shop.learn();
        shop.cycle(10 * um);
        EXPECT_EQ(shop.counts().accepted, 4) << motor_offset;
        EXPECT_NEAR(shop.target, 10 * um, 0.5 * um);
    }
}

TEST(GrowthByContact, AMarkDoesNotMoveTheClockOfAStartHeight) {
    Shop shop;
    shop.used = settings(Method::time);
    shop.learn();
    shop.tamper = [](Milling::Sample& s) { s.clock_start = s.z < s.start_height - 0.5; };
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 4);
    EXPECT_NEAR(shop.target, 10 * um, 0.5 * um);
}

TEST(GrowthByContact, AClockFromProgramStartRejectsALongerToolChange) {
    Shop shop;
    shop.used = settings(Method::time);
    shop.used.program_clock = true;
    shop.learn();
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 4);
    EXPECT_NEAR(shop.target, 10 * um, 0.5 * um);
    shop.mill.change_time = 0.02;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::time_differs);
    EXPECT_NEAR(shop.target, 10 * um, 0.5 * um);
}

TEST(GrowthByContact, ASpeedChangeOnTheWayBlanksTheContact) {
    Shop shop = learnt();
    Milling::Upset change;
    change.speed_change = true;
    shop.cycle(10 * um, {{0, change}});
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::blanked);
    EXPECT_EQ(shop.counts().rejected, 1);
    EXPECT_EQ(shop.counts().missed, 0) << "it came, though it was rejected";
}

TEST(GrowthByContact, AnAbortedCycleCountsWhatItHadAndNoMore) {
    Shop shop = learnt();
    Milling::Upset abort;
    abort.abort = true;
    shop.cycle(10 * um, {{1, abort}});
    EXPECT_EQ(shop.counts().accepted, 1) << "the other one was still being fitted";
    EXPECT_EQ(shop.counts().missed, 0);
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 5);
    EXPECT_EQ(shop.counts().unexpected, 0);
}

TEST(GrowthByContact, AnAbortedLearningCycleLeavesNoReference) {
    Shop shop;
    shop.mill.learn = true;
    Milling::Upset abort;
    abort.abort = true;
    shop.cycle(0, {{1, abort}});
    EXPECT_NE(shop.measured.tally().learning_fault(), LearningFault::none);
    EXPECT_FALSE(shop.measured.cycle().references().made_with(shop.mill.setup));
    shop.learn();
    EXPECT_EQ(shop.measured.tally().learning_fault(), LearningFault::none);
    EXPECT_TRUE(shop.measured.cycle().references().made_with(shop.mill.setup));
}

TEST(GrowthByContact, ALearningCycleThatLosesASignalLeavesNoReference) {
    for (double Milling::Sample::*signal :
         {&Milling::Sample::load, &Milling::Sample::z, &Milling::Sample::speed, &Milling::Sample::velocity,
          &Milling::Sample::applied_offset, &Milling::Sample::start_height,
          &Milling::Sample::feed_override}) {
        Shop shop;
        int periods = 0;
        shop.tamper = [&](Milling::Sample& s) {
            if (++periods == 5000) s.*signal = std::numeric_limits<double>::quiet_NaN();
        };
        shop.learn();
        EXPECT_NE(shop.measured.tally().learning_fault(), LearningFault::none);
    }
}

TEST(GrowthByContact, LearnTakenBackLeavesNoReference) {
    Shop taken_back;
    int periods = 0;
    taken_back.tamper = [&](Milling::Sample& s) { s.learn = ++periods < 5000; };
    taken_back.learn();
    EXPECT_NE(taken_back.measured.tally().learning_fault(), LearningFault::none);
}

TEST(GrowthByContact, ACycleIsNotJoinedInItsMiddle) {
    Shop shop;
    int periods = 0;
    shop.tamper = [&](Milling::Sample& s) { s.enable = ++periods > 4000; };
    shop.learn();
    EXPECT_EQ(shop.counts().contacts, 0);
    EXPECT_FALSE(shop.measured.cycle().references().made_with(shop.mill.setup));
}

TEST(GrowthByContact, DisablingEndsTheCycle) {
    Shop shop = learnt();
    int periods = 0;
    shop.tamper = [&](Milling::Sample& s) { s.enable = ++periods < 8000; };
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 1);
    EXPECT_EQ(shop.counts().missed, 0);
}

TEST(GrowthByContact, AProgramWithoutAReferenceIsRefusedUntilOneWithAReferenceReturns) {
    for (const Refusal reason : {Refusal::program, Refusal::tool_set}) {
        Shop shop = learnt();
        shop.cycle(10 * um);
        ASSERT_EQ(shop.counts().accepted, 4);
        std::int32_t& id = reason == Refusal::program ? shop.mill.setup.program : shop.mill.setup.tool_set;
        ++id;
        for (int n = 0; n < 2; ++n) {
            shop.cycle(10 * um);
            EXPECT_EQ(shop.measured.refusal().reason(), reason);
            EXPECT_FALSE(shop.measured.applicable());
            EXPECT_EQ(shop.counts().rejected, 4 * (n + 1));
            EXPECT_EQ(shop.counts().missed, 0) << "nothing was compared";
            EXPECT_EQ(shop.measured.tally().rejection(), Rejection::no_reference);
            shop.measured.acknowledge();
        }
        shop.cycle(10 * um);
        --id;
        shop.cycle(10 * um);
        EXPECT_EQ(shop.measured.refusal().reason(), Refusal::none);
        EXPECT_EQ(shop.counts().accepted, 8);
    }
}

TEST(GrowthByContact, WhatIsAcknowledgedInACycleIsNotComparedBeforeTheNext) {
    Shop shop = learnt();
    ++shop.mill.setup.program;
    int periods = 0;
    shop.tamper = [&](Milling::Sample& s) {
        if (++periods == 5000) shop.measured.acknowledge();
        if (periods > 5000) --s.setup.program;
        if (periods > 5001 && s.cycle_running) {
            EXPECT_FALSE(shop.measured.applicable());
        }
    };
    shop.cycle(10 * um);
    EXPECT_EQ(shop.measured.refusal().reason(), Refusal::none);
    EXPECT_EQ(shop.counts().accepted, 0);
}

TEST(GrowthByContact, AToolSetThatChangesInACycleEndsItsComparisons) {
    Shop shop = learnt();
    shop.tamper = [&](Milling::Sample& s) { s.setup.tool_set += shop.counts().accepted > 0; };
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 1);
    EXPECT_EQ(shop.counts().rejected, 3);
}

TEST(GrowthByContact, ACycleAtAnotherFeedOrOverrideRefusesTheReference) {
    Milling::Upset slow;
    slow.feed_override = 0.4;
    Shop overridden = learnt();
    overridden.cycle(10 * um, {{0, slow}, {1, slow}, {2, slow}});
    EXPECT_EQ(overridden.measured.refusal().reason(), Refusal::none) << "the last contact agreed";
    overridden.cycle(10 * um, {{0, slow}, {1, slow}, {2, slow}, {3, slow}});
    EXPECT_EQ(overridden.measured.refusal().reason(), Refusal::feed);
    EXPECT_EQ(overridden.counts().accepted, 1);
    overridden.measured.acknowledge();
    overridden.cycle(10 * um);
    EXPECT_EQ(overridden.counts().accepted, 5);

    Shop edited = learnt();
    edited.mill.feed = 0.4 * edited.mill.feed;
    edited.cycle(10 * um);
    EXPECT_EQ(edited.measured.refusal().reason(), Refusal::feed);

    Shop aborted = learnt();
    Milling::Upset abort = slow;
    abort.abort = true;
    aborted.cycle(10 * um, {{0, slow}, {1, abort}});
    EXPECT_EQ(aborted.measured.refusal().reason(), Refusal::none) << "how it would have gone on is not known";
}

TEST(GrowthByContact, WithoutAReferenceNothingIsRefused) {
    Shop shop;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.measured.refusal().reason(), Refusal::none);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::no_reference);
    EXPECT_EQ(shop.counts().rejected, 4);
    Shop forgotten = learnt();
    ++forgotten.mill.setup.program;
    forgotten.cycle(10 * um);
    forgotten.measured.forget();
    forgotten.cycle(10 * um);
    EXPECT_EQ(forgotten.measured.refusal().reason(), Refusal::none);
}

TEST(GrowthByContact, SeveralColdCyclesAreAveragedAndGiveTheirScatter) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop;
        shop.used = settings(method);
        shop.used.reference_cycles = 3;
        shop.mill.learn = true;
        for (const double growth : {0 * um, 6 * um, 12 * um}) {  // it warms
            EXPECT_EQ(shop.measured.cycle().references().size(), 0);
            shop.cycle(growth);
            EXPECT_EQ(shop.target, 0);
        }
        shop.mill.learn = false;
        const ContactReferences& references = shop.measured.cycle().references();
        ASSERT_EQ(references.size(), 4);
        for (std::int32_t i = 0; i < 4; ++i) {
            EXPECT_EQ(references[i].cycles, 3);
            EXPECT_NEAR(references[i].scatter, 6 * um, 0.3 * um);
        }
        shop.cycle(16 * um);
        ASSERT_EQ(shop.accepted.size(), 4u);
        for (const double g : shop.accepted) EXPECT_NEAR(g, 10 * um, 0.5 * um) << "from their middle";
        EXPECT_GT(shop.measured.sigma(), 6 * um);
        EXPECT_LT(shop.measured.sigma(), 9 * um);
    }
}

TEST(GrowthByContact, AChipInOneOfSeveralColdCyclesSpoilsNoMean) {
    Shop shop;
    shop.used.reference_cycles = 3;
    shop.mill.learn = true;
    Milling::Upset chip;
    chip.height = 0.2;
    shop.cycle(0);
    shop.cycle(0, {{1, chip}});
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::too_large);
    shop.cycle(0);
    EXPECT_EQ(shop.measured.cycle().references().size(), 3) << "without that contact";
    const CycleTally::Counts& n = shop.counts();
    EXPECT_EQ(n.contacts, 12);
    EXPECT_EQ(n.rejected, 1);
    shop.mill.learn = false;
    shop.cycle(10 * um);
    EXPECT_EQ(n.accepted, 3);
    EXPECT_EQ(n.unexpected, 2) << "in the third learning cycle, and now";
    for (const double g : shop.accepted) EXPECT_NEAR(g, 10 * um, 0.5 * um);
}

TEST(GrowthByContact, ReferencesRememberWhatMadeThem) {
    Shop shop;
    shop.tamper = [&](Milling::Sample& s) {
        s.temperature = 17.5;
        s.date = 20261121;
        if (s.z < -30) s.temperature = std::numeric_limits<double>::quiet_NaN();
    };
    shop.learn();
    for (std::int32_t i = 0; i < 4; ++i) {
        const ContactReference& r = shop.measured.cycle().references()[i];
        EXPECT_EQ(r.temperature, 17.5);
        EXPECT_EQ(r.date, 20261121);
        EXPECT_EQ(r.setup, shop.mill.setup);
        EXPECT_TRUE(r.valid());
    }
}

TEST(GrowthByContact, ANewOperationIsReportedAndIgnored) {
    Shop shop = learnt();
    shop.mill.program.push_back({50, 1, -30});
    shop.cycle(10 * um);
    EXPECT_EQ(shop.counts().accepted, 4);
    EXPECT_EQ(shop.counts().unexpected, 1);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::unexpected);
}

TEST(GrowthByContact, ExcludedOperationsAndNoneAreNotLookedAt) {
    Shop shop;
    shop.used.excluded = {11, 12, 13, 20};
    shop.mill.program.push_back({0, 1, -30});
    shop.learn();
    EXPECT_EQ(shop.counts().contacts, 3);
    EXPECT_EQ(shop.measured.cycle().references().size(), 3);
}

TEST(GrowthByContact, TheAgeOfTheLoadIsTakenOffTheContact) {
    Shop shop;
    shop.mill.latency = 0.05;
    shop.used.load_latency = 0.05;
    shop.learn();
    EXPECT_NEAR(shop.measured.cycle().references()[0].contact.coordinate, -20, 1 * um);
    EXPECT_NEAR(shop.measured.cycle().references()[0].contact.time, 1, 0.0005);
}

TEST(GrowthByContact, AContactIsFittedByTheTimeConstantOfItsReference) {
    Shop shop = learnt();
    const double time_constant = shop.measured.cycle().references()[0].contact.time_constant;
    EXPECT_NEAR(time_constant, 0.03, 0.002);
    shop.mill.noise = 0.3;
    shop.cycle(10 * um);
    EXPECT_EQ(shop.measured.contact().time_constant,
              shop.measured.cycle().references()[3].contact.time_constant);
}

TEST(GrowthByContact, ASofterPartShiftsNothing) {
    for (const Method method : {Method::coordinate, Method::time}) {
        Shop shop = learnt(method);
        shop.mill.step *= 0.7;
        shop.cycle(10 * um);
        ASSERT_EQ(shop.accepted.size(), 4u);
        for (const double g : shop.accepted) EXPECT_NEAR(g, 10 * um, 0.2 * um);
    }
}

// A rise of exactly the debounce time is a contact by its threshold, and none by its shape.
TEST(GrowthByContact, ARiseThatIsNoneIsRejected) {
    Shop shop = learnt();
    shop.mill.upsets = {};
    int periods = 0;
    shop.tamper = [&](Milling::Sample& s) {
        const bool short_pulse =
            s.operation == 20 && s.velocity < 0 && s.motion == 2 && s.z > -39.7 && s.z < -39.6;
        if (short_pulse) s.load += 6, ++periods;
    };
    shop.cycle(10 * um, {{1, {true}}});
    EXPECT_GT(periods, 20);
    EXPECT_EQ(shop.counts().rejected, 1);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::no_onset);
}

TEST(GrowthByContact, EveryContactIsCountedInOneWay) {
    Shop shop = learnt();
    Milling::Upset chip, slow, air;
    chip.height = 0.2;
    slow.feed_override = 0.8;
    air.air = true;
    shop.cycle(10 * um, {{0, chip}, {1, slow}});
    shop.cycle(10 * um, {{2, air}});
    shop.mill.program.push_back({50, 1, -30});
    shop.cycle(10 * um);
    const CycleTally::Counts& n = shop.counts();
    EXPECT_EQ(n.contacts, 4 + n.accepted + n.rejected + n.unexpected);
    EXPECT_EQ(n.contacts + n.missed, 4 + 4 + 4 + 5);
}

TEST(GrowthByContact, ReferencesOutliveARestart) {
    const Shop before = learnt();
    Shop after;
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(after.measured.restore(before.measured.cycle().references()[i]));
    after.cycle(50 * um);
    EXPECT_EQ(after.measured.tally().rejection(), Rejection::unconfirmed) << "the first contact alone";
    EXPECT_EQ(after.counts().accepted, 3);
    EXPECT_NEAR(after.target, 50 * um, 0.5 * um);
}

TEST(GrowthByContact, NoBadValueReachesTheGrowth) {
    const double infinity = std::numeric_limits<double>::infinity();
    for (double Milling::Sample::*signal :
         {&Milling::Sample::load, &Milling::Sample::z, &Milling::Sample::speed, &Milling::Sample::velocity,
          &Milling::Sample::applied_offset, &Milling::Sample::start_height, &Milling::Sample::feed_override})
        for (const double bad :
             {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, 1e308, -1e308}) {
            Shop shop;
            shop.mill.dt = 0.002;
            shop.used = settings(Method::time);
            shop.learn();
            int periods = 0;
            shop.tamper = [&](Milling::Sample& s) {
                EXPECT_EQ(judged(s).lost, Lost::nothing);
                if (++periods % 1000 != 0) return;
                s.*signal = bad;
                EXPECT_NE(judged(s).lost, Lost::nothing);
            };
            shop.cycle(10 * um);
            shop.tamper = [](auto&) {};
            shop.cycle(10 * um);
            EXPECT_GE(shop.accepted.size(), 4u);
            for (const double g : shop.accepted) EXPECT_NEAR(g, 10 * um, 1 * um);
            EXPECT_TRUE(std::isfinite(shop.measured.sigma()));
        }
}

// Learned from, one contact at 5 um, then ten minutes at a speed of which much growth is to be expected.
Shop predicting(bool by_speed = true) {
    Shop shop;
    shop.used.by_speed = by_speed;
    shop.used.max_growth_rate = 0.01 * um;
    shop.used.unexplained_growth = 6 * um;
    shop.learn();
    shop.cycle(5 * um);
    Milling::Sample turning;
    turning.enable = true;
    turning.speed = 20000;
    for (int i = 0; i < 600; ++i) shop.measured.step(judged(turning), shop.used, 1);
    return shop;
}

TEST(GrowthByContact, GrowthIsUncertainAfterLongAtAnotherSpeedUntilTheNextContacts) {
    EXPECT_TRUE(Shop().measured.uncertain(settings()));
    Shop shop = predicting();
    EXPECT_TRUE(shop.measured.uncertain(shop.used));
    shop.cycle(6 * um);
    EXPECT_FALSE(shop.measured.uncertain(shop.used));
}

TEST(GrowthByContact, EstimateIsTheLastContactAndBySpeedWhatHasComeSince) {
    const Shop holds = predicting(false), follows = predicting();
    EXPECT_NEAR(holds.measured.filter().growth(), 5 * um, 0.5 * um);
    EXPECT_GT(follows.measured.filter().growth(), 15 * um);
    EXPECT_GT(follows.measured.filter().sigma(follows.used), 3 * um);
}

TEST(GrowthByContact, AtASpeedBeyondAllContactsThePredictionIsNotApplied) {
    const Shop shop = predicting();
    EXPECT_GT(shop.measured.filter().sigma(shop.used), 15 * um);
    EXPECT_LE(std::abs(shop.measured.filter().offset()), shop.accepted.back() + 1 * um);
    EXPECT_NE(shop.measured.filter().doubt(), Doubt::none);
}

TEST(GrowthByContact, PredictionLetsNothingThroughTheGate) {
    Shop shop = predicting();
    const auto before = shop.accepted.size();
    shop.cycle(-60 * um);
    EXPECT_EQ(shop.accepted.size(), before);
    EXPECT_EQ(shop.measured.tally().rejection(), Rejection::beyond_gate);
}

TEST(GrowthByContact, AfterAnotherSpeedAContactFarFromThePredictionCounts) {
    Shop shop = predicting();
    shop.mill.program = {{10, 1, -20}};
    shop.cycle(-5 * um);  // 10 from the last contact, and much more from the prediction
    EXPECT_NEAR(shop.accepted.back(), -5 * um, 0.5 * um);
    EXPECT_EQ(shop.measured.filter().shift(shop.used), Shift::none);
}

TEST(GrowthByContact, PredictsNothingBeforeAContactWasAccepted) {
    Shop shop = predicting();
    shop.measured.forget();
    EXPECT_FALSE(shop.measured.known());
}

}  // namespace
}  // namespace plumb
