// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/retain/retained_file.hpp"
#include "hal/any_value.hpp"
#include "hal/pin_list.hpp"

#include <atomic>
#include <chrono>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {

// A pin or a component to keep is missing or unfit; the text gives the reason.
struct Unfit : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct RecordRefused : Unfit {
    using Unfit::Unfit;
};

// The records of a component (hal/records.hpp), read and given back through its pins by a program beside it.
// The component answers once in each period of its thread; not at all while the threads stand.
class RecordWalk {
public:
    using Records = std::vector<Retained::Record>;

    // Throws Unfit if it is no component with records, or if its walk is linked.
    RecordWalk(std::string component, const std::map<std::string, hal::ListedPin>& pins)
        : component_(std::move(component)) {
        const std::string stem = component_ + ".row-";
        for (auto pin = pins.lower_bound(stem); pin != pins.end() && pin->first.rfind(stem, 0) == 0; ++pin)
            if (pin->first != stem + "shown") fields_.push_back(pin->first.substr(stem.size()));
        if (fields_.empty()) throw Unfit("there are no records: there is no pin " + stem + "...");
        find();
        for (const char* const name : {"row", "row-shown", "rows", "restores", "restores-refused"})
            demand_type(name, "s32");
        for (const char* const name : {"forget", "restore", "kept"}) demand_type(name, "bit");
        for (const auto& [name, pin] : pins_)
            if (name != "restores" && name != "rows" && name.rfind("row-", 0) != 0 && pin.linked())
                throw Unfit(full(name) + " is linked, and plumb-retain has to write it");
    }

    // Throws Unfit if these are no records of this component. An older version may lack a quantity: it is
    // given as 0, which has to mean that it is not known.
    void check(const Records& records) const {
        for (const Retained::Record& record : records) {
            for (const std::string& field : fields_)
                if (!record.count(field) && pins_.at("restore-" + field).type() != hal::AnyValue::Type::real)
                    throw Unfit("the records of " + component_ + " are kept without " + field);
            for (const auto& [field, value] : record) {
                const auto pin = pins_.find("restore-" + field);
                if (pin == pins_.end())
                    throw Unfit(component_ + " has no field " + field + ", which is kept");
                if (!pin->second.takes(value))
                    throw Unfit(full(pin->first) + ", " + pin->second.type_name() + ", cannot be " +
                                retained_file::value_text(value));
            }
        }
    }

    // Whether the component works now.
    bool answers() {
        find();
        return seen();
    }

    // Replaces the records of the component. False if it does not answer. Throws RecordRefused if it has
    // refused one; it has no records then.
    bool give(const Records& records) {
        find();
        if (!forget()) return false;
        for (const Retained::Record& record : records) {
            for (const std::string& field : fields_) {
                const auto its = record.find(field);
                write("restore-" + field, its == record.end() ? hal::Value(0.0) : its->second);
            }
            std::atomic_thread_fence(std::memory_order_release);
            const auto answers = [this] { return std::pair(whole("restores"), whole("restores-refused")); };
            const auto before = answers();
            write("restore", true);
            const bool answered = await([&] { return answers() != before; });
            std::atomic_thread_fence(std::memory_order_acquire);  // before the next record
            write("restore", false);
            if (!answered) return false;
            if (answers().second != before.second) {
                forget();
                throw RecordRefused(component_ + " refuses the record { " +
                                    retained_file::fields_text(record) + " }");
            }
            if (!seen()) return false;
        }
        return true;
    }

    // Leaves the component without records; if it does not answer, as soon as it works again.
    void withdraw() {
        find();
        forget();
    }

    // From now on read() detects that the component was loaded again.
    void mark() {
        find();
        write("kept", true);
    }

    // All records at one moment; nothing if the component does not answer, or changes them meanwhile.
    // Throws Unfit if the component was loaded again. Neither `rows` nor `row` shows that: others may
    // forget and walk.
    std::optional<Records> read() {
        find();
        if (!std::get<bool>(pins_.at("kept").read())) throw Unfit(component_ + " was loaded again");
        const auto places = pins_;
        const std::optional<Records> once = pass();
        const std::optional<Records> again = once ? pass() : std::nullopt;
        write("row", none);
        if (!again || text(*once) != text(*again)) return std::nullopt;
        find();
        for (const auto& [name, pin] : pins_)
            if (!pin.same_place(places.at(name))) return std::nullopt;
        return again;
    }

private:
    static constexpr std::int64_t none = -1;  // row at rest; a component begins with 0
    static constexpr std::chrono::milliseconds patience{300};
    static constexpr std::chrono::milliseconds pause{1};

    std::string full(const std::string& name) const { return component_ + '.' + name; }

    void find() {
        const auto find_one = [this](const std::string& name) {
            const auto pin = hal::NamedPin::find(full(name));
            if (!pin) throw Unfit("there is no pin " + full(name));
            pins_.insert_or_assign(name, *pin);
        };
        for (const char* const name :
             {"row", "row-shown", "rows", "restores", "restores-refused", "forget", "restore", "kept"})
            find_one(name);
        for (const std::string& field : fields_) {
            find_one("row-" + field);
            find_one("restore-" + field);
        }
    }

    void demand_type(const std::string& name, const std::string& type) const {
        if (pins_.at(name).type_name() != type) throw Unfit(full(name) + " is no " + type);
    }

    std::int64_t whole(const std::string& name) const {
        return std::get<std::int64_t>(pins_.at(name).read());
    }
    void write(const std::string& name, const hal::Value& value) const { pins_.at(name).write(value); }

    template <class Condition>
    static bool await(const Condition& condition) {
        const auto end = std::chrono::steady_clock::now() + patience;
        while (!condition()) {
            if (std::chrono::steady_clock::now() > end) return false;
            std::this_thread::sleep_for(pause);
        }
        return true;
    }

    bool show(std::int64_t row) const {
        std::atomic_thread_fence(std::memory_order_release);  // the row before has been read
        write("row", row);
        const bool shown = await([&] { return whole("row-shown") == row; });
        std::atomic_thread_fence(std::memory_order_acquire);  // before the row-... pins
        return shown;
    }

    // Leaves the component without records. False if it does not answer; it forgets them when it works
    // again.
    bool forget() const {
        write("restore", false);
        write("forget", false);
        const bool sees = seen();
        write("forget", true);
        if (!sees || !await([&] { return whole("rows") == 0; })) return false;
        write("forget", false);
        return true;
    }

    // Whether the component has read all earlier writes, in a period that began after this call. The first
    // answer may come from a period that had begun before; the second one does not. Without records there
    // is one answer only, which stays from its first period on.
    bool seen() const {
        if (whole("rows") > 0) return show(0) && show(none);
        const bool answered = show(none);
        std::this_thread::sleep_for(pause);
        return answered;
    }

    std::optional<Records> pass() const {
        Records records;
        const std::int64_t rows = whole("rows");
        for (std::int64_t row = 0; row < rows; ++row) {
            if (!show(row)) return std::nullopt;
            Retained::Record& record = records.emplace_back();
            for (const std::string& field : fields_) record[field] = pins_.at("row-" + field).read();
        }
        return whole("rows") == rows ? std::optional(records) : std::nullopt;
    }

    static std::string text(const Records& records) {
        return retained_file::compose({{}, {{"", records}}, {}}, "");
    }

    const std::string component_;
    std::vector<std::string> fields_;
    std::map<std::string, hal::NamedPin> pins_;  // by their names without the component's name
};

}  // namespace plumb
