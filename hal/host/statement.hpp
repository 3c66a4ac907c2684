// SPDX-License-Identifier: GPL-2.0-or-later
// Statements about pins, in muParser's language: a comparison, a bit, finite(x), or several of them joined
// by && and ||. On a command line the name of a pin, parameter or signal stands in braces:
//
//     abs({filter.out}) <= 1 && abs({filter.out}_rate) < 20
#pragma once

#include <functional>
#include <map>
#include <string>

namespace plumb::host {

struct Statement {
    std::string expression;                        // with variables in the place of names
    std::map<std::string, std::string> variables;  // to names
};

// Throws std::invalid_argument, with the text and an example, when a brace is not closed, there is no name in
// one or in the whole text, or the text can be no statement.
Statement parse_statement(const std::string& text);

// The use of a variable in a statement: a bit is a statement by itself, a number has to be compared.
enum class Variable { unknown, number, bit };

// Throws std::invalid_argument, with the reason and an example, unless the expression is a statement. It
// must be true or false, so that it can fail, and must change nothing. muParser itself takes any number for
// a statement.
void require_statement(const std::string& expression,
                       const std::function<Variable(const std::string& name)>& variable);

}  // namespace plumb::host
