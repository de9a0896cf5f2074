// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

namespace fanlight::test {

/// Lines of an audit log whose "what" is this. Waits up to 5 s until there are `at_least` of them, then
/// returns those that exist.
inline std::vector<nlohmann::json> audited(const std::filesystem::path& path, const std::string& what,
                                           std::size_t at_least = 1) {
  for (int attempt = 0;; ++attempt) {
    std::vector<nlohmann::json> lines;
    std::ifstream log(path);
    for (std::string line; std::getline(log, line);) {
      auto parsed = nlohmann::json::parse(line, nullptr, false);
      if (parsed.is_object() && parsed["what"] == what) lines.push_back(std::move(parsed));
    }
    if (lines.size() >= at_least || attempt == 100) return lines;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace fanlight::test
