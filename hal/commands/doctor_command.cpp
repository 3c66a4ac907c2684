// SPDX-License-Identifier: GPL-2.0-or-later
// plumb doctor: reports what is here, what is missing, and the command that fixes it.

#include <linux/can.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "hal/client/client.hpp"
#include "hal/command_line.hpp"
#include "hal/commands/command.hpp"
#include "hal/commands/installation.hpp"
#include "hal/commands/running_threads.hpp"
#include "hal/host/faketime_library.hpp"
#include "hal/linuxcnc_series.hpp"
#include "hal/markup.hpp"
#include "products.hpp"

namespace plumb::commands {
namespace {

namespace fs = std::filesystem;

enum class Mark { ok, note, wrong };

struct Finding {
    Mark mark;
    std::string text;
    std::string command = {};  // that fixes it
};

using Findings = std::vector<Finding>;

// --- small helpers ---

// The first line of a file; empty without one.
std::string first_line(const fs::path& file) {
    std::string line;
    std::ifstream in(file);
    std::getline(in, line);
    return line;
}

// What a command of the shell's prints, without the last line end; nothing unless it succeeds.
std::optional<std::string> output_of(const std::string& command) {
    FILE* const pipe = popen((command + " 2>/dev/null").c_str(), "r");
    if (!pipe) return std::nullopt;
    std::string output;
    for (int c; (c = std::getc(pipe)) != EOF;) output += static_cast<char>(c);
    if (pclose(pipe) != 0) return std::nullopt;
    return output.substr(0, output.find_last_not_of('\n') + 1);
}

std::string as_root(const std::string& command) {
    return (geteuid() == 0 ? "" : "sudo ") + command;
}

std::string joined(const Texts& words) {
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : ", ") + word;
    return result;
}

Texts split(const std::string& list) {
    Texts words;
    std::istringstream in(list);
    for (std::string word; std::getline(in, word, ',');) words.push_back(word);
    return words;
}

// A process of this name, with its number; empty when none runs.
std::string running(const std::string& name) {
    std::error_code ended;
    for (const fs::directory_entry& entry : fs::directory_iterator("/proc", ended))
        if (first_line(entry.path() / "comm") == name)
            return name + ", process " + entry.path().filename().string();
    return "";
}

std::string running_realtime() {
    return running("rtapi_app");
}

// Where the files of this Plumb are.
struct Home {
    fs::path program = fs::read_symlink("/proc/self/exe");
    fs::path programs = program.parent_path();
    fs::path root = programs.parent_path();
    bool built = fs::is_directory(root / "modules");  // else installed

    std::string build_again() const {
        return built ? "cmake --build " + root.string() + " --target product" : install_again();
    }
    bool from_package() const {
        return !built && output_of("dpkg-query --search '" + program.string() + "'").has_value();
    }
    std::string install_again() const {
        if (built) return as_root("cmake --install " + root.string());
        if (from_package()) return as_root("apt install --reinstall ./plumb_*.deb");
        return "cd PLUMB && scripts/setup product && " + as_root("cmake --install build");
    }
};

// --- HAL, tried ---

// What a host did that was started for this.
struct Trial {
    std::string not_started;  // why
    bool given_up = false;    // waiting for it
    bool namespaces = false;
    int hal_version = 0;
    std::string stock_failed;  // with LinuxCNC's own modules: why
    std::string own_failed;    // with one of Plumb's: why
};

// What goes wrong when a module is loaded and run for ten periods; empty when `pin` has its value then.
std::string failure_of(client::Client& host, const Texts& lines, const std::string& pin, double value) try {
    for (const std::string& line : lines) host.command(line);
    host.run(std::chrono::milliseconds(10));
    std::ostringstream difference;
    if (host.get(pin) != value) difference << pin << " is " << host.get(pin) << ", not " << value;
    return difference.str();
} catch (const std::runtime_error& error) {
    const std::string words = error.what();
    return words.substr(0, words.find('\n'));  // further lines come from programs that pass the failure on
}

// Half of the way to 1024 is left after each period; the first one of LinuxCNC 2.10 is for functions of initf
// alone.
#ifdef PLUMB_LINUXCNC_2_10
constexpr double after_ten_periods = 1022;
#else
constexpr double after_ten_periods = 1023;
#endif

Trial try_hal() try {
    client::Client host;
    Trial trial;
    trial.namespaces = host.namespaces();
    trial.stock_failed =
        failure_of(host,
                   {"loadrt threads name1=thread period1=1000000", "loadrt lowpass names=stock",
                    "addf stock thread", "setp stock.gain 0.5", "setp stock.in 1024", "start"},
                   "stock.out", after_ten_periods);
    trial.hal_version = host.hal_version();
    if (trial.stock_failed.empty())
        trial.own_failed = failure_of(host,
                                      {"loadrt sim_drive_load names=own", "addf own.update thread",
                                       "setp own.coolant-load 7", "setp own.coolant 1"},
                                      "own.truth-load", 7);
    return trial;
} catch (const std::runtime_error& error) {
    Trial trial;
    trial.not_started = error.what();
    return trial;
}

// The same, but a host that does not answer is left behind: it ends with this program.
Trial try_hal_for_a_while() {
    constexpr auto patience = std::chrono::seconds(10);
    std::packaged_task<Trial()> task(try_hal);
    std::future<Trial> trial = task.get_future();
    std::thread(std::move(task)).detach();
    if (trial.wait_for(patience) == std::future_status::ready) return trial.get();
    Trial given_up;
    given_up.given_up = true;
    given_up.not_started = "plumb-host has not answered for 10 s";
    return given_up;
}

// --- the checks, one for each group ---

std::optional<std::string> linuxcnc_version() {
    return output_of("linuxcnc_var LINUXCNCVERSION");
}

Findings linuxcnc(const Trial& trial) {
    const auto version = linuxcnc_version();
    if (!version)
        return {{Mark::wrong, "LinuxCNC is not installed: there is no linuxcnc_var in PATH.",
                 as_root("apt install linuxcnc-uspace")}};
    Findings findings;
    const std::string series = hal::linuxcnc_series;
    const bool fits = version->rfind(series, 0) == 0 &&
                      !std::isdigit(static_cast<unsigned char>(version->c_str()[series.size()]));
    if (fits)
        findings.push_back({Mark::ok, "LinuxCNC " + *version + "."});
    else
        findings.push_back({Mark::wrong,
                            "LinuxCNC " + *version + ": this Plumb was built for " + series +
                                ". plumb-host and interlock work with this series only. Install the package "
                                "of Plumb for your "
                                "LinuxCNC, build Plumb again, or install LinuxCNC " +
                                series + " again.",
                            as_root("apt install --allow-downgrades 'linuxcnc-uspace=*" + series + "*'")});
    if (!trial.stock_failed.empty())
        findings.push_back({Mark::wrong, "Its HAL does not work in Plumb's host: " + trial.stock_failed,
                            as_root("apt install --reinstall linuxcnc-uspace")});
    else if (trial.not_started.empty())
        findings.push_back({Mark::ok,
                            "Tried: its halcmd, HAL library and modules work in virtual time, through the "
                            "realtime interface of " +
                                series + "; the version of HAL's memory is " +
                                std::to_string(trial.hal_version) + '.'});
    const std::string realtime = running_realtime();
    if (!realtime.empty()) findings.push_back({Mark::ok, "It is running now: " + realtime + '.'});
    return findings;
}

// Of a computer whose firmware looks for a kernel of its own make. The text ends with a zero byte.
bool is_raspberry_pi() {
    return first_line("/sys/firmware/devicetree/base/model").rfind("Raspberry Pi", 0) == 0;
}

Finding no_realtime_kernel() {
    const std::string what =
        "It is no realtime kernel (PREEMPT_RT), which virtual time does not need, but a machine does.";
    if (is_raspberry_pi())
        return {Mark::note,
                what +
                    " A Raspberry Pi does not boot Debian's: take the image for it from linuxcnc.org, or, in "
                    "Raspberry Pi OS, this kernel, and write kernel=kernel8_rt.img into "
                    "/boot/firmware/config.txt.",
                as_root("apt install linux-image-rpi-v8-rt")};
    return {Mark::note, what, as_root("apt install linux-image-rt-$(dpkg --print-architecture)")};
}

Findings kernel(const Trial&) {
    utsname system{};
    uname(&system);
    Findings findings{
        {Mark::ok, std::string(system.sysname) + ' ' + system.release + ' ' + system.machine + "."}};
    if (first_line("/sys/kernel/realtime") == "1" || std::strstr(system.version, "PREEMPT_RT"))
        findings.push_back({Mark::ok, "It is a realtime kernel (PREEMPT_RT)."});
    else
        findings.push_back(no_realtime_kernel());
    const int can = socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);  // the kernel loads what it has for it
    if (can >= 0) close(can);
    findings.push_back(can >= 0 ? Finding{Mark::ok, "It has CAN, for sensors on a CAN bus."}
                                : Finding{Mark::note,
                                          "It has no CAN, so sensors on a CAN bus cannot be read; Debian's "
                                          "own kernels have it."});
    return findings;
}

// Why the kernel gives no namespaces.
Findings refusals() {
    Findings findings;
    const auto setting = [&](const std::string& name, const std::string& forbidden, const std::string& good) {
        std::string file = name;
        std::replace(file.begin(), file.end(), '.', '/');
        if (first_line("/proc/sys/" + file) == forbidden)
            findings.push_back({Mark::note, "The reason: " + name + " is " + forbidden + '.',
                                as_root("sysctl -w " + name + '=' + good)});
    };
    for (const char* kind : {"user", "ipc", "pid", "mnt"})
        setting(std::string("user.max_") + kind + "_namespaces", "0", "10000");
    if (geteuid() != 0) {
        setting("kernel.unprivileged_userns_clone", "0", "1");
        setting("kernel.apparmor_restrict_unprivileged_userns", "1", "0");
    }
    if (!findings.empty()) return findings;
    if (prctl(PR_GET_SECCOMP, 0, 0, 0, 0) == SECCOMP_MODE_FILTER)
        return {{Mark::note, "The reason may be a filter of system calls (seccomp), as containers have it.",
                 "docker run --privileged ..."}};
    return {{Mark::note, "This program does not know the reason; the kernel may tell more.",
             "unshare --user --map-root-user --ipc --pid --fork --mount-proc true"}};
}

// Whether the system does not find a library of plumb-host, which then ends before it can report anything.
bool lacks_library() {
    const std::string command = "ldd '" + (Home().programs / "plumb-host").string() + "' 2>&1";
    FILE* const pipe = popen(command.c_str(), "r");
    if (!pipe) return false;
    std::string text;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    return text.find("not found") != std::string::npos;
}

Findings isolation(const Trial& trial) {
    if (trial.namespaces)
        return {{Mark::ok,
                 "Namespaces: every host has a HAL of its own, beside other hosts and a running LinuxCNC."}};
    const Home home;
    if (!fs::exists(home.programs / "plumb-host"))
        return {{Mark::note, "Not known: without plumb-host, no host could be started."}};
    Findings findings;
    const std::string realtime = running_realtime();
    if (!trial.not_started.empty() && !realtime.empty())
        findings.push_back({Mark::note, "No host starts while LinuxCNC runs (" + realtime + ")."});
    else if (!trial.not_started.empty())
        findings.push_back({Mark::wrong, "No host starts: " + trial.not_started + '.',
                            trial.given_up ? "pgrep -a plumb-host"
                            : lacks_library()
                                ? "ldd " + (home.programs / "plumb-host").string() +
                                      " | grep 'not found'; the package of each is to be installed"
                                : "halrun -U"});
    findings.push_back({Mark::note,
                        "No namespaces: one host at a time, none while LinuxCNC runs, and plumb run needs "
                        "--no-namespaces."});
    const Findings reasons = refusals();
    findings.insert(findings.end(), reasons.begin(), reasons.end());
    return findings;
}

bool may_schedule_realtime() {
    const sched_param lowest{sched_get_priority_min(SCHED_FIFO)};
    const sched_param none{};
    return sched_setscheduler(0, SCHED_FIFO, &lowest) == 0 && sched_setscheduler(0, SCHED_OTHER, &none) == 0;
}

Findings realtime(const Trial&) {
    Findings findings;
    rlimit lock{};
    getrlimit(RLIMIT_MEMLOCK, &lock);
    const bool permitted = may_schedule_realtime();
    findings.push_back(
        {permitted ? Mark::ok : Mark::note,
         std::string("This user may ") + (permitted ? "" : "not ") + "schedule in realtime, and may lock " +
             (lock.rlim_cur == RLIM_INFINITY ? "any amount" : std::to_string(lock.rlim_cur >> 20) + " MiB") +
             " of memory. Virtual time needs neither."});
    const fs::path master = program_in_path("rtapi_app");
    struct stat file {};
    if (stat(master.c_str(), &file) != 0) return findings;
    if (prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) != 0 && !permitted)
        findings.push_back(
            {Mark::note,
             "Nor may LinuxCNC's own rtapi_app: no program is given rights here (no_new_privs)."});
    else if (file.st_uid == 0 && (file.st_mode & S_ISUID) != 0)
        findings.push_back({Mark::ok, "LinuxCNC's own rtapi_app may: it is set-uid root."});
    else if (!permitted)
        findings.push_back({Mark::note, "Nor may LinuxCNC's own rtapi_app: it is not set-uid root.",
                            as_root("chmod u+s " + master.string())});
    if (geteuid() == 0 && !std::getenv("RTAPI_UID"))
        findings.push_back(
            {Mark::note,
             "As root, LinuxCNC's own rtapi_app wants a user in RTAPI_UID; Plumb's host does not.",
             "export RTAPI_UID=65534"});
    return findings;
}

// Files of Plumb's in a folder: what is right, and what is not.
Findings judged(const Comparison& comparison, const fs::path& folder, const std::string& what,
                const std::string& command) {
    Findings findings;
    if (!comparison.missing.empty())
        findings.push_back({Mark::wrong,
                            "Missing in " + folder.string() + ": " + joined(comparison.missing) + '.',
                            command});
    if (!comparison.wrong.empty())
        findings.push_back({Mark::wrong,
                            "Not of this Plumb in " + folder.string() + ": " + joined(comparison.wrong) + '.',
                            command});
    if (findings.empty())
        findings.push_back(
            {Mark::ok, what + " in " + folder.string() + ": " + joined(comparison.right) + '.'});
    return findings;
}

Findings installation(const Trial& trial) {
    const Home home;
    const Texts modules = split(PLUMB_MODULES);
    Texts programs = split(PLUMB_PROGRAMS);
    programs.insert(programs.begin(), {"plumb", "plumb-host"});

    Findings findings;
    const auto add = [&](const Findings& more) { findings.insert(findings.end(), more.begin(), more.end()); };
    add(judged(compare(home.programs, programs, ""), home.programs, "Plumb " PLUMB_VERSION,
               home.build_again()));
    if (home.from_package()) findings.push_back({Mark::ok, "Installed from the Debian package plumb."});
    if (home.built)
        add(judged(compare(home.root / "modules", modules, ".so"), home.root / "modules", "Modules",
                   home.build_again()));
    const fs::path linuxcncs = PLUMB_RTLIBDIR;
    const Comparison installed = compare(linuxcncs, modules, ".so", home.built ? home.root / "modules" : "");
    if (home.built && installed.missing.size() == modules.size())
        findings.push_back({Mark::note,
                            "Not installed: plumb finds the modules above, LinuxCNC itself finds none in " +
                                linuxcncs.string() + '.',
                            home.install_again()});
    else
        add(judged(installed, linuxcncs, "Modules", home.install_again()));
    for (const std::string& name : stale_modules(linuxcncs, modules))
        findings.push_back({Mark::wrong,
                            "Not part of this Plumb, but in " + linuxcncs.string() + ": " + name +
                                " (of Plumb " + version_of(linuxcncs / (name + ".so")) + ").",
                            as_root("rm " + (linuxcncs / name).string() + ".so")});
    const fs::path usual = program_in_path("plumb");
    if (!usual.empty() && !same_build(usual, home.program))
        findings.push_back({Mark::wrong,
                            "The first plumb in PATH, " + usual.string() + ", is another one (of Plumb " +
                                version_of(usual) + ").",
                            home.install_again()});
    const bool all_there = std::none_of(findings.begin(), findings.end(),
                                        [](const Finding& finding) { return finding.mark == Mark::wrong; });
    if (all_there && !trial.own_failed.empty())
        findings.push_back({Mark::wrong, "A module of Plumb's does not work in the host: " + trial.own_failed,
                            home.build_again()});
    return findings;
}

Findings python() {
    const auto prints = [](const fs::path& python3, const std::string& line) {
        // Not what lies in the present folder: such as a folder plumb, or hal.
        return output_of("'" + python3.string() +
                         "' -c 'import sys; sys.path = [p for p in sys.path if p]; " + line + "'");
    };
    const char* const import = "import linuxcnc, hal; hal.component";
    const fs::path first = program_in_path("python3");
    fs::path good = first;
    Findings findings;
    if (prints(first, import)) {
        findings.push_back({Mark::ok, first.string() + " has LinuxCNC's modules linuxcnc and hal."});
    } else if (good = "/usr/bin/python3"; prints(good, import)) {
        findings.push_back({Mark::note,
                            "The first python3 in PATH" + (first.empty() ? "" : ", " + first.string() + ',') +
                                " lacks LinuxCNC's modules linuxcnc and hal; " + good.string() + " has them.",
                            "export PATH=/usr/bin:$PATH"});
    } else {
        findings.push_back({Mark::note, "No python3 has LinuxCNC's modules linuxcnc and hal.",
                            as_root("apt install --reinstall linuxcnc-uspace")});
        return findings;
    }
    const Home home;
    const fs::path own = home.root / (home.built ? "python" : PLUMB_PYTHON_DIR) / "plumb.py";
    const auto found = prints(good, "import plumb; print(plumb.__file__)");
    const std::string command = "export PYTHONPATH=" + own.parent_path().string();
    if (!found)
        findings.push_back({Mark::note, "Python does not find plumb.py.", command});
    else if (same_build(*found, own))
        findings.push_back({Mark::ok, "Python finds plumb.py: " + *found + '.'});
    else
        findings.push_back(
            {Mark::wrong, "Python finds a plumb.py that is not of this Plumb: " + *found + '.', command});
    return findings;
}

Findings extras(const Trial&) {
    Findings findings;
    if (!host::faketime_library().empty())
        findings.push_back(
            {Mark::ok, "libfaketime, by which programs keep pace with a faster or slower clock."});
    else
        findings.push_back({Mark::note,
                            "No libfaketime: at other speeds than 1, programs beside the host keep the "
                            "computer's clock.",
                            as_root("apt install libfaketime")});
    const Findings pythons = python();
    findings.insert(findings.end(), pythons.begin(), pythons.end());
    const bool display = std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
    findings.push_back(
        display ? Finding{Mark::ok, "A display, for programs with windows."}
                : Finding{Mark::note, "No display: programs with windows (axis, halscope) do not start."});
    return findings;
}

// --- the HAL that runs ---

std::string joined(const std::vector<hal::PlacedFunction>& functions) {
    Texts names;
    for (const hal::PlacedFunction& one : functions)
        if (one.place != hal::Place::none) names.push_back(one.name);
    return joined(names);
}

// Whether the functions of Plumb are where their pages have them.
Findings threads() {
    if (running_realtime().empty() && running("plumb-host").empty())
        return {
            {Mark::wrong, "No HAL runs here: there is neither rtapi_app nor plumb-host.", "linuxcnc my.ini"}};
    const std::string halcmd = "timeout 60 halcmd -s show ";  // another program may keep HAL locked
    const auto lists = output_of(halcmd + "thread"), functions = output_of(halcmd + "funct");
    if (!lists || !functions)
        return {{Mark::wrong, "HAL does not show its threads within 60 s.", "halcmd show thread"}};
    const Home home;
    const RunningThreads found =
        running_threads(*lists, *functions, home.root / "share" / "plumb", split(PLUMB_MODULES));
    Findings findings;
    for (const std::string& file : found.undeclared)
        findings.push_back({Mark::wrong, "Missing or damaged: " + file + '.', home.build_again()});
    if (found.threads.empty())
        findings.push_back(
            {Mark::wrong, "HAL has no thread.", "halcmd loadrt threads name1=servo-thread period1=1000000"});
    const std::vector<hal::Misplaced> wrong = hal::misplaced(found.threads, found.idle);
    for (const hal::Misplaced& one : wrong) {
        std::string command;
        for (const std::string& line : one.commands)
            command += (command.empty() ? "halcmd " : " && halcmd ") + line;
        findings.push_back({Mark::wrong, one.sentence, command});
    }
    if (!wrong.empty()) {
        findings.push_back({Mark::note,
                            "Turn the machine off, and give the commands from the first to the last. They "
                            "last until HAL ends: "
                            "put the addf lines of the .hal files into the same order."});
        return findings;
    }
    for (const hal::ThreadFunctions& thread : found.threads)
        if (const std::string names = joined(thread.functions); !names.empty())
            findings.push_back({Mark::ok, "In order in " + thread.name + ": " + names + '.'});
    if (findings.empty()) findings.push_back({Mark::note, "No thread has a function of Plumb."});
    return findings;
}

struct Group {
    const char* title;
    Findings (*check)(const Trial&);
};

constexpr Group groups[] = {{"LinuxCNC", linuxcnc}, {"Kernel", kernel},      {"Isolation", isolation},
                            {"Realtime", realtime}, {"Plumb", installation}, {"Extras", extras}};

void print(const Finding& finding) {
    const std::string indent = "\n         ";
    const char* const mark = finding.mark == Mark::ok     ? "ok   "
                             : finding.mark == Mark::note ? "note "
                                                          : "WRONG";
    std::string text = hal::wrapped(finding.text);
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += indent.size())
        text.replace(at, 1, indent);
    std::cout << "  " << mark << "  " << text << '\n';
    if (!finding.command.empty()) std::cout << indent.substr(1) << "$ " << finding.command << '\n';
}

hal::CommandPage doctor_page() {
    return {
        "plumb-doctor",
        "[--running | --machine [--ini FILE.ini]]",
        {{"DESCRIPTION",
          R"(plumb doctor examines this computer and reports what is missing for Plumb, with the command that installs or
corrects it. It checks LinuxCNC and tries its HAL in Plumb's host. It checks the kernel, namespaces, and the rights of the
user in realtime. It checks that the modules and programs of Plumb are present and of one build, beside this program and
where LinuxCNC looks for them. It changes nothing.)"},
         {"THREADS",
          R"(With --running it checks the HAL that runs now, of LinuxCNC, halrun or plumb-host. Each function of Plumb has a
place in its thread, which its page has under FUNCTIONS. A function in a wrong place, in a wrong thread or in none is WRONG,
and the commands below it put it where it belongs. Turn the machine off first. Functions of other components, except
motion-controller, may stand anywhere: check yourself that the drives are read first and written last.)"},
         {"MACHINE",
          R"(With --machine it shows, for the LinuxCNC that runs, which functions and stages have passed plumb-commission(1), by
whom and when, what changed since, and which are held. While no LinuxCNC runs, it looks for lines of an earlier Plumb, which
LinuxCNC would refuse, and gives the line to write: in the HAL files of --ini, or of the configuration that was picked last.)"},
         {"OUTPUT",
          R"(- ok: Nothing to do.
- note: optional.
- WRONG: Plumb does not work without it.

The command that fixes a finding stands below it. PLUMB in it is the folder of Plumb's sources. Values that sysctl sets last
until the next start of the computer; put them into a file in /etc/sysctl.d to keep them.)"},
         {"EXIT STATUS", "0 if nothing is WRONG; 1 if something is WRONG; 2 for a wrong command line."}},
        ".BR plumb (1),\n.BR plumb\\-commission (1),\n.BR plumb\\-bench (1),\n.BR plumb\\-run (1),\n.BR "
        "halcmd (1)"};
}

// Prints findings, and counts those that are WRONG and notes.
struct Report {
    int wrongs = 0, notes = 0;

    void show(const char* title, const Findings& findings) {
        std::cout << title << '\n';
        for (const Finding& finding : findings) {
            print(finding);
            notes += finding.mark == Mark::note;
            wrongs += finding.mark == Mark::wrong;
        }
    }

    // Returns the exit status: 0, or 1 when something is WRONG.
    int end() const {
        std::cout << '\n';
        if (wrongs == 0)
            std::cout << "All is well" << (notes ? ", apart from the notes" : "") << ".\n";
        else if (wrongs == 1)
            std::cout << "One thing is WRONG; the command below fixes it.\n";
        else
            std::cout << wrongs << " things are WRONG; the command below each fixes it.\n";
        return wrongs ? 1 : 0;
    }
};

// What plumb commission knows of the machine that runs: rows of a mark, a sentence and a command, between
// tabs.
Findings machine(const std::string& ini) {
    const std::string program = (Home().programs / "plumb-commission").string();
    setenv("PLUMB_DOCTOR_INI", ini.c_str(), 1);  // no shell reads the name
    FILE* const pipe =
        popen(("'" + program + "' --state --rows --ini \"$PLUMB_DOCTOR_INI\" 2>&1").c_str(), "r");
    if (!pipe) return {{Mark::wrong, "Cannot start " + program + '.', Home().build_again()}};
    std::string text;
    for (int c = 0; (c = std::getc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    Findings findings;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream parts(line);
        std::string mark, sentence, command;
        std::getline(parts, mark, '\t');
        std::getline(parts, sentence, '\t');
        std::getline(parts, command);
        if (sentence.empty())
            findings.push_back({Mark::wrong, line, "linuxcnc my.ini"});
        else
            findings.push_back({mark == "ok"     ? Mark::ok
                                : mark == "note" ? Mark::note
                                                 : Mark::wrong,
                                sentence, command});
    }
    if (findings.empty()) findings.push_back({Mark::note, "No function of Plumb is loaded."});
    return findings;
}

int doctor(bool of_running, bool of_machine, const std::string& ini) {
    Report report;
    if (of_machine) {
        report.show("Machine", machine(ini));
        return report.end();
    }
    if (of_running) {
        report.show("Threads", threads());
        return report.end();
    }
    const Trial trial = try_hal_for_a_while();
    for (const Group& group : groups) report.show(group.title, group.check(trial));
    return report.end();
}

const Command command{
    "doctor", "reports missing parts on this computer, and how to fix them", [](int argc, char** argv) {
        CLI::App app(command.summary, "plumb doctor");
        hal::begin_command_line(app, doctor_page);
        bool of_running = false;
        app.add_flag("--running", of_running, "Checks the threads of the HAL that runs, and nothing else.");
        bool of_machine = false;
        app.add_flag("--machine", of_machine,
                     "Shows which functions and stages passed plumb commission, and what changed since.");
        std::string ini;
        app.add_option("--ini", ini, "INI file of the machine, if LinuxCNC does not run.")->needs("--machine");
        return hal::carry_out(app, argc, argv, [&] { return doctor(of_running, of_machine, ini); });
    }};

}  // namespace
}  // namespace plumb::commands
