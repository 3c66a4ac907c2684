// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/names.hpp"

#include <dlfcn.h>
#include <hal.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace plumb::host {

namespace {

// The user-space HAL library. It is loaded with local symbols, and finds the host's rtapi functions before
// its own: it so works on the memory that the host has attached.
class HalLibrary {
public:
    static const HalLibrary& get() {
        static const HalLibrary the_library;
        return the_library;
    }

    int (*init)(const char*);
    int (*exit)(int);
    int (*pin)(const char*, hal_type_t*, hal_data_u**, bool*);
    int (*signal)(const char*, hal_type_t*, hal_data_u**, bool*);
    int (*parameter)(const char*, hal_type_t*, hal_data_u**);

private:
    HalLibrary() {
        void* const handle = dlopen("liblinuxcnchal.so.0", RTLD_LOCAL | RTLD_NOW);
        if (handle == nullptr) throw std::runtime_error(dlerror());
        load(handle, "hal_init", init);
        load(handle, "hal_exit", exit);
        load(handle, "hal_get_pin_value_by_name", pin);
        load(handle, "hal_get_signal_value_by_name", signal);
        load(handle, "hal_get_param_value_by_name", parameter);
    }

    template <typename Function>
    static void load(void* handle, const char* name, Function& function) {
        function = reinterpret_cast<Function>(dlsym(handle, name));
        if (function == nullptr) throw std::runtime_error(dlerror());
    }
};

Cell::Type type_of(hal_type_t type) {
    switch (type) {
        case HAL_BIT: return Cell::Type::bit;
        case HAL_FLOAT: return Cell::Type::floating;
        case HAL_S32: return Cell::Type::s32;
        case HAL_U32: return Cell::Type::u32;
        default: return Cell::Type::port;
    }
}

}  // namespace

double Cell::read() const {
    switch (type) {
        case Type::bit: return *static_cast<hal_bit_t*>(data) ? 1.0 : 0.0;
        case Type::floating: return *static_cast<hal_float_t*>(data);
        case Type::s32: return *static_cast<hal_s32_t*>(data);
        case Type::u32: return *static_cast<hal_u32_t*>(data);
        case Type::port: break;
    }
    return *static_cast<hal_port_t*>(data);
}

void Cell::write(double value) const {
    switch (type) {
        case Type::bit: *static_cast<hal_bit_t*>(data) = value != 0.0; break;
        case Type::floating: *static_cast<hal_float_t*>(data) = value; break;
        case Type::s32: *static_cast<hal_s32_t*>(data) = static_cast<rtapi_s32>(value); break;
        case Type::u32: *static_cast<hal_u32_t*>(data) = static_cast<rtapi_u32>(value); break;
        case Type::port: break;
    }
}

bool Cell::accepts(double value) const {
    switch (type) {
        case Type::bit: return value == 0.0 || value == 1.0;
        case Type::floating: return true;
        case Type::s32:
            return std::trunc(value) == value && value >= std::numeric_limits<rtapi_s32>::min() &&
                   value <= std::numeric_limits<rtapi_s32>::max();
        case Type::u32:
            return std::trunc(value) == value && value >= 0.0 &&
                   value <= std::numeric_limits<rtapi_u32>::max();
        case Type::port: break;
    }
    return false;
}

const char* Cell::type_name() const {
    switch (type) {
        case Type::bit: return "bit";
        case Type::floating: return "float";
        case Type::s32: return "s32";
        case Type::u32: return "u32";
        case Type::port: break;
    }
    return "port";
}

Names::Names() : component_(HalLibrary::get().init("plumb-host")) {
    if (component_ < 0) throw std::runtime_error("HAL refuses to let the host look names up");
}

Names::~Names() {
    // The library and hal_lib share the variable that holds the address of HAL's memory, and the last
    // component to leave the library clears it.
    auto* const memory = static_cast<void**>(dlsym(RTLD_DEFAULT, "hal_shmem_base"));
    void* const kept = memory == nullptr ? nullptr : *memory;
    HalLibrary::get().exit(component_);
    if (memory != nullptr) *memory = kept;
}

std::optional<Cell> Names::find(const std::string& name) const {
    const HalLibrary& hal = HalLibrary::get();
    hal_type_t type = HAL_TYPE_UNSPECIFIED;
    hal_data_u* data = nullptr;
    bool linked = false;
    if (hal.pin(name.c_str(), &type, &data, &linked) == 0)
        return Cell{Cell::Kind::pin, type_of(type), data, linked};
    if (hal.parameter(name.c_str(), &type, &data) == 0)
        return Cell{Cell::Kind::parameter, type_of(type), data, false};
    if (hal.signal(name.c_str(), &type, &data, &linked) == 0)
        return Cell{Cell::Kind::signal, type_of(type), data, linked};
    return std::nullopt;
}

Cell Names::need(const std::string& name) const {
    if (const std::optional<Cell> cell = find(name)) return *cell;
    throw std::runtime_error("there is no pin, parameter or signal '" + name + "'");
}

}  // namespace plumb::host
