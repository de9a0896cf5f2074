# SPDX-License-Identifier: Apache-2.0
# fanlight_add_gtest(TARGET LABELS LABEL... [TIMEOUT SECONDS] [FILTER PATTERN] [LAUNCHER COMMAND...]
#                    [PROCESSORS N] [NAME NAME])
# Registers a GoogleTest program as one test of ctest, which runs all cases in one process: starting a process, a
# sanitizer or a Vulkan driver for each case costs more than most cases. Nothing is asked of the program when it is
# built, so a busy machine cannot fail there.
# The program writes its results to test_results/NAME.xml of the build folder, which tests/summary reads.
# TIMEOUT ends a test that hangs; it is generous, because machines are shared.
function(fanlight_add_gtest target)
  cmake_parse_arguments(PARSE_ARGV 1 given "" "NAME;TIMEOUT;FILTER;PROCESSORS" "LABELS;LAUNCHER")
  if(NOT given_NAME)
    set(given_NAME ${target})
  endif()
  if(NOT given_TIMEOUT)
    set(given_TIMEOUT 900)
  endif()
  if(NOT given_PROCESSORS)
    set(given_PROCESSORS 1)
  endif()
  if(NOT given_FILTER)
    set(given_FILTER *)
  endif()
  add_test(NAME ${given_NAME} COMMAND ${given_LAUNCHER} $<TARGET_FILE:${target}>)
  set_tests_properties(${given_NAME} PROPERTIES
    LABELS "${given_LABELS}"
    TIMEOUT ${given_TIMEOUT}
    PROCESSORS ${given_PROCESSORS}
    ENVIRONMENT "GTEST_OUTPUT=xml:${CMAKE_BINARY_DIR}/test_results/${given_NAME}.xml;GTEST_FILTER=${given_FILTER}")
endfunction()
