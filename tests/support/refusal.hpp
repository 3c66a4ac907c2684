// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>

namespace plumb {

// The sentence of the error with which a call is refused, or "accepted". Another error passes through.
template <class Error = std::invalid_argument, class Call, class = std::invoke_result_t<const Call&>>
std::string refusal(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "accepted";
}

}  // namespace plumb
