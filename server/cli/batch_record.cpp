// SPDX-License-Identifier: Apache-2.0
#include "server/cli/batch_record.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <system_error>

#include "proto/base/printable.hpp"
#include "server/access/digest.hpp"

namespace fanlight {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::vector<FileDigest>& files) {
  Json list = Json::array();
  for (const FileDigest& each : files)
    list.push_back({{"file", each.file}, {"bytes", each.bytes}, {"sha256", each.sha256}});
  return list;
}

std::vector<FileDigest> files_of(const Json& list) {
  std::vector<FileDigest> files;
  for (const Json& each : list)
    files.push_back({.file = each.at("file"), .bytes = each.at("bytes"), .sha256 = each.at("sha256")});
  return files;
}

/// Throws where a value lacks, or is of another kind.
BatchRecord record_of(const Json& json) {
  BatchRecord record;
  const Json& request = json.at("request");
  record.version = request.at("version");
  record.input = request.at("input");
  record.options = request.at("options");
  record.inputs = files_of(request.at("inputs"));
  record.trouble = json.at("trouble");
  record.outputs = files_of(json.at("outputs"));
  record.volumes = json.at("volumes");
  record.interpolated = json.at("volumes_interpolated");
  record.frames_received = json.at("frames_received");
  record.frames_unused = json.at("frames_unused");
  record.frames_missing = json.at("frames_missing");
  record.dropped = json.at("dropped");
  record.notes = json.at("notes");
  const Json& run = json.at("run");
  record.device = run.at("device");
  record.host = run.at("host");
  record.shard = run.at("shard");
  record.begun = run.at("begun");
  record.seconds = run.at("seconds");
  return record;
}

}  // namespace

Result<FileDigest> digest_of(const std::filesystem::path& path, const std::string& name) {
  constexpr std::size_t kPieceBytes = 1 << 20;
  const auto unreadable = [&path](int failure) {
    const bool is_gone = failure == ENOENT || failure == ENOTDIR || failure == EACCES || failure == EISDIR;
    return Error{is_gone ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
                 fmt::format("{} cannot be read ({}), expected a file that can", printable(path.string()),
                             std::generic_category().message(failure))};
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return unreadable(errno);
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::vector<char> piece(kPieceBytes);
  FileDigest digest{.file = name, .bytes = 0, .sha256 = {}};
  bool good = context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1;
  while (good && file) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto bytes = static_cast<std::size_t>(file.gcount());
    digest.bytes += bytes;
    good = EVP_DigestUpdate(context.get(), piece.data(), bytes) == 1;
  }
  std::array<std::uint8_t, 32> value{};
  good = good && EVP_DigestFinal_ex(context.get(), value.data(), nullptr) == 1;
  if (!good) return Error{ErrorCode::kUnavailable, "OpenSSL cannot compute a SHA-256, expected it to"};
  if (file.bad()) return unreadable(errno);
  digest.sha256 = hex(value);
  return digest;
}

Json json_of(const BatchRecord& record) {
  return {{"request",
           {{"version", record.version},
            {"input", record.input},
            {"options", record.options},
            {"inputs", json_of(record.inputs)}}},
          {"trouble", record.trouble},
          {"outputs", json_of(record.outputs)},
          {"volumes", record.volumes},
          {"volumes_interpolated", record.interpolated},
          {"frames_received", record.frames_received},
          {"frames_unused", record.frames_unused},
          {"frames_missing", record.frames_missing},
          {"dropped", record.dropped},
          {"notes", record.notes},
          {"run",
           {{"device", record.device},
            {"host", record.host},
            {"shard", record.shard},
            {"begun", record.begun},
            {"seconds", record.seconds}}}};
}

std::optional<BatchRecord> read_record(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string text(std::istreambuf_iterator<char>(file), {});
  try {
    return record_of(Json::parse(text));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

bool has_outputs(const BatchRecord& record, const std::filesystem::path& folder) {
  return std::ranges::all_of(record.outputs, [&folder](const FileDigest& output) {
    std::error_code failure;
    return std::filesystem::file_size(folder / output.file, failure) == output.bytes && !failure;
  });
}

}  // namespace fanlight
