// SPDX-License-Identifier: Apache-2.0
// Who may give which command: one table for the executor and for each protocol.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <map>

#include "proto/igtl/text_bodies.hpp"
#include "server/client/stream_client.hpp"
#include "server/command/command_executor.hpp"
#include "tests/igtl/igtl_server_rig.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace command_tests {

constexpr std::array kRoles = {Role::kViewer, Role::kOperator, Role::kAdmin};

v1::ClientMessage message_of(const std::function<void(v1::ClientMessage&)>& fill) {
  v1::ClientMessage message;
  fill(message);
  return message;
}

v1::ClientMessage control_message(v1::ControlRequest::Wish wish) {
  return message_of([&](v1::ClientMessage& message) { message.mutable_control()->set_wish(wish); });
}

/// A command, as each protocol has it.
struct Row {
  const char* name;
  ClientCommand command;
  Role least_role;
  bool needs_control;            ///< refused while another session is in control
  v1::ClientMessage message;     ///< at /stream; without a body: it has none
  std::string rest_method = "";  ///< empty: REST has none
  std::string rest_path = "";
  std::string rest_body = "";
  std::string xml = "";  ///< for OpenIGTLink; empty: it has none
};

v1::Scene light_of(double up_mm) {
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(up_mm);
  return scene;
}

v1::PresetRequest saved_preset() {
  v1::PresetRequest request;
  request.mutable_save()->set_name("mine");
  return request;
}

v1::MeasurementRequest removal() {
  v1::MeasurementRequest request;
  request.set_remove_all(true);
  return request;
}

std::vector<Row> table() {
  using Wish = v1::ControlRequest;
  return {
      {"scene", ChangeScene{light_of(20)}, Role::kOperator, true,
       message_of([](auto& message) { *message.mutable_scene_change()->mutable_scene() = light_of(20); }),
       "PATCH", "/api/scene", R"({"light": {"up_mm": 20}})",
       R"(<Command Name="SetParameter"><Parameter Name="light.up_mm" Value="20"/></Command>)"},
      {"view", ChangeView{light_of(20)}, Role::kViewer, false,
       message_of([](auto& message) { *message.mutable_view()->mutable_scene() = light_of(20); })},
      {"leave view", LeaveView(), Role::kViewer, false,
       message_of([](auto& message) { message.mutable_view()->set_leave(true); })},
      {"probe", ChangeProbe(), Role::kOperator, true, message_of([](auto& message) {
         message.mutable_probe_change()->mutable_settings()->set_sweep_deg(40);
       })},
      {"survey", FindSurface(), Role::kOperator, true,
       message_of([](auto& message) { message.mutable_survey(); })},
      {"fluid", MeasureFluid(), Role::kViewer, false,
       message_of([](auto& message) { message.mutable_fluid(); })},
      {"recording", ControlRecorder{RecordingWish::kStop}, Role::kOperator, true,
       message_of([](auto& message) { message.mutable_recording()->set_wish(v1::RecordingRequest::STOP); }),
       "POST", "/api/recording", R"({"wish": "stop"})"},
      {"replay", ControlReplay(), Role::kOperator, true,
       message_of([](auto& message) { message.mutable_replay()->set_wish(v1::ReplayRequest::PAUSE); }),
       "POST", "/api/replay", R"({"wish": "pause"})"},
      {"cine", ControlCine(), Role::kOperator, true,
       message_of([](auto& message) { message.mutable_cine()->set_wish(v1::CineRequest::FREEZE); }), "POST",
       "/api/cine", R"({"wish": "freeze"})"},
      {"preset", ChangePresets{saved_preset()}, Role::kOperator, false,
       message_of([](auto& message) { *message.mutable_preset() = saved_preset(); }), "POST", "/api/presets",
       R"({"save": "mine"})"},
      {"measurement", ChangeMeasurements{removal()}, Role::kOperator, false,
       message_of([](auto& message) { *message.mutable_measurement() = removal(); }), "POST",
       "/api/measurements", R"({"remove_all": true})"},
      {"relay",
       ControlRelay{.sends = true},
       Role::kAdmin,
       false,
       {},
       "POST",
       "/api/rtp",
       R"({"wish": "start"})"},
      {"archive", SendStill(), Role::kOperator, false, {}, "POST", "/api/archive", "{}"},
      {"ask", ChangeControl{.wish = Wish::ASK}, Role::kOperator, false, control_message(Wish::ASK)},
      {"release", ChangeControl{.wish = Wish::RELEASE}, Role::kViewer, false, control_message(Wish::RELEASE)},
      {"grant", ChangeControl{.wish = Wish::GRANT}, Role::kViewer, false, control_message(Wish::GRANT)},
      {"keep", ChangeControl{.wish = Wish::KEEP}, Role::kViewer, false, control_message(Wish::KEEP)},
      {"take over", ChangeControl{.wish = Wish::TAKE_OVER}, Role::kAdmin, false,
       control_message(Wish::TAKE_OVER)},
  };
}

/// The executor with a state that no thread reads.
class CommandTest : public testing::Test {
 protected:
  CommandResult::Refused give(const ClientCommand& command, Role role, std::uint64_t session) {
    const SessionIdentity identity{
        .id = session, .address = "", .principal = Principal{.role = role}, .name = "one"};
    SessionAudit audit(log_, identity);
    auto refused = CommandResult::Refused::kNot;
    executor_.execute({.identity = identity, .audit = audit}, command,
                      [&](const CommandResult& result) { refused = result.refused; });
    executor_.forget(session);
    return refused;
  }

  Doorbell bell_;
  RenderLink link_{bell_, bell_};
  AcquisitionCounters acquisition_;
  RingCounters ring_;
  QueueCounters queue_;
  RenderCounters render_;
  ProbeLink probe_{bell_, bell_};
  ReplayLink replay_{bell_};
  ServerCounters counters_;
  PipelinePorts ports_{.render = link_,
                       .probe = probe_,
                       .replay = replay_,
                       .counters = {acquisition_, ring_, queue_, render_, probe_.counters, probe_.igtl},
                       .source_state = [] { return std::string("running"); }};
  ServerState state_{
      {},
      {.ports = ports_,
       .counters = counters_,
       .executor = [](EncoderLane, const auto&, const auto&) {},
       .find_surface = [](const Volume&, const Scene&, const std::stop_token&) { return std::nullopt; },
       .survey_answered = [](const SurveyDesk::Answer&) {},
       .measure_fluid =
           [](const Volume&, const FluidQuestion&, const std::stop_token&) {
             return Error{ErrorCode::kUnavailable, "none"};
           },
       .fluid_answered = [](const FluidDesk::Answer&) {},
       .presets_changed = [] {},
       .measurements_changed = [] {}}};
  ControlLease control_;
  AuditLog log_;
  std::vector<Notice> notices_;
  CommandExecutor executor_{state_, control_,
                            [this](Notice notice, std::uint64_t) { notices_.push_back(notice); }};
};

TEST_F(CommandTest, IsRefusedByRoleAndByControlAsTheTableSays) {
  using Refused = CommandResult::Refused;
  constexpr std::uint64_t kOther = 9;
  for (const Row& row : table()) {
    for (const Role role : kRoles) {
      for (const std::uint64_t session : {0, 1}) {
        for (const bool held : {false, true}) {
          (void)control_.left(kOther, 0);
          if (held) control_.take_over({.session = kOther, .name = "other"}, 0);
          const Refused refused = give(row.command, role, session);
          const bool may = role >= row.least_role;
          const auto at = fmt::format("{} by {} of session {}{}", row.name, role_name(role), session,
                                      held ? ", another is in control" : "");
          EXPECT_EQ(refused == Refused::kByRole, !may) << at;
          EXPECT_EQ(refused == Refused::kByControl, may && held && row.needs_control) << at;
        }
      }
    }
  }
}

TEST_F(CommandTest, HasARowForEachKind) {
  std::map<std::size_t, int> rows;
  for (const Row& row : table()) ++rows[row.command.index()];
  EXPECT_EQ(rows.size(), std::variant_size_v<ClientCommand>);
}

TEST_F(CommandTest, OnlyAcceptedChangesOfSessionsAcquireControl) {
  EXPECT_EQ(give(ChangeScene{light_of(1e9)}, Role::kOperator, 1), CommandResult::Refused::kByCommand);
  EXPECT_TRUE(notices_.empty());
  EXPECT_EQ(give(ChangeScene{light_of(20)}, Role::kOperator, 0), CommandResult::Refused::kNot);
  EXPECT_EQ(notices_, std::vector{Notice::kScene}) << "a script is never in control";
  notices_.clear();
  give(ChangeScene{light_of(21)}, Role::kOperator, 1);
  EXPECT_EQ(notices_, (std::vector{Notice::kControl, Notice::kScene, Notice::kControl}))
      << "acquired, and free again after the session";
  EXPECT_EQ(counters_.scene_changes.value(), 2U);
  EXPECT_EQ(counters_.scene_refusals.value(), 1U);
}

TEST_F(CommandTest, ASessionThatHasEndedIsNotAnsweredLater) {
  const SessionIdentity identity{
      .id = 1, .address = "", .principal = Principal{.role = Role::kOperator}, .name = ""};
  SessionAudit audit(log_, identity);
  probe_.status.draft().state = ProbeStatus::State::kStreaming;
  probe_.status.publish();
  ASSERT_TRUE(state_.probe.update());
  ChangeProbe change;
  change.settings.set_sweep_deg(40);
  int answers = 0;
  const auto count = [&](const CommandResult&) { ++answers; };
  executor_.execute({.identity = identity, .audit = audit}, change, count);
  EXPECT_EQ(answers, 0) << "the probe has not answered";
  EXPECT_TRUE(control_.holds(1));
  executor_.forget(1);
  EXPECT_FALSE(control_.holds(1));
  probe_.status.draft().order_answered = 1;
  probe_.status.publish();
  ASSERT_TRUE(state_.probe.update());
  executor_.probe_changed();
  EXPECT_EQ(answers, 0);
  executor_.execute({.identity = identity, .audit = audit}, change, count);
  probe_.status.draft().order_answered = 2;
  probe_.status.draft().refusal = "too far";
  probe_.status.publish();
  ASSERT_TRUE(state_.probe.update());
  executor_.probe_changed();
  EXPECT_EQ(answers, 1);
  EXPECT_FALSE(control_.holds(1)) << "the probe has refused";
}

TEST_F(CommandTest, ASurveyIsAnsweredOnceAndNotAfterItsSession) {
  int answers = 0;
  const auto count = [&](const CommandResult& result) {
    EXPECT_EQ(result.error.message, "none");
    ++answers;
  };
  SurveyDesk::Answer none;
  none.reply.mutable_refused()->set_message("none");
  const SessionIdentity identity{
      .id = 1, .address = "", .principal = Principal{.role = Role::kOperator}, .name = ""};
  SessionAudit audit(log_, identity);
  for (none.asker = 1; none.asker <= 2; ++none.asker) {
    executor_.execute({.identity = identity, .audit = audit}, FindSurface(), count);
    if (none.asker == 2) executor_.forget(1);
    executor_.survey_answered(none);
    executor_.survey_answered(none);
    EXPECT_EQ(answers, 1);
  }
  EXPECT_EQ(counters_.survey_refusals.value(), 0U) << "a volume without a surface is no wrong request";
}

TEST_F(CommandTest, FluidIsMeasuredForAnyRoleAndTheLatestPoint) {
  std::vector<CommandResult> answers;
  const auto keep = [&](const CommandResult& result) { answers.push_back(result); };
  const SessionIdentity identity{
      .id = 1, .address = "", .principal = Principal{.role = Role::kViewer}, .name = ""};
  SessionAudit audit(log_, identity);
  const Requester who{.identity = identity, .audit = audit};
  executor_.execute(who, MeasureFluid(), keep);
  EXPECT_TRUE(answers.empty());
  executor_.execute(who, MeasureFluid(), keep);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_NE(answers[0].error.message.find("replaced"), std::string::npos);
  FluidDesk::Answer answer{.asker = 2, .reply = {}};
  answer.reply.mutable_found()->set_volume_mm3(1234);
  executor_.fluid_answered(answer);
  executor_.fluid_answered(answer);
  ASSERT_EQ(answers.size(), 2U) << "once";
  EXPECT_EQ(answers[1].region.volume_mm3(), 1234);
  executor_.execute(who, MeasureFluid(), keep);
  executor_.forget(1);
  answer.asker = 3;
  executor_.fluid_answered(answer);
  EXPECT_EQ(answers.size(), 2U) << "not after the session";
  EXPECT_EQ(counters_.fluid_refusals.value(), 0U) << "a point without fluid is no wrong request";
  executor_.execute(who, MeasureFluid{{.volume_id = 7}}, keep);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_NE(answers[2].error.message.find("not frozen"), std::string::npos);
  EXPECT_EQ(counters_.fluid_refusals.value(), 1U);
}

TEST_F(CommandTest, WhatCannotBeReadIsRefusedForTheRoleFirst) {
  SessionIdentity identity{.id = 0, .address = "", .principal = Principal{.role = Role::kViewer}, .name = ""};
  SessionAudit audit(log_, identity);
  const Error malformed{ErrorCode::kInvalidArgument, "no JSON"};
  const Requester who{.identity = identity, .audit = audit};
  EXPECT_EQ(executor_.reject(who, ChangeScene(), malformed).refused, CommandResult::Refused::kByRole);
  identity.principal->role = Role::kOperator;
  EXPECT_EQ(executor_.reject(who, ChangeScene(), malformed).error.message, "no JSON");
  control_.take_over({.session = 9, .name = "other"}, 0);
  EXPECT_EQ(executor_.reject(who, ChangeScene(), malformed).refused, CommandResult::Refused::kByControl);
  EXPECT_EQ(counters_.scene_refusals.value(), 3U);
}

// ---- each protocol

/// A server with a token for each role, and with OpenIGTLink for one role.
class ServerOfRoles {
 public:
  explicit ServerOfRoles(Role igtl_role) {
    for (const Role role : kRoles) {
      const NewToken token = make_token(std::string(role_name(role)), role, std::nullopt);
      EXPECT_TRUE(append_token(folder_ / "tokens.toml", token.entry));
      tokens_.push_back(token.text);
    }
    StreamServer::Config config = with_igtl(igtl_role);
    config.credentials = folder_ / "tokens.toml";
    server_ = std::make_unique<ServerFixture>(config);
  }

  /// The reply's refusal; empty: it was not refused.
  std::string stream(Role role, const v1::ClientMessage& message) {
    auto client = StreamClient::connect(
        {.url = fmt::format("http://127.0.0.1:{}/", server_->endpoint().port()), .token = token(role)});
    if (!client) throw std::runtime_error(client.error().message);
    EXPECT_TRUE((*client)->send(message));
    for (;;) {
      const auto got = (*client)->next();
      if (!got) throw std::runtime_error(got.error().message);
      switch (got->body_case()) {
        case v1::ServerMessage::kSceneReply:
          return got->scene_reply().refused().message();
        case v1::ServerMessage::kViewReply:
          return got->view_reply().refused().message();
        case v1::ServerMessage::kProbeReply:
          return got->probe_reply().refused().message();
        case v1::ServerMessage::kSurveyReply:
          return got->survey_reply().refused().message();
        case v1::ServerMessage::kFluidReply:
          return got->fluid_reply().refused().message();
        case v1::ServerMessage::kRecordingReply:
          return got->recording_reply().refused().message();
        case v1::ServerMessage::kReplayReply:
          return got->replay_reply().refused().message();
        case v1::ServerMessage::kCineReply:
          return got->cine_reply().refused().message();
        case v1::ServerMessage::kPresetReply:
          return got->preset_reply().refused().message();
        case v1::ServerMessage::kMeasurementReply:
          return got->measurement_reply().refused().message();
        case v1::ServerMessage::kControlReply:
          return got->control_reply().refused().message();
        default:
          break;
      }
    }
  }

  /// The whole response.
  std::string rest(Role role, const Row& row) {
    boost::asio::io_context loop;
    boost::asio::ip::tcp::socket socket(loop);
    socket.connect(server_->endpoint());
    const std::string request = fmt::format(
        "{} {} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer {}\r\n"
        "Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{}",
        row.rest_method, row.rest_path, token(role), row.rest_body.size(), row.rest_body);
    boost::system::error_code end;
    boost::asio::write(socket, boost::asio::buffer(request), end);
    std::string response;
    boost::asio::read(socket, boost::asio::dynamic_buffer(response), end);
    return response;
  }

  /// The status that answers the header of a request with a large body, which is not sent; 0: none comes.
  int status_before_body(const std::string& target, const std::string& authorization) {
    boost::asio::io_context loop;
    boost::asio::ip::tcp::socket socket(loop);
    socket.connect(server_->endpoint());
    boost::asio::write(socket, boost::asio::buffer(fmt::format(
                                   "{} HTTP/1.1\r\nHost: localhost\r\n{}Expect: 100-continue\r\n"
                                   "Content-Type: application/json\r\nContent-Length: 16000000\r\n\r\n",
                                   target, authorization)));
    std::string response(12, '\0');
    boost::system::error_code end;
    boost::asio::read(socket, boost::asio::buffer(response), end);
    return end ? 0 : std::stoi(response.substr(9));
  }
  std::string authorization(Role role) const { return "Authorization: Bearer " + token(role) + "\r\n"; }

  std::string open_igtl_link(const std::string& xml) {
    TestClient client(server_->igtl_port());
    igtl::put_string(client.writer().begin({.type = "STRING", .device = "CMD_1"}), xml);
    EXPECT_TRUE(client.send(client.writer().finish()));
    const auto reply = client.next_of("STRING");
    if (!reply) throw std::runtime_error("no reply came");
    return std::string(*igtl::parse_string(reply->opened().content));
  }

 private:
  const std::string& token(Role role) const { return tokens_.at(static_cast<std::size_t>(role)); }

  TemporaryFolder folder_;
  std::vector<std::string> tokens_;
  std::unique_ptr<ServerFixture> server_;
};

TEST(LargeBody, IsRefusedBeforeItComesToAllButOperators) {
  ServerOfRoles server(Role::kViewer);
  const std::string still = "POST /api/archive";
  EXPECT_EQ(server.status_before_body(still, ""), 401);
  EXPECT_EQ(server.status_before_body(still, "Authorization: Bearer wrong\r\n"), 401);
  EXPECT_EQ(server.status_before_body(still, server.authorization(Role::kViewer)), 403);
  EXPECT_EQ(server.status_before_body(still, server.authorization(Role::kOperator)), 409)
      << "there is no queue";
  for (const char* other : {"PATCH /api/scene", "POST /api/cine", "GET /", "POST /api/archive/"})
    EXPECT_EQ(server.status_before_body(other, server.authorization(Role::kAdmin)), 413) << other;
}

TEST(CommandOfEachProtocol, IsRefusedByRoleAsTheTableSays) {
  for (const Role role : kRoles) {
    ServerOfRoles server(role);
    for (const Row& row : table()) {
      const std::string refusal = rule_of(row.command).role_refusal;
      const bool may = role >= row.least_role;
      const auto at = fmt::format("{} by {}", row.name, role_name(role));
      const bool is_survey = std::holds_alternative<FindSurface>(row.command);
      // The answer to an accepted survey comes when a renderer has looked: there is none here.
      if (row.message.body_case() != v1::ClientMessage::BODY_NOT_SET && !(is_survey && may)) {
        const bool refused = !refusal.empty() && server.stream(role, row.message) == refusal;
        EXPECT_EQ(refused, !may) << at << " at /stream";
      }
      if (!row.rest_method.empty()) {
        const std::string response = server.rest(role, row);
        EXPECT_EQ(response.starts_with("HTTP/1.1 403"), !may) << at << ": " << response;
        EXPECT_EQ(response.find(refusal) != std::string::npos, !may) << at << ": " << response;
        EXPECT_FALSE(response.starts_with("HTTP/1.1 40") && may && !response.starts_with("HTTP/1.1 409"))
            << response;
      }
      if (!row.xml.empty()) {
        const std::string reply = server.open_igtl_link(row.xml);
        EXPECT_EQ(reply.find("FAIL") != std::string::npos, !may) << at << ": " << reply;
      }
    }
  }
}

}  // namespace command_tests
}  // namespace fanlight::test
