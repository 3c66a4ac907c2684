// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/growth_filter.hpp"

#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

GrowthFilter::Settings at_speeds() {
    GrowthFilter::Settings settings;
    settings.by_speed = true;
    return settings;
}

// Cycles of a machine at rest, a minute apart, with gauges of two tools: 0 and 1 of tool 1, 2 of tool 2.
struct Machine {
    GrowthFilter::Settings settings = at_speeds();
    GrowthFilter filter{};
    double noise = 0.5 * um, reference_sigma = 0.5 * um;
    std::int32_t cycle = 0;
    bool other_tools = true;
    GrowthFilter::Machine now{};

    Machine() {
        step(1);
        filter.begin_at(0, 0.5 * um, settings);
        filter.renew_gauges();
    }

    void step(double seconds) {
        for (double t = 0; t < seconds; ++t) {
            filter.predict(now, settings, 1);
            filter.apply(now, settings, 1);
        }
    }
    void begin() {
        ++cycle;
        step(60);
    }
    std::array<double, 3> feeds{-1.6, -1.6, -1.6};  // mm/s

    Rejection contact(int gauge, double growth, double step = 0) {
        GrowthFilter::Reading r;
        r.growth = growth;
        r.noise = noise;
        r.reference_sigma = reference_sigma;
        r.step = step;
        r.gauge = gauge;
        r.of_tool = gauge < 2 ? 3 : 4;
        r.other_tools = other_tools;
        r.feed = feeds[gauge];
        r.cycle = cycle;
        const Rejection why = filter.judge(r, settings);
        filter.apply(now, settings, 1);
        return why;
    }
    // Cycles in which the gauges show this.
    void cycles(int count, double first, double second, double third) {
        for (int n = 0; n < count; ++n) {
            begin();
            contact(0, first);
            contact(1, second);
            contact(2, third);
        }
    }
};

TEST(GrowthFilter, ManyContactsOfOneGaugeAreNoMoreCertainThanItsReference) {
    Machine machine;
    machine.reference_sigma = 10 * um;
    for (int n = 0; n < 200; ++n) {
        machine.begin();
        machine.contact(0, 0);
    }
    const double one = machine.filter.sigma(machine.settings);
    EXPECT_GT(one, 0.9 * um) << "the growth is no more certain than the learning cycle";
    Machine far;
    far.filter.forget();
    far.reference_sigma = 10 * um;
    for (int n = 0; n < 200; ++n) {
        far.begin();
        far.contact(0, 5 * um);
    }
    EXPECT_GT(far.filter.sigma(far.settings), 9 * um);
    for (int n = 0; n < 200; ++n) {
        far.begin();
        far.contact(0, 5 * um);
        far.contact(2, 5 * um);
    }
    EXPECT_LT(far.filter.sigma(far.settings), 8.5 * um) << "two references have less in common";
    EXPECT_GT(far.filter.sigma(far.settings), 6.5 * um);
}

// By the answer that the shift is none.
double if_shift(const GrowthFilter& its) {
    return its.growth() - (its.probability() > 0.5 ? its.shift_size() : 0);
}

TEST(GrowthFilter, AShiftOfAllContactsIsAskedAboutAndHarmsNoPartEitherWay) {
    for (const double grown : {0.0, 12 * um, -12 * um, 40 * um})
        for (const double shift : {-50 * um, -25 * um, 20 * um, 30 * um}) {
            SCOPED_TRACE(testing::Message() << grown << ' ' << shift);
            Machine machine;
            for (int n = 1; n <= 10; ++n) {
                machine.step(300);
                machine.cycles(2, 0.1 * n * grown, 0.1 * n * grown, 0.1 * n * grown);
            }
            const auto moved = [&](double more) {
                const double z = grown + shift + more;
                machine.cycles(1, z, z, z);
                EXPECT_EQ(machine.filter.shift(machine.settings), Shift::all);
                EXPECT_NEAR(machine.filter.shift_size(), shift, 3 * um);
                EXPECT_NEAR(if_shift(machine.filter), grown + more, 2 * um);
                for (const double truth : {grown + more, z})
                    EXPECT_LE(std::abs(machine.filter.offset() - truth), std::abs(truth) + 5 * um);
                EXPECT_EQ(machine.filter.doubt(), Doubt::shift);
            };
            moved(0);
            for (int n = 0; n < 20; ++n) moved(2 * um);  // nobody answers
            machine.cycles(4, grown, grown, grown);
            EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none) << "the contacts are back";
            EXPECT_NEAR(machine.filter.growth(), grown, 2 * um);
        }
}

// Another fixture while the question of other blanks is open.
TEST(GrowthFilter, AFurtherMoveIsAPartOfTheQuestionThatIsOpen) {
    for (const double first : {-14 * um, 20 * um}) {
        Machine machine;
        for (int n = 1; n <= 20; ++n) machine.cycles(2, n * um, n * um, n * um);
        for (int n = 0; n < 3; ++n) machine.cycles(1, 20 * um + first, 20 * um + first, 20 * um + first);
        ASSERT_EQ(machine.filter.shift(machine.settings), Shift::all) << first;
        const double z = 20 * um + first + 50 * um;
        for (int n = 0; n < 20; ++n) {
            machine.cycles(1, z, z, z);
            EXPECT_EQ(machine.filter.shift(machine.settings), Shift::all);
            for (const double truth : {20 * um, z})
                EXPECT_LE(std::abs(machine.filter.offset() - truth), std::abs(truth) + 5 * um) << first;
        }
        EXPECT_NEAR(machine.filter.shift_size(), first + 50 * um, 3 * um);
    }
}

// The first tool of a part has moved. Whether the second has too, it shows itself.
TEST(GrowthFilter, OneToolIsAskedAboutOnceAnotherHasStood) {
    for (const bool both : {false, true}) {
        Machine machine;
        machine.cycles(4, 0, 0, 0);
        machine.begin();
        machine.contact(0, 30 * um);
        machine.contact(1, 30 * um);
        EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
        machine.contact(2, both ? 30 * um : 0);
        EXPECT_EQ(machine.filter.shift(machine.settings), both ? Shift::all : Shift::one_tool);
    }
}

TEST(GrowthFilter, TheAnswersToAShift) {
    Machine growth, other;
    for (Machine* machine : {&growth, &other}) {
        machine->cycles(5, 0, 0, 0);
        machine->cycles(2, 20 * um, 20 * um, 20 * um);
        ASSERT_EQ(machine->filter.shift(machine->settings), Shift::all);
    }
    growth.filter.shift_is_growth();
    EXPECT_EQ(growth.filter.shift(growth.settings), Shift::none);
    EXPECT_NEAR(growth.filter.growth(), 20 * um, 1 * um);
    growth.cycles(2, 20 * um, 20 * um, 20 * um);
    EXPECT_EQ(growth.filter.shift(growth.settings), Shift::none);
    EXPECT_NEAR(growth.filter.growth(), 20 * um, 1 * um);
    EXPECT_NEAR(other.filter.displaced(0, -1.6), 20 * um, 1 * um);
    other.filter.shift_is_corrected();
    EXPECT_EQ(other.filter.shift(other.settings), Shift::none);
    other.cycles(2, 0, 0, 0);  // against references that were corrected
    EXPECT_EQ(other.filter.shift(other.settings), Shift::none);
    EXPECT_NEAR(other.filter.growth(), 0, 1 * um);
}

constexpr std::int32_t probe = 9;  // a tool
constexpr double setter = -200;    // mm, height of a fixed surface

TEST(GrowthFilter, AFixedSurfaceAnswersAShift) {
    for (const bool is_growth : {false, true})
        for (const double shift : {20 * um, -20 * um}) {
            Machine machine;
            const auto check = [&](double grown) {
                return machine.filter.check(setter + grown, probe, false, machine.settings);
            };
            machine.cycles(3, 5 * um, 5 * um, 5 * um);
            EXPECT_EQ(check(5 * um), SurfaceCheck::first);
            machine.cycles(3, 8 * um, 8 * um, 8 * um);
            EXPECT_EQ(check(8 * um), SurfaceCheck::growth);
            const double z = 8 * um + shift;
            machine.cycles(2, z, z, z);
            ASSERT_EQ(machine.filter.shift(machine.settings), Shift::all);
            EXPECT_EQ(check(150 * um), SurfaceCheck::unlike) << "a chip on it";
            ASSERT_EQ(machine.filter.shift(machine.settings), Shift::all);
            EXPECT_EQ(check(is_growth ? z : 8 * um),
                      is_growth ? SurfaceCheck::is_growth : SurfaceCheck::is_no_growth);
            EXPECT_NEAR(if_shift(machine.filter), is_growth ? z : 8 * um, 2 * um);
            if (!is_growth) {
                EXPECT_NEAR(machine.filter.displaced(0, -1.6), shift, 2 * um)
                    << "for the references to follow";
                machine.filter.shift_is_corrected();
            }
            EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
            const double now = is_growth ? z : 8 * um;
            machine.cycles(2, now, now, now);
            EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
            EXPECT_NEAR(machine.filter.growth(), now, 1 * um);
            EXPECT_EQ(check(now), SurfaceCheck::growth);
        }
}

// Half of a shift speaks for neither answer.
TEST(GrowthFilter, AFixedSurfaceThatDoesNotDecideMovesOnlyTheProbability) {
    Machine machine;
    machine.settings.surface_repeatability = 6 * um;
    machine.cycles(3, 0, 0, 0);
    machine.filter.check(setter, probe, false, machine.settings);
    machine.cycles(2, 20 * um, 20 * um, 20 * um);
    const double before = machine.filter.probability();
    EXPECT_EQ(machine.filter.check(setter + 13 * um, probe, false, machine.settings),
              SurfaceCheck::undecided);
    EXPECT_GT(machine.filter.probability(), before);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::all);
    machine.filter.check(setter + 20 * um, probe, false, machine.settings);
    EXPECT_EQ(machine.filter.check(setter + 20 * um, probe, false, machine.settings),
              SurfaceCheck::is_growth);
}

TEST(GrowthFilter, ALongerToolShowsOnAFixedSurfaceAndIsNoGrowth) {
    for (const double moved : {0.0, 30 * um}) {  // of a tool on the surface
        for (const bool asked : {false, true}) {
            Machine machine;
            machine.cycles(3, 0, 0, 0);
            machine.filter.check(setter, 2, asked, machine.settings);
            machine.cycles(4, 0, 0, 30 * um);
            ASSERT_EQ(machine.filter.shift(machine.settings), Shift::one_tool);
            EXPECT_TRUE(machine.filter.asks_of_tool(2));
            EXPECT_FALSE(machine.filter.asks_of_tool(0));
            const auto found = machine.filter.check(setter + moved, 2, asked, machine.settings);
            EXPECT_EQ(found, asked || moved == 0 ? SurfaceCheck::is_no_growth : SurfaceCheck::unlike);
            if (found == SurfaceCheck::is_no_growth) machine.filter.shift_is_corrected();
            if (!asked) continue;
            EXPECT_EQ(machine.filter.check(setter + moved, 2, false, machine.settings), SurfaceCheck::growth);
            EXPECT_NEAR(machine.filter.growth(), 0, 1 * um);
        }
    }
}

// A longer tool moves on the surface as growth does.
TEST(GrowthFilter, TheOnlyToolOfAProgramProvesNoGrowthOnAFixedSurface) {
    for (const bool moved : {false, true}) {
        Machine machine;
        machine.other_tools = false;
        const auto both = [&](double z) {
            machine.begin();
            for (const int gauge : {0, 1}) machine.contact(gauge, z);
        };
        for (int n = 0; n < 3; ++n) both(0);
        machine.filter.check(setter, 1, false, machine.settings);
        for (int n = 0; n < 2; ++n) both(20 * um);
        ASSERT_EQ(machine.filter.shift(machine.settings), Shift::only_tool);
        EXPECT_TRUE(machine.filter.asks_of_tool(0));
        EXPECT_EQ(machine.filter.check(setter + (moved ? 20 * um : 0), 1, true, machine.settings),
                  moved ? SurfaceCheck::undecided : SurfaceCheck::is_no_growth);
    }
}

TEST(GrowthFilter, AGaugeToolThatMovesWhileContactsStandBeginsAnew) {
    Machine machine;
    const auto check = [&](double moved) {
        return machine.filter.check(setter + moved, probe, false, machine.settings);
    };
    machine.cycles(3, 0, 0, 0);
    check(0);
    for (int n = 0; n < 2; ++n) EXPECT_EQ(check(30 * um), SurfaceCheck::unlike) << "it may be growth";
    machine.cycles(1, 0, 0, 0);
    EXPECT_EQ(check(30 * um), SurfaceCheck::first);
    machine.cycles(1, 3 * um, 3 * um, 3 * um);
    EXPECT_EQ(check(33 * um), SurfaceCheck::growth);
    EXPECT_NEAR(machine.filter.growth(), 3 * um, 1 * um);
}

TEST(GrowthFilter, AFixedSurfaceMeasuresTheGrowthBetweenParts) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    machine.filter.check(setter, probe, false, machine.settings);
    machine.step(8 * 3600);
    EXPECT_EQ(machine.filter.check(setter - 25 * um, probe, false, machine.settings), SurfaceCheck::growth);
    EXPECT_NEAR(machine.filter.growth(), -25 * um, 3 * um);
    EXPECT_LE(machine.filter.gate(machine.settings), machine.settings.floor) << "it is known again";
    machine.cycles(1, -25 * um, -25 * um, -25 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
    EXPECT_NEAR(machine.filter.growth(), -25 * um, 1 * um);
}

TEST(GrowthFilter, AnotherOriginLeavesTheFixedSurfaceAndANewReferenceForgetsIt) {
    Machine machine;
    EXPECT_FALSE(machine.filter.has_surface());
    machine.cycles(3, 4 * um, 4 * um, 4 * um);
    machine.filter.check(setter, probe, false, machine.settings);
    EXPECT_TRUE(machine.filter.has_surface());
    machine.filter.displace(-40 * um);
    EXPECT_EQ(machine.filter.check(setter, probe, false, machine.settings), SurfaceCheck::growth);
    EXPECT_NEAR(machine.filter.growth(), -36 * um, 1 * um);
    machine.filter.begin_at(0, 1 * um, machine.settings);
    EXPECT_FALSE(machine.filter.has_surface());
    machine.filter.forget();
    EXPECT_EQ(machine.filter.check(setter, probe, false, machine.settings), SurfaceCheck::unknown);
}

// Five tools on four places.
TEST(GrowthFilter, EachToolHasItsOwnHeightOfAFixedSurface) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    const auto check = [&](std::int32_t tool) {
        return machine.filter.check(setter + tool, tool, false, machine.settings);
    };
    for (const int tool : {0, 1, 2, 3}) EXPECT_EQ(check(tool), SurfaceCheck::first);
    for (const int tool : {0, 1, 2, 3}) EXPECT_EQ(check(tool), SurfaceCheck::growth);
    EXPECT_EQ(check(4), SurfaceCheck::first);
    for (const int tool : {0, 1, 2, 4}) EXPECT_EQ(check(tool), SurfaceCheck::growth);
    EXPECT_EQ(check(3), SurfaceCheck::first) << "it gave way to tool 4";
}

TEST(GrowthFilter, AnAnswerWithoutAShiftChangesNothing) {
    Machine machine;
    machine.cycles(3, 2 * um, 2 * um, 2 * um);
    const double before = machine.filter.growth();
    machine.filter.shift_is_growth();
    EXPECT_EQ(machine.filter.growth(), before);
}

TEST(GrowthFilter, AShiftOfTheOnlyToolMayHaveAnyCause) {
    Machine machine;
    const auto contact = [&](double growth) {
        machine.begin();
        GrowthFilter::Reading r;
        r.growth = growth;
        r.noise = r.reference_sigma = 0.5 * um;
        r.gauge = 0;
        r.of_tool = 1;
        r.cycle = machine.cycle;
        machine.filter.judge(r, machine.settings);
    };
    for (int n = 0; n < 5; ++n) contact(0);
    for (int n = 0; n < 3; ++n) contact(30 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::only_tool);
    EXPECT_NEAR(if_shift(machine.filter), 0, 1 * um);
}

// A pure delay shifts a contact by its feed: at one feed that is like other work.
TEST(GrowthFilter, AnotherDelayOfTheLoadIsNamedAtTwoFeeds) {
    constexpr double delay = 0.015;  // s
    for (const bool two_feeds : {false, true})
        for (const bool is_growth : {false, true}) {
            Machine machine;
            if (two_feeds) machine.feeds[1] = -0.8;
            machine.cycles(5, 0, 0, 0);
            const auto at = [&](int gauge) { return delay * machine.feeds[gauge] + 2 * um; };
            machine.cycles(10, at(0), at(1), at(2));
            GrowthFilter& filter = machine.filter;
            EXPECT_EQ(filter.shift(machine.settings), two_feeds ? Shift::by_feed : Shift::all);
            EXPECT_NEAR(filter.shift_size(), delay * -1.6, 3 * um);
            EXPECT_NEAR(if_shift(filter), 0, 3 * um);
            EXPECT_NEAR(filter.displaced(0, -0.4), two_feeds ? delay * -0.4 : delay * -1.6, 3 * um);
            if (is_growth) {
                filter.shift_is_growth();
                EXPECT_NEAR(filter.growth(), at(0), 2 * um);
                continue;
            }
            const double left = at(1) - filter.displaced(1, machine.feeds[1]);
            filter.shift_is_corrected();
            EXPECT_EQ(filter.shift(machine.settings), Shift::none);
            machine.cycles(4, left, left, left);
            EXPECT_EQ(filter.shift(machine.settings), Shift::none);
            EXPECT_NEAR(filter.growth(), left, 1 * um);
        }
}

TEST(GrowthFilter, OtherWorkIsNoDelayAtTwoFeeds) {
    Machine machine;
    machine.feeds = {-1.6, -0.8, -1.2};
    machine.cycles(5, 0, 0, 0);
    machine.cycles(3, 25 * um, 25 * um, 25 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::all);
    EXPECT_NEAR(machine.filter.shift_size(), 25 * um, 2 * um);
}

TEST(GrowthFilter, AChangeAfterAnotherSpeedIsGrowth) {
    Machine machine;
    machine.cycles(5, 0, 0, 0);
    machine.now.speed = 6000;
    machine.step(300);
    machine.contact(0, 25 * um);
    machine.contact(2, 25 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
    EXPECT_NEAR(machine.filter.growth(), 25 * um, 2 * um);
}

TEST(GrowthFilter, AMachineThatOftenGrowsFastIsAskedLess) {
    Machine quiet, lively;
    quiet.cycles(40, 0, 0, 0);
    for (int n = 0; n < 20; ++n) {
        lively.cycles(1, 0, 0, 0);
        lively.cycles(1, 6 * um, 6 * um, 6 * um);
    }
    quiet.cycles(1, 14 * um, 14 * um, 14 * um);
    lively.cycles(1, 14 * um, 14 * um, 14 * um);
    EXPECT_EQ(quiet.filter.shift(quiet.settings), Shift::all);
    EXPECT_EQ(lively.filter.shift(lively.settings), Shift::none);
}

TEST(GrowthFilter, AChipShiftsNothing) {
    Machine machine;
    machine.begin();
    EXPECT_EQ(machine.contact(0, 40 * um), Rejection::beyond_gate);
    EXPECT_EQ(machine.contact(2, 0), Rejection::none);
    machine.begin();
    EXPECT_EQ(machine.contact(0, 0), Rejection::none);
    EXPECT_NEAR(machine.filter.growth(), 0, 1 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
}

TEST(GrowthFilter, AfterAStartTheContactsDecideAmongEachOther) {
    Machine machine;
    machine.filter.forget();
    machine.begin();
    EXPECT_EQ(machine.contact(0, 40 * um), Rejection::unconfirmed);
    EXPECT_FALSE(machine.filter.known());
    machine.contact(2, 3 * um);
    machine.contact(1, 3 * um);
    EXPECT_NEAR(machine.filter.growth(), 3 * um, 1 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
}

TEST(GrowthFilter, ALongerToolIsAskedAboutAndMovesNothing) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    machine.cycles(4, 0, 0, 30 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::one_tool);
    EXPECT_NEAR(machine.filter.shift_size(), 30 * um, 1 * um);
    EXPECT_NEAR(machine.filter.growth(), 0, 1 * um);
    machine.filter.shift_is_growth();
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::one_tool) << "the others stand: it is no answer";
    machine.cycles(4, 0, 0, 30 * um);
    EXPECT_NEAR(machine.filter.shift_size(), 30 * um, 1 * um);
    machine.filter.renew_gauges();
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none) << "it was learned again";
}

TEST(GrowthFilter, AnotherProgramKnowsTheGrowthAndNotTheWearOfTheTools) {
    Machine machine;
    machine.reference_sigma = 4 * um;
    for (int n = 1; n <= 20; ++n) machine.cycles(1, n * um / 4, n * um / 4, -n * um / 4);  // tool 2 wears
    const double known = machine.filter.growth();
    machine.filter.learned_by_growth(1, machine.settings);
    EXPECT_EQ(machine.filter.growth(), known);
    for (int n = 0; n < 2; ++n) {
        machine.cycles(1, known, known, known);  // of other gauges, with the same numbers
        EXPECT_NEAR(machine.filter.growth(), known, 0.01 * um);
        machine.filter.use(0);
        machine.filter.use(1);
    }
}

TEST(GrowthFilter, AWithdrawnGaugeStaysWithdrawnWhenItsProgramReturns) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    machine.begin();
    ASSERT_EQ(machine.contact(2, 20 * um, 20 * um), Rejection::withdrawn);
    machine.filter.use(1);
    EXPECT_FALSE(machine.filter.withdrawn(2)) << "of another program";
    machine.filter.use(0);
    EXPECT_TRUE(machine.filter.withdrawn(2));
    machine.filter.learned_by_growth(0, machine.settings);
    EXPECT_FALSE(machine.filter.withdrawn(2)) << "it was learned again";
}

TEST(GrowthFilter, LearningUnderAQuestionKeepsTheGrowthThatIsSubtracted) {
    bool likely = false, unlikely = false;
    for (double size = 6 * um; size < 40 * um; size += 1 * um) {
        Machine machine;
        machine.cycles(3, 0, 0, 0);
        machine.step(300);  // growth has had time
        machine.cycles(1, size, size, size);
        if (machine.filter.shift(machine.settings) == Shift::none) continue;
        (machine.filter.probability() > 0.5 ? likely : unlikely) = true;
        const double subtracted = machine.filter.growth();
        machine.filter.learned_by_growth(1, machine.settings);
        EXPECT_NEAR(machine.filter.growth(), subtracted, 1e-12) << size;
        EXPECT_GT(machine.filter.common_sigma(1), 0.4 * size) << "the other answer counts";
    }
    EXPECT_TRUE(likely && unlikely);
}

TEST(GrowthFilter, AContactOfAnEarlierProgramCorrectsTheGrowthOfALaterOne) {
    Machine machine;
    machine.noise = 2 * um;
    machine.cycles(3, 3 * um, 3 * um, 3 * um);
    machine.filter.learned_by_growth(1, machine.settings);  // it has grown by 1 um in truth
    EXPECT_GT(machine.filter.common_sigma(1), 0.5 * um);
    const double error = machine.filter.growth() - 1 * um;
    ASSERT_GT(error, 1 * um);
    machine.cycles(3, 1 * um + error, 1 * um + error, 1 * um + error);
    EXPECT_NEAR(machine.filter.growth() - 1 * um, error, 0.1 * um) << "its own contacts cannot know";
    machine.filter.use(0);
    machine.noise = 0.3 * um;
    machine.cycles(6, 1 * um, 1 * um, 1 * um);
    machine.filter.use(1);
    machine.cycles(1, 1 * um + error, 1 * um + error, 1 * um + error);
    EXPECT_LT(std::abs(machine.filter.growth() - 1 * um), error / 2);
}

TEST(GrowthFilter, BothGaugesOfALongerToolShiftAlike) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    machine.cycles(4, 25 * um, 25 * um, 0);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::one_tool);
    EXPECT_NEAR(machine.filter.growth(), 0, 1 * um);
}

TEST(GrowthFilter, BeyondTheGateNothingIsGrowthHoweverOftenItIsClaimed) {
    Machine machine;
    for (int n = 0; n < 20; ++n) {
        machine.begin();
        for (const int gauge : {0, 1, 2}) machine.contact(gauge, 50 * um);
    }
    EXPECT_EQ(machine.filter.offset(), 0);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::all);
}

// The speed does not explain it, so that all of it shows in the errors of the contacts.
TEST(GrowthFilter, GrowthInEachPartIsNoScatter) {
    Machine machine;
    Random random(3);
    for (int n = 1; n <= 30; ++n) {
        machine.begin();
        machine.contact(0, 3 * um * std::clamp(n - 5, 0, 20) + 0.5 * um * random.gaussian());
    }
    EXPECT_NEAR(machine.filter.offset(), 60 * um, 3 * um);
    EXPECT_LT(machine.filter.apart(), 3 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
}

TEST(GrowthFilter, ContactsThatScatterMoreThanTheirNoiseWidenSigma) {
    Machine clean, rough;
    Random random(3);
    for (int n = 0; n < 100; ++n) {
        clean.begin();
        rough.begin();
        clean.contact(0, 0.5 * um * random.gaussian());
        rough.contact(0, 6 * um * random.gaussian());
    }
    EXPECT_LT(clean.filter.sigma(clean.settings), 1.5 * um);
    EXPECT_GT(rough.filter.sigma(rough.settings), 1.3 * clean.filter.sigma(clean.settings));
    EXPECT_LT(std::abs(rough.filter.growth()), 3 * rough.filter.sigma(rough.settings));
}

TEST(GrowthFilter, AChipThatMayBeGrowthHarmsNoPart) {
    Machine machine;
    machine.cycles(5, 0, 0, 0);
    machine.now.speed = 6000;
    machine.step(3600);
    machine.begin();
    EXPECT_EQ(machine.contact(0, 38 * um), Rejection::none) << "its growth at that speed is not known yet";
    machine.contact(1, 12 * um);
    machine.contact(2, 12 * um);
    EXPECT_LE(std::abs(machine.filter.offset() - 12 * um), 17 * um);
    EXPECT_NE(machine.filter.doubt(), Doubt::none);
}

TEST(GrowthFilter, NoiseIsNoFastGrowth) {
    Machine quiet;
    Random random(5);
    quiet.noise = quiet.reference_sigma = 10 * um;
    for (int n = 0; n < 300; ++n) {
        quiet.begin();
        quiet.contact(0, 10 * um * random.gaussian());
    }
    const double before = quiet.filter.growth();
    quiet.begin();
    quiet.contact(0, before + 25 * um);
    EXPECT_LT(quiet.filter.growth() - before, 2.5 * um) << "one contact in so much noise moves little";
}

TEST(GrowthFilter, AGaugeThatMovesWithAStepOnPurposeIsWithdrawn) {
    Machine machine;
    machine.cycles(3, 0, 0, 0);
    machine.begin();
    machine.contact(0, 0, 20 * um);
    EXPECT_EQ(machine.contact(2, 20 * um, 20 * um), Rejection::withdrawn);
    EXPECT_TRUE(machine.filter.withdrawn(2));
    EXPECT_FALSE(machine.filter.withdrawn(0));
    EXPECT_EQ(machine.contact(2, 0), Rejection::withdrawn);
    machine.step(1);
    EXPECT_EQ(machine.filter.doubt(), Doubt::program_event);
}

TEST(GrowthFilter, WithoutAStepOnPurposeNoGaugeIsAccused) {
    Machine machine;
    for (int n = 0; n < 60; ++n) {
        machine.begin();
        for (const int gauge : {0, 1, 2})
            machine.contact(gauge, 0.5 * um * n);  // as the offset that follows it
    }
    EXPECT_FALSE(machine.filter.withdrawn(0));
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
}

// Seats and blanks scatter by 3 um, where 1 um is expected.
TEST(GrowthFilter, KnowsHowFarACutMayBeFromItsContacts) {
    for (const double noise : {0.3 * um, 12 * um}) {
        Machine machine;
        Random random(3);
        machine.noise = noise;
        machine.reference_sigma = std::hypot(noise, 1 * um);
        double squares = 0, expected = 0;
        for (int part = 1; part <= 200; ++part) {
            machine.step(240);
            machine.begin();
            const double cut = machine.filter.growth() - 3 * um * random.gaussian();
            const double sigma = std::hypot(machine.filter.sigma(machine.settings), machine.filter.apart());
            if (part > 50) {
                squares += cut * cut;
                expected += sigma * sigma;
            }
            machine.contact(0, 3 * um * random.gaussian() + noise * random.gaussian());
        }
        EXPECT_GT(expected, 0.7 * squares) << noise;
        EXPECT_LT(expected, 4 * squares) << noise;
    }
}

// The letter of the source: contacts that agree give the whole displacement.
TEST(GrowthFilter, AppliesTheWholeDisplacementOfCleanContacts) {
    for (const double grown : {10 * um, -9 * um}) {
        Machine machine;
        Random random(7);
        machine.cycles(8, 0, 0, 0);
        for (int part = 0; part < 3; ++part) {
            machine.step(240);
            machine.begin();
            for (const int gauge : {0, 1, 2}) machine.contact(gauge, grown + 0.3 * um * random.gaussian());
        }
        EXPECT_NEAR(machine.filter.offset(), grown, 1 * um);
    }
}

TEST(GrowthFilter, WithoutSpeedTheLastContactHolds) {
    Machine machine;
    machine.settings.by_speed = false;
    machine.step(1);
    machine.filter.begin_at(0, 0.5 * um, machine.settings);
    for (const double grown : {3 * um, 8 * um, 12 * um}) {
        machine.step(240);
        machine.begin();
        machine.contact(0, grown);
        EXPECT_NEAR(machine.filter.growth(), grown, 0.1 * um);
    }
}

TEST(GrowthFilter, ALostSpeedHoldsAndAfterAMinuteNothingIsKnown) {
    Machine machine;
    machine.cycles(3, 2 * um, 2 * um, 2 * um);
    machine.now.speed = std::numeric_limits<double>::quiet_NaN();
    machine.step(59);
    EXPECT_TRUE(machine.filter.known());
    machine.step(2);
    EXPECT_FALSE(machine.filter.known());
    machine.now.speed = 0;
    machine.cycles(1, 2 * um, 2 * um, 2 * um);
    EXPECT_TRUE(machine.filter.known());
}

// A quarter of a kelvin in each part, 4 um/K.
TEST(GrowthFilter, ATemperatureIsLearntAndHeldWhenItIsLost) {
    Machine machine;
    machine.now.temperature_valid = true;
    double grown = 0;
    for (int part = 0; part < 40; ++part) {
        machine.now.temperature = 20 + 0.25 * (part % 8);
        machine.step(240);
        grown = 4 * um * (machine.now.temperature - 20);
        machine.cycles(1, grown, grown, grown);
    }
    machine.now.temperature = 21;
    machine.step(300);
    EXPECT_NEAR(machine.filter.growth(), 4 * um, 1.5 * um) << "before a contact has shown it";
    const double before = machine.filter.growth();
    machine.now.temperature_valid = false;
    machine.step(599);
    EXPECT_EQ(machine.filter.growth(), before);
}

TEST(GrowthFilter, InACycleALossOfCertaintyMovesNothing) {
    Machine machine;
    for (int n = 1; n <= 20; ++n) {
        machine.step(240);
        machine.cycles(1, 2 * n * um, 2 * n * um, 2 * n * um);
    }
    machine.now.in_cycle = true;
    machine.step(1);
    const double before = machine.filter.offset();
    EXPECT_NEAR(before, 40 * um, 2 * um);
    machine.step(7200);
    EXPECT_NEAR(machine.filter.offset(), before, 1e-9);
    machine.now.in_cycle = false;
    machine.step(1);
    EXPECT_LT(machine.filter.offset(), before - 5 * um);
}

TEST(GrowthFilter, WithoutContactsThatCountTheOffsetHoldsAndReturnsAfterTheHoldTime) {
    Machine machine;
    for (int n = 1; n <= 20; ++n) {
        machine.step(240);
        machine.cycles(1, n * um, n * um, n * um);
    }
    machine.now.barren = true;
    machine.step(1);
    const double before = machine.filter.offset();
    EXPECT_EQ(machine.filter.doubt(), Doubt::missed);
    machine.step(1790);
    EXPECT_EQ(machine.filter.offset(), before);
    machine.step(910);
    EXPECT_NEAR(machine.filter.offset(), before / 2, 0.5 * um);
    EXPECT_EQ(machine.filter.doubt(), Doubt::old);
    machine.step(900);
    EXPECT_EQ(machine.filter.offset(), 0);
}

TEST(GrowthFilter, AnotherOriginMovesTheGrowthOnce) {
    Machine machine;
    for (int n = 1; n <= 10; ++n) machine.cycles(2, n * um, n * um, n * um);
    const double before = machine.filter.growth();
    machine.filter.displace(-6 * um);
    EXPECT_NEAR(machine.filter.growth(), before - 6 * um, 1e-12);
    machine.cycles(2, 4 * um, 4 * um, 4 * um);
    EXPECT_NEAR(machine.filter.growth(), 4 * um, 1 * um);
    EXPECT_EQ(machine.filter.shift(machine.settings), Shift::none);
}

TEST(GrowthFilter, StaysSoundForAWeekWithEachOfItsGauges) {
    Machine machine;
    Random random(9);
    for (int part = 0; part < 2000; ++part) {
        machine.now.speed = random.index(2) ? random.uniform(0, 20000) : 0;
        machine.now.temperature_valid = random.index(3) > 0;
        machine.now.temperature = random.uniform(10, 40);
        machine.step(5);
        for (double t = 0; t < 300; t += 60) machine.filter.predict(machine.now, machine.settings, 60);
        machine.begin();
        GrowthFilter::Reading r;
        r.gauge = part % 64;
        r.of_tool = std::uint64_t{1} << r.gauge;
        r.other_tools = true;
        r.feed = -1.6;
        r.cycle = machine.cycle;
        r.noise = r.reference_sigma = random.uniform(0, 10 * um);
        r.growth = random.uniform(-60 * um, 60 * um);
        machine.filter.judge(r, machine.settings);
        ASSERT_TRUE(std::isfinite(machine.filter.growth()));
        ASSERT_TRUE(std::isfinite(machine.filter.sigma(machine.settings)));
        ASSERT_LE(std::abs(machine.filter.offset()), 1);
    }
}

}  // namespace
}  // namespace plumb
