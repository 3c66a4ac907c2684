// SPDX-License-Identifier: GPL-2.0-or-later
// The pins of a status: status-code and attention, of a function (hal::Status) or of a stage
// (hal::ComponentStatus).
#pragma once

#include "hal/permission.hpp"
#include "hal/pin.hpp"
#include "hal/status.hpp"

#include <cstdint>
#include <map>
#include <string>

namespace plumb::hal {

struct StatusInfo {
    std::string pin;  // without the instance's name
    std::map<std::int32_t, Said> statuses;
};

// Declares status-code and attention: of a stage, which interlock does not permit.
template <class E>
class ComponentStatus {
public:
    explicit ComponentStatus(Owner owner)
        : code_{owner, "status-code", "Number of what the component does now."},
          attention_{owner, "attention", "Somebody must act; status-code gives the reason."} {
        StatusInfo info{code_.name(), {}};
        CodesInfo codes{code_.name(), {}};
        for (std::int32_t number = 1; number <= largest; ++number) {
            const Said its = said(static_cast<E>(number));
            if (!its.sentence) continue;
            info.statuses[number] = its;
            codes.sentences[number] = its.sentence;
        }
        owner.registrar().add(info);
        owner.registrar().add(codes);
    }

    ComponentStatus& operator=(E value) noexcept {
        const Kind kind = said(value).kind;
        code_ = static_cast<std::int32_t>(value);
        attention_ = kind == Kind::warn || kind == Kind::bad;
        return *this;
    }

private:
    static constexpr std::int32_t largest = 99;

    Out<std::int32_t> code_;
    Out<bool> attention_;
};

// Of a function, which interlock permits.
template <class E>
class Status {
public:
    Status(Owner owner, const Permission& permission) : permission_(permission), own_{owner} {}

    // Why interlock hinders it: none where it hinders nothing, or there is no interlock.
    E of_interlock() const noexcept {
        const auto reason = static_cast<std::int32_t>(permission_.reason());
        return is_common(reason) ? static_cast<E>(reason) : E{};
    }

    Status& operator=(E value) noexcept {
        own_ = value;
        return *this;
    }

private:
    const Permission& permission_;
    ComponentStatus<E> own_;
};

}  // namespace plumb::hal
