#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/doorbell.hpp"
#include "proto/mailbox.hpp"
#include "server/stream_context.hpp"
#include "server/tls_context.hpp"

namespace fanlight {

/// The one port: HTTP and WebSocket, in one loop on the thread that calls run(). Reads pictures from a
/// mailbox, leaves scenes in another.
class StreamServer {
 public:
  struct Config {
    boost::asio::ip::tcp::endpoint endpoint;
    HouseFacts facts;
    NumberedScene initial_scene;        ///< what the renderer was made with
    Scene suggested_scene;              ///< scene_for() of the source: what nobody chose
    TlsFiles tls;                       ///< empty: no TLS
    std::filesystem::path credentials;  ///< empty: everyone may do everything
    std::filesystem::path audit_log;    ///< empty: none is kept
    std::int64_t control_lapse_ms = 60'000;
    ProbeControl probe_control = ProbeControl::kEveryone;
    std::size_t most_connections = 2048;
    std::size_t most_connections_a_host = 256;  ///< but of this one, where a proxy may stand
    std::size_t most_private_views = kMostPrivateViews;
  };
  /// All must outlive the server. `bell` is the one that the mailboxes ring for their reader, and whoever
  /// changes what source_state() says.
  struct Dependencies {
    Doorbell& bell;
    Mailbox<Picture>& pictures;
    Mailbox<NumberedScene>& scenes;
    Mailbox<Error>& failures;
    HouseCounters house;
    ProbeLink& probe;
    ServerCounters& counters;
    std::function<std::string()> source_state;
    Mailbox<PrivateViews>* private_views = nullptr;  ///< may be null: then there are none to be had
  };

  /// Listens; connections wait until run(). kUnavailable where the address is in use or not ours; the errors
  /// of the files in the configuration.
  static Result<std::unique_ptr<StreamServer>> create(const Config& config, const Dependencies& dependencies);

  ~StreamServer();

  /// Where it listens, with the port that was chosen.
  boost::asio::ip::tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }

  /// Serves until SIGINT or SIGTERM or stop(), or until something is broken.
  Result<void> run();

  /// Any thread: ends run().
  void stop() { loop_.stop(); }

 private:
  StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit, AccessDesk access);
  Result<void> listen();
  Result<void> read_certificates();
  void accept();
  void accepted(boost::system::error_code failure, boost::asio::ip::tcp::socket socket);
  void watch_bell();
  void bell_rang();
  void count_seconds();
  void second_passed();
  std::vector<std::shared_ptr<StreamSession>> all_sessions() const;
  void show_private_views();
  void probe_told();
  void fail(const Error& error);

  Config config_;
  Dependencies from_;
  // The loop goes last: destroying it ends the sessions, which leave the hub.
  SceneDesk desk_;
  ProbeDesk probe_;
  ProbeStatus logged_;  // of it, the last that the log has
  ViewDesk views_;
  PictureHub hub_;
  AuditLog audit_;
  AccessDesk access_;
  ControlDesk control_;
  std::unordered_set<StreamSession*> strangers_;
  std::uint64_t sessions_so_far_ = 0;
  StreamContext context_;
  std::shared_ptr<boost::asio::ssl::context> tls_;  // null: none
  std::array<FileMark, 3> certificates_read_;
  std::string certificates_result_;  // the last trouble with them that was told
  ConnectionPlaces places_;
  boost::asio::io_context loop_{1};
  boost::asio::ip::tcp::acceptor acceptor_{loop_};
  boost::asio::posix::stream_descriptor bell_{loop_};
  boost::asio::steady_timer second_{loop_};
  boost::asio::steady_timer accept_pause_{loop_};
  boost::asio::steady_timer private_pause_{loop_};
  boost::asio::signal_set signals_{loop_};
  std::optional<Error> failure_;
};

}  // namespace fanlight
