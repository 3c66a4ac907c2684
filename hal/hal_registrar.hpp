// SPDX-License-Identifier: GPL-2.0-or-later
// A declaration creates a pin or a function in HAL; an option reads its text from the load line.
#pragma once

#include "hal/component.hpp"

#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace plumb::hal {

// The result of a HAL call, or an exception that names the request.
inline int check(int result, const std::string& what) {
    if (result < 0) throw std::system_error(-result, std::generic_category(), what);
    return result;
}

// Throws unless the name is fit for HAL: lower-case letters, digits, '-' and '.', no level empty.
inline void check_instance_name(const std::string& name) {
    const auto refuse = [&](const std::string& why) {
        throw std::invalid_argument("name '" + name + "' " + why);
    };
    if (name.empty()) refuse("is empty");
    for (const char c : name)
        if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.'))
            refuse(std::string("has a '") + c + "'; HAL names are of a-z, 0-9, '-' and '.'");
    if (name.front() == '.' || name.back() == '.' || name.find("..") != std::string::npos)
        refuse("has an empty level");
}

class HalRegistrar final : public Registrar {
public:
    // options: text by name for this instance; an option that is not in it keeps its initial value.
    HalRegistrar(int component, std::string instance, std::map<std::string, std::string> options)
        : component_(component), instance_(std::move(instance)), options_(std::move(options)) {
        const auto unit = options_.find(length_option);
        if (unit != options_.end()) millimetres_ = millimetres_of_option(unit->second);
    }

    Slot add(const PinInfo& pin) override {
        const std::string name = full(pin.name);
        int result = 0;
        const Slot slot = new_pin(component_, name, pin.type, pin.output, result);
        check(result, "pin " + name);
        return slot;
    }

#ifdef RTAPI
    void add(Function& function) override {
        const auto call = [](void* self, long period_ns) {
            (*static_cast<Function*>(self))(static_cast<double>(period_ns) * 1e-9);
        };
        const std::string name = full(function.name);
        check(hal_export_funct(name.c_str(), call, &function, /*uses_fp=*/1, /*reentrant=*/0, component_),
              "function " + name);
        functions_.push_back(&function);
    }
    const std::vector<const Function*>& functions() const noexcept {
        return functions_;
    }
#else  // a user-space program calls its functions itself
    void add(Function& function) override {
        functions_.push_back(&function);
    }
    void call_functions(double dt) const noexcept {
        for (const Function* function : functions_) (*function)(dt);
    }
#endif

    void add(const TurningInfo& info) override {
        turning_.push_back(info.pin);
    }
    const std::vector<std::string>& turning() const noexcept {
        return turning_;
    }

    std::string instance() const override {
        return instance_;
    }

    std::string add(const OptionInfo& option) override {
        const auto given = options_.find(option.name);
        return given == options_.end() ? option.initial : given->second;
    }

    double millimetres() const noexcept override {
        return millimetres_;
    }

private:
    std::string full(const std::string& name) const {
        const std::string result = instance_ + "." + name;
        if (result.size() > HAL_NAME_LEN)
            throw std::invalid_argument("name '" + instance_ + "' is too long: " + result + " has " +
                                        std::to_string(result.size()) + " characters of " +
                                        std::to_string(HAL_NAME_LEN));
        return result;
    }

    int component_;
    std::string instance_;
    std::map<std::string, std::string> options_;
    double millimetres_ = 1;
    std::vector<const Function*> functions_;
    std::vector<std::string> turning_;
};

}  // namespace plumb::hal
