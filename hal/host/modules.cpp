// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/modules.hpp"

#include <dlfcn.h>
#include <hal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <regex>

#include "drivers.hpp"
#include "hal/host/functions.hpp"
#include "hal/host/rtapi.hpp"
#include "hal/host/watchdog.hpp"

namespace plumb::host {

namespace {

const std::string hal_library = "hal_lib";

using Texts = std::list<std::string>;

// Constructors of components that can be instantiated, by component number.
std::map<int, constructor>& constructors() {
    static std::map<int, constructor> the_constructors;
    return the_constructors;
}

template <typename Function>
Function symbol(void* handle, const std::string& name) {
    return reinterpret_cast<Function>(dlsym(handle, name.c_str()));
}

// Writes one value into element `index` of a module's parameter.
bool set_element(char type, const std::string& parameter, const std::string& text, void* storage,
                 std::size_t index, Texts& texts) {
    if (type == 's') {
        static_cast<char**>(storage)[index] = texts.emplace_back(text).data();
        return true;
    }
    if (type != 'i' && type != 'l') {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: Invalid type character `%c'\n", parameter.c_str(), type);
        return false;
    }
    char* end = nullptr;
    const long number = std::strtol(text.c_str(), &end, 0);
    if (*end != '\0') {
        rtapi_print_msg(RTAPI_MSG_ERR, "`%s' invalid for parameter `%s'", text.c_str(), parameter.c_str());
        return false;
    }
    if (type == 'l')
        static_cast<long*>(storage)[index] = number;
    else
        static_cast<int*>(storage)[index] = static_cast<int>(number);
    return true;
}

// Sets a module's parameter from NAME=VALUE. The module describes it by three symbols: its address, its type
// (i, l or s), and for an array its size.
bool set_parameter(void* handle, std::string text, Texts& texts) {
    text.erase(std::remove(text.begin(), text.end(), '"'), text.end());
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
        rtapi_print_msg(RTAPI_MSG_ERR, "Invalid paramter `%s'\n", text.c_str());
        return false;
    }
    const std::string name = text.substr(0, equals);
    const std::string value = text.substr(equals + 1);
    auto* const address = symbol<void**>(handle, "rtapi_info_address_" + name);
    if (address == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "Unknown parameter `%s'\n", text.c_str());
        return false;
    }
    auto* const type = symbol<const char**>(handle, "rtapi_info_type_" + name);
    if (type == nullptr || *type == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "Unknown parameter `%s' (type information missing)\n", text.c_str());
        return false;
    }
    auto* const size = symbol<const int*>(handle, "rtapi_info_size_" + name);
    if (size == nullptr) return set_element(**type, text, value, *address, 0, texts);

    std::size_t index = 0;
    for (std::size_t begin = 0; begin != std::string::npos; ++index) {
        if (index == static_cast<std::size_t>(*size)) {
            rtapi_print_msg(RTAPI_MSG_ERR, "%s: can only take %d arguments\n", text.c_str(), *size);
            return false;
        }
        const std::size_t comma = value.find(',', begin);
        if (!set_element(**type, text, value.substr(begin, comma - begin), *address, index, texts))
            return false;
        begin = comma == std::string::npos ? comma : comma + 1;
    }
    return true;
}

}  // namespace

Modules::Modules(std::vector<std::string> folders, std::vector<std::string> options,
                 const std::string& models)
    : folders_(std::move(folders)), options_(std::move(options)), models_(models) {
    if (!models_.module_folder().empty()) folders_.insert(folders_.begin(), models_.module_folder());
}

Modules::~Modules() {
    unload_all();
}

void Modules::unload_all() {
    while (!modules_.empty()) {
        Module last = std::move(modules_.back());
        modules_.pop_back();
        unload(std::move(last));
    }
}

Modules::Module* Modules::find(const std::string& name) {
    const auto found = std::find_if(modules_.begin(), modules_.end(),
                                    [&](const Module& module) { return module.name == name; });
    return found == modules_.end() ? nullptr : &*found;
}

std::string Modules::file_of(const std::string& name) const {
    for (const std::string& folder : folders_) {
        std::string file = folder + "/" + name + ".so";
        if (access(file.c_str(), F_OK) == 0) return file;
    }
    return folders_.back() + "/" + name + ".so";
}

bool Modules::need_hal_library() {
    return find(hal_library) != nullptr || load_file(hal_library, {}) == 0;
}

int Modules::load(const std::string& name, const std::vector<std::string>& parameters) {
    if (name.find('/') != std::string::npos || name.find("..") != std::string::npos) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: Not allowed as module name\n", name.c_str());
        return -1;
    }
    if (!need_hal_library()) return -1;
    const int result = load_file(name, with_options(name, parameters));
    end_without_modules();
    return result;
}

std::vector<std::string> Modules::with_options(const std::string& name,
                                               std::vector<std::string> parameters) const {
    for (const std::string& option : options_) {
        if (option.compare(0, name.size() + 1, name + ".") != 0) continue;
        const std::string given = option.substr(name.size() + 1);
        const std::string its_name = given.substr(0, given.find('=') + 1);
        const auto replaced = [&](const std::string& other) {
            return other.compare(0, its_name.size(), its_name) == 0;
        };
        parameters.erase(std::remove_if(parameters.begin(), parameters.end(), replaced), parameters.end());
        parameters.push_back(given);
    }
    return parameters;
}

int Modules::load_file(const std::string& name, const std::vector<std::string>& parameters) {
    if (find(name) != nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: already exists\n", name.c_str());
        return -1;
    }
    ++changes_;
    if (models_.has(name)) {
        const int result = models_.load(name);
        if (result == 0) modules_.push_back({name, nullptr, {}});
        return result;
    }
    void* const handle = dlopen(file_of(name).c_str(), RTLD_GLOBAL | RTLD_NOW);
    if (handle == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: dlopen: %s\n", name.c_str(), dlerror());
        name_models(name);
        return -1;
    }
    auto* const main = symbol<int (*)()>(handle, "rtapi_app_main");
    if (main == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: dlsym: %s\n", name.c_str(), dlerror());
        dlclose(handle);
        return -1;
    }
    if (name == hal_library) find_hal_code(reinterpret_cast<const void*>(main));
    Texts texts;
    for (const std::string& parameter : parameters) {
        if (!set_parameter(handle, parameter, texts)) {
            dlclose(handle);
            return -1;
        }
    }
    const int result = [&] {
        const Watchdog watchdog(name);
        return main();
    }();
    if (result < 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: rtapi_app_main: %s (%d)\n", name.c_str(), std::strerror(-result),
                        result);
        name_models(name);
        dlclose(handle);
        return result;
    }
    modules_.push_back({name, handle, std::move(texts)});
    return 0;
}

void Modules::name_models(const std::string& name) const {
    if (models_.given() || !std::regex_match(name, std::regex(drivers))) return;
    rtapi_print_msg(RTAPI_MSG_ERR,
                    "%s: run without this hardware: plumb run --models, plumb bench --models\n",
                    name.c_str());
}

int Modules::unload(const std::string& name) {
    Module* const module = find(name);
    if (module == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: not loaded\n", name.c_str());
        return -1;
    }
    Module unloaded = std::move(*module);
    modules_.erase(modules_.begin() + (module - modules_.data()));
    unload(std::move(unloaded));
    end_without_modules();
    return 0;
}

// The stock rtapi_app ends here, and so do HAL's threads and the rest of a module that failed.
void Modules::end_without_modules() {
    if (modules_.size() == 1) unload_all();
}

void Modules::unload(Module module) {
    ++changes_;
    if (module.handle == nullptr) return models_.unload(module.name);
    if (auto* const exit = symbol<void (*)()>(module.handle, "rtapi_app_exit")) exit();
    dlclose(module.handle);
    if (module.name != hal_library) return;
    constructors().clear();
    reset_rtapi();
}

int Modules::new_instance(const std::string& component, const std::string& name,
                          const std::string& argument) {
    Module* const library = find(hal_library);
    auto* const component_name =
        library == nullptr ? nullptr : symbol<char* (*)(int)>(library->handle, "hal_comp_name");
    if (component_name == nullptr) {
        rtapi_print_msg(RTAPI_MSG_ERR, "newinst: hal_lib is required, but not loaded\n");
        return -1;
    }
    for (const auto& [number, construct] : constructors()) {
        const char* const found = component_name(number);
        if (found == nullptr || component != found) continue;
        ++changes_;
        return construct(const_cast<char*>(name.c_str()), const_cast<char*>(argument.c_str()));
    }
    rtapi_print_msg(RTAPI_MSG_ERR, "newinst: component %s not found\n", component.c_str());
    return -1;
}

}  // namespace plumb::host

// Stands before hal_lib's function of the same name, and calls it: hal_lib keeps constructors where only
// code that knows its private layout could find them again.
extern "C" int hal_set_constructor(int component, constructor construct) {
    auto* const next =
        reinterpret_cast<decltype(&hal_set_constructor)>(dlsym(RTLD_NEXT, "hal_set_constructor"));
    const int result = next == nullptr ? -EINVAL : next(component, construct);
    if (result == 0) plumb::host::constructors()[component] = construct;
    return result;
}
