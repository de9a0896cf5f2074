// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/access/credentials.hpp"
#include "server/client/stream_client.hpp"
#include "tests/support/made_certificate.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {

/// A server with TLS, one token per role, one client certificate (role operator), and an audit log, all in a
/// temporary folder.
class TlsServerFixture {
 public:
  explicit TlsServerFixture(std::int64_t control_lapse_ms = 60'000, bool hsts = false) {
    server_certificate_.write(file("server.pem"), file("server.key"));
    authority_.write(file("ca.pem"), file("ca.key"));
    client_certificate_.write(file("client.pem"), file("client.key"));
    for (const Role role : {Role::kViewer, Role::kOperator, Role::kAdmin}) {
      const NewToken token = make_token(std::string(role_name(role)) + " of the test", role, std::nullopt);
      tokens_.push_back(token);
      if (!append_token(file("tokens.toml"), token.entry)) std::abort();
    }
    std::ofstream(file("tokens.toml"), std::ios::app)
        << "[[certificate]]\nname = \"console\"\nrole = \"operator\"\nsha256 = \""
        << hex(client_certificate_.fingerprint()) << "\"\n";
    StreamServer::Config config;
    config.tls = {.certificate = file("server.pem"), .key = file("server.key"), .client_ca = file("ca.pem")};
    config.credentials = file("tokens.toml");
    config.audit_log = file("audit.log");
    config.control_lapse_ms = control_lapse_ms;
    config.hsts = hsts;
    fixture_ = std::make_unique<ServerFixture>(config);
  }

  ServerFixture& fixture() { return *fixture_; }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  const NewToken& token(Role role) const { return tokens_[static_cast<std::size_t>(role)]; }
  const MadeCertificate& authority() const { return authority_; }
  std::string url() const { return "https://127.0.0.1:" + std::to_string(fixture_->endpoint().port()); }

  /// Configuration of a client that logs in with the token of the role.
  StreamClient::Config display(Role role) const {
    return {.url = url(), .token = token(role).text, .server_ca = file("server.pem")};
  }
  std::unique_ptr<StreamClient> come_in(Role role) const {
    auto client = StreamClient::connect(display(role));
    if (!client) throw std::runtime_error(client.error().message);
    return std::move(*client);
  }

  /// Entries of the audit log whose "what" equals `what`. Waits up to 5 s until there are `at_least` of them,
  /// then returns those that exist.
  std::vector<nlohmann::json> audited(const std::string& what, std::size_t at_least = 1) const {
    for (int attempt = 0;; ++attempt) {
      std::vector<nlohmann::json> lines;
      std::ifstream log(file("audit.log"));
      for (std::string line; std::getline(log, line);) {
        auto parsed = nlohmann::json::parse(line, nullptr, false);
        if (parsed.is_object() && parsed["what"] == what) lines.push_back(std::move(parsed));
      }
      if (lines.size() >= at_least || attempt == 100) return lines;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

 private:
  TemporaryFolder folder_;
  MadeCertificate server_certificate_{{}};
  MadeCertificate authority_{{.name = "fanlight test authority", .authority = true}};
  MadeCertificate client_certificate_{{.name = "console"}, &authority_};
  std::vector<NewToken> tokens_;
  std::unique_ptr<ServerFixture> fixture_;
};

}  // namespace fanlight::test
