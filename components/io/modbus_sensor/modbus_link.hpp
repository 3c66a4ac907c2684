// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/byte_stream.hpp"
#include "components/io/modbus_sensor/modbus_link_fault.hpp"
#include "components/io/modbus_sensor/request_plan.hpp"
#include "components/io/sensor/back_off.hpp"
#include "components/io/sensor/link_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace plumb {

// The values that the thread of a link shares with others.
struct ModbusLinkState : LinkState {
    struct Command {
        bool enable = false;
        double value = 0;
    };

    ModbusLinkState(ModbusLinkSettings its, Say its_say)
        : LinkState(its.channels, std::move(its_say)), settings(std::move(its)) {
        commands.resize(settings.channels.size());
        written.resize(settings.channels.size());
    }

    const ModbusLinkSettings settings;

    // All guarded by the mutex.
    std::vector<Command> commands;               // one a channel; of outputs
    std::vector<std::optional<double>> written;  // the command that the device has last acknowledged
    ModbusLinkFault fault = ModbusLinkFault::none;
};

// The thread of a link: connects, asks, judges, and starts again after every failure.
//
// A reply that comes late must not pass for the reply to the next request. Over TCP each failure closes the
// connection. A serial line has no such end: after a failure the device is left alone for longer than it may
// take, and what it sends then is thrown away; bytes that nobody has asked for make the values before them
// invalid.
class ModbusTalk {
public:
    explicit ModbusTalk(ModbusLinkState& state) : state_(state), settings_(state.settings) {
        for (const ModbusGroup& group : request_plan(settings_.channels, settings_.gap))
            tasks_.push_back({group, 0, ""});
        for (std::size_t i = 0; i < settings_.channels.size(); ++i) {
            const ModbusChannel& channel = settings_.channels[i];
            if (!channel.output) continue;
            ModbusGroup group;
            group.request.device = channel.device;
            group.request.table = channel.table;
            group.request.first = channel.first;
            group.request.count = channel.count();
            group.request.multiple = channel.multiple;
            group.every = channel.every;
            group.channels = {i};
            tasks_.push_back({group, 0, ""});
        }
        for (const Task& task : tasks_)
            devices_.emplace(task.group.request.device,
                             Device{{settings_.retry, settings_.retry_max}, false});
    }

    void run() {
        while (!state_.pauses.stopped()) {
            try {
                if (!stream_.is_open())
                    connect();
                else
                    work();
            } catch (const std::system_error& error) {
                lose(error.what());
            }
        }
    }

private:
    using Woken = Pauses::Woken;

    struct Device {
        BackOff back_off;
        bool answers;
    };
    struct Task {
        ModbusGroup group;
        double due;
        std::string refusal;  // that was reported
    };

    void connect() {
        Pauses& pauses = state_.pauses;
        if (pauses.wait(back_off_.until()) == Woken::stopped) return;
        try {
            if (settings_.is_serial()) {
                stream_ = ByteStream::opened(settings_.path, settings_.serial);
            } else {
                const NameLookup::Result found =
                    lookup_.find(settings_.host, settings_.port, pauses, seconds_now() + settings_.timeout);
                if (pauses.stopped()) return;
                if (found.addresses.empty()) return not_connected(ModbusLinkFault::name, found.error);
                stream_ = ByteStream::connected(found.addresses, pauses, settings_.timeout);
            }
        } catch (const std::system_error& error) {
            if (pauses.stopped()) return;
            return not_connected(settings_.is_serial() ? ModbusLinkFault::port : ModbusLinkFault::unreachable,
                                 error.what());
        }
        replies_ = 0;
        ++number_;
        quiet_until_ = 0;
    }

    void not_connected(ModbusLinkFault fault, const std::string& why) {
        back_off_.failed(seconds_now());
        disconnected(fault, why);
    }

    // The connection is gone. It is made again at once if it has worked, so that one reply lost costs little.
    void lose(const std::string& why) {
        stream_.close();
        if (replies_ == 0 || settings_.is_serial()) back_off_.failed(seconds_now());
        disconnected(ModbusLinkFault::lost, why);
    }

    void disconnected(ModbusLinkFault fault, const std::string& why) {
        for (auto& [number, device] : devices_) device.answers = false;
        {
            const std::lock_guard lock(state_.mutex);
            for (Judge& judge : state_.judges) judge.fail(SensorFault::disconnected);
            state_.connected = false;
            state_.fault = fault;
            state_.count_error();
        }
        report(settings_.place() + ": " + why);
    }

    // The next request that is due, or a pause in which the connection is watched.
    void work() {
        Task* next = nullptr;
        double when = 0;
        const double now = seconds_now();
        for (Task& task : tasks_) {
            const double ready = std::max(task.due, device_of(task).back_off.until());
            // Of those that wait the one that has waited longest.
            if (!next || (ready <= now && when <= now ? task.due < next->due : ready < when)) {
                next = &task;
                when = ready;
            }
        }
        when = std::max(when, quiet_until_);
        if (when > now && state_.pauses.wait(stream_.number(), POLLIN, when) == Woken::time) return;
        if (state_.pauses.stopped()) return;
        if (throw_away()) return;
        if (seconds_now() < when) return;
        perform(*next);
        // Times that have passed are left out.
        next->due = std::max(next->due + next->group.every, seconds_now());
    }

    // Bytes that nobody has asked for. True if requests must wait.
    bool throw_away() {
        const std::size_t stray = stream_.discard(state_.pauses);
        if (stray == 0) return false;
        quiet_until_ = seconds_now() + silence();
        if (!settings_.is_serial())
            throw std::system_error(EPROTO, std::generic_category(), "reply without request");
        state_.pauses.wait(quiet_until_);  // a line that is never silent shall not use up the processor
        if (stray < shortest_reply || last_ == nullptr) return true;
        // The reply before this one may have been late, and this is the one to the last request.
        {
            const std::lock_guard lock(state_.mutex);
            for (std::size_t i = 0; i < settings_.channels.size(); ++i)
                if (settings_.channels[i].device == last_->group.request.device)
                    state_.judges[i].reject(SensorFault::damaged);
            state_.connected = false;
            state_.fault = ModbusLinkFault::silent;
            state_.count_error();
        }
        Device& device = device_of(*last_);
        device.back_off.failed(seconds_now());
        device.answers = false;
        last_ = nullptr;
        return true;
    }

    void perform(Task& task) {
        ModbusRequest request = task.group.request;
        std::optional<double> command;
        const std::size_t first = task.group.channels.front();
        if (settings_.channels[first].output) {
            command = command_to_write(first, request);
            if (!command) return;
        }
        const double asked = seconds_now();
        const ModbusReply reply = asked_for(request);
        if (state_.pauses.stopped()) return;
        const double now = seconds_now();
        Device& device = device_of(task);
        switch (reply.status) {
            case ModbusReply::Status::good: {
                device.back_off.succeeded();
                task.refusal.clear();
                const std::lock_guard lock(state_.mutex);
                if (command) {
                    state_.judges[first].take(asked, *command);
                    state_.written[first] = command;
                } else {
                    take(task.group, reply, asked);
                }
                break;
            }
            case ModbusReply::Status::exception: refused(task, reply.exception); break;
            default: failed(task, reply.status == ModbusReply::Status::incomplete); return;
        }
        ++replies_;
        back_off_.succeeded();
        device.answers = true;
        last_ = &task;
        const std::lock_guard lock(state_.mutex);
        state_.round_trip = now - asked;
        state_.connected = true;
        state_.fault = ModbusLinkFault::none;
        reported_.clear();
    }

    void take(const ModbusGroup& group, const ModbusReply& reply, double asked) {
        for (const std::size_t i : group.channels) {
            const ModbusChannel& channel = settings_.channels[i];
            const auto* const words = reply.words.data() + (channel.first - group.request.first);
            const double number = group.request.of_bits() ? *words : decoded(words, channel.encoding);
            state_.judges[i].take(asked, number * channel.scale.scale + channel.scale.offset);
        }
    }

    // The command of an output, whose registers it puts into the request; or nothing if it is not to be
    // written.
    std::optional<double> command_to_write(std::size_t i, ModbusRequest& request) {
        const ModbusChannel& channel = settings_.channels[i];
        const std::lock_guard lock(state_.mutex);
        const ModbusLinkState::Command command = state_.commands[i];
        if (!command.enable) return std::nullopt;
        request.words.resize(static_cast<std::size_t>(channel.count()));
        const bool within = command.value >= channel.limits.min && command.value <= channel.limits.max;
        const double number = (command.value - channel.scale.offset) / channel.scale.scale;
        if (within && encode(number, channel.encoding, request.words.data())) return command.value;
        state_.judges[i].fail(SensorFault::command);
        return std::nullopt;
    }

    // Sends the request. The reply is incomplete if it has not come in time.
    ModbusReply asked_for(const ModbusRequest& request) {
        const bool serial = settings_.is_serial();
        const std::vector<std::uint8_t> frame = serial ? rtu_frame(request) : tcp_frame(request, ++number_);
        double until = seconds_now() + settings_.timeout;
        if (serial) {
            const int answer = 5 + (request.of_bits() ? (request.count + 7) / 8 : 2 * request.count);
            until += static_cast<double>(frame.size() + static_cast<std::size_t>(answer)) *
                     settings_.serial.byte_time();
        }
        ModbusReply reply;
        if (!stream_.send(frame, state_.pauses, until)) return reply;
        std::vector<std::uint8_t> bytes;
        while (reply.status == ModbusReply::Status::incomplete && seconds_now() < until &&
               !state_.pauses.stopped()) {
            if (stream_.receive(bytes, state_.pauses, until) == 0) continue;
            reply = serial ? rtu_reply(request, bytes.data(), bytes.size())
                           : tcp_reply(request, number_, bytes.data(), bytes.size());
        }
        quiet_until_ = serial ? seconds_now() + silence() : 0;
        return reply;
    }

    // The device has answered that it will not.
    void refused(Task& task, int exception) {
        {
            const std::lock_guard lock(state_.mutex);
            for (const std::size_t i : task.group.channels) state_.judges[i].fail(SensorFault::refused);
            state_.count_error();
        }
        const ModbusRequest& request = task.group.request;
        const std::string why = "device " + std::to_string(request.device) + ", " +
                                settings_.channels[task.group.channels.front()].name + ": exception " +
                                std::to_string(exception) + ", " + modbus_exception(exception);
        if (std::exchange(task.refusal, why) != why) state_.say(settings_.name + ": " + why);
        device_of(task).back_off.succeeded();
    }

    // No reply, or none that is intact: the device is left alone for a while.
    void failed(Task& task, bool silent) {
        const int number = task.group.request.device;
        Device& device = device_of(task);
        device.answers = false;
        device.back_off.failed(seconds_now());
        bool any = false;
        for (const auto& [each, its] : devices_) any |= its.answers;
        {
            const std::lock_guard lock(state_.mutex);
            for (std::size_t i = 0; i < settings_.channels.size(); ++i)
                if (settings_.channels[i].device == number)
                    state_.judges[i].fail(silent ? SensorFault::silent : SensorFault::damaged);
            state_.connected = any;
            if (!any) state_.fault = ModbusLinkFault::silent;
            state_.count_error();
        }
        if (!any) report(settings_.place() + (silent ? ": no reply" : ": damaged reply"));
        last_ = nullptr;
        if (settings_.is_serial())
            drain();
        else
            stream_.close();
    }

    // Waits, for no longer than a reply takes, until the line is silent.
    void drain() {
        const double until = seconds_now() + settings_.timeout;
        double silent = seconds_now() + silence();
        while (seconds_now() < std::min(silent, until) && !state_.pauses.stopped()) {
            std::vector<std::uint8_t> bytes;
            if (stream_.receive(bytes, state_.pauses, std::min(silent, until)) > 0)
                silent = seconds_now() + silence();
        }
        quiet_until_ = seconds_now();
    }

    // Between two frames on a serial line, s: three and a half bytes, and no less than above 19200 baud.
    double silence() const { return std::max(3.5 * settings_.serial.byte_time(), 1.75e-3); }

    Device& device_of(const Task& task) { return devices_.at(task.group.request.device); }

    // Once for each cause, until the link works again.
    void report(const std::string& text) {
        if (std::exchange(reported_, text) != text) state_.say(settings_.name + ": " + text);
    }

    static constexpr std::size_t shortest_reply = 5;  // bytes, on a serial line

    ModbusLinkState& state_;
    const ModbusLinkSettings& settings_;
    std::vector<Task> tasks_;
    std::map<int, Device> devices_;  // by number
    ByteStream stream_;
    NameLookup lookup_;
    BackOff back_off_{settings_.retry, settings_.retry_max};  // of the connection
    int replies_ = 0;                                         // since it was made
    std::uint16_t number_ = 0;                                // of the last request over TCP
    double quiet_until_ = 0;
    const Task* last_ = nullptr;  // that was answered
    std::string reported_;
};

using ModbusLink = Worker<ModbusLinkState, ModbusTalk>;

}  // namespace plumb
