// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/exchange/pipeline_ports.hpp"
#include "server/api/rest_api.hpp"
#include "server/command/command_executor.hpp"
#include "server/http/connection_listener.hpp"
#include "server/http/http_session.hpp"
#include "server/igtl/igtl_server.hpp"
#include "server/net/allowed_origins.hpp"
#include "server/net/loop_chain.hpp"
#include "server/net/loop_timer.hpp"
#include "server/net/tls_context.hpp"
#include "server/rtp/rtp_sender.hpp"
#include "server/service/access_files.hpp"
#include "server/service/liveness_watch.hpp"
#include "server/service/loop_executor.hpp"
#include "server/service/measurement_files.hpp"
#include "server/service/preset_file.hpp"
#include "server/service/recording_watch.hpp"
#include "server/service/scene_guard.hpp"
#include "server/service/server_signals.hpp"
#include "server/service/source_watch.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace fanlight {

/// The server: owns the state, the protocols (HTTP and WebSocket on one port, OpenIGTLink, RTP) and the event
/// loop, and connects them. All run on the thread that calls run(), the server thread.
class StreamServer {
 public:
  struct Config {
    boost::asio::ip::tcp::endpoint endpoint;
    ServerState::Config state;
    TlsFiles tls;                          ///< empty: no TLS
    bool hsts = false;                     ///< with TLS: browsers come to this host over TLS only, for a year
    AllowedOrigins allowed_origins{};      ///< other sites whose pages may use the server
    std::filesystem::path credentials;     ///< empty: every client is an admin
    std::filesystem::path presets;         ///< keeps what people save; empty: until the end only
    std::filesystem::path audit_log;       ///< empty: no audit log
    std::uint64_t audit_rotate_bytes = 0;  ///< see AuditFile::open()
    bool audit_required = false;           ///< see AuditLog::require()
    std::int64_t control_lapse_ms = 60'000;
    /// The server ends with an error where a call of the GPU's driver takes longer: a supervisor restarts it.
    /// Longer than a driver takes to build a pipeline.
    std::int64_t most_driver_ms = 60'000;
    /// And where a GPU that was lost has shown no picture for this long.
    std::int64_t most_gpu_lost_ms = 30'000;
    std::int64_t most_end_ms = 1'000;  ///< for displays to take their close frame
    std::size_t most_connections = 2048;
    std::size_t most_connections_a_host = 256;  ///< except this machine, which may run a proxy
    SessionLimits session_limits;
    std::optional<IgtlServer::Config> igtl{};  ///< absent: no OpenIGTLink
    std::optional<RtpSender::Config> rtp{};    ///< absent: pictures are sent to no RTP receiver
  };
  /// For the supervisor of the process; each may be empty. Server thread.
  struct Hooks {
    std::function<void(const PictureLiveness::Report& report)> second_passed{};
    std::function<bool()> read_again{};  ///< on SIGHUP, before files are read again; false: to end instead
    std::function<void()> was_read_again{};  ///< and after
    std::function<void()> ends{};            ///< the server begins to end
  };
  /// All must outlive the server.
  struct Dependencies {
    PipelinePorts ports;
    ServerCounters& counters;
    SurfaceFinder find_surface{};  ///< empty: no surfaces are found
    FluidMeter measure_fluid{};    ///< empty: no fluid is measured
    IgtlServer::WriteFrame write_frame{};
    Hooks hooks{};
    OpenStillArchive open_archive{};  ///< empty: displays send nothing to an archive
  };

  /// Listens; connections wait until run(). Errors: kUnavailable if the address is in use or not of this
  /// machine; those of the files in the configuration.
  static Result<std::unique_ptr<StreamServer>> create(const Config& config, const Dependencies& dependencies);

  ~StreamServer();

  /// The address that it listens on, with the port that the system chose if the configuration has port 0.
  boost::asio::ip::tcp::endpoint endpoint() const { return listener_.endpoint(); }

  /// Of OpenIGTLink, with the port that the system chose; nullopt: there is none.
  std::optional<boost::asio::ip::tcp::endpoint> igtl_endpoint() const {
    return igtl_ ? std::optional(igtl_->endpoint()) : std::nullopt;
  }

  /// Blocks and serves until SIGINT, SIGTERM, stop(), or a failure, which it returns. Signals: see
  /// ServerSignals. After the first signal, or a failure, displays get a close frame and have
  /// Config::most_end_ms to take it. Writes the last lines of the audit log before it returns.
  Result<void> run();

  /// The title of the source for displays that connect from now on. Server thread.
  void set_title(const std::string& title) { state_.description.title = title; }
  /// The silence after which the control is free again. Server thread.
  void set_control_lapse_ms(std::int64_t lapse_ms) { control_.set_lapse_ms(lapse_ms); }

  /// Ends run(). Any thread.
  void stop() { loop_.stop(); }

 private:
  StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit, Authenticator access);
  Executor executor();
  Result<void> open_archive();
  void start_relay();
  /// Runs the loop until stop(). Where memory runs out in a handler, the others continue.
  void run_loop();
  /// Starts the chains of the loop that do not run.
  void start_chains();
  void fail(const Error& error);
  /// Sends every display that the server ends, and stops when all have left, or after Config::most_end_ms.
  void end(const std::string& reason);
  void stop_without_sessions();
  void close_audit();
  void read_again();
  void log_state() const;
  void watch_bell();
  /// Reads all mailboxes.
  void bell_rang();
  void take_answers();
  void take_picture();
  void survey_answered(const SurveyDesk::Answer& answer);
  void show_private_views();
  void second_passed();
  void expire_control();
  void end_views(const std::vector<ViewAdmission::EndedView>& ended);
  /// Clients that need pictures and are no sessions.
  std::size_t other_clients() const;

  Config config_;
  Dependencies dependencies_;
  // The loop is declared after what sessions use: its destruction ends the pending operations of sessions.
  ServerState state_;
  PictureHub hub_;
  SessionRegistry sessions_;
  AuditLog audit_;
  Authenticator access_;
  ControlLease control_;
  CommandExecutor commands_;
  PresetFile preset_file_;
  MeasurementFiles measurement_files_;
  ServerMessages messages_;
  StreamRequests::Dependencies requests_;
  StreamSession::Dependencies streams_;
  RestApi rest_api_;
  HttpSession::Dependencies http_;
  ConnectionLimit connection_limit_;
  boost::asio::io_context loop_{1};
  ConnectionListener listener_;
  std::optional<IgtlServer> igtl_;
  std::optional<RtpSender> rtp_;
  AccessFiles access_files_;
  SourceWatch source_watch_;
  RecordingWatch recording_watch_;
  SceneGuard scene_guard_;
  LivenessWatch liveness_watch_;
  ServerSignals signals_;
  boost::asio::posix::stream_descriptor bell_{loop_};
  LoopChain bell_chain_;
  LoopTimer second_;
  boost::asio::steady_timer private_pause_{loop_};
  boost::asio::steady_timer end_pause_{loop_};
  LoopChain end_chain_;
  bool ending_ = false;
  std::int64_t end_until_ns_ = 0;  // then the server ends, even if sessions are left
  std::optional<Error> failure_;
  // These two are last: they end first, and their results go to the loop.
  LoopExecutor executor_{loop_};
  std::unique_ptr<StillArchive> archive_;
};

}  // namespace fanlight
