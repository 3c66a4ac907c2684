// SPDX-License-Identifier: GPL-2.0-or-later
// `plumb doctor` as its users meet it, on computers that have and lack this and that.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <fnmatch.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    fs::permissions(file, static_cast<fs::perms>(0755));
}

// Modules and programs, by path.
using Files = std::map<std::string, std::string>;

Files built_modules() {
    Files files;
    for (const fs::directory_entry& entry : fs::directory_iterator(build_folder() + "/modules"))
        files[entry.path().filename()] = contents(entry.path());
    return files;
}

Files built_declarations() {
    Files files;
    for (const fs::directory_entry& entry : fs::directory_iterator(build_folder() + "/share/plumb"))
        if (entry.path().extension() == ".json") files[entry.path().filename()] = contents(entry.path());
    return files;
}

std::vector<fs::path> built_programs() {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(build_folder() + "/bin"))
        if (entry.path().filename() != "plumb-host") files.push_back(entry.path());
    return files;
}

std::string of_release(std::string bytes, const std::string& release) {
    const std::string line = "@(#)Plumb ";
    const std::size_t at = bytes.find(line + PLUMB_VERSION);
    EXPECT_NE(at, std::string::npos);
    return bytes.replace(at + line.size(), std::string(PLUMB_VERSION).size(), release);
}

std::string of_another_build(std::string bytes) {
    const std::string name("\3\0\0\0GNU\0", 8);  // kind and name of the note with the build's identifier
    const std::size_t at = bytes.find(name);
    EXPECT_NE(at, std::string::npos);
    bytes.at(at + name.size()) ^= 1;
    return bytes;
}

// A computer with Plumb below /tmp, as a build leaves it or as it is installed; programs in /tmp/first are
// found before all others.
class PlumbDoctor : public testing::Test {
protected:
    void on_computer(const std::function<void()>& body) {
        const Files modules = built ? built_modules() : Files(), declarations = built_declarations();
        const std::string python = contents(build_folder() + "/python/plumb.py");
        MachineOptions options;
        options.programs = built_programs();
        options.as_root = as_root;
        const Folder folder;
        for (const auto& [name, bytes] : installed) folder.write(name, bytes);
        fs::permissions(folder.path(), static_cast<fs::perms>(0755));
        if (!installed.empty()) options.modules = folder.path();
        on_own_machine(
            [&] {
                for (const auto& [name, bytes] : modules) write("/tmp/modules/" + name, bytes);
                for (const auto& [name, bytes] : declarations) write("/tmp/share/plumb/" + name, bytes);
                fs::permissions("/tmp/share/plumb", static_cast<fs::perms>(0777));
                const std::string python_folder = built ? "/tmp/python" : "/tmp/lib/python3/dist-packages";
                write(python_folder + "/plumb.py", python);
                setenv("PATH", "/tmp/first:/usr/bin:/bin", 1);
                setenv("PYTHONPATH", python_folder.c_str(), 1);
                if (before) before();
                if (as_root) return body();
                Child user(false, [&](Child&) { body(); });
                user.await_success();
            },
            options);
    }

    static Outcome doctor(const std::string& program = "/tmp/bin/plumb") {
        return run_program({program, "doctor"}, "/tmp");
    }
    static Outcome doctor_of_running() {
        return run_program({"/tmp/bin/plumb", "doctor", "--running"}, "/tmp");
    }

    bool as_root = true;                // else as an ordinary user
    std::function<void()> before;       // done by root to the computer
    bool built = true;                  // else installed
    Files installed = built_modules();  // in LinuxCNC's folder
};

// A part of the output: a mark, a text, and the command below it, if there is one.
struct Finding {
    std::string text;  // with the mark
    std::vector<std::string> commands;
};

// A finding begins with two blanks and its mark; its further lines stand nine blanks in.
std::vector<Finding> findings(const std::string& output) {
    const std::string indent(9, ' ');
    std::vector<Finding> result;
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);) {
        if (result.empty() || line.compare(0, indent.size(), indent) != 0) {
            result.push_back({line, {}});
            continue;
        }
        Finding& last = result.back();
        line.erase(0, indent.size());
        if (line.compare(0, 2, "$ ") == 0)
            last.commands.push_back(line.substr(2));
        else
            (last.commands.empty() ? last.text : last.commands.back()) += " " + line;
    }
    return result;
}

// Whether the output has a finding with this mark and text, in which * stands for anything, and right below
// it this command, or none.
MATCHER_P3(Finds, mark, text, command, "") {
    const std::string start = "  " + std::string(mark) + " ";
    for (const Finding& finding : findings(arg)) {
        if (finding.text.compare(0, start.size(), start) != 0) continue;
        const std::size_t begin = finding.text.find_first_not_of(' ', start.size());
        if (begin == std::string::npos) continue;
        if (fnmatch(std::string(text).c_str(), finding.text.c_str() + begin, FNM_NOESCAPE) != 0) continue;
        if ((finding.commands.empty() ? "" : finding.commands.front()) == std::string(command)) return true;
    }
    return false;
}

const char* const all_is_well = "\nAll is well, apart from the notes.\n";
const char* const one_is_wrong = "\nOne thing is WRONG; the command below fixes it.\n";

// No system call of this process and its children makes a namespace any more: so a container forbids it.
void forbid_namespaces() {
    constexpr auto number = static_cast<unsigned>(offsetof(seccomp_data, nr));
    constexpr auto flags = static_cast<unsigned>(offsetof(seccomp_data, args[0]));
    constexpr unsigned refused = SECCOMP_RET_ERRNO | 1;
    constexpr unsigned spaces = CLONE_NEWUSER | CLONE_NEWIPC | CLONE_NEWPID | CLONE_NEWNS;
    sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, number), BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clone, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, flags),  BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, spaces, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, refused),         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
    const sock_fprog program{static_cast<unsigned short>(std::size(filter)), filter};
    ASSERT_EQ(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
    ASSERT_EQ(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program), 0);
}

TEST_F(PlumbDoctor, ReportsThatAllIsWell) {
    on_computer([] {
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_EQ(outcome.errors, "");
        EXPECT_THAT(outcome.output, Finds("ok", "LinuxCNC 2.9.*", ""));
        EXPECT_THAT(
            outcome.output,
            Finds("ok", "Tried: its halcmd, HAL library and modules work * version of HAL's memory is 16.",
                  ""));
        EXPECT_THAT(outcome.output, Finds("ok", "Linux *", ""));
        EXPECT_THAT(outcome.output, Finds("ok", "Namespaces: every host has a HAL of its own*", ""));
        EXPECT_THAT(outcome.output,
                    Finds("ok", "Plumb " PLUMB_VERSION " in /tmp/bin: plumb, plumb-host*", ""));
        EXPECT_THAT(outcome.output, Finds("ok", "Modules in /tmp/modules: *thermal_displacement*", ""));
        EXPECT_THAT(outcome.output,
                    Finds("ok", "Modules in " STOCK_MODULE_DIR ": *thermal_displacement*", ""));
        EXPECT_THAT(outcome.output, Finds("ok", "Python finds plumb.py: /tmp/python/plumb.py.", ""));
        EXPECT_THAT(outcome.output, Not(HasSubstr("WRONG")));
        EXPECT_THAT(outcome.output, EndsWith(all_is_well));
        EXPECT_THAT(outcome.output, Not(ContainsRegex("[^\n]{101}"))) << "a line is too long";
    });
}

TEST_F(PlumbDoctor, ReadsTheSameToAnOrdinaryUserWhoNeedsSudo) {
    installed.clear();
    as_root = false;
    on_computer([] {
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.output, Finds("ok", "Tried: *", ""));
        EXPECT_THAT(outcome.output, Finds("note", "This user may not schedule in realtime, *", ""));
        EXPECT_THAT(outcome.output, Finds("note", "Not installed: *", "sudo cmake --install /tmp"));
    });
}

TEST_F(PlumbDoctor, NamesInstalledModulesThatDoNotMatch) {
    installed.erase("sim_mill.so");
    installed["sim_drive_load.so"] = of_release(installed["sim_drive_load.so"], "0.0.9");
    installed["sim_part_program.so"] = of_another_build(installed["sim_part_program.so"]);
    installed["gone.so"] = installed["thermal_displacement.so"];
    on_computer([] {
        const std::string folder = STOCK_MODULE_DIR;
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output,
                    Finds("WRONG", "Missing in " + folder + ": sim_mill.", "cmake --install /tmp"));
        EXPECT_THAT(outcome.output,
                    Finds("WRONG",
                          "Not of this Plumb in " + folder +
                              ": sim_drive_load (of Plumb 0.0.9), sim_part_program (of another build).",
                          "cmake --install /tmp"));
        EXPECT_THAT(outcome.output,
                    Finds("WRONG",
                          "Not part of this Plumb, but in " + folder + ": gone (of Plumb " PLUMB_VERSION ").",
                          "rm " + folder + "/gone.so"));
        EXPECT_THAT(outcome.output, EndsWith("\n3 things are WRONG; the command below each fixes it.\n"));
    });
}

TEST_F(PlumbDoctor, InstalledAloneItWantsItsModulesInLinuxCncsFolder) {
    built = false;
    on_computer([] { EXPECT_EQ(doctor().status, 0); });
    installed.clear();
    on_computer([] {
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output, Finds("WRONG", "Missing in " STOCK_MODULE_DIR ": *thermal_displacement*",
                                          "cd PLUMB && scripts/setup product && cmake --install build"));
        EXPECT_THAT(outcome.output, EndsWith(one_is_wrong));
    });
}

TEST_F(PlumbDoctor, StrippedModulesAreTheSame) {
    const Folder folder;
    for (auto& [name, bytes] : installed) {
        const fs::path file = folder.write(name, bytes);
        ASSERT_EQ(std::system(("strip " + file.string()).c_str()), 0);
        ASSERT_NE(contents(file), bytes);
        bytes = contents(file);
    }
    on_computer([] { EXPECT_EQ(doctor().status, 0); });
}

TEST_F(PlumbDoctor, SeesProgramsThatAreMissingOrOfAnotherRelease) {
    on_computer([] {
        write("/tmp/first/plumb", of_release(contents("/tmp/bin/plumb"), "0.0.9"));
        const Outcome another = doctor();
        EXPECT_EQ(another.status, 0) << "the same build, with another text";
        write("/tmp/first/plumb", of_another_build(of_release(contents("/tmp/bin/plumb"), "0.0.9")));
        const Outcome first = doctor();
        EXPECT_EQ(first.status, 1);
        EXPECT_THAT(
            first.output,
            Finds("WRONG", "The first plumb in PATH, /tmp/first/plumb, is another one (of Plumb 0.0.9).",
                  "cmake --install /tmp"));
        fs::remove("/tmp/first/plumb");

        write("/tmp/bin/plumb-host", of_release(contents("/tmp/bin/plumb-host"), "0.0.9"));
        EXPECT_THAT(doctor().output,
                    Finds("WRONG", "Not of this Plumb in /tmp/bin: plumb-host (of Plumb 0.0.9).",
                          "cmake --build /tmp --target product"));
        fs::remove("/tmp/bin/plumb-host");
        const Outcome missing = doctor();
        EXPECT_EQ(missing.status, 1);
        EXPECT_THAT(missing.output, Finds("WRONG", "Missing in /tmp/bin: plumb-host.",
                                          "cmake --build /tmp --target product"));
        EXPECT_THAT(missing.output, EndsWith(one_is_wrong));
    });
}

TEST_F(PlumbDoctor, WithoutLinuxCncItNamesThePackageToInstall) {
    on_computer([] {
        setenv("PATH", "/tmp/first", 1);
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output,
                    Finds("WRONG", "LinuxCNC is not installed*", "apt install linuxcnc-uspace"));
        EXPECT_THAT(outcome.output, EndsWith(one_is_wrong));
    });
}

TEST_F(PlumbDoctor, LinuxCncOfAnotherLineIsWrong) {
    on_computer([] {
        for (const char* version : {"2.10.0~pre0", "2.8.4", "2.90"}) {
            write("/tmp/first/linuxcnc_var", std::string("#!/bin/sh\necho ") + version + "\n");
            const Outcome outcome = doctor();
            EXPECT_EQ(outcome.status, 1);
            EXPECT_THAT(
                outcome.output,
                Finds("WRONG", std::string("LinuxCNC ") + version + ": this Plumb was built for 2.9. *",
                      "apt install --allow-downgrades 'linuxcnc-uspace=*2.9*'"));
        }
    });
}

TEST_F(PlumbDoctor, TriesHal) {
    installed["lowpass.so"] = "no module";
    on_computer([] {
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output,
                    Finds("WRONG", "Its HAL does not work in Plumb's host: lowpass: dlopen: *",
                          "apt install --reinstall linuxcnc-uspace"));
    });
}

TEST_F(PlumbDoctor, TriesAModuleOfPlumbs) {
    built = false;
    installed["sim_drive_load.so"] = "no module @(#)Plumb " PLUMB_VERSION;
    on_computer([] {
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output,
                    Finds("WRONG", "A module of Plumb's does not work in the host: sim_drive_load: dlopen: *",
                          "cd PLUMB && scripts/setup product && cmake --install build"));
        EXPECT_THAT(outcome.output, EndsWith(one_is_wrong));
    });
}

// Settings as they are on other kernels, too.
void set_all_that_forbid_namespaces() {
    ASSERT_EQ(mount("tmpfs", "/proc/sys", "tmpfs", 0, "mode=755"), 0);
    write("/proc/sys/user/max_pid_namespaces", "0\n");
    write("/proc/sys/kernel/unprivileged_userns_clone", "0\n");
    write("/proc/sys/kernel/apparmor_restrict_unprivileged_userns", "1\n");
}

TEST_F(PlumbDoctor, NamesTheSettingThatForbidsNamespacesToRoot) {
    if (geteuid() != 0) GTEST_SKIP() << "not root";
    on_computer([] {
        set_all_that_forbid_namespaces();
        EXPECT_THAT(doctor().output, Finds("ok", "Namespaces: *", "")) << "a working setup gets no advice";
        forbid_namespaces();
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.output, Finds("ok", "Tried: *", ""));
        EXPECT_THAT(outcome.output,
                    Finds("note",
                          "No namespaces: one host at a time, none while LinuxCNC runs, and plumb run needs "
                          "--no-namespaces.",
                          ""));
        EXPECT_THAT(outcome.output, Finds("note", "The reason: user.max_pid_namespaces is 0.",
                                          "sysctl -w user.max_pid_namespaces=10000"));
        EXPECT_THAT(outcome.output, Not(HasSubstr("unprivileged")));
        EXPECT_THAT(outcome.output, EndsWith(all_is_well));
    });
}

TEST_F(PlumbDoctor, NamesTheSettingThatForbidsNamespacesToOrdinaryUsers) {
    as_root = false;
    before = set_all_that_forbid_namespaces;
    on_computer([] {
        forbid_namespaces();
        const std::string output = doctor().output;
        EXPECT_THAT(output, Finds("note", "The reason: user.max_pid_namespaces is 0.",
                                  "sudo sysctl -w user.max_pid_namespaces=10000"));
        EXPECT_THAT(output, Finds("note", "The reason: kernel.unprivileged_userns_clone is 0.",
                                  "sudo sysctl -w kernel.unprivileged_userns_clone=1"));
        EXPECT_THAT(output, Finds("note", "The reason: kernel.apparmor_restrict_unprivileged_userns is 1.",
                                  "sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0"));
    });
}

TEST_F(PlumbDoctor, ReportsThatAFilterForbidsNamespaces) {
    as_root = false;
    on_computer([] {
        forbid_namespaces();
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.output, Finds("note", "The reason may be a filter of system calls *",
                                          "docker run --privileged ..."));
    });
}

TEST_F(PlumbDoctor, WithoutNamespacesItDoesNotDisturbLinuxCnc) {
    as_root = false;  // a stock realtime does not run where root is the only user
    on_computer([] {
        ASSERT_EQ(std::system("halcmd loadrt threads name1=stock period1=1000000"), 0);
        EXPECT_THAT(doctor().output, Finds("ok", "It is running now: rtapi_app, process *.", ""));
        forbid_namespaces();
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 0);
        EXPECT_THAT(outcome.output,
                    Finds("note", "No host starts while LinuxCNC runs (rtapi_app, process *).", ""));
        EXPECT_EQ(std::system("halcmd unloadrt all"), 0);
    });
}

TEST_F(PlumbDoctor, RunningItFindsEachWrongOrderAndItsCommandsMendIt) {
    as_root = false;
    on_computer([] {
        const auto halcmd = [](const std::string& command) {
            ASSERT_EQ(std::system(("halcmd " + command).c_str()), 0) << command;
        };
        const auto await_fault_code = [](const std::string& code) {
            const std::string test = "halcmd getp interlock.fault-code | grep -qx " + code;
            for (int n = 0; std::system(test.c_str()) != 0; ++n) {
                ASSERT_LT(n, 100) << "fault-code does not become " << code;
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            }
        };
        EXPECT_THAT(doctor_of_running().output, Finds("WRONG", "No HAL runs here: *", "linuxcnc my.ini"));
        halcmd("loadrt threads name1=servo-thread period1=1000000 name2=slow period2=10000000");
        halcmd("loadrt lowpass names=motion-controller,filter");
        halcmd("loadrt squareness names=square interlock=no");
        halcmd("loadrt joint_offset names=x-stage,y-stage interlock=no");
        EXPECT_THAT(doctor_of_running().output,
                    Finds("WRONG", "square.update is in no thread, so it is never called; *",
                          "halcmd addf square.update servo-thread"));
        for (const char* function : {"x-stage.update", "filter", "motion-controller", "square.update",
                                     "x-stage.update-feedback", "y-stage.update-feedback"})
            halcmd(std::string("addf ") + function + " servo-thread");
        halcmd("addf y-stage.update slow");
        halcmd("loadrt interlock names=interlock functions=0 stages=0");
        halcmd("addf interlock.update servo-thread 3");
        halcmd("start");
        await_fault_code("4");

        const Outcome wrong = doctor_of_running();
        EXPECT_EQ(wrong.status, 1);
        EXPECT_THAT(wrong.output, EndsWith("\n5 things are WRONG; the command below each fixes it.\n"));
        EXPECT_THAT(wrong.output,
                    Finds("WRONG",
                          "x-stage.update runs before motion-controller, square.update and 2 more in "
                          "servo-thread; it belongs after them.",
                          "halcmd delf x-stage.update servo-thread && halcmd addf x-stage.update "
                          "servo-thread 7"));
        EXPECT_THAT(wrong.output, Finds("WRONG", "y-stage.update is in slow; it belongs in servo-thread, *",
                                        "halcmd delf y-stage.update slow && halcmd addf y-stage.update "
                                        "servo-thread"));
        for (const Finding& finding : findings(wrong.output))
            for (const std::string& command : finding.commands)
                EXPECT_EQ(std::system(command.c_str()), 0) << command;
        const Outcome right = doctor_of_running();
        EXPECT_EQ(right.status, 0) << right.output;
        EXPECT_THAT(right.output,
                    Finds("ok",
                          "In order in servo-thread: x-stage.update-feedback, y-stage.update-feedback, "
                          "motion-controller, square.update, x-stage.update, y-stage.update, "
                          "interlock.update.",
                          ""));
        EXPECT_THAT(right.output, EndsWith("\nAll is well.\n"));
        await_fault_code("0");

        fs::remove("/tmp/share/plumb/squareness.json");
        EXPECT_THAT(doctor_of_running().output,
                    Finds("WRONG", "Missing or damaged: /tmp/share/plumb/squareness.json.",
                          "cmake --build /tmp --target product"));
        halcmd("unloadrt all");
    });
}

TEST_F(PlumbDoctor, WithoutNamespacesItDoesNotWaitLongForAnotherHost) {
    on_computer([] {
        client::Start start;
        start.executable = host_of_machine;
        start.namespaces = false;
        const client::Client another(start);
        forbid_namespaces();
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output, Finds("WRONG", "No host starts: plumb-host has not answered for 10 s.",
                                          "pgrep -a plumb-host"));
    });
}

TEST_F(PlumbDoctor, ExtrasAreNotes) {
    on_computer([] {
        for (const fs::directory_entry& entry : fs::directory_iterator("/usr/lib"))
            if (const fs::path folder = entry.path() / "faketime"; fs::is_directory(folder)) {
                ASSERT_EQ(mount("tmpfs", folder.c_str(), "tmpfs", 0, ""), 0);
            }
        write("/tmp/first/python3", "#!/bin/sh\nexit 1\n");
        unsetenv("PYTHONPATH");
        unsetenv("DISPLAY");
        unsetenv("WAYLAND_DISPLAY");
        const Outcome outcome = doctor();
        EXPECT_THAT(outcome.output, Finds("note", "No libfaketime: *", "apt install libfaketime"));
        EXPECT_THAT(outcome.output, Finds("note", "The first python3 in PATH, /tmp/first/python3, lacks *",
                                          "export PATH=/usr/bin:$PATH"));
        EXPECT_THAT(outcome.output, Finds("note", "No display: *", ""));
        EXPECT_EQ(outcome.status, 0);
    });
}

TEST_F(PlumbDoctor, KnowsARealtimeKernel) {
    on_computer([] {
        ASSERT_EQ(mount("tmpfs", "/sys/kernel", "tmpfs", 0, "mode=755"), 0);
        write("/sys/kernel/realtime", "1\n");
        EXPECT_THAT(doctor().output, Finds("ok", "It is a realtime kernel (PREEMPT_RT).", ""));
    });
}

TEST_F(PlumbDoctor, AdvisesAKernelThatTheComputerBoots) {
    on_computer([] {
        for (const char* folder : {"/sys/kernel", "/sys/firmware"})
            ASSERT_EQ(mount("tmpfs", folder, "tmpfs", 0, "mode=755"), 0);
        const std::string debians = "apt install linux-image-rt-$(dpkg --print-architecture)";
        const std::string model = "/sys/firmware/devicetree/base/model";
        if (contents("/proc/version").find("PREEMPT_RT") != std::string::npos) GTEST_SKIP() << "it is one";
        EXPECT_THAT(doctor().output,
                    Finds("note", "It is no realtime kernel (PREEMPT_RT)*a machine does.", debians));
        write(model, std::string("Radxa ROCK 5B\0", 14));
        EXPECT_THAT(doctor().output,
                    Finds("note", "It is no realtime kernel (PREEMPT_RT)*a machine does.", debians));
        write(model, std::string("Raspberry Pi 5 Model B Rev 1.0\0", 31));
        EXPECT_THAT(
            doctor().output,
            Finds("note", "It is no realtime kernel (PREEMPT_RT)* does not boot Debian's: *kernel8_rt.img*",
                  "apt install linux-image-rpi-v8-rt"));
    });
}

TEST_F(PlumbDoctor, AnotherPlumbForPythonIsWrong) {
    on_computer([] {
        write("/tmp/other/plumb.py", contents("/tmp/python/plumb.py") + "\n");
        setenv("PYTHONPATH", "/tmp/other", 1);
        const Outcome outcome = doctor();
        EXPECT_EQ(outcome.status, 1);
        EXPECT_THAT(outcome.output,
                    Finds("WRONG", "Python finds a plumb.py that is not of this Plumb: /tmp/other/plumb.py.",
                          "export PYTHONPATH=/tmp/python"));
    });
}

TEST_F(PlumbDoctor, AFolderThatIsCalledPlumbIsNoPythonModule) {
    on_computer([] {
        unsetenv("PYTHONPATH");
        fs::create_directories("/tmp/plumb");
        EXPECT_THAT(doctor().output,
                    Finds("note", "Python does not find plumb.py.", "export PYTHONPATH=/tmp/python"));
    });
}

TEST(PlumbDoctorCommand, TakesNoArguments) {
    const Outcome outcome = run_program({build_folder() + "/bin/plumb", "doctor", "now"}, "/");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.errors, HasSubstr("now"));
}

}  // namespace
}  // namespace plumb
