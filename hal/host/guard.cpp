// SPDX-License-Identifier: GPL-2.0-or-later
#include "guard.hpp"

#include <nlohmann/json.hpp>

namespace plumb::host {
nlohmann::json guard_report() {
    return {{"ok", false}, {"error", "the guard is off; start the host with --guard"}};
}
}  // namespace plumb::host
