// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/assembly/assembler.hpp"
#include "acquisition/open_source.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/igtl_options.hpp"
#include "server/cli/option_sources.hpp"
#include "server/cli/recording_options.hpp"
#include "server/cli/rtp_options.hpp"
#include "server/cli/scene_options.hpp"
#include "server/net/tls_context.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/view_admission.hpp"

namespace fanlight {

/// The options of `fanlight serve`, by the command line, the environment and a configuration.
struct ServeOptions {
  std::string source = "phantom:";
  std::string title;
  SourceOptions playing{.ends_whole = true, .ending = ReplaySource::Ending::kToAndFro};
  std::string listen = "127.0.0.1:8080";
  IgtlOptions igtl;
  RtpOptions rtp;
  TlsFiles tls;
  std::string tokens;
  std::string presets;
  std::string archive_queue;
  std::string audit_log;
  std::uint64_t audit_log_mb = 0;
  double control_lapse_s = 60;
  std::size_t private_views = kMostPrivateViews;
  bool hsts = false;
  std::string allow_origin;
  bool audit_required = false;
  bool render_unwatched = false;
  bool print_config = false;
  MismatchCorrection mismatch = MismatchCorrection::kOn;
  std::optional<RingPolicy> policy;  ///< absent: what suits the source
  ProbeControl probe_control = ProbeControl::kEveryone;
  std::string size = "512x512";
  std::string size_max = "2048x2048";
  std::string gpu;
  int jpeg_quality = 85;
  std::uint32_t ring_slots = 4;
  std::uint32_t cine_volumes = 32;
  RecordingOptions recording;
  AutoOptions automatic;
  SceneOptions scene;
  std::string log_level;  ///< empty: info, or what SPDLOG_LEVEL says
  std::string log_format = "text";
  std::string config;
  OptionOrigins origins;  ///< of those that the environment or a configuration gave

  /// What the configuration said of what is in force.
  std::vector<ConfiguredOption> configured;
  /// Sentences about variables that set nothing.
  std::vector<std::string> misspelt;
  /// What the command line and the environment gave, which comes first.
  std::vector<ConfiguredOption> given_before;

  /// The object must live as long as the command, and not move.
  void add_to(CLI::App& command);

  /// A refusal of the value of an option, with the place that gave it, such as "fanlight.toml, line 3".
  Error placed(const std::string& name, Error refusal) const;
  /// The same for the source. A number that names no file was most likely meant as a port: --listen.
  Error source_refusal(const Error& refusal) const;

  /// Refuses what is wrong with the source, the scene, tokens and certificates. A probe need not be plugged
  /// in, and a recording that a crash left is not looked into. Reads files, and writes none.
  Result<void> check_inputs() const;

  /// Reads the configuration again. Takes what a running server can change: title, control-lapse_s and
  /// log_level of this object, where neither the command line nor the environment gave them. The names of all
  /// that was changed come back, and whether each takes effect. Errors: as at the start; nothing is changed.
  struct Reread {
    std::string name;
    bool in_force = false;  ///< false: it takes a new start
  };
  Result<std::vector<Reread>> read_again();

 private:
  void add_network_options(CLI::App& command);
  void add_access_options(CLI::App& command);
  void add_source_options(CLI::App& command);
  void add_picture_options(CLI::App& command);
  void add_volume_options(CLI::App& command);
  void add_service_options(CLI::App& command);
};

}  // namespace fanlight
