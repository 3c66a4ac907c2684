// SPDX-License-Identifier: GPL-2.0-or-later
// Angles, lengths, times and numbers, as people write them.
#include "tests/readers/reader.hpp"

#include "components/commissioning/quantity_text.hpp"
#include "components/io/files/csv.hpp"
#include "hal/client/duration.hpp"
#include "hal/host/decimal.hpp"

#include <cmath>

namespace plumb::readers {
namespace {

void read_time(const std::string& text) {
    client::Time time{};
    if (!takes<std::invalid_argument>([&] { time = client::parse_duration(text); })) return;
    demand(time.count() >= 0, "no time is below 0");
    demand(!client::describe_duration(time).empty(), "each time has words");
    std::string seconds;
    host::append_seconds(seconds, time.count());
    demand(host::number_of(seconds).has_value(), "the text of a time is a number");
}

void read_number(const std::string& text) {
    const std::optional<double> number = host::number_of(text);
    if (const auto finite = csv::number(text)) {
        demand(std::isfinite(*finite), "a number of a table is finite");
        demand(number == finite, "a number is the same in a table and in a recording");
    }
    if (!number) return;
    std::string again;
    host::append_number(again, *number);
    const auto read_back = host::number_of(again);
    demand(read_back && (*read_back == *number || std::isnan(*number)),
           "a number that was written is read back");
}

void read(std::string_view bytes) {
    const std::string text(bytes);
    takes<std::invalid_argument>([&] { demand(std::isfinite(angle_of(text)), "an angle is finite"); });
    takes<std::invalid_argument>(
        [&] { demand(std::abs(length_of(text)) <= 1e6, "a length is at most 1 km"); });
    takes<std::invalid_argument>([&] {
        for (const double length : lengths_of(text))
            demand(std::abs(length) <= 1e6, "a length is at most 1 km");
    });
    read_time(text);
    read_number(text);
}

const Reader reader{"quantity", read};

}  // namespace
}  // namespace plumb::readers
