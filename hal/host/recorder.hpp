// SPDX-License-Identifier: GPL-2.0-or-later
// Writes chosen values into a CSV file as virtual time passes: a header `time,NAME,...`, then a row at once
// and one at the end of each period that is a multiple of an interval after it. Times are in s since the
// recording began; numbers are the shortest decimals that read back to the same value, bits are 0 or 1.
#pragma once

#include <string>
#include <vector>

#include "hal/host/names.hpp"
#include "hal/host/time.hpp"

namespace plumb::host {

class Recorder {
public:
    // The columns of a recording. `append` goes on with a file of the same columns: it adds no header and
    // no row at once, and its times go on from the file's last. `every` must be positive.
    struct Settings {
        std::string file;
        std::vector<std::string> columns;
        Nanoseconds every;
        bool append;
    };

    // Opens the file and writes its beginning. Throws std::runtime_error when it cannot, a name is unknown,
    // or the file that is to be gone on with has other columns.
    Recorder(Settings settings, const Names& names);

    // Flushes, and prints a failure; call flush() to learn of it.
    ~Recorder();
    Recorder(const Recorder&) = delete;

    // The time of the last row of a recording that is to be gone on with; 0 without one. Throws
    // std::runtime_error, with the file, when it is no recording of these columns, or not a whole one.
    static Nanoseconds last_time(const std::string& name, const std::vector<std::string>& columns);

    // Looks the columns up again. Throws std::runtime_error when one is gone.
    void resolve(const Names& names);

    // The instant of the next row.
    Nanoseconds next_row() const { return next_row_; }

    // Writes the row of the present instant. Throws std::runtime_error when the file cannot be written.
    void write_row();

    // Brings all rows into the file. Throws std::runtime_error when it cannot be written.
    void flush();

private:
    void go_on_with_file();

    Settings settings_;
    std::vector<Cell> cells_;
    int descriptor_;
    std::string buffer_;
    Nanoseconds began_;  // the instant that stands in the file as 0
    Nanoseconds next_row_;
};

}  // namespace plumb::host
