// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/replayer.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "hal/host/decimal.hpp"
#include "hal/host/scheduler.hpp"
#include "hal/regular_file.hpp"

namespace plumb::host {

namespace {

constexpr Nanoseconds latest = Nanoseconds{1} << 62;          // leaves room to add
constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";  // of UTF-8, as spreadsheets write it

bool blank(char c) {
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

std::vector<std::string_view> split_at_commas(std::string_view line) {
    std::vector<std::string_view> fields;
    for (std::size_t begin = 0; begin != std::string_view::npos;) {
        const std::size_t comma = line.find(',', begin);
        fields.push_back(trimmed(line.substr(begin, comma - begin)));
        begin = comma == std::string_view::npos ? comma : comma + 1;
    }
    return fields;
}

std::vector<std::string_view> split_at_blanks(std::string_view line) {
    std::vector<std::string_view> fields;
    for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
        const auto end = std::find_if(line.begin(), line.end(), blank);
        fields.push_back(line.substr(0, static_cast<std::size_t>(end - line.begin())));
        line.remove_prefix(fields.back().size());
    }
    return fields;
}

// The value of a field: a number, or TRUE or FALSE in any case.
std::optional<double> value_of(std::string_view field) {
    const auto is = [field](std::string_view word) {
        return field.size() == word.size() &&
               std::equal(field.begin(), field.end(), word.begin(),
                          [](char a, char b) { return std::toupper(static_cast<unsigned char>(a)) == b; });
    };
    if (is("TRUE")) return 1.0;
    if (is("FALSE")) return 0.0;
    return number_of(field);
}

std::string at_line(const std::string& file, std::size_t line) {
    return file + ": line " + std::to_string(line) + ": ";
}

std::string number_text(double value) {
    std::string text;
    append_number(text, value);
    return text;
}

constexpr std::size_t longest_line = 1 << 20;  // bytes

// The lines of a file. A device or a pipe would keep the host waiting, and a line without an end fill its
// memory.
class Lines {
public:
    explicit Lines(const std::string& name) : name_(name) {
        hal::require_regular_file(name);
        file_.open(name);
        if (!file_) throw std::runtime_error(name + ": " + std::strerror(errno));
    }

    // Reads the next one. Returns whether there is one.
    bool next(std::string& text) {
        text.clear();
        ++number_;
        std::streambuf& bytes = *file_.rdbuf();
        for (int c; (c = bytes.sbumpc()) != EOF;) {
            if (c == '\n') return true;
            if (text.size() == longest_line)
                throw std::runtime_error(at_line(name_, number_) + "is longer than " +
                                         std::to_string(longest_line >> 20) + " MiB");
            text += static_cast<char>(c);
        }
        broken_off_ = true;
        return !text.empty();
    }

    std::size_t number() const { return number_; }   // of that line, from 1 on
    bool broken_off() const { return broken_off_; }  // the file ends within it

private:
    const std::string& name_;
    std::ifstream file_;
    std::size_t number_ = 0;
    bool broken_off_ = false;
};

std::string fields_text(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " value" : " values");
}

}  // namespace

Replayer::Replayer(Settings settings) : settings_(std::move(settings)) {
    if (settings_.columns.empty())
        read_csv();
    else
        read_samples();
    if (times_.empty()) throw std::runtime_error(settings_.file + ": there is no data in it");
}

void Replayer::add_row(std::size_t line, Nanoseconds time, const std::vector<std::string_view>& fields) {
    if (!times_.empty() && time <= times_.back())
        throw std::runtime_error(at_line(settings_.file, line) + "the time does not rise");
    for (std::size_t column = 0; column < fields.size(); ++column) {
        const std::optional<double> value = value_of(fields[column]);
        if (!value) {
            throw std::runtime_error(at_line(settings_.file, line) + "column '" + columns_[column] + "': '" +
                                     std::string(fields[column]) + "' is not a number");
        }
        values_[column].push_back(*value);
    }
    times_.push_back(time);
    lines_.push_back(line);
}

void Replayer::read_csv() {
    Lines lines(settings_.file);
    std::string text;
    if (!lines.next(text)) throw std::runtime_error(settings_.file + ": there is no data in it");
    if (text.compare(0, byte_order_mark.size(), byte_order_mark) == 0) text.erase(0, byte_order_mark.size());
    const std::vector<std::string_view> header = split_at_commas(text);
    if (header[0] != "time")
        throw std::runtime_error(at_line(settings_.file, 1) + "the first column is '" +
                                 std::string(header[0]) + "', not 'time'");
    for (std::size_t i = 1; i < header.size(); ++i) {
        if (header[i].empty())
            throw std::runtime_error(at_line(settings_.file, 1) + "column " + std::to_string(i + 1) +
                                     " has no name");
        if (std::find(columns_.begin(), columns_.end(), header[i]) != columns_.end())
            throw std::runtime_error(at_line(settings_.file, 1) + "'" + std::string(header[i]) +
                                     "' stands there twice");
        columns_.emplace_back(header[i]);
    }
    if (columns_.empty())
        throw std::runtime_error(at_line(settings_.file, 1) + "no pin is named beside the time");
    values_.resize(columns_.size());

    while (lines.next(text)) {
        const std::size_t line = lines.number();
        if (trimmed(text).empty()) continue;
        std::vector<std::string_view> fields = split_at_commas(text);
        if (fields.size() != columns_.size() + 1)
            throw std::runtime_error(at_line(settings_.file, line) + fields_text(fields.size()) +
                                     ", but the header has " + std::to_string(columns_.size() + 1));
        const std::optional<double> seconds = number_of(fields[0]);
        const double time = seconds ? *seconds * static_cast<double>(one_second) : NAN;
        if (!(time >= 0.0 && time < static_cast<double>(latest)))
            throw std::runtime_error(at_line(settings_.file, line) + "column 'time': '" +
                                     std::string(fields[0]) + "' is not a time in s from 0 on");
        fields.erase(fields.begin());
        add_row(line, std::llround(time), fields);
    }
}

void Replayer::read_samples() {
    Lines lines(settings_.file);
    columns_ = settings_.columns;
    values_.resize(columns_.size());
    bool numbered = false;
    double last_number = 0;
    std::string text;
    while (lines.next(text)) {
        const std::size_t line = lines.number();
        std::vector<std::string_view> fields = split_at_blanks(text);
        if (fields.empty()) continue;
        const std::size_t whole = columns_.size() + (numbered ? 1 : 0);
        if (lines.broken_off() && fields.size() < whole && !times_.empty())
            break;  // halsampler was killed in it
        if (fields[0] == "overrun")
            throw std::runtime_error(at_line(settings_.file, line) +
                                     "halsampler lost samples here ('overrun')");
        const bool first = times_.empty();
        if (first) numbered = fields.size() == columns_.size() + 1;
        if (numbered) {
            const std::optional<double> number = number_of(fields[0]);
            if (!number)
                throw std::runtime_error(at_line(settings_.file, line) + "'" + std::string(fields[0]) +
                                         "' is not a sample number");
            if (!first && *number != last_number + 1)
                throw std::runtime_error(at_line(settings_.file, line) + "sample " + number_text(*number) +
                                         " follows " + number_text(last_number) +
                                         ": samples are missing or out of order");
            last_number = *number;
            fields.erase(fields.begin());
        }
        if (fields.size() != columns_.size())
            throw std::runtime_error(at_line(settings_.file, line) + fields_text(fields.size()) + " for " +
                                     std::to_string(columns_.size()) + " columns");
        const Nanoseconds time = first ? 0 : after(times_.back(), settings_.sample_period);
        if (time > latest)
            throw std::runtime_error(at_line(settings_.file, line) + "is later than 146 years");
        add_row(line, time, fields);
    }
}

void Replayer::check(const Cell& cell, std::size_t column) const {
    for (std::size_t row = 0; row < times_.size(); ++row) {
        const double value = values_[column][row];
        if (cell.value.accepts(value)) continue;
        throw std::runtime_error(at_line(settings_.file, lines_[row]) + "column '" + columns_[column] +
                                 "': " + number_text(value) + " is no value of a " + cell.value.type_name() +
                                 " pin");
    }
}

void Replayer::resolve(const Names& names) {
    std::vector<Cell> cells;
    for (std::size_t column = 0; column < columns_.size(); ++column) {
        cells.push_back(names.need(columns_[column]));
        if (!begun_ || cells[column].value.type() != cells_[column].value.type()) check(cells[column], column);
    }
    cells_ = std::move(cells);
    if (!begun_) began_ = scheduler().time();
    begun_ = true;
}

void Replayer::apply(Nanoseconds instant) {
    const Nanoseconds time = instant - began_;
    while (row_ + 1 < times_.size() && times_[row_ + 1] <= time) ++row_;
    const bool between = row_ + 1 < times_.size() && time > times_[row_];
    const double share = between ? static_cast<double>(time - times_[row_]) /
                                       static_cast<double>(times_[row_ + 1] - times_[row_])
                                 : 0.0;
    for (std::size_t column = 0; column < cells_.size(); ++column) {
        const double value = values_[column][row_];
        const double change = between ? values_[column][row_ + 1] - value : 0.0;
        const bool linear =
            between && cells_[column].value.type() == hal::AnyValue::Type::real && std::isfinite(change);
        cells_[column].value.set_number(linear ? value + change * share : value);
    }
}

}  // namespace plumb::host
