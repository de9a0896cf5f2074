// SPDX-License-Identifier: Apache-2.0
// The permissions of each role over the network, the holder of control, and the lines of the audit log about
// them.
#include <gtest/gtest.h>

#include "server/access/audit_log.hpp"
#include "tests/support/tls_server_fixture.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

/// The next message with this body. Skips others.
v1::ServerMessage next(StreamClient& client, v1::ServerMessage::BodyCase body) {
  for (;;) {
    auto message = client.next();
    if (!message) throw std::runtime_error(message.error().message);
    if (message->body_case() == body) return *message;
  }
}

v1::SceneReply change(StreamClient& client, double up_mm) {
  v1::ClientMessage message;
  message.mutable_scene_change()->set_request_id(1);
  message.mutable_scene_change()->mutable_scene()->mutable_light()->set_up_mm(up_mm);
  EXPECT_TRUE(client.send(message));
  return next(client, Body::kSceneReply).scene_reply();
}

v1::ControlReply wish(StreamClient& client, v1::ControlRequest::Wish wish, std::uint64_t to_session = 0) {
  v1::ClientMessage message;
  message.mutable_control()->set_request_id(5);
  message.mutable_control()->set_wish(wish);
  message.mutable_control()->set_to_session(to_session);
  EXPECT_TRUE(client.send(message));
  const auto reply = next(client, Body::kControlReply).control_reply();
  EXPECT_EQ(reply.request_id(), 5U);
  return reply;
}

TEST(Roles, AreThoseOfTheTokens) {
  TlsServerFixture guarded;
  for (const Role role : {Role::kViewer, Role::kOperator, Role::kAdmin}) {
    const auto client = guarded.come_in(role);
    EXPECT_EQ(client->hello().role(), static_cast<v1::Role>(role));
    EXPECT_EQ(client->hello().name(), guarded.token(role).entry.name);
    EXPECT_EQ(client->hello().protocol_version(), 2U);
  }
}

TEST(Roles, AViewerWatchesAndChangesNothing) {
  TlsServerFixture guarded;
  const auto viewer = guarded.come_in(Role::kViewer);
  guarded.fixture().show(3, 100);
  EXPECT_EQ(next(*viewer, Body::kPicture).picture().picture_id(), 3U);
  const auto reply = change(*viewer, 20);
  ASSERT_TRUE(reply.has_refused());
  EXPECT_NE(reply.refused().message().find("operator"), std::string::npos);
  EXPECT_FALSE(guarded.fixture().has_scene());
  EXPECT_TRUE(wish(*viewer, v1::ControlRequest::ASK).has_refused());
  EXPECT_TRUE(wish(*viewer, v1::ControlRequest::TAKE_OVER).has_refused());
  v1::ClientMessage probe;
  probe.mutable_probe_change()->mutable_settings()->set_sweep_deg(40);
  ASSERT_TRUE(viewer->send(probe));
  EXPECT_TRUE(next(*viewer, Body::kProbeReply).probe_reply().has_refused());
  const auto lines = guarded.audited("scene_change");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0]["who"], "viewer of the test");
  EXPECT_NE(std::string(lines[0]["result"]).find("refused"), std::string::npos);
}

TEST(Roles, OneOperatorIsInControlAtATime) {
  TlsServerFixture guarded;
  const auto first = guarded.come_in(Role::kOperator);
  const auto second = guarded.come_in(Role::kOperator);
  EXPECT_TRUE(change(*first, 20).has_in_force());
  const auto told = next(*second, Body::kControl).control();
  EXPECT_EQ(told.holder_session(), first->hello().session_id());
  EXPECT_FALSE(told.mine());
  const auto refused = change(*second, 30);
  ASSERT_TRUE(refused.has_refused());
  EXPECT_NE(refused.refused().message().find("in control"), std::string::npos);

  EXPECT_FALSE(wish(*second, v1::ControlRequest::ASK).state().mine());
  auto state = next(*first, Body::kControl).control();
  while (state.asking_size() == 0) state = next(*first, Body::kControl).control();
  EXPECT_EQ(state.asking(0).session(), second->hello().session_id());
  EXPECT_FALSE(wish(*first, v1::ControlRequest::GRANT, second->hello().session_id()).state().mine());
  EXPECT_TRUE(change(*second, 30).has_in_force());
  EXPECT_TRUE(change(*first, 40).has_refused());

  const auto admin = guarded.come_in(Role::kAdmin);
  EXPECT_TRUE(change(*admin, 50).has_refused()) << "an admin takes over by saying so";
  EXPECT_TRUE(wish(*admin, v1::ControlRequest::TAKE_OVER).state().mine());
  EXPECT_TRUE(change(*admin, 50).has_in_force());
  EXPECT_GE(guarded.audited("control", 3).size(), 3U);
}

TEST(Roles, TheControlLapsesAndGoesWithItsSession) {
  TlsServerFixture guarded(1500);
  auto first = guarded.come_in(Role::kOperator);
  const auto second = guarded.come_in(Role::kOperator);
  ASSERT_TRUE(change(*first, 20).has_in_force());
  while (next(*second, Body::kControl).control().holder_session() != 0) {
  }
  EXPECT_TRUE(change(*second, 30).has_in_force());
  while (next(*first, Body::kControl).control().holder_session() != second->hello().session_id()) {
  }
  ASSERT_FALSE(wish(*first, v1::ControlRequest::ASK).state().mine());
  first.reset();
  EXPECT_TRUE(change(*second, 40).has_in_force());
}

TEST(Roles, ATokenThatIsTakenBackClosesItsSessions) {
  TlsServerFixture guarded;
  const auto viewer = guarded.come_in(Role::kViewer);
  ASSERT_TRUE(remove_token(guarded.file("tokens.toml"), guarded.token(Role::kViewer).entry.id));
  for (;;) {
    const auto message = viewer->next();
    if (message) continue;
    EXPECT_NE(message.error().message.find("not valid any more"), std::string::npos)
        << message.error().message;
    break;
  }
  EXPECT_FALSE(StreamClient::connect(guarded.display(Role::kViewer)));
  EXPECT_EQ(guarded.audited("credentials_read").size(), 1U);
}

TEST(Roles, WrongTokensAreRefusedAuditedAndMadeToWait) {
  TlsServerFixture guarded;
  auto display = guarded.display(Role::kViewer);
  display.token.back() = display.token.back() == '0' ? '1' : '0';
  const auto wrong = StreamClient::connect(display);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("expected one that is known"), std::string::npos);
  const auto soon = StreamClient::connect(display);
  ASSERT_FALSE(soon);
  EXPECT_NE(soon.error().message.find("expected the next one in"), std::string::npos);
  EXPECT_TRUE(StreamClient::connect(guarded.display(Role::kViewer))) << "others may share the address";
  const auto lines = guarded.audited("login");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(std::string(lines[0]["result"]).find(display.token), std::string::npos);
  EXPECT_TRUE(verify_audit_log(guarded.file("audit.log")));
}

TEST(Roles, ALoginIsDueFirst) {
  TlsServerFixture guarded;
  auto display = guarded.display(Role::kViewer);
  display.token.clear();
  const auto none = StreamClient::connect(display);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("token"), std::string::npos);
}

TEST(Roles, TheAuditLogSaysWhoChangedWhat) {
  TlsServerFixture guarded;
  const auto one = guarded.come_in(Role::kOperator);
  for (int moved = 0; moved < 50; ++moved) ASSERT_TRUE(change(*one, moved).has_in_force());
  const auto lines = guarded.audited("scene_change");
  std::uint64_t changes = 0;
  for (const auto& line : lines) {
    EXPECT_EQ(line["session"], one->hello().session_id());
    changes += line["details"]["changes"].get<std::uint64_t>();
  }
  EXPECT_LE(lines.size(), 5U) << "a dragged light is a line a second";
  EXPECT_GT(changes, 0U);
}

}  // namespace
}  // namespace fanlight::test
