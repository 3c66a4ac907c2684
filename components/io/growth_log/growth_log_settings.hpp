// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"
#include "components/io/files/toml_reader.hpp"

#include <filesystem>
#include <set>
#include <string>

namespace plumb {

// The settings in the TOML file of growth_log.
struct GrowthLogSettings {
    std::string component = "growth-test";
    std::filesystem::path folder;
    GrowthLog head;  // all but `begun`, and no records

    // Throws std::runtime_error with file, line and reason.
    static GrowthLogSettings read(const std::filesystem::path& file) {
        const toml::table table = TomlReader::parse(file);
        TomlReader reader(file, table);
        GrowthLogSettings settings;
        GrowthLog& head = settings.head;
        const auto text = [&](const std::string& key, const std::string& initial) {
            const std::string value = reader.text_or(key, initial);
            if (value.find(',') != std::string::npos) reader.refuse(key, "has a comma");
            return value;
        };
        head.machine = text("machine", reader.has("machine") ? "" : reader.text("machine"));
        settings.component = text("component", settings.component);
        settings.folder = reader.text("folder");
        if (!settings.folder.is_absolute()) settings.folder = file.parent_path() / settings.folder;
        head.millimetres = reader.number_or("unit", 1, 1e-3, 1e3);
        head.ball = reader.number_or("ball", head.ball, 0, 100);
        head.trunnion = reader.choice_or<bool>("table", false, {{"B", false}, {"A", true}});
        head.warming = reader.choice_or<std::string>(
            "warming", "spindle", {{"spindle", "spindle"}, {"axes", "axes"}, {"none", "none"}});
        head.compensation = text("compensation", head.compensation);
        if (reader.has("tolerance")) {
            TomlReader its = reader.table("tolerance");
            for (std::size_t i = 0; i < 3; ++i)
                head.tolerance[i] = its.number(std::string(1, "xyz"[i]), 1e-6, 10);
            its.end();
        }
        std::set<std::int64_t> seen;
        for (TomlReader its : reader.tables("sensor")) {
            const std::int64_t number = its.whole("number", 1, 8);
            if (!seen.insert(number).second) its.refuse("number", "is there twice");
            head.sensors[static_cast<int>(number)] = its.text("name", 40);
            if (head.sensors[static_cast<int>(number)].find(',') != std::string::npos)
                its.refuse("name", "has a comma");
            its.end();
        }
        for (TomlReader its : reader.tables("bore")) {
            const int number = static_cast<int>(its.whole("number", 1, 16));
            if (head.bores.count(number) != 0) its.refuse("number", "is there twice");
            for (std::size_t i = 0; i < 3; ++i)
                head.bores[number].place[i] = its.number(std::string(1, "xyz"[i]), -1e5, 1e5);
            head.bores[number].sphere =
                its.choice_or<bool>("kind", false, {{"bore", false}, {"sphere", true}});
            its.end();
        }
        if (reader.has("artifact")) {
            TomlReader its = reader.table("artifact");
            GrowthLog::Artifact& artifact = head.artifact.emplace();
            artifact.sensor = static_cast<int>(its.whole("sensor", 1, 8));
            artifact.expansion = its.number_or("expansion", artifact.expansion, -5, 50);
            artifact.uncertainty = its.number_or("uncertainty", artifact.uncertainty, 0, 20);
            TomlReader fixed = its.table("fixed");
            for (std::size_t i = 0; i < 3; ++i)
                artifact.fixed[i] = fixed.number(std::string(1, "xyz"[i]), -1e5, 1e5);
            fixed.end();
            its.end();
        }
        reader.end();
        return settings;
    }
};

}  // namespace plumb
