# SPDX-License-Identifier: GPL-2.0-or-later
# Writes the list of tests that CTest reads, from the list that a GoogleTest program has printed as JSON.
cmake_minimum_required(VERSION 3.19)

file(READ ${json} text)
string(JSON suites LENGTH "${text}" testsuites)
math(EXPR last_suite "${suites} - 1")
set(lines "")
set(files "")
foreach(i RANGE ${last_suite})
  string(JSON tests LENGTH "${text}" testsuites ${i} testsuite)
  math(EXPR last_test "${tests} - 1")
  string(JSON suite GET "${text}" testsuites ${i} name)
  foreach(j RANGE ${last_test})
    string(JSON name GET "${text}" testsuites ${i} testsuite ${j} name)
    if(by_file)
      string(JSON file GET "${text}" testsuites ${i} testsuite ${j} file)
      get_filename_component(file ${file} NAME_WE)
      list(APPEND files ${file})
      list(APPEND suites_of_${file} "${suite}.*")
      break()  # a suite lies in one file
    endif()
    string(APPEND lines "add_test([=[${suite}.${name}]=] [=[${program}]=] [=[--gtest_filter=${suite}.${name}]=])\n"
      "set_tests_properties([=[${suite}.${name}]=] PROPERTIES TIMEOUT 120 "
      "SKIP_REGULAR_EXPRESSION [=[\\[  SKIPPED \\]]=])\n")
  endforeach()
endforeach()
list(REMOVE_DUPLICATES files)
foreach(file IN LISTS files)
  list(JOIN suites_of_${file} ":" filter)
  string(APPEND lines "add_test(${file} [=[${program}]=] [=[--gtest_filter=${filter}]=])\n"
    "set_tests_properties(${file} PROPERTIES TIMEOUT 240)\n")
endforeach()
file(WRITE ${output} "${lines}")
