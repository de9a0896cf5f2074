// SPDX-License-Identifier: Apache-2.0
#include "server/cli/log_format.hpp"

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

class PrintableMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text = printable(std::string_view(message.payload.data(), message.payload.size()));
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintableMessage>();
  }
};

class JsonMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text = printable(std::string_view(message.payload.data(), message.payload.size()));
    // What is no UTF-8 was made printable; a lone byte is replaced and not thrown.
    const std::string json =
        nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    line.append(json.data(), json.data() + json.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<JsonMessage>(); }
};

bool is_json = false;

std::unique_ptr<spdlog::formatter> json_log_format() {
  auto format = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  format->add_flag<JsonMessage>('*').set_pattern(
      R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","message":%*})");
  return format;
}

std::unique_ptr<spdlog::formatter> printable_log_format() {
  auto format = std::make_unique<spdlog::pattern_formatter>();
  format->add_flag<PrintableMessage>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  return format;
}

}  // namespace

void begin_log(bool json) {
  is_json = json;
  spdlog::set_default_logger(spdlog::stderr_color_mt("fanlight"));
  spdlog::set_formatter(json ? json_log_format() : printable_log_format());
}

void print_error(const std::string& of, const std::string& sentence) {
  if (is_json) {
    spdlog::set_level(std::min(spdlog::get_level(), spdlog::level::err));
    spdlog::error("{}: {}", of, sentence);
  } else {
    fmt::print(stderr, "{}: {}\n", of, printable(sentence));
  }
}

}  // namespace fanlight
