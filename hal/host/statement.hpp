// SPDX-License-Identifier: GPL-2.0-or-later
// Statements about pins as users write them on a command line: the name of a pin, parameter or signal stands
// in braces, as in abs({filter.out}) <= 1 && abs({filter.out}_rate) < 20.
#pragma once

#include <map>
#include <string>

namespace plumb::host {

struct Statement {
    std::string expression;                        // with variables in the place of names
    std::map<std::string, std::string> variables;  // to names
};

// Throws std::invalid_argument when a brace is not closed, or there is no name in one, or in the whole text.
Statement parse_statement(const std::string& text);

}  // namespace plumb::host
