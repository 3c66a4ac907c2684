// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/retain/keeper.hpp"
#include "components/io/retain/program_identity.hpp"
#include "hal/component.hpp"

#include <atomic>
#include <chrono>
#include <ctime>
#include <iostream>
#include <memory>
#include <stdexcept>

namespace plumb {

struct Retain final : hal::Component {
    static constexpr hal::About about{
        "retain",
        "keeps values of pins, and records of components, over a restart",
        R"(
retain saves pins and the records of components in a file, and restores them when LinuxCNC starts again. Use it for the
reference that thermal_displacement has learned. It also outputs the date and the identity of a program. A TOML file
names the pins and the records. All of it is restored, or nothing.)",
        hal::Wiring{R"(
  loadusr -W retain --file $(CONFIG_DIR)/mill.toml

  loadrt interlock names=interlock

  setp interlock.service-timeout-0 30
  setp interlock.function-switch-0 true

  net restored         retain.restored  => interlock.service-ready-0
  net retain-heartbeat retain.heartbeat => interlock.service-heartbeat-0
  net retain-fault     retain.fault     => interlock.service-fault-0
  net growth-on        interlock.function-enable-0 => growth.enable
  net date             retain.date      => growth.date

  addf interlock.update servo-thread

interlock(9) switches the function off when retain has died.

Load retain after all components that the TOML file names, and after the lines that set their pins. $(CONFIG_DIR) is
the folder of the INI file. configs/mill/stages.hal is a complete example.)"},
        hal::SettingUp{R"(
1. Write the TOML file. Only machine is required; paths are absolute.

    machine = "mill 3"            # values go into no other machine
    pins    = ["growth.window", "growth.gate-floor"]
    records = ["growth"]          # components with the pins row, rows, ...
    program = ["/home/mill/nc/part.ngc"]    # files of program-id
    every   = 2                   # s between two writes, default 5
    store   = "/home/mill/mill.retained"    # default: beside this file
    formerly = { "growth" = "thermal" }     # growth takes over the values stored for thermal

2. List pins only that are inputs without a signal, of type bit, s32, u32 or float.
3. Let the components work only while restored is true and heartbeat is alive, as above.
4. For a second instance give it a name and a file: loadusr -Wn tools retain tools --file FILE. Two instances with the
same store are refused.)"},
        hal::Behaviour{R"(
- Start: retain reads the store when it is loaded. It restores when all named pins and components exist and the realtime
threads run; waiting is true until then. Then restored becomes true. Without a store it becomes true at once.
- Refused record: All components forget their records, and the pins get back their former values.
- Pin that the store does not have: It keeps its value.
- Component loaded again: Its records are restored once more. The pin kept is for this, and for retain alone.
- Saving: retain looks once a second, and when it is asked to end. It writes changes every so many seconds, at most,
and never before restored is true.
- Crash, power cut: The store is either the old one or the new one. kill -9 loses unwritten changes.
- Component that does not answer: Its last seen records are kept.
- Disk that does not answer for 5 s: heartbeat stops.
- Foreign, damaged or other version of the store on loading: Nothing is restored or saved, and the store stays as it is.
Correct it, and start again.
- Store that cannot be read or written: retain tries again once a second. At the start it restores as soon as it can read;
later restored stays true.
- Pin or component that is missing, netted, or of another type: Nothing is restored, or restored becomes false. retain goes
on after you correct it.
- List of pins changed in the TOML file: retain follows it within a second while restored is true. A new pin keeps its
value, and is saved from then on. A list with a pin that is missing or netted is not followed.
- Unreadable program file: program-id is 0.

stderr gives the details of a fault. program-id is the CRC-32 of the files of the program in order, as a signed number.
It follows their changes within a second.)"},
        hal::Limits{R"(
The store is text with a checksum: you can read it, but an edited store is refused. It keeps its owner and its rights. A
file .lock stays beside it; retain also locks the store itself. Pipes, files with a hard link, and a link of another user
in a folder for all are refused.

Another program that walks the records takes turns with retain, which uses row once a second. It sets row again until
row-shown agrees, and must be brief.)"},
        hal::SeeAlso{"thermal_displacement(9), interlock(9), linuxcnc_link(1)"}};

    static constexpr hal::Role role = hal::Role::program;
    using Component::Component;

    hal::Out<bool> heartbeat{this, "heartbeat", "Changes once per period, for interlock."};
    hal::Out<bool> restored{this, "restored", "All kept values are in force."};
    hal::Out<bool> waiting{this, "waiting", "Waits for the realtime threads."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Out<std::int32_t> saves{this, "saves", "Number of times that the store was written."};
    hal::Out<std::int32_t> date{this, "date", "Local date, as a number YYYYMMDD."};
    hal::Out<std::int32_t> program_id{this, "program-id",
                                      "Identifies the program and its version; 0 for none."};
    hal::Option<std::string> file{this, "file", "",
                                  "TOML file that lists the values to keep. LinuxCNC starts programs in the "
                                  "folder of the INI file: a relative path begins there."};
    hal::Function run{this, "update", &Retain::update, "Once per period."};

    void prepare() override {
        if (file.get().empty())
            throw std::invalid_argument("give the TOML file that lists the values to keep by --file");
        keeper_ = std::make_unique<Keeper>(std::filesystem::absolute(file.get()));
        identity_ = std::make_unique<ProgramIdentity>(keeper_->settings().program);
        identify();
        show();
        today();
    }

    // The other thread does all that waits for the disk or for realtime.
    void update(double dt) noexcept {
        const int rounds = rounds_;
        stuck_ = rounds == seen_rounds_ ? stuck_ + dt : 0;
        seen_rounds_ = rounds;
        if (stuck_ < 5) beat_ = !beat_;
        heartbeat = beat_;
        today();
    }

    void background() override {
        ++rounds_;
        keeper_->step();
        if (std::chrono::steady_clock::now() >= identify_again_) identify();
        show();
    }

    void finish() override { keeper_->finish(); }

private:
    void show() {
        const Keeper::State state = keeper_->state();
        fault = state.fault != Fault::none ? state.fault : identity_fault_;
        saves = state.saves;
        waiting = state.waiting;
        restored = state.restored;
    }

    void identify() {
        identify_again_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
        try {
            program_id = identity_->look();
            identity_fault_ = Fault::none;
        } catch (const std::exception& error) {
            program_id = 0;
            if (identity_fault_ == Fault::none) std::cerr << std::string("retain: ") + error.what() + '\n';
            identity_fault_ = Fault::program;
        }
    }

    void today() noexcept {
        const std::time_t now = std::time(nullptr);
        std::tm local{};
        localtime_r(&now, &local);
        date = (local.tm_year + 1900) * 10000 + (local.tm_mon + 1) * 100 + local.tm_mday;
    }

    std::unique_ptr<Keeper> keeper_;
    std::unique_ptr<ProgramIdentity> identity_;
    Fault identity_fault_ = Fault::none;
    std::chrono::steady_clock::time_point identify_again_{};
    std::atomic<int> rounds_{0};  // of background()
    int seen_rounds_ = -1;
    double stuck_ = 0;  // s
    bool beat_ = false;
};

hal::Model hal::model() {
    return model_of<Retain>();
}

}  // namespace plumb
