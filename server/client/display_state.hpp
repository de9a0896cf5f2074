// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight {

/// What a native display knows of its session, and what its inputs ask of the server. No window, no socket:
/// messages come in, requests come out. Pixels are those of the picture as rendered, from its upper left
/// corner. One thread.
class DisplayState {
 public:
  explicit DisplayState(const v1::Hello& hello);

  /// `now_ns`: this machine's clock, as of the others.
  void take(const v1::ServerMessage& message, std::int64_t now_ns);

  /// The connection is lost, with this sentence: until this object is replaced.
  void lose(const std::string& reason) { lost_reason_ = reason; }

  /// A picture is on show.
  void shown(const v1::Picture& picture);

  enum class Word : std::uint8_t { kWaiting, kLive, kDelayed, kFrozen, kReplay, kLost };
  struct Condition {
    Word word = Word::kWaiting;
    std::string text;    ///< "LIVE 0.4 s", "LOST, 12.0 s old"
    std::string reason;  ///< a sentence; empty where the picture is live
  };
  /// The word for the picture on show. A server that says nothing for two seconds is lost.
  Condition condition(std::int64_t now_ns) const;

  const std::string& title() const { return hello_.title(); }
  const v1::CineStatus& cine() const { return cine_; }
  /// Whether the pictures are sent to displays beyond the room as well.
  bool is_relayed() const { return is_relayed_; }
  /// The newest refusal, for four seconds; empty where there is none.
  std::string refusal(std::int64_t now_ns) const;

  // Requests for the server. The changes are kept as if they were in force, so that the next one adds to
  // them.

  /// Turns the body with a pointer that has moved by this many pixels.
  v1::ClientMessage turn(double right_px, double down_px);
  /// A factor above 1 shows more of the body.
  v1::ClientMessage zoom(double factor);
  /// Moves the light to a pixel; its depth stays.
  v1::ClientMessage light_to(double column, double row);
  /// Moves the threshold by this many grey levels, from the one in force.
  v1::ClientMessage threshold_by(double levels);
  /// The preset of this index; absent where there is none.
  std::optional<v1::ClientMessage> preset(int index);
  /// The name of that preset; empty where there is none.
  std::string preset_name(int index) const;
  /// "surface", "surface-and-volume", "slices", ...; absent where this server has no such mode.
  std::optional<v1::ClientMessage> mode(const std::string& name);
  /// Back to the view of the default scene.
  v1::ClientMessage reset();
  /// Freezes all displays, or shows new volumes again.
  v1::ClientMessage freeze_or_live() const;
  v1::ClientMessage step(int volumes) const;

 private:
  struct Part {
    double left = 0, top = 0, width = 0, height = 0, field_pixels = 0;
  };
  /// The part of the picture that shows the surface, as viewport() in renderer/parameters.
  Part surface_part() const;
  const v1::SceneField* field(const std::string& name) const;
  /// Whether the choice of this index in a field is the one of that name.
  bool is(const std::string& name, std::uint32_t index, const std::string& choice) const;
  /// The value within the range of a field.
  double allowed(const std::string& name, double value) const;
  v1::ClientMessage changed(const v1::Scene& change);

  v1::Hello hello_;
  v1::Scene scene_;     // with the changes that are not answered yet
  v1::Scene in_force_;  // as the server has sent it
  v1::Liveness liveness_;
  v1::CineStatus cine_;
  v1::EchoLevels levels_;
  bool is_relayed_ = false;
  bool any_picture_ = false;
  std::uint64_t volume_id_ = 0;   // of the picture on show
  std::int64_t captured_ns_ = 0;  // of the picture on show, by the server's clock
  // The server's clock, by the message that was fastest on its way; forgotten slowly, since clocks drift.
  std::optional<std::int64_t> clock_ahead_ns_;
  std::int64_t clock_told_ns_ = 0;
  std::optional<std::int64_t> heard_ns_;
  std::string lost_reason_;
  std::string refusal_;
  std::int64_t refused_ns_ = 0;
  std::uint64_t last_request_ = 0;
};

}  // namespace fanlight
