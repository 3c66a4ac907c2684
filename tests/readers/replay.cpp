// SPDX-License-Identifier: GPL-2.0-or-later
// Files of `plumb bench --replay`: CSV, and halsampler's after a first line that begins with a letter.
#include "tests/readers/reader.hpp"

#include "hal/host/replayer.hpp"

#include <stdexcept>

namespace plumb::readers {
namespace {

// The first byte is the number of columns: none, as in a CSV file, which has a header, or 1 to 3.
void read(std::string_view bytes) {
    if (bytes.empty()) return;
    const std::vector<std::string> all{"a", "b", "c"};
    const std::size_t count = static_cast<unsigned char>(bytes.front()) % 4;
    const FileOf file(bytes.substr(1));
    takes<std::runtime_error>([&] {
        const host::Replayer replayer({file.path(),
                                       {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)},
                                       host::Nanoseconds{1} << (bytes.size() % 63)});
        demand(!replayer.columns().empty(), "a file that is taken has columns");
        demand(replayer.duration() >= 0, "a file ends after it begins");
        for (const std::string& column : replayer.columns())
            demand(!column.empty(), "each column has a name");
    });
}

const Reader reader{"replay", read};

}  // namespace
}  // namespace plumb::readers
