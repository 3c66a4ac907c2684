// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// After foreign, damaged, version, and a refusal, nothing is restored and nothing is saved; after computer,
// older, unnamed and nameless until somebody answers.
enum class Fault : std::int32_t {
    none,
    foreign,
    damaged,
    version,
    inaccessible,
    unfit,
    refused,
    program,
    computer,
    older,
    unnamed,
    nameless
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::foreign:
            return "The store is another machine's, or no file of plumb-retain; it is left as it is. Correct "
                   "that, "
                   "and start again.";
        case Fault::damaged:
            return "The store is truncated or damaged; it is left as it is. Correct that, and start again.";
        case Fault::version:
            return "The store is of another version; it is left as it is. Correct that, and start again.";
        case Fault::inaccessible:
            return "The store cannot be read or written. plumb-retain tries again once a second. At the "
                   "start "
                   "nothing is restored until then; later restored stays true.";
        case Fault::unfit:
            return "A named pin or component does not exist, has another type, is an output, or is netted; "
                   "restored stays or becomes false until that is corrected.";
        case Fault::refused:
            return "A component refused a record, as while it learns; the store is left as it is. Correct "
                   "that, and start again.";
        case Fault::program: return "A file of the program cannot be read; program-id is 0.";
        case Fault::computer:
            return "The store is from another computer. Nothing is restored or saved until you answer: plumb "
                   "commission --accept takes it over, --renew begins a new one.";
        case Fault::older:
            return "The store is an old copy, or another user's. Nothing is restored or saved until you "
                   "answer: plumb commission --accept takes it over, --renew begins a new one.";
        case Fault::unnamed:
            return "The store does not say from which computer it is, as before it was bound. Nothing is "
                   "restored or saved until you answer: plumb commission --accept takes it over, --renew "
                   "begins a new one.";
        case Fault::nameless:
            return "This computer has no machine-id: run systemd-machine-id-setup. Nothing is restored or "
                   "saved until you answer: plumb commission --accept takes the store over, --renew begins a "
                   "new one.";
        default: return nullptr;
    }
}

}  // namespace plumb
