// SPDX-License-Identifier: Apache-2.0
// The REST API: the scene as JSON, read and changed, and the newest picture as a file.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

TEST(SceneJson, RoundTrips) {
  Scene scene;
  scene.light.up_mm = 17.25;
  scene.mode = Mode::kVolume;
  scene.filter.size = 9;
  const auto change = scene_change_from_json(json::parse(scene_json(scene).dump()));
  ASSERT_TRUE(change) << change.error().message;
  const auto back = changed_scene(Scene{}, *change);
  ASSERT_TRUE(back) << back.error().message;
  for (const SceneField& field : scene_fields()) EXPECT_TRUE(field.same(*back, scene)) << field.name;
}

TEST(RestApi, ReadsAndChangesTheScene) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  display.next(v1::ServerMessage::kHello);
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/scene").body)["revision"], 1);
  const Answer changed =
      talk(fixture, "PATCH", "/api/scene", R"({"light": {"up_mm": 21.5}, "mode": "volume"})");
  ASSERT_EQ(changed.status, 200) << changed.body;
  const json state = json::parse(changed.body);
  EXPECT_EQ(state["revision"], 2);
  EXPECT_EQ(state["scene"]["light"]["up_mm"], 21.5);
  EXPECT_EQ(state["scene"]["mode"], "volume");
  EXPECT_EQ(fixture.next_scene().scene.light.up_mm, 21.5);
  EXPECT_EQ(display.next(v1::ServerMessage::kScene).scene().revision(), 2U) << "the displays are notified";
}

TEST(RestApi, SavesGivesAndRemovesPresets) {
  ServerFixture fixture;
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/presets").body)["presets"].size(), 0U);
  const Answer saved =
      talk(fixture, "POST", "/api/presets",
           R"({"save": "mine", "scene": {"light": {"up_mm": 3}, "camera": {"yaw_deg": 9}}})");
  ASSERT_EQ(saved.status, 200) << saved.body;
  EXPECT_EQ(json::parse(saved.body)["presets"][0]["scene"], json::parse(R"({"light": {"up_mm": 3}})"));
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"save": "whole"})").status, 200) << "what is in force";
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"remove": "mine"})").status, 200);
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"remove": "mine"})").status, 404);
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"save": "bone"})").status, 400);
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"save": "x", "scene": {"no": 1}})").status, 422);
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", R"({"save": "x", "with": 1})").status, 400)
      << "an unknown key";
  EXPECT_EQ(talk(fixture, "POST", "/api/presets", "[]").status, 400);
  EXPECT_EQ(talk(fixture, "PUT", "/api/presets", "{}").status, 405);
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/presets").body)["presets"][0]["name"], "whole");
}

TEST(RestApi, NamesTheRefusedFieldAndItsRange) {
  ServerFixture fixture;
  const Answer range = talk(fixture, "PATCH", "/api/scene", R"({"light": {"up_mm": 1e9}})");
  EXPECT_EQ(range.status, 422);
  EXPECT_NE(range.head.find("application/problem+json"), std::string::npos);
  const json error = json::parse(range.body);
  EXPECT_EQ(error["type"], "urn:fanlight:problem:value-not-allowed");
  EXPECT_EQ(error["status"], 422);
  EXPECT_EQ(error["field"], "light.up_mm");
  EXPECT_EQ(error["maximum"], 2000);
  for (const char* body :
       {R"({"light": {"colour": 1}})", R"({"light": 5})", R"({"mode": "sideways"})", R"({"mode": 99})",
        R"([1, 2])", R"({"filter": {"size": -3}})", R"({"filter": {"size": 3.5}})",
        R"({"filter": {"size": 4294967299}})", R"({"filter": {"size": 1e300}})",
        R"({"transfer": {"points": 7}})", R"({"light": {"up_mm": "high"}})", R"({"light": {"up_mm": null}})",
        R"({"light": {"up_mm": {"up_mm": 3}}})", R"({"": {"": 1}})"}) {
    EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", body).status, 422) << body;
  }
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", "{").status, 400);
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", R"({"light": {"up_mm": 1e999}})").status, 400);
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", std::string(60'000, '[')).status, 400);
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", std::string(70'000, ' ')).status, 413);
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", "light.up_mm=3", "application/x-www-form-urlencoded").status,
            415);
  EXPECT_EQ(talk(fixture, "POST", "/api/scene", "{}").status, 405);
  EXPECT_EQ(talk(fixture, "PATCH", "/api/picture.png", "{}").status, 405);
  EXPECT_EQ(talk(fixture, "GET", "/api/nothing").status, 404);
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/scene").body)["revision"], 1) << "no change was applied";
}

TEST(RestApi, RefusesChangesWhileADisplayHoldsControl) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(5);
  ASSERT_TRUE(display.change(scene).has_in_force());
  EXPECT_EQ(talk(fixture, "PATCH", "/api/scene", R"({"light": {"up_mm": 21}})").status, 409);
}

TEST(RestApi, GivesTheNewestPicture) {
  ServerFixture fixture;
  EXPECT_EQ(talk(fixture, "GET", "/api/picture.png").status, 503);
  TestDisplay display(fixture.endpoint());
  fixture.show(5, 99);
  display.next(v1::ServerMessage::kPicture);
  const Answer picture = talk(fixture, "GET", "/api/picture.png");
  EXPECT_EQ(picture.status, 200);
  EXPECT_EQ(picture.body.substr(1, 3), "PNG");
  EXPECT_NE(picture.head.find("X-Fanlight-Picture-Id: 5"), std::string::npos);
  EXPECT_EQ(talk(fixture, "HEAD", "/api/picture.png").body, "");
}

TEST(RestApi, GivesTheSurfaceAsAPageThatNeedsNoServer) {
  ServerFixture fixture;
  EXPECT_EQ(talk(fixture, "GET", "/api/surface.html").status, 503) << "there is no picture";
  EXPECT_EQ(talk(fixture, "POST", "/api/surface.html", "{}").status, 405);
  TestDisplay display(fixture.endpoint());
  fixture.show(1, 99);
  display.next(v1::ServerMessage::kPicture);
  EXPECT_EQ(talk(fixture, "GET", "/api/surface.html").status, 409) << "the picture has no surface";
  fixture.show_depths(
      2, [](std::uint32_t column, std::uint32_t /*row*/) { return 40.F + static_cast<float>(column); });
  display.next(v1::ServerMessage::kPicture);
  const Answer page = talk(fixture, "GET", "/api/surface.html");
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.head.find("Content-Disposition: attachment"), std::string::npos);
  EXPECT_NE(page.body.find("Not for diagnosis"), std::string::npos);
  EXPECT_NE(page.body.find("id=\"surfaces\""), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test
