# SPDX-License-Identifier: Apache-2.0
# Packs each package of CPack again with dpkg-deb, which sorts the files and sets no time later than SOURCE_DATE_EPOCH.
# CPack keeps the times at which files were built. cpack calls this script.
find_program(DPKG_DEB dpkg-deb REQUIRED)
foreach(package IN LISTS CPACK_PACKAGE_FILES)
  set(folder ${package}.folder)
  file(REMOVE_RECURSE ${folder})
  execute_process(COMMAND ${DPKG_DEB} --raw-extract ${package} ${folder} COMMAND_ERROR_IS_FATAL ANY)
  # Debug symbols share the documents of the package that they belong to; CPack gives them none, and the mode and the
  # sums of another folder.
  file(GLOB_RECURSE symbols ${folder}/usr/lib/debug/*.debug)
  if(symbols)
    file(CHMOD ${symbols} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
    file(STRINGS ${folder}/DEBIAN/control name REGEX "^Package: ")
    string(REGEX REPLACE "^Package: |-dbgsym$" "" name ${name})
    file(MAKE_DIRECTORY ${folder}/usr/share/doc)
    file(CREATE_LINK ${name} ${folder}/usr/share/doc/${name}-dbgsym SYMBOLIC)
  endif()
  file(GLOB_RECURSE files LIST_DIRECTORIES OFF RELATIVE ${folder} ${folder}/*)
  list(FILTER files EXCLUDE REGEX "^DEBIAN/|^usr/share/doc/[^/]*-dbgsym")
  list(SORT files COMPARE STRING)
  set(sums)
  foreach(file IN LISTS files)
    file(MD5 ${folder}/${file} sum)
    string(APPEND sums "${sum}  ${file}\n")
  endforeach()
  file(WRITE ${folder}/DEBIAN/md5sums "${sums}")
  execute_process(
    COMMAND ${DPKG_DEB} --root-owner-group -Zxz --build ${folder} ${package}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE_RECURSE ${folder})
endforeach()
