// SPDX-License-Identifier: GPL-2.0-or-later
// Puts a line of text with the release of Plumb into a module or program. `plumb doctor` reads it from the
// file, which may be of another release, for another computer, or not loadable at all.
#pragma once

namespace plumb {

[[gnu::used]] static const char identity[] = "@(#)Plumb " PLUMB_VERSION;

}  // namespace plumb
