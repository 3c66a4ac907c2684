// SPDX-License-Identifier: GPL-2.0-or-later
// However a host, its client or a halcmd ends: nobody hangs, nobody becomes a stock realtime master by
// accident, and no process, no shared memory, no socket and no lock is left.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"

#include <gmock/gmock.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <thread>
#include <tuple>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

enum class Moment { idle, running, loading };

constexpr auto at_once = 2s;  // on a busy machine; a stock halcmd waits 3 s before it becomes a master

client::Start start_as(Role role) {
    client::Start start;
    start.executable = host_of_machine;
    start.namespaces = role != Role::no_namespaces;
    return start;
}

void make_thread(client::Client& host) {
    host.command("loadrt threads name1=servo-thread period1=1000000");
    host.command("start");
}

// Once it has loaded a thread, sends the parent the host's number. The parent finds it in this moment, with
// a user-space program beside the host.
void be_in(Moment moment, client::Client& host, Child& self) {
    make_thread(host);
    host.command("loadusr sleep 1000");
    self.say(std::to_string(host.process()));
    if (moment == Moment::running) host.run(client::seconds(1e9));
    if (moment == Moment::loading) host.source("/tmp/slow.hal");
    self.await_go();
    for (const auto begin = Clock::now(); Clock::now() < begin + at_once;) host.get("servo-thread.time");
}

// Until the child is in the moment; returns the number of its host.
pid_t await_moment(Moment moment, Child& child) {
    const pid_t host = std::stoi(child.hear());
    if (moment == Moment::loading)
        while (kill(Processes::called("slow_program"), 0) != 0) {
        }
    else
        std::this_thread::sleep_for(100ms);
    return host;
}

// A .hal file whose second line waits for a program to end.
void write_slow_hal_file() {
    std::filesystem::copy_file("/bin/sleep", "/tmp/bin/slow_program");
    std::ofstream("/tmp/slow.hal") << "loadusr -w /tmp/bin/slow_program 1000\nloadrt lowpass\n";
}

// A host starts, works and ends well, as if nothing had been.
void expect_machine_works(Role role) {
    Child child(role != Role::user, [role](Child&) {
        client::Client host(start_as(role));
        EXPECT_EQ(host.namespaces(), role != Role::no_namespaces);
        make_thread(host);
        host.run(client::seconds(1));
        EXPECT_EQ(host.time(), client::seconds(1));
    });
    child.await_success();
}

std::string name_of(Moment moment) {
    return moment == Moment::idle ? "Idle" : moment == Moment::running ? "Running" : "Loading";
}

void PrintTo(Moment moment, std::ostream* out) {
    *out << name_of(moment);
}

class LifeCycle : public testing::TestWithParam<Role> {};

TEST_P(LifeCycle, NothingIsLeftAfterANormalEnd) {
    const Role role = GetParam();
    on_own_machine(
        [role] {
            expect_machine_works(role);
            expect_nothing_left({});
            expect_machine_works(role);
            expect_nothing_left({});
        },
        machine_of(role));
}

TEST_P(LifeCycle, ProgramsEndWithTheHost) {
    const Role role = GetParam();
    on_own_machine(
        [role] {
            Child child(role != Role::user, [role](Child&) {
                client::Client host(start_as(role));
                make_thread(host);
                host.command("loadusr sleep 1000");
                EXPECT_THAT(host.programs(), testing::ElementsAre("sleep"));
            });
            child.await_success();
            expect_nothing_left({});
        },
        machine_of(role));
}

TEST_P(LifeCycle, KilledHalcmdIsAnAnswerAndTheHostGoesOn) {
    const Role role = GetParam();
    on_own_machine(
        [role] {
            write_slow_hal_file();
            const auto before = files();
            Child child(role != Role::user, [role](Child& self) {
                client::Client host(start_as(role));
                make_thread(host);
                self.say("loading");
                EXPECT_EQ(host.halcmd({"-f", "/tmp/slow.hal"}).status, 128 + SIGKILL);
                self.say("returned");
                host.command("loadrt lowpass names=filter");
                host.command("addf filter servo-thread");
                host.set("filter.gain", 1);
                host.set("filter.in", 5);
                host.run(client::seconds(0.002));
                EXPECT_EQ(host.get("filter.out"), 5);
            });
            child.hear();
            Processes::called("slow_program");
            kill(Processes::called("halcmd"), SIGKILL);
            const auto killed = Clock::now();
            child.hear();
            EXPECT_LT(Clock::now() - killed, at_once);
            child.await_success();
            expect_nothing_left(before);
            expect_machine_works(role);
        },
        machine_of(role));
}

INSTANTIATE_TEST_SUITE_P(, LifeCycle, testing::Values(Role::root, Role::user, Role::no_namespaces),
                         [](const auto& instance) { return name_of(instance.param); });

class SuddenDeath : public testing::TestWithParam<std::tuple<Role, Moment>> {
protected:
    const Role role = std::get<Role>(GetParam());
    const Moment moment = std::get<Moment>(GetParam());

    // Kills a process of the host: its client, the child, notices at once, and nothing is left.
    void expect_clean_death(pid_t victim, Child& child, const std::vector<std::string>& files_before) const {
        kill(victim, SIGKILL);
        const auto killed = Clock::now();
        if (moment == Moment::idle) child.go();
        EXPECT_EQ(child.hear(), "noticed");
        EXPECT_LT(Clock::now() - killed, at_once);
        child.await_success();
        expect_nothing_left(files_before);
        expect_machine_works(role);
    }
};

TEST_P(SuddenDeath, OfTheHostFailsItsClientAtOnce) {
    on_own_machine(
        [this] {
            write_slow_hal_file();
            const auto before = files();
            Child child(role != Role::user, [this](Child& self) {
                client::Client host(start_as(role));
                try {
                    be_in(moment, host, self);
                    ADD_FAILURE() << "the host did not die";
                } catch (const client::HostDied& death) {
                    EXPECT_THAT(death.what(), HasSubstr("the virtual-time host died (signal 9)"));
                }
                self.say("noticed");
                EXPECT_THROW(host.get("servo-thread.time"), client::HostDied);
                EXPECT_THROW(host.run(client::seconds(1)), client::HostDied);
            });
            expect_clean_death(await_moment(moment, child), child, before);
        },
        machine_of(role));
}

// Its parent process, which waits to clear up after it, may be the victim as well.
TEST_P(SuddenDeath, OfTheHostsKeeperFailsTheClientAtOnce) {
    on_own_machine(
        [this] {
            write_slow_hal_file();
            const auto before = files();
            Child child(role != Role::user, [this](Child& self) {
                client::Client host(start_as(role));
                EXPECT_THROW(be_in(moment, host, self), client::HostDied);
                self.say("noticed");
            });
            await_moment(moment, child);
            std::ifstream children("/proc/" + std::to_string(child.process()) + "/task/" +
                                   std::to_string(child.process()) + "/children");
            pid_t keeper = 0;
            ASSERT_TRUE(children >> keeper);
            expect_clean_death(keeper, child, before);
        },
        machine_of(role));
}

TEST_P(SuddenDeath, OfTheClientLeavesNothing) {
    on_own_machine(
        [this] {
            write_slow_hal_file();
            const auto before = files();
            Child child(role != Role::user, [this](Child& self) {
                client::Client host(start_as(role));
                be_in(moment, host, self);
            });
            await_moment(moment, child);
            child.kill();
            expect_nothing_left(before);
            expect_machine_works(role);
        },
        machine_of(role));
}

INSTANTIATE_TEST_SUITE_P(, SuddenDeath,
                         testing::Combine(testing::Values(Role::root, Role::user, Role::no_namespaces),
                                          testing::Values(Moment::idle, Moment::running, Moment::loading)),
                         [](const auto& instance) {
                             return name_of(std::get<Role>(instance.param)) +
                                    name_of(std::get<Moment>(instance.param));
                         });

TEST(SideBySide, HostsDoNotSeeEachOther) {
    Bench a;
    Bench b;
    EXPECT_NE(a.client().socket(), b.client().socket());
    a.command("loadrt lowpass names=same");
    b.command("loadrt lowpass names=same");
    a.command("addf same servo-thread");
    a.command("net only-in-a same.out");
    a.set("same.gain", 1);
    b.set("same.gain", 0.5);
    a.set("same.in", 7);
    a.run(1);
    EXPECT_EQ(a.get("same.out"), 7);
    EXPECT_EQ(b.get("same.out"), 0);
    EXPECT_EQ(a.get("same.gain"), 1);
    EXPECT_EQ(b.time(), 0);
    EXPECT_THROW(b.get("only-in-a"), std::runtime_error);
}

TEST(SideBySide, WithoutNamespacesASecondHostWaitsForTheFirstAndReportsIt) {
    on_own_machine([] {
        auto first = std::make_unique<client::Client>(start_as(Role::no_namespaces));
        std::FILE* const said = std::tmpfile();
        Child child(true, [said](Child& self) {
            dup2(fileno(said), STDERR_FILENO);
            client::Start start = start_as(Role::no_namespaces);
            start.show_output = true;
            client::Client second(start);
            self.say("started");
        });
        const auto begin = Clock::now();
        std::string words;
        while (words.find("waits until the other host") == std::string::npos && Clock::now() < begin + 5s) {
            char text[200] = "";
            words.assign(text, pread(fileno(said), text, sizeof text, 0));
            std::this_thread::sleep_for(5ms);
        }
        EXPECT_THAT(words, HasSubstr("waits until the other host"));
        make_thread(*first);  // which is not disturbed
        first->run(client::seconds(1));
        EXPECT_EQ(first->time(), client::seconds(1));
        first.reset();
        EXPECT_EQ(child.hear(), "started");
        child.await_success();
    });
}

TEST(SideBySide, WhereTheKernelForbidsNamespacesTheMachinesHalIsUsed) {
    MachineOptions options;
    options.own_users = true;
    on_own_machine(
        [] {
            std::ofstream("/proc/sys/user/max_ipc_namespaces") << 0;
            client::Start start;
            start.executable = host_of_machine;
            client::Client host(start);
            EXPECT_FALSE(host.namespaces());
            make_thread(host);
            EXPECT_GT(shared_memory_segments(), 0);
        },
        options);
}

TEST(SideBySide, WithoutNamespacesItIsRefusedWhileLinuxCncRuns) {
    MachineOptions options;
    options.as_root = false;  // a stock realtime does not run where root is the only user
    const auto body = [] {
        setenv("RTAPI_UID", "65534", 1);  // which a stock realtime of root's asks for
        ASSERT_EQ(std::system("halcmd loadrt threads name1=stock period1=1000000"), 0);
        try {
            client::Client host(start_as(Role::no_namespaces));
            ADD_FAILURE() << "it started";
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr("LinuxCNC"));
        }
        EXPECT_EQ(std::system("halcmd -s show thread | grep -q stock"), 0) << "LinuxCNC was disturbed";
        EXPECT_EQ(std::system("halcmd unloadrt all"), 0);
    };
    on_own_machine(body, options);
}

}  // namespace
}  // namespace plumb
