// SPDX-License-Identifier: GPL-2.0-or-later
// The command line of `plumb squareness`, a word a line, and its advice.
#include "tests/readers/reader.hpp"

#include "components/commissioning/squareness/squareness_arguments.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    constexpr std::size_t most_words = 40;
    std::istringstream lines{std::string(bytes)};
    std::vector<std::string> words;
    for (std::string word; words.size() < most_words && std::getline(lines, word);) words.push_back(word);
    std::reverse(words.begin(), words.end());  // as CLI11 wants them
    commissioning::SquarenessOptions options;
    if (!takes<CLI::ParseError>([&] {
            CLI::App command("reader");
            command.set_help_flag();
            commissioning::declare_squareness(command, options);
            command.parse(words);
        }))
        return;
    for (const auto& measured : options.measured) {
        demand(std::isfinite(measured.corner.opening), "a measured angle is a number");
        options.machine.measured.push_back(measured.corner);
    }
    commissioning::SquarenessAdvice advice;
    if (!takes<std::invalid_argument>([&] { advice = commissioning::advice_on(options.machine); })) return;
    for (const SquarenessQuantity& quantity : advice.quantities)
        demand(std::abs(quantity.angle) < 1, "an advised angle is a small number");
    for (const auto& setting : advice.settings) demand(!setting.value.empty(), "a setting has a value");
    for (const auto& move : advice.moves) demand(std::isfinite(move.rise), "a test move has a number");
}

const Reader reader{"squareness", read};

}  // namespace
}  // namespace plumb::readers
