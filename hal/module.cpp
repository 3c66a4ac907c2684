// SPDX-License-Identifier: GPL-2.0-or-later
// Linked into every realtime component: turns its Model into a module for `loadrt`.
//
//     loadrt <component> [count=N | names=a,b,...] [OPTION=value,value,...]

#include "hal/background.hpp"
#include "hal/hal_registrar.hpp"
#include "hal/identity.hpp"
#include "hal/linuxcnc_unit.hpp"
#include "hal/message.hpp"
#include "hal/module_options.hpp"

#include <rtapi.h>
#include <rtapi_app.h>
#include <rtapi_errno.h>

#include <atomic>
#include <charconv>
#include <cstddef>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

static char* names = nullptr;
RTAPI_MP_STRING(names, "instance names, comma separated")
static char* count = nullptr;  // a text: of a number RTAPI hands on the low 32 bits
RTAPI_MP_STRING(count, "number of instances")
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

constexpr std::size_t most_instances = 64;  // far more than any machine has; HAL's memory is small

void refuse_more_instances(std::size_t number, const std::string& given) {
    if (number > most_instances)
        throw std::invalid_argument(given + ": at most " + std::to_string(most_instances) +
                                    " instances are possible");
}

std::size_t counted_instances() {
    if (!count) return 1;
    const std::string given = count;
    const char* const end = given.data() + given.size();
    long long number = 0;
    const auto [rest, error] = std::from_chars(given.data(), end, number);
    if (rest != end || error == std::errc::invalid_argument)
        throw std::invalid_argument("count=" + given + ": not a whole number");
    const bool negative = given.front() == '-';
    if (negative || (error == std::errc{} && number == 0))
        throw std::invalid_argument("count=" + given + " is below 1");
    refuse_more_instances(error == std::errc{} ? static_cast<std::size_t>(number) : most_instances + 1,
                          "count=" + given);
    return static_cast<std::size_t>(number);
}

// names=a,b gives {a, b}; otherwise <component>.0, <component>.1, ...
Texts instance_names() {
    if (names && count) throw std::invalid_argument("count= and names= exclude each other");
    Texts result;
    if (names) {
        result = split(names);
        refuse_more_instances(result.size(), "names= gives " + std::to_string(result.size()) + " names");
        std::set<std::string> seen;
        for (const std::string& name : result) {
            check_instance_name(name);
            if (!seen.insert(name).second) throw std::invalid_argument("name '" + name + "' is given twice");
        }
    } else {
        std::string stem = model().about.name;
        for (char& c : stem)
            if (c == '_') c = '-';
        const std::size_t number = counted_instances();
        for (std::size_t i = 0; i < number; ++i) result.push_back(stem + "." + std::to_string(i));
    }
    return result;
}

// The values of each option, one per instance. A single one holds for all.
std::map<std::string, Texts> option_values(std::size_t instances) {
    std::map<std::string, Texts> result;
    for (const ModuleOption* option = module_options; option->name; ++option) {
        const char* const list = *option->values;
        if (!list) continue;
        Texts values = split(list);
        if (values.size() == 1) values.assign(instances, values.front());
        if (values.size() != instances)
            throw std::invalid_argument(std::string(option->name) + "=" + list + " gives " +
                                        std::to_string(values.size()) + " values for " +
                                        std::to_string(instances) + " instances");
        result[option->name] = std::move(values);
    }
    return result;
}

// Before a millimetre of a default becomes an inch.
void check_unit(const std::map<std::string, Texts>& options) {
    for (const ModuleOption* option = module_options; option->name; ++option) {
        if (option->name != std::string(length_option)) continue;
        const auto given = options.find(length_option);
        for (const std::string& unit : given == options.end() ? Texts{""} : given->second)
            compare_with_linuxcnc(unit);
    }
}

int component_id = -1;

// A plain pointer, which no destructor follows: when rtapi_app is asked to end, as at a logout or when the
// computer is turned off, it calls exit() while its threads go on calling update().
struct Loaded {
    std::vector<std::unique_ptr<Component>> instances;
    std::unique_ptr<Background> background;
};
Loaded* loaded = nullptr;

// Of the functions, as another module may ask for them: also while this one is loaded or unloaded.
struct DeclaredPlace {
    char name[HAL_NAME_LEN + 1] = "";
    Place place = Place::none;
};
DeclaredPlace declared_places[8];
std::atomic<std::size_t> number_of_places{0};

void declare_places(const std::vector<const Function*>& functions) {
    if (functions.size() > std::size(declared_places)) throw std::logic_error("too many functions");
    std::size_t number = 0;
    for (const Function* const function : functions) {
        DeclaredPlace& declared = declared_places[number++];
        function->name.copy(declared.name, HAL_NAME_LEN);
        declared.place = function->place;
    }
    number_of_places = number;
}

// function: as HAL knows it, INSTANCE.NAME.
Place place_of_function(const std::string_view function) {
    for (std::size_t i = 0; i < number_of_places; ++i) {
        const std::string_view name = declared_places[i].name;
        if (function.size() <= name.size()) continue;
        const std::size_t dot = function.size() - name.size() - 1;
        if (function[dot] == '.' && function.substr(dot + 1) == name) return declared_places[i].place;
    }
    return Place::none;
}

// The settings whose sign turns the effect round, for interlock.
char turning[64][HAL_NAME_LEN + 1];
std::atomic<std::size_t> number_of_turning{0};

void declare_turning(const std::vector<std::string>& pins) {
    if (pins.size() > std::size(turning)) throw std::logic_error("too many settings that turn the effect");
    std::size_t number = 0;
    for (const std::string& pin : pins) pin.copy(turning[number++], HAL_NAME_LEN);
    number_of_turning = number;
}

bool turns(const std::string_view pin) {
    for (std::size_t i = 0; i < number_of_turning; ++i)
        if (pin == turning[i]) return true;
    return false;
}

// The options of the load line, by instance, for interlock.
struct GivenOptions {
    char instance[HAL_NAME_LEN + 1] = "";
    char text[256] = "";
};
GivenOptions given_options[most_instances];
std::atomic<std::size_t> number_of_given{0};

void declare_given(const std::string& instance, const std::map<std::string, std::string>& options) {
    GivenOptions& given = given_options[number_of_given];
    std::string text;
    for (const auto& [option, value] : options) text += option + "=" + value + ' ';
    instance.copy(given.instance, HAL_NAME_LEN);
    text.copy(given.text, sizeof given.text - 1);
    ++number_of_given;
}

const char* given_to(const std::string_view instance) {
    for (std::size_t i = 0; i < number_of_given; ++i)
        if (instance == given_options[i].instance) return given_options[i].text;
    return "";
}

void load() {
    const Texts instance = instance_names();
    const auto options = option_values(instance.size());
    check_unit(options);
    component_id = check(hal_init(model().about.name), "hal_init");
    loaded = new Loaded;
    for (std::size_t i = 0; i < instance.size(); ++i) {
        std::map<std::string, std::string> own;
        for (const auto& [option, values] : options) own[option] = values[i];
        declare_given(instance[i], own);
        HalRegistrar registrar(component_id, instance[i], std::move(own));
        loaded->instances.push_back(model().make(registrar));
        if (i == 0) declare_places(registrar.functions());
        if (i == 0) declare_turning(registrar.turning());
        loaded->instances.back()->prepare();
    }
    if (model().has_background) loaded->background = Background::of(loaded->instances);
    check(hal_ready(component_id), "hal_ready");
}

// HAL takes our functions out of its threads but does not wait for one that runs. So unloadrt while the
// threads run can kill rtapi_app, with LinuxCNC's own modules as well.
void unload() noexcept {
    if (loaded) loaded->background.reset();  // it writes pins, whose memory HAL takes back
    if (component_id > 0) hal_exit(component_id);
    component_id = -1;
    delete loaded;
    loaded = nullptr;
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

// For interlock: the name of a function's place in the order of a thread.
extern "C" const char* plumb_place(const char* function) {
    return plumb::hal::info(plumb::hal::place_of_function(function)).name;
}

// For interlock: whether another sign of this setting, without the instance's name, turns the effect round.
extern "C" bool plumb_turns(const char* pin) {
    return plumb::hal::turns(pin);
}

// For interlock: the options with which this instance was loaded.
extern "C" const char* plumb_given(const char* instance) {
    return plumb::hal::given_to(instance);
}

// For our own tools: the manual and the conformance test.
extern "C" const plumb::hal::Model* plumb_model() {
    static const plumb::hal::Model instance = plumb::hal::model();
    return &instance;
}
