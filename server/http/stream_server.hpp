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

#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/render_health.hpp"
#include "server/http/connection_listener.hpp"
#include "server/http/http_session.hpp"
#include "server/http/liveness_watch.hpp"
#include "server/http/recording_watch.hpp"
#include "server/http/rest_api.hpp"
#include "server/http/rtp_api.hpp"
#include "server/http/server_signals.hpp"
#include "server/igtl/igtl_server.hpp"
#include "server/metrics/picture_times.hpp"
#include "server/net/loop_chain.hpp"
#include "server/net/tls_context.hpp"
#include "server/rtp/rtp_sender.hpp"
#include "server/state/default_view.hpp"
#include "server/state/picture_demand.hpp"
#include "server/state/picture_liveness.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/state/view_admission.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace fanlight {

/// The server: HTTP and WebSocket on one port, in one event loop on the thread that calls run(), the server
/// thread. Reads pictures from a mailbox and writes scenes to another.
class StreamServer {
 public:
  struct Config {
    boost::asio::ip::tcp::endpoint endpoint;
    ServerDescription facts;
    NumberedScene initial_scene;                   ///< the scene that the renderer was made with
    Scene suggested_scene;                         ///< scene_for() of the source, without options of the user
    std::vector<const SceneField*> chosen_fields;  ///< those that the user gave options for
    bool finds_view = false;                       ///< nobody chose a view: see DefaultView
    TlsFiles tls;                                  ///< empty: no TLS
    bool hsts = false;                     ///< with TLS: browsers come to this host over TLS only, for a year
    std::filesystem::path credentials;     ///< empty: every client is an admin
    std::filesystem::path presets;         ///< keeps what people save; empty: until the end only
    std::filesystem::path audit_log;       ///< empty: no audit log
    std::uint64_t audit_rotate_bytes = 0;  ///< see AuditFile::open()
    std::int64_t control_lapse_ms = 60'000;
    /// The server ends with an error where a call of the GPU's driver takes longer: a supervisor starts it
    /// anew. Longer than a driver takes to build a pipeline.
    std::int64_t most_driver_ms = 60'000;
    std::int64_t most_end_ms = 1'000;  ///< for displays to take their close frame
    ProbeControl probe_control = ProbeControl::kEveryone;
    std::size_t most_connections = 2048;
    std::size_t most_connections_a_host = 256;  ///< except this machine, which may run a proxy
    std::size_t most_private_views = kMostPrivateViews;
    RecordingProxy::Config recording;
    SessionLimits session_limits;
    std::optional<IgtlServer::Config> igtl{};  ///< absent: no OpenIGTLink
    std::optional<RtpSender::Config> rtp{};    ///< absent: pictures are sent nowhere else
  };
  /// All must outlive the server. `bell`: rung by the mailboxes that the server reads, and when the result of
  /// source_state() changes.
  struct Dependencies {
    Doorbell& bell;
    Mailbox<Picture>& pictures;
    Mailbox<NumberedScene>& scenes;
    Mailbox<Error>& failures;
    PipelineCounters pipeline;
    ProbeLink& probe;
    ReplayLink& replay;
    ServerCounters& counters;
    std::function<std::string()> source_state;
    Mailbox<PrivateViews>* private_views = nullptr;         ///< null: private views are not available
    Mailbox<PrivateViewEnds>* private_view_ends = nullptr;  ///< null: the renderer ends none by itself
    Mailbox<RenderHealth>* render_health = nullptr;         ///< null: the renderer is always well
    Mailbox<SurveyOrder>* survey_orders = nullptr;          ///< null: nobody looks for surfaces
    Mailbox<SurveyResult>* survey_results = nullptr;
    Mailbox<VolumeOrder>* volume_orders = nullptr;  ///< null: no volumes are sent
    Mailbox<VolumeAnswer>* volume_answers = nullptr;
    std::optional<RecordingLink> recording{};  ///< absent: nothing is recorded
    CineLink* cine = nullptr;                  ///< null: nothing is ever frozen
    Audience* audience = nullptr;              ///< null: every volume is rendered, whoever looks
    FrameTap* frames = nullptr;                ///< of the source, for OpenIGTLink; null: none are sent
    /// See IgtlServer::Dependencies.
    decltype(IgtlServer::Dependencies::write_frame) write_frame{};
    /// For whoever supervises the process; each may be empty. Server thread.
    std::function<void(const PictureLiveness::Report& report)> second_passed{};
    std::function<bool()> read_again{};  ///< on SIGHUP, before files are read again; false: to end instead
    std::function<void()> was_read_again{};  ///< and after
    std::function<void()> ends{};            ///< the server begins to end
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

  /// What displays that come from now on call the source. Server thread.
  void set_title(const std::string& title) { config_.facts.title = title; }
  /// The silence after which the control is free again. Server thread.
  void set_control_lapse_ms(std::int64_t lapse_ms) { control_.set_lapse_ms(lapse_ms); }

  /// Ends run(). Any thread.
  void stop() { loop_.stop(); }

 private:
  StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit, Authenticator access);
  PictureHub::Config hub_config();
  IgtlServer::Dependencies igtl_dependencies();
  RtpSender::Dependencies rtp_dependencies();
  /// Begins to send by RTP where that was configured so.
  void start_rtp();
  /// Calls it on the server thread. Any thread. Waits for memory where there is none: the hub counts on it.
  void post(const std::shared_ptr<std::function<void()>>& done);
  /// Runs the loop until stop(). Where memory runs out in a handler, goes on with the others.
  void run_loop();
  /// Begins the chains of the loop that are not under way.
  void begin_chains();
  /// Tells every display that the server ends, and stops when all have left, or after Config::most_end_ms.
  void end(const std::string& reason);
  void stop_without_sessions();
  void close_audit();
  void read_again();
  void tell_state();
  void watch_bell();
  /// Reads all mailboxes.
  void bell_rang();
  void start_second();
  void second_passed();
  /// Reads files that have changed; `in_any_case`: also those that have not.
  void reload_credentials(bool in_any_case);
  void reload_certificates(bool in_any_case);
  void lapse_control();
  void notify_sessions_of_second();
  /// Who needs pictures beside displays.
  std::size_t other_clients() const;
  void end_views(const std::vector<ViewAdmission::EndedView>& ended);
  void show_private_views();
  void probe_changed();
  void tell_of_replay();
  void presets_changed();
  void write_presets();
  /// A file that cannot be read, or not whole, is copied aside before anything replaces it.
  void load_presets();
  bool save_presets(const std::string& text) const;
  void fail(const Error& error);

  Config config_;
  Dependencies dependencies_;
  // The loop is declared after what sessions use: its destruction ends the pending operations of sessions.
  SceneStore scene_store_;
  ProbeProxy probe_;
  ProbeStatus logged_;  // the last status that was logged
  PictureLiveness liveness_;
  PictureTimes times_;
  ViewAdmission views_;
  SurveyDesk surveys_;
  RecordingProxy recording_;
  ReplayProxy replay_;
  std::string replay_trouble_;  // that was logged last
  CineProxy cine_;
  PictureDemand demand_;
  PresetStore presets_{[this] { presets_changed(); }};
  bool writing_presets_ = false;    // on a thread of the encoders
  bool presets_unwritten_ = false;  // they have changed since the last writing began, or it has failed
  DefaultView default_view_;
  bool relayed_ = false;  // pictures are sent by RTP
  PictureHub hub_;
  SessionRegistry sessions_;
  AuditLog audit_;
  Authenticator access_;
  ControlLease control_;
  ServerMessages messages_;
  StreamRequests::Dependencies request_dependencies_;
  StreamSession::Dependencies stream_dependencies_;
  RtpApi rtp_api_;
  RestApi rest_api_;
  HttpSession::Dependencies http_dependencies_;
  ConnectionLimit connection_limit_;
  boost::asio::io_context loop_{1};
  ConnectionListener listener_;
  std::optional<IgtlServer> igtl_;
  std::optional<RtpSender> rtp_;
  boost::asio::posix::stream_descriptor bell_{loop_};
  boost::asio::steady_timer second_{loop_};
  boost::asio::steady_timer private_pause_{loop_};
  boost::asio::steady_timer end_pause_{loop_};
  LoopChain bell_chain_;
  LoopChain second_chain_;
  LoopChain end_chain_;
  ServerSignals signals_;
  LivenessWatch liveness_watch_{loop_,
                                {.liveness = liveness_,
                                 .probe = probe_,
                                 .replay = replay_,
                                 .cine = cine_,
                                 .recording = recording_,
                                 .demand = demand_,
                                 .hub = hub_,
                                 .source_state = dependencies_.source_state,
                                 .health = dependencies_.render_health,
                                 .sessions = sessions_,
                                 .other_clients = [this] { return other_clients(); },
                                 .changed =
                                     [this] {
                                       if (igtl_) igtl_->state_changed();
                                     }}};
  RecordingWatch recording_watch_{{.proxy = recording_, .sessions = sessions_, .audit = audit_}};
  bool ending_ = false;
  std::int64_t end_until_ns_ = 0;  // then the server ends, whoever is still there
  std::optional<Error> failure_;
  EncoderPool encoders_;  // last: it ends first, and its results go to the loop
};

}  // namespace fanlight
