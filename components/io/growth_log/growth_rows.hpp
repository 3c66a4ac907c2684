// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"
#include "hal/any_value.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace plumb {

// The records of thermal_growth_test, read and given back through its pins. The component answers once in
// each period of its thread; not at all while the threads stand.
class GrowthRows {
public:
    explicit GrowthRows(std::string component) : component_(std::move(component)) {}

    // Finds the pins. False if the component is not there, or lacks one.
    bool find() {
        pins_.clear();
        for (const char* const name :
             {"row", "row-shown", "rows", "restore", "restores", "restores-refused", "gap"})
            if (!find_one(name)) return false;
        bool all = true;
        GrowthRecord record;
        each_field(record, [&](const std::string& field, auto&) {
            all = all && find_one("row-" + field) && find_one("restore-" + field);
        });
        return all;
    }

    std::int64_t count() const { return whole("rows"); }

    // Nothing if the component does not answer in time.
    std::optional<GrowthRecord> read(std::int64_t row) const {
        write("row", row);
        if (!await([&] { return whole("row-shown") == row; })) return std::nullopt;
        std::atomic_thread_fence(std::memory_order_acquire);
        GrowthRecord r;
        each_field(r, [&](const std::string& field, auto& value) {
            using Type = std::decay_t<decltype(value)>;
            value = static_cast<Type>(std::get<Wide<Type>>(pins_.at("row-" + field).read()));
        });
        return whole("row-shown") == row ? std::optional(r) : std::nullopt;
    }

    // Whether the component has seen restore false in a period of its own, as the edge of the next record
    // needs. A record given before has then been counted, or never will be.
    bool settle() const {
        if (count() == 0) {  // no row can answer; an edge that was not seen is given again
            const bool rests = !std::get<bool>(pins_.at("restore").read());
            write("restore", false);
            return rests;
        }
        write("restore", false);
        const std::int64_t other = whole("row-shown") < 0 ? 0 : -1;
        write("row", other);
        return await([&] { return whole("row-shown") == other; });
    }

    // Gives one record back, after settle(). Nothing if the component does not answer, else whether it
    // accepted the record.
    std::optional<bool> give(const GrowthRecord& r) const {
        each_field(r, [&](const std::string& field, auto value) {
            write("restore-" + field, Wide<decltype(value)>{value});
        });
        std::atomic_thread_fence(std::memory_order_release);
        const auto answers = [&] { return std::pair(whole("restores"), whole("restores-refused")); };
        const auto before = answers();
        write("restore", true);
        if (!await([&] { return answers() != before; })) return std::nullopt;
        return answers().first != before.first;
    }

    void set_gap(double seconds) const { write("gap", seconds); }

private:
    // The type of a pin for a field of this type.
    template <class Type>
    using Wide = std::conditional_t<std::is_same_v<Type, int>, std::int64_t, Type>;

    // The fields of a record, by the names of their pins.
    template <class Record, class Visit>
    static void each_field(Record& r, Visit visit) {
        visit("kind", r.kind), visit("time", r.time), visit("item", r.item);
        visit("pass", r.pass), visit("visit", r.visit), visit("bore", r.bore);
        visit("turned", r.turned), visit("compensated", r.compensated), visit("cooled", r.cooled);
        visit("x", r.at[0]), visit("y", r.at[1]), visit("z", r.at[2]);
        visit("x-offset", r.offset[0]), visit("y-offset", r.offset[1]), visit("z-offset", r.offset[2]);
    }

    bool find_one(const std::string& name) {
        const auto pin = hal::NamedPin::find(component_ + '.' + name);
        if (!pin) return false;
        pins_.insert_or_assign(name, *pin);
        return true;
    }
    std::int64_t whole(const std::string& name) const {
        return std::get<std::int64_t>(pins_.at(name).read());
    }
    void write(const std::string& name, const hal::Value& value) const { pins_.at(name).write(value); }

    template <class Condition>
    static bool await(const Condition& condition) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
        while (!condition()) {
            if (std::chrono::steady_clock::now() > end) return false;
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        }
        return true;
    }

    const std::string component_;
    std::map<std::string, hal::NamedPin> pins_;
};

}  // namespace plumb
