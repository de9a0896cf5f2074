# SPDX-License-Identifier: Apache-2.0
# Writes changelog.gz, the changes of Fanlight, and changelog.Debian.gz, those of its packaging, to FOLDER.
# cmake -DFOLDER= -DVERSION= -DSTAMP=SECONDS -DMAINTAINER= -DCHANGELOG=FILE -P documents.cmake
set(ENV{SOURCE_DATE_EPOCH} ${STAMP})
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(MAKE_DIRECTORY ${FOLDER})
configure_file(${CHANGELOG} ${FOLDER}/changelog COPYONLY)
file(WRITE ${FOLDER}/changelog.Debian
     "fanlight (${VERSION}) unstable; urgency=medium\n\n"
     "  * Built from the sources of this version: see changelog.gz.\n\n"
     " -- ${MAINTAINER}  ${date}\n")
execute_process(
  COMMAND gzip -9nf ${FOLDER}/changelog ${FOLDER}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
