#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "server/picture_hub.hpp"
#include "server/probe_desk.hpp"
#include "server/scene_desk.hpp"
#include "server/server_counters.hpp"

namespace fanlight {

/// What a display is told about the house when it connects.
struct HouseFacts {
  std::string source;
  std::string device;
  std::uint32_t picture_width = 0;
  std::uint32_t picture_height = 0;
};

/// One of the connections that a server allows at once, counted while it lives.
class ConnectionPlace {
 public:
  explicit ConnectionPlace(std::size_t& taken) : taken_(&taken) { ++*taken_; }
  ConnectionPlace(ConnectionPlace&& other) noexcept : taken_(std::exchange(other.taken_, nullptr)) {}
  ConnectionPlace& operator=(ConnectionPlace&&) = delete;
  ~ConnectionPlace() {
    if (taken_ != nullptr) --*taken_;
  }

 private:
  std::size_t* taken_;
};

/// What every session works with; outlives them all. Server thread only.
struct StreamContext {
  const HouseFacts& facts;
  const HouseCounters& house;
  const std::function<std::string()>& source_state;  ///< "running", "ended", or why it failed
  ServerCounters& counters;
  bool loopback_only;  ///< the listener's address: then requests must name it too
  SceneDesk& desk;
  ProbeDesk& probe;
  PictureHub& hub;
};

}  // namespace fanlight
