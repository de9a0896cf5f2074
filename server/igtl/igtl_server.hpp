// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "proto/base/thread_owner.hpp"
#include "proto/exchange/frame_tap.hpp"
#include "proto/model/picture.hpp"
#include "server/codec/encoder_pool.hpp"
#include "server/igtl/igtl_commands.hpp"
#include "server/igtl/igtl_session.hpp"
#include "server/igtl/igtl_streams.hpp"
#include "server/igtl/igtl_volumes.hpp"
#include "server/igtl/picture_messages.hpp"
#include "server/net/connection_limit.hpp"
#include "server/net/loop_chain.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// OpenIGTLink on a port of its own: pictures, depth maps, surfaces and the camera for 3D Slicer and other
/// programs (proto/OPENIGTLINK.md). The protocol has neither encryption nor logins. Messages of a picture are
/// written elsewhere, once for all clients; while that is busy, the newest picture waits. Server thread only.
class IgtlServer {
 public:
  struct Config {
    boost::asio::ip::tcp::endpoint endpoint;
    IgtlStreams usual;          ///< sent to clients that ask for nothing
    double spacing_mm = 0;      ///< of the volume's grid; 0: about 256 voxels on the longest side
    Role role = Role::kViewer;  ///< of every client
    std::size_t most_clients = 64;
    std::size_t most_clients_a_host = 16;  ///< except this machine
    std::uint32_t most_messages = 500;     ///< that are read of a client in a second
    IgtlSession::Patience patience{};
  };
  /// Writes the message of a frame of the source, which was taken at `utc_ns` and is sent now; valid until
  /// the next call.
  using WriteFrame = std::function<std::span<const std::uint8_t>(
      const QueuedFrame& frame, std::uint64_t utc_ns, FrameOrigin origin, igtl::HeadVersion version)>;
  /// All must outlive this object. Of `ports` it uses the frames.
  struct Dependencies {
    ServerState& state;
    CommandExecutor& commands;
    AuditLog& audit;
    const PictureHub& hub;
    Executor executor;
    const PipelinePorts& ports;
    WriteFrame write_frame{};             ///< not empty where there are frames
    std::function<void()> wants_changed;  ///< wants_pictures() may have changed
  };
  IgtlServer(boost::asio::io_context& loop, const Config& config, Dependencies dependencies);
  ~IgtlServer();

  /// Opens the port. kUnavailable if the address is in use or not of this machine.
  Result<void> open();
  /// With the port that the system chose if the configuration has port 0. Precondition: open().
  boost::asio::ip::tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }
  /// Accepts from now on. Begins again where a lack of memory has ended it.
  void start();

  /// Whether a client wants what a picture is needed for.
  bool wants_pictures() const;
  std::size_t clients() const { return sessions_.size(); }

  /// The newest picture of the main view. It must stay unchanged until the next call.
  void show(const Picture& picture);
  /// Takes what came: frames of the source, and an answer of the render thread.
  void bell_rang();
  /// The state of the picture has changed.
  void state_changed();
  void second_passed();
  /// Accepts no more clients, and tells those connected that the server stops.
  void end();

 private:
  struct Job;
  void accept();
  void begin(boost::asio::ip::tcp::socket socket);
  void refuse(const boost::asio::ip::address& address);
  IgtlWanted wanted() const;
  /// Without what clients have of this picture and its volume already.
  IgtlWanted wanted_of(const PictureStamp& stamp) const;
  void wants_changed();
  void show_newest();
  void plan_video(IgtlWanted& now, const PictureStamp& stamp) const;
  bool key_is_due() const;
  void write_messages(const Picture& picture, const IgtlWanted& wanted);
  void written(Job& job);
  void send_frames();
  void offer_volume(const IgtlVolumes::Made& made);

  Config config_;
  Dependencies dependencies_;
  IgtlCommands commands_;
  IgtlSession::Dependencies session_dependencies_;
  ConnectionLimit limit_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  LoopChain chain_;
  FrameTap* frames_;  // of the source; null: none are sent
  std::vector<std::shared_ptr<IgtlSession>> sessions_;
  std::shared_ptr<Job> job_;  // its memory is used again
  IgtlVolumes volumes_;
  std::size_t bytes_waiting_ = 0;  // of all sessions
  std::int64_t key_coded_ns_ = 0;  // when the last key picture of the video was encoded
  bool video_failed_ = false;      // its next picture must be a key picture
  bool busy_ = false;              // the job runs
  bool newer_waits_ = false;       // a picture, or a wish, came meanwhile
  int seconds_to_state_ = 0;
  std::int64_t refusal_logged_ns_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
