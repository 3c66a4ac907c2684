// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/clock_speed.hpp"
#include "hal/component.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// The programs beside realtime that functions need.
struct Services : hal::Group {
    static constexpr std::size_t number = 8;
    static constexpr std::int32_t all = (1 << number) - 1;  // as a sum of 1, 2, 4, ... 128
    static constexpr double longest = 3600;                 // s
    static constexpr double fastest = 1000, slowest = 0.01;

    // Of those that hold no feed: waiting-code tells the others.
    struct Losses {
        explicit Losses(hal::Owner owner) {
            const std::string lost =
                " does not answer. Functions that need it go off when the program ends. "
                "Start LinuxCNC again.";
            const std::string sentences[number] = {
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

    using Group::Group;

    hal::Row<hal::In<bool>, number> heartbeat{this, "service-heartbeat", false,
                                              "Heartbeat of the service: it changes while the service runs."};
    hal::Row<hal::In<double>, number> timeout{
        this, "service-timeout", 0, "s",
        "Maximum time without a change of the heartbeat, up to 3600; 0: the heartbeat is not watched."};
    hal::In<double> clock_speed{this,
                                "clock-speed",
                                hal::clock_speed(),
                                "1",
                                "Factor of each service-timeout. plumb run sets it to its speed, because a "
                                "service follows the computer's clock.",
                                {slowest, fastest}};
    hal::Row<hal::In<bool>, number> ready{this, "service-ready", true,
                                          "The service is ready: for example plumb-retain.restored."};
    hal::Row<hal::In<bool>, number> fault{this, "service-fault", false, "The service has a fault."};

    hal::Row<hal::Out<bool>, number> ok{this, "service-ok", "The service runs and is ready."};
    hal::Row<hal::Out<bool>, number> lost{this, "service-lost", "The heartbeat has stopped."};
    Losses told_losses{this};
    hal::Row<hal::Out<bool>, number> not_ready{this, "service-not-ready",
                                               "The service has a fault, and is not ready."};
    hal::Row<hal::Out<bool>, number> troubled{this, "service-troubled",
                                              "The service has a fault, and is ready nevertheless."};

    // Once in each period.  False where clock-speed or a timeout is out of range; its last good value stays.
    bool step(double dt) noexcept {
        const double speed = clock_speed;
        bool good = clock_speed.accepts(speed);
        if (good) speed_ = speed;
        ok_ = lost_ = 0;
        for (std::size_t i = 0; i < number; ++i) {
            const double given = timeout[i];
            good &= its_[i].set_timeout(given);
            its_[i].listen(heartbeat[i], dt / speed_);
            const bool has_fault = fault[i], is_ready = ready[i];
            const bool is_lost = its_[i].lost(), is_ok = its_[i].lives() && is_ready;
            ok_ |= is_ok ? 1 << i : 0;
            lost_ |= is_lost ? 1 << i : 0;
            ok[i] = is_ok;
            lost[i] = is_lost;
            not_ready[i] = has_fault && !is_ok && !is_lost;
            troubled[i] = has_fault && is_ok;
        }
        return good;
    }

    double speed() const noexcept { return speed_; }  // of the clock, against the computer's

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

        // A heartbeat that is true at first has not changed.
        void listen(bool beat, double dt) noexcept {
            const bool changed = known_ && beat != last_;
            known_ = true;
            last_ = beat;
            const bool watched = timeout_ > 0;
            beaten_ = watched && (beaten_ || changed);
            silence_ = changed || !watched ? 0 : silence_ + dt;
        }

        bool lost() const noexcept { return timeout_ > 0 && silence_ > timeout_; }
        bool lives() const noexcept { return timeout_ > 0 ? beaten_ && !lost() : true; }

    private:
        double timeout_ = 0, silence_ = 0;  // s of the computer's clock
        bool known_ = false, last_ = false, beaten_ = false;
    };

    double speed_ = 1;
    std::array<Pulse, number> its_;
    std::int32_t ok_ = 0, lost_ = 0;
};

}  // namespace plumb
