// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/statement.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

namespace plumb::host {

namespace {

constexpr std::size_t longest = 10'000;  // characters of a statement
constexpr int deepest = 100;             // brackets within each other

[[noreturn]] void refuse(const std::string& why) {
    throw std::invalid_argument(why);
}

std::string shown(std::string_view text) {
    constexpr std::size_t most = 60;
    std::string result = "'";
    for (const char c : text.substr(0, most)) result += c >= ' ' && c <= '~' ? c : '?';
    return result + (text.size() > most ? "...'" : "'");
}

bool digit(char c) {
    return c >= '0' && c <= '9';
}

bool letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

// A name of a command line is a variable as it stands: {filter.out}, {filter.out}_rate.
bool in_braces(std::string_view name) {
    return !name.empty() && name.front() == '{';
}

// Follows the grammar of muParser, and distinguishes statements from numbers.
class StatementReader {
public:
    StatementReader(std::string_view text, const std::function<Variable(const std::string&)>& variable)
        : text_(text), variable_(variable) {}

    void read() {
        if (text_.size() > longest)
            refuse("it has " + std::to_string(text_.size()) + " characters, at most " +
                   std::to_string(longest) + " are possible");
        const Operand all = choice();
        if (here() == ',') refuse_comma();
        if (at_ != text_.size()) unexpected();
        if (!about_pin_) refuse("it is about no pin, so it always holds or never");
        if (all.kind != Kind::statement)
            refuse("its value is a number, which would always hold unless it is 0; compare it, as in x <= 5");
    }

private:
    enum class Kind {
        number,
        constant,
        statement
    };  // constant: 0 or 1, which may stand for a statement in a choice
    struct Operand {
        Kind kind;
        std::string_view text;
    };

    Operand choice() {
        if (++depth_ > deepest)
            refuse("its brackets or choices are nested more than " + std::to_string(deepest) + " deep");
        const std::size_t from = start();
        Operand operand = disjunction();
        if (take("?")) {
            need_statement(operand, "?");
            const Operand yes = choice();
            if (!take(":")) refuse("after the ? in " + shown(text_.substr(from)) + " a : is missing");
            const Operand no = choice();
            operand = since(from, choice_of(yes.kind, no.kind));
        }
        --depth_;
        return operand;
    }

    static Kind choice_of(Kind yes, Kind no) {
        if (yes == Kind::number || no == Kind::number) return Kind::number;
        return yes == Kind::constant && no == Kind::constant ? Kind::constant : Kind::statement;
    }

    Operand disjunction() {
        return joined("||", [this] { return joined("&&", [this] { return comparison(); }); });
    }

    template <class Next>
    Operand joined(const char* mark, Next next) {
        const std::size_t from = start();
        Operand operand = next();
        while (take(mark)) {
            need_statement(operand, mark);
            need_statement(next(), mark);
            operand = since(from, Kind::statement);
        }
        return operand;
    }

    static void need_statement(const Operand& operand, const std::string& mark) {
        if (operand.kind != Kind::statement)
            refuse(shown(operand.text) + " beside " + mark + " is a number; compare it, as in x <= 5");
    }

    Operand comparison() {
        const std::size_t from = start();
        const Operand operand = sum();
        if (!take_comparison()) return operand;
        sum();
        const Operand all = since(from, Kind::statement);
        if (take_comparison())
            refuse(shown(all.text) +
                   " is compared once more; join two comparisons by &&, as in 0 < x && x < 5");
        return all;
    }

    bool take_comparison() {
        for (const char* mark : {"<=", ">=", "==", "!=", "<", ">"})
            if (take(mark)) return true;
        if (here() == '=') refuse("= assigns a value, which always holds; write == to compare, as in x == 5");
        return false;
    }

    Operand sum() {
        return computed({"+", "-"}, [this] {
            return computed({"*", "/"}, [this] {
                return computed({"^", "^"}, [this] { return with_sign(); });
            });
        });
    }

    template <class Next>
    Operand computed(const std::array<const char*, 2>& marks, Next next) {
        const std::size_t from = start();
        Operand operand = next();
        while (take(marks[0]) || take(marks[1])) {
            next();
            operand = since(from, Kind::number);
        }
        return operand;
    }

    Operand with_sign() {
        const std::size_t from = start();
        if (!take("-") && !take("+")) return primary();
        primary();
        return since(from, Kind::number);
    }

    Operand primary() {
        const std::size_t from = start();
        if (take("(")) {
            const Kind kind = choice().kind;
            if (here() == ',') refuse_comma();
            if (!take(")")) refuse("a ) is missing in " + shown(text_.substr(from)));
            return since(from, kind);
        }
        if (digit(here()) || here() == '.') {
            number();
            const Operand all = since(from, Kind::number);
            return all.text == "0" || all.text == "1" ? since(from, Kind::constant) : all;
        }
        const std::string word = name();
        return take("(") ? call(from, word) : variable(from, word);
    }

    Operand call(std::size_t from, const std::string& function) {
        if (in_braces(function)) refuse(function + " is no function");
        do choice();
        while (take(","));
        if (!take(")")) refuse("a ) is missing in " + shown(text_.substr(from)));
        return since(from, function == "finite" ? Kind::statement : Kind::number);
    }

    Operand variable(std::size_t from, const std::string& word) {
        if (word == "_pi" || word == "_e") return since(from, Kind::number);
        const Variable found = variable_(word);
        if (found == Variable::unknown)
            refuse(shown(word) + " is unknown; there are pins, and functions such as abs(x)");
        about_pin_ = true;
        return since(from, found == Variable::bit ? Kind::statement : Kind::number);
    }

    void digits() {
        while (digit(here_exactly())) ++at_;
    }

    void number() {
        const std::size_t from = at_;
        digits();
        if (here_exactly() == '.') ++at_;
        digits();
        if (here_exactly() == 'e' || here_exactly() == 'E') {
            ++at_;
            if (here_exactly() == '+' || here_exactly() == '-') ++at_;
            digits();
        }
        if (letter(here_exactly()) || here_exactly() == '{' || here_exactly() == '.' ||
            !digit_or_point(text_[at_ - 1]))
            refuse(shown(text_.substr(from)) + " is no number");
    }

    static bool digit_or_point(char c) { return digit(c) || c == '.'; }

    std::string name() {
        const std::size_t from = start();
        if (here() == '{') {
            const std::size_t end = text_.find('}', at_);
            if (end == std::string_view::npos) unexpected();
            at_ = end + 1;
        } else if (!letter(here())) {
            unexpected();
        }
        while (letter(here_exactly()) || digit(here_exactly())) ++at_;
        return std::string(text_.substr(from, at_ - from));
    }

    [[noreturn]] void unexpected() {
        if (start() == text_.size()) refuse("it breaks off");
        if (here() == '!') refuse("there is no !; not is == 0, as in x == 0");
        if (here() == '=') take_comparison();
        refuse("it is not understood from " + shown(text_.substr(at_)) + " on");
    }

    [[noreturn]] static void refuse_comma() {
        refuse(
            "a comma stands between the arguments of a function only; join statements by &&, as in 0 < x && "
            "x < 5");
    }

    // Where the next word begins.
    std::size_t start() {
        while (at_ < text_.size() && text_[at_] > 0 && text_[at_] <= ' ') ++at_;
        return at_;
    }
    char here() {
        start();
        return here_exactly();
    }
    char here_exactly() const { return at_ < text_.size() ? text_[at_] : '\0'; }

    bool take(std::string_view mark) {
        start();
        if (text_.substr(at_, mark.size()) != mark) return false;
        at_ += mark.size();
        return true;
    }

    Operand since(std::size_t from, Kind kind) const {
        const std::string_view text = text_.substr(from, at_ - from);
        return {kind, text.substr(0, text.find_last_not_of(" \t\r\n") + 1)};
    }

    const std::string_view text_;
    const std::function<Variable(const std::string&)>& variable_;
    std::size_t at_ = 0;
    int depth_ = 0;
    bool about_pin_ = false;  // rather than numbers alone
};

}  // namespace

void require_statement(const std::string& expression,
                       const std::function<Variable(const std::string&)>& variable) {
    StatementReader(expression, variable).read();
}

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
    try {
        require_statement(text, [](const std::string& word) {
            if (!in_braces(word)) return Variable::unknown;
            const std::string behind = word.substr(word.find('}') + 1);
            if (behind.empty()) return Variable::bit;  // it may be one; the host knows
            return behind == "_rate" ? Variable::number : Variable::unknown;
        });
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("'" + text + "': " + error.what());
    }
    return statement;
}

}  // namespace plumb::host
