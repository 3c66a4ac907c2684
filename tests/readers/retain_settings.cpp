// SPDX-License-Identifier: GPL-2.0-or-later
// The TOML file of `plumb-retain`.
#include "tests/readers/reader.hpp"

#include "components/io/retain/retain_settings.hpp"

#include <set>
#include <stdexcept>

namespace plumb::readers {
namespace {

void read(std::string_view bytes) {
    const FileOf file(bytes);
    RetainSettings settings;
    if (!takes<std::runtime_error>([&] { settings = RetainSettings::read(file.path()); })) return;
    demand(!settings.machine.empty(), "a machine has a name");
    demand(settings.machine.find_first_of("\"\\\n") == std::string::npos,
           "the name of a machine fits into quotes");
    demand(settings.every >= 0.01 && settings.every <= 3600, "every lies in its range");
    demand(settings.store.is_absolute(), "the path of the store is absolute");
    for (const auto* list : {&settings.pins, &settings.records}) {
        demand(std::set<std::string>(list->begin(), list->end()).size() == list->size(),
               "no name is there twice");
        for (const std::string& name : *list)
            demand(retain_settings::hal_name(name), "a pin has a name of HAL's");
    }
    for (const std::string& path : settings.program)
        demand(path.front() == '/', "the path of a program is absolute");
}

const Reader reader{"retain_settings", read};

}  // namespace
}  // namespace plumb::readers
