// SPDX-License-Identifier: Apache-2.0
// Compares pictures of the simulated probe's scenes, at rest and speckled, with pictures of their true
// surfaces from the same view under the same light, which the CPU twin of passes 2 and 3 draws. Prints a
// table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <string>

#include "acquisition/phantom/phantom_options.hpp"
#include "server/cli/picture_file.hpp"
#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/depth_normals.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/face_features.hpp"
#include "tests/accuracy/figure_table.hpp"
#include "tests/accuracy/flip.hpp"
#include "tests/accuracy/methods.hpp"
#include "tests/accuracy/phantom_truth.hpp"
#include "tests/accuracy/picture_likeness.hpp"
#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {
namespace {

constexpr PictureSize kSize{.width = 320, .height = 320};

constexpr std::string_view kGuarded = "face/r2/default/front";

struct View {
  std::string_view name;
  double yaw_deg;
  double pitch_deg;
};
constexpr View kViews[] = {{"front", 0, 0}, {"left", 25, 0}, {"above", 0, 25}};

constexpr FaceFeature kFeatures[] = {
    {.name = "nose", .right_mm = -21, .up_mm = -18, .within_mm = 8, .ring_mm = 9},
    {.name = "lips", .right_mm = -20, .up_mm = -30, .within_mm = 4, .ring_mm = 3.5, .is_groove = true},
    {.name = "brow", .right_mm = -2, .up_mm = 12, .within_mm = 7, .ring_mm = 9}};

struct Work {
  std::string name;
  std::string options;  // of the simulated probe
  bool moves = false;
};

/// The true depth of each pixel, kNoSurface without a surface.
std::vector<double> depths_of(const std::vector<PixelTruth>& truth) {
  std::vector<double> depths;
  for (const PixelTruth& pixel : truth) {
    const bool has_surface = pixel.meets == Meets::kSurface || pixel.meets == Meets::kBorder;
    depths.push_back(has_surface ? pixel.depth_mm : kNoSurface);
  }
  return depths;
}

double brightness(const Rgb& colour) {
  return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b;  // Rec. 709
}

std::vector<Rgb> colours(const Picture& picture) {
  std::vector<Rgb> values;
  for (std::size_t i = 0; i + 3 < picture.rgba.size(); i += 4)
    values.push_back(Rgb(picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]) / 255.0);
  return values;
}

std::vector<double> brightnesses(const std::vector<Rgb>& colours) {
  std::vector<double> values;
  for (const Rgb& colour : colours) values.push_back(brightness(colour));
  return values;
}

std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < a.size(); ++i) apart.push_back(std::abs(a[i] - b[i]));
  return apart;
}

/// The mean over the pixels whose truth is known.
double mean_where_known(const std::vector<double>& values, const std::vector<PixelTruth>& truth) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (truth[i].meets != Meets::kSurface && truth[i].meets != Meets::kFluid) continue;
    sum += values[i];
    ++count;
  }
  return sum / count;
}

/// What lies before the uterine wall: at most so deep from the probe.
std::vector<std::uint8_t> before_wall(const PixelRays& rays, const auto& depths_mm) {
  constexpr double kWallMm = 128;
  std::vector<std::uint8_t> marked;
  for (std::uint32_t pixel = 0; pixel < kSize.width * kSize.height; ++pixel) {
    const double depth_mm = depths_mm[pixel];
    const PixelRay ray = rays.ray(pixel % kSize.width, pixel / kSize.width);
    marked.push_back(depth_mm >= 0 && ray.at(depth_mm).y < kWallMm ? 1 : 0);
  }
  return marked;
}

void save(const std::string& path, const Picture& picture) {
  if (auto written = write_picture(path, picture, {}); !written)
    throw std::runtime_error(written.error().message);
}

Picture picture_of(const std::vector<Rgb>& colours) {
  Picture picture{.width = kSize.width,
                  .height = kSize.height,
                  .rgba = std::vector<std::uint8_t>(4 * colours.size(), 255)};
  for (std::size_t pixel = 0; pixel < colours.size(); ++pixel) {
    for (int channel = 0; channel < 3; ++channel) {
      picture.rgba[4 * pixel + static_cast<std::size_t>(channel)] =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(colours[pixel][channel], 0.0, 1.0)));
    }
  }
  return picture;
}

/// What a method shows of a volume.
struct Shown {
  std::vector<float> depth_mm;
  std::vector<Rgb> colours;
};

/// A depth map of another program: height x width floats, top row first, mm below the view plane, negative
/// without a surface.
std::vector<float> read_depths(const std::string& path) {
  std::vector<float> depths_mm(std::size_t{kSize.width} * kSize.height);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(depths_mm.data()),
            static_cast<std::streamsize>(depths_mm.size() * sizeof(float)));
  if (!file) {
    throw std::runtime_error(fmt::format("{} cannot be read, expected {} floats", path, depths_mm.size()));
  }
  return depths_mm;
}

struct Options {
  std::string rows = ".";
  std::string depths;
  std::string gpu;
  std::string pictures;
  std::vector<std::string> changes;
  std::uint64_t seeds = 1;
  bool json = false;
};

std::vector<Rgb> lit(const std::vector<double>& depths_mm, const Scene& scene) {
  const std::vector<Rgb> nothing_behind(depths_mm.size(), Rgb(0));
  const std::vector<double> certainty(depths_mm.size(), 1.0);
  const auto lit = twin_light(depths_mm, certainty, nothing_behind, kSize, scene);
  return twin_finish(twin_outline(lit, depths_mm, kSize, scene), kSize, scene.finish);
}

/// What the rays of a scene meet in truth, and its picture.
struct Truth {
  PixelRays rays;
  std::vector<PixelTruth> pixels;
  std::vector<double> depth_mm;
  std::vector<Rgb> colours;
};

/// How like the truth a method's pictures are, over several volumes.
class Likeness {
 public:
  void add(const Shown& shown, const Truth& truth, const Scene& scene, const KnownSurface& surface) {
    errors_.add(shown.depth_mm, truth.pixels, truth.rays, kSize, surface);
    const DepthNormals normals(shown.depth_mm, kSize, truth.rays, scene.light.normals, scene.filter.step_mm);
    const auto of_volume =
        normal_errors_deg(normals, shown.depth_mm, truth.pixels, truth.rays, kSize, surface);
    normals_deg_.insert(normals_deg_.end(), of_volume.begin(), of_volume.end());
    const auto alike = structural_similarity(brightnesses(shown.colours), brightnesses(truth.colours), kSize);
    similarity_ += mean_where_known(alike, truth.pixels);
    flip_ += mean_where_known(flip_errors(truth.colours, shown.colours, kSize), truth.pixels);
    const Outline outline = compared_outlines(before_wall(truth.rays, shown.depth_mm),
                                              before_wall(truth.rays, truth.depth_mm), kSize);
    outline_mm_ += outline.mean_distance_pixels * truth.rays.port().pixel_mm;
    ragged_ += outline.length_ratio;
    ++volumes_;
  }

  FigureRow row(const std::string& name, double change) {
    // No aims, but what was reached: a picture must not become worse unnoticed.
    const auto demand = [&](const Demand& reached) {
      return name == kGuarded ? std::optional(reached) : std::nullopt;
    };
    std::ranges::sort(normals_deg_);
    return {name,
            {{"normals deg", normal_deg(0.5), 1, demand(at_most(2.8))},
             {"90 % deg", normal_deg(0.9), 1},
             {"SSIM", similarity_ / volumes_, 3, demand(at_least(0.78))},
             {"FLIP", flip_ / volumes_, 3},
             {"found %", 100 * errors_.share_found_of_all(), 1, demand(at_least(68))},
             {"false %", 100 * errors_.share_false_of_all(), 2},
             {"signed mm", errors_.signed_median_mm(), 2},
             {"outline mm", outline_mm_ / volumes_, 2},
             {"ragged", ragged_ / volumes_, 2},
             {"change", change, 1}}};
  }

 private:
  /// Of the sorted errors.
  double normal_deg(double share) const {
    if (normals_deg_.empty()) return NAN;
    return normals_deg_[static_cast<std::size_t>(share * static_cast<double>(normals_deg_.size() - 1))];
  }

  DepthErrors errors_{Rim::kJudged};
  std::vector<double> normals_deg_;
  // Sums over the volumes.
  double similarity_ = 0;
  double flip_ = 0;
  double outline_mm_ = 0;
  double ragged_ = 0;
  double volumes_ = 0;
};

/// One work: its volumes, one a seed, and what is true of it.
class Comparison {
 public:
  Comparison(const Options& options, BareGpu& gpu, const Work& work)
      : options_(options),
        sources_(sources_of(work, options.seeds)),
        surface_(surface_of(*sources_.front(), middle_of_sweep_s(work, *sources_.front()))),
        moves_(work.moves) {
    const SourceDescription& description = sources_.front()->description();
    fan_ = {description.geometry, description.first_angle_rad, description.last_angle_rad};
    rig_.emplace(gpu, fan_, description.frames_per_volume, kSize);
    for (const auto& source : sources_) {
      volumes_.push_back(next_sweep(*source));
      following_.push_back(next_sweep(*source));
    }
  }

  /// How far the face's features are from their true places, and their share of the true height: the means of
  /// all seeds. Of the view from the front.
  FigureRow features(const std::string& name, const Method& method) {
    const Scene scene = scene_of(kViews[0], method);
    const Truth truth = truth_of(scene);
    const double pixel_mm = truth.rays.port().pixel_mm;
    FigureRow row{name, {}};
    for (const FaceFeature& feature : kFeatures) {
      row.figures.push_back({std::string(feature.name) + " mm", 0, 2});
      row.figures.push_back({std::string(feature.name) + " %", 0, 0});
    }
    for (const Volume& volume : volumes_) {
      const Shown shown = rendered(volume, scene);
      const std::vector<double> shown_mm(shown.depth_mm.begin(), shown.depth_mm.end());
      const auto share = 1.0 / static_cast<double>(volumes_.size());
      auto figure = row.figures.begin();
      for (const FaceFeature& feature : kFeatures) {
        const auto there = found_feature(feature, truth.depth_mm, kSize, pixel_mm);
        const auto here = found_feature(feature, shown_mm, kSize, pixel_mm);
        const bool both = there && here;
        (figure++)->value +=
            both ? share * std::hypot(here->right_mm - there->right_mm, here->up_mm - there->up_mm) : NAN;
        (figure++)->value += both ? share * 100 * here->height_mm / there->height_mm : NAN;
      }
    }
    return row;
  }

  FigureRow row(const std::string& name, const View& view, const Method& method) {
    const Scene scene = scene_of(view, method);
    const Truth truth = truth_of(scene);
    Likeness likeness;
    double change = 0;
    for (std::size_t seed = 0; seed < volumes_.size(); ++seed) {
      const Shown shown = rendered(volumes_[seed], scene);
      likeness.add(shown, truth, scene, *surface_);
      if (seed + 1 == volumes_.size() && !options_.pictures.empty()) save_pictures(name, shown, truth);
      const Shown next = rendered(following_[seed], scene);
      const auto apart = differences(brightnesses(shown.colours), brightnesses(next.colours));
      change += 255 * mean_where_known(apart, truth.pixels) / static_cast<double>(volumes_.size());
    }
    return likeness.row(name, moves_ ? NAN : change);
  }

  /// The row of a depth map that another program made of the first volume, from the front. It is lit as the
  /// truth is.
  FigureRow row_of_depths(const std::string& name, std::vector<float> depths_mm) {
    const Scene scene = scene_of(kViews[0], methods().back());
    const Truth truth = truth_of(scene);
    Shown shown{std::move(depths_mm), {}};
    shown.colours = lit(std::vector<double>(shown.depth_mm.begin(), shown.depth_mm.end()), scene);
    if (!options_.pictures.empty()) save_pictures(name, shown, truth);
    Likeness likeness;
    likeness.add(shown, truth, scene, *surface_);
    return likeness.row(name, NAN);
  }

 private:
  static std::vector<std::unique_ptr<PhantomSource>> sources_of(const Work& work, std::uint64_t seeds) {
    std::vector<std::unique_ptr<PhantomSource>> sources;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto config =
          parse_phantom(fmt::format("{},moving={},seed={}", work.options, work.moves ? "on" : "off", seed),
                        {.pace = PhantomSource::Pace::kUnpaced});
      if (!config) throw std::runtime_error(config.error().message);
      sources.push_back(made_phantom(*config));
    }
    return sources;
  }

  /// What moves is compared with what was there in the middle of the first sweep.
  static double middle_of_sweep_s(const Work& work, const PhantomSource& source) {
    const double frames = source.description().frames_per_volume;
    return work.moves ? 0.5 * (frames - 1) / PhantomSource::Config{}.frame_rate_hz : 0;
  }

  Truth truth_of(const Scene& scene) const {
    Truth truth{.rays = PixelRays(scene, kSize)};
    truth.pixels = depth_truth(truth.rays, kSize, fan_, *surface_);
    truth.depth_mm = depths_of(truth.pixels);
    truth.colours = lit(truth.depth_mm, scene);
    return truth;
  }

  Shown rendered(const Volume& volume, const Scene& scene) {
    rig_->set_volume(volume);
    std::vector<float> depths_mm = rig_->depths(scene).smooth_mm;
    return {std::move(depths_mm), colours(rig_->picture())};
  }

  void save_pictures(const std::string& row, const Shown& shown, const Truth& truth) {
    const std::string file = std::regex_replace(row, std::regex("/"), "_");
    save(fmt::format("{}/{}.png", options_.pictures, file), picture_of(shown.colours));
    save(fmt::format("{}/{}_truth.png", options_.pictures, file), picture_of(truth.colours));
  }

  /// With the method's fields and those of --set, none of which moves rays.
  Scene scene_of(const View& view, const Method& method) const {
    Scene scene = scene_for(fan_.geometry, fan_.first_angle_rad, fan_.last_angle_rad, kSize.width);
    scene.camera.target = {.x_mm = 0, .y_mm = 80, .z_mm = 2};
    scene.camera.field_mm = 130;
    scene.camera.distance_mm = 100;
    scene.camera.yaw_deg += view.yaw_deg;
    scene.camera.pitch_deg += view.pitch_deg;
    scene.rays.end_mm = 220;
    method.change(scene);
    for (const std::string& change : options_.changes) apply(change, scene);
    return scene;
  }

  static void apply(const std::string& change, Scene& scene) {
    const std::size_t equals = change.find('=');
    const std::string name = change.substr(0, equals);
    const SceneField* const field = find_scene_field(name);
    const bool moves_rays = name.starts_with("camera.") || name.starts_with("rays.");
    if (equals == std::string::npos || field == nullptr || moves_rays) {
      throw std::runtime_error(fmt::format(
          "--set {} cannot be compared, expected NAME=VALUE of a field that moves no rays", change));
    }
    if (auto set = set_field(scene, *field, std::string_view(change).substr(equals + 1)); !set)
      throw std::runtime_error(set.error().message);
  }

  const Options& options_;
  std::vector<std::unique_ptr<PhantomSource>> sources_;
  std::unique_ptr<KnownSurface> surface_;
  ScannedFan fan_;
  bool moves_;
  std::optional<DepthRig> rig_;
  std::vector<Volume> volumes_;    // one a seed
  std::vector<Volume> following_;  // the next sweep of each: backward
};

/// The files PREFIX*.f32 of a folder, by what stands for the star.
std::map<std::string, std::string> depth_files(const std::string& folder, const std::string& prefix) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string stem = entry.path().stem();
    if (stem.starts_with(prefix) && entry.path().extension() == ".f32")
      files.emplace(stem.substr(prefix.size()), entry.path());
  }
  return files;
}

int run(const Options& options) {
  BareGpu bare(options.gpu);
  const std::regex rows(options.rows);
  FigureBlock block{"pictures of the simulated probe beside pictures of its true surface",
                    "320 x 320 pixels, speckled, at rest and moving. All rays count, the rim and those "
                    "through the fan's cut "
                    "sides included.\nSSIM and FLIP where the truth is known; the outline of what lies "
                    "before the wall; the change "
                    "of a pixel's "
                    "brightness, of 255, from a volume to the next one, at rest.",
                    {}};
  FigureBlock features{"features of the face, seen from the front",
                       "Distance from the true place, and share of the true height over (lips: depth below) "
                       "a circle about it.",
                       {}};
  for (const Work& work :
       {Work{"face/r1", "probe=r1,scene=face"}, Work{"face/r2", "probe=r2,scene=face"},
        Work{"face-moving/r1", "probe=r1,scene=face", true},
        Work{"face-moving/r2", "probe=r2,scene=face", true}, Work{"relief/r1", "probe=r1,scene=relief"},
        Work{"relief/r2", "probe=r2,scene=relief"}}) {
    std::optional<Comparison> comparison;
    for (const Method& method : {methods()[kPaperMethod], Method{"default", methods().back().change}}) {
      for (const View& view : kViews) {
        const std::string name = fmt::format("{}/{}/{}", work.name, method.name, view.name);
        if (!std::regex_search(name, rows)) continue;
        if (!comparison) comparison.emplace(options, bare, work);
        block.rows.push_back(comparison->row(name, view, method));
        if (work.name.starts_with("face") && &view == &kViews[0])
          features.rows.push_back(comparison->features(name, method));
      }
    }
    if (options.depths.empty()) continue;
    const std::string prefix = std::regex_replace(work.name, std::regex("/"), "_") + "_";
    for (const auto& [method, path] : depth_files(options.depths, prefix)) {
      const std::string name = fmt::format("{}/{}/{}", work.name, method, kViews[0].name);
      if (!std::regex_search(name, rows)) continue;
      if (!comparison) comparison.emplace(options, bare, work);
      block.rows.push_back(comparison->row_of_depths(name, read_depths(path)));
    }
  }
  if (block.rows.empty()) {
    fmt::print(stderr, "picture_quality: no row's name holds \"{}\"\n", options.rows);
    return 1;
  }
  const std::vector<FigureBlock> blocks{block, features};
  fmt::print("{}\n", options.json ? as_json(blocks) : as_text(blocks));
  const std::vector<std::string> failed = failures(blocks);
  for (const std::string& failure : failed) fmt::print(stderr, "not reached: {}\n", failure);
  return failed.empty() ? 0 : 1;
}

}  // namespace
}  // namespace fanlight::test

int main(int count, char** arguments) {
  fanlight::test::Options options;
  CLI::App program("Likeness of pictures to those of the true surface");
  program.add_option("--rows", options.rows, "Only rows whose name holds this, such as face/r2/default")
      ->type_name("REGEX");
  program.add_option("--seeds", options.seeds, "Volumes with other speckle to average")
      ->check(CLI::Range(1, 20));
  program.add_option("--set", options.changes, "A field of the scene to try otherwise")
      ->type_name("NAME=VALUE");
  program.add_option("--pictures", options.pictures, "Folder to write the pictures to")->type_name("FOLDER");
  program
      .add_option(
          "--depths", options.depths,
          "Folder of depth maps by other programs, WORK_METHOD.f32 such as face_r1_vtk.f32, for rows of "
          "their own (tests/bench/peers/likeness)")
      ->type_name("FOLDER");
  program.add_option("--gpu", options.gpu, "GPU to use, by a part of its name")->type_name("NAME");
  program.add_flag("--json", options.json, "Print the figures as JSON");
  CLI11_PARSE(program, count, arguments);
  try {
    return fanlight::test::run(options);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "picture_quality: {}\n", failure.what());
    return 1;
  }
}
