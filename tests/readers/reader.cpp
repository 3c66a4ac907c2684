// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/readers/reader.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace plumb::readers {
namespace {

std::map<std::string, Reader::Read>& readers() {
    static std::map<std::string, Reader::Read> all;
    return all;
}

// The reader that the environment names.
Reader::Read chosen() {
    const char* const name = std::getenv("PLUMB_READER");
    const auto found = readers().find(name ? name : "");
    if (found != readers().end()) return found->second;
    std::fprintf(stderr, "PLUMB_READER is to be one of:");
    for (const auto& [known, read] : readers()) std::fprintf(stderr, " %s", known.c_str());
    std::fputs("\n", stderr);
    std::exit(2);
}

}  // namespace

Reader::Reader(const char* name, Read read) {
    readers()[name] = read;
}

void demand(bool so, const std::string& sentence) {
    if (so) return;
    std::fprintf(stderr, "demanded: %s\n", sentence.c_str());
    std::abort();
}

FileOf::FileOf(std::string_view bytes)
    : descriptor_(memfd_create("bytes", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t count = write(descriptor_, bytes.data() + done, bytes.size() - done);
        if (count <= 0) std::abort();
        done += static_cast<std::size_t>(count);
    }
}

FileOf::~FileOf() {
    close(descriptor_);
}

}  // namespace plumb::readers

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    static const plumb::readers::Reader::Read read = plumb::readers::chosen();
    read({reinterpret_cast<const char*>(bytes), size});
    return 0;
}
