// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/liveness.hpp"
#include "components/io/sensor/reading.hpp"
#include "hal/component.hpp"
#include "hal/program_state.hpp"

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace plumb {

// The pins of a channel, NAME.value and so on.
struct ChannelPins : hal::Group {
    // unit: of the value; a bit has none.
    ChannelPins(hal::Owner owner, const std::string& name, const std::optional<std::string>& unit)
        : Group(owner),
          its_(name + "."),
          valid{this, its_ + "valid", "The value is valid."},
          age{this, its_ + "age", "s", "Time since the value was requested, or since its frame arrived."},
          errors{this, its_ + "error-count", "Number of failed requests and rejected values."},
          fault{this, its_ + "fault", "A fault of the channel is active; its fault-code gives the cause."} {
        const char* const sentence =
            "Last accepted value; of an output, the last command that the device acknowledged.";
        if (unit)
            number_.emplace(this, its_ + "value", *unit, sentence);
        else
            bit_.emplace(this, its_ + "value",
                         "Last accepted state of a coil, a discrete input or a bit; of an output, the last "
                         "acknowledged command.");
    }

    // A reader never sees an invalid value as valid: valid falls before the value changes, and rises after
    // it.
    void show(const Reading& reading) noexcept {
        if (!reading.valid) valid = false;
        std::atomic_thread_fence(std::memory_order_release);
        if (number_) *number_ = reading.value;
        if (bit_) *bit_ = reading.value != 0;
        age = reading.age;
        errors = reading.errors;
        fault = reading.fault;
        std::atomic_thread_fence(std::memory_order_release);
        if (reading.valid) valid = true;
    }

private:
    const std::string its_;

public:
    hal::Out<bool> valid;
    hal::Out<double> age;
    hal::Out<std::int32_t> errors;
    hal::Codes<SensorFault> fault;

private:
    std::optional<hal::Out<double>> number_;
    std::optional<hal::Out<bool>> bit_;
};

// The pins of a link, NAME.connected and so on, and the pins of its channels.
template <class Fault>
struct LinkPins : hal::Group {
    template <class Settings>
    LinkPins(hal::Owner owner, const Settings& settings, const char* connected_sentence,
             const char* round_trip_sentence)
        : Group(owner),
          its_(settings.name + "."),
          connected{this, its_ + "connected", connected_sentence},
          program_state{this, hal::Service::any, its_},
          round_trip{this, its_ + "round-trip", "s", round_trip_sentence},
          errors{this, its_ + "error-count", "Number of failures."},
          fault{this, its_ + "fault", "A fault of the link is active; its fault-code gives the cause."} {
        for (const auto& channel : settings.channels)
            channels.emplace_back(this, channel.name,
                                  channel.is_bit() ? std::nullopt : std::optional(channel.scale.unit));
    }

    // The link itself, of whose state the caller holds the mutex; dt: s since the last call.
    template <class State>
    void show(const State& state, double dt) noexcept {
        connected = state.connected;
        program_state.report(liveness_.lives(state.pauses.turns(), dt), {true, state.fault != Fault::none});
        round_trip = state.round_trip;
        errors = state.errors;
        fault = state.fault;
    }

private:
    const std::string its_;
    Liveness liveness_;

public:
    hal::Out<bool> connected;
    hal::ProgramState program_state;
    hal::Out<double> round_trip;
    hal::Out<std::int32_t> errors;
    hal::Codes<Fault> fault;
    std::deque<ChannelPins> channels;
};

}  // namespace plumb
