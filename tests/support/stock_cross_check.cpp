// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/stock_cross_check.hpp"

#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <set>
#include <sstream>
#include <stdexcept>

namespace plumb {
namespace {

const char* const dump = "/tmp/bin/hal_stream_dump";

// The file's lines but `start`, which must follow the recorder's.
std::string without_start(const std::string& text) {
    std::istringstream lines(text);
    std::string result;
    for (std::string line; std::getline(lines, line);)
        if (line.substr(0, line.find_last_not_of(" \t") + 1) != "start") result += line + '\n';
    return result;
}

struct Recorder {
    std::string types;     // one letter a name
    std::string commands;  // that make the sampler take them
};

client::Start on_machine() {
    client::Start start;
    start.executable = host_of_machine;
    return start;
}

// A pin that is netted is sampled through its signal, any other through a signal of its own.
Recorder recorder_of(const std::string& hal_file, const std::vector<std::string>& names, std::size_t depth,
                     const std::string& thread) {
    client::Client host(on_machine());
    host.source(hal_file);
    Recorder recorder;
    std::string nets;
    for (std::size_t i = 0; i < names.size(); ++i) {
        recorder.types += host.read(names[i]).type.front();
        std::istringstream row(host.halcmd({"-s", "show", "pin", names[i]}).output);
        std::string signal;
        std::string source;
        for (std::string word; row >> word;) {  // owner type direction value name [arrow signal]
            if (word == names[i]) source = names[i];
            if (word == "==>" || word == "<==" || word == "<=>") row >> signal;
        }
        if (source.empty()) signal = names[i];
        if (signal.empty()) {
            signal = "recorded-" + std::to_string(i);
            nets += "net " + signal + " " + source + "\n";
        }
        nets += "net " + signal + " => sampler.0.pin." + std::to_string(i) + "\n";
    }
    recorder.commands = "loadrt sampler depth=" + std::to_string(depth) + " cfg=" + recorder.types + "\n" +
                        nets + "addf sampler.0 " + thread + "\n";
    return recorder;
}

std::vector<std::int64_t> read_records(const std::string& file) {
    const std::string bytes = contents(file);
    std::vector<std::int64_t> cells(bytes.size() / sizeof(std::int64_t));
    std::memcpy(cells.data(), bytes.data(), cells.size() * sizeof(std::int64_t));
    return cells;
}

std::string shown(std::int64_t bits, char type) {
    if (type != 'f') return std::to_string(bits);
    double value;
    std::memcpy(&value, &bits, sizeof value);
    std::ostringstream text;
    text << std::setprecision(17) << value;
    return text.str();
}

void compare(const std::vector<std::string>& names, const std::string& types, std::size_t count) {
    const auto stock = read_records("/tmp/stock.records");
    const auto virtual_time = read_records("/tmp/virtual.records");
    const std::size_t width = names.size() + 1;
    ASSERT_EQ(stock.size(), count * width);
    ASSERT_EQ(virtual_time.size(), count * width);
    for (std::size_t column = 0; column < width; ++column) {
        const std::string name = column ? names[column - 1] : "number of the record";
        const char type = column ? types[column - 1] : 'u';
        std::set<std::int64_t> different;
        for (std::size_t row = 0; row < count; ++row) {
            const std::int64_t a = stock[row * width + column];
            const std::int64_t b = virtual_time[row * width + column];
            different.insert(a);
            if (a == b) continue;
            ADD_FAILURE() << name << " differs from record " << row << " on: stock " << shown(a, type)
                          << ", virtual " << shown(b, type);
            break;
        }
        EXPECT_GT(different.size(), 1u) << name << " never changes";
    }
}

}  // namespace

void expect_same_records(const std::filesystem::path& hal_file, const std::vector<std::string>& names,
                         double seconds, const std::string& thread) {
    const std::string file = without_start(contents(hal_file));
    const auto count = static_cast<std::size_t>(std::lround(seconds * 1000));
    MachineOptions machine;
    machine.as_root = false;  // a stock realtime does not run where root is the only user
    machine.modules = build_folder() + "/modules";
    machine.programs = {build_folder() + "/specimens/hal_stream_dump"};
    on_own_machine(
        [&] {
            std::ofstream("/tmp/file.hal") << file;
            const Recorder recorder = recorder_of("/tmp/file.hal", names, count + 1000, thread);
            const auto dumping = [&](const char* records) {
                return std::string("loadusr -w ") + dump + " " + recorder.types + " " +
                       std::to_string(count) + " " + records;
            };
            std::ofstream("/tmp/recorded.hal") << file << recorder.commands << "start\n";

            client::Client host(on_machine());
            host.source("/tmp/recorded.hal");
            host.run(client::seconds(seconds + 0.5));
            host.command(dumping("/tmp/virtual.records"));

            std::ofstream("/tmp/stock.hal")
                << contents("/tmp/recorded.hal") << dumping("/tmp/stock.records") << "\n";
            setenv("RTAPI_UID", "65534", 1);  // a user for the realtime, which root must name
            ASSERT_EQ(std::system("halrun -f /tmp/stock.hal >/tmp/halrun.log 2>&1"), 0)
                << contents("/tmp/halrun.log");
            compare(names, recorder.types, count);
        },
        machine);
}

}  // namespace plumb
