// SPDX-License-Identifier: GPL-2.0-or-later
// The first milliseconds of a host: where namespaces cannot be had, and where it or its keeper is killed
// before it has them.
#include "hal/host/faketime_library.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <signal.h>
#include <sys/file.h>
#include <sys/shm.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Clock = std::chrono::steady_clock;

const std::string plumb_program = "/tmp/bin/plumb";

void write_bench() {
    std::ofstream("/tmp/lag.hal") << "loadrt threads name1=servo-thread period1=1000000\n"
                                     "loadrt lowpass names=lag\naddf lag servo-thread\n";
}

// --- where the kernel forbids namespaces ---

void without_namespaces(const std::function<void()>& body) {
    MachineOptions options;
    options.own_users = true;
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [&] {
            std::ofstream("/proc/sys/user/max_ipc_namespaces") << 0;
            body();
        },
        options);
}

TEST(WithoutNamespaces, ARunIsRefusedAndItsProgramDoesNotStart) {
    without_namespaces([] {
        const Outcome refused = run_program({plumb_program, "run", "touch", "/tmp/started"}, "/tmp");
        EXPECT_EQ(refused.status, 1);
        EXPECT_THAT(
            refused.errors,
            AllOf(HasSubstr("plumb run: this system gives the run no namespaces (clone: No space left"),
                  HasSubstr("--no-namespaces runs it nevertheless")));
        EXPECT_FALSE(std::filesystem::exists("/tmp/started"));
        const Outcome asked_for =
            run_program({plumb_program, "run", "--no-namespaces", "touch", "/tmp/started"}, "/tmp");
        EXPECT_EQ(asked_for.status, 0) << asked_for.errors;
        EXPECT_EQ(asked_for.errors, "");
        EXPECT_TRUE(std::filesystem::exists("/tmp/started"));
    });
}

TEST(WithoutNamespaces, ABenchReportsItAndUsesTheOneHal) {
    without_namespaces([] {
        write_bench();
        const Outcome outcome = run_program({plumb_program, "bench", "lag.hal", "--for", "1"}, "/tmp");
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
        EXPECT_THAT(outcome.output, HasSubstr("simulated 1 s"));
        EXPECT_THAT(outcome.errors, HasSubstr("plumb-host: this system gives no namespaces (clone: "));
        EXPECT_THAT(outcome.errors, HasSubstr("uses the computer's one HAL"));
    });
}

// The host's clock is a day off: by it, all files there are young or old.
TEST(WithoutNamespaces, FilesOfOthersStayAndThoseOfTheRunGoWhateverTheClockShows) {
    const std::string library = host::faketime_library().string();
    if (library.empty()) GTEST_SKIP() << "libfaketime is not installed";
    without_namespaces([&library] {
        for (const std::string shift : {"-1d", "+1d"}) {
            std::ofstream("/tmp/linuxcnc.print.others") << "1\n";
            const auto run = [&](std::vector<std::string> words) {
                words.insert(words.begin(),
                             {"/usr/bin/env", "LD_PRELOAD=" + library, "FAKETIME=" + shift,
                              "FAKETIME_DONT_FAKE_MONOTONIC=1", "ASAN_OPTIONS=verify_asan_link_order=0"});
                const Outcome outcome = run_program(words, "/tmp");
                EXPECT_EQ(outcome.status, 0) << outcome.errors;
                return outcome.output;
            };
            EXPECT_NE(run({"/usr/bin/date", "+%F"}), run_program({"/usr/bin/date", "+%F"}, "/tmp").output);
            run({plumb_program, "run", "--no-namespaces", "sh", "-c", "echo > /tmp/linuxcnc.print.own"});
            EXPECT_TRUE(std::filesystem::exists("/tmp/linuxcnc.print.others")) << shift;
            EXPECT_FALSE(std::filesystem::exists("/tmp/linuxcnc.print.own")) << shift;
            std::filesystem::remove("/tmp/linuxcnc.print.own");
        }
    });
}

// --- kills meanwhile ---

class KilledWhileItIsSetUp : public testing::TestWithParam<Role> {
protected:
    const Role role = GetParam();

    void on_machine(const std::function<void()>& body) const {
        MachineOptions options = machine_of(role);
        options.programs = {build_folder() + "/bin/plumb"};
        on_own_machine(body, options);
    }

    static bool ended(pid_t child) {
        siginfo_t state{};
        return waitid(P_PID, static_cast<id_t>(child), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
               state.si_pid != 0;
    }

    // Calls `kill_one` for the keeper as soon as the host is there, and then a bit later from run to run.
    void run_and_kill(const std::function<void(pid_t keeper, pid_t host)>& kill_one,
                      const std::function<void(const Outcome&)>& check) const {
        Child child(role != Role::user, [&](Child&) {
            int killed = 0;
            for (int round = 0; round < 24; ++round) {
                std::vector<std::string> words{plumb_program, "run"};
                if (role == Role::no_namespaces) words.push_back("--no-namespaces");
                words.insert(words.end(), {"sh", "-c", "readlink /proc/self/ns/ipc; ls /dev"});
                const Outcome outcome = run_program(words, "/tmp", [&](pid_t keeper) {
                    const std::string number = std::to_string(keeper);
                    pid_t host = 0;
                    while (host == 0 && !ended(keeper))
                        std::ifstream("/proc/" + number + "/task/" + number + "/children") >> host;
                    for (const auto end = Clock::now() + round * 150us; Clock::now() < end;) continue;
                    if (host != 0) kill_one(keeper, host);
                });
                killed += outcome.status == 128 + SIGKILL;
                check(outcome);
            }
            EXPECT_GT(killed, 0) << "each came too late";
        });
        child.await_success();
    }
};

TEST_P(KilledWhileItIsSetUp, AHostEndsTheRunAndNoProgramSeesTheComputersDevices) {
    on_machine([this] {
        const std::string machines = std::filesystem::read_symlink("/proc/self/ns/ipc");
        const std::string devices = run_program({"/bin/ls", "/dev"}, "/").output;
        run_and_kill([](pid_t, pid_t host) { kill(host, SIGKILL); },
                     [&](const Outcome& outcome) {
                         EXPECT_THAT(outcome.status, testing::AnyOf(0, 128 + SIGKILL)) << outcome.errors;
                         if (outcome.status != 0) {
                             EXPECT_THAT(outcome.errors,
                                         HasSubstr("plumb run: the virtual-time host was killed"));
                         }
                         if (role == Role::no_namespaces) return;
                         EXPECT_THAT(outcome.output, Not(HasSubstr(machines)));
                         EXPECT_THAT(outcome.output, Not(HasSubstr(devices)));
                     });
        expect_nothing_left({});
    });
}

TEST_P(KilledWhileItIsSetUp, AKeeperTakesItsHostWithIt) {
    on_machine([this] {
        run_and_kill([](pid_t keeper, pid_t) { kill(keeper, SIGKILL); }, [](const Outcome&) {});
        expect_nothing_left({});
    });
}

INSTANTIATE_TEST_SUITE_P(, KilledWhileItIsSetUp, testing::Values(Role::root, Role::user, Role::no_namespaces),
                         [](const auto& instance) { return name_of(instance.param); });

// --- the lock of the one HAL, in a folder that every user can write ---

const char* const lock_file = "/run/lock/plumb-host";

struct HalLock : testing::Test {
    void SetUp() override {
        if (!std::filesystem::is_directory("/run/lock")) GTEST_SKIP() << "there is no /run/lock";
    }
    static void on_machine(const std::function<void()>& body) {
        MachineOptions options;
        options.programs = {build_folder() + "/bin/plumb"};
        on_own_machine(
            [&] {
                write_bench();
                body();
            },
            options);
    }
    static Outcome bench() {
        return run_program({plumb_program, "bench", "--no-namespaces", "lag.hal", "--for", "1"}, "/tmp");
    }
    static mode_t mode_of(const char* file) {
        struct stat state {};
        return stat(file, &state) == 0 ? state.st_mode & 07777 : 0;
    }
};

TEST_F(HalLock, ALinkInItsPlaceIsRefusedAndItsTargetStaysAsItIs) {
    on_machine([] {
        std::ofstream("/tmp/secret") << "secret\n";
        ASSERT_EQ(chmod("/tmp/secret", 0600), 0);
        for (const char* target : {"/tmp/secret", "/tmp/not-there"}) {
            ASSERT_EQ(symlink(target, lock_file), 0);
            const Outcome refused = bench();
            EXPECT_EQ(refused.status, 1);
            EXPECT_THAT(refused.errors, HasSubstr(std::string(lock_file) + " is a symbolic link"));
            ASSERT_EQ(unlink(lock_file), 0);
        }
        EXPECT_EQ(mode_of("/tmp/secret"), 0600u);
        EXPECT_EQ(contents("/tmp/secret"), "secret\n");
        EXPECT_FALSE(std::filesystem::exists("/tmp/not-there"));
    });
}

TEST_F(HalLock, APipeInItsPlaceIsRefusedAtOnce) {
    on_machine([] {
        ASSERT_EQ(mkfifo(lock_file, 0666), 0);
        const Outcome refused = bench();
        EXPECT_EQ(refused.status, 1);
        EXPECT_THAT(refused.errors, HasSubstr(std::string(lock_file) + " is no file"));
    });
}

// Whether another program has opened the file; a child that this one has just forked has it too.
bool others_have_it() {
    std::error_code gone;
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe");
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
        if (std::filesystem::read_symlink(process.path() / "exe", gone) == own) continue;
        for (const auto& link : std::filesystem::directory_iterator(process.path() / "fd", gone))
            if (std::filesystem::read_symlink(link.path(), gone) == lock_file) return true;
    }
    return false;
}

TEST_F(HalLock, AFileThatIsThereKeepsItsRightsAndServes) {
    on_machine([] {
        const int there = open(lock_file, O_RDONLY | O_CREAT | O_CLOEXEC, 0600);
        ASSERT_EQ(flock(there, LOCK_EX | LOCK_NB), 0);
        std::thread later([&] {
            while (!others_have_it()) std::this_thread::sleep_for(20ms);
            std::this_thread::sleep_for(200ms);  // from its opening to the first look at the lock
            close(there);
        });
        const Outcome outcome = bench();
        later.join();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.errors, HasSubstr("waits until the other host"));
        EXPECT_EQ(mode_of(lock_file), 0600u);
    });
}

TEST_F(HalLock, ItsFileServesEveryUserWithAnyUmask) {
    on_machine([] {
        umask(077);
        EXPECT_EQ(bench().status, 0);
        EXPECT_EQ(mode_of(lock_file), 0644u);
    });
}

TEST_F(HalLock, WhoHoldsItIsNamedAfterASecondWithTheRemedy) {
    if (geteuid() != 0) GTEST_SKIP() << "only root is more than one user";
    on_machine([] {
        const int there = open(lock_file, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
        close(there);
        Child stranger(false, [](Child& self) {
            const int file = open(lock_file, O_RDONLY | O_CLOEXEC);
            ASSERT_EQ(flock(file, LOCK_EX | LOCK_NB), 0);
            self.say("held");
            self.await_go();
        });
        stranger.hear();
        const Outcome outcome =
            run_program({plumb_program, "run", "--no-namespaces", "true"}, "/tmp", [&](pid_t) {
                std::this_thread::sleep_for(2500ms);
                stranger.go();
            });
        EXPECT_EQ(outcome.status, 0);
        const std::string number = std::to_string(stranger.process());
        EXPECT_THAT(outcome.errors,
                    HasSubstr("process " + number + ", tests, of user nobody holds " + lock_file));
        EXPECT_THAT(outcome.errors, HasSubstr("end it: kill " + number + "\n"));
    });
}

// The first process that took it is gone, and its child has it.
TEST_F(HalLock, WhoInheritedItIsNamed) {
    on_machine([] {
        const int there = open(lock_file, O_RDONLY | O_CREAT, 0644);  // goes to a program
        ASSERT_EQ(flock(there, LOCK_EX | LOCK_NB), 0);
        const Outcome started = run_program({"/bin/sh", "-c", "sleep 4 >/dev/null 2>&1 & echo $!"}, "/tmp");
        close(there);
        const Outcome outcome = run_program({plumb_program, "run", "--no-namespaces", "true"}, "/tmp");
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.errors,
                    HasSubstr("process " + std::to_string(std::stoi(started.output)) + ", sleep, of user "));
    });
}

TEST_F(HalLock, WhoHasHalsMemoryIsNamed) {
    if (geteuid() != 0) GTEST_SKIP() << "only root is more than one user";
    on_machine([] {
        Child stranger(false, [](Child& self) {
            ASSERT_NE(shmat(shmget(0x48414c32, 1000, IPC_CREAT | 0600), nullptr, 0), nullptr);
            self.say("attached");
            self.await_go();
        });
        stranger.hear();
        const Outcome refused = bench();
        EXPECT_EQ(refused.status, 1);
        EXPECT_THAT(
            refused.errors,
            HasSubstr("HAL is in use on this machine (shared memory 0x48414c32 of user nobody: process " +
                      std::to_string(stranger.process()) + ", tests"));
        stranger.go();
        stranger.await_success();
    });
}

TEST_F(HalLock, WhoWaitsForItCanBeEnded) {
    on_machine([] {
        const int there = open(lock_file, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
        ASSERT_EQ(flock(there, LOCK_EX | LOCK_NB), 0);
        const Outcome ended =
            run_program({plumb_program, "run", "--no-namespaces", "true"}, "/tmp", [](pid_t host) {
                std::this_thread::sleep_for(200ms);
                kill(host, SIGTERM);
            });
        EXPECT_EQ(ended.status, 128 + SIGTERM);
    });
}

}  // namespace
}  // namespace plumb
