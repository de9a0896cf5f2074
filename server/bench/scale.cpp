// SPDX-License-Identifier: Apache-2.0
#include "server/bench/scale.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

namespace {

constexpr int kUsualPixels = 512;
constexpr int kUsualFrames = 35;

struct Size {
  int columns = kUsualPixels;  // and rows
  int frames = kUsualFrames;
  int picture = kUsualPixels;
};

double sum_ms(const Picture& picture, Stage first, Stage last) {
  double ms = 0;
  for (auto stage = static_cast<std::size_t>(first); stage <= static_cast<std::size_t>(last); ++stage)
    ms += picture.stamp.stage_ms[stage];
  return ms;
}

/// The row r1/paper in another size.
BenchRow row_of(const Size& size, std::string& input) {
  input = fmt::format("phantom:scene=relief,probe=r1,compression=linear,columns={0},rows={0},frames={1}",
                      size.columns, size.frames);
  BenchRow row = bench_rows().front();
  row.input = input;
  row.picture = size.picture;
  return row;
}

/// Runs `measure` once in vain and then `rounds` times; the medians of what it returns.
template <typename Measure>
Result<std::vector<double>> medians(int rounds, const Measure& measure) {
  std::vector<std::vector<double>> columns;
  for (int round = 0; round <= rounds; ++round) {
    const auto costs = measure();
    if (!costs) return costs.error();
    columns.resize(costs->size());
    for (std::size_t column = 0; round > 0 && column < costs->size(); ++column)
      columns[column].push_back((*costs)[column]);
  }
  std::vector<double> middle;
  middle.reserve(columns.size());
  for (const auto& column : columns) middle.push_back(quantile(column, 0.5));
  return middle;
}

using Costs = Result<std::vector<double>>;

Costs costs_of(const RenderDevice& device, const Size& size, int rounds) {
  std::string input;
  const BenchRow row = row_of(size, input);
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  return medians(rounds, [&]() -> Costs {
    const auto whole = rig.whole_volume();
    if (!whole) return whole.error();
    const Picture& picture = rig.picture();
    return std::vector{*whole, sum_ms(picture, Stage::kPrepare, Stage::kPrepare),
                       sum_ms(picture, Stage::kCast, Stage::kCast),
                       sum_ms(picture, Stage::kFilter, Stage::kFinish)};
  });
}

Result<ScaleCurve> curve_of_sizes(const RenderDevice& device, int rounds, std::string amount,
                                  const std::vector<std::pair<Size, double>>& sizes) {
  ScaleCurve curve{.amount = std::move(amount),
                   .columns = {"volume at once", "pass 0", "pass 1", "passes 2 and 3"},
                   .points = {},
                   .exponents = {}};
  for (const auto& [size, count] : sizes) {
    auto costs = costs_of(device, size, rounds);
    if (!costs) return costs.error();
    curve.points.push_back(
        {.name = fmt::format("{0} x {0} x {1} to {2} x {2}", size.columns, size.frames, size.picture),
         .amount = count,
         .ms = std::move(*costs)});
  }
  return curve;
}

Result<ScaleCurve> curve_of_views(const RenderDevice& device, int rounds) {
  std::string input;
  const BenchRow row = row_of({}, input);
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  if (auto first = rig.whole_volume(); !first) return first.error();
  ScaleCurve curve{
      .amount = "private views", .columns = {"a camera each", "a light each"}, .points = {}, .exponents = {}};
  for (std::size_t views = 1; views <= kMostPrivateViews; ++views) {
    auto costs = medians(rounds, [&]() -> Costs {
      const auto cameras = rig.private_pictures(views, BenchRig::PrivateKind::kCamera);
      if (!cameras) return cameras.error();
      const auto lights = rig.private_pictures(views, BenchRig::PrivateKind::kLight);
      if (!lights) return lights.error();
      return std::vector{*cameras, *lights};
    });
    if (!costs) return costs.error();
    curve.points.push_back(
        {.name = fmt::format("{}", views), .amount = static_cast<double>(views), .ms = std::move(*costs)});
  }
  return curve;
}

void add_exponents(ScaleCurve& curve) {
  for (std::size_t column = 0; column < curve.columns.size(); ++column) {
    std::vector<double> amounts;
    std::vector<double> costs;
    for (const ScalePoint& point : curve.points) {
      amounts.push_back(point.amount);
      costs.push_back(point.ms[column]);
    }
    curve.exponents.push_back(scale_exponent(amounts, costs));
  }
}

}  // namespace

double scale_exponent(const std::vector<double>& amounts, const std::vector<double>& costs) {
  const auto count = static_cast<double>(amounts.size());
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  for (std::size_t index = 0; index < amounts.size(); ++index) {
    if (!(amounts[index] > 0 && costs[index] > 0)) return 0;
    const double log_amount = std::log(amounts[index]);
    const double log_cost = std::log(costs[index]);
    x += log_amount;
    y += log_cost;
    xx += log_amount * log_amount;
    xy += log_amount * log_cost;
  }
  const double spread = count * xx - x * x;
  return spread > 0 ? (count * xy - x * y) / spread : 0;
}

Result<void> run_bench_scale(const RenderDevice& device, int rounds,
                             const std::function<void(const ScaleCurve&)>& tell) {
  const auto square = [](int side) { return static_cast<double>(side) * side; };
  std::vector<std::pair<Size, double>> pictures;
  for (const int side : {128, 256, 512, 1024}) pictures.push_back({{.picture = side}, square(side)});
  std::vector<std::pair<Size, double>> voxels;
  for (const auto& [side, frames] : {std::pair(256, 18), std::pair(512, 35), std::pair(1024, 70)})
    voxels.push_back({{.columns = side, .frames = frames}, square(side) * frames});
  std::vector<std::pair<Size, double>> frames;
  for (const int count : {18, 35, 70, 140}) frames.push_back({{.frames = count}, static_cast<double>(count)});

  const std::pair<const char*, const std::vector<std::pair<Size, double>>&> curves[] = {
      {"pixels of the picture", pictures}, {"voxels", voxels}, {"frames a volume", frames}};
  for (const auto& [amount, sizes] : curves) {
    auto curve = curve_of_sizes(device, rounds, amount, sizes);
    if (!curve) return curve.error();
    add_exponents(*curve);
    tell(*curve);
  }
  auto views = curve_of_views(device, rounds);
  if (!views) return views.error();
  add_exponents(*views);
  tell(*views);
  return {};
}

}  // namespace fanlight
