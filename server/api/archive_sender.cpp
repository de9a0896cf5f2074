// SPDX-License-Identifier: Apache-2.0
#include "server/api/archive_sender.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

using boost::beast::http::status;
using nlohmann::json;

constexpr std::int64_t kMostWaitNs = 5'000'000'000;  // for the copy of a volume

/// Which volume such a body asks for; null: it has a picture. It may be 16 MB, most of them the picture's.
json wanted_volume(const std::string& body) {
  constexpr std::size_t kMostBytes = 65'536;
  if (body.size() > kMostBytes) return nullptr;
  const json read = json::parse(body, nullptr, false);
  if (!read.is_object() || !read.contains("volume")) return nullptr;
  return read["volume"].is_null() ? json(false) : read["volume"];
}

const char* name_of(ArchivedObject object) {
  switch (object) {
    case ArchivedObject::kStill:
      return "still";
    case ArchivedObject::kClip:
      return "clip";
    case ArchivedObject::kVolume:
      break;
  }
  return "volume";
}

}  // namespace

ArchiveSender::Permit ArchiveSender::admit() {
  if (*under_way_ == kMostRequests) return nullptr;
  ++*under_way_;
  return {this, [count = under_way_](void*) { --*count; }};
}

void ArchiveSender::send(std::string body, const Principal& principal, const Permit& permit,
                         const Answer& answer) {
  const std::uint64_t number = ++last_number_;
  Request& request =
      requests_
          .emplace(number,
                   Request{.principal = principal, .permit = permit, .answer = answer, .bytes = body.size()})
          .first->second;
  request.wanted = wanted_volume(body);
  if (request.wanted.is_null())
    return state_.archive->add(std::move(body),
                               [this, number](const auto& result) { added(number, result); });
  request.volume_body = std::move(body);
  send_volume(number, request);
}

void ArchiveSender::send_volume(std::uint64_t number, Request& request) {
  if (request.wanted != "shown" && !request.wanted.is_number_unsigned())
    return refuse(number, status::bad_request,
                  R"(volume is of another form, expected "shown" or the number of a volume)");
  if (const auto checked = state_.archive->check_volume_request(request.volume_body); !checked)
    return refuse(number, status::bad_request, checked.error().message);
  if (volume_ != 0)
    return refuse(number, status::service_unavailable,
                  "another volume is being written, expected a later request");
  std::shared_ptr<Volume> no_memory_yet;
  volume_ = number;
  request.until_ns = now_ns() + kMostWaitNs;
  const bool ordered =
      state_.volumes.copy(EncoderLane::kBackground, no_memory_yet,
                          [this, number](const VolumeCopier::Copy& copy) { copied(number, copy); });
  if (!ordered) refuse(number, status::service_unavailable, kRendererBusySentence);
}

void ArchiveSender::copied(std::uint64_t number, const VolumeCopier::Copy& copy) {
  using Outcome = VolumeCopier::Outcome;
  const auto found = requests_.find(number);
  if (found == requests_.end()) return;  // it came too late
  Request& request = found->second;
  request.until_ns = 0;
  const auto refused_for_now = [&](const char* sentence) {
    refuse(number, status::service_unavailable, sentence);
  };
  if (copy.outcome == Outcome::kNoVolume)
    return refused_for_now("there is no volume yet, expected a later request");
  if (copy.outcome == Outcome::kNoMemory)
    return refused_for_now("there is no memory for the volume, expected a later request");
  if (copy.outcome == Outcome::kBusy) return refused_for_now(kRendererBusySentence);
  const VolumeStamp& stamp = copy.volume->stamp();
  if (request.wanted.is_number() && request.wanted.get<std::uint64_t>() != stamp.volume_id)
    return refuse(number, status::conflict,
                  "another volume is shown by now, expected the one on show; freeze it first");
  // Without displays the renderer draws no frozen volume, and still has the one before.
  if (state_.cine.is_frozen() && state_.cine.volume_id() != stamp.volume_id)
    return refused_for_now("the frozen volume is not drawn yet, expected a display that shows it");
  const FrameOrigin origin = state_.frame_origin();
  const bool is_live = origin != FrameOrigin::kRecording;
  const std::int64_t age_s = (now_ns() - stamp.first_capture_time_ns) / 1'000'000'000;
  state_.archive->add_volume({.volume = copy.volume,
                              .acquired_utc_s = is_live ? utc_now_s() - age_s : 0,
                              .is_simulated = origin == FrameOrigin::kSimulated},
                             std::move(request.volume_body),
                             [this, number](const auto& result) { added(number, result); });
}

void ArchiveSender::added(std::uint64_t number, const Result<ArchivedObject>& result) {
  if (!requests_.contains(number)) return;  // abandoned
  ServerCounters& counters = state_.counters;
  if (!result && result.error().code != ErrorCode::kUnavailable)
    return refuse(number, status::bad_request, result.error().message);
  if (!result) {
    const std::string& sentence = result.error().message;
    counters.archive_failures.add();
    spdlog::error("an object could not be put into the queue for the archive: {}", sentence);
    return end(number, "failed: " + sentence, nullptr, refusal(status::service_unavailable, sentence));
  }
  (*result == ArchivedObject::kVolume ? counters.archive_volumes : counters.archive_stills).add();
  end(number, "done", name_of(*result), json_response(status::accepted, {{"taken", true}}));
}

void ArchiveSender::refuse(std::uint64_t number, status code, const std::string& sentence) {
  state_.counters.archive_refusals.add();
  end(number, "refused: " + sentence, nullptr, refusal(code, sentence));
}

void ArchiveSender::end(std::uint64_t number, const std::string& result, const char* object,
                        ApiResponse response) {
  auto ended = requests_.extract(number);
  const Request& request = ended.mapped();
  if (volume_ == number) volume_ = 0;
  nlohmann::ordered_json details = {{"bytes", request.bytes}};
  if (object != nullptr) details["object"] = object;
  audit_.note(request.principal, {.what = "archive", .result = result}, details);
  request.answer(std::move(response));
}

void ArchiveSender::end_late(std::int64_t now_ns) {
  const auto found = requests_.find(volume_);
  if (found == requests_.end() || found->second.until_ns == 0 || now_ns < found->second.until_ns) return;
  refuse(volume_, status::service_unavailable, "the renderer does not answer, expected a later request");
}

}  // namespace fanlight
