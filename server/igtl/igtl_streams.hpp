// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace fanlight {

/// What an OpenIGTLink client can have again and again. The names follow PLUS: What_FrameOfReference. The
/// transducer frame is GLOSSARY.md's.
enum class IgtlStream : std::uint8_t {
  kPicture,  ///< the lit picture, RGB
  kDepth,    ///< the depth map of it, mm along the line of sight; -1 where there is no surface
  kSurface,  ///< the surface that it shows, as triangles
  kCamera,   ///< where the camera is and looks
  kVideo,    ///< the lit picture as H.264: a picture may need those before it
  kVolume,   ///< the volume on show, on a grid of cubes
  kFrames,   ///< every frame of the source; the others are of what is shown
};
inline constexpr std::size_t kIgtlStreams = 7;

struct IgtlStreamName {
  std::string_view word;  ///< in options
  std::string_view type;  ///< of its messages
  std::string_view device;
};
inline constexpr std::array<IgtlStreamName, kIgtlStreams> kIgtlStreamNames = {{
    {"picture", "IMAGE", "Picture_Transducer"},
    {"depth", "IMAGE", "Depth_Transducer"},
    {"surface", "POLYDATA", "Surface_Transducer"},
    {"camera", "TRANSFORM", "CameraToTransducer"},
    {"video", "VIDEO", "Video_Transducer"},
    {"volume", "IMAGE", "Volume_Transducer"},
    {"frames", "IMAGE", "Image_Transducer"},
}};

/// The name of this program's other messages.
inline constexpr const char* kIgtlDevice = "Fanlight";

inline const IgtlStreamName& name_of(IgtlStream stream) {
  return kIgtlStreamNames[static_cast<std::size_t>(stream)];
}

/// The stream that a query means: by its type ("TRANS" is TRANSFORM's in queries) and its device. Without a
/// device, the first of that type. nullopt: there is none.
std::optional<IgtlStream> stream_of(std::string_view type, std::string_view device);

/// A set of streams.
class IgtlStreams {
 public:
  void set(IgtlStream stream, bool on) { on_[static_cast<std::size_t>(stream)] = on; }
  bool has(IgtlStream stream) const { return on_[static_cast<std::size_t>(stream)]; }
  bool any() const { return std::ranges::find(on_, true) != on_.end(); }
  /// Whether there must be pictures for any of them.
  bool any_of_pictures() const {
    IgtlStreams others = *this;
    others.set(IgtlStream::kFrames, false);
    return others.any();
  }
  void add(const IgtlStreams& other) {
    for (std::size_t i = 0; i < kIgtlStreams; ++i) on_[i] = on_[i] || other.on_[i];
  }
  bool operator==(const IgtlStreams&) const = default;

 private:
  std::array<bool, kIgtlStreams> on_{};
};

}  // namespace fanlight
