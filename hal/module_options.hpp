// SPDX-License-Identifier: GPL-2.0-or-later
// The options that `loadrt` accepts for a module, besides names= and count=.
#pragma once

namespace plumb::hal {

struct ModuleOption {
    const char* name;
    char** values;  // where rtapi_app puts the text; null when it was not given
};

extern const ModuleOption module_options[];  // ends with a null name

}  // namespace plumb::hal
