// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/recorded_stream.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>
#include <string_view>
#include <utility>

#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kLargestNumber = std::uint64_t{1} << 48;

/// Reads header fields as long as all are there.
class Fields {
 public:
  explicit Fields(const std::map<std::string, std::string, std::less<>>& fields) : fields_(fields) {}

  std::string_view text(std::string_view name) {
    const auto found = fields_.find(name);
    if (found == fields_.end()) complete_ = false;
    return found == fields_.end() ? std::string_view() : std::string_view(found->second);
  }
  template <typename T>
  T number(std::string_view name) {
    const auto value = number_in<T>(text(name));
    if (!value) complete_ = false;
    return value.value_or(T{});
  }
  bool complete() const { return complete_; }

 private:
  const std::map<std::string, std::string, std::less<>>& fields_;
  bool complete_ = true;
};

/// "2026-11-22T17:25:00Z" in seconds since 1970; 0 for another text.
std::int64_t utc_of(std::string_view text) {
  std::tm time{};
  const std::string copy(text);
  const char* const end = strptime(copy.c_str(), "%Y-%m-%dT%H:%M:%SZ", &time);
  const std::int64_t seconds = end != nullptr && *end == '\0' ? timegm(&time) : 0;
  return seconds > 0 && time.tm_year < 8100 ? seconds : 0;
}

std::optional<RecordingFacts> facts_of(const FrameSequence& sequence) {
  auto facts = recording_facts(sequence.fanlight_fields);
  if (!facts) return std::nullopt;
  // Memory for a sweep: no sweep of this file is longer than all of it.
  const auto frames = static_cast<std::uint32_t>(sequence.frames.size());
  facts->frames_per_volume = std::min(facts->frames_per_volume, frames + 1);
  facts->usual_frames = std::min(facts->usual_frames, frames + 1);
  return facts;
}

std::optional<RecordedFrame> frame_of(const SequenceFrame& frame, bool counts_volumes) {
  const bool numbered = frame.volume_index && frame.frame_index && frame.direction;
  if (!frame.sequence || !frame.motor_angle_rad || (counts_volumes && !numbered)) return std::nullopt;
  // Sums of them with those of earlier passes stay far from the end of the numbers.
  if (*frame.sequence > kLargestNumber || frame.volume_index.value_or(0) > kLargestNumber)
    return std::nullopt;
  // A status that was changed by hand counts.
  const FrameFault unusable = frame.fault == FrameFault::kNone ? FrameFault::kInvalid : frame.fault;
  return RecordedFrame{.stamp = {.sequence = *frame.sequence,
                                 .volume_index = frame.volume_index.value_or(0),
                                 .frame_index = frame.frame_index.value_or(0),
                                 .frames_in_sweep = frame.frames_in_sweep.value_or(0),
                                 .direction = frame.direction.value_or(SweepDirection::kForward),
                                 .angle_rad = *frame.motor_angle_rad,
                                 .after_interruption = frame.after_interruption},
                       .fault = frame.valid ? FrameFault::kNone : unusable};
}

}  // namespace

std::optional<RecordingFacts> recording_facts(
    const std::map<std::string, std::string, std::less<>>& fanlight_fields) {
  Fields fields(fanlight_fields);
  const auto simulated = fanlight_fields.find("FanlightSimulated");
  const bool is_simulated = simulated != fanlight_fields.end() && simulated->second == "True";
  RecordingFacts facts{.source = std::string(fields.text("FanlightSource")),
                       .geometry = {},
                       .counts_volumes = fields.text("FanlightSweepsNumbered") == "True",
                       .frames_per_volume = fields.number<std::uint32_t>("FanlightFramesPerVolume"),
                       .usual_frames = fields.number<std::uint32_t>("FanlightUsualFrames"),
                       .simulated = is_simulated,
                       .first_angle_rad = fields.number<double>("FanlightSmallestAngleRad"),
                       .last_angle_rad = fields.number<double>("FanlightLargestAngleRad"),
                       .begun_utc_s = utc_of(fields.text("FanlightBegun"))};
  const auto usable = [](double angle_rad) { return std::abs(angle_rad) < kPi / 2; };
  if (!fields.complete() || !usable(facts.first_angle_rad) || !usable(facts.last_angle_rad))
    return std::nullopt;
  return facts;
}

std::optional<RecordedStream> recorded_stream(const FrameSequence& sequence) {
  auto facts = facts_of(sequence);
  if (!facts) return std::nullopt;
  RecordedStream stream{.facts = *std::move(facts), .frames = {}};
  stream.frames.reserve(sequence.frames.size());
  for (const SequenceFrame& each : sequence.frames) {
    const auto frame = frame_of(each, stream.facts.counts_volumes);
    if (!frame) return std::nullopt;
    stream.frames.push_back(*frame);
  }
  const auto sequence_of = [](const RecordedFrame& frame) { return frame.stamp.sequence; };
  const auto volume_of = [](const RecordedFrame& frame) { return frame.stamp.volume_index; };
  stream.smallest_sequence = std::ranges::min(stream.frames, {}, sequence_of).stamp.sequence;
  stream.smallest_volume_index = std::ranges::min(stream.frames, {}, volume_of).stamp.volume_index;
  return stream;
}

}  // namespace fanlight
