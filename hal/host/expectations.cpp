// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/expectations.hpp"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/host/scheduler.hpp"
#include "hal/host/statement.hpp"

namespace plumb::host {

namespace {

double finite(double x) {
    return std::isfinite(x) ? 1.0 : 0.0;
}

struct Quantity {
    std::string name;
    std::string of;  // pin, parameter or signal
    Cell cell;
    double value;
    double rate;
};

}  // namespace

struct Expectations::Statement {
    std::string id;
    std::vector<Quantity> variables;
    mu::Parser parser;
    Nanoseconds last;   // the instant of the values
    bool lost = false;  // one of its names is gone
    Violation violation;
};

Expectations::Expectations() = default;
Expectations::~Expectations() = default;

void Expectations::add(const std::string& id, const std::string& expression,
                       const std::map<std::string, std::string>& variables, const Names& names) {
    auto statement = std::make_unique<Statement>();
    statement->id = id;
    statement->last = scheduler().time();
    statement->violation = {id, 0, 0, {}};
    for (const auto& [name, of] : variables) {
        const Cell cell = names.need(of);
        statement->variables.push_back({name, of, cell, cell.value.number(), 0.0});
    }
    try {
        require_statement(expression, [&](const std::string& word) {
            for (const Quantity& variable : statement->variables)
                if (variable.name == word)
                    return variable.cell.value.type() == hal::AnyValue::Type::bit ? Variable::bit
                                                                                  : Variable::number;
            for (const Quantity& variable : statement->variables)
                if (variable.name + "_rate" == word) return Variable::number;
            return Variable::unknown;
        });
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error("'" + expression + "': " + error.what());
    }
    try {
        statement->parser.DefineFun("finite", finite);
        for (Quantity& variable : statement->variables) {
            statement->parser.DefineVar(variable.name, &variable.value);
            statement->parser.DefineVar(variable.name + "_rate", &variable.rate);
        }
        statement->parser.SetExpr(expression);
        statement->parser.Eval();
    } catch (const mu::Parser::exception_type& error) {
        throw std::runtime_error("'" + expression + "': " + error.GetMsg());
    }
    const auto same = std::find_if(statements_.begin(), statements_.end(),
                                   [&](const std::unique_ptr<Statement>& each) { return each->id == id; });
    if (same == statements_.end())
        statements_.push_back(std::move(statement));
    else
        *same = std::move(statement);
}

void Expectations::resolve(const Names& names) {
    for (const auto& statement : statements_)
        for (Quantity& variable : statement->variables) variable.cell = names.need(variable.of);
}

void Expectations::drop_lost(const Names& names) {
    for (const auto& statement : statements_) {
        for (Quantity& variable : statement->variables) {
            const std::optional<Cell> cell = names.find(variable.of);
            statement->lost = statement->lost || !cell;
            if (cell) variable.cell = *cell;
        }
    }
}

void Expectations::lose_all() {
    for (const auto& statement : statements_) statement->lost = true;
}

void Expectations::check(Nanoseconds instant) {
    for (const auto& statement : statements_) {
        if (statement->lost) continue;
        const double elapsed =
            static_cast<double>(instant - statement->last) / static_cast<double>(one_second);
        statement->last = instant;
        for (Quantity& variable : statement->variables) {
            const double value = variable.cell.value.number();
            variable.rate = elapsed > 0.0 ? (value - variable.value) / elapsed : 0.0;
            variable.value = value;
        }
        const double holds = statement->parser.Eval();
        if (holds != 0.0 && !std::isnan(holds)) continue;
        Violation& violation = statement->violation;
        if (violation.count++ == 0) {
            violation.first_time = instant;
            for (const Quantity& variable : statement->variables) {
                violation.values[variable.name] = variable.value;
                const std::string rate = variable.name + "_rate";
                if (statement->parser.GetUsedVar().count(rate) > 0) violation.values[rate] = variable.rate;
            }
        }
    }
}

std::vector<Violation> Expectations::violations() const {
    std::vector<Violation> found;
    for (const auto& statement : statements_)
        if (statement->violation.count > 0) found.push_back(statement->violation);
    return found;
}

}  // namespace plumb::host
