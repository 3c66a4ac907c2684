// SPDX-License-Identifier: GPL-2.0-or-later
#include <CLI/Error.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>
#include <stdexcept>
#include <vector>

#include "components/commissioning/quantity_text.hpp"
#include "components/commissioning/squareness/squareness_document.hpp"
#include "components/commissioning/squareness/squareness_wording.hpp"

namespace plumb::commissioning {
namespace {

using Json = nlohmann::ordered_json;

constexpr int deepest = 8;
constexpr std::size_t longest = 1 << 20;  // bytes
constexpr std::size_t most_items = 100;   // of a list

[[noreturn]] void refuse(const std::string& where, const std::string& why) {
    throw std::runtime_error(where + ": " + why);
}

// Refuses a key that an object has twice, of which other readers take one or the other.
Json parsed(std::string_view text) {
    if (text.size() > longest) refuse("the document", "it has more than 1 MB");
    std::vector<std::set<std::string>> keys;
    const auto each = [&](int depth, Json::parse_event_t event, Json& value) {
        if (depth > deepest) refuse("the document", "its lists and objects are too deep");
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end) keys.pop_back();
        if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
            refuse(value.get<std::string>(), "it is there twice");
        return true;
    };
    try {
        return Json::parse(text.begin(), text.end(), each);
    } catch (const Json::exception& error) {
        const std::string why = error.what();
        refuse("no JSON", why.substr(why.find("] ") == std::string::npos ? 0 : why.find("] ") + 2));
    }
}

// An object whose keys are known.
class Object {
public:
    // Keeps a reference to the JSON.
    Object(std::string where, const Json& json, std::initializer_list<const char*> keys)
        : where_(std::move(where)), json_(json) {
        if (!json.is_object()) refuse(named(), "it is no object { }");
        std::string all;
        for (const char* key : keys) all += (all.empty() ? "" : ", ") + std::string(key);
        for (const auto& [key, value] : json.items())
            if (std::find(keys.begin(), keys.end(), key) == keys.end())
                refuse(named(), "there is no '" + key + "'; there are " + all);
    }

    std::string place(const std::string& key) const { return where_.empty() ? key : where_ + '.' + key; }
    std::string named() const { return where_.empty() ? "the document" : where_; }
    bool has(const std::string& key) const { return json_.contains(key); }
    const Json& at(const std::string& key) const {
        if (!has(key)) refuse(named(), key + " is missing");
        return json_.at(key);
    }

    std::string text(const std::string& key) const {
        const Json& value = at(key);
        if (!value.is_string()) refuse(place(key), "it is no text");
        const std::string text = value.get<std::string>();
        if (std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < ' '; }))
            refuse(place(key), "the text has a control character");
        return text;
    }
    std::string text(const std::string& key, const std::string& initial) const {
        return has(key) ? text(key) : initial;
    }
    // One of the words, from 0.
    int word(const std::string& key, std::initializer_list<const char*> words) const {
        if (!has(key)) return 0;
        const std::string is = text(key);
        const auto* const found = std::find(words.begin(), words.end(), is);
        if (found == words.end()) {
            std::string all;
            for (const char* const each : words) all += (all.empty() ? "" : " or ") + std::string(each);
            refuse(place(key), "'" + is + "' is not " + all);
        }
        return static_cast<int>(found - words.begin());
    }
    // A text with its unit, or a number in the unit.
    std::string quantity(const std::string& key, const char* unit) const {
        return at(key).is_number() ? number(place(key), at(key), unit) : text(key);
    }
    // The same, or a list of numbers.
    std::string quantities(const std::string& key, const char* unit) const {
        if (!at(key).is_array()) return quantity(key, unit);
        std::string all;
        for (const Json& each : at(key)) {
            if (!each.is_number()) refuse(place(key), "the list has something that is no number");
            all += (all.empty() ? "" : ":") + number(place(key), each, unit);
        }
        return all;
    }
    template <class Each>
    void each(const std::string& key, Each take) const {
        if (!has(key)) return;
        const Json& list = at(key);
        if (!list.is_array()) refuse(place(key), "it is no list [ ]");
        if (list.size() > most_items)
            refuse(place(key), "it has more than " + std::to_string(most_items) + " items");
        for (std::size_t i = 0; i < list.size(); ++i)
            take(place(key) + '[' + std::to_string(i) + ']', list[i]);
    }

private:
    static std::string number(const std::string& where, const Json& json, const char* unit) {
        const double value = json.get<double>();
        if (!std::isfinite(value)) refuse(where, "it is no finite number");
        return formatted("%.17g", value) + unit;
    }

    std::string where_;
    const Json& json_;
};

// U is twice u.
std::string standard(const Object& object) {
    if (object.has("u") && object.has("U"))
        refuse(object.named(), "one of u, the standard uncertainty, and U, which is twice that, is wanted");
    if (object.has("u")) return object.quantity("u", "rad");
    if (!object.has("U")) return "";
    try {
        return formatted("%.17grad", angle_of(object.quantity("U", "rad")) / 2);
    } catch (const std::invalid_argument& error) {
        refuse(object.place("U"), error.what());
    }
}

SquarenessGiven::Angle angle_in(const Object& object, const char* name) {
    return {object.named(), object.text(name), object.quantity("angle", "rad"), standard(object)};
}

void read_measurement(const std::string& where, const Json& json, SquarenessGiven& given) {
    if (!json.is_object() || !json.contains("by"))
        refuse(where, "by is missing: square, diagonals, opening or points");
    const Json by{{"by", json["by"]}};
    const Object any(where, by, {"by"});
    const int kind = any.word("by", {"square", "diagonals", "opening", "points"});
    const auto read = [&](const Object& object, std::initializer_list<const char*> texts,
                          std::initializer_list<const char*> lengths,
                          std::initializer_list<const char*> angles) {
        SquarenessGiven::Fields fields{where, {}, ""};
        for (const char* key : texts)
            if (object.has(key)) fields.fields.emplace_back(key, object.text(key));
        for (const char* key : lengths)
            if (object.has(key)) fields.fields.emplace_back(key, object.quantities(key, "mm"));
        for (const char* key : angles)
            if (object.has(key)) fields.fields.emplace_back(key, object.quantity(key, "rad"));
        return fields;
    };
    if (kind == 0)
        given.squares.push_back(
            read(Object(where, json, {"by", "move", "plunger", "at", "reads", "turned", "u", "U", "own-u"}),
                 {"move", "plunger"}, {"at", "reads", "turned", "u", "U"}, {"own-u"}));
    else if (kind == 1)
        given.diagonals.push_back(
            read(Object(where, json,
                        {"by", "plane", "object", "rising", "falling", "sides", "u", "U", "own", "own-u"}),
                 {"plane", "object"}, {"rising", "falling", "sides", "u", "U"}, {"own", "own-u"}));
    else if (kind == 2)
        given.openings.push_back(read(Object(where, json, {"by", "plane", "object", "angle", "u", "U"}),
                                      {"plane", "object"}, {}, {"angle", "u", "U"}));
    else  // own-u is a length for a ring
        given.points.push_back(read(Object(where, json, {"by", "file", "object", "unit", "u", "U", "own-u"}),
                                    {"file", "object", "unit", "own-u"}, {"u", "U"}, {}));
}

SquarenessOptions read(const Json& json) {
    const Object all("", json,
                     {"chain", "unit", "reading", "against", "datum", "travel", "directions", "frame",
                      "correction", "leans", "in_force", "measurements"});
    SquarenessOptions options;
    SquarenessGiven given;
    given.chain = {"chain", all.text("chain")};
    given.datum = {"datum", all.text("datum", "")};
    given.travel = {"travel", all.has("travel") ? all.quantity("travel", "mm") : ""};
    given.directions = {"directions", all.text("directions", "")};
    options.machine.inch = all.word("unit", {"mm", "inch"}) == 1;
    options.machine.reading = all.word("reading", {"component", "axis-direction"}) == 0
                                  ? TiltReading::component
                                  : TiltReading::axis_direction;
    options.machine.against = all.word("against", {"rail", "bed"}) == 0 ? TiltDatum::rail : TiltDatum::bed;
    all.each("leans", [&](const std::string& where, const Json& each) {
        const Object lean(where, each, {"lean", "name", "angle", "u", "U"});
        if (lean.has("lean") == lean.has("name"))
            refuse(where, "one of lean, such as Y+X, and name, such as EC0Y, is wanted");
        (lean.has("lean") ? given.leans : given.quantities)
            .push_back(angle_in(lean, lean.has("lean") ? "lean" : "name"));
    });
    all.each("in_force", [&](const std::string& where, const Json& each) {
        given.in_force.push_back(angle_in(Object(where, each, {"name", "angle", "u", "U"}), "name"));
    });
    all.each("measurements",
             [&](const std::string& where, const Json& each) { read_measurement(where, each, given); });
    const bool found = !given.leans.empty() || !given.quantities.empty() || !given.squares.empty() ||
                       !given.diagonals.empty() || !given.openings.empty() || !given.points.empty();
    if (found && !given.in_force.empty() && !all.has("correction"))
        refuse("correction", "it is missing: on if the angles in force acted as you measured, or off");
    options.machine.measured_with_correction = all.word("correction", {"on", "off"}) == 0;
    options.frame = static_cast<MachineFrame>(all.word("frame", {"any", "column", "portal"}));
    take_squareness(given, options);
    return options;
}

}  // namespace

SquarenessOptions read_squareness_document(std::string_view text) {
    const Json json = parsed(text);
    try {
        const bool output = json.is_object() && json.contains("input");
        return read(output ? json["input"] : json);
    } catch (const CLI::ValidationError& error) {
        throw std::runtime_error(error.what());
    }
}

}  // namespace plumb::commissioning
