// SPDX-License-Identifier: GPL-2.0-or-later
// The binary requests of rtapi_app of LinuxCNC 2.10.
#include "hal/host/rtapi_protocol.hpp"

#include <stdexcept>

#include "tests/readers/reader.hpp"

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    takes<std::runtime_error>([&] {
        const auto words = host::words_of_frame(bytes);
        if (!words) return;
        std::size_t size = 4;
        for (const std::string& word : *words) size += 2 + word.size();
        demand(size <= bytes.size() && size <= 0xffff, "the words are those of the frame");
    });
}

const Reader reader{"rtapi_frame", read};

}  // namespace
}  // namespace plumb::readers
