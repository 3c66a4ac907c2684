// SPDX-License-Identifier: GPL-2.0-or-later
// LinuxCNC's external offset of an axis, shared by a stage and its guest: mathematics without pins. In mu.
// Once in each period:
//
//     OffsetLedger::divide      which part of the offset in force is the stage's own, and which the guest's
//     OffsetLedger::listen      the guest's counts: what it asks for
//     OffsetCounter::answered   whether LinuxCNC has taken the last step; then
//     OffsetLedger::approach        the own part moves towards its target
//     OffsetCounter::ask            the counts that bring LinuxCNC's request to the sum of both parts
//
// If LinuxCNC's request differs from what was sent, take_stock() and start() begin again from that request.
#pragma once

#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// The offset that LinuxCNC's external offsets would be asked for by another user of an axis, its guest, which
// gives counts, scale, enable and clear as it would give them to axis.L.eoffset-*:
//
//     request += (counts - last counts) * scale
//
// while the machine is on, homed, enabled and not cleared; other steps are lost for good. Clear makes the
// request 0. Without enable the offset stops where it is. Counts wrap around at 32 bits, as LinuxCNC's do.
class GuestOffset {
public:
    struct Given {
        std::int32_t counts = 0;
        double scale = 0;  // mu
        bool enable = true, clear = false;
    };

    // LinuxCNC has forgotten all offsets: the machine was turned on.
    void forget() noexcept { request_ = 0; }

    // What LinuxCNC turns out to be asked for.
    void correct(double request) noexcept { request_ = request; }

    // `takes`: LinuxCNC takes steps, as the machine is on and homed. `applied` is the guest's part of the
    // offset in force.
    void listen(const Given& given, bool takes, double applied) noexcept {
        if (!known_) counts_ = given.counts;
        known_ = true;
        const std::int32_t steps = difference(given.counts, counts_);
        const double asked = request_ + steps * given.scale;
        const bool moves = takes && given.enable && !given.clear && steps != 0;
        good_ = !moves || (given.scale != 0 && std::abs(asked) <= largest);
        held_ = !given.enable;
        if (!good_) return;  // the step is not lost: it can be taken back, or waits for a good scale
        counts_ = given.counts;
        if (held_)
            request_ = applied;
        else if (given.clear)  // LinuxCNC clears an unhomed axis, too
            request_ = 0;
        else if (moves)
            request_ = asked;
    }

    double request() const noexcept { return request_; }
    bool held() const noexcept { return held_; }  // enable is false
    // False: a step of the counts with a scale that is 0 or invalid, or one to an offset beyond 1000.
    bool good() const noexcept { return good_; }

private:
    static constexpr double largest = 1e3;  // mu

    static std::int32_t difference(std::int32_t a, std::int32_t b) noexcept {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
    }

    double request_ = 0;
    std::int32_t counts_ = 0;
    bool known_ = false, held_ = false, good_ = true;
};

// Which part of the offset in force is the stage's own, and which its guest's. LinuxCNC shows the sum alone.
//
// While the guest is at rest its part is what it asks for, and the own part is the rest: also what a soft
// limit takes away. While the guest is under way the own part, which is slow, follows its request first, and
// the guest has the rest.
class OffsetShares {
public:
    struct Requests {
        double own, guest;
        bool held;  // the guest stops where it is, and asks for no more
    };

    // LinuxCNC has forgotten all offsets.
    void forget() noexcept {
        own_ = guest_ = 0;
        under_way_ = false;
    }

    // The guest's part turns out to be this.
    void correct(double guest) noexcept {
        own_ += guest_ - guest;
        guest_ = guest;
        under_way_ = false;
    }

    // `own_step` is the largest change of the own part in a period, `grain` the step of a count.
    void divide(double in_force, const Requests& requests, double own_step, double grain) noexcept {
        const double step = in_force - own_ - guest_;
        const double way = bounded(requests.own - own_, std::max(std::abs(step), own_step));
        const double by_guest = step == 0 ? 0 : step - way;
        if (requests.held)  // it brakes, until it stands or turns
            under_way_ = under_way_ && by_guest * last_ > 0;
        else
            under_way_ = std::abs(requests.guest - guest_) > grain;
        last_ = by_guest;
        if (under_way_)
            guest_ += by_guest;
        else if (!requests.held)
            guest_ = requests.guest;
        own_ = in_force - guest_;
    }

    double own() const noexcept { return own_; }
    double guest() const noexcept { return guest_; }

private:
    double own_ = 0, guest_ = 0;
    double last_ = 0;  // the guest's last step
    bool under_way_ = false;
};

// The own part and the guest's part of LinuxCNC's external offset of an axis: of the offset that LinuxCNC is
// asked for, and of the one in force. Invariant:
//
//     own + guest = asked
class OffsetLedger {
public:
    // LinuxCNC has forgotten all offsets.
    void forget() noexcept {
        guest_.forget();
        shares_.forget();
        own_ = 0;
    }

    // The offset in force. `own_step` is the largest change of the own part in a period, `grain` the step of
    // a count.
    void divide(double in_force, double own_step, double grain) noexcept {
        shares_.divide(in_force, {own_, guest_.request(), guest_.held()}, own_step, grain);
    }

    // The guest, see GuestOffset.
    void listen(const GuestOffset::Given& given, bool takes) noexcept {
        guest_.listen(given, takes, shares_.guest());
    }

    // LinuxCNC is asked for something else than was sent. The guest keeps its part if that leaves an own part
    // within ±limit; it has none if all was cleared.
    void take_stock(double asked, double in_force, double limit, double grain) noexcept {
        const bool cleared = std::abs(asked) <= grain / 2 && std::abs(in_force) <= grain / 2;
        if (cleared) guest_.correct(0);
        own_ = asked - guest_.request();
        if (guest_.request() != 0 && std::abs(own_) > limit) {
            own_ = bounded(own_, limit);
            guest_.correct(asked - own_);
        }
        shares_.correct(guest_.request());
    }

    // Moves the own part towards its target, unless it is ahead of the one in force by more than `lag`.
    void approach(double target, double step, double lag) noexcept {
        const bool ahead =
            std::abs(own_ - shares_.own()) > lag && (target - own_) * (shares_.own() - own_) <= 0;
        if (!ahead) own_ += bounded(target - own_, step);
    }

    double asked() const noexcept { return own_ + guest_.request(); }
    double own() const noexcept { return own_; }
    const GuestOffset& guest() const noexcept { return guest_; }
    double own_in_force() const noexcept { return shares_.own(); }
    double guest_in_force() const noexcept { return shares_.guest(); }

private:
    double own_ = 0;
    GuestOffset guest_;
    OffsetShares shares_;
};

// Turns a wanted offset into the counts of LinuxCNC's external offsets. LinuxCNC adds each step of the
// counts, times the scale, to the requested offset (the request), and loses all steps that come while it
// ignores the counts. So the loop is closed on the request:
//
//     counts += round((wanted - request) / scale)
//
// and a step is sent only after the request has shown the one before. So lost steps can neither add up nor
// wind up.
class OffsetCounter {
public:
    // Forgets a step under way, and takes the request as it is.
    void start(double request) noexcept {
        expected_ = request;
        silence_ = 0;
        under_way_ = false;
    }

    // Whether the request shows the last step.
    bool agrees(double request, double scale) const noexcept {
        return std::abs(request - expected_) <= scale / 2;
    }

    // The same. Call it once in each period: it counts periods without an answer.
    bool answered(double request, double scale) noexcept {
        const bool heard = agrees(request, scale);
        silence_ = heard ? 0 : silence_ + 1;
        under_way_ = under_way_ && !heard;
        return heard;
    }

    // Sends the step that brings the request to the wanted offset; only after answered(). Both finite, scale
    // > 0.
    void ask(double wanted, double request, double scale) noexcept {
        const double step = std::round((wanted - request) / scale);
        const double counts = counts_ + step;
        used_up_ = std::abs(counts) > std::numeric_limits<std::int32_t>::max();
        if (used_up_) return;
        counts_ = static_cast<std::int32_t>(counts);
        expected_ = request + step * scale;
        under_way_ = step != 0;
    }

    std::int32_t counts() const noexcept { return counts_; }
    bool under_way() const noexcept { return under_way_; }        // a step has no answer yet
    bool silent() const noexcept { return silence_ > patience; }  // LinuxCNC does not take the steps
    bool used_up() const noexcept { return used_up_; }            // the step does not fit into 32 bits

private:
    static constexpr int patience = 10;  // periods

    std::int32_t counts_ = 0;
    double expected_ = 0;
    int silence_ = 0;
    bool used_up_ = false, under_way_ = false;
};

}  // namespace plumb
