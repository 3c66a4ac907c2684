// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"

#include "tests/support/impossible.hpp"
#include "tests/support/place.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace plumb {
namespace {

double in_seconds(client::Time time) {
    return std::chrono::duration<double>(time).count();
}

std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line)
        if (c == ',')
            cells.emplace_back();
        else
            cells.back() += c;
    return cells;
}

}  // namespace

std::vector<double> Table::column(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw std::out_of_range("no column " + name);
    const auto index = static_cast<std::size_t>(std::distance(names.begin(), found));
    std::vector<double> column;
    column.reserve(rows.size());
    for (const std::vector<double>& row : rows) column.push_back(row[index]);
    return column;
}

Table read_table(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    const auto fail = [&](std::size_t number, const std::string& why) {
        throw std::runtime_error(file.string() + ":" + std::to_string(number) + ": " + why);
    };
    if (!std::getline(in, line)) fail(1, "no header");
    Table table{split(line), {}};
    while (std::getline(in, line)) {
        const std::size_t number = table.rows.size() + 2;
        std::vector<double> row;
        for (const std::string& cell : split(line)) {
            double value;
            const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
            if (error != std::errc() || end != cell.data() + cell.size())
                fail(number, "not a number: " + cell);
            row.push_back(value);
        }
        if (row.size() != table.names.size()) fail(number, "not as many values as the header names");
        table.rows.push_back(std::move(row));
    }
    return table;
}

client::Start with_specimens(bool guard) {
    client::Start start;
    start.modules = {build_folder() + "/specimens"};
    start.guard = guard;
    return start;
}

Bench::Bench(Thread thread, const client::Start& start) : client_(start) {
    if (thread == Thread::none) return;
    command("loadrt threads name1=servo-thread period1=1000000");
    command("start");
}

void Bench::poison(const std::string& pin, double seconds) {
    const double own = get(pin);
    for (const double value : impossible) {
        set(pin, value);
        run(seconds);
    }
    set(pin, own);
}

void Bench::run(double seconds) {
    client_.run(client::seconds(seconds));
    if (expectations_.empty()) return;
    for (const client::Violation& violation : client_.violations()) {
        std::int64_t& reported = reported_[violation.id];
        if (violation.count == reported) continue;
        std::string values;
        for (const auto& [name, value] : violation.values)
            values += ", " + name + " = " + testing::PrintToString(value);
        ADD_FAILURE() << expectations_[violation.id] << " did not hold in " << violation.count - reported
                      << " periods; first at " << testing::PrintToString(in_seconds(violation.first_time))
                      << " s" << values;
        reported = violation.count;
    }
}

Table Bench::trace(double seconds, const std::vector<std::string>& names, double every) {
    const Folder folder;
    const std::filesystem::path file = folder / "trace.csv";
    client_.record("trace", {names, client::seconds(every), file});
    run(seconds);
    client_.record_stop("trace");
    return read_table(file);
}

void Bench::record(const std::filesystem::path& file, const std::vector<std::string>& names, double every) {
    client_.record(file, {names, client::seconds(every), file});
}

void Bench::expect(const std::string& expression, const std::map<std::string, std::string>& variables) {
    const std::string id = "expectation " + std::to_string(expectations_.size() + 1);
    client_.expect(id, expression, variables);
    expectations_[id] = expression;
}

}  // namespace plumb
