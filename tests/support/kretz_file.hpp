// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace fanlight::test {

/// Builds a Kretz volume (little endian host). It is valid unless a test changes it.
struct KretzFile {
  struct Item {
    std::uint16_t group;
    std::uint16_t element;
    std::string data;
  };

  template <typename T>
  static std::string bytes_of(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
  static std::string table(std::uint32_t count, double first, double last) {
    std::string bytes;
    for (std::uint32_t i = 0; i < count; ++i) bytes += bytes_of(first + (last - first) * i / (count - 1));
    return bytes;
  }

  std::string magic = "KRETZFILE 1.0   ";
  std::vector<Item> items;

  /// 12 samples of 0.5 mm on 8 lines over 0.7 rad in 6 frames over 0.9 rad; apex 40 mm, axis 23 mm behind the
  /// first sample. Voxel (sample, line, frame) is sample + 12 * line + frame.
  static KretzFile small() {
    KretzFile file;
    file.items = {{0x0110, 1, "DOE^JANE"},
                  {0xC000, 1, bytes_of(std::uint16_t{12})},
                  {0xC000, 2, bytes_of(std::uint16_t{8})},
                  {0xC000, 3, bytes_of(std::uint16_t{6})},
                  {0xC100, 1, bytes_of(0.0005)},
                  {0xC200, 1, bytes_of(80.0)},
                  {0xC200, 2, bytes_of(-34.0)},
                  {0xC300, 1, table(6, 1.1, 2.0)},
                  {0xC300, 2, table(8, 1.2, 1.9)}};
    std::string voxels;
    for (int frame = 0; frame < 6; ++frame) {
      for (int line = 0; line < 8; ++line) {
        for (int sample = 0; sample < 12; ++sample) voxels += static_cast<char>(sample + 12 * line + frame);
      }
    }
    file.items.push_back({0xD000, 1, voxels});
    file.items.push_back({0x0130, 1, "after the voxels"});
    return file;
  }

  Item& item(std::uint16_t group, std::uint16_t element) {
    for (Item& each : items) {
      if (each.group == group && each.element == element) return each;
    }
    std::abort();
  }
  void remove(std::uint16_t group, std::uint16_t element) {
    std::erase_if(items, [&](const Item& each) { return each.group == group && each.element == element; });
  }

  std::string bytes() const {
    std::string all = magic;
    for (const Item& each : items) {
      all += bytes_of(each.group) + bytes_of(each.element) +
             bytes_of(static_cast<std::uint32_t>(each.data.size()));
      all += each.data;
    }
    return all;
  }
};

}  // namespace fanlight::test
