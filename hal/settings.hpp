// SPDX-License-Identifier: GPL-2.0-or-later
// Settings are members of one struct. Each is declared once, and its line is its pin, too:
//
//     struct StrokeSettings : hal::Settings {
//         using Settings::Settings;
//         double feed = pin(feed, "feed", 0, "mu/s", "Speed of the stroke.", hal::must({0, 1e6}));
//         bool learn = pin(learn, "learn", false, "Correct the dead points.", hal::machine());
//     };
//     StrokeSettings settings{this};
//
// A copy has the values and no pins: it keeps the last good set as a whole. Without an owner there are no
// pins, and each member has its default.
#pragma once

#include "hal/pin.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace plumb::hal {

class Settings {
public:
    Settings() = default;
    explicit Settings(Owner owner) : pins_(std::make_unique<Pins>(Pins{owner, {}})) {}
    Settings(const Settings& other) noexcept : in_range(other.in_range) {}
    Settings& operator=(const Settings& other) noexcept {
        in_range = other.in_range;
        return *this;
    }

    // Reads each pin once. True if a member has changed, and always while one is not a number.
    bool read() noexcept {
        if (!pins_) return false;
        const auto read = [](auto&... its) { return (int{its.read()} | ...) != 0; };
        const auto good = [](const auto&... its) { return (its.good() && ...); };
        const bool changed = std::apply(read, pins_->all);
        if (changed) in_range = std::apply(good, pins_->all);
        return changed;
    }

    // The pin of a member, for hal::Offset and hal::Effects.
    template <class T>
    const Pin<T>& pin_of(const T& member) const {
        return std::get<Members<T>>(pins_->all).pin_of(member);
    }

    bool in_range = true;  // each member that is judged by its range

protected:
    // Declares the pin of a member, and gives its default. `rest` is as of hal::In.
    template <class T, class... Rest>
    T pin(T& member, const std::string& name, const Rest&... rest) {
        return declare<T>(member, true, name, rest...);
    }
    // The same for one that is judged where it is used.
    template <class T, class... Rest>
    T unjudged(T& member, const std::string& name, const Rest&... rest) {
        return declare<T>(member, false, name, rest...);
    }

private:
    // The pins of all members of a type, and beside each other what read() needs.
    template <class T>
    class Members {
    public:
        template <class... Rest>
        T add(T& member, bool judged, Owner owner, const Rest&... rest) {
            const Input& its = pins_.emplace_back(owner, rest...);
            places_.push_back({its.slot_, &member});
            if (judged) judged_.push_back({&member, its.range});
            return its.slot_.template read<T>();
        }

        bool read() noexcept {
            bool same = true;
            for (const Place& each : places_) {
                const T now = each.slot.template read<T>();
                same &= now == *each.member;
                *each.member = now;
            }
            return !same;
        }
        bool good() const noexcept {
            return std::all_of(judged_.begin(), judged_.end(), [](const Judged& each) {
                return each.range.contains(static_cast<double>(*each.member));
            });
        }

        const Pin<T>& pin_of(const T& member) const {
            for (std::size_t i = 0; i < places_.size(); ++i)
                if (places_[i].member == &member) return pins_[i];
            throw std::logic_error("this member has no pin");
        }

    private:
        struct Input final : Pin<T> {
            Input(Owner owner, const std::string& name, T initial, const std::string& unit,
                  const std::string& doc, const Setting& setting = {})
                : Pin<T>(owner, false, name, initial, unit, doc, setting), range(setting.range) {}
            Input(Owner owner, const std::string& name, T initial, const std::string& doc,
                  const Setting& setting = {})
                : Input(owner, name, initial, "", doc, setting) {}

            using Pin<T>::slot_;
            const Range range;
        };
        struct Place {
            Slot slot;
            T* member;
        };
        struct Judged {
            const T* member;
            Range range;
        };

        std::deque<Input> pins_;
        std::vector<Place> places_;  // of all pins, side by side for read()
        std::vector<Judged> judged_;
    };
    struct Pins {
        const Owner owner;  // valid while the component is built
        std::tuple<Members<bool>, Members<std::int32_t>, Members<double>> all;
    };

    template <class T, class... Rest>
    T declare(T& member, bool judged, const std::string& name, T initial, const Rest&... rest) {
        if (!pins_) return initial;
        return std::get<Members<T>>(pins_->all).add(member, judged, pins_->owner, name, initial, rest...);
    }

    std::unique_ptr<Pins> pins_;
};

}  // namespace plumb::hal
