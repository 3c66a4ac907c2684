// SPDX-License-Identifier: GPL-2.0-or-later
// For LD_PRELOAD: SIGTERM calls exit(0), as LinuxCNC's rtapi_app does it in realtime mode, which not every
// kernel and container permits.
#include <signal.h>
#include <stdlib.h>

[[gnu::constructor]] static void handle() {
    signal(SIGTERM, [](int) { exit(0); });
}
