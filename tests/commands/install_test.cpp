// SPDX-License-Identifier: GPL-2.0-or-later
// `cmake --install` puts everything where LinuxCNC looks for it, below DESTDIR, and it works there.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

namespace plumb {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

struct Ended {
    int status;
    std::string output;
};

Ended run(const std::string& command) {
    std::array<char, 4096> buffer;
    std::string output;
    FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
    while (std::fgets(buffer.data(), buffer.size(), pipe)) output += buffer.data();
    return {pclose(pipe), output};
}

std::set<std::string> files_below(const fs::path& folder) {
    std::set<std::string> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
        if (!entry.is_directory()) files.insert("/" + entry.path().lexically_relative(folder).string());
    return files;
}

class Installed : public testing::Test {
protected:
    void SetUp() override { install("022"); }

    void install(const std::string& umask) {
        // Everything is of this component; naming it leaves the list of a real installation alone.
        const Ended ended =
            run("umask " + umask + "; DESTDIR=" + stage.path().string() + " cmake --install " +
                build_folder() + " --prefix /usr --component Unspecified");
        ASSERT_EQ(ended.status, 0) << ended.output;
    }

    const Folder stage;
    const fs::path programs = stage / "usr/bin";
    const fs::path modules = stage.path().string() + STOCK_MODULE_DIR;
    const fs::path configs = stage / "usr/share/linuxcnc/aux_examples/plumb";
};

TEST_F(Installed, EveryModuleProgramPageAndConfigurationIsWhereLinuxCncLooks) {
    std::vector<std::string> wanted{"/usr/bin/plumb",
                                    "/usr/bin/plumb-host",
                                    "/usr/share/man/man1/plumb-bench.1",
                                    "/usr/share/man/man1/plumb-doctor.1",
                                    "/usr/share/man/man7/plumb-glossary.7",
                                    "/usr/share/plumb/plumb-retain.json",
                                    "/usr/share/linuxcnc/aux_examples/plumb/mill/bench.hal",
                                    "/usr/share/linuxcnc/hallib/plumb_order.tcl",
                                    "/usr/share/linuxcnc/aux_examples/plumb/three_axis/three_axis.ini",
                                    "/usr/lib/python3/dist-packages/plumb.py",
                                    "/usr/lib/python3/dist-packages/plumb_folder.py",
                                    "/usr/lib/python3/dist-packages/plumb_linuxcnc.py",
                                    "/usr/lib/python3/dist-packages/plumb_program.py"};
    for (const std::string& module : built_modules()) {
        wanted.push_back(STOCK_MODULE_DIR "/" + module + ".so");
        wanted.push_back("/usr/share/man/man9/" + module + ".9");
        wanted.push_back("/usr/share/plumb/" + module + ".json");
    }
    for (const fs::directory_entry& program : fs::directory_iterator(programs))
        wanted.push_back("/usr/share/man/man1/" + program.path().filename().string() + ".1");
    ASSERT_GT(wanted.size(), 12u);
    EXPECT_THAT(files_below(stage.path()), IsSupersetOf(wanted));
}

TEST_F(Installed, EveryPageNamesTheGlossary) {
    int pages = 0;
    for (const char* section : {"man1", "man9"})
        for (const fs::directory_entry& page : fs::directory_iterator(stage / "usr/share/man" / section)) {
            std::ifstream file(page.path());
            const std::string text{std::istreambuf_iterator<char>(file), {}};
            EXPECT_THAT(text, HasSubstr(".BR plumb\\-glossary (7)")) << page.path();
            ++pages;
        }
    EXPECT_GT(pages, 20);
}

TEST_F(Installed, NothingOfTheTestsIsInstalled) {
    for (std::string file : files_below(stage.path())) {
        for (std::size_t at = 0; (at = file.find("growth_test")) != std::string::npos;)
            file.erase(at, 11);  // a function of that name
        EXPECT_THAT(file, Not(HasSubstr("specimen"))) << file;
        EXPECT_THAT(file, Not(HasSubstr("test"))) << file;
    }
}

TEST_F(Installed, ConfigurationReachesWhatItHasInCommon) {
    const fs::path common = configs / "three_axis/common";
    EXPECT_TRUE(fs::exists(common / "hal.inc"));
    EXPECT_NE(fs::status(common / "headless.py").permissions() & fs::perms::others_exec, fs::perms::none);
}

// Folders that LinuxCNC and Debian have are there before.
TEST_F(Installed, EverybodyMayUseIt) {
    fs::remove_all(stage / "usr");
    install("077");
    const auto expect_open = [](const fs::path& path, bool entered) {
        const fs::perms given = fs::status(path).permissions();
        const fs::perms wanted =
            fs::perms::others_read | (entered ? fs::perms::others_exec : fs::perms::none);
        EXPECT_EQ(given & wanted, wanted) << path;
    };
    for (const fs::path& folder : {configs, stage / "usr/share/plumb"}) {
        expect_open(folder, true);
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
            if (entry.is_directory()) expect_open(entry, true);
    }
    for (const std::string& file : files_below(stage.path())) {
        const fs::path path = stage.path().string() + file;
        if (!fs::is_symlink(path) || fs::exists(path))
            expect_open(path, (fs::status(path).permissions() & fs::perms::owner_exec) != fs::perms::none);
    }
}

TEST_F(Installed, PagesAreFoundByMan) {
    const Ended page =
        run("MANPATH=" + (stage / "usr/share/man").string() + " man -P cat 9 thermal_displacement");
    if (page.output.find("command not found") != std::string::npos || page.status == 127 << 8)
        GTEST_SKIP() << "there is no man";
    EXPECT_EQ(page.status, 0) << page.output;
    EXPECT_THAT(page.output, HasSubstr("z-offset"));
}

TEST_F(Installed, BenchRunsFromWhatIsInstalledAlone) {
    const Ended bench = run("cd " + stage.path().string() + " && " + (programs / "plumb").string() +
                            " bench " + (configs / "mill/bench.hal").string() + " --modules " +
                            modules.string() + " --for 2 --record mill.z-position --every 1 --output z.csv");
    EXPECT_EQ(bench.status, 0) << bench.output;
    EXPECT_EQ(read_table(stage / "z.csv").rows.size(), 3u);
}

TEST_F(Installed, StockLinuxCncLoadsThermalDisplacement) {
    MachineOptions machine;
    machine.modules = modules;
    machine.as_root = false;
    on_own_machine(
        [] {
            // -1, which update() alone writes: so it runs.
            std::ofstream("/tmp/await") << "for turn in $(seq 100); do\n"
                                           "  [ $(halcmd getp z-growth.row-shown) = -1 ] && break\n"
                                           "  sleep 0.1\n"
                                           "done\n";
            std::ofstream("/tmp/load.hal") << "loadrt threads name1=servo-thread period1=1000000\n"
                                              "loadrt thermal_displacement names=z-growth interlock=no\n"
                                              "addf z-growth.update servo-thread\n"
                                              "setp z-growth.max-offset 0.1\n"
                                              "start\n"
                                              "loadusr -w bash /tmp/await\n"
                                              "show pin z-growth.max-offset\n"
                                              "show pin z-growth.row-shown\n";
            const Ended halrun = run("RTAPI_UID=65534 halrun -f /tmp/load.hal");
            EXPECT_EQ(halrun.status, 0) << halrun.output;
            EXPECT_THAT(halrun.output, HasSubstr("0.1  z-growth.max-offset"));
            EXPECT_THAT(halrun.output, HasSubstr("-1  z-growth.row-shown"));
        },
        machine);
}

}  // namespace
}  // namespace plumb
