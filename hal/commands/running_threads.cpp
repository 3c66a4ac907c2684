// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/commands/running_threads.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

namespace plumb::commands {
namespace {

// Places of a module's functions, by name without the instance's. Nothing if the file cannot be read.
using Places = std::map<std::string, hal::Place>;

std::optional<Places> declared_places(const std::filesystem::path& file) try {
    Places result;
    std::ifstream in(file);
    const nlohmann::json functions = nlohmann::json::parse(in).at("functions");
    for (const auto& [name, its] : functions.items())
        result[name] = hal::place_named(its.at("place").get<std::string>());
    return result;
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

// function: INSTANCE.NAME
hal::Place place_in(const Places& places, const std::string& function) {
    for (const auto& [name, place] : places) {
        const std::string end = '.' + name;
        if (function.size() > end.size() &&
            function.compare(function.size() - end.size(), end.size(), end) == 0)
            return place;
    }
    return hal::Place::none;
}

}  // namespace

RunningThreads running_threads(const std::string& threads, const std::string& functions,
                               const std::filesystem::path& declarations,
                               const std::vector<std::string>& modules) {
    RunningThreads result;
    std::map<std::string, std::optional<Places>> declared;  // by module
    Places place_of;                                        // by whole name
    std::istringstream lines(functions);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string module, code, argument, floating_point, name;
        int users = 0;
        if (!(words >> module >> code >> argument >> floating_point >> users >> name)) continue;
        hal::Place place = hal::place_of_linuxcnc(name);
        if (std::find(modules.begin(), modules.end(), module) != modules.end()) {
            if (declared.count(module) == 0) {
                const std::filesystem::path file = declarations / (module + ".json");
                declared[module] = declared_places(file);
                if (!declared[module]) result.undeclared.push_back(file);
            }
            if (const auto& its = declared[module]) place = place_in(*its, name);
        }
        place_of[name] = place;
        if (users == 0) result.idle.push_back({name, place});
    }
    lines = std::istringstream(threads);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string first, floating_point, thread, time, longest;
        words >> first;
        if (words >> floating_point >> thread >> time >> longest)
            result.threads.push_back({thread, {}});
        else if (result.threads.empty() || first.empty())
            continue;
        else  // LinuxCNC 2.10 shows each function on a line of its own
            result.threads.back().functions.push_back({first, place_of[first]});
        for (std::string name; words >> name;)
            result.threads.back().functions.push_back({name, place_of[name]});
    }
    return result;
}

}  // namespace plumb::commands
