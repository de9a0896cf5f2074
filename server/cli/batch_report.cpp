// SPDX-License-Identifier: Apache-2.0
#include "server/cli/batch_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"
#include "server/cli/batch_sweep.hpp"
#include "server/cli/csv_table.hpp"
#include "server/cli/json_text.hpp"

namespace fanlight {

namespace {

using Json = nlohmann::ordered_json;

struct Row {
  const BatchSweep* sweep;
  std::optional<BatchRecord> record;  // absent: not rendered yet, or files of it are gone
  bool is_outdated = false;           // it was asked for otherwise, or of another version

  std::string_view state() const {
    if (!record) return "missing";
    if (is_outdated) return "outdated";
    return record->trouble.empty() ? "done" : "failed";
  }
};

/// The inputs are not read for it.
bool is_outdated(const BatchRecord& record, const BatchSweep& sweep, const std::filesystem::path& folder) {
  SweepOptions asked(sweep);
  return !asked.read(folder) || record.version != version() || record.input != sweep.input ||
         record.options != asked.json();
}

struct Totals {
  std::size_t sweeps = 0;
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t outdated = 0;
  std::size_t volumes = 0;
  std::uint64_t interpolated = 0;
  std::size_t dropped = 0;
  std::uint64_t received = 0;
  std::uint64_t unused = 0;
  std::uint64_t missing = 0;
  std::uint64_t output_bytes = 0;
  double seconds = 0;  // of all machines together
  std::string first_begun;
  std::string last_begun;
  std::set<std::string> devices;
  std::set<std::string> hosts;

  std::size_t missing_sweeps() const { return sweeps - done - failed - outdated; }

  void add(const Row& row) {
    ++sweeps;
    if (!row.record) return;
    const BatchRecord& record = *row.record;
    seconds += record.seconds;
    hosts.insert(record.host);
    ++(row.is_outdated ? outdated : record.trouble.empty() ? done : failed);
    volumes += record.volumes.size();
    interpolated += record.interpolated;
    dropped += record.dropped.size();
    received += record.frames_received;
    unused += record.frames_unused;
    missing += record.frames_missing;
    for (const FileDigest& output : record.outputs) output_bytes += output.bytes;
    if (first_begun.empty() || record.begun < first_begun) first_begun = record.begun;
    last_begun = std::max(last_begun, record.begun);
    if (!record.device.empty()) devices.insert(record.device);
  }
};

Json json_of(const Row& row) {
  Json json = {{"sweep", row.sweep->name}, {"input", row.sweep->input}, {"state", row.state()}};
  if (!row.record) return json;
  const BatchRecord& record = *row.record;
  json.update(Json({{"volumes", record.volumes.size()},
                    {"volumes_interpolated", record.interpolated},
                    {"sweeps_dropped", record.dropped.size()},
                    {"frames_received", record.frames_received},
                    {"frames_unused", record.frames_unused},
                    {"frames_missing", record.frames_missing},
                    {"seconds", record.seconds},
                    {"host", record.host},
                    {"device", record.device},
                    {"shard", record.shard},
                    {"begun", record.begun},
                    {"version", record.version},
                    {"trouble", record.trouble}}));
  return json;
}

Json json_of(const Totals& totals) {
  return {{"sweeps", totals.sweeps},
          {"done", totals.done},
          {"failed", totals.failed},
          {"outdated", totals.outdated},
          {"missing", totals.missing_sweeps()},
          {"volumes", totals.volumes},
          {"volumes_interpolated", totals.interpolated},
          {"sweeps_dropped", totals.dropped},
          {"frames_received", totals.received},
          {"frames_unused", totals.unused},
          {"frames_missing", totals.missing},
          {"output_bytes", totals.output_bytes},
          {"seconds", totals.seconds},
          {"first_begun", totals.first_begun},
          {"last_begun", totals.last_begun},
          {"hosts", totals.hosts},
          {"devices", totals.devices}};
}

void print_csv(std::FILE* out, const std::vector<Row>& rows) {
  // The columns are those of a sweep that was rendered.
  const BatchSweep none;
  const Json all = json_of(Row{.sweep = &none, .record = BatchRecord()});
  std::vector<std::string> names;
  for (const auto& [name, value] : all.items()) names.push_back(name);
  fmt::print(out, "{}\n", fmt::join(names, ","));
  for (const Row& row : rows) {
    const Json json = json_of(row);
    std::vector<std::string> cells;
    for (const std::string& name : names) {
      if (!json.contains(name)) {
        cells.emplace_back();
      } else {
        const Json& value = json.at(name);
        cells.push_back(csv_cell(value.is_string() ? value.get<std::string>() : json_text(value)));
      }
    }
    fmt::print(out, "{}\n", fmt::join(cells, ","));
  }
}

void print_text(std::FILE* out, const std::vector<Row>& rows, const Totals& totals) {
  std::size_t width = 5;
  for (const Row& row : rows) width = std::max(width, printable(row.sweep->name).size());
  fmt::print(out, "{:<{}}  {:<8} {:>7} {:>12} {:>7} {:>8} {:>8} {:>8}\n", "sweep", width, "state", "volumes",
             "interpolated", "dropped", "frames", "missing", "seconds");
  for (const Row& row : rows) {
    const std::string name = printable(row.sweep->name);
    if (!row.record) {
      fmt::print(out, "{:<{}}  {}\n", name, width, row.state());
    } else if (!row.record->trouble.empty()) {
      fmt::print(out, "{:<{}}  {:<8} {}\n", name, width, row.state(), printable(row.record->trouble));
    } else {
      const BatchRecord& record = *row.record;
      fmt::print(out, "{:<{}}  {:<8} {:>7} {:>12} {:>7} {:>8} {:>8} {:>8.1f}\n", name, width, row.state(),
                 record.volumes.size(), record.interpolated, record.dropped.size(), record.frames_received,
                 record.frames_missing, record.seconds);
    }
  }
  fmt::print(out, "{:<{}}  {:<8} {:>7} {:>12} {:>7} {:>8} {:>8} {:>8.1f}\n", "total", width, "",
             totals.volumes, totals.interpolated, totals.dropped, totals.received, totals.missing,
             totals.seconds);
  fmt::print(
      out,
      "{} of {} sweeps done, {} failed, {} not rendered yet, {} outdated; {} of the frames in no volume\n",
      totals.done, totals.sweeps, totals.failed, totals.missing_sweeps(), totals.outdated, totals.unused);
  if (totals.hosts.empty()) return;
  fmt::print(out, "{:.1f} MB of outputs; begun from {} to {}, on {} ({})\n",
             static_cast<double>(totals.output_bytes) * 1e-6, totals.first_begun, totals.last_begun,
             fmt::join(totals.hosts, ", "), fmt::join(totals.devices, ", "));
  if (totals.devices.size() > 1)
    fmt::print(out, "Pictures of different devices may differ in the last bits.\n");
}

}  // namespace

Result<void> print_batch_report(std::FILE* out, const BatchManifest& manifest, BatchTable table) {
  std::vector<Row> rows;
  rows.reserve(manifest.sweeps.size());
  Totals totals;
  for (const BatchSweep& sweep : manifest.sweeps) {
    Row row{.sweep = &sweep, .record = read_record(record_path(manifest.folder, sweep))};
    if (row.record && !has_outputs(*row.record, manifest.folder)) row.record.reset();
    row.is_outdated = row.record && is_outdated(*row.record, sweep, manifest.folder);
    rows.push_back(std::move(row));
    totals.add(rows.back());
  }
  if (table == BatchTable::kCsv) print_csv(out, rows);
  if (table == BatchTable::kText) print_text(out, rows, totals);
  if (table == BatchTable::kJson) {
    Json list = Json::array();
    for (const Row& row : rows) list.push_back(json_of(row));
    fmt::print(out, "{}\n", json_text({{"sweeps", list}, {"totals", json_of(totals)}}));
  }
  if (totals.done == totals.sweeps) return {};
  return Error{
      ErrorCode::kNotFound,
      fmt::format("of {} sweeps {} failed, {} are not rendered yet, and {} are of other options or of "
                  "another version; expected all to be done",
                  totals.sweeps, totals.failed, totals.missing_sweeps(), totals.outdated)};
}

}  // namespace fanlight
