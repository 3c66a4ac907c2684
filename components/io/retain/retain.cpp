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
    static constexpr hal::About about{"retain",
                                      "keep values of pins, and records of components, over a restart", R"(
What a machine has learnt is to outlive a restart.  A TOML file says what is kept:

    machine = "mill 3"                             # its values are put into no other machine
    pins    = ["z-growth.window", "z-growth.gate-floor"]
    records = ["z-growth"]                         # components that have the pins row, rows, restore, ...
    program = ["/home/mill/nc/part.ngc"]           # files that make up program-id
    every   = 2                                    # s; what changes is written at most this often, default 5
    store   = "/home/mill/linuxcnc/mill.retained"  # default: beside the TOML file, with this ending
    formerly = { "z-growth" = "thermal" }          # z-growth takes over the values that the store has of thermal

Only machine must be there; paths are absolute.  The pins are inputs that no signal is netted to, of type bit, s32, u32 or
float.  Load retain after all that it names, and after the lines that set the pins:

    loadusr -W retain --file /home/mill/linuxcnc/mill.toml

and let what depends on it work only while restored is true, and heartbeat, netted to watchdog, is alive.  In
LinuxCNC's .hal files $(CONFIG_DIR) is the folder of the .ini file.  A second instance has a name and a file of its own:
loadusr -Wn tools retain tools --file ...; two that keep values in the same store are refused.

Restoring.  The store is read when retain is loaded.  Once all that is named exists, and each component answers through
its walk, which it does when the realtime threads run (until then waiting is true), pins and records get what was
kept, instead of what they had, and restored rises; at once where there was no store yet.  It is all or nothing: when a
component refuses a record, all of them forget, and the pins get back what they had.  A pin that the store does not have
stays as it is.

A component is given what was kept once more when it is loaded anew, which retain knows by its pin kept: that one is for
retain alone.  To forget is up to everyone.  Whoever else walks the records takes turns with retain, which uses row
once a second: set row anew until row-shown agrees, and do not go on for long.

Saving.  Pins and records are looked at once a second, and at once when retain is asked to end, by unloadusr or with
LinuxCNC; where they have changed they are written, at most every so many seconds and in the end, but never before
restored.  Records are read twice, until both readings agree.  Written is a file beside the store, which then takes its
place: after a crash or power cut the store is as it was, or as it was meant to be.  A component that does not answer any
more, as after the threads were stopped, or that is gone, is kept as it was seen last.  kill -9 loses what was not yet written.

The store is text: who reads it sees each value, and who changes it is found out by the checksum.  It keeps its owner and
its rights.  Beside it stays a file .lock, by which a second retain knows of the first.  A store is a regular file with
one name: a pipe is refused, and so is a file with a hard link.  Neither is a link followed that another user has put
into a folder that all can write.

Details of a fault are written to stderr.

program-id is the CRC-32 of the program's files, one after the other, as a signed number; it follows their changes
within a second.  Heartbeat stands still when the disk has not answered for 5 s.)"};

    using Component::Component;

    hal::Out<bool> heartbeat{this, "heartbeat", "Changes once per period, for watchdog."};
    hal::Out<bool> restored{this, "restored", "All that was kept is in force."};
    hal::Out<bool> waiting{this, "waiting", "Waits for the realtime threads."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Out<std::int32_t> saves{this, "saves", "How often the store was written."};
    hal::Out<std::int32_t> date{this, "date", "Local date, as a number YYYYMMDD."};
    hal::Out<std::int32_t> program_id{this, "program-id",
                                      "Tells programs, and versions of one, apart; 0 for none."};
    hal::Option<std::string> file{this, "file", "", "TOML file that says what is kept, absolute path."};
    hal::Function run{this, "update", &Retain::update, "Once per period."};

    void prepare() override {
        if (file.get().empty())
            throw std::invalid_argument("say by --file which TOML file says what is kept");
        keeper_ = std::make_unique<Keeper>(hal::absolute_path("file", file));
        identity_ = std::make_unique<ProgramIdentity>(keeper_->settings().program);
        identify();
        show();
        today();
    }

    // Whatever waits for the disk, or for realtime, is on the other thread.
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
