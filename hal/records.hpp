// SPDX-License-Identifier: GPL-2.0-or-later
// Many records, few pins: a program reads a component's records one by one through `row`, and gives them back
// one by one through `restore`.
//
//     struct ContactRow final : hal::RecordRow<Contact> {
//         using RecordRow::RecordRow;
//         Field<std::int32_t> tool{this, record.tool, "tool", "", "Tool that made the contact."};
//     };
//
//     hal::Records records{this};
//     ContactRow row{this};
//
// declares row, row-shown, rows, restore, forget, restores, restores-refused, kept, row-tool and
// restore-tool.
//
// The program runs on another core, to which an ARM processor shows pins in any order: fences keep a record
// together with the pin that announces it.
#pragma once

#include "hal/component.hpp"

#include <atomic>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>

namespace plumb::hal {

// The pins of a record. Each field is declared once, with the place of its value in `record`.
template <class Record>
class RecordRow : public Group {
public:
    using Group::Group;

    void show(const Record& shown) noexcept {
        record = shown;
        each([](auto& field) { field.row_ = field.value_; });
    }

    // The record in the restore-... pins.
    Record given() noexcept {
        record = Record{};
        each([](auto& field) { field.value_ = field.restore_; });
        return record;
    }

protected:
    // Shown as row-NAME, and given back as restore-NAME.
    template <class T>
    class Field {
    public:
        Field(RecordRow* its, T& value, const std::string& name, const std::string& unit,
              const std::string& doc)
            : value_(value),
              next_(std::exchange(std::get<Field*>(its->last_), this)),
              row_{its, "row-" + name, unit, doc},
              restore_{its, "restore-" + name, T{}, unit, doc} {}

    private:
        friend RecordRow;

        T& value_;
        Field* const next_;
        Out<T> row_;
        In<T> restore_;
    };

    Record record{};

private:
    template <class Do>
    void each(const Do& act) noexcept {
        std::apply([&](auto*... last) { (act_on(last, act), ...); }, last_);
    }
    template <class T, class Do>
    static void act_on(Field<T>* field, const Do& act) noexcept {
        for (; field; field = field->next_) act(*field);
    }

    std::tuple<Field<bool>*, Field<std::int32_t>*, Field<double>*> last_{};  // declared of each type
};

// The walk itself. The component keeps the records; each period it calls, in this order, wants_forget(),
// wants_restore() with restored() for the answer, and show(): once the records have changed or asks() is
// true.
class Records final : public Group {
public:
    using Group::Group;

    bool wants_forget() noexcept { return rose(forget_, forgetting_); }
    bool wants_restore() noexcept {
        const bool wants = rose(restore_, restoring_);
        if (wants) std::atomic_thread_fence(std::memory_order_acquire);  // before the restore-... pins
        return wants;
    }

    // The answer to wants_restore().
    void restored(bool accepted) noexcept {
        std::atomic_thread_fence(std::memory_order_release);  // the restore-... pins have been read
        if (accepted)
            restores_ = ++accepted_count_;
        else
            refused_ = ++refused_count_;
    }

    bool asks() noexcept { return row_ != wanted_; }  // for another record than in the last show()

    // Publishes the number of records and, through write(index), the record that `row` asks for.
    template <class Write>
    void show(std::int32_t count, const Write& write) noexcept {
        wanted_ = row_;
        const std::int32_t shown = wanted_ >= 0 && wanted_ < count ? wanted_ : -1;
        if (shown >= 0) write(shown);
        rows_ = count;
        std::atomic_thread_fence(std::memory_order_release);
        shown_ = shown;  // last: a reader that waits for it finds the record complete
    }

private:
    static bool rose(bool now, bool& before) noexcept {
        const bool edge = now && !before;
        before = now;
        return edge;
    }

    In<std::int32_t> row_{this, "row", 0, "Record to show in the row-... pins, counted from 0."};
    Out<std::int32_t> shown_{this, "row-shown", "Record that the row-... pins show; -1 for none."};
    Out<std::int32_t> rows_{this, "rows", "Number of records."};
    In<bool> forget_{this, "forget", false, "A rising edge forgets all records."};
    In<bool> restore_{this, "restore", false, "A rising edge adds the record in the restore-... pins."};
    Out<std::int32_t> restores_{this, "restores", "Number of records accepted by restore."};
    Out<std::int32_t> refused_{this, "restores-refused", "Number of records refused by restore."};
    // For plumb-retain, which set it: false again, the component was loaded again.
    In<bool> kept_{this, "kept", false, "For plumb-retain, which keeps the records; leave it unset."};
    std::int32_t wanted_ = -1;
    bool forgetting_ = false;
    bool restoring_ = false;
    std::int32_t accepted_count_ = 0;
    std::int32_t refused_count_ = 0;
};

}  // namespace plumb::hal
