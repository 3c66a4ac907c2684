# SPDX-License-Identifier: GPL-2.0-or-later
# cmake -D SOURCE=FOLDER -D HEADER=FILE -P commit.cmake
# Writes PLUMB_COMMIT into HEADER: the commit of a build from git, such as " (commit 3f2a9c1)", and nothing elsewhere.
set(text "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} describe --always --dirty=+changes --exclude=* OUTPUT_VARIABLE commit
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(text " (commit ${commit})")
  endif()
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define PLUMB_COMMIT \"${text}\"\n")
