// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/manual.hpp"

#include <sstream>

namespace plumb::hal {
namespace {

// Text for man(7): no character of it is taken for markup.
std::string escaped(const std::string& text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const bool line_begins = i == 0 || text[i - 1] == '\n';
        if (line_begins && (c == '.' || c == '\'')) result += "\\&";
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else if (c == '^')
            result += "\\(ha";
        else if (c == '~')
            result += "\\(ti";
        else
            result += c;
    }
    return result;
}

// Paragraphs are filled; a run of lines that begin with a blank keeps its shape.
void write_description(std::ostream& out, const std::string& text) {
    std::istringstream lines(text);
    bool verbatim = false;
    bool pending_gap = false;
    bool first = true;
    for (std::string line; std::getline(lines, line);) {
        if (line.find_first_not_of(' ') == std::string::npos) {
            pending_gap = !first;
            continue;
        }
        const bool shaped = line.front() == ' ';
        if (shaped != verbatim) {
            out << (shaped ? ".PP\n.EX\n" : ".EE\n.PP\n");
        } else if (pending_gap) {
            out << (verbatim ? "\n" : ".PP\n");
        }
        pending_gap = false;
        verbatim = shaped;
        first = false;
        out << escaped(line) << '\n';
    }
    if (verbatim) out << ".EE\n";
}

std::string initial(const PinInfo& pin) {
    if (pin.type == Type::bit) return pin.initial != 0 ? "true" : "false";
    std::ostringstream text;
    text << pin.initial;
    return text.str();
}

void write_pins(std::ostream& out, const Declarations& declared, bool output) {
    for (const PinInfo& pin : declared.pins) {
        if (pin.output != output) continue;
        out << ".TP\n.BI NAME ." << escaped(pin.name) << "\n.RI ( " << type_name(pin.type);
        if (!pin.unit.empty()) out << " \", " << escaped(pin.unit) << '"';
        if (!output) out << " \", default " << escaped(initial(pin)) << '"';
        out << " )\n.br\n" << escaped(pin.doc) << '\n';
    }
}

}  // namespace

std::string manual(const Model& model, int section) {
    const Declarations declared(model);
    const std::string name = escaped(model.about.name);
    std::ostringstream out;
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
    out << "\n.SH DESCRIPTION\n";
    write_description(out, model.about.description);
    if (!declared.options.empty()) {
        out << ".SH OPTIONS\nGiven when the component is loaded"
            << (section == 9 ? ", one value per instance, separated by commas.\n" : ".\n");
        for (const OptionInfo& option : declared.options)
            out << ".TP\n.B " << escaped(option.name)
                << "\n(default: " << (option.initial.empty() ? "none" : escaped(option.initial)) << ")\n.br\n"
                << escaped(option.doc) << '\n';
    }
    if (section == 9) {
        out << ".SH FUNCTIONS\nIn the order of a thread:\n";
        for (const Function* function : declared.functions)
            out << ".TP\n.BI NAME ." << escaped(function->name) << '\n' << escaped(function->place) << '\n';
    }
    out << ".SH PINS\nInputs, each with its default; unit mu is the machine's unit of length:\n";
    write_pins(out, declared, false);
    out << ".PP\nOutputs:\n";
    write_pins(out, declared, true);
    out << ".SH LICENSE\nGPL\\-2.0\\-or\\-later\n";
    return out.str();
}

}  // namespace plumb::hal
