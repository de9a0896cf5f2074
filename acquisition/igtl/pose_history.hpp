// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_head.hpp"

namespace fanlight {

/// The last poses of each device that sends transforms, to find the one of an image. Times are the sender's,
/// ns since 1970. One thread. Allocates with the first pose of a device.
class PoseHistory {
 public:
  static constexpr std::size_t kMostDevices = 16;
  /// So many poses of a device are kept.
  static constexpr std::size_t kMostPoses = 8192;
  /// A pose further away in time is not of the image.
  static constexpr std::int64_t kMostApartNs = 50'000'000;

  /// A pose that came. Those of further devices than kMostDevices are not kept.
  void add(const igtl::DeviceName& device, std::int64_t time_ns, const igtl::GridPose& pose);
  void clear();

  std::size_t devices() const { return devices_; }
  const igtl::DeviceName& name(std::size_t device) const { return histories_[device].name; }
  /// nullopt: nothing came of a device of this name.
  std::optional<std::size_t> find(std::string_view name) const;

  struct Answer {
    std::optional<igtl::GridPose> pose;
    bool may_come = false;  ///< no pose of this time or a later one has come yet
  };
  /// The pose at a time: between two that came, interpolated linearly; else the nearest within kMostApartNs.
  Answer at(std::size_t device, std::int64_t time_ns) const;

 private:
  struct Timed {
    std::int64_t time_ns = 0;
    igtl::GridPose pose;
  };
  struct History {
    igtl::DeviceName name;
    std::vector<Timed> poses;  // a ring
    std::size_t count = 0;     // that came
  };
  std::size_t later_than(const History& history, std::int64_t time_ns) const;
  const Timed& newest(const History& history, std::size_t back) const {
    return history.poses[(history.count - 1 - back) % kMostPoses];
  }

  std::array<History, kMostDevices> histories_;
  std::size_t devices_ = 0;
};

}  // namespace fanlight
