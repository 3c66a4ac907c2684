// SPDX-License-Identifier: GPL-2.0-or-later
// The pins and parameters of HAL with their signals and values, as a realtime module sees them. LinuxCNC 2.10
// has calls that list them, but not for realtime modules: so their layouts stand here, as in thread_list.hpp.
#pragma once

#include "hal/any_value.hpp"
#include "hal/thread_list.hpp"

#include <optional>
#include <string>
#include <vector>

namespace plumb::hal {

struct WiredPin {
    std::string name, signal;  // "": none
    bool writes = false;       // an output
    bool is_real = false;
    double value = 0;
};

struct WiredParameter {
    std::string name;
    double value = 0;
};

struct WiringList {
    std::vector<WiredPin> pins;
    std::vector<WiredParameter> parameters;
};

namespace layout {

#ifdef PLUMB_LINUXCNC_2_10
struct Pin {
    Offset next, cell, owner, former_name;
    hal_data_u own;
    Offset signal;
    hal_type_t type;
    hal_pin_dir_t direction;
    Name name;
};

struct Parameter {
    Offset next, data, owner, former_name;
    hal_data_u own;
    Offset reserved;
    hal_type_t type;
    hal_param_dir_t direction;
    Name name;
};
#else
struct Pin {
    Offset next, cell, owner, signal;
    hal_data_u own;
    Offset former_name;
    hal_type_t type;
    hal_pin_dir_t direction;
    Name name;
};

struct Parameter {
    Offset next, data, owner, former_name;
    hal_type_t type;
    hal_param_dir_t direction;
    Name name;
};
#endif

struct Signal {
    Offset next, data;
    hal_type_t type;
    int readers, writers, both;
    Name name;
};

// Of a cell in HAL's memory; 0 outside it.
inline double value_at(hal_type_t type, Offset data) {
    const auto* const cell = at<hal_data_u>(data);
    return cell ? AnyValue(type, const_cast<hal_data_u*>(cell)).number() : 0;
}

inline WiringList read_wiring(const Head& head) {
    WiringList result;
    int left = most;
    for (auto one = at<Pin>(head.pins); one && left-- > 0; one = at<Pin>(one->next)) {
        const Signal* const signal = one->signal ? at<Signal>(one->signal) : nullptr;
        WiredPin pin;
        pin.name = text(one->name);
        if (signal) pin.signal = text(signal->name);
        pin.writes = one->direction == HAL_OUT;
        pin.is_real = one->type == HAL_FLOAT;
        pin.value = signal ? value_at(signal->type, signal->data)
                           : AnyValue(one->type, const_cast<hal_data_u*>(&one->own)).number();
        result.pins.push_back(std::move(pin));
    }
    for (auto one = at<Parameter>(head.parameters); one && left-- > 0; one = at<Parameter>(one->next))
        result.parameters.push_back({text(one->name), value_at(one->type, one->data)});
    return result;
}

}  // namespace layout

inline std::optional<WiringList> list_wiring() {
    return list_of_hal(layout::read_wiring);
}

}  // namespace plumb::hal
