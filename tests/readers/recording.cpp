// SPDX-License-Identifier: GPL-2.0-or-later
// Recordings that are to be gone on with.
#include "tests/readers/reader.hpp"

#include "hal/host/recorder.hpp"

#include <stdexcept>

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    const FileOf file(bytes);
    host::Nanoseconds time = 0;
    if (!takes<std::runtime_error>([&] { time = host::Recorder::last_time(file.path(), {"a", "b"}); }))
        return;
    demand(time >= 0 && host::after(time, time) > time - 1,
           "a recording ends at a time that leaves room to add");
    demand(bytes.back() == '\n', "a recording that breaks off is refused");
}

const Reader reader{"recording", read};

}  // namespace
}  // namespace plumb::readers
