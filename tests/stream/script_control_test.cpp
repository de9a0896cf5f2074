// SPDX-License-Identifier: Apache-2.0
// Control that scripts ask for over REST: keys, their end, and what displays see of it.
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;
using Wish = v1::ControlRequest;

/// As talk(), with a control key.
Answer talk_with(const ServerFixture& fixture, const std::string& key, const std::string& method,
                 const std::string& target, const std::string& body = "") {
  return talk(fixture, method, target + " HTTP/1.1\r\nFanlight-Control: " + key + "\r\nX-Rest:", body);
}

json ask(const ServerFixture& fixture, const std::string& body = R"({"wish": "ask", "name": "one"})") {
  const Answer answer = talk(fixture, "POST", "/api/control", body);
  EXPECT_EQ(answer.status, 200) << answer.body;
  return json::parse(answer.body);
}

TEST(ScriptControl, IsSeenByDisplaysAndPassedOnByThem) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(5);
  ASSERT_TRUE(display.change(scene).has_in_force());
  const json asked = ask(fixture);
  EXPECT_FALSE(asked["mine"].get<bool>());
  EXPECT_TRUE(asked["waiting"].get<bool>());
  v1::ControlState state;
  do {
    state = display.next(v1::ServerMessage::kControl).control();
  } while (state.asking().empty());
  EXPECT_EQ(state.asking(0).name(), "one");
  v1::ClientMessage grant;
  grant.mutable_control()->set_wish(Wish::GRANT);
  grant.mutable_control()->set_to_session(state.asking(0).session());
  display.send(grant);
  do {
    state = display.next(v1::ServerMessage::kControl).control();
  } while (state.holder_name() != "one");
  const std::string key = asked["key"];
  EXPECT_EQ(talk_with(fixture, key, "PATCH", "/api/scene", R"({"light": {"up_mm": 9}})").status, 200);
  EXPECT_FALSE(display.change(scene).has_in_force()) << "a script is in control";
  EXPECT_EQ(talk_with(fixture, key, "POST", "/api/control", R"({"wish": "release"})").status, 200);
  EXPECT_TRUE(display.change(scene).has_in_force());
}

TEST(ScriptControl, EndsWhereTheKeyIsNotShown) {
  ServerFixture fixture(StreamServer::Config{.control_lapse_ms = 3000});
  const std::string kept = ask(fixture)["key"];
  const std::string waiting = ask(fixture)["key"];
  for (int i = 0; i < 9; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const json state = json::parse(talk_with(fixture, kept, "GET", "/api/control").body);
    EXPECT_TRUE(state["mine"].get<bool>()) << "a read with the key keeps it";
  }
  const json state = json::parse(talk(fixture, "GET", "/api/control").body);
  EXPECT_TRUE(state["asking"].empty()) << "the other one has not been heard of";
  EXPECT_EQ(talk_with(fixture, waiting, "GET", "/api/control").status, 409);
  for (int i = 0; i < 100 && !json::parse(talk(fixture, "GET", "/api/control").body)["holder"].is_null(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const Answer lapsed = talk_with(fixture, kept, "PATCH", "/api/scene", R"({"light": {"up_mm": 9}})");
  EXPECT_EQ(lapsed.status, 409) << "a script that believes to be in control must not change anything";
  EXPECT_EQ(json::parse(lapsed.body)["type"], "urn:fanlight:problem:control-lapsed");
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", R"({"light": {"up_mm": 9}})").status, 200);
}

TEST(ScriptControl, IsForAFewScriptsAtATime) {
  ServerFixture fixture;
  std::string last;
  for (std::size_t i = 0; i < ScriptSessions::kMost; ++i) last = ask(fixture)["key"];
  const Answer refused = talk(fixture, "POST", "/api/control", R"({"wish": "ask"})");
  EXPECT_EQ(refused.status, 503);
  EXPECT_NE(refused.head.find("Retry-After"), std::string::npos);
  EXPECT_EQ(talk_with(fixture, last, "POST", "/api/control", R"({"wish": "release"})").status, 200);
  ask(fixture);
  EXPECT_EQ(talk_with(fixture, "0123", "GET", "/api/control").status, 409) << "no such key";
}

}  // namespace
}  // namespace fanlight::test
