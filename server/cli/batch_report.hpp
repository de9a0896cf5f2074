// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "proto/base/result.hpp"
#include "server/cli/batch_manifest.hpp"

namespace fanlight {

/// How `fanlight batch --report` writes its table.
enum class BatchTable : std::uint8_t { kText, kCsv, kJson };

/// Merges the records of all sweeps of a manifest, whichever shard wrote them, into one table: a line for
/// each sweep, then the totals. A record of other options or of another version than asked for now is
/// outdated. Error, kNotFound: not all sweeps are done.
Result<void> print_batch_report(std::FILE* out, const BatchManifest& manifest, BatchTable table);

}  // namespace fanlight
