// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace fanlight {

/// Sends the log to the standard error, since scripts read the standard output. `json`: each line is an
/// object of JSON with time (UTC, RFC 3339), level and message; else it is for people. Messages are made
/// printable(): names of files, devices and displays are part of them. Call it once, before other threads
/// run.
void begin_log(bool json);

/// The last words of a program that fails, whatever the log leaves out: "of: sentence", or a line of the log
/// where that is JSON. Text of files, devices and the network may be part of the sentence, and is made
/// printable().
void print_error(const std::string& of, const std::string& sentence);

}  // namespace fanlight
