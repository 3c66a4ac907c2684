// SPDX-License-Identifier: GPL-2.0-or-later
// Writes a component's manual page from the same declarations that create its pins, functions and options.
#pragma once

#include "hal/component.hpp"

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb::hal {

// Builds an instance without HAL and keeps its declarations.
class Declarations : public Registrar {
public:
    // With options that have other values than their initial ones.
    explicit Declarations(const Model& model, std::map<std::string, std::string> given = {})
        : given_(std::move(given)), instance_(model.make(*this)) {}

    Slot add(const PinInfo& pin) override {
        pins.push_back(pin);
        cells_.emplace_back();
        return Slot(&slots_.emplace_back(&cells_.back()));
    }
    void add(Function& function) override { functions.push_back(&function); }
    std::string add(const OptionInfo& option) override {
        options.push_back(option);
        const auto value = given_.find(option.name);
        return value == given_.end() ? option.initial : value->second;
    }
    void add(const OffsetInfo& offset) override { offsets.push_back(offset); }
    void add(const CodesInfo& info) override { codes.push_back(info); }
    void add(const StatusInfo& info) override { statuses.push_back(info); }
    void add(const TurningInfo& info) override { turning.push_back(info.pin); }
    void add(const EffectInfo& info) override { effects.push_back(info); }
    void add(const ToldInfo& info) override { told.push_back(info); }

    std::vector<PinInfo> pins;
    std::vector<const Function*> functions;  // live as long as this object
    std::vector<OptionInfo> options;
    std::vector<OffsetInfo> offsets;
    std::vector<CodesInfo> codes;
    std::vector<StatusInfo> statuses;  // one, of a function or a stage
    std::vector<std::string> turning;
    std::vector<EffectInfo> effects;
    std::vector<ToldInfo> told;

private:
    const std::map<std::string, std::string> given_;
    std::deque<double> cells_;
    std::deque<void*> slots_;
    std::unique_ptr<Component> instance_;
};

// With the pins that options bring, too.
class AllDeclarations final : public Declarations {
public:
    explicit AllDeclarations(const Model& model);
};

// Whether a pin has a default that depends on the unit of the machine.
inline bool has_length_default(const PinInfo& pin) {
    return !pin.output && pin.initial != 0 && is_length(pin.unit);
}

// A manual page in man(7) markup: section 9 for a realtime module, 1 for a program, which has no functions,
// and a load line under SYNOPSIS.
std::string manual(const Model& model, int section);

// The manual page plumb-glossary(7): the text of GLOSSARY.md below its heading.
std::string glossary(const std::string& text);

// The declarations as JSON, for programs: pins, outputs that move an axis, codes and their sentences,
// options, functions.
std::string declarations(const Model& model);

}  // namespace plumb::hal
