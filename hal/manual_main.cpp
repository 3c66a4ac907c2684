// SPDX-License-Identifier: GPL-2.0-or-later
// manual MODULE.so: prints the module's manual page.
#include "hal/manual.hpp"
#include "hal/standard_output.hpp"

#include <dlfcn.h>

#include <nlohmann/json.hpp>

#include <iostream>
#include <string_view>

namespace {

// What a component declares, for programs: pins, codes and their sentences, options, functions.
nlohmann::ordered_json declarations(const plumb::hal::Model& model) {
    const plumb::hal::Declarations declared(model);
    nlohmann::ordered_json result{{"name", model.about.name}, {"summary", model.about.summary}};
    for (const auto& pin : declared.pins)
        result["pins"][pin.name] = {{"type", type_name(pin.type)},
                                    {"output", pin.output},
                                    {"unit", pin.unit},
                                    {"default", pin.initial},
                                    {"sentence", pin.doc}};
    for (const auto& code : declared.codes)
        for (const auto& [number, sentence] : code.sentences)
            result["codes"][code.pin][std::to_string(number)] = sentence;
    for (const auto& option : declared.options) result["options"][option.name] = option.doc;
    for (const auto* function : declared.functions) result["functions"][function->name] = function->place;
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    const bool as_json = argc == 3 && std::string_view(argv[1]) == "--json";
    if (argc != 2 && !as_json) {
        std::cerr << "usage: manual [--json] MODULE.so\n";
        return 2;
    }
    void* const module = dlopen(argv[argc - 1], RTLD_LAZY);  // lazily: HAL is not here, and nothing is called
    void* const symbol = module ? dlsym(module, "plumb_model") : nullptr;
    if (!symbol) {
        std::cerr << "manual: " << dlerror() << '\n';
        return 1;
    }
    const auto& model = *reinterpret_cast<const plumb::hal::Model* (*)()>(symbol)();
    if (as_json)
        std::cout << declarations(model).dump(1) << '\n';
    else
        std::cout << plumb::hal::manual(model, 9);
    return plumb::when_written(0, "manual");
}
