// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/exchange/recording_link.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "server/state/scene_store.hpp"

namespace fanlight {

/// What displays may ask of the recorder.
enum class RecordingWish : std::uint8_t {
  kStart,
  kStop,
  kKeep,  ///< writes the last seconds to a file, where the server keeps them
};
/// "start", "stop", "keep"; nullopt for another word.
std::optional<RecordingWish> recording_wish(std::string_view word);
std::string_view recording_word(RecordingWish wish);

/// Passes the wishes of displays and scripts to the recorder, as numbered orders, and keeps its newest state.
/// Chooses the names of the files: fanlight-2026-11-22T174500Z.igs.mha, by the time in UTC. Server thread
/// only.
class RecordingProxy {
 public:
  struct Config {
    std::filesystem::path folder;  ///< for all recordings; empty: nothing is recorded
    PixelForm form = PixelForm::kRaw;
    double most_s = 0;      ///< a recording ends after so long; 0: no limit
    double last_s = 0;      ///< while nothing is recorded, the last seconds to keep; 0: none
    bool at_start = false;  ///< begins a recording at once
  };
  /// `link`: absent without a folder. `utc_s`: seconds since 1970.
  RecordingProxy(Config config, std::optional<RecordingLink> link, std::function<std::int64_t()> utc_s);

  /// Carries out a wish; the name of the file that it concerns. Errors: kUnavailable where the server has no
  /// folder for recordings, or the recorder is not in a state for it.
  Result<std::string> request(RecordingWish wish);

  /// What a call of update() has found.
  struct News {
    bool read = false;     ///< there was a new state
    bool changed = false;  ///< more than the counts of a recording under way
    /// A recording has ended since the last call; then the fields last_... of the status are of the newest.
    bool ended = false;
  };
  /// Reads the recorder's newest state. Begins to keep the last seconds again after a recording.
  News update();

  /// The main view has shown a picture: the recording notes what it takes to render it again.
  void picture_shown(const Picture& picture, PictureSize usual, const SceneStore& scenes);

  /// Whether counts change: the status is worth a message every second.
  bool is_active() const { return status_.state != RecordingStatus::State::kIdle; }
  const RecordingStatus& status() const { return status_; }
  v1::RecordingStatus message() const;

 private:
  std::filesystem::path free_name(std::string_view begin);
  bool order(RecordingOrder order);
  RecordingOrder ring_order();
  bool keeps_ring() const { return config_.last_s > 0; }

  Config config_;
  std::optional<RecordingLink> link_;
  std::function<std::int64_t()> utc_s_;
  RecordingStatus status_;
  std::uint64_t ordered_ = 0;
  std::uint64_t noted_revision_ = 0;                            // of the last scene that was noted
  std::filesystem::path recording_;                             // that a display has started; empty: none
  std::map<std::string, std::string, std::less<>> last_names_;  // by what they begin with
};

}  // namespace fanlight
