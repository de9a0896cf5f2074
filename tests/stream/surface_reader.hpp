// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/fanlight.pb.h"

namespace fanlight::test {

/// What a display unpacks of a surface, written from proto/DISPLAY_PROTOCOL.md alone.
struct ReadSurface {
  std::vector<int> units;        ///< height x width; -1: no surface
  std::vector<int> certainties;  ///< of the blocks of 2 x 2 pixels with a surface, in their order, as sent
};

inline std::vector<std::uint8_t> inflated(const std::string& bytes) {
  std::vector<std::uint8_t> plain(1U << 22U);
  uLongf size = plain.size();
  if (uncompress(plain.data(), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != Z_OK)
    throw std::runtime_error("expected what zlib can read");
  plain.resize(size);
  return plain;
}

inline ReadSurface read_surface(const v1::Surface& surface) {
  const auto runs = inflated(surface.runs());
  const auto residuals = inflated(surface.residuals());
  const auto large = inflated(surface.large_residuals());
  const auto width = static_cast<int>(surface.width());
  const auto height = static_cast<int>(surface.height());
  ReadSurface read;
  read.units.assign(std::size_t{surface.width()} * surface.height(), -1);
  std::vector<std::vector<int>> depth(height + 1, std::vector<int>(width + 2, 0));
  std::vector<std::vector<int>> size(height + 1, std::vector<int>(width + 2, 0));
  std::size_t next_run = 0;
  std::size_t calm = 0;
  std::size_t rough = surface.calm_pixels();
  std::size_t next_large = 0;
  const auto run_length = [&] {
    std::uint64_t length = 0;
    for (unsigned shift = 0;; shift += 7) {
      const std::uint8_t byte = runs.at(next_run++);
      length |= std::uint64_t{byte & 127U} << shift;
      if (byte < 128) return length;
    }
  };
  std::uint64_t left = run_length();
  bool in_surface = false;
  for (int y = 1; y <= height; ++y) {
    depth[y][0] = depth[y - 1][0] = depth[y - 1][1];
    for (int x = 1; x <= width; ++x) {
      while (left == 0) {
        left = run_length();
        in_surface = !in_surface;
      }
      --left;
      if (!in_surface) {
        depth[y][x] = depth[y - 1][x];
        continue;
      }
      const int around = size[y][x - 1] + size[y - 1][x - 1] + size[y - 1][x] + size[y - 1][x + 1];
      int folded = residuals.at(around <= 6 ? calm++ : rough++);
      if (folded == 255) {
        folded = large.at(next_large) + 256 * large.at(next_large + 1);
        next_large += 2;
      }
      const int residual = folded % 2 == 0 ? folded / 2 : -(folded + 1) / 2;
      depth[y][x] = (depth[y][x - 1] + depth[y - 1][x] - depth[y - 1][x - 1] + residual) & 65535;
      size[y][x] = folded < 40 ? folded : 40;
      read.units[static_cast<std::size_t>(y - 1) * width + x - 1] = depth[y][x];
    }
  }
  if (calm != surface.calm_pixels() || rough != residuals.size() || next_large != large.size())
    throw std::runtime_error("expected all residuals to be used");
  for (const std::uint8_t sent : inflated(surface.certainties())) read.certainties.push_back(sent);
  return read;
}

}  // namespace fanlight::test
