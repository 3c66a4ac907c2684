// SPDX-License-Identifier: GPL-2.0-or-later
// Logs of growth tests, and the report that is made of them.
#include "tests/readers/reader.hpp"

#include "components/commissioning/growth/growth_report.hpp"
#include "components/io/files/growth_log_file.hpp"

#include <stdexcept>
#include <string>

namespace plumb::readers {
namespace {

void demand_unchanged(const std::string& whole) {
    constexpr std::size_t tries = 64;
    const std::size_t step = 8 * whole.size() / tries + 1;
    for (std::size_t bit = whole.size() % step; bit < 8 * whole.size(); bit += step) {
        std::string flipped = whole;
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
        demand(!takes<std::runtime_error>([&] { growth_log_file::parse(flipped, "growth.csv"); }),
               "a log with a flipped bit is refused");
    }
}

void read(std::string_view bytes) {
    GrowthLog log;
    if (!takes<std::runtime_error>([&] { log = growth_log_file::parse(std::string(bytes), "growth.csv"); }))
        return;
    demand(!log.records.empty() && !log.machine.empty(), "a log that is taken has a machine and a record");
    double time = 0;
    std::string again = growth_log_file::head(log);
    for (std::size_t i = 0; i < log.records.size(); ++i) {
        demand(log.records[i].time >= time, "the records are in the order of time");
        time = log.records[i].time;
        again += growth_log_file::line(log.records[i], i + 1);
    }
    const std::string whole = LineChecksums().added(again);
    const GrowthLog copy = growth_log_file::parse(whole, "growth.csv");
    demand(copy.records.size() == log.records.size() && copy.bores.size() == log.bores.size(),
           "a log that is written again is the same");
    demand_unchanged(whole);
    const commissioning::GrowthAnalysis analysis = commissioning::analysed(log);
    demand(analysis.verdict != commissioning::GrowthVerdict::pass || analysis.stop == growth_test::Stop::stable,
           "only a test that ended passes");
    demand(!commissioning::growth_json({analysis}).empty(), "there are results");
}

const Reader reader{"growth_log", read};

}  // namespace
}  // namespace plumb::readers
