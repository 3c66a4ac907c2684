// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"
#include "hal/any_value.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
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
        for (const char* const field : fields)
            if (!find_one(std::string("row-") + field) || !find_one(std::string("restore-") + field))
                return false;
        return true;
    }

    std::int64_t count() const { return whole("rows"); }

    // Nothing if the component does not answer in time.
    std::optional<GrowthRecord> read(std::int64_t row) const {
        write("row", row);
        if (!await([&] { return whole("row-shown") == row; })) return std::nullopt;
        std::atomic_thread_fence(std::memory_order_acquire);
        const auto real = [&](const char* field) {
            return std::get<double>(pins_.at(std::string("row-") + field).read());
        };
        const auto count = [&](const char* field) {
            return static_cast<int>(whole(std::string("row-") + field));
        };
        const auto bit = [&](const char* field) {
            return std::get<bool>(pins_.at(std::string("row-") + field).read());
        };
        GrowthRecord r;
        r.kind = count("kind");
        r.time = real("time");
        r.pass = count("pass");
        r.visit = count("visit");
        r.bore = count("bore");
        r.item = count("item");
        r.turned = bit("turned");
        r.compensated = bit("compensated");
        r.cooled = bit("cooled");
        r.at = {real("x"), real("y"), real("z")};
        r.offset = {real("x-offset"), real("y-offset"), real("z-offset")};
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
        const auto put = [&](const char* field, const hal::Value& value) {
            write(std::string("restore-") + field, value);
        };
        put("kind", std::int64_t{r.kind});
        put("time", r.time);
        put("pass", std::int64_t{r.pass});
        put("visit", std::int64_t{r.visit});
        put("bore", std::int64_t{r.bore});
        put("item", std::int64_t{r.item});
        put("turned", r.turned);
        put("compensated", r.compensated);
        put("cooled", r.cooled);
        put("x", r.at[0]);
        put("y", r.at[1]);
        put("z", r.at[2]);
        put("x-offset", r.offset[0]);
        put("y-offset", r.offset[1]);
        put("z-offset", r.offset[2]);
        std::atomic_thread_fence(std::memory_order_release);
        const auto answers = [&] { return std::pair(whole("restores"), whole("restores-refused")); };
        const auto before = answers();
        write("restore", true);
        if (!await([&] { return answers() != before; })) return std::nullopt;
        return answers().first != before.first;
    }

    void set_gap(double seconds) const { write("gap", seconds); }

private:
    static constexpr std::array<const char*, 15> fields{
        "kind",   "time", "pass", "visit", "bore",     "item",     "turned",  "compensated",
        "cooled", "x",    "y",    "z",     "x-offset", "y-offset", "z-offset"};

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
