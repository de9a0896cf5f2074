// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "proto/base/result.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

enum class ArchivedObject : std::uint8_t { kStill, kClip, kVolume };

/// A volume for an archive.
struct VolumeToSend {
  std::shared_ptr<const Volume> volume;
  std::int64_t acquired_utc_s = 0;  ///< seconds since 1970; 0: not known
  bool is_simulated = false;
};

/// Takes stills and clips of displays, and volumes, for an archive. Server thread.
class StillArchive {
 public:
  struct Report {
    bool available = false;     ///< the folder can be written
    std::uint64_t waiting = 0;  ///< objects that the archive does not have yet
    std::uint64_t refused = 0;  ///< objects that it has refused for good
  };
  using Done = std::function<void(const Result<ArchivedObject>&)>;

  virtual ~StillArchive() = default;

  /// Some seconds old at most.
  virtual Report report() const = 0;

  /// `request`: a JSON object with `png`, the picture in base64, and `patient`, as `fanlight worklist` saves
  /// it; or of a clip, `jpegs` and `pictures_per_second`. `done`: called later on the server thread, when it
  /// is on the disk, or with an error: kInvalidArgument or kBadInput for the request, kUnavailable for
  /// the disk.
  virtual void add(std::string request, Done done) = 0;

  /// The same for a volume, scan converted. `request`: a JSON object with `volume`, which is the caller's,
  /// and `patient`.
  virtual Result<void> check_volume_request(const std::string& request) const = 0;
  virtual void add_volume(VolumeToSend volume, std::string request, Done done) = 0;
};

/// Opens it. `post`: runs a function on the server thread; any thread may call it.
using OpenStillArchive =
    std::function<Result<std::unique_ptr<StillArchive>>(std::function<void(std::function<void()>)> post)>;

}  // namespace fanlight
