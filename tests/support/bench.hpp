// SPDX-License-Identifier: GPL-2.0-or-later
// The fixture of tests that run on the real HAL in virtual time.
//
//     Bench bench;                                    // a host with servo-thread, 1 ms, started
//     bench.command("loadrt lowpass names=filter");   // a line of a .hal file
//     bench.command("addf filter servo-thread");
//     bench.expect("abs(out) <= 1", {{"out", "filter.out"}});   // in every period
//     bench.set("filter.in", 1);
//     bench.run(600);                                 // seconds, in a moment
//     EXPECT_NEAR(bench.get("filter.out"), 1, 1e-9);
#pragma once

#include "hal/client/client.hpp"
#include "tests/support/folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plumb {

inline constexpr double um = 1e-3;  // one micrometre, in millimetres

// A recording: one row a sample, one column a name.
struct Table {
    std::vector<std::string> names;  // "time", in seconds, is the first
    std::vector<std::vector<double>> rows;

    // Throws std::out_of_range for a name that was not recorded.
    std::vector<double> column(const std::string& name) const;
};

// A CSV file as the host writes it. Throws std::runtime_error with file and line if it is malformed.
Table read_table(const std::filesystem::path& file);

// For a host that finds the modules of the tests, too.
client::Start with_specimens(bool guard = false);

class Bench {
public:
    enum class Thread { servo, none };  // none: for .hal files that make their own and start it

    explicit Bench(Thread thread = Thread::servo, const client::Start& start = {});

    // A line of a .hal file, or a whole .hal file. Throws with HAL's message if HAL refuses it.
    void command(const std::string& line) { client_.command(line); }
    void source(const std::filesystem::path& file, const std::string& ini = "") { client_.source(file, ini); }

    // The value of a pin, a parameter or a signal; bits are 0 and 1.
    void set(const std::string& name, double value) { client_.set(name, value); }
    double get(const std::string& name) { return client_.get(name); }

    // Gives an input each impossible value for so many seconds, and then its own value again.
    void poison(const std::string& pin, double seconds);

    // Runs for so many seconds; reports every expectation that did not hold as a failure of the test.
    void run(double seconds);
    // Runs, and returns the named values: at the start, and after each `every` seconds.
    Table trace(double seconds, const std::vector<std::string>& names, double every = 0.001);
    // Writes them into a CSV file from now on.
    void record(const std::filesystem::path& file, const std::vector<std::string>& names,
                double every = 0.001);
    // Seconds since the host was started.
    double time() { return std::chrono::duration<double>(client_.time()).count(); }

    // Holds from now on in every period: bench.expect("abs(z_rate) <= 0.01", {{"z", "it.z-offset"}}).
    void expect(const std::string& expression, const std::map<std::string, std::string>& variables);

    client::Client& client() { return client_; }  // for all else

private:
    client::Client client_;
    std::map<std::string, std::string> expectations_;  // expression, by id
    std::map<std::string, std::int64_t> reported_;     // violations already reported, by id
};

}  // namespace plumb
