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
#include "hal/host/scheduler.hpp"

namespace plumb::host {

namespace {

constexpr std::size_t buffer_size = 1 << 16;

std::string header_of(const std::vector<std::string>& columns) {
    std::string header = "time";
    for (const std::string& column : columns) header += "," + column;
    return header;
}

}  // namespace

Recorder::Recorder(Settings settings, const Names& names)
    : settings_(std::move(settings)), began_(scheduler().time()), next_row_(began_) {
    resolve(names);
    const int mode = O_WRONLY | O_CREAT | O_CLOEXEC | (settings_.append ? O_APPEND : O_TRUNC);
    descriptor_ = open(settings_.file.c_str(), mode, 0666);
    if (descriptor_ < 0) throw std::runtime_error(settings_.file + ": " + std::strerror(errno));
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
    } catch (const std::runtime_error&) {
        // Whoever wanted to know has called flush().
    }
    close(descriptor_);
}

void Recorder::go_on_with_file() {
    std::ifstream file(settings_.file);
    std::string line, last;
    std::getline(file, line);
    if (line != header_of(settings_.columns))
        throw std::runtime_error(settings_.file + ": line 1: the columns are '" + line +
                                 "', not those to be recorded");
    while (std::getline(file, line)) last = line;
    if (last.empty()) return;
    const auto seconds = number_of(last.substr(0, last.find(',')));
    if (!seconds) throw std::runtime_error(settings_.file + ": the last row has no time");
    began_ -= std::llround(*seconds * static_cast<double>(one_second));
    next_row_ += settings_.every;
}

void Recorder::resolve(const Names& names) {
    cells_.clear();
    for (const std::string& column : settings_.columns) cells_.push_back(names.need(column));
}

void Recorder::write_row() {
    append_seconds(buffer_, next_row_ - began_);
    for (const Cell& cell : cells_) {
        buffer_ += ',';
        append_number(buffer_, cell.read());
    }
    buffer_ += '\n';
    next_row_ += settings_.every;
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
