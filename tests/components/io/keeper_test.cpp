// SPDX-License-Identifier: GPL-2.0-or-later
// The keeper of the values of pins, used by several threads as in `retain`;
// tests/components/io/retain_test.py runs the program.
#include "components/io/retain/keeper.hpp"

#include "tests/support/folder.hpp"

#include <gtest/gtest.h>

#include <atomic>
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
