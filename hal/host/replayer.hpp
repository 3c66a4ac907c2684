// SPDX-License-Identifier: GPL-2.0-or-later
// Writes recorded data into pins before each period: floats change linearly in time between two rows, bits
// and integers hold the value of the last row, and so do floats while either row's value is not finite.
// Before the first row its values hold.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/host/names.hpp"
#include "hal/host/time.hpp"

namespace plumb::host {

class Replayer {
public:
    struct Settings {
        std::string file;

        // Empty: a CSV file, whose header names the time (in s) and the pins. Otherwise the pins of
        // halsampler's output: no header, blanks between the values, and perhaps a sample number before
        // them, which must rise by 1 from row to row; a last line that breaks off is left out.
        std::vector<std::string> columns;
        Nanoseconds sample_period;  // with `columns`: the time from one row to the next
    };

    // Reads the whole file, which is a regular one. Throws std::runtime_error with the file, line, column and
    // value that are wrong.
    explicit Replayer(Settings settings);

    // Names of the columns' pins.
    const std::vector<std::string>& columns() const { return columns_; }

    // Looks the pins up, and counts the file's time from now on the first time. Throws std::runtime_error
    // when a pin is gone, or the file holds a value that it cannot take.
    void resolve(const Names& names);

    // The instant of the last row. Call resolve() before.
    Nanoseconds end() const { return began_ + times_.back(); }

    // How long the data lasts from time 0 of the file on.
    Nanoseconds duration() const { return times_.back(); }

    // Writes the values of an instant; instants must not fall.
    void apply(Nanoseconds instant);

private:
    void read_csv();
    void read_samples();
    void check(const Cell& cell, std::size_t column) const;
    void add_row(std::size_t line, Nanoseconds time, const std::vector<std::string_view>& fields);

    Settings settings_;
    std::vector<std::string> columns_;
    std::vector<Nanoseconds> times_;           // rising
    std::vector<std::vector<double>> values_;  // by column, then by row
    std::vector<std::size_t> lines_;           // of the rows in the file
    std::vector<Cell> cells_;
    Nanoseconds began_ = 0;
    bool begun_ = false;
    std::size_t row_ = 0;  // the last one that is not later than the present
};

}  // namespace plumb::host
