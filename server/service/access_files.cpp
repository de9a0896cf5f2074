// SPDX-License-Identifier: Apache-2.0
#include "server/service/access_files.hpp"

#include <spdlog/spdlog.h>

#include <string>

namespace fanlight {

void AccessFiles::reload(bool in_any_case) {
  std::string trouble;
  if (access_.reload(trouble, in_any_case)) {
    audit_.note({.name = "fanlight"},
                {.what = "credentials_read", .result = trouble.empty() ? "done" : trouble});
    if (trouble.empty()) {
      spdlog::info("read the credentials again");
    } else {
      spdlog::error("the credentials stay as they were: {}", trouble);
    }
  }
  const auto result = listener_.reload_certificates(in_any_case);
  if (!result) return;
  audit_.note({.name = "fanlight"}, {.what = "certificates_read", .result = *result});
  spdlog::info("the certificates were read again: {}", *result);
}

}  // namespace fanlight
