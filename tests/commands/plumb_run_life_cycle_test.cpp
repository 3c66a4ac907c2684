// SPDX-License-Identifier: GPL-2.0-or-later
// However a plumb run ends: its exit status is the one that is documented, nothing of it is left, and the
// next one works. With halrun and with a complete LinuxCNC, under libfaketime.
#include "tests/support/folder.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <vector>

namespace plumb {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

enum class Subject { halrun, linuxcnc };
enum class Ending {
    normal,
    control_c,
    sigterm,
    keeper_killed,
    host_killed,
    program_killed,
    component_killed
};

const std::filesystem::path work = "/tmp/work";

void write_program(const std::string& name, const std::string& text) {
    std::ofstream(work / name) << text;
    std::filesystem::permissions(work / name, static_cast<std::filesystem::perms>(0755));
}

// The parts of both subjects. Both show that they are ready, then wait for a file that is called end.
void write_subjects() {
    std::filesystem::create_directory(work);
    std::filesystem::permissions(work, std::filesystem::perms::all);
    write_program("screen", "#!/bin/sh\ntouch ready\necho begun\nwhile [ ! -e end ]; do sleep 0.2; done\n");
    std::filesystem::create_symlink("/bin/sleep", work / "component");
    std::ofstream(work / "wait.hal") << R"(
loadrt threads name1=servo-thread period1=1000000
start
loadusr ./component 100000
loadusr -w ./screen
)";
    std::ofstream(work / "again.hal") << R"(
loadrt threads name1=servo-thread period1=1000000
start
show thread
)";
    std::ofstream(work / "machine.hal") << R"(
loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net position joint.0.motor-pos-cmd => joint.0.motor-pos-fb
net enable iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
)";
    std::ofstream(work / "machine.ini") << R"(
[EMC]
VERSION = 1.1
[DISPLAY]
DISPLAY = ./screen
[TASK]
TASK = milltask
CYCLE_TIME = 0.01
[RS274NGC]
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
[EMCIO]
EMCIO = io
[HAL]
HALFILE = machine.hal
[KINS]
KINEMATICS = trivkins coordinates=X
JOINTS = 1
[TRAJ]
COORDINATES = X
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
[AXIS_X]
MAX_VELOCITY = 100
MAX_ACCELERATION = 1000
[JOINT_0]
TYPE = LINEAR
MAX_VELOCITY = 100
MAX_ACCELERATION = 1000
)";
}

std::string mounts() {
    return contents("/proc/self/mounts");
}

void await_ready() {
    for (const auto deadline = Clock::now() + 15s; !std::filesystem::exists(work / "ready");) {
        if (Clock::now() > deadline) throw std::runtime_error("the program is not ready");
        std::this_thread::sleep_for(5ms);
    }
}

pid_t first_child_of(pid_t process) {
    const std::string number = std::to_string(process);
    std::ifstream children("/proc/" + number + "/task/" + number + "/children");
    pid_t child = 0;
    if (!(children >> child)) throw std::runtime_error("process " + number + " has no child");
    return child;
}

pid_t victim(Ending ending, Subject subject, pid_t keeper) {
    switch (ending) {
        case Ending::keeper_killed: return keeper;
        case Ending::host_killed: return first_child_of(keeper);
        case Ending::program_killed: return first_child_of(first_child_of(keeper));
        default: return Processes::called(subject == Subject::halrun ? "component" : "milltask");
    }
}

// At ten times the clock, so that libfaketime takes part.
std::vector<std::string> plumb_run(Role role, const std::vector<std::string>& program) {
    std::vector<std::string> words{"/tmp/bin/plumb", "run", "--speed", "10"};
    if (role == Role::no_namespaces) words.push_back("--no-namespaces");
    words.insert(words.end(), program.begin(), program.end());
    return words;
}

Outcome run_until(Ending ending, Subject subject, Role role) {
    const auto words = plumb_run(role, subject == Subject::halrun
                                           ? std::vector<std::string>{"halrun", "-f", "wait.hal"}
                                           : std::vector<std::string>{"linuxcnc", "-r", "machine.ini"});
    if (ending == Ending::control_c) return run_on_terminal(words, work, "begun", "\x03");
    return run_program(words, work, [&](pid_t keeper) {
        await_ready();
        if (ending == Ending::sigterm)
            kill(keeper, SIGTERM);
        else if (ending != Ending::normal)
            kill(victim(ending, subject, keeper), SIGKILL);
        if (ending == Ending::normal || ending == Ending::component_killed) std::ofstream(work / "end");
    });
}

// The exit status of the program: halrun does not catch SIGTERM, and fails when its child is killed from
// the terminal; the linuxcnc script cleans up in all these cases.
int status_of(Ending ending, Subject subject) {
    switch (ending) {
        case Ending::normal: return 0;
        case Ending::control_c: return subject == Subject::halrun ? 1 : 0;
        case Ending::sigterm: return subject == Subject::halrun ? 128 + SIGTERM : 0;
        case Ending::component_killed: return 0;
        default: return 128 + SIGKILL;
    }
}

class PlumbRunEnds : public testing::TestWithParam<std::tuple<Subject, Role, Ending>> {
protected:
    const Subject subject = std::get<Subject>(GetParam());
    const Role role = std::get<Role>(GetParam());
    const Ending ending = std::get<Ending>(GetParam());
};

TEST_P(PlumbRunEnds, WithItsStatusAndLeavesNothing) {
    MachineOptions options = machine_of(role);
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [this] {
            write_subjects();
            const auto mounts_before = mounts();
            Child child(role != Role::user, [this](Child&) {
                const Outcome outcome = run_until(ending, subject, role);
                EXPECT_EQ(outcome.status, status_of(ending, subject)) << outcome.output << outcome.errors;
                if (ending == Ending::sigterm) {
                    EXPECT_THAT(outcome.errors,
                                HasSubstr("a signal (SIGTERM or SIGHUP) asked the run to end"));
                }
            });
            child.await_success();
            expect_nothing_left({work});
            EXPECT_EQ(mounts(), mounts_before);
            Child next(role != Role::user, [this](Child&) {
                const Outcome outcome = run_program(plumb_run(role, {"halrun", "-f", "again.hal"}), work);
                EXPECT_EQ(outcome.status, 0) << outcome.errors;
                EXPECT_THAT(outcome.output, HasSubstr("servo-thread"));
            });
            next.await_success();
            expect_nothing_left({work});
        },
        options);
}

void add_with_children(pid_t process, std::vector<pid_t>& found) {
    found.push_back(process);
    const std::string number = std::to_string(process);
    std::ifstream children("/proc/" + number + "/task/" + number + "/children");
    for (pid_t child = 0; children >> child;) add_with_children(child, found);
}

// As an out-of-memory killer does, or a terminal that is closed by force: none of them sees another's death.
void kill_all_at_once(pid_t keeper) {
    std::vector<pid_t> group;
    add_with_children(keeper, group);
    for (const int signal : {SIGSTOP, SIGKILL})
        for (const pid_t process : group) kill(process, signal);
}

class PlumbRunKilledAsAGroup : public testing::TestWithParam<Role> {
protected:
    const Role role = GetParam();

    static bool is_there(const std::string& file) {
        return std::filesystem::exists(std::filesystem::symlink_status(file));
    }
    static std::vector<std::string> folders_of_hosts() {
        std::vector<std::string> found;
        for (const std::string& file : files())
            if (file.rfind("/tmp/plumb-host-", 0) == 0) found.push_back(file);
        return found;
    }
    void start_again() const {
        const Outcome outcome = run_program(plumb_run(role, {"true"}), work);
        EXPECT_EQ(outcome.status, 0) << outcome.errors;
    }
};

// Of another user, of a host that lives, and files that only look alike.
TEST_P(PlumbRunKilledAsAGroup, LeavesWhatTheNextStartRemovesAndNothingElse) {
    MachineOptions options = machine_of(role);
    options.programs = {build_folder() + "/bin/plumb"};
    const bool there_are_strangers = role == Role::root && geteuid() == 0;
    on_own_machine(
        [this, there_are_strangers] {
            write_subjects();
            std::filesystem::create_directory("/tmp/target");
            std::ofstream("/tmp/target/rtapi") << "mine";
            std::filesystem::create_symlink("/tmp/target", "/tmp/plumb-host-linked");
            std::ofstream("/tmp/plumb-host-filefi");
            std::vector<std::string> others = {work, "/tmp/target", "/tmp/plumb-host-linked",
                                               "/tmp/plumb-host-filefi"};
            Child child(role != Role::user, [&](Child& self) {
                std::filesystem::create_directories("/tmp/plumb-host-myname-x");
                std::filesystem::create_directories("/tmp/plumb-host-filled/mine");
                self.say("made");
                self.await_go();
                run_program(plumb_run(role, {"./screen"}), work, [](pid_t keeper) {
                    await_ready();
                    kill_all_at_once(keeper);
                });
                self.say("killed");
                self.await_go();
                start_again();
            });
            child.hear();
            others.insert(others.end(), {"/tmp/plumb-host-myname-x", "/tmp/plumb-host-filled"});
            if (there_are_strangers) {
                Child stranger(false,
                               [](Child&) { std::filesystem::create_directory("/tmp/plumb-host-strang"); });
                stranger.await_success();
                others.emplace_back("/tmp/plumb-host-strang");
            }
            const std::size_t before = folders_of_hosts().size();
            child.go();
            child.hear();
            for (int turn = 0; turn < 40; ++turn) {  // init takes in the dead
                waitpid(-1, nullptr, WNOHANG);
                std::this_thread::sleep_for(5ms);
            }
            EXPECT_EQ(folders_of_hosts().size(), before + 1) << "nothing was left to be removed";
            child.go();
            child.await_success();
            expect_nothing_left(others);
            for (const std::string& other : others) EXPECT_TRUE(is_there(other)) << other;
            EXPECT_EQ(contents("/tmp/target/rtapi"), "mine");
        },
        options);
}

TEST_P(PlumbRunKilledAsAGroup, DoesNotTakeALivingRunWithIt) {
    if (role == Role::no_namespaces) GTEST_SKIP() << "there is one host at a time";
    MachineOptions options = machine_of(role);
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [this] {
            write_subjects();
            Child child(role != Role::user, [this](Child&) {
                const Outcome living = run_program(plumb_run(role, {"./screen"}), work, [this](pid_t) {
                    await_ready();
                    const auto of_living = folders_of_hosts();
                    ASSERT_EQ(of_living.size(), 1u);
                    const std::string socket = of_living.front() + "/rtapi";
                    for (const bool listening : {true, false}) {  // its lock protects it alone, too
                        if (!listening) std::filesystem::remove(socket);
                        start_again();
                        EXPECT_EQ(folders_of_hosts(), of_living);
                    }
                    std::ofstream(work / "end");
                });
                EXPECT_EQ(living.status, 0) << living.errors;
            });
            child.await_success();
            expect_nothing_left({work});
        },
        options);
}

INSTANTIATE_TEST_SUITE_P(, PlumbRunKilledAsAGroup,
                         testing::Values(Role::root, Role::user, Role::no_namespaces),
                         [](const auto& instance) { return plumb::name_of(instance.param); });

TEST(ATestThatIsKilled, TakesItsRunWithIt) {
    MachineOptions options;
    options.programs = {build_folder() + "/bin/plumb"};
    on_own_machine(
        [] {
            Child test(true, [](Child& self) {
                run_program(plumb_run(Role::root, {"sleep", "1000"}), "/tmp", [&](pid_t) {
                    Processes::called("sleep");
                    self.say("it runs");
                });
            });
            test.hear();
            test.kill();
            expect_nothing_left(files());
        },
        options);
}

std::string name_of(Subject subject) {
    return subject == Subject::halrun ? "Halrun" : "LinuxCnc";
}

std::string name_of(Ending ending) {
    switch (ending) {
        case Ending::normal: return "Normally";
        case Ending::control_c: return "ByControlC";
        case Ending::sigterm: return "BySigterm";
        case Ending::keeper_killed: return "ByDeathOfTheKeeper";
        case Ending::host_killed: return "ByDeathOfTheHost";
        case Ending::program_killed: return "ByDeathOfTheProgram";
        case Ending::component_killed: return "AfterDeathOfAComponent";
    }
    return "";
}

INSTANTIATE_TEST_SUITE_P(, PlumbRunEnds,
                         testing::Combine(testing::Values(Subject::halrun, Subject::linuxcnc),
                                          testing::Values(Role::root, Role::user, Role::no_namespaces),
                                          testing::Values(Ending::normal, Ending::control_c, Ending::sigterm,
                                                          Ending::keeper_killed, Ending::host_killed,
                                                          Ending::program_killed, Ending::component_killed)),
                         [](const auto& instance) {
                             return name_of(std::get<Subject>(instance.param)) +
                                    plumb::name_of(std::get<Role>(instance.param)) +
                                    name_of(std::get<Ending>(instance.param));
                         });

}  // namespace
}  // namespace plumb
