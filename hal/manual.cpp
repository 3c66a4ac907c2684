// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/manual.hpp"

#include "hal/effect.hpp"
#include "hal/markup.hpp"
#include "hal/page.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <tuple>
#include <vector>

namespace plumb::hal {
namespace {

std::string initial(const PinInfo& pin) {
    if (pin.type == Type::bit) return pin.initial != 0 ? "true" : "false";
    std::ostringstream text;
    text << pin.initial;
    if (pin.initial != 0 && is_length(pin.unit)) text << ' ' << default_unit(pin.unit);
    return text.str();
}

// "0 to 1"; "" of an input that accepts all values.
std::string range_of(const PinInfo& pin) {
    const Range& range = pin.setting.range;
    std::ostringstream text;
    if (std::isfinite(range.least) && std::isfinite(range.most))
        text << range.least << " to " << range.most;
    else if (std::isfinite(range.least))
        text << "at least " << range.least;
    else if (std::isfinite(range.most))
        text << "at most " << range.most;
    return text.str();
}

// Pins that differ by the letter of an axis or by a number: they stand together.
using Family = std::vector<const PinInfo*>;

bool are_of_a_family(const PinInfo& one, const PinInfo& other) {
    const auto facts = [](const PinInfo& pin) {
        const std::string& name = pin.each_name;
        const std::string stem = name.substr(0, name.find_last_not_of("0123456789") + 1);
        return std::make_tuple(stem, pin.each_doc, pin.type, pin.unit, pin.initial, pin.setting.level,
                               pin.setting.range.least, pin.setting.range.most);
    };
    return one.output == other.output && facts(one) == facts(other);
}

std::vector<Family> families(const Declarations& declared, bool output, Level level = Level::signal) {
    std::vector<Family> result;
    for (const PinInfo& pin : declared.pins) {
        if (pin.output != output || pin.setting.level != level) continue;
        const auto its = std::find_if(result.begin(), result.end(), [&](const Family& family) {
            return are_of_a_family(*family.front(), pin);
        });
        if (its == result.end())
            result.push_back({&pin});
        else
            its->push_back(&pin);
    }
    return result;
}

std::string names_of(const Family& family) {
    std::string text;
    for (const PinInfo* pin : family) text += (text.empty() ? "" : ", ") + pin->name;
    return escaped(wrapped(text));
}

// The condition of the last pin of a family, as a sentence for all.
std::string condition_of(const PinInfo& last, std::size_t number) {
    const std::string& condition = last.only_with;
    if (condition.empty()) return "";
    const std::size_t count = condition.find(">="), axis = condition.rfind(" in ");
    if (count != std::string::npos && number > 1)
        return " The option " + condition.substr(0, count) + " is their number.";
    if (axis != std::string::npos && number > 1)
        return " An axis in " + condition.substr(axis + 4) + " has it.";
    return " Only with " + condition + '.';
}

// L is the letter of the axis, where there are several.
std::string sentence_of(const Family& family) {
    const PinInfo& pin = *family.front();
    std::string text = family.size() == 1 || pin.doc == family.back()->doc ? pin.doc : pin.each_doc;
    if (text != pin.doc) std::replace(text.begin(), text.end(), '%', 'L');
    return escaped(wrapped(text + condition_of(*family.back(), family.size())));
}

void write_pins(std::ostream& out, const Declarations& declared, bool output) {
    const char* paragraph = "";
    for (const Family& family : families(declared, output)) {
        const PinInfo& pin = *family.front();
        const std::string range = range_of(pin);
        out << paragraph << "\\fB" << names_of(family) << "\\fR\n.RI ( " << type_name(pin.type);
        if (!pin.unit.empty()) out << " \", " << escaped(pin.unit) << '"';
        if (!output) out << " \", default " << escaped(initial(pin)) << '"';
        if (!range.empty()) out << " \", " << escaped(range) << '"';
        out << " )\n.RS\n" << sentence_of(family) << "\n.RE\n";
        paragraph = ".PP\n";
    }
}

// The effect of a setting on the axes, as a sentence.
std::string acts(const Declarations& declared, const PinInfo& pin) {
    for (const EffectInfo& info : declared.effects) {
        if (info.pin != pin.name) continue;
        if (info.effect == std::string(name(Effect::at_once))) return " Acts at once.";
        if (info.effect == std::string(name(Effect::next_cycle))) return " Acts at the next cycle.";
        if (info.effect == std::string(name(Effect::in_no_cycle))) return " Refused while a cycle runs.";
    }
    return "";
}

// Settings of a level: two lines of a table each.
void write_settings(std::ostream& out, const Declarations& declared, Level level) {
    out << ".TS\nl l l l.\nSetting\tUnit\tDefault\tRange\n";
    for (const Family& family : families(declared, false, level)) {
        const PinInfo& pin = *family.front();
        const bool one = family.size() == 1;
        if (!one) out << ".T&\nlB s s s.\nT{\n" << names_of(family) << "\nT}\n";
        out << ".T&\nlB l l l.\n"
            << (one ? escaped(pin.name) : "") << '\t' << escaped(pin.unit) << '\t' << escaped(initial(pin))
            << '\t' << escaped(range_of(pin)) << "\n.T&\nl s s s.\nT{\n"
            << sentence_of(family) << acts(declared, pin) << "\nT}\n";
    }
    out << ".TE\n";
}

// What holds of an output that moves an axis.
std::string moves(const OffsetInfo& offset) {
    std::ostringstream out;
    if (!offset.counts.empty()) out << "Counts of " << escaped(offset.scale) << " each. ";
    out << "The offset" << (offset.guest.empty() ? "" : ", without " + escaped(offset.guest) + ',')
        << " never grows beyond " << escaped(offset.bound) << " either way, and changes by at most "
        << escaped(offset.rate) << (offset.motion.empty() ? "" : " apart from motion");
    if (!offset.acceleration.empty()) {
        out << ", its speed by at most ";
        if (offset.times != 1) out << offset.times << " times ";
        out << escaped(offset.acceleration);
    }
    out << ". ";
    if (!offset.turning_rate.empty())
        out << "Where motion turns, it changes besides by at most " << escaped(offset.turning_rate)
            << ", its speed by at most " << escaped(offset.turning_acceleration) << ". ";
    if (!offset.driven.empty())
        out << "While " << escaped(offset.driven) << " is false, and when " << escaped(offset.homed)
            << " rises, it may be at once where its axis is. ";
    if (!offset.accelerated_by.empty()) out << escaped(offset.accelerated_by) << ' ';
    out << "While a bound keeps it from its wanted value, " << escaped(offset.limited) << " is true.\n";
    return out.str();
}

void write_offsets(std::ostream& out, const Declarations& declared) {
    if (declared.offsets.empty()) return;
    out << ".SH MOVES AN AXIS\n";
    std::string last;
    for (const OffsetInfo& offset : declared.offsets) {
        const std::string text = moves(offset);
        if (!last.empty() && text != last) out << last;
        out << (text == last ? ".TQ\n.B " : ".TP\n.B ")
            << escaped(offset.counts.empty() ? offset.value : offset.counts) << '\n';
        last = text;
    }
    out << last;
}

bool is_status(const Declarations& declared, const CodesInfo& code) {
    return std::any_of(declared.statuses.begin(), declared.statuses.end(),
                       [&](const StatusInfo& info) { return info.pin == code.pin; });
}

// A list that several pins have stands once.
void write_codes(std::ostream& out, const Declarations& declared) {
    for (auto each = declared.codes.begin(); each != declared.codes.end(); ++each) {
        const CodesInfo& code = *each;
        if (is_status(declared, code)) continue;
        const auto same = std::find_if(declared.codes.begin(), each, [&](const CodesInfo& earlier) {
            return earlier.sentences == code.sentences;
        });
        if (same != each) {
            out << ".PP\n" << escaped(code.pin) << " has the codes of " << escaped(same->pin) << ".\n";
            continue;
        }
        out << (code.pin == "fault-code" ? ".SH FAULTS\n" : ".SH CODES OF " + escaped(code.pin) + "\n");
        for (const auto& [number, text] : code.sentences)
            out << ".TP 4\n" << number << '\n' << escaped(text) << '\n';
    }
}

const char* told_as(Tell tell) {
    return tell == Tell::error ? "an error" : "a text";
}

// Each status with its kind and its remedy.
void write_statuses(std::ostream& out, const Declarations& declared) {
    for (const StatusInfo& info : declared.statuses) {
        out << ".SH STATUS\nNumbers of " << escaped(info.pin)
            << ". A status is good, wait, off, warn or bad; attention is true with warn and bad. "
               "linuxcnc_link tells those that are marked.\n";
        for (const auto& [number, its] : info.statuses) {
            out << ".TP 4\n" << number << "\n(" << name(its.kind);
            if (tell(its) != Tell::never) out << ", " << told_as(tell(its));
            if (its.after > 0) out << " after " << its.after << " s";
            out << ") " << escaped(its.sentence) << ' ' << escaped(its.remedy) << '\n';
        }
    }
}

void write_told(std::ostream& out, const Declarations& declared) {
    if (declared.told.empty()) return;
    out << ".SH MESSAGES\nlinuxcnc_link tells them when a bit rises.\n";
    for (const ToldInfo& told : declared.told)
        out << ".TP\n.BI NAME ." << escaped(told.pin) << '\n' << escaped(told.sentence) << '\n';
}

void write_section(std::ostream& out, const Page& page, const std::string& heading) {
    const std::string text = page.section(heading);
    if (text.empty()) return;
    const bool one_word = heading.find(' ') == std::string::npos;
    out << ".SH " << (one_word ? heading : '"' + heading + '"') << '\n';
    write_description(out, text);
}

// Pages are named in a text: halcmd(1), motion(9). The glossary is one of them.
void write_see_also(std::ostream& out, const std::string& pages) {
    out << ".SH SEE ALSO\n";
    std::istringstream words(pages);
    for (std::string page; words >> page;) {
        const std::size_t bracket = page.find('(');
        if (page.back() != ',') page += ',';
        out << ".BR " << escaped(page.substr(0, bracket)) << ' ' << page.substr(bracket) << '\n';
    }
    out << ".BR plumb\\-glossary (7)\n";
}

void write_options(std::ostream& out, const Declarations& declared, int section) {
    if (declared.options.empty()) return;
    out << ".SH OPTIONS\nGiven when the component is loaded"
        << (section == 9 ? ", one value for each instance, separated by commas, or one for all.\n" : ".\n");
    for (const OptionInfo& option : declared.options)
        out << ".TP\n.B " << escaped(option.name)
            << "\n(default: " << (option.initial.empty() ? "none" : escaped(option.initial)) << ")\n.br\n"
            << escaped(option.doc) << '\n';
}

void write_tasks(std::ostream& out, const Model& model) {
    if (!model.without_hal) return;
    out << ".SH \"WITHOUT HAL\"\n";
    for (const WithoutHal* task = model.without_hal; task->name; ++task)
        out << ".TP\n.BI " << escaped(model.about.name) << " \" \\-\\-" << task->name << " \" FILE\n"
            << escaped(task->sentence) << '\n';
}

void write_functions(std::ostream& out, const Declarations& declared) {
    out << ".SH FUNCTIONS\nIn the order of a thread:\n";
    for (const Function* function : declared.functions)
        out << ".TP\n.BI NAME ." << escaped(function->name) << '\n' << escaped(function->sentence) << '\n';
}

// A sentence, where a default is a length.
std::string unit_of_defaults(const Declarations& declared) {
    const bool converts = std::any_of(declared.options.begin(), declared.options.end(),
                                      [](const OptionInfo& option) { return option.name == length_option; });
    if (!std::any_of(declared.pins.begin(), declared.pins.end(), has_length_default)) return "";
    return converts ? "With the option unit a default in mm is converted to the machine unit.\n"
                    : "Use it on a machine in mm only: the defaults of lengths are not converted.\n";
}

bool has_settings(const Declarations& declared, Level level) {
    return std::any_of(declared.pins.begin(), declared.pins.end(),
                       [&](const PinInfo& pin) { return pin.setting.level == level; });
}

// The first settings that a user reads, beside the wiring.
void write_required_settings(std::ostream& out, const Declarations& declared) {
    if (!has_settings(declared, Level::must)) return;
    out << ".SH \"REQUIRED SETTINGS\"\n";
    write_settings(out, declared, Level::must);
}

void write_other_settings(std::ostream& out, const Declarations& declared) {
    if (has_settings(declared, Level::machine)) {
        out << ".SH \"SETTINGS OF THE MACHINE\"\n";
        write_settings(out, declared, Level::machine);
    }
    if (has_settings(declared, Level::expert)) {
        out << ".SH \"SETTINGS FOR EXPERTS\"\nThe defaults fit nearly all machines.\n";
        write_settings(out, declared, Level::expert);
    }
}

void write_all_pins(std::ostream& out, const Declarations& declared) {
    const auto& pins = declared.pins;
    out << ".SH PINS\nThe name of the instance and a dot precede each name. L is the letter of the axis.\n";
    if (std::any_of(pins.begin(), pins.end(), [](const PinInfo& pin) { return !pin.output; })) {
        out << "The unit mu is the machine unit of length.\n" << unit_of_defaults(declared) << ".SS Inputs\n";
        write_pins(out, declared, false);
    }
    out << ".SS Outputs\n";
    write_pins(out, declared, true);
}

// The options of a load line for an Other: "VALUE OPTION=VALUE".
std::map<std::string, std::string> given_for(const OptionInfo& option, const Other& other) {
    std::map<std::string, std::string> given;
    std::istringstream words(option.name + '=' + other.value);
    for (std::string word; words >> word;) {
        const std::size_t sign = word.find('=');
        given[word.substr(0, sign)] = word.substr(sign + 1);
    }
    return given;
}

std::string condition_of(const OptionInfo& option, const Other& other) {
    if (option.counts) return option.name + ">=" + other.value;
    return other.only_with.empty() ? option.name + '=' + other.value : other.only_with;
}

// Adds those of `others` whose key is not there.
template <class T, class Key>
void merge(std::vector<T>& all, const std::vector<T>& others, Key key) {
    for (const T& other : others)
        if (std::none_of(all.begin(), all.end(), [&](const T& each) { return key(each) == key(other); }))
            all.push_back(other);
}

}  // namespace

AllDeclarations::AllDeclarations(const Model& model) : Declarations(model) {
    const std::size_t by_default = pins.size();
    for (const OptionInfo& option : options) {
        std::map<std::string, std::string> conditions;  // by pin
        for (const Other& other : option.others) {
            const Declarations its(model, given_for(option, other));
            const std::string condition = condition_of(option, other);
            for (const PinInfo& pin : its.pins) {
                std::string& known = conditions[pin.name];
                if (known.empty())
                    known = condition;
                else if (!option.counts)
                    known += " or " + condition;
            }
            const auto name = [](const auto& pin) { return pin.name; };
            const auto pin = [](const auto& info) { return info.pin; };
            merge(pins, its.pins, name);
            merge(effects, its.effects, pin);
            merge(offsets, its.offsets, [](const auto& info) { return info.value; });
            merge(turning, its.turning, [](const auto& each) { return each; });
        }
        for (std::size_t i = 0; i < pins.size(); ++i) {
            const auto known = conditions.find(pins[i].name);
            if (known == conditions.end() || !pins[i].only_with.empty()) continue;
            const bool always =
                option.counts ? known->second == condition_of(option, option.others.front()) : i < by_default;
            if (!always) pins[i].only_with = known->second;
        }
    }
}

std::string manual(const Model& model, int section) {
    const AllDeclarations declared(model);
    const Page page(model.about.page);
    const std::string name = escaped(model.about.name);
    std::ostringstream out;
    if (has_settings(declared, Level::must) || has_settings(declared, Level::machine) ||
        has_settings(declared, Level::expert))
        out << "'\\\" t\n";  // man(1) calls tbl(1)
    out << ".\\\" SPDX-License-Identifier: GPL-2.0-or-later\n"
        << ".TH \"" << model.about.name << "\" \"" << section << "\" \"\" \"Plumb\" \"HAL component\"\n"
        << ".SH NAME\n"
        << name << " \\- " << escaped(model.about.summary) << "\n.SH SYNOPSIS\n";
    if (section == 9) {
        out << ".B loadrt " << name << "\n.RI [ count=N | names=a,b,... ]";
    } else {
        out << ".B loadusr \\-W " << name << "\n.RI [ name ] \" [\" \\-\\-period \" seconds]\"";
    }
    for (const OptionInfo& option : declared.options)
        if (section == 9)
            out << "\n.RI [ " << escaped(option.name) << "=value,... ]";
        else
            out << "\n.RI [ \\-\\-" << escaped(option.name) << " \" value]\"";
    out << '\n';
    write_section(out, page, "DESCRIPTION");
    write_section(out, page, "WIRING");
    write_required_settings(out, declared);
    write_section(out, page, "SETTING UP");
    write_section(out, page, "BEHAVIOUR");
    write_options(out, declared, section);
    write_tasks(out, model);
    if (section == 9) write_functions(out, declared);
    write_all_pins(out, declared);
    write_other_settings(out, declared);
    write_offsets(out, declared);
    write_statuses(out, declared);
    write_told(out, declared);
    write_codes(out, declared);
    write_section(out, page, "LIMITS");
    if (section == 9)
        out << ".SH UNLOADING\nStop the threads first:\n.IP\n.nf\nhalcmd stop\nhalcmd unloadrt " << name
            << "\n.fi\n.PP\nLinuxCNC does not wait for a running function. If you unload any component "
               "while the threads run, you can kill\n.BR rtapi_app .\n";
    write_see_also(out, page.section("SEE ALSO"));
    out << ".SH LICENSE\nGPL\\-2.0\\-or\\-later\n";
    return out.str();
}

std::string glossary(const std::string& text) {
    std::ostringstream out;
    out << ".\\\" SPDX-License-Identifier: GPL-2.0-or-later\n"
        << ".TH PLUMB\\-GLOSSARY 7 \"\" Plumb LinuxCNC\n"
        << ".SH NAME\nplumb\\-glossary \\- the words of Plumb's pages, messages and screens\n.SH "
           "DESCRIPTION\n";
    write_description(out, text.substr(text.find('\n') + 1));
    out << ".SH SEE ALSO\n.BR plumb (1)\n.SH LICENSE\nGPL\\-2.0\\-or\\-later\n";
    return out.str();
}

std::string declarations(const Model& model) {
    const AllDeclarations declared(model);
    nlohmann::ordered_json result{{"name", model.about.name}, {"summary", model.about.summary}};
    if (*model.about.title) result["title"] = model.about.title;
    if (model.role != Role::none) result["role"] = name(model.role);
    for (const auto& pin : declared.pins) {
        nlohmann::ordered_json& entry = result["pins"][pin.name];
        entry = {{"type", type_name(pin.type)},
                 {"output", pin.output},
                 {"unit", pin.unit},
                 {"default", pin.initial},
                 {"sentence", pin.doc}};
        if (!pin.output && is_length(pin.unit)) entry["default_unit"] = default_unit(pin.unit);
        const Range& range = pin.setting.range;
        if (pin.setting.level != Level::signal) entry["level"] = name(pin.setting.level);
        if (std::isfinite(range.least)) entry["minimum"] = range.least;
        if (std::isfinite(range.most)) entry["maximum"] = range.most;
        if (!pin.only_with.empty()) entry["only_with"] = pin.only_with;
    }
    for (const auto& code : declared.codes)
        for (const auto& [number, sentence] : code.sentences)
            result["codes"][code.pin][std::to_string(number)] = sentence;
    for (const auto& info : declared.statuses)
        for (const auto& [number, its] : info.statuses)
            result["statuses"][std::to_string(number)] = {
                {"kind", name(its.kind)},     {"sentence", its.sentence}, {"remedy", its.remedy},
                {"button", name(its.button)}, {"detail", its.detail},     {"size", its.size},
                {"tell", name(tell(its))},    {"after", its.after}};
    for (const ToldInfo& told : declared.told)
        result["told"][told.pin] = {{"tell", told.tell}, {"sentence", told.sentence}};
    for (const auto& offset : declared.offsets) {
        nlohmann::ordered_json& entry = result["moves"][offset.counts.empty() ? offset.value : offset.counts];
        entry = {{"bound", offset.bound}, {"rate", offset.rate}, {"limited", offset.limited}};
        if (!offset.follows_while.empty()) entry["follows_while"] = offset.follows_while;
        if (offset.at_next_cycle) entry["at_next_cycle"] = true;
        if (offset.acceleration.empty()) {
            entry["accelerated_by"] = offset.accelerated_by;
        } else {
            entry["acceleration"] = offset.acceleration;
            entry["times"] = offset.times;
        }
        if (!offset.turning_rate.empty())
            entry["turning"] = {{"rate", offset.turning_rate}, {"acceleration", offset.turning_acceleration}};
    }
    for (const auto& pin : declared.turning) result["pins"][pin]["turns"] = true;
    for (const auto& [pin, effect] : declared.effects) result["pins"][pin]["effect"] = effect;
    for (const auto& option : declared.options)
        result["options"][option.name] = {{"sentence", option.doc}, {"default", option.initial}};
    for (const auto* function : declared.functions) {
        nlohmann::ordered_json& entry = result["functions"][function->name];
        entry = {{"sentence", function->sentence}, {"place", info(function->place).name}};
        if (info(function->place).in_its_thread) entry["thread"] = info(Place::motion).name;
        for (const PlaceInfo& other : places) {
            if (goes_before(other.place, function->place)) entry["after"].push_back(other.name);
            if (goes_before(function->place, other.place)) entry["before"].push_back(other.name);
        }
    }
    return result.dump(1) + '\n';
}

}  // namespace plumb::hal
