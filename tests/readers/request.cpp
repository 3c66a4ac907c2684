// SPDX-License-Identifier: GPL-2.0-or-later
// Control requests of the host, as a line and by the types that the host asks for.
#include "hal/host/request.hpp"

#include "tests/readers/reader.hpp"
#include "tests/readers/repeated.hpp"

namespace plumb::readers {
namespace {

template <class Take>
void ask(const Take& take) {
    takes<std::runtime_error>(take);
}

void read(std::string_view bytes) {
    constexpr std::size_t longest = 1 << 20;
    const std::string line = repeated(bytes, longest);
    using Words = std::vector<std::string>;
    takes<std::runtime_error>([&] {
        const host::Request request(line);
        for (const char* key : {"names", "args", "columns"}) ask([&] { request.required<Words>(key); });
        for (const char* key : {"id", "file", "cwd"}) ask([&] { request.optional<std::string>(key, ""); });
        for (const char* key : {"append", "override"}) ask([&] { request.optional<bool>(key, false); });
        ask([&] { request.required<std::map<std::string, std::string>>("variables"); });
        ask([&] { host::Request::shown(request.required<host::Request::Json>("value")); });
        for (const char* key : {"ns", "every", "sample-period"}) {
            ask([&] {
                const host::Nanoseconds span = request.span(key, 1);
                demand(span >= 1 && host::after(span, span) > span,
                       "a span of time is positive, and leaves room to add");
            });
        }
    });
}

const Reader reader{"request", read};

}  // namespace
}  // namespace plumb::readers
