// SPDX-License-Identifier: Apache-2.0
// What the depth map of a surface takes as bytes and time in several codings: that of SurfaceCoder, and
// others that were tried. Depth maps of the simulated probe, each in steps of the size that SurfaceCoder
// chooses.
#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "renderer/render_once.hpp"
#include "server/codec/surface_coder.hpp"
#ifdef FANLIGHT_HAVE_ZSTD
#include <zstd.h>
#endif

namespace fanlight {
namespace {

using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void fail(const Error& error) {
  fmt::print(stderr, "surface_codecs: {}\n", error.message);
  std::exit(1);
}

template <typename T>
T required(Result<T> result) {
  if (!result) fail(result.error());
  return std::move(result).value();
}

Picture rendered(const std::string& scene, std::uint32_t side) {
  auto config = required(parse_phantom("scene=" + scene, usual_phantom()));
  config.pace = PhantomSource::Pace::kUnpaced;
  const auto source = required(PhantomSource::create(config));
  const SourceDescription& description = source->description();
  Volume volume(description.geometry, description.frames_per_volume);
  while (!volume.full()) {
    const auto frame = source->next_frame({});
    source->read_pixels(volume.next_frame_pixels(), {});
    volume.add_frame(**frame);
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;
  const auto instance = required(GpuInstance::create({}));
  const auto gpu = required(Gpu::create(*instance, ""));
  RenderCounters counters;
  const auto renderer = required(Renderer::create(
      {.size = {side, side},
       .geometry = description.geometry,
       .first_angle_rad = description.first_angle_rad,
       .last_angle_rad = description.last_angle_rad,
       .frame_capacity = description.frames_per_volume},
      {.gpu = *gpu, .counters = counters}, {.revision = 1, .scene = suggested_scene(description, side)}));
  return required(render_once(*renderer, volume));
}

/// The depths in steps; 65535: no surface.
std::vector<std::uint16_t> words_of(const Picture& picture, double unit_mm) {
  std::vector<std::uint16_t> words;
  for (const float depth_mm : picture.depth_mm)
    words.push_back(depth_mm < 0 ? 65535 : static_cast<std::uint16_t>(std::lround(depth_mm / unit_mm)));
  return words;
}

/// Differences from a prediction, folded, a byte each; larger ones as 255 with two bytes at the end. `plane`:
/// left + above - above left; else the median predictor of JPEG-LS.
Bytes differences(const std::vector<std::uint16_t>& words, std::size_t width, bool plane) {
  Bytes bytes;
  Bytes large;
  bytes.reserve(words.size() + words.size() / 8);
  for (std::size_t at = 0; at < words.size(); ++at) {
    const bool first = at % width == 0;
    const int above = at >= width ? words[at - width] : 0;
    const int left = first ? above : words[at - 1];
    const int corner = first || at < width ? above : words[at - width - 1];
    const int planar = left + above - corner;
    const int predicted = plane ? planar : std::clamp(planar, std::min(left, above), std::max(left, above));
    const auto signed_difference = static_cast<std::int16_t>(words[at] - predicted);
    const auto folded = static_cast<std::uint16_t>((signed_difference << 1) ^ (signed_difference >> 15));
    bytes.push_back(static_cast<std::uint8_t>(std::min<int>(folded, 255)));
    if (folded < 255) continue;
    large.push_back(static_cast<std::uint8_t>(folded & 255));
    large.push_back(static_cast<std::uint8_t>(folded >> 8));
  }
  bytes.insert(bytes.end(), large.begin(), large.end());
  return bytes;
}

std::size_t deflated(const Bytes& bytes, int level, int strategy) {
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, 15, 9, strategy) != Z_OK) std::abort();
  Bytes packed(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  deflateEnd(&stream);
  return stream.total_out;
}

std::size_t png16(const std::vector<std::uint16_t>& words, std::uint32_t side) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = side;
  image.format = PNG_FORMAT_LINEAR_Y;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t bytes = 0;
  if (png_image_write_get_memory_size(image, bytes, 0, words.data(), 0, nullptr) == 0) std::abort();
  return bytes;
}

void measure(const char* what, int rounds, const std::function<std::size_t()>& run) {
  std::vector<double> times_ms;
  std::size_t bytes = 0;
  for (int round = 0; round < rounds; ++round) {
    const auto from = std::chrono::steady_clock::now();
    bytes = run();
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count());
  }
  std::ranges::nth_element(times_ms, times_ms.begin() + rounds / 2);
  const double median_ms = times_ms[static_cast<std::size_t>(rounds) / 2];
  fmt::print("  {:<52} {:8.1f} KB {:7.2f} ms\n", what, static_cast<double>(bytes) / 1000, median_ms);
}

void compare(const std::string& scene, std::uint32_t side, int rounds) {
  const Picture picture = rendered(scene, side);
  SurfaceCoder coder;
  v1::Surface surface;
  if (auto packed = coder.encode(picture, surface); !packed) fail(packed.error());
  const auto words = words_of(picture, surface.depth_unit_mm());
  fmt::print("{}, {} x {}, {:.0f} % surface, steps of {:.4f} mm\n", scene, side, side,
             100 * picture.stamp.surface_share, surface.depth_unit_mm());
  measure("as sent: plane, runs, two kinds, Huffman; certainties", rounds, [&] {
    if (auto packed = coder.encode(picture, surface); !packed) fail(packed.error());
    return surface.ByteSizeLong();
  });
  fmt::print("  {:<52} {:8.1f} KB\n", "  of that the certainties",
             static_cast<double>(surface.certainties().size()) / 1000);
  for (const bool plane : {true, false}) {
    const char* const name = plane ? "plane" : "JPEG-LS's predictor";
    measure(fmt::format("{}, Huffman codes alone", name).c_str(), rounds,
            [&] { return deflated(differences(words, side, plane), 1, Z_HUFFMAN_ONLY); });
    measure(fmt::format("{}, deflate 1", name).c_str(), rounds,
            [&] { return deflated(differences(words, side, plane), 1, Z_DEFAULT_STRATEGY); });
#ifdef FANLIGHT_HAVE_ZSTD
    for (const int level : {1, 3}) {
      measure(fmt::format("{}, zstd {}", name, level).c_str(), rounds, [&] {
        const Bytes bytes = differences(words, side, plane);
        Bytes packed(ZSTD_compressBound(bytes.size()));
        return ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
      });
    }
#endif
  }
  measure("PNG of 16 bits, fast", rounds, [&] { return png16(words, side); });
}

}  // namespace
}  // namespace fanlight

int main(int count, char** arguments) {
  int rounds = 25;
  CLI::App program("What the depth map of a surface takes in several codings");
  program.add_option("--rounds", rounds, "How often each is timed")->check(CLI::Range(1, 1000));
  CLI11_PARSE(program, count, arguments);
  for (const std::uint32_t side : {512U, 1024U})
    for (const char* const scene : {"face", "womb"}) fanlight::compare(scene, side, rounds);
  return 0;
}
