// SPDX-License-Identifier: GPL-2.0-or-later
// A number for the wiring of a stage or a function: its signals, the joint, the drive and its scale, the
// unit, and the signs of its settings. Another angle, limit or rate does not change it.
#pragma once

#include "hal/wiring_list.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

class WiringIdentity {
public:
    // What the modules of Plumb declare.
    struct Modules {
        // Whether another sign of this setting turns the effect of the instance round.
        std::function<bool(const std::string& instance, const std::string& setting)> turns;
        // The options in the load line of the instance.
        std::function<std::string(const std::string& instance)> options;
    };

    WiringIdentity(const hal::WiringList& list, std::string interlock, const std::string& unit,
                   Modules modules)
        : list_(list), interlock_(std::move(interlock)), unit_("unit " + unit), modules_(std::move(modules)) {
        for (const hal::WiredPin& pin : list.pins) {
            if (pin.signal.empty()) continue;
            signals_[pin.signal].push_back(&pin);
        }
    }

    // 0 where the pin of interlock has no stage or function.
    std::int32_t of_stage(std::size_t number) const {
        const std::string name = writer_of("stage-state-" + std::to_string(number));
        return name.empty() ? 0 : number_of(stage_lines(name));
    }

    // `stages`: the numbers of those that take its offset.
    std::int32_t of_function(std::size_t number, const std::vector<std::size_t>& stages) const {
        const std::string name = reader_of("function-permit-" + std::to_string(number));
        if (name.empty()) return 0;
        Lines lines{unit_, name + " " + modules_.options(name)};
        for (const hal::WiredPin& pin : list_.pins) {
            const std::string setting = setting_of(pin, name);
            if (setting.empty()) continue;
            if (pin.signal.empty()) {
                if (!pin.writes && modules_.turns(name, setting))
                    lines.insert(setting + " " + sign_of(pin.value));
            } else if (!pin.writes) {
                add_writer(lines, setting, pin.signal);
            } else if (pin.is_real) {
                for (const hal::WiredPin* reader : signals_.at(pin.signal))
                    if (is_source(reader->name)) lines.insert(setting + " > " + instance_of(reader->name));
            }
        }
        for (const std::size_t stage : stages) lines.insert("stage " + std::to_string(of_stage(stage)));
        return number_of(lines);
    }

    // The source of stage `number` that is the offset of function `function`; -1 where there is none.
    std::int32_t source_of(std::size_t number, std::size_t function) const {
        const std::string stage = writer_of("stage-state-" + std::to_string(number));
        const std::string its = reader_of("function-permit-" + std::to_string(function));
        if (stage.empty() || its.empty()) return -1;
        for (const hal::WiredPin& pin : list_.pins) {
            if (pin.signal.empty() || instance_of(pin.name) != stage || !is_source(pin.name)) continue;
            for (const hal::WiredPin* other : signals_.at(pin.signal))
                if (other->writes && instance_of(other->name) == its)
                    return std::stoi(pin.name.substr(pin.name.rfind('-') + 1));
        }
        return -1;
    }

private:
    using Lines = std::set<std::string>;

    static std::string instance_of(const std::string& pin) { return pin.substr(0, pin.rfind('.')); }

    // The name of the pin in the instance; "" for a pin of another one.
    static std::string setting_of(const hal::WiredPin& pin, const std::string& instance) {
        return instance_of(pin.name) == instance ? pin.name.substr(instance.size() + 1) : "";
    }

    static bool is_source(const std::string& pin) { return pin.find(".offset-") != std::string::npos; }

    static bool ends_with(const std::string& text, const std::string& end) {
        return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
    }

    static const char* sign_of(double value) { return value > 0 ? "+" : value < 0 ? "-" : "0"; }

    // The instance at the other end of the signal at a pin of interlock.
    std::string writer_of(const std::string& pin) const { return other_end(pin, true); }
    std::string reader_of(const std::string& pin) const { return other_end(pin, false); }
    std::string other_end(const std::string& pin, bool writes) const {
        const std::string whole = interlock_ + "." + pin;
        const auto own = std::find_if(list_.pins.begin(), list_.pins.end(),
                                      [&](const hal::WiredPin& one) { return one.name == whole; });
        if (own == list_.pins.end() || own->signal.empty()) return "";
        for (const hal::WiredPin* other : signals_.at(own->signal)) {
            const bool is_end = writes ? other->writes : ends_with(other->name, ".permit");
            if (is_end && other->name != whole) return instance_of(other->name);
        }
        return "";
    }

    // What interlock itself writes depends on numbers that may change.
    void add_writer(Lines& lines, const std::string& setting, const std::string& signal) const {
        for (const hal::WiredPin* writer : signals_.at(signal))
            if (writer->writes) {
                if (instance_of(writer->name) != interlock_) lines.insert(setting + " < " + writer->name);
                return;
            }
        lines.insert(setting + " < signal " + signal);
    }

    Lines stage_lines(const std::string& name) const {
        Lines lines{unit_, name + " " + modules_.options(name)};
        for (const hal::WiredPin& pin : list_.pins) {
            const std::string setting = setting_of(pin, name);
            if (setting.empty() || pin.signal.empty() || is_source(pin.name)) continue;
            if (!pin.writes) add_writer(lines, setting, pin.signal);
            for (const hal::WiredPin* other : signals_.at(pin.signal)) {
                const bool of_motion =
                    other->name.rfind("joint.", 0) == 0 || other->name.rfind("axis.", 0) == 0;
                if (pin.writes && other != &pin && (pin.is_real || of_motion))
                    lines.insert(setting + " > " + other->name);
                if (pin.is_real && other->name != pin.name) add_scales(lines, instance_of(other->name));
            }
        }
        return lines;
    }

    // The scale of a drive has its unit and its sign.
    void add_scales(Lines& lines, const std::string& drive) const {
        const auto add = [&](const std::string& name, double value) {
            if (instance_of(name) != drive || name.find("scale", drive.size()) == std::string::npos) return;
            char text[40];
            std::snprintf(text, sizeof text, " = %.9g", value);
            lines.insert(name + text);
        };
        for (const hal::WiredPin& pin : list_.pins)
            if (!pin.writes && pin.signal.empty()) add(pin.name, pin.value);
        for (const hal::WiredParameter& parameter : list_.parameters) add(parameter.name, parameter.value);
    }

    // FNV-1a of the lines; never 0.
    static std::int32_t number_of(const Lines& lines) {
        std::uint32_t sum = 2166136261U;
        for (const std::string& line : lines)
            for (const char c : line + '\n') sum = (sum ^ static_cast<unsigned char>(c)) * 16777619U;
        return static_cast<std::int32_t>(sum ? sum : 1);
    }

    const hal::WiringList& list_;
    const std::string interlock_, unit_;
    const Modules modules_;
    std::map<std::string, std::vector<const hal::WiredPin*>> signals_;
};

}  // namespace plumb
