// SPDX-License-Identifier: GPL-2.0-or-later
// manual MODULE.so: prints the module's manual page.
#include "hal/manual.hpp"
#include "hal/standard_output.hpp"

#include <dlfcn.h>

#include <iostream>

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: manual MODULE.so\n";
        return 2;
    }
    void* const module = dlopen(argv[1], RTLD_LAZY);  // lazily: nothing of HAL is here, and nothing is called
    void* const symbol = module ? dlsym(module, "plumb_model") : nullptr;
    if (!symbol) {
        std::cerr << "manual: " << dlerror() << '\n';
        return 1;
    }
    const auto model = reinterpret_cast<const plumb::hal::Model* (*)()>(symbol);
    std::cout << plumb::hal::manual(*model(), 9);
    return plumb::when_written(0, "manual");
}
