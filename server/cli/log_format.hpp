// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// Sends the log to the standard error, since scripts read the standard output. `json`: each line is an
/// object of JSON with time (UTC, RFC 3339), level and message; else it is for people. Messages are made
/// printable(): names of files, devices and displays are part of them. Call it once, before other threads
/// run.
void begin_log(bool json);

/// Whether begin_log() chose JSON.
bool logs_json();

}  // namespace fanlight
