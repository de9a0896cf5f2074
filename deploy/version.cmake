# SPDX-License-Identifier: Apache-2.0
# Sets FANLIGHT_VERSION_FULL, the version that the program prints and the packages bear. Include it after project().
#   0.1.0              this commit has the tag v0.1.0, or nothing better is known than the version of project()
#   0.1.0+12.gabcdef   12 commits after the tag v0.1.0; Debian sorts it after 0.1.0 and before 0.1.1.
#   0.1.0~287.gabcdef  before the first tag: the version of project() is to come, and this has 287 commits.
# -DFANLIGHT_VERSION_FULL=VERSION overrides it. It is found when CMake configures, not at each commit.
if(NOT FANLIGHT_VERSION_FULL)
  set(FANLIGHT_VERSION_FULL ${PROJECT_VERSION})
  find_program(GIT git)
  if(GIT AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
    execute_process(
      COMMAND ${GIT} -C ${PROJECT_SOURCE_DIR} describe --tags --match "v*"
      OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(described MATCHES "^v(.+)-([0-9]+)-(g[0-9a-f]+)$")
      set(FANLIGHT_VERSION_FULL "${CMAKE_MATCH_1}+${CMAKE_MATCH_2}.${CMAKE_MATCH_3}")
    elseif(described MATCHES "^v(.+)$")
      set(FANLIGHT_VERSION_FULL ${CMAKE_MATCH_1})
    else()
      execute_process(
        COMMAND ${GIT} -C ${PROJECT_SOURCE_DIR} rev-list --count HEAD
        OUTPUT_VARIABLE commits OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
      execute_process(
        COMMAND ${GIT} -C ${PROJECT_SOURCE_DIR} rev-parse --short=7 HEAD
        OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
      if(commits AND commit)
        set(FANLIGHT_VERSION_FULL "${PROJECT_VERSION}~${commits}.g${commit}")
      endif()
    endif()
    # Before a release Debian sorts 1.0.0~rc1, not 1.0.0-rc1.
    string(REPLACE "-" "~" FANLIGHT_VERSION_FULL "${FANLIGHT_VERSION_FULL}")
  endif()
endif()
if(NOT FANLIGHT_VERSION_FULL MATCHES "^[0-9][0-9A-Za-z.+~]*$")
  message(FATAL_ERROR "the version is \"${FANLIGHT_VERSION_FULL}\", expected a number such as 0.1.0")
endif()
