// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/settings.hpp"

#include "hal/component.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

namespace plumb {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Pins in plain memory, of an inch machine.
struct Pins final : hal::Registrar {
    struct Cell {
        alignas(8) unsigned char value[8] = {};
        void* place = value;
    };

    hal::Slot add(const hal::PinInfo& pin) override { return hal::Slot(&cells[pin.name].place); }
    void add(hal::Function&) override {}
    std::string add(const hal::OptionInfo& option) override { return option.initial; }
    double millimetres() const noexcept override { return 25.4; }

    template <class T>
    void set(const std::string& name, T value) {
        hal::Slot(&cells.at(name).place).write<T>(value);
    }

    std::map<std::string, Cell> cells;
};

struct Feed : hal::Settings {
    using Settings::Settings;

    double feed = pin(feed, "feed", 50.8, "mu/s", "Speed.", hal::must({0, 100}));
    std::int32_t kind = pin(kind, "kind", 1, "Kind of the speed.", hal::machine({0, 3}));
    bool learn = pin(learn, "learn", true, "Learns.", hal::machine());
    double frequency = unjudged(frequency, "frequency", 0, "Hz", "Cycles.", hal::machine({0, 10}));
};

struct Holder final : hal::Component {
    using Component::Component;

    Feed settings{this};
};

struct DeclaredSettings : testing::Test {
    Pins pins;
    Holder holder{pins};
    Feed& it = holder.settings;
};

TEST_F(DeclaredSettings, BeginWithTheirDefaultsInTheUnitOfTheMachine) {
    EXPECT_EQ(it.feed, 2);
    EXPECT_EQ(it.kind, 1);
    EXPECT_TRUE(it.learn);
    EXPECT_FALSE(it.read());
    EXPECT_TRUE(it.in_range);
    const Feed none;
    EXPECT_EQ(none.feed, 50.8) << "without an owner, in mm";
    EXPECT_TRUE(none.learn);
}

TEST_F(DeclaredSettings, AReadTakesAllAndTellsWhetherOneHasChanged) {
    pins.set("feed", 3.0);
    pins.set("kind", 2);
    pins.set("learn", false);
    EXPECT_TRUE(it.read());
    EXPECT_EQ(it.feed, 3);
    EXPECT_EQ(it.kind, 2);
    EXPECT_FALSE(it.learn);
    EXPECT_FALSE(it.read());
    pins.set("feed", nan);
    EXPECT_TRUE(it.read());
    EXPECT_TRUE(it.read()) << "one that is not a number";
}

TEST_F(DeclaredSettings, AreInRangeWhereEachJudgedOneIs) {
    pins.set("frequency", 11.0);
    EXPECT_TRUE(it.read());
    EXPECT_TRUE(it.in_range) << "it is judged where it is used";
    for (const double feed : {-1.0, 101.0, nan}) {
        pins.set("feed", feed);
        EXPECT_TRUE(it.read());
        EXPECT_FALSE(it.in_range) << feed;
    }
    pins.set("kind", 4);
    EXPECT_TRUE(it.read());
    pins.set("feed", 100.0);
    EXPECT_TRUE(it.read());
    EXPECT_FALSE(it.in_range) << "the kind is not";
    pins.set("kind", 3);
    EXPECT_TRUE(it.read());
    EXPECT_TRUE(it.in_range);
}

TEST_F(DeclaredSettings, ACopyKeepsTheLastSetAndReadsNoPins) {
    Feed last = it;
    pins.set("feed", 3.0);
    it.read();
    EXPECT_EQ(last.feed, 2);
    EXPECT_FALSE(last.read());
    last = it;
    EXPECT_EQ(last.feed, 3);
    pins.set("feed", 200.0);
    it.read();
    it = last;
    EXPECT_TRUE(it.read()) << "it has its pins still";
    EXPECT_EQ(it.feed, 200);
}

TEST_F(DeclaredSettings, NameThePinOfAMember) {
    EXPECT_EQ(it.pin_of(it.frequency).name(), "frequency");
    const double other = 0;
    EXPECT_THROW(it.pin_of(other), std::logic_error);
}

}  // namespace
}  // namespace plumb
