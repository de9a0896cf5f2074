# SPDX-License-Identifier: Apache-2.0
# fanlight_add_gtest(TARGET LABELS LABEL... [TIMEOUT SECONDS] [FILTER PATTERN] [LAUNCHER COMMAND...]
#                    [ALONE | WAITS] [NAME NAME] [SHARDS N] [SANITIZED])
# Registers a GoogleTest program as one test of ctest, which runs all cases in one process: starting a process, a
# sanitizer or a Vulkan driver for each case costs more than most cases. Nothing is asked of the program when it is
# built, so a busy machine cannot fail there.
# The program writes its results to test_results/NAME.xml of the build folder, which tests/summary reads.
# SHARDS makes N tests, NAME_1 to NAME_N, of which each runs a part of the cases.
# TIMEOUT ends a test that hangs; it is generous, because machines are shared.
# SANITIZED: a test of protocols or formats, which tests/run runs under the sanitizers. In the release build, `tests/run
# protocols` builds and runs them.
# PROCESSORS counts halves of a processor, of which tests/run gives ctest all: a test computes on one (2), WAITS for
# its own time limits most of the time (1), or takes two and stands ALONE on a small machine (4).
function(fanlight_add_gtest target)
  cmake_parse_arguments(PARSE_ARGV 1 given "ALONE;SANITIZED;WAITS" "NAME;TIMEOUT;FILTER;SHARDS" "LABELS;LAUNCHER")
  if(given_SANITIZED AND CMAKE_BUILD_TYPE STREQUAL Release)
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL ON)
    return()
  endif()
  if(NOT given_NAME)
    set(given_NAME ${target})
  endif()
  if(NOT given_TIMEOUT)
    set(given_TIMEOUT 900)
  endif()
  set(processors 2)
  if(given_ALONE)
    set(processors 4)
  elseif(given_WAITS)
    set(processors 1)
  endif()
  if(NOT given_FILTER)
    set(given_FILTER *)
  endif()
  if(given_SHARDS)
    foreach(shard RANGE 1 ${given_SHARDS})
      math(EXPR index "${shard} - 1")
      fanlight_add_gtest_part(${given_NAME}_${shard} "GTEST_TOTAL_SHARDS=${given_SHARDS};GTEST_SHARD_INDEX=${index}")
    endforeach()
  else()
    fanlight_add_gtest_part(${given_NAME} "")
  endif()
endfunction()

# One test with the arguments of fanlight_add_gtest, of which it is a part.
macro(fanlight_add_gtest_part name environment)
  add_test(NAME ${name} COMMAND ${given_LAUNCHER} $<TARGET_FILE:${target}>)
  set(part_environment "GTEST_OUTPUT=xml:${CMAKE_BINARY_DIR}/test_results/${name}.xml"
    "GTEST_FILTER=${given_FILTER}" ${environment})
  if(FANLIGHT_SANITIZE MATCHES undefined)
    # Without it, undefined behaviour is reported, and the test passes.
    list(APPEND part_environment UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1)
  endif()
  set_tests_properties(${name} PROPERTIES
    LABELS "${given_LABELS}"
    TIMEOUT ${given_TIMEOUT}
    PROCESSORS ${processors}
    ENVIRONMENT "${part_environment}")
endmacro()
