// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/command_manual.hpp"

#include <cctype>
#include <iostream>
#include <sstream>

#include "hal/markup.hpp"

namespace plumb::hal {

std::string command_manual(const CLI::App& command, const CommandPage& page) {
    std::string words = command.get_name();
    for (const CLI::App* parent = command.get_parent(); parent; parent = parent->get_parent())
        words = parent->get_name() + ' ' + words;
    std::string title = page.name;
    for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    std::ostringstream out;
    out << ".\\\" SPDX-License-Identifier: GPL-2.0-or-later\n"
        << ".TH " << title << " 1 " << RELEASE_DATE << " Plumb LinuxCNC\n"
        << ".SH NAME\n"
        << escaped(page.name) << " \\- " << escaped(command.get_description()) << '\n'
        << ".SH SYNOPSIS\n.B " << escaped(words) << '\n'
        << escaped(page.synopsis) << '\n';
    const auto write_option = [&](const CLI::Option* option) {
        const std::string name = escaped(option->get_name(option->get_positional(), true));
        const bool valued = option->get_items_expected_max() > 0 && !option->get_positional();
        out << ".TP\n.BI " << name;
        if (valued) out << " \" " << escaped(option->get_type_name()) << '"';
        out << '\n';
        write_description(out, option->get_description());
    };
    for (const auto& [heading, text] : page.sections) {
        out << ".SH " << heading << '\n';
        write_description(out, text);
        if (heading != "DESCRIPTION") continue;
        const auto subcommands = command.get_subcommands([](const CLI::App*) { return true; });
        if (!subcommands.empty()) out << ".SH COMMANDS\n";
        for (const CLI::App* subcommand : subcommands)
            out << ".TP\n.B " << escaped(subcommand->get_name()) << '\n'
                << escaped(subcommand->get_description()) << '\n';
        out << ".SH OPTIONS\n";
        for (const CLI::Option* option : command.get_options())
            if (!option->get_group().empty()) write_option(option);
    }
    out << ".SH SEE ALSO\n"
        << page.see_also << ",\n.BR plumb\\-glossary (7)\n.SH LICENSE\nGPL\\-2.0\\-or\\-later\n";
    return out.str();
}

void add_manual(CLI::App& command, CommandPage (*page)()) {
    command.add_flag_callback(
        "--man",
        [&command, page] {
            std::cout << command_manual(command, page());
            throw CLI::Success();
        },
        "Prints the manual page of this command, in man(7) markup.");
    command.get_option("--man")->trigger_on_parse();
}

}  // namespace plumb::hal
