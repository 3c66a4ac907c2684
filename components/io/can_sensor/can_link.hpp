// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/can_sensor/can_link_fault.hpp"
#include "components/io/can_sensor/can_settings.hpp"
#include "components/io/can_sensor/can_socket.hpp"
#include "components/io/sensor/back_off.hpp"
#include "components/io/sensor/link_state.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace plumb {

// The values that the thread of a link shares with others.
struct CanLinkState : LinkState<CanLinkSettings, CanLinkFault> {
    using LinkState::LinkState;

    // Guarded by the mutex.
    std::int32_t frames = 0;  // that were received; begins again at 0 after the largest number
};

// Gives frames to the channels that they belong to. Used by the thread of a link, and by tests alone.
class CanDispatch {
public:
    explicit CanDispatch(const std::vector<CanChannel>& channels) : channels_(channels) {}

    // Calls use(channel, value) for each value in the frame, and damaged(channel) where it is too short for
    // one.
    template <class Use, class Damaged>
    void operator()(const CanFrame& frame, const Use& use, const Damaged& damaged) const {
        for (std::size_t i = 0; i < channels_.size(); ++i) {
            const CanChannel& channel = channels_[i];
            if (channel.object || !channel.match(frame)) continue;
            if (const auto& multiplexer = channel.multiplexer) {
                if (multiplexer->signal.bytes() > frame.size) {
                    damaged(i);
                    continue;
                }
                const std::uint64_t value = raw_bits(multiplexer->signal, frame.bytes);
                if (value < multiplexer->first || value > multiplexer->last) continue;
            }
            if (channel.signal.bytes() > frame.size)
                damaged(i);
            else
                use(i, channel.scale.value_of(decoded(channel.signal, frame.bytes)));
        }
    }

private:
    const std::vector<CanChannel>& channels_;
};

// The thread of a link: listens, asks for objects if it may, and starts again when the interface was away.
class CanTalk {
public:
    explicit CanTalk(CanLinkState& state)
        : state_(state), settings_(state.settings), dispatch_(settings_.channels) {
        for (std::size_t i = 0; i < settings_.channels.size(); ++i) {
            const CanChannel& channel = settings_.channels[i];
            if (channel.object) {
                objects_.push_back(
                    {i, 0, 0, BackOff(settings_.retry, std::max(settings_.retry_max, channel.every)), {}});
                match(canopen::sdo_reply + static_cast<std::uint32_t>(channel.object->node));
            } else {
                matches_.push_back(channel.match);
            }
        }
        for (const int node : settings_.nmt_start)
            match(canopen::heartbeat + static_cast<std::uint32_t>(node));
    }

    void run() {
        while (!state_.pauses.stopped()) {
            try {
                if (!socket_.is_open())
                    open();
                else
                    serve();
            } catch (const std::system_error& error) {
                reported_down_ = error.code().value() == ENETDOWN;
                if (!reported_down_) socket_.close();
                disconnected(fault_of(error.code().value()), error.code().message());
            }
        }
    }

private:
    // An object, and the request for it.
    struct Asked {
        std::size_t channel;
        double due;
        double asked;  // 0 while no reply is awaited
        BackOff back_off;
        Cause refusal;
    };

    void match(std::uint32_t id) {
        CanMatch match;
        match.id = id;
        matches_.push_back(match);
    }

    static CanLinkFault fault_of(int error) {
        switch (error) {
            case ENETDOWN: return CanLinkFault::down;
            case ENODEV:
            case ENXIO: return CanLinkFault::missing;
            default: return CanLinkFault::unsupported;
        }
    }

    void open() {
        if (state_.pauses.wait(back_off_.until()) == Pauses::Woken::stopped) return;
        try {
            socket_ = CanSocket(settings_.interface, matches_);
        } catch (const std::system_error&) {
            back_off_.failed(seconds_now());
            throw;
        }
        back_off_.succeeded();
        dropped_ = 0;
        look_at_ = 0;
        up_ = false;
    }

    void serve() {
        double now = seconds_now();
        if (now >= look_at_) look(now);
        if (!socket_.is_open()) return;
        double until = look_at_;
        if (up_) {
            for (Asked& each : objects_) {
                ask(each, now);
                until = std::min(until, each.asked > 0 ? each.asked + settings_.timeout
                                                       : std::max(each.due, each.back_off.until()));
            }
        }
        const bool ready = state_.pauses.wait(socket_.number(), POLLIN, until) == Pauses::Woken::ready;
        CanReceived received;
        if (ready) socket_.look_at_clocks();
        // A full bus must not keep the thread from the rest.
        for (int i = 0; ready && i < most_at_once && socket_.receive(received); ++i) take(received);
        // The next frames come together: a full bus would wake the thread 9,000 times a second.
        if (ready) state_.pauses.wait(seconds_now() + rest);
        if (!to_say_.empty()) state_.say(std::exchange(to_say_, ""));  // while nobody waits for the mutex
    }

    // Looks at the interface, which does not always say that it has changed.
    void look(double now) {
        look_at_ = now + look_every;
        switch (socket_.state(settings_.interface)) {
            case CanSocket::State::gone:
                socket_.close();
                disconnected(CanLinkFault::missing, "the interface is gone");
                break;
            case CanSocket::State::down:
                if (up_ || !reported_down_) disconnected(CanLinkFault::down, "the interface is down");
                reported_down_ = true;
                break;
            case CanSocket::State::up:
                reported_down_ = false;
                if (!std::exchange(up_, true)) connected();
                if (now >= errors_until_) {
                    const std::lock_guard lock(state_.mutex);
                    if (state_.fault != CanLinkFault::bus_off) state_.fault = CanLinkFault::none;
                }
        }
    }

    void connected() {
        {
            const std::lock_guard lock(state_.mutex);
            state_.connected = true;
            state_.fault = CanLinkFault::none;
        }
        reported_.over();
        for (Asked& each : objects_) each.asked = 0;
        for (const int node : settings_.nmt_start) socket_.send(canopen::start_node(node));
    }

    void disconnected(CanLinkFault fault, const std::string& why) {
        up_ = false;
        {
            const std::lock_guard lock(state_.mutex);
            state_.disconnect(fault);
        }
        report(why);
    }

    void take(const CanReceived& received) {
        const std::lock_guard lock(state_.mutex);
        if (received.dropped != dropped_) {
            dropped_ = received.dropped;
            bus_fault(CanLinkFault::overrun);
        }
        if (received.error != 0) return take_error(received.error);
        state_.frames = state_.frames < std::numeric_limits<std::int32_t>::max() ? state_.frames + 1 : 0;
        if (state_.fault == CanLinkFault::bus_off) recovered();
        dispatch_(
            received.frame, [&](std::size_t i, double value) { state_.judges[i].take(received.time, value); },
            [&](std::size_t i) { state_.judges[i].fail(SensorFault::damaged); });
        for (Asked& each : objects_)
            if (each.asked > 0) take_reply(each, received);
        take_heartbeat(received.frame);
    }

    void take_error(std::uint32_t error) {
        if ((error & CAN_ERR_RESTARTED) != 0) return recovered();
        if ((error & CAN_ERR_BUSOFF) != 0) {
            state_.disconnect(CanLinkFault::bus_off);
        } else if (state_.fault != CanLinkFault::bus_off) {
            bus_fault(CanLinkFault::errors);
        }
    }

    // Shown for a while, as nothing says when it is over.
    void bus_fault(CanLinkFault fault) {
        state_.fault = fault;
        state_.count_error();
        errors_until_ = seconds_now() + errors_shown;
    }

    void recovered() {
        state_.fault = CanLinkFault::none;
        state_.connected = true;
    }

    // A node that starts, or stands by, is made operational. It sends nothing before.
    void take_heartbeat(const CanFrame& frame) {
        for (const int node : settings_.nmt_start)
            if (!frame.extended && frame.id == canopen::heartbeat + static_cast<std::uint32_t>(node) &&
                frame.size >= 1 &&
                (frame.bytes[0] == canopen::boot_up || frame.bytes[0] == canopen::pre_operational))
                socket_.send(canopen::start_node(node));
    }

    void ask(Asked& each, double now) {
        const CanChannel& channel = settings_.channels[each.channel];
        if (each.asked > 0 && now >= each.asked + settings_.timeout) {
            each.asked = 0;
            each.back_off.failed(now);
            const std::lock_guard lock(state_.mutex);
            state_.judges[each.channel].fail(SensorFault::silent);
        }
        if (each.asked > 0 || now < std::max(each.due, each.back_off.until())) return;
        // A node answers one request at a time.
        for (const Asked& other : objects_)
            if (other.asked > 0 && settings_.channels[other.channel].object->node == channel.object->node) {
                each.due = now + 0.001;
                return;
            }
        each.due = std::max(each.due + channel.every, now);
        if (socket_.send(canopen::upload_request(*channel.object))) {
            each.asked = now;
        } else {
            each.back_off.failed(now);
        }
    }

    void take_reply(Asked& each, const CanReceived& received) {
        const CanChannel& channel = settings_.channels[each.channel];
        const canopen::Upload upload = canopen::upload_reply(*channel.object, received.frame);
        if (upload.status == canopen::Upload::Status::other) return;
        Judge& judge = state_.judges[each.channel];
        const double asked = std::exchange(each.asked, 0);
        state_.round_trip = std::max(received.time - asked, 0.0);
        if (upload.status == canopen::Upload::Status::good &&
            channel.signal.bytes() <= static_cast<std::size_t>(upload.size)) {
            each.back_off.succeeded();
            each.refusal.over();
            return judge.take(asked, channel.scale.value_of(decoded(channel.signal, upload.data)));
        }
        const bool abort = upload.status == canopen::Upload::Status::abort;
        judge.fail(abort ? SensorFault::refused : SensorFault::damaged);
        each.back_off.failed(seconds_now());
        char code[16];
        std::snprintf(code, sizeof code, "0x%08X", upload.abort_code);
        const std::string why =
            channel.name + ": " + (abort ? std::string("SDO abort ") + code : "SDO reply of another size");
        if (each.refusal.is_new(why)) to_say_ = settings_.name + ": " + why;
    }

    // Once for each cause, until the link works again.
    void report(const std::string& text) {
        if (reported_.is_new(text)) state_.say(settings_.name + ": " + settings_.interface + ": " + text);
    }

    static constexpr double look_every = 0.1;  // s
    static constexpr double errors_shown = 1;  // s
    static constexpr double rest = 0.002;      // s, after frames; the socket holds ten times as many
    static constexpr int most_at_once = 256;   // frames

    CanLinkState& state_;
    const CanLinkSettings& settings_;
    const CanDispatch dispatch_;
    std::vector<CanMatch> matches_;
    std::vector<Asked> objects_;
    CanSocket socket_;
    BackOff back_off_{settings_.retry, settings_.retry_max};
    bool up_ = false;
    bool reported_down_ = false;
    double look_at_ = 0, errors_until_ = 0;
    std::uint32_t dropped_ = 0;
    Cause reported_;
    std::string to_say_;
};

using CanLink = Worker<CanLinkState, CanTalk>;

}  // namespace plumb
