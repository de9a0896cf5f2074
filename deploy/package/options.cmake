# SPDX-License-Identifier: Apache-2.0
# How packages are compiled: cmake -C deploy/package/options.cmake. The flags are those of Debian's own packages.
cmake_path(SET sources NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../..)
string(REGEX REPLACE "/$" "" sources ${sources})
set(CMAKE_BUILD_TYPE Release CACHE STRING "")
set(CMAKE_INSTALL_PREFIX /usr CACHE PATH "")
set(CMAKE_INSTALL_LIBDIR lib CACHE PATH "")
set(FANLIGHT_TESTS OFF CACHE BOOL "")
set(FANLIGHT_SHADER_NAMES OFF CACHE BOOL "")
# A package is built once and afresh; batches of sources take a fifth less time.
set(CMAKE_UNITY_BUILD ON CACHE BOOL "")
# -g1: functions and lines, for a backtrace; with all variables the symbols would be ten times as large.
# -ffile-prefix-map: no path of the machine that built it goes into the program. The last match counts.
string(JOIN " " flags
  -g1 -ffile-prefix-map=${sources}=. -ffile-prefix-map=${CMAKE_BINARY_DIR}=./build
  -fstack-protector-strong -D_FORTIFY_SOURCE=2 -Wformat -Werror=format-security)
set(CMAKE_CXX_FLAGS "${flags}" CACHE STRING "")
set(CMAKE_EXE_LINKER_FLAGS "-Wl,-z,relro -Wl,-z,now -Wl,--build-id=sha1" CACHE STRING "")
set(CMAKE_MODULE_LINKER_FLAGS "${CMAKE_EXE_LINKER_FLAGS}" CACHE STRING "")
