// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of numbers as loggers and spreadsheets write them. The C library decodes (iconv) and reads dates
// (strptime), Boost splits the lines. What a column means is up to the caller.
//
// 1. The text is UTF-8, UTF-16 with its mark, or else cp1252.
// 2. Tabs, semicolons, commas, bars or blanks separate the fields: those that leave the most numbers.
// 3. The first line of numbers is the first row. The heads stand before it, between them perhaps units.
// 4. A comma within a number is the decimal mark, unless other numbers have a point: then it is refused.
// 5. A head ends in a unit, as in "Z (um)", "time [s]" or "T1_degC".
#pragma once

#include "components/io/files/csv.hpp"

#include <boost/algorithm/string.hpp>
#include <boost/tokenizer.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <iconv.h>

namespace plumb {

class TableFile {
public:
    enum Quantity { unknown, time, temperature, length, speed, angle };
    enum class Clock { none, day, date, both };  // the fields are numbers, times of a day, dates, or both
    struct Unit {
        Quantity quantity = unknown;  // in s, degC, mm, rpm, deg: factor x value + zero
        double factor = 1, zero = 0;
    };
    struct Column {
        std::string head;  // as it is written
        std::string name;  // lower case without the unit, a blank between words
        std::string unit;  // as it is written; "" if there is none
        Unit known;        // of unknown quantity without a unit
        Clock clock = Clock::none;
    };
    using Heads = std::map<std::string, std::string>;  // a head of the file, and how it is read instead

    static constexpr std::size_t most_bytes = 64 << 20;

    explicit TableFile(const std::string& file, const Heads& heads = {})
        : TableFile(file, csv::text_of(file, most_bytes), heads) {}

    // Throws std::runtime_error with file, line, value and reason.
    TableFile(const std::string& file, std::string_view bytes, const Heads& heads = {}) : file_(file) {
        take_lines(decoded(bytes));
        take_separator();
        const std::size_t first = first_row();
        take_heads(first, heads);
        take_rows(first);
    }

    const std::string& file() const { return file_; }
    const std::vector<Column>& columns() const { return columns_; }
    std::size_t rows() const { return rows_.size(); }
    std::size_t line(std::size_t row) const { return rows_[row].line; }
    std::size_t head_line() const { return head_line_; }
    const std::string& field(std::size_t row, std::size_t column) const { return rows_[row].fields[column]; }

    // How the file is written, where this is not plain CSV; "" if it is.
    std::string form() const {
        std::string text;
        for (const std::string& its : form_) text += (text.empty() ? "" : ", ") + its;
        return text;
    }

    // The place of the column with this name; refuses without one.
    std::size_t column(const std::string& name) const {
        const auto at = std::find_if(columns_.begin(), columns_.end(),
                                     [&](const Column& its) { return its.name == name; });
        if (at == columns_.end()) refuse(head_line_, "there is no column " + name + "; there are " + heads());
        return static_cast<std::size_t>(at - columns_.begin());
    }
    std::string heads() const {
        std::string all;
        for (const Column& its : columns_) all += (all.empty() ? "" : ", ") + csv::quoted(its.head);
        return all;
    }

    // In the unit of its quantity; nothing in a gap. Without a unit of the column, times `scale`.
    std::optional<double> number(std::size_t row, std::size_t column, double scale = 1) const {
        const Column& its = columns_[column];
        const std::string& text = rows_[row].fields[column];
        if (is_gap(text)) return std::nullopt;
        if (its.clock != Clock::none) {
            const auto [seconds, kind] = clock_of(text);
            if (kind == Clock::none)
                refuse_value(row, column,
                             text.find('/') == std::string::npos
                                 ? "is no time as " + csv::quoted(first_field(column))
                                 : "has the month or the day first: write it as 2026-03-31T08:00:00");
            return seconds;
        }
        const auto value = plain(text);
        if (!value) refuse_value(row, column, "is no number");
        return its.known.quantity == unknown ? *value * scale : *value * its.known.factor + its.known.zero;
    }
    double value(std::size_t row, std::size_t column, double scale = 1) const {
        const auto its = number(row, column, scale);
        if (!its) refuse(rows_[row].line, "column " + columns_[column].head + ": there is no value");
        return *its;
    }

    // Of a line "# NAME: VALUE".
    const std::string& stated(const std::string& name) const {
        const auto at = stated_.find(name);
        if (at == stated_.end())
            throw std::runtime_error(file_ + ": the head does not state " + name + ": write # " + name +
                                     ": ...");
        return at->second.second;
    }
    std::size_t stated_line(const std::string& name) const { return stated_.at(name).first; }

    [[noreturn]] void refuse(std::size_t line, const std::string& why) const {
        throw std::runtime_error(file_ + ": line " + std::to_string(line) + ": " + why);
    }
    [[noreturn]] void refuse_value(std::size_t row, std::size_t column, const std::string& why) const {
        refuse(rows_[row].line,
               "column " + columns_[column].head + ": " + csv::quoted(rows_[row].fields[column]) + ' ' + why);
    }

    // Of unknown quantity if there is no such unit.
    static Unit unit_of(std::string text) {
        static const std::map<std::string, Unit> all = [] {
            std::map<std::string, Unit> its;
            const auto add = [&](const char* names, Unit unit) {
                std::vector<std::string> words;
                boost::split(words, names, boost::is_any_of(" "));
                for (const std::string& word : words) its[word] = unit;
            };
            add("s sec secs second seconds", {time, 1});
            add("ms msec millisecond milliseconds", {time, 1e-3});
            add("min mins minute minutes", {time, 60});
            add("h hr hrs hour hours", {time, 3600});
            add("degc c celsius", {temperature, 1});
            add("degf f fahrenheit", {temperature, 5. / 9, -32 * 5. / 9});
            add("k kelvin degk", {temperature, 1, -273.15});
            add("nm", {length, 1e-6});
            add("um micron microns micrometre micrometres micrometer micrometers", {length, 1e-3});
            add("mm millimetre millimetres millimeter millimeters", {length, 1});
            add("in inch inches", {length, 25.4});
            add("mil mils thou", {length, 0.0254});
            add("rpm 1/min min-1 u/min r/min rev/min", {speed, 1});
            add("deg degree degrees", {angle, 1});
            return its;
        }();
        boost::erase_all(text, " ");
        const auto at = all.find(plain_letters(text));
        return at == all.end() ? Unit{} : at->second;
    }

private:
    struct Row {
        std::size_t line = 0;
        std::vector<std::string> fields;
    };

    static std::string plain_letters(std::string text) {
        for (const auto& [from, to] : {std::pair("\u00b5", "u"),
                                       {"\u03bc", "u"},
                                       {"\u00b0", "deg"},
                                       {"\u00ba", "deg"},
                                       {"\u2103", "degc"}})
            boost::replace_all(text, from, to);
        return boost::to_lower_copy(text);
    }

    std::optional<std::string> converted(std::string_view bytes, const char* from) const {
        const iconv_t way = iconv_open("UTF-8", from);
        if (way == iconv_t(-1)) return std::nullopt;
        std::string result(3 * bytes.size() + 16, '\0');
        char *in = const_cast<char*>(bytes.data()), *out = result.data();
        std::size_t rest = bytes.size(), room = result.size();
        const bool failed = iconv(way, &in, &rest, &out, &room) == static_cast<std::size_t>(-1);
        iconv_close(way);
        if (failed) return std::nullopt;
        result.resize(result.size() - room);
        return result;
    }

    std::string decoded(std::string_view bytes) {
        const std::string_view mark = bytes.substr(0, 2);
        const bool wide = mark == "\xff\xfe" || mark == "\xfe\xff";
        std::string encoding = wide ? "UTF-16" : "UTF-8";
        auto text = converted(csv::without_byte_order_mark(bytes), encoding.c_str());
        if (!text && !wide) text = converted(bytes, (encoding = "CP1252").c_str());
        if (!text || text->find('\0') != std::string::npos)
            throw std::runtime_error(file_ + ": is no text; export the table as CSV");
        if (encoding != "UTF-8") form_.push_back(encoding);
        if (text->find('\n') == std::string::npos) boost::replace_all(*text, "\r", "\n");
        return *text;
    }

    void take_lines(const std::string& text) {
        whole_ = !text.empty() && text.back() == '\n';
        std::size_t number = 0;
        for (std::string_view rest = text; !rest.empty();) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            std::string_view line = rest.substr(0, end);
            rest.remove_prefix(std::min(end + 1, rest.size()));
            ++number;
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            if (csv::trimmed(line).empty()) continue;
            if (line[0] != '#') {
                lines_.emplace_back(number, line);
                continue;
            }
            const std::string_view words = csv::trimmed(line.substr(1));
            const std::size_t colon = words.find(':');
            if (colon != std::string_view::npos)
                stated_[std::string(csv::trimmed(words.substr(0, colon)))] = {
                    number, std::string(csv::trimmed(words.substr(colon + 1)))};
        }
    }

    std::vector<std::string> split(const std::string& line, char separator) const {
        std::vector<std::string> fields;
        if (separator == ' ') {
            boost::split(fields, line, boost::is_any_of(" "), boost::token_compress_on);
        } else {
            const boost::escaped_list_separator<char> rule("", std::string(1, separator), "\"");
            for (const std::string& field : boost::tokenizer(line, rule))
                fields.emplace_back(csv::trimmed(field));
        }
        return fields;
    }

    static bool is_gap(const std::string& field) {
        static const std::vector<std::string> words{"",     "nan",      "na",  "n/a", "#n/a", "null",
                                                    "none", "-",        "--",  "---", "inf",  "-inf",
                                                    "ol",   "overload", "ovl", "err", "error"};
        return field.size() <= 8 &&
               std::find(words.begin(), words.end(), boost::to_lower_copy(field)) != words.end();
    }
    // The seconds of a date, of a time of a day, or of both.
    static std::pair<double, Clock> clock_of(const std::string& field) {
        if (field.size() < 4 || field.size() > 40 || !std::isdigit(static_cast<unsigned char>(field[0])))
            return {0, Clock::none};
        for (const char* const date : {"%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y", ""})
            for (const char* const between : {"T", " ", ""})
                for (const char* const hour : {"%H:%M:%S", "%H:%M", ""}) {
                    const bool has_date = *date != '\0', has_hour = *hour != '\0';
                    if ((*between != '\0') != (has_date && has_hour)) continue;
                    std::tm when{};
                    when.tm_year = 70, when.tm_mday = 1;
                    const char* rest =
                        strptime(field.c_str(), (std::string(date) + between + hour).c_str(), &when);
                    if (rest == nullptr || (!has_date && !has_hour)) continue;
                    auto seconds = static_cast<double>(timegm(&when));
                    if (has_hour && (*rest == '.' || *rest == ',')) {
                        const std::size_t digits = std::string_view(rest + 1).find_first_not_of("0123456789");
                        const std::string_view its(rest + 1,
                                                   std::min(digits, std::string_view(rest + 1).size()));
                        seconds += csv::number("0." + std::string(its)).value_or(0);
                        rest += 1 + its.size();
                    }
                    if (has_date && has_hour && (*rest == '+' || *rest == '-') && std::strlen(rest) >= 5) {
                        std::tm zone{};
                        const char* const end = strptime(rest + 1, "%H:%M", &zone);
                        const double off = 3600 * zone.tm_hour + 60 * zone.tm_min;
                        seconds -= *rest == '+' ? off : -off;
                        rest = end == nullptr ? rest : end;
                    }
                    if (has_date && has_hour && *rest == 'Z') ++rest;
                    if (*rest != '\0') continue;
                    return {seconds, has_date && has_hour ? Clock::both
                                     : has_date           ? Clock::date
                                                          : Clock::day};
                }
        return {0, Clock::none};
    }
    static bool is_clock(const std::string& field) {
        const bool month_or_day = std::count(field.begin(), field.end(), '/') == 2 &&
                                  std::isdigit(static_cast<unsigned char>(field[0]));
        return month_or_day || clock_of(field).second != Clock::none;
    }
    static std::optional<double> any_number(std::string field) {
        if (std::count(field.begin(), field.end(), ',') == 1) boost::replace_all(field, ",", ".");
        return csv::number(field);
    }
    std::optional<double> plain(const std::string& field) const {
        return comma_ ? any_number(field) : csv::number(field);
    }

    void take_separator() {
        if (lines_.empty()) throw std::runtime_error(file_ + ": there are no rows in it");
        double best = -1;
        for (const char separator : {'\t', ';', ',', '|', ' '}) {
            std::map<std::size_t, std::size_t> counts;
            const std::size_t looked = std::min<std::size_t>(lines_.size(), 200);
            for (std::size_t i = 0; i < looked; ++i) ++counts[split(lines_[i].second, separator).size()];
            const auto most =
                std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
                    return std::pair(a.second, a.first) < std::pair(b.second, b.first);
                });
            if (most->first < 2) continue;
            double good = 0, all = 0;
            for (std::size_t i = 0; i < looked; ++i)
                for (const std::string& field : split(lines_[i].second, separator)) {
                    ++all;
                    good += any_number(field) || is_gap(field) || is_clock(field);
                }
            if (good / all <= best) continue;
            best = good / all;
            separator_ = separator;
            width_ = most->first;
        }
        if (separator_ != ',')
            form_.push_back(std::string("separated by ") + (separator_ == '\t'  ? "tabs"
                                                            : separator_ == ';' ? "semicolons"
                                                            : separator_ == '|' ? "bars"
                                                                                : "blanks"));
    }

    // Its index in lines_.
    std::size_t first_row() const {
        for (const bool exact : {true, false})
            for (std::size_t i = 0; i < lines_.size(); ++i) {
                const auto fields = split(lines_[i].second, separator_);
                const bool numbers = std::all_of(fields.begin(), fields.end(), [](const std::string& its) {
                    return any_number(its) || is_gap(its) || is_clock(its);
                });
                const bool gaps = std::all_of(fields.begin(), fields.end(), is_gap);
                if (!numbers || gaps || (exact && fields.size() != width_)) continue;
                if (i == 0) refuse(lines_[0].first, "the first line has to name the columns, and is a row");
                return i;
            }
        return lines_.size();
    }

    void take_heads(std::size_t first, const Heads& given) {
        std::size_t at = first > 0 ? first - 1 : 0;
        const auto fields = [&](std::size_t i) { return split(lines_[i].second, separator_); };
        std::vector<std::string> heads = fields(at), units(heads.size());
        const auto is_unit = [](const std::string& its) {
            return its.empty() ||
                   unit_of(boost::trim_copy_if(its, boost::is_any_of("()[]"))).quantity != unknown;
        };
        if (at > 0 && fields(at - 1).size() >= heads.size() &&
            std::all_of(heads.begin(), heads.end(), is_unit)) {
            units = heads;
            heads = fields(--at);
            units.resize(heads.size());
            form_.push_back("units in line " + std::to_string(lines_[at + 1].first));
        }
        head_line_ = lines_[at].first;
        check_quotes(lines_[at]);
        if (lines_[at].second.find('"') != std::string::npos) form_.push_back("quotation marks");
        if (at > 0) form_.push_back("heads in line " + std::to_string(head_line_));
        while (!heads.empty() && heads.back().empty()) heads.pop_back();
        for (const auto& [head, instead] : given) {
            const auto its = std::find(heads.begin(), heads.end(), head);
            if (its == heads.end())
                refuse(head_line_, "there is no column " + csv::quoted(head) + "; there are '" +
                                       boost::join(heads, "', '") + "'");
            *its = instead;
        }
        for (std::size_t i = 0; i < heads.size(); ++i) {
            for (const Column& other : columns_)
                if (other.head == heads[i])
                    refuse(head_line_, "column " + csv::quoted(heads[i]) + " is there twice");
            columns_.push_back(column_of(heads[i], boost::trim_copy_if(units[i], boost::is_any_of("()[]"))));
        }
    }

    static Column column_of(const std::string& head, std::string unit) {
        Column its{head, head, "", {}};
        const std::size_t open = head.find_last_of("(["), blank = head.find_last_of(" _.,/");
        const bool closed = !head.empty() && (head.back() == ')' || head.back() == ']');
        std::string own;
        if (closed && open != std::string::npos) {
            own = head.substr(open + 1, head.size() - open - 2);
            its.name.resize(open);
        } else if (head.size() > 1 && unit_of(head).quantity == time) {
            own = std::exchange(its.name, "time");
        } else if (blank != std::string::npos && blank > 0 &&
                   unit_of(head.substr(blank + 1)).quantity != unknown) {
            own = head.substr(blank + 1);
            its.name.resize(blank);
        }
        if (unit.empty()) unit = own;
        its.name = plain_letters(its.name);
        std::vector<std::string> words;
        boost::split(words, its.name, boost::is_any_of(" _.,-/:"), boost::token_compress_on);
        its.name = boost::trim_copy(boost::join(words, " "));
        its.unit = unit;
        its.known = unit_of(unit);
        return its;
    }

    void check_quotes(const std::pair<std::size_t, std::string>& line) const {
        if (std::count(line.second.begin(), line.second.end(), '"') % 2 != 0)
            refuse(line.first, "a quotation mark is not closed");
    }

    void take_rows(std::size_t first) {
        std::string with_point;
        std::pair<std::size_t, std::string> with_comma;
        for (std::size_t i = first; i < lines_.size(); ++i) {
            check_quotes(lines_[i]);
            auto fields = split(lines_[i].second, separator_);
            while (fields.size() > columns_.size() && fields.back().empty()) fields.pop_back();
            if (fields.size() < columns_.size() && i + 1 == lines_.size() && !whole_) {
                form_.push_back("line " + std::to_string(lines_[i].first) +
                                " is not complete and was left out");
                break;
            }
            if (fields.size() != columns_.size())
                refuse(lines_[i].first,
                       std::to_string(fields.size()) + (fields.size() == 1 ? " value" : " values") +
                           ", but line " + std::to_string(head_line_) + " has " +
                           std::to_string(columns_.size()) + " heads" +
                           (fields.size() > columns_.size() && separator_ == ','
                                ? "; is the comma a decimal mark? Then separate by semicolons"
                                : ""));
            for (const std::string& field : fields) {
                if (is_clock(field)) continue;
                if (field.find(',') != std::string::npos && with_comma.second.empty())
                    with_comma = {lines_[i].first, field};
                if (field.find('.') != std::string::npos && with_point.empty()) with_point = field;
            }
            rows_.push_back({lines_[i].first, std::move(fields)});
        }
        if (rows_.empty()) throw std::runtime_error(file_ + ": there are no rows in it");
        comma_ = !with_comma.second.empty();
        if (comma_ && !with_point.empty())
            refuse(with_comma.first, csv::quoted(with_comma.second) + " has a comma and " +
                                         csv::quoted(with_point) +
                                         " a point: which one is the decimal mark?");
        if (comma_) form_.emplace_back("decimal comma");
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const std::string& text = first_field(i);
            if (!csv::number(text) && is_clock(text))
                columns_[i].clock = std::max(clock_of(text).second, Clock::day);
        }
    }
    const std::string& first_field(std::size_t column) const {
        const auto at = std::find_if(rows_.begin(), rows_.end(),
                                     [&](const Row& row) { return !is_gap(row.fields[column]); });
        return (at == rows_.end() ? rows_.front() : *at).fields[column];
    }

    std::string file_;
    std::vector<std::pair<std::size_t, std::string>> lines_;  // with their numbers
    bool whole_ = false;                                      // the last line has an end
    char separator_ = ',';
    std::size_t width_ = 1;
    bool comma_ = false;  // the decimal mark
    std::size_t head_line_ = 0;
    std::vector<Column> columns_;
    std::vector<Row> rows_;
    std::map<std::string, std::pair<std::size_t, std::string>> stated_;
    std::vector<std::string> form_;
};

}  // namespace plumb
