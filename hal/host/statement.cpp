// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/statement.hpp"

#include <stdexcept>

namespace plumb::host {

Statement parse_statement(const std::string& text) {
    Statement statement;
    std::map<std::string, std::string> variable_of;
    std::size_t at = 0;
    for (std::size_t brace = text.find('{'); brace != std::string::npos; brace = text.find('{', at)) {
        const std::size_t end = text.find('}', brace);
        if (end == std::string::npos) throw std::invalid_argument("'" + text + "' has a { without a }");
        const std::string name = text.substr(brace + 1, end - brace - 1);
        if (name.empty()) throw std::invalid_argument("'" + text + "' has no name between { and }");
        const auto [known, is_new] = variable_of.emplace(name, "v" + std::to_string(variable_of.size()));
        if (is_new) statement.variables[known->second] = name;
        statement.expression += text.substr(at, brace - at) + known->second;
        at = end + 1;
    }
    if (variable_of.empty())
        throw std::invalid_argument("'" + text +
                                    "' names no pin; its name stands in braces, as in {filter.out} < 1");
    statement.expression += text.substr(at);
    return statement;
}

}  // namespace plumb::host
