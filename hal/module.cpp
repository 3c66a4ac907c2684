// SPDX-License-Identifier: GPL-2.0-or-later
// Linked into every realtime component: turns its Model into a module for `loadrt`.
//
//     loadrt <component> [count=N | names=a,b,...] [OPTION=value,value,...]

#include "hal/background.hpp"
#include "hal/hal_registrar.hpp"
#include "hal/identity.hpp"
#include "hal/message.hpp"
#include "hal/module_options.hpp"

#include <rtapi.h>
#include <rtapi_app.h>
#include <rtapi_errno.h>

#include <climits>
#include <exception>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

static char* names = nullptr;
RTAPI_MP_STRING(names, "instance names, comma separated")
static int count = INT_MIN;  // no number that a user would give
RTAPI_MP_INT(count, "number of instances")
MODULE_LICENSE("GPL")

namespace plumb::hal {
namespace {

using Texts = std::vector<std::string>;

Texts split(const std::string& list) {
    Texts result(1);
    for (const char c : list)
        if (c == ',')
            result.emplace_back();
        else
            result.back() += c;
    return result;
}

// names=a,b gives {a, b}; otherwise <component>.0, <component>.1, ...
Texts instance_names() {
    if (names && count != INT_MIN) throw std::invalid_argument("count= and names= exclude each other");
    Texts result;
    if (names) {
        result = split(names);
        std::set<std::string> seen;
        for (const std::string& name : result) {
            check_instance_name(name);
            if (!seen.insert(name).second) throw std::invalid_argument("name '" + name + "' is given twice");
        }
    } else {
        if (count != INT_MIN && count < 1)
            throw std::invalid_argument("count=" + std::to_string(count) + " is below 1");
        std::string stem = model().about.name;
        for (char& c : stem)
            if (c == '_') c = '-';
        for (int i = 0; i < (count == INT_MIN ? 1 : count); ++i)
            result.push_back(stem + "." + std::to_string(i));
    }
    return result;
}

// The values of each option, one per instance.
std::map<std::string, Texts> option_values(std::size_t instances) {
    std::map<std::string, Texts> result;
    for (const ModuleOption* option = module_options; option->name; ++option) {
        const char* const list = *option->values;
        if (!list) continue;
        Texts values = split(list);
        if (values.size() != instances)
            throw std::invalid_argument(std::string(option->name) + "=" + list + " gives " +
                                        std::to_string(values.size()) + " values for " +
                                        std::to_string(instances) + " instances");
        result[option->name] = std::move(values);
    }
    return result;
}

int component_id = -1;
std::vector<std::unique_ptr<Component>> instances;
std::unique_ptr<Background> background;

void load() {
    const Texts instance = instance_names();
    const auto options = option_values(instance.size());
    component_id = check(hal_init(model().about.name), "hal_init");
    for (std::size_t i = 0; i < instance.size(); ++i) {
        std::map<std::string, std::string> own;
        for (const auto& [option, values] : options) own[option] = values[i];
        HalRegistrar registrar(component_id, instance[i], std::move(own));
        instances.push_back(model().make(registrar));
        instances.back()->prepare();
    }
    if (model().has_background) background = std::make_unique<Background>(instances);
    check(hal_ready(component_id), "hal_ready");
}

void unload() noexcept {
    if (component_id > 0) hal_exit(component_id);  // HAL stops calling our functions here
    component_id = -1;
    background.reset();
    instances.clear();
}

}  // namespace

void report_error(const char* text) noexcept {
    rtapi_print_msg(RTAPI_MSG_ERR, "%s: %s\n", model().about.name, text);
}

void report(const char* text) noexcept {
    rtapi_print("%s: %s\n", model().about.name, text);
}

}  // namespace plumb::hal

extern "C" int rtapi_app_main() {
    try {
        plumb::hal::load();
        return 0;
    } catch (const std::exception& error) {
        plumb::hal::report_error(error.what());
    } catch (...) {
        plumb::hal::report_error("unknown exception");
    }
    plumb::hal::unload();
    return -EINVAL;
}

extern "C" void rtapi_app_exit() {
    plumb::hal::unload();
}

// For our own tools: the manual and the conformance test.
extern "C" const plumb::hal::Model* plumb_model() {
    static const plumb::hal::Model instance = plumb::hal::model();
    return &instance;
}
