// SPDX-License-Identifier: GPL-2.0-or-later
// Programs, functions and stages that say to interlock what a test gives them.
#include "components/stages/stage_permit.hpp"
#include "hal/component.hpp"
#include "hal/program_state.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace plumb {

struct Peers final : hal::Component {
    static constexpr hal::About about{"peers", "programs, functions and stages for interlock", R"(
Each state says what the inputs of its number say.)"};

    static constexpr std::size_t services = 8, functions = 16, stages = 17;

    using Component::Component;

    template <class T>
    using Row = hal::Row<hal::In<T>>;
    Row<bool> heartbeat{this, services, "service-heartbeat", false, "The program beats with each change."};
    Row<bool> ready{this, services, "service-ready", true, "The program is ready."};
    Row<bool> has_fault{this, services, "service-fault", false, "The program has a fault."};
    Row<bool> busy{this, functions, "function-busy", false, "The function is at work."};
    Row<bool> settling{this, functions, "function-settling", false, "The next cut must wait."};
    Row<bool> function_ramping{this, functions, "function-ramping", false, "The function ramps."};
    Row<bool> in_force{this, stages, "stage-in-force", false, "An offset is in force."};
    Row<bool> ramping{this, stages, "stage-ramping", false, "The offset changes."};
    Row<bool> uncompensated{this, stages, "stage-uncompensated", false, "The axis lacks its offset."};
    Row<bool> refused{this, stages, "stage-probing-refused", false, "A probing move began too early."};
    Row<bool> fault{this, stages, "stage-fault", false, "The stage has a fault."};
    Row<bool> limited{this, stages, "stage-limited", false, "A limit is active."};
    hal::In<bool> dumb{this, "dumb", false, "All say the same word again and again."};
    hal::Row<hal::Out<std::uint32_t>> service_state{this, services, "service-state", "The word."};
    hal::Row<hal::Out<std::uint32_t>> function_state{this, functions, "function-state", "The word."};
    hal::Row<hal::Out<std::uint32_t>> stage_state{this, stages, "stage-state", "The word."};
    hal::Function run{this, "update", &Peers::update, "Before interlock."};

    void update(double) noexcept {
        if (!dumb) ++beat_;
        const auto to_interlock = hal::Direction::to_interlock;
        for (std::size_t i = 0; i < services; ++i) {
            const bool beat = heartbeat[i];
            if (beat != last_[i]) ++beats_[i];
            last_[i] = beat;
            service_state[i] =
                hal::BusWord::of(hal::Party::program, to_interlock, static_cast<std::uint32_t>(i), beats_[i],
                                 hal::ProgramReport{ready[i], has_fault[i]}.content());
        }
        for (std::size_t i = 0; i < functions; ++i) {
            const hal::FunctionState its{busy[i], false, settling[i], function_ramping[i]};
            function_state[i] = hal::BusWord::of(hal::Party::function, to_interlock,
                                                 static_cast<std::uint32_t>(i), beat_, its.content());
        }
        for (std::size_t i = 0; i < stages; ++i) {
            const StageState its{in_force[i], ramping[i], uncompensated[i], refused[i], fault[i], limited[i]};
            stage_state[i] = hal::BusWord::of(hal::Party::stage, to_interlock, static_cast<std::uint32_t>(i),
                                              beat_, its.content());
        }
    }

private:
    std::uint32_t beat_ = 0;
    std::array<std::uint32_t, services> beats_{};
    std::array<bool, services> last_{};
};

hal::Model hal::model() {
    return model_of<Peers>();
}

}  // namespace plumb
