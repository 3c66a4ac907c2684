// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/modbus_connection.hpp"
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
struct ModbusLinkState : LinkState<ModbusLinkSettings, ModbusLinkFault> {
    struct Command {
        bool enable = false;
        double value = 0;
    };

    ModbusLinkState(ModbusLinkSettings its, Say its_say) : LinkState(std::move(its), std::move(its_say)) {
        commands.resize(settings.channels.size());
        written.resize(settings.channels.size());
    }

    // Guarded by the mutex.
    std::vector<Command> commands;               // one a channel; of outputs
    std::vector<std::optional<double>> written;  // the command that the device has last acknowledged
};

// The thread of a link: connects, asks, judges, and starts again after every failure.
//
// A reply that comes late must not pass for the reply to the next request. Over TCP each failure closes the
// connection. A serial line has no such end: after a failure the device is left alone for longer than it may
// take, and what it sends then is thrown away. Its next reply may still be the late one, and is dropped; the
// reply after that counts if no other follows it. Later, bytes that nobody has asked for make the values
// before them invalid.
class ModbusTalk {
public:
    explicit ModbusTalk(ModbusLinkState& state) : state_(state), settings_(state.settings) {
        for (const ModbusGroup& group : request_plan(settings_.channels, settings_.gap))
            tasks_.push_back({group, 0, {}});
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
            tasks_.push_back({group, 0, {}});
        }
        for (const Task& task : tasks_)
            devices_.emplace(task.group.request.device,
                             Device{BackOff(settings_.retry, settings_.retry_max)});
    }

    void run() {
        while (!state_.pauses.stopped()) {
            try {
                if (!connection_.is_open())
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
    using Status = ModbusReply::Status;

    // What the next reply of a device is taken for. `alone`: a value if no other reply follows it.
    enum class Next { value, alone, nothing };

    struct Device {
        BackOff back_off;
        bool answers = false;
        Next next = Next::value;
        double replied = 0;  // s
        double pause = 0;    // s, after its reply
        int unheard = 0;     // hasty requests since one was answered: see learn_pause()
    };
    struct Task {
        ModbusGroup group;
        double due;
        Cause refusal;
    };

    void connect() {
        Pauses& pauses = state_.pauses;
        if (pauses.wait(back_off_.until()) == Woken::stopped) return;
        try {
            if (settings_.is_serial()) {
                connection_ = ModbusConnection::opened(settings_.path, settings_.serial);
            } else {
                const NameLookup::Result found =
                    lookup_.find(settings_.host, settings_.port, pauses, seconds_now() + settings_.timeout);
                if (pauses.stopped()) return;
                if (found.addresses.empty()) return not_connected(ModbusLinkFault::name, found.error);
                connection_ = ModbusConnection::connected(found.addresses, pauses, settings_.timeout);
            }
        } catch (const std::system_error& error) {
            if (pauses.stopped()) return;
            return not_connected(settings_.is_serial() ? ModbusLinkFault::port : ModbusLinkFault::unreachable,
                                 error.what());
        }
        replies_ = 0;
        quiet_until_ = 0;
    }

    void not_connected(ModbusLinkFault fault, const std::string& why) {
        back_off_.failed(seconds_now());
        disconnected(fault, why);
    }

    // The connection is gone. It is made again at once if it has worked, so that one reply lost costs little.
    void lose(const std::string& why) {
        connection_.close();
        if (replies_ == 0 || settings_.is_serial()) back_off_.failed(seconds_now());
        disconnected(ModbusLinkFault::lost, why);
    }

    void disconnected(ModbusLinkFault fault, const std::string& why) {
        for (auto& [number, device] : devices_) device.answers = false;
        {
            const std::lock_guard lock(state_.mutex);
            state_.disconnect(fault);
        }
        report(settings_.place() + ": " + why);
    }

    // The next request that is due, or a pause in which the connection is watched.
    void work() {
        Task* next = nullptr;
        double when = 0;
        const double now = seconds_now();
        for (Task& task : tasks_) {
            const Device& device = device_of(task);
            const double ready = std::max({task.due, device.back_off.until(), device.replied + device.pause,
                                           device.answers ? 0 : trial_after_});
            // Of those that wait the one that has waited longest.
            if (!next || (ready <= now && when <= now ? task.due < next->due : ready < when)) {
                next = &task;
                when = ready;
            }
        }
        when = std::max(when, quiet_until_);
        const Woken woken =
            when > now ? state_.pauses.wait(connection_.number(), POLLIN, when) : Woken::ready;
        if (woken != Woken::ready) return;
        if (connection_.waiting() > 0) return throw_away();
        if (seconds_now() < when) connection_.lost();
        // Times that have passed are left out.
        if (perform(*next)) next->due = std::max(next->due + next->group.every, seconds_now());
    }

    // Bytes that nobody has asked for.
    void throw_away() {
        if (!settings_.is_serial())
            throw std::system_error(EPROTO, std::generic_category(), "reply without request");
        const std::size_t stray = drain();
        if (stray < modbus_shortest || last_ == nullptr) return;
        // The reply before this one may have been late, and this is the one to the last request.
        const int number = last_->group.request.device;
        {
            const std::lock_guard lock(state_.mutex);
            for (std::size_t i = 0; i < settings_.channels.size(); ++i)
                if (settings_.channels[i].device == number) state_.judges[i].reject(SensorFault::damaged);
            state_.connected = false;
            state_.fault = ModbusLinkFault::silent;
            state_.count_error();
        }
        Device& device = devices_.at(number);
        device.back_off.failed(seconds_now());
        device.answers = false;
        device.next = Next::nothing;
        last_ = nullptr;
    }

    // False if the same request is due again.
    bool perform(Task& task) {
        ModbusRequest request = task.group.request;
        std::optional<double> command;
        const std::size_t first = task.group.channels.front();
        if (settings_.channels[first].output) {
            command = command_to_write(first, request);
            if (!command) return true;
        }
        Device& device = device_of(task);
        // Unless the reply comes, and is intact.
        const Next next = std::exchange(device.next, settings_.is_serial() ? Next::nothing : Next::value);
        const double asked = seconds_now();
        ModbusReply reply = asked_for(request);
        const double round_trip = seconds_now() - asked;
        if (state_.pauses.stopped()) return true;
        const bool whole = reply.status == Status::good || reply.status == Status::exception;
        if (whole && hasty(device, asked)) device.unheard = 0;
        if (whole) device.replied = asked + round_trip;
        if (whole && next == Next::nothing) {
            device.next = Next::alone;
            return false;
        }
        if (whole && next == Next::alone && another_follows(request)) reply = modbus_wrong();
        if (state_.pauses.stopped()) return true;
        switch (reply.status) {
            case Status::good: {
                task.refusal.over();
                const std::lock_guard lock(state_.mutex);
                if (command) {
                    state_.judges[first].take(asked, *command);
                    state_.written[first] = command;
                } else {
                    take(task.group, reply, asked);
                }
                break;
            }
            case Status::exception: refused(task, reply.exception); break;
            default: failed(task, reply.status == Status::silent, asked); return true;
        }
        ++replies_;
        back_off_.succeeded();
        device.back_off.succeeded();
        device.next = Next::value;
        device.answers = true;
        last_ = &task;
        reported_.over();
        const std::lock_guard lock(state_.mutex);
        state_.round_trip = round_trip;
        state_.connected = true;
        state_.fault = ModbusLinkFault::none;
        return true;
    }

    void take(const ModbusGroup& group, const ModbusReply& reply, double asked) {
        for (const std::size_t i : group.channels) {
            const ModbusChannel& channel = settings_.channels[i];
            const auto* const words = reply.words.data() + (channel.first - group.request.first);
            const double number = group.request.of_bits() ? *words : decoded(words, channel.encoding);
            state_.judges[i].take(asked, channel.scale.value_of(number));
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

    // Sends the request. The reply is silent if it has not come in time.
    ModbusReply asked_for(const ModbusRequest& request) {
        const double until = seconds_now() + patience(request);
        ModbusReply reply;
        if (connection_.send(request, state_.pauses, until))
            reply = connection_.reply(request, state_.pauses, until);
        quiet_until_ = settings_.is_serial() ? seconds_now() + settings_.serial.silence() : 0;
        return reply;
    }

    // As long as a request and its reply may take, s.
    double patience(const ModbusRequest& request) const {
        if (!settings_.is_serial()) return settings_.timeout;
        const std::size_t bytes = request.bytes().size() + 2 + request.reply_size() + 2;
        return settings_.timeout + static_cast<double>(bytes) * settings_.serial.byte_time();
    }

    // True if another reply comes within the time of one.
    bool another_follows(const ModbusRequest& request) {
        return state_.pauses.wait(connection_.number(), POLLIN, seconds_now() + patience(request)) ==
               Woken::ready;
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
        if (task.refusal.is_new(why)) state_.say(settings_.name + ": " + why);
    }

    // No reply, or none that is intact: the device is left alone for a while.
    void failed(Task& task, bool silent, double asked) {
        const int number = task.group.request.device;
        Device& device = device_of(task);
        if (silent) learn_pause(number, device, asked);
        device.answers = false;
        device.back_off.failed(seconds_now());
        trial_after_ = seconds_now() + settings_.timeout;
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
            connection_.close();
    }

    // Some devices do not hear a request that comes sooner than 10 or 50 ms after their reply. If two such
    // requests were silent, and none was answered between them, the next ones come later.
    static bool hasty(const Device& device, double asked) { return asked - device.replied < 2 * first_pause; }
    void learn_pause(int number, Device& device, double asked) {
        if (!hasty(device, asked) || ++device.unheard < 2 || device.pause == last_pause) return;
        device.pause = device.pause > 0 ? last_pause : first_pause;
        state_.say(settings_.name + ": device " + std::to_string(number) + " has a pause of " +
                   std::to_string(std::lround(1000 * device.pause)) +
                   " ms after each reply: it did not hear two requests");
    }
    static constexpr double first_pause = 0.02, last_pause = 0.1;  // s

    // Discards what comes until the line is silent, for no longer than a reply takes; returns its bytes.
    std::size_t drain() {
        const std::size_t bytes =
            connection_.discard(state_.pauses, settings_.serial.silence(), seconds_now() + settings_.timeout);
        quiet_until_ = seconds_now();
        return bytes;
    }

    Device& device_of(const Task& task) { return devices_.at(task.group.request.device); }

    // Once for each cause, until the link works again.
    void report(const std::string& text) {
        if (reported_.is_new(text)) state_.say(settings_.name + ": " + text);
    }

    ModbusLinkState& state_;
    const ModbusLinkSettings& settings_;
    std::vector<Task> tasks_;
    std::map<int, Device> devices_;  // by number
    ModbusConnection connection_;
    NameLookup lookup_;
    BackOff back_off_{settings_.retry, settings_.retry_max};  // of the connection
    int replies_ = 0;                                         // since it was made
    double quiet_until_ = 0;
    // Those that do not answer are tried for at most half of the time, so that the others are asked as
    // before.
    double trial_after_ = 0;
    const Task* last_ = nullptr;  // that was answered
    Cause reported_;
};

using ModbusLink = Worker<ModbusLinkState, ModbusTalk>;

}  // namespace plumb
