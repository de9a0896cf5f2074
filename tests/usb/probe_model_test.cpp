// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/probe_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "proto/base/crc32c.hpp"
#include "tests/support/milliseconds.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kStartNs = 50'000 * kMs;
constexpr std::int64_t kPeriodNs = 10 * kMs;  // at the 100 Hz of small_model()
constexpr std::uint32_t kFrames = 6;

using Config = ProbeModel::Config;

Config small_model() {
  return {.frame_rate_hz = 100, .frames_per_volume = kFrames, .columns = 32, .rows = 64, .room_frames = 1000};
}

std::unique_ptr<ProbeModel> made(const Config& config) {
  auto model = ProbeModel::create(config);
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

bool tell(ProbeModel& model, probe::Request request, std::int64_t now_ns) {
  return model.control_out(static_cast<std::uint8_t>(request), {}, now_ns);
}
bool tell(ProbeModel& model, probe::Request request, std::uint32_t value, std::int64_t now_ns) {
  std::vector<std::uint8_t> data;
  for (int byte = 0; byte < 4; ++byte) data.push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
  return model.control_out(static_cast<std::uint8_t>(request), data, now_ns);
}
std::unique_ptr<ProbeModel> started(const Config& config) {
  auto model = made(config);
  EXPECT_TRUE(tell(*model, probe::Request::kStart, kStartNs));
  return model;
}

/// The bytes of one transfer, and the header of the frame at its front, if any.
struct Transfer {
  std::vector<std::uint8_t> bytes;
  bool ended = false;
  probe::FrameHeader header;
  bool has_header = false;

  std::span<const std::uint8_t> pixels() const { return std::span(bytes).subspan(probe::kFrameHeaderBytes); }
  bool whole() const {
    return has_header && pixels().size() == header.payload_bytes && crc32c(pixels()) == header.payload_crc32c;
  }
};

Transfer transfer(ProbeModel& model, std::int64_t now_ns, std::size_t most_bytes = 65536) {
  Transfer made;
  made.bytes.resize(most_bytes);
  const auto filled = model.fill(made.bytes, now_ns);
  made.bytes.resize(filled.bytes);
  made.ended = filled.ended;
  std::size_t header_bytes = 0;
  made.has_header = read_header(made.bytes, made.header, header_bytes) == probe::HeaderCheck::kHeader;
  return made;
}

std::int64_t time_of(std::uint64_t frame) {
  return kStartNs + static_cast<std::int64_t>(frame) * kPeriodNs;
}

/// The transfers of all frames up to number `last`.
std::vector<Transfer> transfers_until(ProbeModel& model, std::uint64_t last) {
  std::vector<Transfer> all;
  for (;;) {
    Transfer next = transfer(model, time_of(last));
    if (next.bytes.empty()) return all;
    all.push_back(std::move(next));
  }
}

void expect_balance(const ProbeModel& model) {
  const auto& count = model.counters();
  EXPECT_EQ(count.frames_taken, count.frames_sent + count.frames_dropped + count.frames_withheld +
                                    count.frames_torn + model.waiting());
}

TEST(ProbeModelTest, AnswersWhoItIs) {
  const auto model = made(small_model());
  const auto ask = [&](probe::Request request) {
    return *model->control_in(static_cast<std::uint8_t>(request));
  };
  EXPECT_EQ(probe::decode_identity(ask(probe::Request::kIdentity))->serial, "0001");
  EXPECT_TRUE(probe::decode_capabilities(ask(probe::Request::kCapabilities))->counts_volumes);
  const auto settings = probe::decode_settings(ask(probe::Request::kSettings));
  EXPECT_EQ(settings->frames_a_volume, kFrames);
  EXPECT_EQ(settings->depth_mm, 160);
  const auto geometry = probe::decode_geometry(ask(probe::Request::kGeometry));
  ASSERT_TRUE(geometry) << geometry.error().message;
  EXPECT_EQ(geometry->fan.columns, 32U);
  EXPECT_EQ(geometry->fan.rows, 64U);
  EXPECT_FALSE(model->control_in(0x7F));
  EXPECT_FALSE(tell(*model, static_cast<probe::Request>(0x7F), 0));
}

TEST(ProbeModelTest, SendsNothingBeforeTheStartAndAfterTheStop) {
  const auto model = made(small_model());
  EXPECT_TRUE(transfer(*model, kStartNs).bytes.empty());
  EXPECT_FALSE(model->ready_at_ns());
  tell(*model, probe::Request::kStart, kStartNs);
  EXPECT_EQ(model->ready_at_ns(), kStartNs);
  EXPECT_TRUE(transfer(*model, kStartNs).whole());
  EXPECT_TRUE(transfer(*model, kStartNs).bytes.empty()) << "not due yet";
  EXPECT_EQ(model->ready_at_ns(), kStartNs + kPeriodNs);
  tell(*model, probe::Request::kStop, kStartNs);
  EXPECT_TRUE(transfer(*model, kStartNs + 10 * kPeriodNs).bytes.empty());
  expect_balance(*model);
}

TEST(ProbeModelTest, FramesFollowTheMotorToAndFro) {
  auto config = small_model();
  config.lag_deg = 1;
  const auto model = started(config);
  const auto frames = transfers_until(*model, 3 * kFrames - 1);
  ASSERT_EQ(frames.size(), 3 * kFrames);
  for (std::uint32_t i = 0; i < frames.size(); ++i) {
    const probe::FrameHeader& header = frames[i].header;
    EXPECT_TRUE(frames[i].whole());
    EXPECT_EQ(header.sequence, i);
    EXPECT_EQ(header.volume_index, i / kFrames);
    EXPECT_EQ(header.frame_index, i % kFrames);
    EXPECT_EQ(header.frames_in_sweep, kFrames);
    const bool forward = i / kFrames % 2 == 0;
    EXPECT_EQ(header.direction, forward ? SweepDirection::kForward : SweepDirection::kBackward);
    const double along = forward ? i % kFrames : kFrames - 1 - i % kFrames;
    EXPECT_NEAR(header.angle_deg, -35 + along * 70 / (kFrames - 1) + (forward ? -0.5 : 0.5), 1e-5);
    EXPECT_EQ(header.device_time_ns - frames[0].header.device_time_ns, i * std::uint64_t{kPeriodNs});
  }
  EXPECT_NE(frames[0].header.payload_crc32c, frames[kFrames].header.payload_crc32c);
}

TEST(ProbeModelTest, WithoutAVolumeIndexFramesHaveOnlyTheirAngle) {
  auto config = small_model();
  config.counts_volumes = false;
  const auto model = started(config);
  for (const Transfer& frame : transfers_until(*model, 2 * kFrames)) {
    EXPECT_EQ(frame.header.volume_index, 0U);
    EXPECT_EQ(frame.header.frames_in_sweep, 0U);
  }
}

TEST(ProbeModelTest, AFrameEndsItsTransferAndFillsThoseBefore) {
  const auto model = started(small_model());
  constexpr std::size_t kBytes = probe::kFrameHeaderBytes + 32 * 64;  // 2112: four packets and 64 bytes
  const Transfer first = transfer(*model, kStartNs, 1024);
  EXPECT_EQ(first.bytes.size(), 1024U);
  EXPECT_FALSE(first.ended);
  EXPECT_EQ(transfer(*model, kStartNs, 1024).bytes.size(), 1024U);
  const Transfer last = transfer(*model, kStartNs, 1024);
  EXPECT_EQ(last.bytes.size(), kBytes - 2048);
  EXPECT_TRUE(last.ended);
}

TEST(ProbeModelTest, AFullLastPacketIsFollowedByAnEmptyOne) {
  auto config = small_model();
  config.rows = 62;  // 64 + 32 x 62 bytes are four packets
  const auto model = started(config);
  const Transfer full = transfer(*model, kStartNs, 2048);
  EXPECT_EQ(full.bytes.size(), 2048U);
  EXPECT_FALSE(full.ended);
  const Transfer empty = transfer(*model, kStartNs, 2048);
  EXPECT_TRUE(empty.bytes.empty());
  EXPECT_TRUE(empty.ended);
  EXPECT_TRUE(transfer(*model, time_of(1), 4096).ended) << "with room left the empty packet ends it at once";
}

TEST(ProbeModelTest, KeepsAFewFramesAndDropsTheOldest) {
  auto config = small_model();
  config.room_frames = 3;
  const auto model = started(config);
  const auto frames = transfers_until(*model, 9);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].header.sequence, 7U);
  EXPECT_EQ(model->counters().frames_dropped, 7U);
  EXPECT_EQ(model->counters().frames_taken, 10U);
  expect_balance(*model);
}

TEST(ProbeModelTest, FaultsOfAFrame) {
  const auto model = started(small_model());
  const auto with = [&](const Fault& fault, std::uint64_t frame) {
    model->inject(fault, time_of(frame) - 1);
    return transfer(*model, time_of(frame));
  };
  EXPECT_TRUE(transfer(*model, time_of(0)).whole());
  const Transfer damaged = with({.kind = FaultKind::kDamage}, 1);
  EXPECT_TRUE(damaged.has_header);
  EXPECT_FALSE(damaged.whole());
  EXPECT_FALSE(with({.kind = FaultKind::kDamageHeader}, 2).has_header);
  const Transfer cut = with({.kind = FaultKind::kCut}, 3);
  EXPECT_EQ(cut.pixels().size(), 32U * 64U / 2);
  EXPECT_TRUE(cut.ended);
  const Transfer invalid = with({.kind = FaultKind::kInvalid}, 4);
  EXPECT_TRUE(invalid.header.invalid && invalid.whole());
  const Transfer noisy = with({.kind = FaultKind::kNoise, .bytes = 100}, 5);
  EXPECT_EQ(noisy.bytes.size(), 100 + probe::kFrameHeaderBytes + 32 * 64);
  EXPECT_FALSE(noisy.has_header);
  EXPECT_TRUE(with({.kind = FaultKind::kDrop}, 6).bytes.empty());
  EXPECT_EQ(with({.kind = FaultKind::kRepeat}, 7).header.sequence, 7U);
  EXPECT_EQ(transfer(*model, time_of(7)).header.sequence, 7U);
  EXPECT_TRUE(with({.kind = FaultKind::kSwap}, 8).bytes.empty());
  EXPECT_EQ(transfer(*model, time_of(9)).header.sequence, 9U);
  const Transfer swapped = transfer(*model, time_of(9));
  EXPECT_EQ(swapped.header.sequence, 8U);
  EXPECT_TRUE(swapped.whole());
  const auto& count = model->counters();
  EXPECT_EQ(count.frames_taken, 10U);
  EXPECT_EQ(count.frames_sent, 8U);
  EXPECT_EQ(count.frames_torn, 1U);
  EXPECT_EQ(count.frames_withheld, 1U);
  EXPECT_EQ(count.repeats, 1U);
  expect_balance(*model);
}

TEST(ProbeModelTest, FaultsOfTheStream) {
  const auto model = started(small_model());
  transfers_until(*model, 2);
  model->inject({.kind = FaultKind::kSilent, .duration_ns = 3 * kPeriodNs}, time_of(2));
  EXPECT_TRUE(transfers_until(*model, 4).empty());
  EXPECT_EQ(model->ready_at_ns(), time_of(5));
  EXPECT_EQ(transfers_until(*model, 5).size(), 3U);
  model->inject({.kind = FaultKind::kRestart}, time_of(5));
  const auto again = transfers_until(*model, 6);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].header.sequence, 0U);
  EXPECT_EQ(again[0].header.frame_index, 0U);
  model->inject({.kind = FaultKind::kRandom}, time_of(6));
  const Transfer random = transfer(*model, time_of(8));
  EXPECT_FALSE(random.has_header);
  EXPECT_FALSE(random.ended);
  expect_balance(*model);
}

TEST(ProbeModelTest, ALostTransferTearsItsFrame) {
  const auto model = started(small_model());
  transfer(*model, time_of(0));  // whole
  model->lose_last_fill();
  transfer(*model, time_of(1), 512);  // begun
  model->lose_last_fill();
  EXPECT_EQ(transfer(*model, time_of(1)).bytes.size(), probe::kFrameHeaderBytes + 32 * 64 - 512);
  transfer(*model, time_of(2), 512);
  model->tear();
  EXPECT_EQ(model->counters().frames_torn, 3U);
  EXPECT_EQ(model->counters().frames_sent, 0U);
  expect_balance(*model);
}

TEST(ProbeModelTest, SettingsComeWithTheNextSweep) {
  const auto model = started(small_model());
  transfers_until(*model, 2);
  EXPECT_TRUE(tell(*model, probe::Request::kSetSweep, 40'000'000, time_of(2)));
  EXPECT_TRUE(tell(*model, probe::Request::kSetFrames, 3, time_of(2)));
  EXPECT_TRUE(tell(*model, probe::Request::kSetDepth, 81'000, time_of(2)));
  const auto settings = probe::decode_settings(*model->control_in(0x04));
  EXPECT_EQ(settings->depth_mm, 80) << "rounded to rows of 2.5 mm";
  EXPECT_EQ(model->geometry().revision, 1U);
  const auto frames = transfers_until(*model, 8);
  ASSERT_EQ(frames.size(), 6U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].header.geometry_revision, 1U);
    const probe::FrameHeader& after = frames[3 + i].header;
    EXPECT_EQ(after.geometry_revision, 2U);
    EXPECT_EQ(after.payload_bytes, 32U * 32U);
    EXPECT_EQ(after.volume_index, 1U);
    EXPECT_EQ(after.frames_in_sweep, 3U);
    EXPECT_EQ(after.direction, SweepDirection::kBackward);
    EXPECT_NEAR(after.angle_deg, 20 - 20.0 * static_cast<double>(i), 1e-6);
    EXPECT_TRUE(frames[3 + i].whole());
  }
  EXPECT_EQ(model->geometry().revision, 2U);
  EXPECT_EQ(model->geometry().fan.rows, 32U);
}

TEST(ProbeModelTest, RefusesSettingsOutOfRange) {
  const auto model = made(small_model());
  EXPECT_FALSE(tell(*model, probe::Request::kSetSweep, 180'000'000, 0));
  EXPECT_FALSE(tell(*model, probe::Request::kSetFrames, 1, 0));
  EXPECT_FALSE(tell(*model, probe::Request::kSetDepth, 200'000, 0));
  EXPECT_EQ(probe::decode_settings(*model->control_in(0x04))->frames_a_volume, kFrames);
}

TEST(ProbeModelTest, TheDepthChangesByItselfInMidSweep) {
  const auto model = started(small_model());
  transfers_until(*model, 1);
  model->inject({.kind = FaultKind::kGeometry}, time_of(1));
  const auto frames = transfers_until(*model, 3 * kFrames);
  EXPECT_EQ(frames[0].header.frame_index, 2U);
  for (const Transfer& frame : frames) EXPECT_EQ(frame.header.payload_bytes, 32U * 48U);
}

TEST(ProbeModelTest, AnUnplugForgetsAllButTheCounters) {
  const auto model = started(small_model());
  tell(*model, probe::Request::kSetFrames, 3, kStartNs);
  transfer(*model, time_of(3), 512);
  model->unplugged();
  EXPECT_FALSE(model->streaming());
  EXPECT_EQ(model->counters().frames_torn, 1U);
  EXPECT_EQ(model->counters().frames_dropped, 3U);
  EXPECT_EQ(probe::decode_settings(*model->control_in(0x04))->frames_a_volume, kFrames);
  tell(*model, probe::Request::kStart, time_of(9));
  const Transfer first = transfer(*model, time_of(9));
  EXPECT_EQ(first.header.sequence, 0U);
  EXPECT_TRUE(first.whole());
  expect_balance(*model);
}

TEST(ProbeModelTest, PreparedPicturesComeAgainAndAgain) {
  auto config = small_model();
  config.prepared = true;
  const auto model = started(config);
  const auto frames = transfers_until(*model, 5 * kFrames - 1);
  ASSERT_EQ(frames.size(), 5 * kFrames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(frames[i].whole());
    EXPECT_EQ(frames[i].header.payload_crc32c, frames[i % (2 * kFrames)].header.payload_crc32c);
    EXPECT_EQ(frames[i].header.sequence, i);
  }
  EXPECT_TRUE(tell(*model, probe::Request::kSetFrames, 3, time_of(5 * kFrames)));
  for (const Transfer& frame : transfers_until(*model, 9 * kFrames)) EXPECT_TRUE(frame.whole());
}

TEST(ProbeModelTest, OneThatDoesNotEndItsTransfersFillsThem) {
  auto config = small_model();
  config.ends_transfers = false;
  const auto model = started(config);
  const Transfer full = transfer(*model, time_of(9), 4096);
  EXPECT_EQ(full.bytes.size(), 4096U);
  EXPECT_FALSE(full.ended);
}

TEST(ProbeModelTest, RefusesWhatCannotBe) {
  for (auto change :
       {+[](Config& config) { config.frame_rate_hz = 0; }, +[](Config& config) { config.columns = 1; },
        +[](Config& config) { config.lag_deg = std::nan(""); },
        +[](Config& config) { config.depth_mm = 500; }}) {
    auto config = small_model();
    change(config);
    const auto model = ProbeModel::create(config);
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace fanlight::test
