// SPDX-License-Identifier: GPL-2.0-or-later
// Statements of `plumb bench --expect`, as muParser evaluates those that are taken.
#include "hal/host/statement.hpp"

#include "tests/readers/reader.hpp"

#include <muParser.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace plumb::readers {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A pin whose name begins with b is a bit.
bool is_bit(const std::string& name) {
    return name.front() == 'b';
}

struct Value {
    double now = 0, rate = 0;
};

void demand_statement(const host::Statement& statement) {
    std::map<std::string, Value> values;
    mu::Parser parser;
    parser.DefineFun("finite", [](double x) { return std::isfinite(x) ? 1.0 : 0.0; });
    for (const auto& [variable, name] : statement.variables) {
        parser.DefineVar(variable, &values[variable].now);
        parser.DefineVar(variable + "_rate", &values[variable].rate);
    }
    parser.SetExpr(statement.expression);
    const std::array<double, 7> numbers{0, 1, -2.5, 1e300, infinity, -infinity, std::nan("")};
    for (std::size_t round = 0; round < 2 * numbers.size(); ++round) {
        std::size_t i = round;
        for (auto& [variable, value] : values) {
            value.now =
                is_bit(statement.variables.at(variable)) ? static_cast<double>(i % 2) : numbers[i % 7];
            value.rate = numbers[++i % 7];
        }
        const auto before = values;
        const double holds = parser.Eval();
        demand(holds == 0 || holds == 1, "a statement is true or false");
        for (const auto& [variable, value] : values) {
            const Value& earlier = before.at(variable);
            const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
            demand(same(value.now, earlier.now) && same(value.rate, earlier.rate),
                   "a statement changes nothing");
        }
    }
}

void read(std::string_view bytes) {
    host::Statement statement;
    if (!takes<std::invalid_argument>([&] { statement = host::parse_statement(std::string(bytes)); })) return;
    demand(!statement.variables.empty(), "a statement is about a pin");
    if (!takes<std::invalid_argument>([&] {
            host::require_statement(statement.expression, [&](const std::string& word) {
                for (const auto& [variable, name] : statement.variables) {
                    if (word == variable) return is_bit(name) ? host::Variable::bit : host::Variable::number;
                    if (word == variable + "_rate") return host::Variable::number;
                }
                return host::Variable::unknown;
            });
        }))
        return;
    try {
        demand_statement(statement);
    } catch (const mu::Parser::exception_type&) {  // an unknown function, or too many arguments
    }
}

const Reader reader{"statement", read};

}  // namespace
}  // namespace plumb::readers
