// SPDX-License-Identifier: Apache-2.0
// The file that keeps compiled pipelines from one process to the next: used where it fits, never required.
#include "renderer/vulkan/pipeline_cache.hpp"

#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp and setenv

#include <fstream>
#include <string>
#include <vector>

#include "proto/base/crc32c.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::pipeline_cache_tests {
namespace {

const FanGeometry kGeometry{.columns = 32,
                            .rows = 32,
                            .pixel_width_mm = 2,
                            .pixel_height_mm = 2,
                            .face_column = 15.5,
                            .face_row = 0,
                            .motor_radius_mm = 30};

class PipelineCacheTest : public GpuTest {
 protected:
  PipelineCacheTest() {
    std::string name = testing::TempDir() + "fanlight_pipelines_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~PipelineCacheTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  PipelineCache::Config config() {
    return {.folder = folder_ / "fanlight",
            .log = [this](const std::string& sentence) { log_.push_back(sentence); }};
  }
  PipelineCache cache() { return {gpu(), config()}; }

  std::unique_ptr<Renderer> renderer() {
    auto made = Renderer::create({.size = {32, 32},
                                  .geometry = kGeometry,
                                  .first_angle_rad = -0.4,
                                  .last_angle_rad = 0.4,
                                  .frame_capacity = 5,
                                  .pipeline_cache = config()},
                                 {.gpu = gpu(), .counters = counters_},
                                 {.revision = 1, .scene = scene_for(kGeometry, -0.4, 0.4)});
    if (!made) throw std::runtime_error(made.error().message);
    return std::move(*made);
  }

  static std::string contents(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  static void write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
  }

  std::filesystem::path folder_;
  std::vector<std::string> log_;
  RenderCounters counters_;
};

TEST_F(PipelineCacheTest, IsWrittenByARendererAndReadByTheNext) {
  const std::filesystem::path file = cache().file();
  EXPECT_FALSE(cache().loaded());
  EXPECT_FALSE(std::filesystem::exists(file));
  renderer();
  ASSERT_TRUE(std::filesystem::exists(file));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.parent_path()), {}), 1)
      << "no temporary file stays";
  EXPECT_TRUE(cache().loaded());
  renderer();
  EXPECT_TRUE(cache().loaded());
  EXPECT_EQ(log_, std::vector<std::string>());
}

TEST_F(PipelineCacheTest, IsNotWrittenWithoutAFolder) {
  PipelineCache none(gpu(), {});
  none.save();
  EXPECT_TRUE(none.file().empty());
  EXPECT_FALSE(none.loaded());
}

TEST_F(PipelineCacheTest, IsWrittenOnlyWhereItChanged) {
  PipelineCache first = cache();
  first.save();
  ASSERT_TRUE(std::filesystem::remove(first.file()));
  first.save();
  EXPECT_FALSE(std::filesystem::exists(first.file()));
}

TEST_F(PipelineCacheTest, IgnoresADamagedFileAndReplacesIt) {
  renderer();
  const std::filesystem::path file = cache().file();
  const std::string whole = contents(file);
  std::string flipped = whole;
  flipped.back() = static_cast<char>(flipped.back() ^ 1);
  for (const std::string& damaged : {std::string(), std::string("FLPC"), whole.substr(0, whole.size() / 2),
                                     std::string(5000, 'x'), flipped}) {
    write(file, damaged);
    log_.clear();
    EXPECT_FALSE(cache().loaded()) << damaged.size() << " bytes";
    EXPECT_EQ(log_.size(), 1U) << damaged.size() << " bytes";
  }
  renderer();
  EXPECT_TRUE(cache().loaded());
}

TEST_F(PipelineCacheTest, IgnoresTheFileOfAnotherDriver) {
  renderer();
  const std::filesystem::path file = cache().file();
  const std::string whole = contents(file);
  // The file's prefix, then the header of the payload: its length, its version, vendor, device and UUID.
  constexpr std::size_t kPrefixBytes = 8;
  for (const std::size_t at : {4U, 8U, 12U, 16U, 31U}) {
    std::string payload = whole.substr(kPrefixBytes);
    payload[at] = static_cast<char>(payload[at] ^ 0x40);
    const std::uint32_t crc = crc32c({reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()});
    write(file, "FLPC" + std::string(reinterpret_cast<const char*>(&crc), sizeof crc) + payload);
    log_.clear();
    EXPECT_FALSE(cache().loaded()) << "byte " << at;
    EXPECT_EQ(log_.size(), 1U) << "byte " << at;
  }
}

TEST_F(PipelineCacheTest, DoesNotStopARendererWhereItCannotBeWritten) {
  write(folder_ / "fanlight", "a file where the folder would be");
  renderer();
  EXPECT_EQ(log_.size(), 1U) << "one line, also after the renderer has ended";
}

TEST(CacheFolderTest, IsTheUsersCacheFolder) {
  EXPECT_EQ(user_cache_folder("/somewhere", "/home/user"), "/somewhere/fanlight");
  EXPECT_EQ(user_cache_folder("relative", "/home/user"), "/home/user/.cache/fanlight");
  EXPECT_EQ(user_cache_folder("", "/home/user"), "/home/user/.cache/fanlight");
  EXPECT_EQ(user_cache_folder(nullptr, "/home/user"), "/home/user/.cache/fanlight");
  EXPECT_TRUE(user_cache_folder(nullptr, nullptr).empty());
}

TEST_F(PipelineCacheTest, AStoreGivesTheNextRendererThePipelinesOfTheLast) {
  PipelineStore store;
  const auto renderer_with_store = [&] {
    auto made = Renderer::create({.size = {32, 32},
                                  .geometry = kGeometry,
                                  .first_angle_rad = -0.4,
                                  .last_angle_rad = 0.4,
                                  .frame_capacity = 5,
                                  .sampling = Sampling::kGathering,
                                  .rays_by_shader = true},
                                 {.gpu = gpu(), .counters = counters_, .store = &store},
                                 {.revision = 1, .scene = scene_for(kGeometry, -0.4, 0.4)});
    if (!made) throw std::runtime_error(made.error().message);
    return std::move(*made);
  };
  const auto kept = [&](Sampling sampling) { return *store.get(gpu(), {.sampling = sampling, .cache = {}}); };
  renderer_with_store();
  const auto first = kept(Sampling::kGathering);
  EXPECT_EQ(first.use_count(), 2) << "the store and this test: the renderer has ended";
  {
    const auto renderer = renderer_with_store();
    EXPECT_EQ(kept(Sampling::kGathering), first);
    EXPECT_EQ(first.use_count(), 3) << "the renderer took them from the store";
  }
  EXPECT_NE(kept(Sampling::kTexture), first) << "another kind of sampling has pipelines of its own";
  store.clear();
  EXPECT_EQ(first.use_count(), 1);
}

}  // namespace
}  // namespace fanlight::test::pipeline_cache_tests
