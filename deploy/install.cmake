# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` installs, in four components: `server`; `images`, which needs OpenImageIO and its libraries;
# `view`, which needs those of a desktop; and `python` (python/CMakeLists.txt). Then the Debian packages of
# all for `cpack`. Include it after all targets.
include(GNUInstallDirs)
set(deploy ${CMAKE_CURRENT_LIST_DIR})
set(packaging ${CMAKE_BINARY_DIR}/packaging)
set(commands serve render batch watch view export token audit bench info record recover convert)
if(FANLIGHT_DICOM)
  list(APPEND commands send worklist)
endif()

install(TARGETS fanlight RUNTIME COMPONENT server)
# Where the run path of the program finds it.
install(TARGETS fanlight_images_module LIBRARY DESTINATION lib/fanlight COMPONENT images)
if(TARGET fanlight-view)
  install(TARGETS fanlight-view RUNTIME COMPONENT view)
endif()

# Man pages and completions are what the program prints of itself. A program for another processor cannot run here, and
# one with a sanitizer is not installed.
if(NOT CMAKE_CROSSCOMPILING AND NOT FANLIGHT_SANITIZE)
  find_program(GZIP gzip REQUIRED)
  set(help_files)
  # help_file(FILE ARGUMENTS...): FILE is what the program prints with these arguments; compressed if it ends in .gz.
  function(help_file file)
    cmake_path(GET file PARENT_PATH folder)
    file(MAKE_DIRECTORY ${folder})
    string(REGEX REPLACE "[.]gz$" "" plain ${file})
    set(compress)
    if(NOT plain STREQUAL file)
      # Without a time and a name, so that equal pages give equal bytes.
      set(compress COMMAND ${GZIP} -9nf ${plain})
    endif()
    add_custom_command(OUTPUT ${file} DEPENDS fanlight COMMAND fanlight ${ARGN} > ${plain} ${compress} VERBATIM)
    set(help_files ${help_files} ${file} PARENT_SCOPE)
  endfunction()

  help_file(${packaging}/man/fanlight.1.gz man)
  foreach(command IN LISTS commands)
    help_file(${packaging}/man/fanlight-${command}.1.gz man ${command})
  endforeach()
  help_file(${packaging}/bash/fanlight completion bash)
  help_file(${packaging}/zsh/_fanlight completion zsh)
  help_file(${packaging}/fish/fanlight.fish completion fish)
  add_custom_target(help_files ALL DEPENDS ${help_files})

  # `fanlight view` starts fanlight-view with the same options: one page describes both, beside the latter.
  install(DIRECTORY ${packaging}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT server
          PATTERN fanlight-view.1.gz EXCLUDE)
  if(TARGET fanlight-view)
    install(FILES ${packaging}/man/fanlight-view.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT view)
  endif()
  install(FILES ${packaging}/bash/fanlight DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          COMPONENT server)
  # Debian's zsh looks into vendor-completions below /usr, and into site-functions below /usr/local.
  set(zsh_folder site-functions)
  if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    set(zsh_folder vendor-completions)
  endif()
  install(FILES ${packaging}/zsh/_fanlight DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/${zsh_folder} COMPONENT server)
  install(FILES ${packaging}/fish/fanlight.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
          COMPONENT server)
endif()

# systemd and udev read these folders below /usr and /usr/local alike; not lib64 or lib/x86_64-linux-gnu.
file(READ ${deploy}/systemd/fanlight.service unit)
string(REPLACE /usr/bin/ ${CMAKE_INSTALL_FULL_BINDIR}/ unit "${unit}")
string(REPLACE /etc/fanlight/ ${CMAKE_INSTALL_FULL_SYSCONFDIR}/fanlight/ unit "${unit}")
file(CONFIGURE OUTPUT ${packaging}/fanlight.service CONTENT "${unit}" @ONLY)
install(FILES ${packaging}/fanlight.service DESTINATION lib/systemd/system COMPONENT server)
install(FILES ${deploy}/systemd/fanlight.sysusers DESTINATION lib/sysusers.d RENAME fanlight.conf COMPONENT server)
install(FILES ${deploy}/systemd/fanlight.tmpfiles DESTINATION lib/tmpfiles.d RENAME fanlight.conf COMPONENT server)
install(FILES ${deploy}/60-fanlight-probe.rules DESTINATION lib/udev/rules.d COMPONENT server)
install(FILES ${deploy}/fanlight.toml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/fanlight COMPONENT server)

set(documents ${CMAKE_INSTALL_DATADIR}/doc/fanlight)
install(FILES README.md SECURITY.md deploy/USER_GUIDE.md deploy/API.md deploy/openapi.json deploy/SCALE.md
  deploy/PYTHON.md deploy/python_ball.png
  proto/DISPLAY_PROTOCOL.md proto/RTP.md
  DESTINATION ${documents}
  COMPONENT server)
install(DIRECTORY ${deploy}/monitoring ${deploy}/janus ${deploy}/slurm ${deploy}/kubernetes DESTINATION ${documents}
  COMPONENT server PATTERN "*.test.yml" EXCLUDE)
# For displays of others.
install(FILES proto/fanlight.proto DESTINATION ${CMAKE_INSTALL_DATADIR}/fanlight COMPONENT server)
install(DIRECTORY ${CMAKE_BINARY_DIR}/server/viewer/fanlight-view DESTINATION ${CMAKE_INSTALL_DATADIR}/fanlight
  COMPONENT server)

include(${deploy}/package/debian.cmake)
