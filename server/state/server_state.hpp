// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "proto/exchange/pipeline_ports.hpp"
#include "server/state/cine_proxy.hpp"
#include "server/state/default_view.hpp"
#include "server/state/fluid_desk.hpp"
#include "server/state/measurement_store.hpp"
#include "server/state/picture_demand.hpp"
#include "server/state/picture_liveness.hpp"
#include "server/state/picture_times.hpp"
#include "server/state/preset_store.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/relay.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/state/server_counters.hpp"
#include "server/state/still_archive.hpp"
#include "server/state/survey_desk.hpp"
#include "server/state/view_admission.hpp"
#include "server/state/volume_copier.hpp"

namespace fanlight {

/// Description of the server that a client receives when its session opens.
struct ServerDescription {
  std::string source;  ///< as on the command line; may be the path of a file, which only an admin sees
  std::string title;   ///< for everyone
  std::string path;    ///< of the recording that is played; never sent
  FrameOrigin origin = FrameOrigin::kProbe;  ///< unless the sender of the frames says otherwise
  std::string device;
  PictureSize picture_size;          ///< usual one
  PictureSize largest_picture_size;  ///< for displays that ask for more
  int jpeg_quality = 85;             ///< if a session asks for none
  std::vector<std::string> notes;    ///< see SourceDescription::notes, and DefaultView::note()
};

/// All that clients see and may change, except sessions, control and pictures. The parts do not know
/// of each other, except through their constructors. Server thread only.
struct ServerState {
  struct Config {
    ServerDescription description;
    NumberedScene initial_scene;                   ///< the scene that the renderer was made with
    Scene suggested_scene;                         ///< scene_for() of the source, without options of the user
    std::vector<const SceneField*> chosen_fields;  ///< those that the user gave options for
    bool finds_view = false;                       ///< no option chose a view: see DefaultView
    ProbeControl probe_control = ProbeControl::kEveryone;
    std::size_t most_private_views = kMostPrivateViews;
    bool renders_unwatched = false;  ///< every volume is rendered, even without clients
    RecordingProxy::Config recording;
  };
  /// All must outlive this object, except what the executor runs.
  struct Dependencies {
    const PipelinePorts& ports;
    ServerCounters& counters;
    Executor executor;
    SurfaceFinder find_surface;  ///< empty: no surfaces are found
    std::function<void(const SurveyDesk::Answer&)> survey_answered;
    FluidMeter measure_fluid;  ///< empty: no fluid is measured
    std::function<void(const FluidDesk::Answer&)> fluid_answered;
    std::function<void()> presets_changed;               ///< see PresetStore
    std::function<void()> measurements_changed = [] {};  ///< see MeasurementStore
  };
  ServerState(const Config& config, const Dependencies& dependencies);
  ServerState(const ServerState&) = delete;
  ServerState& operator=(const ServerState&) = delete;

  /// The main view shows a picture.
  void picture_shown(const Picture& picture, std::int64_t now_ns);

  /// Where the frames come from, at the first of several senders.
  FrameOrigin frame_origin() const;

  bool is_relayed() const { return relay != nullptr && relay->sending(); }
  /// "running", "ended", or the sentence why the source failed, without the path of a recording.
  std::string source_state() const;

  ServerCounters& counters;
  PipelineCounters pipeline;
  ServerDescription description;
  SceneStore scene_store;
  ProbeProxy probe;
  PictureLiveness liveness;
  PictureTimes times;
  ViewAdmission views;
  VolumeCopier volumes;
  SurveyDesk surveys;
  FluidDesk fluid;
  RecordingProxy recording;
  ReplayProxy replay;
  CineProxy cine;
  PictureDemand demand;
  PresetStore presets;
  MeasurementStore measurements;
  DefaultView default_view;
  Relay* relay = nullptr;           ///< null: the server was given no receiver
  StillArchive* archive = nullptr;  ///< null: the server was given no queue

 private:
  std::function<std::string()> source_state_;
};

}  // namespace fanlight
