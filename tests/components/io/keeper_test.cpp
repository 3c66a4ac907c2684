// SPDX-License-Identifier: GPL-2.0-or-later
// The keeper of the values of pins, used by several threads as in `plumb-retain`;
// tests/components/io/plumb_retain_test.py runs the program.
#include "components/io/retain/keeper.hpp"

#include "tests/support/folder.hpp"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

namespace {
hal_data_u the_pin;  // kept.in, a float
}

// HAL has this one pin.
extern "C" int hal_get_pin_value_by_name(const char* name, hal_type_t* type, hal_data_u** data,
                                         bool* linked) {
    if (std::strcmp(name, "kept.in") != 0) return -1;
    *type = HAL_FLOAT;
    *data = &the_pin;
    *linked = false;
    return 0;
}

namespace plumb {
namespace {

// A halcmd, which lists the pin, before LinuxCNC's.
struct KeeperThreads : testing::Test {
    KeeperThreads() {
        const auto halcmd = folder.write("halcmd", "#!/bin/sh\necho '  7 float IN 0 kept.in'\n");
        std::filesystem::permissions(halcmd, std::filesystem::perms::owner_all);
        setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
    }
    ~KeeperThreads() override { setenv("PATH", path.c_str(), 1); }

    std::string stored() const {
        std::ostringstream text;
        text << std::ifstream(folder / "it.retained").rdbuf();
        return text.str();
    }

    const Folder folder;
    const std::string path = std::getenv("PATH");
    const std::string toml = folder.write("it.toml", "machine = \"m\"\npins = [\"kept.in\"]\nevery = 3600\n");
};

TEST_F(KeeperThreads, OneMayFinishAndAnotherLookWhileItSteps) {
    for (int round = 0; round < 20; ++round) {
        std::filesystem::remove(folder / "it.retained");
        the_pin.f = round + 0.5;
        Keeper keeper(toml);
        std::atomic<bool> over{false};
        std::thread background([&] {
            while (!over) {
                keeper.step();
                const Keeper::State state = keeper.state();
                EXPECT_FALSE(state.restored && state.waiting);
                EXPECT_EQ(state.fault, Fault::none);
            }
        });
        while (keeper.state().saves == 0) std::this_thread::yield();
        keeper.finish();
        EXPECT_FALSE(keeper.state().restored);
        over = true;
        background.join();
        const std::string line = "\"kept.in\" = " + std::to_string(round) + ".5\n";
        EXPECT_NE(stored().find(line), std::string::npos) << stored();
    }
}

// The store has been written.
void keep(Keeper& keeper) {
    while (keeper.state().saves == 0) keeper.step();
}

TEST_F(KeeperThreads, ARemovedLockFileLetsNoSecondKeeperIn) {
    the_pin.f = 1.5;
    Keeper first(toml);
    keep(first);
    std::filesystem::remove(folder / "it.retained.lock");
    EXPECT_THROW(Keeper second(toml), std::runtime_error);
}

TEST_F(KeeperThreads, TooManyOpenFilesAtTheStartAreNotFinal) {
    the_pin.f = 1.5;
    {
        Keeper first(toml);
        keep(first);
    }
    the_pin.f = 0;
    rlimit before{};
    getrlimit(RLIMIT_NOFILE, &before);
    const int free = dup(0);
    close(free);
    const rlimit one_free{static_cast<rlim_t>(free) + 1, before.rlim_max};
    setrlimit(RLIMIT_NOFILE, &one_free);
    Keeper second(toml);
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(second.state().fault, Fault::inaccessible);
    for (int tries = 0; tries < 400 && !second.state().restored; ++tries) {
        second.step();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(second.state().fault, Fault::none);
    EXPECT_EQ(the_pin.f, 1.5);
}

TEST(RetainedFile, NoFlippedBitIsTaken) {
    Retained values;
    values.pins = {{"a.b", 1.5}, {"a.on", true}, {"a.n", std::int64_t{7}}};
    values.records["growth"] = {{{"length", -2.5}, {"tool", std::int64_t{3}}}};
    const std::string text = retained_file::compose(values, "mill");
    ASSERT_EQ(retained_file::compose(retained_file::parse(text, "mill", "store"), "mill"), text);
    for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
        std::string flipped = text;
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
        EXPECT_THROW(retained_file::parse(flipped, "mill", "store"), retained_file::Refused)
            << "bit " << bit % 8 << " of byte " << bit / 8 << " of " << text;
    }
}

TEST_F(KeeperThreads, APinTakesOverTheValueKeptUnderTheFormerNameOfItsInstance) {
    const auto renamed = folder.write("it.toml",
                                      "machine = \"m\"\npins = [\"kept.in\"]\nevery = 3600\n"
                                      "formerly = { kept = \"a.former\" }\n");
    for (const bool both : {false, true}) {
        Retained values;
        values.pins["a.former.in"] = 7.5;
        if (both) values.pins["kept.in"] = 2.5;
        folder.write("it.retained", retained_file::compose(values, "m"));
        the_pin.f = 0;
        Keeper keeper(renamed);
        while (keeper.state().saves == 0) keeper.step();
        EXPECT_EQ(the_pin.f, both ? 2.5 : 7.5);
        EXPECT_EQ(stored().find("a.former"), std::string::npos) << stored();
    }
}

}  // namespace
}  // namespace plumb
