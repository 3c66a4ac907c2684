// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb::hal {

// Shows the operator an error, with the name of the module or program before it. From prepare() and
// background(); update() does not speak.
void report_error(const char* text) noexcept;

// Writes a line to the place from which LinuxCNC was started; no error.
void report(const char* text) noexcept;

}  // namespace plumb::hal
