# SPDX-License-Identifier: Apache-2.0
# Debian packages for `cpack -G DEB`: fanlight, fanlight-images, fanlight-view with the debug symbols of each, and
# python3-fanlight.
# deploy/package/build calls it with the options of a release. The bytes depend on the sources and on SOURCE_DATE_EPOCH
# alone.
set(FANLIGHT_MAINTAINER "Fanlight developers <fanlight@localhost>" CACHE STRING
    "Who made the packages, as in Debian's field Maintainer")
set(FANLIGHT_HOMEPAGE "" CACHE STRING "The project's page, as in Debian's field Homepage")
# One version for each release of Debian, since each has libraries of its own. deb13 replaces deb12 in an upgrade.
set(release 0)
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release release REGEX "^VERSION_ID=")
  string(REGEX MATCH "[0-9]+" release "${release}")
endif()
set(FANLIGHT_PACKAGE_REVISION 1+deb${release} CACHE STRING "Debian's revision of the package")

# Of a package alone: its licences and its changes, where Debian looks for them.
set(stamp "$ENV{SOURCE_DATE_EPOCH}")
if(NOT stamp)
  string(TIMESTAMP stamp %s UTC)
endif()
set(version ${FANLIGHT_VERSION_FULL}-${FANLIGHT_PACKAGE_REVISION})
set(compress_documents ${CMAKE_COMMAND} -DFOLDER=${packaging} -DVERSION=${version} -DSTAMP=${stamp}
    "-DMAINTAINER=${FANLIGHT_MAINTAINER}" -DCHANGELOG=${PROJECT_SOURCE_DIR}/CHANGELOG.md
    -P ${CMAKE_CURRENT_LIST_DIR}/documents.cmake)
execute_process(COMMAND ${compress_documents} COMMAND_ERROR_IS_FATAL ANY)
function(install_documents component package)
  set(folder ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES ${deploy}/package/copyright ${packaging}/changelog.gz ${packaging}/changelog.Debian.gz
          DESTINATION ${folder} COMPONENT ${component})
endfunction()
install_documents(server fanlight)
install_documents(images fanlight-images)
install_documents(python python3-fanlight)
if(TARGET fanlight-view)
  install_documents(view fanlight-view)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fanlight)
set(CPACK_PACKAGE_VERSION ${FANLIGHT_VERSION_FULL})
set(CPACK_DEBIAN_PACKAGE_RELEASE ${FANLIGHT_PACKAGE_REVISION})
set(CPACK_PACKAGE_CONTACT "${FANLIGHT_MAINTAINER}")
set(CPACK_PACKAGE_HOMEPAGE_URL "${FANLIGHT_HOMEPAGE}")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_OUTPUT_FILE_PREFIX ${CMAKE_BINARY_DIR}/packages)
# With DESTDIR, files in /etc are packaged instead of installed on this machine.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL server images python)
if(TARGET fanlight-view)
  list(APPEND CPACK_COMPONENTS_ALL view)
endif()
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEBUGINFO_PACKAGE ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# A driver for Vulkan: Mesa's, which renders on a processor too, or another. The scripts make the user and its folders
# with systemd's programs, or with those for machines and containers without systemd.
set(CPACK_DEBIAN_SERVER_PACKAGE_NAME fanlight)
set(CPACK_DEBIAN_SERVER_PACKAGE_SECTION graphics)
string(CONCAT CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS
  "mesa-vulkan-drivers | vulkan-icd, systemd | systemd-standalone-sysusers | systemd-sysusers, "
  "systemd | systemd-standalone-tmpfiles | systemd-tmpfiles")
# Picture files; kill, which reloads the service; events of USB devices.
set(CPACK_DEBIAN_SERVER_PACKAGE_RECOMMENDS "fanlight-images (= ${version}), procps, udev")
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS fanlight-view)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
  ${deploy}/package/conffiles ${deploy}/package/postinst ${deploy}/package/prerm ${deploy}/package/postrm)
string(CONCAT CPACK_COMPONENT_SERVER_DESCRIPTION
  "4D ultrasound, rendered in real time and streamed to displays\n"
  "Reads the frames of a 4D ultrasound probe, a recording or a simulated probe,\n"
  "assembles volumes, renders surfaces with Vulkan, and streams the pictures to\n"
  "browsers and programs, which move light, camera and threshold.\n"
  "It is not a medical device.")

# Apart from the server, which seldom needs it: OpenImageIO brings ten times as many libraries as the server has.
set(CPACK_DEBIAN_IMAGES_PACKAGE_NAME fanlight-images)
set(CPACK_DEBIAN_IMAGES_PACKAGE_SECTION graphics)
# The program refuses a library of another version than its own.
set(CPACK_DEBIAN_IMAGES_PACKAGE_DEPENDS "fanlight (= ${version})")
# Earlier versions of fanlight hold the library themselves.
set(CPACK_DEBIAN_IMAGES_PACKAGE_BREAKS "fanlight (<< ${version})")
set(CPACK_DEBIAN_IMAGES_PACKAGE_REPLACES "fanlight (<< ${version})")
set(CPACK_DEBIAN_IMAGES_PACKAGE_ENHANCES fanlight)
string(CONCAT CPACK_COMPONENT_IMAGES_DESCRIPTION
  "picture files for Fanlight's 4D ultrasound\n"
  "Lets the commands of fanlight read and write pictures in files: render, batch,\n"
  "send, info --plot, and recordings that are a folder of pictures. A server needs\n"
  "it for such a recording alone. It is not a medical device.")

set(CPACK_DEBIAN_VIEW_PACKAGE_NAME fanlight-view)
set(CPACK_DEBIAN_VIEW_PACKAGE_SECTION graphics)
# Any font does for its text; without one it refuses to start.
set(CPACK_DEBIAN_VIEW_PACKAGE_DEPENDS "fonts-dejavu-core | fonts-dejavu")
set(CPACK_DEBIAN_VIEW_PACKAGE_ENHANCES fanlight)
string(CONCAT CPACK_COMPONENT_VIEW_DESCRIPTION
  "native display for Fanlight's 4D ultrasound\n"
  "Shows the pictures of a Fanlight server in a window or on the full screen of a\n"
  "scanner, without a browser. It is not a medical device.")

# It takes any version of the server that speaks its protocol.
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-fanlight)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_PYTHON_DEBUGINFO_PACKAGE OFF)
string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.11), python3-numpy, python3-pil, python3-protobuf, python3-websockets (>= 10.4)")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${deploy}/package/python/postinst ${deploy}/package/python/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "fanlight, fanlight-images")
string(CONCAT CPACK_COMPONENT_PYTHON_DESCRIPTION
  "Fanlight's 4D ultrasound from Python\n"
  "Renders arrays and recordings to pictures with their depths, and takes the\n"
  "pictures of a Fanlight server as arrays. It is not a medical device.")

set(CPACK_POST_BUILD_SCRIPTS ${deploy}/package/repack.cmake)
include(CPack)
