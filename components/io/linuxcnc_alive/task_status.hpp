// SPDX-License-Identifier: GPL-2.0-or-later
// TaskStatus, which reads TaskReports.
#pragma once

#if __has_include(<emc_nml.hh>)
#include "components/io/linuxcnc_alive/nml_task_status.hpp"
#else
#include "components/io/linuxcnc_alive/python_task_status.hpp"
#endif
