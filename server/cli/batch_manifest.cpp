// SPDX-License-Identifier: Apache-2.0
#include "server/cli/batch_manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "acquisition/source/printable.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/csv_table.hpp"

namespace fanlight {

namespace {

constexpr std::uintmax_t kMostBytes = 256'000'000;
constexpr std::uint32_t kMostShards = 1'000'000;

Error bad(const std::string& place, const std::string& wrong) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}: {}", place, wrong)};
}

/// "liver-001.igs.mha" -> "liver-001".
std::string usual_name(const std::string& input) {
  std::string name = std::filesystem::path(input).filename().string();
  if (name.empty()) name = std::filesystem::path(input).parent_path().filename().string();
  for (const std::string_view ending : {".mha", ".mhd", ".nrrd", ".nhdr", ".vol", ".dcm", ".igs", ".seq"}) {
    if (name.ends_with(ending)) name.erase(name.size() - ending.size());
  }
  return name;
}

/// Takes a value that is no option of `fanlight render`: the input and the name.
void take(BatchSweep& sweep, ConfiguredOption option) {
  if (option.name == "input") {
    sweep.input = std::move(option.value);
  } else if (option.name == "name") {
    sweep.name = std::move(option.value);
  } else {
    sweep.given.push_back(std::move(option));
  }
}

Result<void> complete(BatchSweep& sweep, const std::filesystem::path& folder) {
  sweep.folder = folder;
  if (sweep.input.empty()) return bad(sweep.from, "the sweep has no input, expected a recording");
  if (sweep.input.starts_with("usb:") || sweep.input.starts_with("igtl:"))
    return bad(sweep.from, fmt::format("{} is live, expected a recording", printable(sweep.input)));
  if (sweep.is_simulated() && sweep.name.empty())
    return bad(sweep.from, "a simulated sweep needs a name, expected name");
  if (sweep.input.starts_with("replay:")) sweep.input.erase(0, std::string_view("replay:").size());
  if (sweep.name.empty()) sweep.name = usual_name(sweep.input);
  return {};
}

/// "a.0017" -> "a": the name of a sweep that may have such an output; empty: none.
std::string without_number(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos || dot + 1 == name.size()) return {};
  const bool is_number =
      std::ranges::all_of(name.substr(dot + 1), [](unsigned char c) { return c >= '0' && c <= '9'; });
  return is_number ? name.substr(0, dot) : std::string();
}

Result<void> check_names(const BatchManifest& manifest) {
  if (manifest.sweeps.empty())
    return bad(printable(manifest.path.string()),
               "there is no sweep, expected [[sweep]] with input = \"...\", or a table with a column input");
  std::map<std::string, const BatchSweep*> names;
  for (const BatchSweep& sweep : manifest.sweeps) {
    if (!stays_inside(sweep.name))
      return bad(sweep.from, fmt::format("the name {} does not stay in the folder of the outputs, expected "
                                         "one such as ward-3/liver-001",
                                         in_quotes(sweep.name)));
    const auto [other, is_new] = names.emplace(sweep.name, &sweep);
    if (!is_new)
      return bad(sweep.from, fmt::format("the name {} is that of the sweep at {}, expected another name",
                                         in_quotes(sweep.name), other->second->from));
  }
  for (const BatchSweep& sweep : manifest.sweeps) {
    const auto other = names.find(without_number(sweep.name));
    if (other != names.end())
      return bad(sweep.from, fmt::format("{} may be an output of the sweep at {}, expected another name",
                                         in_quotes(sweep.name), other->second->from));
  }
  return {};
}

/// "sweep.17.size" -> 17 and "size"; "sweep.17", an empty [[sweep]], -> 17 and "".
std::optional<std::pair<std::size_t, std::string>> in_sweep(const std::string& name) {
  constexpr std::string_view kSweep = "sweep.";
  if (!name.starts_with(kSweep)) return std::nullopt;
  std::size_t number = 0;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + kSweep.size(), end, number);
  if (read.ec != std::errc{}) return std::nullopt;
  if (read.ptr == end) return std::pair(number, std::string());
  if (*read.ptr != '.') return std::nullopt;
  return std::pair(number, std::string(read.ptr + 1, end));
}

Result<void> read_toml(BatchManifest& manifest) {
  auto options = read_configuration(
      manifest.path, {.name = "manifest", .line = "input = \"liver.igs.mha\"", .most_bytes = kMostBytes});
  if (!options) return options.error();
  std::vector<ConfiguredOption> for_all;
  for (ConfiguredOption& option : *options) {
    constexpr std::string_view kAll = "all.";
    if (option.name == "folder") {
      manifest.folder = manifest.path.parent_path() / option.value;
    } else if (option.name.starts_with(kAll)) {
      option.name.erase(0, kAll.size());
      for_all.push_back(std::move(option));
    } else if (auto place = in_sweep(option.name); place && place->first < options->size()) {
      manifest.sweeps.resize(std::max(manifest.sweeps.size(), place->first + 1));
      BatchSweep& sweep = manifest.sweeps[place->first];
      if (sweep.from.empty()) sweep.from = option.from;
      option.name = std::move(place->second);
      if (!option.name.empty()) take(sweep, std::move(option));
    } else {
      return bad(option.from,
                 fmt::format("there is no {}, expected folder, [all] and [[sweep]]", printable(option.name)));
    }
  }
  for (BatchSweep& sweep : manifest.sweeps) {
    sweep.given.insert(sweep.given.end(), for_all.begin(), for_all.end());
  }
  return {};
}

Result<std::string> text_of(const std::filesystem::path& path) {
  std::error_code failure;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failure);
  std::ifstream file(path, std::ios::binary);
  if (failure || !file || bytes > kMostBytes)
    return bad(printable(path.string()), "it cannot be read, expected a table of at most 256 MB");
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Result<void> read_table(BatchManifest& manifest) {
  const std::string name = printable(manifest.path.string());
  const auto text = text_of(manifest.path);
  if (!text) return text.error();
  auto rows = parse_csv(*text);
  if (!rows) return bad(name, rows.error().message);
  if (rows->empty()) return {};
  const std::vector<std::string> columns = rows->front().cells;
  if (std::ranges::find(columns, "input") == columns.end())
    return bad(name,
               "the first row has no column input, expected input, name and options of fanlight render");
  for (auto column = columns.begin(); column != columns.end(); ++column) {
    if (std::find(columns.begin(), column, *column) != column)
      return bad(name, fmt::format("there are two columns {}, expected one", in_quotes(*column)));
  }
  for (auto row = rows->begin() + 1; row != rows->end(); ++row) {
    BatchSweep sweep;
    sweep.from = fmt::format("{}, line {}", name, row->line);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!row->cells[i].empty())
        take(sweep, {.name = columns[i], .value = std::move(row->cells[i]), .from = sweep.from});
    }
    manifest.sweeps.push_back(std::move(sweep));
  }
  return {};
}

}  // namespace

bool stays_inside(const std::string& name) {
  const std::filesystem::path path(name);
  const bool is_printable = std::ranges::none_of(name, [](unsigned char c) { return c < ' ' || c == 0x7f; });
  return !name.empty() && is_printable && path.is_relative() && path.has_filename() &&
         std::ranges::none_of(path, [](const auto& part) { return part == ".." || part == "."; }) &&
         path == path.lexically_normal();
}

Result<BatchManifest> read_manifest(const std::filesystem::path& path) {
  BatchManifest manifest{.path = path, .folder = path.parent_path(), .sweeps = {}};
  auto read =
      path.extension() == ".csv" || path.extension() == ".CSV" ? read_table(manifest) : read_toml(manifest);
  if (!read) return read.error();
  if (manifest.folder.empty()) manifest.folder = std::filesystem::path(".");
  for (BatchSweep& sweep : manifest.sweeps) {
    if (auto whole = complete(sweep, path.parent_path()); !whole) return whole.error();
  }
  if (auto named = check_names(manifest); !named) return named.error();
  return manifest;
}

Result<Shard> parse_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto index = std::from_chars(text.data(), end, shard.index);
  const bool has_stroke = index.ec == std::errc{} && index.ptr != end && *index.ptr == '/';
  const auto count = has_stroke ? std::from_chars(index.ptr + 1, end, shard.count) : index;
  if (!has_stroke || count.ec != std::errc{} || count.ptr != end || shard.index < 1 ||
      shard.index > shard.count || shard.count > kMostShards) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("the shard is {}, expected I/N such as 2/16, with I from 1 to N", in_quotes(text))};
  }
  return shard;
}

}  // namespace fanlight
