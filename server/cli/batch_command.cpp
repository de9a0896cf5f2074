// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/batch_report.hpp"
#include "server/cli/batch_sweep.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/end_signals.hpp"
#include "server/cli/json_text.hpp"

namespace fanlight {

namespace {

// Where the outputs cannot be written, or there is no GPU, every sweep fails; another machine may do better.
constexpr std::uint32_t kMostTroubles = 3;

struct BatchOptions {
  std::string manifest;
  std::string shard = "1/1";
  std::string folder;
  std::string gpu;
  bool report = false;
  bool json = false;
  bool csv = false;
};

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

struct BatchTotals {
  std::uint64_t sweeps = 0;
  std::uint64_t rendered = 0;
  std::uint64_t there = 0;
  std::uint64_t failed = 0;
  std::uint64_t troubled = 0;  // by this machine; they have no record
  std::uint64_t volumes = 0;   // rendered now
};

void print_totals(const BatchOptions& options, const BatchTotals& totals, double seconds) {
  if (options.json) {
    fmt::print("{}\n", json_text({{"shard", options.shard},
                                  {"sweeps", totals.sweeps},
                                  {"rendered", totals.rendered},
                                  {"there_already", totals.there},
                                  {"failed", totals.failed},
                                  {"troubled", totals.troubled},
                                  {"volumes", totals.volumes},
                                  {"seconds", seconds}}));
    return;
  }
  fmt::print("shard {}: {} sweeps: {} rendered, {} there already, {} failed; {} volumes in {:.1f} s\n",
             options.shard, totals.sweeps, totals.rendered, totals.there, totals.failed, totals.volumes,
             seconds);
}

class BatchShard {
 public:
  BatchShard(const BatchOptions& options, const BatchManifest& manifest, Shard shard)
      : options_(options), manifest_(manifest), shard_(shard) {
    run_.folder = manifest.folder;
    run_.gpu = options.gpu;
    run_.host = host_name();
    run_.shard = options.shard;
    run_.stopped = [this] { return signals_.wait_ms(0); };
  }

  /// Before anything is rendered: a mistake in the manifest is reported at once.
  Result<void> check() const {
    for (std::size_t i = 0; i < manifest_.sweeps.size(); ++i) {
      if (!shard_.has(i)) continue;
      SweepOptions asked(manifest_.sweeps[i]);
      if (auto read = asked.read(run_.folder); !read) return read;
    }
    return {};
  }

  Result<void> render() {
    const std::int64_t begun_ns = now_ns();
    Result<void> ended;
    for (std::size_t i = 0; i < manifest_.sweeps.size() && ended; ++i) {
      if (!shard_.has(i)) continue;
      if (run_.stopped()) {
        ended = Error{ErrorCode::kStopped, "stopped, expected another run for what is left"};
      } else {
        ended = take(manifest_.sweeps[i]);
      }
    }
    print_totals(options_, totals_, static_cast<double>(now_ns() - begun_ns) * 1e-9);
    if (!ended || totals_.troubled == 0) return ended;
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} sweeps were not rendered because of trouble that another run may not have, "
                             "expected that run",
                             totals_.troubled)};
  }

 private:
  /// A library that throws ends its sweep, and not the shard.
  Result<SweepEnd> rendered(const BatchSweep& sweep, BatchRecord& record) {
    try {
      return render_sweep(sweep, run_, record);
    } catch (const std::exception& failure) {
      return Error{ErrorCode::kUnavailable, failure.what()};
    }
  }

  Result<void> take(const BatchSweep& sweep) {
    ++totals_.sweeps;
    BatchRecord record;
    run_.is_in_trouble = false;
    const auto end = rendered(sweep, record);
    const std::string name = printable(sweep.name);
    if (!end) {
      if (end.error().code == ErrorCode::kStopped) return end.error();
      ++totals_.troubled;
      fmt::print(stderr, "{}: {}\n", name, printable(end.error().message));
      run_.pipelines.clear();
      run_.device.reset();
      troubles_ = run_.is_in_trouble ? troubles_ + 1 : 0;
      return troubles_ < kMostTroubles ? Result<void>() : end.error();
    }
    troubles_ = 0;
    switch (*end) {
      case SweepEnd::kRendered:
        ++totals_.rendered;
        totals_.volumes += record.volumes.size();
        fmt::print(stderr, "{}: {} volume{} in {:.1f} s\n", name, record.volumes.size(),
                   record.volumes.size() == 1 ? "" : "s", record.seconds);
        break;
      case SweepEnd::kThere:
        ++totals_.there;
        fmt::print(stderr, "{}: there already\n", name);
        break;
      case SweepEnd::kFailed:
        ++totals_.failed;
        fmt::print(stderr, "{}: failed: {}\n", name, printable(record.trouble));
        break;
    }
    return {};
  }

  const BatchOptions& options_;
  const BatchManifest& manifest_;
  Shard shard_;
  EndSignals signals_;
  BatchRun run_;
  BatchTotals totals_;
  std::uint32_t troubles_ = 0;  // one after the other
};

Result<void> batch(const BatchOptions& options) {
  const auto shard = parse_shard(options.shard);
  if (!shard) return shard.error();
  auto manifest = read_manifest(options.manifest);
  if (!manifest) return manifest.error();
  if (!options.folder.empty()) manifest->folder = options.folder;
  if (options.report) {
    const BatchTable table = options.csv    ? BatchTable::kCsv
                             : options.json ? BatchTable::kJson
                                            : BatchTable::kText;
    return print_batch_report(stdout, *manifest, table);
  }
  BatchShard work(options, *manifest, *shard);
  if (auto good = work.check(); !good) return good;
  return work.render();
}

}  // namespace

Command add_batch_command(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("batch", "Render many recordings, in shards that can run on any machine");
  const auto options = std::make_shared<BatchOptions>();
  command->option_defaults()->group("Batch");
  command
      ->add_option("MANIFEST", options->manifest,
                   "List of recordings: a TOML file with one [[sweep]] each, or a table (.csv) with the "
                   "columns input, name and options of fanlight render")
      ->required()
      ->type_name("MANIFEST");
  command
      ->add_option("--shard", options->shard,
                   "Render shard I of N, such as 2/16; existing outputs are skipped")
      ->capture_default_str()
      ->type_name("I/N");
  command
      ->add_option("--folder", options->folder, "Folder for the outputs, instead of the one in the manifest")
      ->type_name("FOLDER");
  command->add_option("--gpu", options->gpu, "GPU to use, by a part of its name")->type_name("NAME");
  auto* const report = command->add_flag("--report", options->report,
                                         "Render nothing; print the results of all shards as one table");
  auto* const csv = command->add_flag("--csv", options->csv, "Print the table as comma-separated values");
  csv->needs(report);
  command->add_flag("--json", options->json, "Print the totals of the shard, or the table, as JSON")
      ->excludes(csv);
  return [options]() { return batch(*options); };
}

}  // namespace fanlight
