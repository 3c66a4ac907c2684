// SPDX-License-Identifier: GPL-2.0-or-later
// Finds pins, parameters and signals by name, with HAL's public interface for user-space programs. The host
// attaches itself as a HAL component only while it looks, so that no halcmd ever sees it in a list or unloads
// it.
#pragma once

#include <optional>
#include <string>

#include "hal/any_value.hpp"

namespace plumb::host {

// One value in HAL memory. It is valid until a net, an unload or any other command changes HAL.
struct Cell {
    enum class Kind { pin, parameter, signal };

    Kind kind;
    hal::AnyValue value;
    bool linked;  // a pin with a signal, or a signal with a writer
};

// Looks names up for as long as it lives.
class Names {
public:
    // Attaches to HAL; hal_lib must be loaded. Throws std::runtime_error when HAL refuses.
    Names();
    ~Names();
    Names(const Names&) = delete;

    // A pin of this name, else a parameter, else a signal.
    std::optional<Cell> find(const std::string& name) const;

    // The same. Throws std::runtime_error("there is no pin, parameter or signal 'NAME'").
    Cell need(const std::string& name) const;

private:
    int component_;
};

}  // namespace plumb::host
