// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/names.hpp"

#include <dlfcn.h>

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

}  // namespace

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
    const HalLibrary& library = HalLibrary::get();
    hal_type_t type = HAL_TYPE_UNSPECIFIED;
    hal_data_u* data = nullptr;
    bool linked = false;
    if (library.pin(name.c_str(), &type, &data, &linked) == 0)
        return Cell{Cell::Kind::pin, hal::AnyValue(type, data), linked};
    if (library.parameter(name.c_str(), &type, &data) == 0)
        return Cell{Cell::Kind::parameter, hal::AnyValue(type, data), false};
    if (library.signal(name.c_str(), &type, &data, &linked) == 0)
        return Cell{Cell::Kind::signal, hal::AnyValue(type, data), linked};
    return std::nullopt;
}

Cell Names::need(const std::string& name) const {
    if (const std::optional<Cell> cell = find(name)) return *cell;
    throw std::runtime_error("there is no pin, parameter or signal '" + name + "'");
}

}  // namespace plumb::host
