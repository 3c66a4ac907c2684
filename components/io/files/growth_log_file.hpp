// SPDX-License-Identifier: GPL-2.0-or-later
// The log of a growth test: CSV, one line a fact, appended as it comes. growth_log(1) describes the format.
#pragma once

#include "components/io/files/csv.hpp"
#include "components/io/files/line_checksums.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// One record, in the order of time. The fields are those of the records of thermal_growth_test.
struct GrowthRecord {
    enum Kind { touch = 1, temperature = 2, event = 3, speed = 4 };
    int line = 0;  // of the file
    int kind = 0;
    double time = 0;
    int pass = 0, visit = 0, bore = 0, item = 0;
    bool turned = false, compensated = false, cooled = false;
    std::array<double, 3>
        at{};  // mu; of a temperature: degC, 1 for valid, age in s; of an event: a number; of a speed: rpm
    std::array<double, 3> offset{};  // mu
};

struct GrowthLog {
    struct Bore {
        std::array<double, 3> place{};  // mm, from the centre of the table at the orientation 0
        bool sphere = false;            // touched from outside and from above
    };
    struct Artifact {
        int sensor = 0;                 // from 1
        double expansion = 11.5;        // parts of a million for 1 K
        double uncertainty = 1;         // the same, standard
        std::array<double, 3> fixed{};  // mm, the point that its clamp holds; as the places of the bores
    };

    std::string file;
    int number = 0;       // logs of a folder count from 1; 0 for a log without a number
    std::string machine, begun, compensation = "none", warming = "spindle";
    double millimetres = 1;  // in a machine unit
    double ball = 6;         // mm
    bool trunnion = false;
    std::array<double, 3> tolerance{0.01, 0.01, 0.01};  // mm
    std::map<int, std::string> sensors;                 // from 1
    std::map<int, Bore> bores;
    std::optional<Artifact> artifact;  // whose expansion is known
    std::vector<GrowthRecord> records;
    std::string torn;  // why the last line was left out; empty if it is whole

    // The date alone does not tell two tests of a computer without a clock apart.
    std::string title() const { return number > 0 ? begun + ", log " + std::to_string(number) : begun; }
};

namespace growth_log_file {

constexpr std::string_view first_line = "growth-log,2";
constexpr std::size_t most_bytes = 16 << 20;
constexpr std::array<const char*, 10> event_names{"begin", "pass-begin", "pass-end", "cycle-end",
                                                  "stop",  "resumed",    "rejected", "fault",
                                                  "end",   "measured"};

inline std::string text_of(double value) {
    char digits[32];
    return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

// The head of a log, of whole lines without checksums.
inline std::string head(const GrowthLog& log) {
    std::string text = std::string(first_line) + '\n';
    const auto add = [&](const std::string& key, const std::string& value) {
        text += key + ',' + value + '\n';
    };
    if (log.number > 0) add("log", std::to_string(log.number));
    add("machine", log.machine);
    add("begun", log.begun);
    add("unit", text_of(log.millimetres));
    add("ball", text_of(log.ball));
    add("table", log.trunnion ? "A" : "B");
    add("tolerance",
        text_of(log.tolerance[0]) + ',' + text_of(log.tolerance[1]) + ',' + text_of(log.tolerance[2]));
    add("warming", log.warming);
    add("compensation", log.compensation);
    for (const auto& [number, name] : log.sensors) add("sensor", std::to_string(number) + ',' + name);
    if (const auto& its = log.artifact)
        add("artifact", std::to_string(its->sensor) + ',' + text_of(its->expansion) + ',' +
                            text_of(its->uncertainty) + ',' + text_of(its->fixed[0]) + ',' +
                            text_of(its->fixed[1]) + ',' + text_of(its->fixed[2]));
    for (const auto& [number, bore] : log.bores)
        add(bore.sphere ? "sphere" : "bore", std::to_string(number) + ',' + text_of(bore.place[0]) + ',' +
                                                 text_of(bore.place[1]) + ',' + text_of(bore.place[2]));
    return text;
}

struct Identity {
    int number = 0;        // 0 for none
    bool damaged = false;  // the number cannot be trusted, or it is no log
};

constexpr std::size_t identity_bytes = 64;

// By the first identity_bytes of a file, or all of a shorter one. One that breaks off here has no number: its
// test had not begun.
inline Identity identity_of(std::string_view text) {
    const bool breaks_off = text.size() < identity_bytes;
    LineChecksums checksums;
    const auto next = [&]() -> std::optional<std::string_view> {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return std::nullopt;
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    };
    const auto number_in = [](std::string_view line) {
        constexpr std::string_view key = "log,";
        if (line.substr(0, key.size()) != key) return 0;
        const auto value = csv::number(line.substr(key.size()));
        return value && *value >= 1 && *value <= 1e6 ? static_cast<int>(*value) : 0;
    };
    const auto first = next();
    if (!first) return {0, !breaks_off};
    if (checksums.checked(*first) != first_line) return {0, true};
    const auto second = next();
    if (!second) return {0, !breaks_off};
    const auto content = checksums.checked(*second);
    if (content) return {number_in(*content), false};
    return {number_in(second->substr(0, second->find(',', 4))), true};
}

// One line of a record without checksum, whose number counts from 1.
inline std::string line(const GrowthRecord& r, std::size_t number) {
    const auto join = [](std::initializer_list<std::string> fields) {
        std::string text;
        for (const std::string& field : fields) text += (text.empty() ? "" : ",") + field;
        return text + '\n';
    };
    const std::string n = std::to_string(number), time = text_of(r.time);
    if (r.kind == GrowthRecord::temperature)
        return join({"temperature", n, time, std::to_string(r.item), text_of(r.at[0]),
                     r.at[1] != 0 ? "1" : "0", text_of(r.at[2])});
    if (r.kind == GrowthRecord::speed) return join({"speed", n, time, text_of(r.at[0])});
    const auto bit = [](bool value) { return std::string(value ? "1" : "0"); };
    const std::string where = std::to_string(r.pass) + ',' + std::to_string(r.visit) + ',' +
                              std::to_string(r.bore) + ',' + bit(r.turned) + ',' + bit(r.compensated) + ',' +
                              bit(r.cooled);
    if (r.kind == GrowthRecord::event)
        return join(
            {"event", n, time, where, event_names[static_cast<std::size_t>(r.item - 1)], text_of(r.at[0])});
    static constexpr std::array<const char*, 7> sides{"-Z", "-Y", "-X", "?", "+X", "+Y", "+Z"};
    return join({"touch", n, time, where, sides[static_cast<std::size_t>(r.item + 3)], text_of(r.at[0]),
                 text_of(r.at[1]), text_of(r.at[2]), text_of(r.offset[0]), text_of(r.offset[1]),
                 text_of(r.offset[2])});
}

class Parser {
public:
    explicit Parser(const std::string& file) { log_.file = file; }

    GrowthLog parse(std::string_view text) {
        text = csv::without_byte_order_mark(text);
        if (text.empty()) refuse("is empty: it has no line 'growth-log,2'", false);
        while (!text.empty()) {
            ++line_;
            const std::size_t end = text.find('\n');
            const std::string_view whole = without_return(text.substr(0, end));
            if (line_ == 1) first(whole);
            if (end == std::string_view::npos) {
                take_torn(text);
                break;
            }
            text.remove_prefix(end + 1);
            const auto content = checksums_.checked(whole);
            if (!content) refuse_damaged();
            if (line_ > 1) take(*content);
        }
        if (log_.machine.empty()) refuse("has no line 'machine': its head is not complete", false);
        if (log_.records.empty()) refuse("has no record: the test has not begun", false);
        return std::move(log_);
    }

private:
    using Fields = std::vector<std::string_view>;

    static std::string_view without_return(std::string_view line) {
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }

    // A line that was not written to its end. One that was, and has another byte than a line feed, is
    // damaged.
    void take_torn(std::string_view line) {
        LineChecksums ahead = checksums_;
        if (ahead.checked(without_return(line.substr(0, line.size() - 1)))) refuse_damaged();
        log_.torn = "line " + std::to_string(line_) + " is not complete and was left out";
    }

    [[noreturn]] void refuse_damaged() const {
        refuse("does not fit its checksum: it was changed or is damaged" +
               (line_ > 1 ? "; the lines before it are whole: head -n " + std::to_string(line_ - 1)
                          : std::string()));
    }

    [[noreturn]] void refuse(const std::string& why, bool at_line = true) const {
        throw std::runtime_error(log_.file + (at_line ? ":" + std::to_string(line_) + ": " : ": ") + why);
    }

    void first(std::string_view line) const {
        const Fields fields = csv::split_at_commas(line);
        if (fields[0] != "growth-log" || fields.size() < 2)
            refuse("is no growth log: the first line is " + csv::quoted(fields[0]) + ", not 'growth-log,2'");
        if (fields[1] != "2")
            refuse("is of version " + csv::quoted(fields[1]) + "; this plumb reads version 2");
        if (fields.size() != 3) refuse("has no checksum, as a log has in each line");
    }

    double number(std::string_view field, const char* what) const {
        const auto value = csv::number(field);
        if (!value || !(std::abs(*value) <= 1e9)) refuse(std::string(what) + " is " + csv::quoted(field));
        return *value;
    }
    int whole(std::string_view field, const char* what, int least, int most) const {
        const double value = number(field, what);
        if (value != std::trunc(value) || value < least || value > most)
            refuse(std::string(what) + " is " + csv::quoted(field) + ", not a whole number from " +
                   std::to_string(least) + " to " + std::to_string(most));
        return static_cast<int>(value);
    }
    void need(const Fields& fields, std::size_t count) const {
        if (fields.size() != count)
            refuse("has " + std::to_string(fields.size()) + " fields; a line '" + std::string(fields[0]) +
                   "' has " + std::to_string(count));
    }

    void take(std::string_view line) {
        const Fields fields = csv::split_at_commas(line);
        const std::string_view key = fields[0];
        if (key == "touch" || key == "temperature" || key == "event" || key == "speed") return record(fields);
        if (!log_.records.empty())
            refuse(csv::quoted(key) + " among the records: two logs are mixed, or the file was changed");
        if (key == "machine")
            need(fields, 2), log_.machine = fields[1];
        else if (key == "log")
            need(fields, 2), log_.number = whole(fields[1], "the number of the log", 1, 1000000);
        else if (key == "begun")
            need(fields, 2), log_.begun = fields[1];
        else if (key == "warming")
            need(fields, 2), log_.warming = fields[1];
        else if (key == "compensation")
            need(fields, 2), log_.compensation = fields[1];
        else if (key == "table")
            need(fields, 2), log_.trunnion = fields[1] == "A";
        else if (key == "ball")
            need(fields, 2), log_.ball = number(fields[1], "the ball");
        else if (key == "unit") {
            need(fields, 2);
            log_.millimetres = number(fields[1], "the unit");
            if (!(log_.millimetres >= 1e-3 && log_.millimetres <= 1e3)) refuse("the unit is out of range");
        } else if (key == "tolerance") {
            need(fields, 4);
            for (std::size_t i = 0; i < 3; ++i) {
                log_.tolerance[i] = number(fields[i + 1], "the tolerance");
                if (!(log_.tolerance[i] > 0)) refuse("a tolerance is not positive");
            }
        } else if (key == "sensor") {
            need(fields, 3);
            log_.sensors[whole(fields[1], "the sensor", 1, 8)] = fields[2];
        } else if (key == "artifact") {
            need(fields, 7);
            GrowthLog::Artifact& its = log_.artifact.emplace(GrowthLog::Artifact{});
            its.sensor = whole(fields[1], "the sensor of the artifact", 1, 8);
            its.expansion = number(fields[2], "the expansion of the artifact");
            its.uncertainty = number(fields[3], "the uncertainty of this expansion");
            for (std::size_t i = 0; i < 3; ++i) its.fixed[i] = number(fields[i + 4], "the fixed point");
        } else if (key == "bore" || key == "sphere") {
            need(fields, 5);
            GrowthLog::Bore& bore = log_.bores[whole(fields[1], "the bore", 1, 16)];
            bore.sphere = key == "sphere";
            for (std::size_t i = 0; i < 3; ++i)
                bore.place[i] = number(fields[i + 2], "the place of the bore");
        } else {
            refuse("unknown line " + csv::quoted(key));
        }
    }

    void record(const Fields& fields) {
        GrowthRecord r;
        r.line = line_;
        const bool touch = fields[0] == "touch", event = fields[0] == "event", speed = fields[0] == "speed";
        need(fields, touch ? 16 : event ? 11 : speed ? 4 : 7);
        const int n = whole(fields[1], "the number of the record", 1, 1000000);
        const int expected = static_cast<int>(log_.records.size()) + 1;
        if (n != expected)
            refuse("record " + std::to_string(n) + " where record " + std::to_string(expected) +
                   " should be: lines are lost, or two logs are mixed");
        r.time = number(fields[2], "the time");
        if (r.time < 0 || (!log_.records.empty() && r.time < log_.records.back().time))
            refuse("the time runs backwards");
        if (speed) {
            r.kind = GrowthRecord::speed;
            r.at[0] = number(fields[3], "the speed");
            log_.records.push_back(r);
            return;
        }
        if (!touch && !event) {
            r.kind = GrowthRecord::temperature;
            r.item = whole(fields[3], "the sensor", 1, 8);
            r.at = {number(fields[4], "the temperature"), double(whole(fields[5], "valid", 0, 1)),
                    number(fields[6], "the age")};
            log_.records.push_back(r);
            return;
        }
        r.kind = touch ? GrowthRecord::touch : GrowthRecord::event;
        r.pass = whole(fields[3], "the pass", 0, 100000);
        r.visit = whole(fields[4], "the visit", 0, 1000000);
        r.bore = whole(fields[5], "the bore", 0, 16);
        r.turned = whole(fields[6], "turned", 0, 1) != 0;
        r.compensated = whole(fields[7], "compensated", 0, 1) != 0;
        r.cooled = whole(fields[8], "cooled", 0, 1) != 0;
        if (event) {
            for (std::size_t i = 0; i < event_names.size(); ++i)
                if (fields[9] == event_names[i]) r.item = static_cast<int>(i) + 1;
            if (r.item == 0) refuse("unknown event " + csv::quoted(fields[9]));
            r.at[0] = number(fields[10], "the number of the event");
        } else {
            const std::string_view side = fields[9];
            if (side.size() != 2 || (side[0] != '+' && side[0] != '-') || side[1] < 'X' || side[1] > 'Z')
                refuse("the direction is " + csv::quoted(side));
            r.item = (side[1] - 'X' + 1) * (side[0] == '+' ? 1 : -1);
            for (std::size_t i = 0; i < 3; ++i) {
                r.at[i] = number(fields[10 + i], "the position");
                r.offset[i] = number(fields[13 + i], "the compensation");
            }
        }
        if (log_.records.empty() && !(event && r.item == 1)) refuse("the first record is not 'begin'");
        log_.records.push_back(r);
    }

    GrowthLog log_;
    LineChecksums checksums_;
    int line_ = 0;
};

// The checksums behind the last of whole lines. Throws std::runtime_error with file and line.
inline LineChecksums checksums_of(std::string_view text, const std::string& file) {
    LineChecksums checksums;
    for (int line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size() - 1);
        std::string_view its = text.substr(0, end);
        if (!its.empty() && its.back() == '\r') its.remove_suffix(1);
        if (!checksums.checked(its))
            throw std::runtime_error(file + ':' + std::to_string(line) + ": does not fit its checksum");
        text.remove_prefix(end + 1);
    }
    return checksums;
}

// Throws std::runtime_error with file, line and reason.
inline GrowthLog parse(const std::string& text, const std::string& file) {
    return Parser(file).parse(text);
}

}  // namespace growth_log_file

// Throws std::runtime_error with file, line and reason.
inline GrowthLog read_growth_log(const std::filesystem::path& file) {
    return growth_log_file::parse(csv::text_of(file, growth_log_file::most_bytes), file.string());
}

}  // namespace plumb
