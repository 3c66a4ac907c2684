# SPDX-License-Identifier: GPL-2.0-or-later
# FILE.page beside FILE.cpp, as "pages/FILE.page.hpp" of a target.
function(embed_page name source)
  cmake_path(REPLACE_EXTENSION source page OUTPUT_VARIABLE page)
  if(NOT EXISTS ${page})
    return()
  endif()
  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embed_page.cmake)
  get_filename_component(file ${source} NAME_WE)
  set(header ${CMAKE_BINARY_DIR}/pages/${file}.page.hpp)
  add_custom_command(OUTPUT ${header} DEPENDS ${page} ${script} VERBATIM
    COMMAND ${CMAKE_COMMAND} -D PAGE=${page} -D HEADER=${header} -P ${script})
  target_sources(${name} PRIVATE ${header})
  target_include_directories(${name} PRIVATE ${CMAKE_BINARY_DIR})
endfunction()
