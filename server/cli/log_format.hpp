// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <spdlog/formatter.h>

#include <memory>

namespace fanlight {

/// The usual format of a log line, with the message made printable(): names of files, devices and displays
/// are part of it, and it may be read on a terminal.
std::unique_ptr<spdlog::formatter> printable_log_format();

/// A line of the log as an object of JSON: time (UTC, RFC 3339), level and message.
std::unique_ptr<spdlog::formatter> json_log_format();

}  // namespace fanlight
