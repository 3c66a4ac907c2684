// SPDX-License-Identifier: GPL-2.0-or-later
// What modules print. While a halcmd runs, its output and the modules' go into that command's answer, in the
// order in which they came; otherwise modules print on the host's own standard output and error, unbuffered.
#pragma once

#include <functional>
#include <string_view>

namespace plumb::host {

// Where modules' messages go; an empty function restores standard output (when `error` is false) and error.
using MessageSink = std::function<void(std::string_view text, bool error)>;
void set_message_sink(MessageSink sink);

// Passes a message on to the sink.
void print_message(std::string_view text, bool error);

}  // namespace plumb::host
