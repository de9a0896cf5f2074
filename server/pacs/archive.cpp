// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/archive.hpp"

#include "server/pacs/store.hpp"

namespace fanlight {

Archive archive_of(const DicomPeer& peer) {
  return {.name = shown(peer),
          .store = [peer](auto files, const auto& stop) { return store_files(peer, files, stop); },
          .check = [peer] { return check_echo(peer); }};
}

Archive archive_of(const DicomWebPeer& peer) {
  return {.name = shown(peer),
          .store = [peer](auto files, const auto& stop) { return store_by_web(peer, files, stop); },
          .check = [peer] { return check_web(peer); }};
}

}  // namespace fanlight
