#include <nlohmann/json.hpp>

#include "server/scene_json.hpp"
#include "server/scene_message.hpp"
#include "server/stream_settings.hpp"
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
    require(!error.message().empty(), "a refusal has a sentence");
    return;
  }
  require(check(*scene).has_value(), "what is taken is a scene that may be");
  const auto again = changed_scene(before, scene_message(*scene));
  require(again && first_pass_changed(*scene, *again) == FirstPass::kNone, "a scene goes there and back");
  const auto through_json = scene_change_from_json(change_json(scene_message(*scene)));
  require(through_json.has_value(), "a scene goes through JSON");
  const auto from_json = changed_scene(before, *through_json);
  require(from_json && first_pass_changed(*scene, *from_json) == FirstPass::kNone,
          "and comes out of it the same");
}

void check_stream(const v1::StreamRequest& request) {
  const auto settings = parse_stream_request(request, 85);
  if (!settings) return require(!settings.error().message.empty(), "a refusal has a sentence");
  const auto again = parse_stream_request(stream_message(*settings), 85);
  require(again && *again == *settings, "what is in force can be asked for");
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
  require(!change.error().message.empty(), "a refusal has a sentence");
}

}  // namespace fanlight::test
