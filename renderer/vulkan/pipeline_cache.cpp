// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/pipeline_cache.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "proto/base/crc32c.hpp"

namespace fanlight {

namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'F', 'L', 'P', 'C'};
constexpr std::size_t kPrefixBytes = kMagic.size() + sizeof(std::uint32_t);
// Far more than the pipelines of this program; a larger file is not ours.
constexpr std::uintmax_t kMostBytes = 256 << 20;

/// Why the payload does not serve this GPU and driver; empty where it does.
std::string mismatch(std::span<const std::uint8_t> payload, const VkPhysicalDeviceProperties& gpu) {
  VkPipelineCacheHeaderVersionOne header{};
  if (payload.size() < sizeof header) return "it is too short";
  std::memcpy(&header, payload.data(), sizeof header);
  if (header.headerSize < sizeof header || header.headerVersion != VK_PIPELINE_CACHE_HEADER_VERSION_ONE) {
    return "its header is of an unknown version";
  }
  const bool same = header.vendorID == gpu.vendorID && header.deviceID == gpu.deviceID &&
                    std::ranges::equal(header.pipelineCacheUUID, gpu.pipelineCacheUUID);
  return same ? "" : "it is of another GPU or driver";
}

PipelineCacheHandle create_cache(VkDevice device, std::span<const std::uint8_t> payload) {
  const VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                       .initialDataSize = payload.size(),
                                       .pInitialData = payload.empty() ? nullptr : payload.data()};
  VkPipelineCache cache = VK_NULL_HANDLE;
  if (vkCreatePipelineCache(device, &info, nullptr, &cache) != VK_SUCCESS) return {};
  return {device, cache};
}

bool write_all(int file, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// Replaces the file atomically: readers see the old contents or the new ones. Error: errno.
int replace_file(const std::filesystem::path& path, std::span<const std::uint8_t> prefix,
                 std::span<const std::uint8_t> payload) {
  // A name of its own: processes in containers may share the folder and the process id.
  std::string temporary = path.string() + ".XXXXXX";
  const int file = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (file < 0) return errno;
  errno = EIO;  // for a write that takes nothing and gives no reason
  int error = write_all(file, prefix) && write_all(file, payload) ? 0 : errno;
  // Some file systems know no fsync; the checksum finds a file that a crash cut short.
  if (error == 0 && ::fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP) error = errno;
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) ::unlink(temporary.c_str());
  return error;
}

}  // namespace

PipelineCache::PipelineCache(const Gpu& gpu, Config config) : gpu_(gpu), config_(std::move(config)) {
  if (!config_.folder.empty()) {
    file_ = config_.folder /
            fmt::format("pipelines-{:08x}-{:08x}.bin", gpu.properties().vendorID, gpu.properties().deviceID);
  }
  const std::vector<std::uint8_t> payload = read_file();
  if (!payload.empty()) {
    cache_ = create_cache(gpu.device(), payload);
    loaded_ = cache_.get() != VK_NULL_HANDLE;
    if (loaded_) stored_crc_ = crc32c(payload);
  }
  if (!loaded_) cache_ = create_cache(gpu.device(), {});
}

std::vector<std::uint8_t> PipelineCache::read_file() const {
  std::error_code error;
  if (file_.empty() || !std::filesystem::is_regular_file(file_, error)) return {};
  const auto refused = [this](const std::string& reason) {
    log(fmt::format("the pipeline cache {} is not used: {}", file_.string(), reason));
    return std::vector<std::uint8_t>{};
  };
  const std::uintmax_t bytes = std::filesystem::file_size(file_, error);
  if (error) return refused(error.message());
  if (bytes < kPrefixBytes) return refused("it is too short");
  if (bytes > kMostBytes) return refused("it is too long");
  std::ifstream stream(file_, std::ios::binary);
  std::array<std::uint8_t, kPrefixBytes> prefix{};
  std::vector<std::uint8_t> payload(bytes - prefix.size());
  stream.read(reinterpret_cast<char*>(prefix.data()), static_cast<std::streamsize>(prefix.size()));
  stream.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
  if (!stream) return refused("it cannot be read");
  std::uint32_t crc = 0;
  std::memcpy(&crc, prefix.data() + kMagic.size(), sizeof crc);
  if (!std::equal(kMagic.begin(), kMagic.end(), prefix.begin()) || crc != crc32c(payload)) {
    return refused("it is damaged");
  }
  if (const std::string reason = mismatch(payload, gpu_.properties()); !reason.empty())
    return refused(reason);
  return payload;
}

void PipelineCache::save() {
  if (file_.empty() || unwritable_ || cache_.get() == VK_NULL_HANDLE) return;
  std::size_t bytes = 0;
  if (vkGetPipelineCacheData(gpu_.device(), cache_.get(), &bytes, nullptr) != VK_SUCCESS) return;
  std::vector<std::uint8_t> payload(bytes);
  if (vkGetPipelineCacheData(gpu_.device(), cache_.get(), &bytes, payload.data()) != VK_SUCCESS) return;
  payload.resize(bytes);
  const std::uint32_t crc = crc32c(payload);
  if (crc == stored_crc_) return;
  std::array<std::uint8_t, kPrefixBytes> prefix{};
  std::ranges::copy(kMagic, prefix.begin());
  std::memcpy(prefix.data() + kMagic.size(), &crc, sizeof crc);
  std::error_code error;
  std::filesystem::create_directories(config_.folder, error);
  if (!error) error.assign(replace_file(file_, prefix, payload), std::generic_category());
  if (error) {
    unwritable_ = true;
    log(fmt::format("the pipeline cache {} is not written: {}", file_.string(), error.message()));
    return;
  }
  stored_crc_ = crc;
}

void PipelineCache::log(const std::string& sentence) const {
  if (config_.log) config_.log(sentence);
}

std::filesystem::path user_cache_folder(const char* xdg_cache_home, const char* home) {
  const auto is_absolute = [](const char* path) { return path != nullptr && *path == '/'; };
  if (is_absolute(xdg_cache_home)) return std::filesystem::path(xdg_cache_home) / "fanlight";
  if (is_absolute(home)) return std::filesystem::path(home) / ".cache" / "fanlight";
  return {};
}

}  // namespace fanlight
