// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/bus.hpp"
#include "hal/clock_speed.hpp"
#include "hal/component.hpp"
#include "hal/program_state.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// The programs beside realtime that functions need.
struct Services : hal::Group {
    static constexpr std::size_t most = 8;
    static constexpr double longest = 3600;  // s
    static constexpr double fastest = 1000, slowest = 0.01;

    // Of those that hold no feed: waiting-code tells the others.
    struct Losses {
        Losses(hal::Owner owner, std::size_t number) {
            const std::string lost =
                " does not answer. Functions that need it go off when the program ends. "
                "Start LinuxCNC again.";
            const std::string sentences[most] = {
                "Service 0, plumb-retain," + lost,
                "Service 1, linuxcnc_link," + lost,
                "Service 2" + lost,
                "Service 3" + lost,
                "",
                "",
                "Service 6, growth_log, does not answer: the growth test is not written. Start growth_log "
                "again by "
                "its line in man growth_log, or LinuxCNC and then resume.ngc.",
                "Service 7" + lost};
            for (std::size_t i = 0; i < number; ++i)
                if (!sentences[i].empty())
                    hal::Told(owner, "service-lost-" + std::to_string(i), hal::Tell::error, sentences[i]);
        }
    };

    Services(hal::Owner owner, std::size_t number) : Group(owner), number_(number), its_(number) {
        for (std::size_t i = 0; i < number; ++i)
            heard_.emplace_back(hal::Party::program, hal::Direction::to_interlock,
                                static_cast<std::uint32_t>(i), 1);
    }

    const std::size_t number_;

    hal::Row<hal::In<std::uint32_t>> state{this, number_, "service-state", 0U,
                                           "What the program says: from its state."};
    hal::Row<hal::In<double>> timeout{
        this, number_, "service-timeout",
        0,    "s",     "Maximum time without a beat in the state, up to 3600; 0: the beat is not watched."};
    hal::In<double> clock_speed{this,
                                "clock-speed",
                                hal::clock_speed(),
                                "1",
                                "Factor of each service-timeout. plumb run sets it to its speed, because a "
                                "service follows the computer's clock.",
                                hal::Range{slowest, fastest}};

    hal::Row<hal::Out<bool>> ok{this, number_, "service-ok", "The service runs and is ready."};
    hal::Row<hal::Out<bool>> lost{this, number_, "service-lost", "The beat has stopped."};
    Losses told_losses{this, number_};

    // Once in each period.  False where clock-speed or a timeout is out of range; its last good value stays.
    bool step(double dt) noexcept {
        const double speed = clock_speed;
        bool good = clock_speed.accepts(speed);
        if (good) speed_ = speed;
        ok_ = lost_ = 0;
        for (std::size_t i = 0; i < number_; ++i) {
            const std::uint32_t word = state[i];
            heard_[i].step(word);
            const double given = timeout[i];
            good &= its_[i].set_timeout(given);
            its_[i].listen(heard_[i].beats(), dt / speed_);
            const bool is_ready =
                heard_[i].heard() ? hal::ProgramReport::of(heard_[i].content()).ready : word == 0;
            const bool is_lost = its_[i].lost(), is_ok = its_[i].lives() && is_ready;
            ok_ |= is_ok ? 1 << i : 0;
            lost_ |= is_lost ? 1 << i : 0;
            ok[i] = is_ok;
            lost[i] = is_lost;
        }
        return good;
    }

    double speed() const noexcept { return speed_; }  // of the clock, against the computer's

    static constexpr std::int32_t of(std::size_t number) noexcept { return (1 << number) - 1; }
    std::int32_t all() const noexcept { return of(number_); }
    bool exist(std::int32_t these) const noexcept { return (these & ~all()) == 0; }
    // Of these, as a sum of 1, 2, 4, ... 128.
    bool are_ok(std::int32_t these) const noexcept { return (these & ~ok_) == 0; }
    bool any_lost(std::int32_t these) const noexcept { return (these & lost_) != 0; }
    std::int32_t lost_of(std::int32_t these) const noexcept { return these & lost_; }
    std::int32_t late_of(std::int32_t these) const noexcept { return these & ~ok_ & ~lost_; }

private:
    class Pulse {
    public:
        bool set_timeout(double given) noexcept {
            const bool good = given >= 0 && given <= longest;
            if (good) timeout_ = given;
            return good;
        }

        void listen(bool beats, double dt) noexcept {
            const bool watched = timeout_ > 0;
            beaten_ = watched && (beaten_ || beats);
            silence_ = beats || !watched ? 0 : silence_ + dt;
        }

        bool lost() const noexcept { return timeout_ > 0 && silence_ > timeout_; }
        bool lives() const noexcept { return timeout_ > 0 ? beaten_ && !lost() : true; }

    private:
        double timeout_ = 0, silence_ = 0;  // s of the computer's clock
        bool beaten_ = false;
    };

    double speed_ = 1;
    std::vector<Pulse> its_;
    std::vector<hal::BusListener> heard_;
    std::int32_t ok_ = 0, lost_ = 0;
};

}  // namespace plumb
