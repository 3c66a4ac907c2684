// SPDX-License-Identifier: GPL-2.0-or-later
// However a plumb run ends: its exit status is the one that is documented, nothing of it is left, and the
// next one works. With halrun and with a complete LinuxCNC, under libfaketime.
#include "tests/support/folder.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <tuple>

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
    write_program("screen", "#!/bin/sh\ntouch ready\necho ready\nwhile [ ! -e end ]; do sleep 0.2; done\n");
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
    if (ending == Ending::control_c) return run_on_terminal(words, work, "ready", "\x03");
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
    options.programs = {BUILD_DIR "/bin/plumb"};
    on_own_machine(
        [this] {
            write_subjects();
            const auto mounts_before = mounts();
            Child child(role != Role::user, [this](Child&) {
                const Outcome outcome = run_until(ending, subject, role);
                EXPECT_EQ(outcome.status, status_of(ending, subject)) << outcome.output << outcome.errors;
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
