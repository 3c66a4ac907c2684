// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/recorder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "hal/host/decimal.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/scheduler.hpp"
#include "hal/regular_file.hpp"

namespace plumb::host {

namespace {

constexpr std::size_t buffer_size = 1 << 16;

std::string header_of(const std::vector<std::string>& columns) {
    std::string header = "time";
    for (const std::string& column : columns) header += "," + column;
    return header;
}

// Does not wait for somebody to read from a pipe.
int open_for_writing(const std::string& file, bool append) {
    const int mode = O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | (append ? O_APPEND : O_TRUNC);
    const int descriptor = open(file.c_str(), mode, 0666);
    if (descriptor < 0)
        throw std::runtime_error(
            file + ": " + (errno == ENXIO ? "is a pipe or socket that nobody reads" : std::strerror(errno)));
    fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) & ~O_NONBLOCK);
    return descriptor;
}

}  // namespace

Recorder::Recorder(Settings settings, const Names& names)
    : settings_(std::move(settings)), began_(scheduler().time()), next_row_(began_) {
    resolve(names);
    descriptor_ = open_for_writing(settings_.file, settings_.append);
    try {
        struct stat state {};
        if (settings_.append && fstat(descriptor_, &state) == 0 && state.st_size > 0) {
            go_on_with_file();
            return;
        }
        buffer_ = header_of(settings_.columns) + "\n";
        write_row();
        flush();
    } catch (...) {
        close(descriptor_);
        throw;
    }
}

Recorder::~Recorder() {
    try {
        flush();
    } catch (const std::runtime_error& error) {
        print_message(std::string("plumb-host: ") + error.what() + ": the recording is not complete\n", true);
    }
    close(descriptor_);
}

void Recorder::go_on_with_file() {
    began_ -= last_time(settings_.file, settings_.columns);
    next_row_ = after(next_row_, settings_.every);
}

Nanoseconds Recorder::last_time(const std::string& name, const std::vector<std::string>& columns) {
    hal::require_regular_file(name);
    std::ifstream file(name);
    std::string line, last;
    std::getline(file, line);
    if (line != header_of(columns))
        throw std::runtime_error(name + ": line 1: the columns are '" + line.substr(0, 200) +
                                 "', not those to be recorded");
    if (file.eof())
        throw std::runtime_error(name + ": the header breaks off: remove the file, or record elsewhere");
    while (std::getline(file, line)) {
        last = line;
        if (file.eof())
            throw std::runtime_error(name + ": the last row breaks off: remove it, or record elsewhere");
    }
    if (last.empty()) return 0;
    const auto seconds = number_of(last.substr(0, last.find(',')));
    const double time = seconds ? *seconds * static_cast<double>(one_second) : NAN;
    if (!(time >= 0 && time < static_cast<double>(never / 2)))
        throw std::runtime_error(name + ": the last row has no time");
    return std::llround(time);
}

void Recorder::resolve(const Names& names) {
    cells_.clear();
    for (const std::string& column : settings_.columns) cells_.push_back(names.need(column));
}

void Recorder::write_row() {
    append_seconds(buffer_, next_row_ - began_);
    for (const Cell& cell : cells_) {
        buffer_ += ',';
        append_number(buffer_, cell.value.number());
    }
    buffer_ += '\n';
    next_row_ = after(next_row_, settings_.every);
    if (buffer_.size() > buffer_size) flush();
}

void Recorder::flush() {
    const std::string text = std::move(buffer_);
    buffer_.clear();
    for (std::size_t written = 0; written < text.size();) {
        const ssize_t count = write(descriptor_, text.data() + written, text.size() - written);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw std::runtime_error(settings_.file + ": " + std::strerror(errno));
        written += static_cast<std::size_t>(count);
    }
}

}  // namespace plumb::host
