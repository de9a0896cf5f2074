// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/fault_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>

namespace fanlight::test {

namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kMostDurationMs = 86'400'000;  // a day

std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\n";
  std::vector<std::string_view> words;
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kSpaces), text.size()));
    if (text.empty()) return words;
    words.push_back(text.substr(0, text.find_first_of(kSpaces)));
    text.remove_prefix(words.back().size());
  }
}

std::optional<std::uint32_t> number_in(std::string_view text) {
  std::uint32_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<std::int64_t> duration_ns_in(std::string_view text) {
  std::int64_t in_ms = 0;
  if (text.ends_with("ms")) {
    in_ms = 1;
    text.remove_suffix(2);
  } else if (text.ends_with("s")) {
    in_ms = 1000;
    text.remove_suffix(1);
  }
  const auto number = number_in(text);
  if (in_ms == 0 || !number || *number * in_ms > kMostDurationMs) return std::nullopt;
  return *number * in_ms * kNsPerMs;
}

/// The fault at the front of `words`; nothing may follow it.
std::optional<Fault> fault_in(const std::vector<std::string_view>& words) {
  if (words.empty()) return std::nullopt;
  const auto known = fault_words();
  const auto found = std::ranges::find(known, words[0], &FaultWord::word);
  if (found == known.end()) return std::nullopt;
  const bool has_argument = found->argument != FaultWord::Argument::kNone;
  if (words.size() != (has_argument ? 2U : 1U)) return std::nullopt;
  Fault fault{.kind = found->kind};
  if (found->argument == FaultWord::Argument::kBytes) {
    const auto bytes = number_in(words[1]);
    if (!bytes) return std::nullopt;
    fault.bytes = *bytes;
  } else if (has_argument) {
    const auto duration_ns = duration_ns_in(words[1]);
    if (!duration_ns) return std::nullopt;
    fault.duration_ns = *duration_ns;
  }
  return fault;
}

std::string list_of_faults() {
  std::string list;
  for (const FaultWord& each : fault_words()) {
    list += fmt::format("{}{}", list.empty() ? "" : ", ", each.word);
    if (each.argument == FaultWord::Argument::kBytes) list += " BYTES";
    if (each.argument == FaultWord::Argument::kDuration) list += " DURATION";
  }
  return list;
}

Error not_understood(std::string_view part, std::string_view expected) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("the fault script says \"{}\", expected {}", part, expected)};
}

}  // namespace

Result<FaultScript::Part> FaultScript::parse_part(std::string_view text) {
  std::vector<std::string_view> words = words_of(text);
  Part part;
  const std::string_view first = words[0];
  const std::string_view second = words.size() > 1 ? words[1] : "";
  const auto duration_ns = duration_ns_in(second);
  const auto number = number_in(second);
  std::ptrdiff_t used = 2;
  bool understood = false;
  if (first == "at" || first == "after") {
    part.moment = first == "at" ? Moment::kAt : Moment::kAfter;
    understood = duration_ns.has_value();
  } else if (first == "frame") {
    part.moment = Moment::kFrame;
    understood = number.has_value();
  } else if (first == "every" && words.size() > 2 && words[2] == "frames") {
    part.moment = Moment::kEveryFrames;
    understood = number.value_or(0) > 0;
    used = 3;
  } else if (first == "every") {
    part.moment = Moment::kEveryDuration;
    understood = duration_ns.value_or(0) > 0;
  }
  if (!understood) {
    return not_understood(
        text, "a moment (at 2s, after 300ms, every 5s, frame 100 or every 50 frames) and then a fault");
  }
  part.duration_ns = duration_ns.value_or(0);
  part.frames = number.value_or(0);
  words.erase(words.begin(), words.begin() + used);
  const auto fault = fault_in(words);
  if (!fault) return not_understood(text, "one of these after the moment: " + list_of_faults());
  part.fault = *fault;
  return part;
}

Result<FaultScript> FaultScript::parse(std::string_view text) {
  FaultScript script;
  while (!text.empty()) {
    std::string_view part_text = text.substr(0, text.find(';'));
    text.remove_prefix(std::min(part_text.size() + 1, text.size()));
    const auto words = words_of(part_text);
    if (words.empty()) continue;
    // Without surrounding spaces, for the error message.
    part_text = {words.front().data(), words.back().data() + words.back().size()};
    if (script.repeats_) return not_understood(part_text, "nothing after \"repeat\"");
    if (part_text == "repeat") {
      script.repeats_ = true;
      continue;
    }
    auto part = parse_part(part_text);
    if (!part) return part.error();
    if (part->moment == Moment::kAfter && (script.parts_.empty() || script.parts_.back().recurs())) {
      return not_understood(part_text, "a part with \"at\", \"after\" or \"frame\" before an \"after\"");
    }
    script.parts_.push_back(*part);
  }
  const bool passes = std::ranges::any_of(
      script.parts_, [](const Part& part) { return !part.recurs() && part.duration_ns + part.frames > 0; });
  if (script.repeats_ && !passes) return not_understood("repeat", "parts before it that take time");
  return script;
}

void FaultScript::begin(std::int64_t now_ns) {
  began_ns_ = now_ns;
  round_ns_ = now_ns;
}

std::optional<std::int64_t> FaultScript::due_ns(std::size_t index) const {
  const Part& part = parts_[index];
  if (part.happened_ns && !part.recurs()) return std::nullopt;
  switch (part.moment) {
    case Moment::kAt:
      return round_ns_ + part.duration_ns;
    case Moment::kAfter: {
      const auto& before_ns = parts_[index - 1].happened_ns;
      return before_ns ? std::optional(*before_ns + part.duration_ns) : std::nullopt;
    }
    case Moment::kEveryDuration:
      return *began_ns_ + static_cast<std::int64_t>(part.times + 1) * part.duration_ns;
    case Moment::kFrame:
    case Moment::kEveryFrames:
      return std::nullopt;
  }
  return std::nullopt;
}

std::optional<std::int64_t> FaultScript::next_ns() const {
  std::optional<std::int64_t> next_ns;
  if (!began_ns_) return next_ns;
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    const auto part_ns = due_ns(part);
    if (part_ns && (!next_ns || *part_ns < *next_ns)) next_ns = part_ns;
  }
  return next_ns;
}

void FaultScript::happen(Part& part, std::int64_t at_ns, std::vector<Fault>& faults) {
  part.happened_ns = at_ns;
  ++part.times;
  faults.push_back(part.fault);
}

void FaultScript::begin_round_if_over() {
  if (!repeats_) return;
  std::int64_t last_ns = round_ns_;
  for (const Part& part : parts_) {
    if (part.recurs()) continue;
    if (!part.happened_ns) return;
    last_ns = std::max(last_ns, *part.happened_ns);
  }
  for (Part& part : parts_) {
    if (!part.recurs()) part.happened_ns.reset();
  }
  round_ns_ = last_ns;
  round_frame_ = last_frame_;
}

std::vector<Fault> FaultScript::due(std::int64_t now_ns) {
  std::vector<Fault> faults;
  for (auto next = next_ns(); next && *next <= now_ns; next = next_ns()) {
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      const auto part_ns = due_ns(part);
      if (part_ns && *part_ns <= *next) happen(parts_[part], *part_ns, faults);
    }
    begin_round_if_over();
  }
  return faults;
}

bool FaultScript::frame_has_come(const Part& part, std::uint64_t frame) const {
  if (part.moment == Moment::kFrame) return !part.happened_ns && frame >= round_frame_ + part.frames;
  return part.moment == Moment::kEveryFrames && frame >= (part.times + 1) * part.frames;
}

std::vector<Fault> FaultScript::before_frame(std::uint64_t frame, std::int64_t now_ns) {
  last_frame_ = frame;
  std::vector<Fault> faults;
  for (Part& part : parts_) {
    if (frame_has_come(part, frame)) happen(part, now_ns, faults);
  }
  begin_round_if_over();
  return faults;
}

}  // namespace fanlight::test
