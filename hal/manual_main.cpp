// SPDX-License-Identifier: GPL-2.0-or-later
// manual MODULE.so: prints the module's manual page; manual --json MODULE.so: its declarations; manual
// --glossary FILE: the page of the words.
#include "hal/manual.hpp"
#include "hal/standard_output.hpp"

#include <dlfcn.h>

#include <fstream>
#include <iostream>
#include <iterator>
#include <string_view>

int main(int argc, char** argv) {
    if (argc == 3 && std::string_view(argv[1]) == "--glossary") {
        std::ifstream file(argv[2]);
        std::cout << plumb::hal::glossary({std::istreambuf_iterator<char>(file), {}});
        return plumb::when_written(file ? 0 : 1, "manual");
    }
    const bool as_json = argc == 3 && std::string_view(argv[1]) == "--json";
    if (argc != 2 && !as_json) {
        std::cerr << "usage: manual [--json] MODULE.so | --glossary FILE\n";
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
        std::cout << plumb::hal::declarations(model);
    else
        std::cout << plumb::hal::manual(model, 9);
    return plumb::when_written(0, "manual");
}
