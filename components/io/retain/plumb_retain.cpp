// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/retain/keeper.hpp"
#include "components/io/retain/program_identity.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/component.hpp"
#include "hal/program_state.hpp"
#include "pages/plumb_retain.page.hpp"

#include <atomic>
#include <chrono>
#include <ctime>
#include <iostream>
#include <memory>
#include <stdexcept>

namespace plumb {

struct Retain final : hal::Component {
    static constexpr hal::About about{
        "plumb-retain", "keeps values of pins, and records of components, over a restart", page};

    static constexpr hal::Role role = hal::Role::program;
    static constexpr const char* former_name = "retain";
    using Component::Component;

    hal::In<bool> accept{
        this, "accept", false,
        "The rising edge restores a store of another computer, or an older one: fault-code 8 to 11."};
    hal::In<bool> renew{this, "renew", false,
                        "The rising edge keeps the present values in place of such a store."};
    hal::ProgramState program_state{this, hal::Service::retain};
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
    hal::Option<std::string> machine{this, "machine", "",
                                     "Name of the machine for a file that is not there yet: it is written "
                                     "with this name and without a value."};
    hal::Function run{this, "update", &Retain::update, "Once per period."};

    void prepare() override {
        if (file.get().empty())
            throw std::invalid_argument("give the TOML file that lists the values to keep by --file");
        if (!machine.get().empty()) begin_settings(file.get(), machine);
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
        program_state.report(stuck_ < 5, {is_restored_, has_fault_});
        const bool accepts = accept_.rises(accept), renews = renew_.rises(renew);
        if (accepts || renews) answer_ = accepts ? Keeper::Answer::accept : Keeper::Answer::renew;
        today();
    }

    void background() override {
        ++rounds_;
        keeper_->answer(answer_.exchange(Keeper::Answer::none));
        keeper_->step();
        if (std::chrono::steady_clock::now() >= identify_again_) identify();
        show();
    }

    void finish() override { keeper_->finish(); }

private:
    void show() {
        const Keeper::State state = keeper_->state();
        const Fault found = state.fault != Fault::none ? state.fault : identity_fault_;
        fault = found;
        has_fault_ = found != Fault::none;
        is_restored_ = state.restored;
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
            if (identity_fault_ == Fault::none)
                std::cerr << std::string("plumb-retain: ") + error.what() + '\n';
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
    Edge accept_, renew_;
    std::atomic<Keeper::Answer> answer_{Keeper::Answer::none};
    int seen_rounds_ = -1;
    double stuck_ = 0;  // s
    std::atomic<bool> is_restored_{false}, has_fault_{false};
};

hal::Model hal::model() {
    return model_of<Retain>();
}

}  // namespace plumb
