// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>

#include "server/access/file_version.hpp"
#include "server/http/http_session.hpp"
#include "server/net/connect_rate.hpp"
#include "server/net/connection_limit.hpp"
#include "server/net/loop_chain.hpp"
#include "server/net/tls_context.hpp"

namespace fanlight {

/// The server's port: accepts connections within the limits, and begins an HttpSession on each, with TLS
/// where there is a certificate. Server thread only.
class ConnectionListener {
 public:
  struct Config {
    boost::asio::ip::tcp::endpoint endpoint;
    TlsFiles tls;  ///< empty: no TLS
  };
  /// Must outlive the listener, and its connections, which the loop may keep longer.
  struct Dependencies {
    ServerCounters& counters;
    ConnectionLimit& limit;
    const HttpSession::Dependencies& http;
  };
  ConnectionListener(boost::asio::io_context& loop, Config config, const Dependencies& dependencies);

  /// Reads the certificates and opens the port. Errors: kUnavailable if the address is in use or not of this
  /// machine; those of the files.
  Result<void> open();

  /// Accepts from now on. Begins again where a lack of memory has ended it.
  void start();

  /// Accepts no further connection.
  void close();

  /// With the port that the system chose if the configuration has port 0. Precondition: open().
  boost::asio::ip::tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }

  /// Called once a second.
  void second_passed();

  /// Reads the certificates again if they have changed, or `in_any_case`. The result where there is news:
  /// "done", or what is wrong with the files, once for each error.
  std::optional<std::string> reload_certificates(bool in_any_case);

 private:
  Result<void> read_certificates();
  void accept();
  void accepted(boost::system::error_code failure, boost::asio::ip::tcp::socket socket);
  void begin_session(boost::asio::ip::tcp::socket socket);
  void accept_later();

  Config config_;
  Dependencies dependencies_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  LoopChain chain_;
  bool waits_for_second_ = false;                       // enough were accepted within this second
  ConnectRate rate_;                                    // where there is TLS
  std::shared_ptr<boost::asio::ssl::context> context_;  // null: no TLS
  std::array<FileVersion, 3> certificates_read_;
  std::string certificates_result_;  // the last error that was reported; empty: none
};

}  // namespace fanlight
