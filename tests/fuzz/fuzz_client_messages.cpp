// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "server/codec/stream_settings.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/require.hpp"

namespace fanlight::test {

namespace {

void check_change(const v1::Scene& change) {
  const Scene before;
  const SceneField* refused = nullptr;
  const auto scene = changed_scene(before, change, &refused);
  if (!scene) {
    v1::Error error;
    describe(error, scene.error(), refused);
    require(!error.message().empty(), "a refusal has a message");
    return;
  }
  require(check(*scene).has_value(), "an accepted scene is valid");
  const auto from_message = changed_scene(before, scene_message(*scene));
  require(from_message && first_pass_changed(*scene, *from_message) == FirstPass::kNone,
          "a scene is unchanged after conversion to a message and back");
  const auto through_json = scene_change_from_json(change_json(scene_message(*scene)));
  require(through_json.has_value(), "the JSON of a scene is accepted");
  const auto from_json = changed_scene(before, *through_json);
  require(from_json && first_pass_changed(*scene, *from_json) == FirstPass::kNone,
          "a scene is unchanged after conversion to JSON and back");
}

void check_stream(const v1::StreamRequest& request) {
  const auto settings = parse_stream_request(request, 85);
  if (!settings) return require(!settings.error().message.empty(), "a refusal has a message");
  const auto from_message = parse_stream_request(stream_message(*settings), 85);
  require(from_message && *from_message == *settings,
          "accepted settings are unchanged after conversion to a message and back");
}

}  // namespace

void fuzz_client_messages(std::span<const std::uint8_t> input) {
  v1::ClientMessage message;
  if (message.ParseFromArray(input.data(), static_cast<int>(input.size()))) {
    check_change(message.scene_change().scene());
    check_change(message.view().scene());
    check_stream(message.stream());
  }
  const auto json = nlohmann::json::parse(input.begin(), input.end(), nullptr, false);
  if (json.is_discarded()) return;
  const auto change = scene_change_from_json(json);
  if (change) return check_change(*change);
  require(!change.error().message.empty(), "a refusal has a message");
}

}  // namespace fanlight::test
