// SPDX-License-Identifier: GPL-2.0-or-later
// How modules end with LinuxCNC's own rtapi_app.
#include "tests/support/folder.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"

#include <gtest/gtest.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <thread>

namespace plumb {
namespace {

#ifndef PLUMB_SANITIZED  // stock LinuxCNC is not built with sanitizers

using namespace std::chrono_literals;

// From a file with lines `Name: value`, as the kernel has them.
std::string field(const std::string& file, const std::string& name) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.rfind(name + ":", 0) == 0) return line.substr(name.size() + 1);
    ADD_FAILURE() << file << " has no " << name;
    return "0";
}

struct StockRtapi : testing::Test {
    // Runs `body` on a machine where these are in LinuxCNC's folder of modules.
    static void on_machine(const std::string& modules, const std::function<void()>& body) {
        MachineOptions options;
        options.as_root = false;  // a stock realtime does not run where root is the only user
        options.modules = build_folder() + "/" + modules;
        on_own_machine(
            [&] {
                setenv("RTAPI_UID", "65534", 1);  // which a stock realtime of root's asks for
                body();
            },
            options);
    }

    static void halcmd(const std::string& command) {
        ASSERT_EQ(std::system(("halcmd " + command).c_str()), 0) << command;
    }

    // Until the thread that was started last has run for a while.
    static void run_thread() {
        halcmd("start");
        std::this_thread::sleep_for(50ms);
    }

    // The end of a process; for its parent, which the first process is of all that are left.
    static int await_end(pid_t process) {
        int status = 0;
        for (int tries = 0; tries < 5000; ++tries) {
            if (waitpid(process, &status, WNOHANG) == process) return status;
            std::this_thread::sleep_for(1ms);
        }
        ADD_FAILURE() << "it goes on";
        return status;
    }

    // An empty file that every user may write.
    static void make_notes() {
        std::ofstream{notes};
        std::filesystem::permissions(notes, static_cast<std::filesystem::perms>(0666));
    }

    static constexpr const char* notes = "/tmp/notes";
};

TEST_F(StockRtapi, ComponentsAreNotDestroyedWhileThreadsRunWhenTheSystemEndsIt) {
    if (geteuid() != 0) GTEST_SKIP() << "not root: set-uid rtapi_app is given no LD_PRELOAD";
    on_machine("specimens", [] {
        setenv("LD_PRELOAD", (build_folder() + "/specimens/exit_on_sigterm.so").c_str(), 1);
        make_notes();
        halcmd("loadrt threads name1=thread period1=1000000");
        halcmd("loadrt afterlife names=it notes=/tmp/notes");
        halcmd("addf it.update thread");
        run_thread();
        const pid_t rtapi = Processes::called("rtapi_app");
        ASSERT_EQ(kill(rtapi, SIGTERM), 0);
        const int status = await_end(rtapi);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "exit(0) is the cause of interest";
        EXPECT_EQ(contents(notes), "") << "d: destroyed, u: update() called after that";
    });
}

TEST_F(StockRtapi, UnloadingDestroysComponentsOnceThreadsStand) {
    on_machine("specimens", [] {
        make_notes();
        halcmd("loadrt threads name1=thread period1=1000000");
        halcmd("loadrt afterlife names=a,b notes=/tmp/notes,/tmp/notes");
        halcmd("addf a.update thread");
        run_thread();
        halcmd("stop");
        halcmd("unloadrt afterlife");
        EXPECT_EQ(contents(notes), "dd");
        halcmd("unloadrt all");
    });
}

// The threads of a process, and how often each has slept.
std::map<std::string, long> threads(pid_t process) {
    std::map<std::string, long> found;
    for (const auto& thread :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task"))
        found[thread.path().filename()] =
            std::atol(field(thread.path() / "status", "voluntary_ctxt_switches").c_str());
    return found;
}

// Bytes of memory that a process may write: rtapi_app locks all of it.
long writable_memory(pid_t process) {
    std::ifstream maps("/proc/" + std::to_string(process) + "/maps");
    long sum = 0;
    for (std::string line; std::getline(maps, line);) {
        unsigned long begin = 0, end = 0;
        char mode[5] = "";
        if (std::sscanf(line.c_str(), "%lx-%lx %4s", &begin, &end, mode) == 3 && mode[1] == 'w')
            sum += static_cast<long>(end - begin);
    }
    return sum;
}

TEST_F(StockRtapi, AModuleHasAThreadOfItsOwnOnlyWhereItHasWorkAndASmallOne) {
    on_machine("modules", [] {
        std::ofstream("/tmp/y.csv") << "Y,EXY\n0,0\n100,0.01\n# end, 2 rows\n";
        halcmd("loadrt threads name1=thread period1=1000000");
        const pid_t rtapi = Processes::called("rtapi_app");
        const auto without = threads(rtapi);
        const long memory = writable_memory(rtapi);
        halcmd("loadrt squareness names=a,b");
        EXPECT_EQ(threads(rtapi).size(), without.size()) << "there is nothing to do";
        halcmd("unloadrt squareness");
        halcmd("loadrt squareness names=a,b table=,/tmp/y.csv");
        EXPECT_LT(writable_memory(rtapi) - memory, 1 << 20);

        const auto before = threads(rtapi);
        ASSERT_EQ(before.size(), without.size() + 1);
        std::this_thread::sleep_for(500ms);
        const auto after = threads(rtapi);
        for (const auto& [thread, slept] : before) {
            if (without.count(thread)) continue;
            EXPECT_GT(after.at(thread) - slept, 0) << "it does not work";
            EXPECT_LE(after.at(thread) - slept, 6) << "ten times a second is enough";
            const auto status = "/proc/" + std::to_string(rtapi) + "/task/" + thread + "/status";
            const unsigned long blocked = std::stoul(field(status, "SigBlk"), nullptr, 16);
            for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGALRM})
                EXPECT_TRUE(blocked >> (number - 1) & 1) << "it takes signal " << number;
            EXPECT_FALSE(blocked >> (SIGSEGV - 1) & 1) << "rtapi_app could not report its failure";
        }
        halcmd("unloadrt all");
    });
}

// LinuxCNC's script exports INI_FILE_NAME before its realtime side starts.
TEST_F(StockRtapi, MillimetresOnAnInchMachineAreRefused) {
    on_machine("modules", [] {
        std::ofstream("/tmp/machine.ini") << "[TRAJ]\nLINEAR_UNITS = inch\n";
        setenv("INI_FILE_NAME", "/tmp/machine.ini", 1);
        halcmd("loadrt threads name1=thread period1=1000000 2> /tmp/messages");  // also those of rtapi_app
        EXPECT_NE(std::system("halcmd loadrt axis_offset names=z interlock=no"), 0);
        EXPECT_NE(contents("/tmp/messages")
                      .find("[TRAJ]LINEAR_UNITS is inch in /tmp/machine.ini, and the "
                            "defaults are in mm"),
                  std::string::npos)
            << contents("/tmp/messages");
        std::ofstream("/tmp/stage.hal") << "loadrt axis_offset names=z interlock=no unit=[TRAJ]LINEAR_UNITS\n";
        halcmd("-i /tmp/machine.ini -f /tmp/stage.hal");
        EXPECT_EQ(std::system("halcmd getp z.max-offset | grep -q '^0\\.00590'"), 0);
        halcmd("unloadrt all");
    });
}

#endif

}  // namespace
}  // namespace plumb
