// SPDX-License-Identifier: GPL-2.0-or-later
// The part of a module that differs with its component: compiled for each, while module.cpp is compiled
// once.
//
// CMake writes the component's options into PLUMB_OPTIONS as X(name) X(name) ...: rtapi_app finds a parameter
// through a symbol of its name, which no template can make.

#include "hal/module_options.hpp"

#include <rtapi.h>

#define X(option)                  \
    static char* option = nullptr; \
    RTAPI_MP_STRING(option, "see the manual page")
PLUMB_OPTIONS
#undef X

namespace plumb::hal {

#define X(option) {#option, &option},
const ModuleOption module_options[] = {PLUMB_OPTIONS{nullptr, nullptr}};
#undef X

}  // namespace plumb::hal

// For the conformance test: the same, each name followed by a comma.
extern "C" const char* plumb_options() {
#define X(option) #option ","
    return "" PLUMB_OPTIONS;
#undef X
}
