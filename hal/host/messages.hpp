// SPDX-License-Identifier: GPL-2.0-or-later
// The messages of modules. While a halcmd runs, its output and the modules' go into that command's answer,
// in the order in which they came; otherwise modules print on the host's own standard output and error, or
// where OutputOf directs them, unbuffered.
#pragma once

#include <functional>
#include <string_view>

namespace plumb::host {

// Takes modules' messages, for standard output when `error` is false. Returns whether it did; if not, the
// message is printed. An empty function takes none.
using MessageSink = std::function<bool(std::string_view text, bool error)>;
void set_message_sink(MessageSink sink);

// Descriptors to print on in the place of standard output and error; negative ones restore them.
void set_message_files(int output, int error);

// Passes a message on to the sink, or prints it.
void print_message(std::string_view text, bool error);

}  // namespace plumb::host
