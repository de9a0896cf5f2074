// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/codec/stream_settings.hpp"

namespace fanlight {

/// A serialised ServerMessage, shared by all sessions that send it.
using SharedMessage = std::shared_ptr<const std::string>;

/// An encoded picture, ready to be sent.
struct PictureOffer {
  SharedMessage message;
  /// The same for a client that has its surface; null where `surface_id` is 0.
  SharedMessage without_surface;
  std::uint64_t surface_id = 0;  ///< 0: it contains no surface
  std::uint64_t picture_id = 0;
  std::uint64_t scene_revision = 0;
  std::uint64_t view_id = 0;
  bool key = true;  ///< can be decoded without the pictures before it
};

/// A receiver of pictures, as PictureHub sees it. Server thread only.
class PictureSubscriber {
 public:
  virtual ~PictureSubscriber() = default;

  /// Number of the session, never 0.
  virtual std::uint64_t id() const = 0;

  /// The view whose pictures it receives: 0 for the main view, id() for its private view.
  virtual std::uint64_t view_id() const = 0;
  virtual void set_view(std::uint64_t view_id) = 0;

  /// How its pictures are encoded.
  virtual const StreamSettings& settings() const = 0;

  /// Whether its role is above a viewer's.
  virtual bool privileged() const = 0;

  /// Receives the newest picture. It must not add or remove subscribers of the hub.
  virtual void offer(const PictureOffer& picture) = 0;

  /// Its picture could not be encoded. It must not add or remove subscribers of the hub.
  virtual void encoding_failed() = 0;
};

}  // namespace fanlight
