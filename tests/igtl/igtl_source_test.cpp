// SPDX-License-Identifier: Apache-2.0
// The source, with a scanner that the test plays.
#include "acquisition/igtl/igtl_source.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "proto/base/clock.hpp"
#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "tests/igtl/igtl_source_rig.hpp"

namespace fanlight::test {
namespace igtl_source_tests {

TEST(IgtlSource, GivesTheFramesOfAFanlightFromTheFirstOne) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))})) << rig.error.message;
  EXPECT_EQ(rig.source->description().geometry, facts().geometry);
  EXPECT_EQ(rig.source->description().name, "igtl:" + rig.scanner.place());
  for (std::uint32_t i = 1; i < 45; ++i) ASSERT_TRUE(rig.scanner.send(message_of(of_fanlight(i))));
  const auto frames = rig.next(45);
  ASSERT_EQ(frames.size(), 45U);
  for (std::uint32_t i = 0; i < 45; ++i) {
    const FrameStamp& stamp = frames[i].stamp;
    EXPECT_EQ(frames[i].fault, FrameFault::kNone);
    EXPECT_EQ(stamp.sequence, i);
    EXPECT_EQ(stamp.volume_index, i / kFrames);
    EXPECT_EQ(stamp.frame_index, i % kFrames);
    EXPECT_EQ(stamp.frames_in_sweep, kFrames);
    EXPECT_EQ(stamp.angle_rad, radians(angle_deg(i, kFrames))) << "every bit";
    EXPECT_EQ(frames[i].pixels, Bytes(kColumns * kRows, static_cast<std::uint8_t>(i)));
    EXPECT_LE(stamp.capture_time_ns, now_ns());
    if (i > 0) {
      EXPECT_GE(stamp.capture_time_ns, frames[i - 1].stamp.capture_time_ns);
    }
  }
  EXPECT_EQ(rig.counters().messages_used.value(), 45U);
  EXPECT_TRUE(rig.sum_holds());
}

TEST(IgtlSource, AsksForImagesAndPoses) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}, ",transform=ProbeToTracker"));
  const Bytes received = rig.scanner.received();
  ASSERT_GE(received.size(), 58U + 58 + 36);
  const auto first = igtl::parse_head(std::span(received).first<igtl::kHeadBytes>());
  ASSERT_TRUE(first);
  EXPECT_EQ(first->type.view(), "STT_IMAGE");
  EXPECT_EQ(first->version, 1U) << "old programs lose their place at version 2";
  const auto second =
      igtl::parse_head(std::span(received).subspan(58 + first->body_bytes).first<igtl::kHeadBytes>());
  ASSERT_TRUE(second);
  EXPECT_EQ(second->type.view(), "STT_TDATA");
  EXPECT_EQ(second->device.view(), "ProbeToTracker");
  // The image was of version 2.
  const std::size_t at = 2 * 58 + first->body_bytes + second->body_bytes;
  ASSERT_GE(received.size(), at + 58);
  const auto third = igtl::parse_head(std::span(received).subspan(at).first<igtl::kHeadBytes>());
  ASSERT_TRUE(third);
  EXPECT_EQ(third->type.view(), "STT_IMAGE");
  EXPECT_EQ(third->version, 2U);
}

TEST(IgtlSource, PlacesImagesByTransformsThatComeBeforeOrAfterThem) {
  Rig rig;
  std::vector<Bytes> first;
  const auto add = [](std::vector<Bytes>& messages, std::uint32_t i) {
    if (i % 2 == 0) messages.push_back(transform_of_plus(i));
    messages.push_back(message_of(of_plus(i)));
    if (i % 2 == 1) messages.push_back(transform_of_plus(i));
  };
  for (std::uint32_t i = 0; i < 64; ++i) add(first, i);
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  std::vector<Bytes> more;
  for (std::uint32_t i = 64; i < 104; ++i) add(more, i);
  for (const Bytes& message : more) ASSERT_TRUE(rig.scanner.send(message));
  const auto frames = rig.next(40);
  ASSERT_EQ(frames.size(), 40U);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].fault, FrameFault::kNone);
    EXPECT_EQ(frames[i].stamp.sequence, frames[i - 1].stamp.sequence + 1);
  }
  // The image that was learned last is the first frame: 63 or another with index % 16 = 15.
  const auto index = static_cast<std::uint32_t>(104 - 40);
  std::size_t agreeing = 0;
  for (const Frame& frame : frames) {
    for (std::uint32_t at = index - 20; at < 104; ++at)
      if (std::abs(degrees(frame.stamp.angle_rad) - angle_deg(at, kFrames)) < 0.01) {
        ++agreeing;
        break;
      }
  }
  EXPECT_EQ(agreeing, 40U);
  EXPECT_EQ(rig.counters().images_not_placed.value(), 0U);
}

TEST(IgtlSource, CountsImagesForWhichNoPoseCame) {
  Rig rig;
  std::vector<Bytes> first;
  for (std::uint32_t i = 0; i < 48; ++i) {
    first.push_back(transform_of_plus(i));
    first.push_back(message_of(of_plus(i)));
  }
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  (void)rig.next(1);
  // 200 ms later, without transforms: the second image shows that none will come for the first.
  for (std::uint32_t i = 53; i < 56; ++i) ASSERT_TRUE(rig.scanner.send(message_of(of_plus(i))));
  const auto frames = rig.next(2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].fault, FrameFault::kInvalid);
  EXPECT_GE(rig.counters().images_not_placed.value(), 1U);
}

TEST(IgtlSource, UsesTheNearestPoseOfASlowTracker) {
  Rig rig;
  std::vector<Bytes> first;
  // 25 images a second, and a pose with every second one.
  for (std::uint32_t i = 0; i < 65; ++i) {
    if (i % 2 == 0) first.push_back(transform_of_plus(i));
    first.push_back(message_of(of_plus(i)));
  }
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  for (std::uint32_t i = 65; i < 85; ++i) {
    if (i % 2 == 0) {
      ASSERT_TRUE(rig.scanner.send(transform_of_plus(i)));
    }
    ASSERT_TRUE(rig.scanner.send(message_of(of_plus(i))));
  }
  for (const Frame& frame : rig.next(15)) EXPECT_EQ(frame.fault, FrameFault::kNone);
  EXPECT_EQ(rig.counters().images_not_placed.value(), 0U);
}

TEST(IgtlSource, UsesNoPoseThatItsTrackerCallsMissing) {
  igtl::MessageWriter writer;
  const auto with_status = [&writer](std::uint32_t index, std::string_view status) {
    const std::pair<std::string_view, std::string_view> items[] = {{"TransformStatus", status}};
    igtl::put_transform(writer.begin({.type = "TRANSFORM",
                                      .device = "ProbeToTracker",
                                      .timestamp = igtl::timestamp_of((kBeganMs + 40 * index) * 1'000'000),
                                      .version = igtl::HeadVersion::kTwo,
                                      .metadata = items}),
                        {.first_mm = {500, 0, 0}});  // nowhere
    const auto message = writer.finish();
    return Bytes(message.begin(), message.end());
  };
  Rig rig;
  std::vector<Bytes> first;
  for (std::uint32_t i = 0; i < 64; ++i) {
    first.push_back(transform_of_plus(i));
    if (i % 8 == 3) first.push_back(with_status(i, "OUT_OF_VIEW"));
    first.push_back(message_of(of_plus(i)));
  }
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  ASSERT_EQ(rig.next(1).size(), 1U);
  EXPECT_TRUE(std::ranges::any_of(rig.source->description().notes, [](const std::string& note) {
    return note.find("misses by 0.00 mm") != std::string::npos;
  }));
}

TEST(IgtlSource, ADamagedMessageIsThatFrameAlone) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
  Bytes damaged = message_of(of_fanlight(1));
  damaged[200] ^= 1;
  ASSERT_TRUE(rig.scanner.send(damaged));
  ASSERT_TRUE(rig.scanner.send(message_of(of_fanlight(2))));
  const auto frames = rig.next(3);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[1].fault, FrameFault::kDamaged);
  EXPECT_EQ(frames[1].stamp.sequence, 1U);
  EXPECT_EQ(frames[2].stamp.sequence, 2U);
  EXPECT_EQ(frames[2].fault, FrameFault::kNone);
  EXPECT_EQ(rig.counters().messages_damaged.value(), 1U);
  EXPECT_TRUE(rig.sum_holds());
  // Another device's damage is no frame of ours.
  SentImage other = of_fanlight(3);
  other.device = "Other_Reference";
  damaged = message_of(other);
  damaged[200] ^= 1;
  ASSERT_TRUE(rig.scanner.send(damaged));
  ASSERT_TRUE(rig.scanner.send(message_of(of_fanlight(3))));
  const auto next = rig.next(1);
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].fault, FrameFault::kNone);
  EXPECT_EQ(next[0].stamp.sequence, 3U);
}

TEST(RisingNumber, GoesOnWhereASenderCountsAnew) {
  RisingNumber numbers(64);
  EXPECT_EQ(numbers.continued(500, true), 0U) << "what came before was sent to others";
  EXPECT_EQ(numbers.continued(501, false), 1U);
  EXPECT_EQ(numbers.continued(503, false), 3U) << "one is missing";
  EXPECT_EQ(numbers.continued(502, false), 2U) << "it came out of order";
  EXPECT_EQ(numbers.continued(504, false), 4U);
  EXPECT_EQ(numbers.continued(0, false), 5U) << "it counts again";
  EXPECT_EQ(numbers.continued(1, false), 6U);
  EXPECT_EQ(numbers.continued(0, true), 7U) << "on a new connection it may do so at once";
  EXPECT_EQ(numbers.continued(9, true), 16U) << "or continue";
  EXPECT_LE(numbers.continued(~std::uint64_t{0}, false), RisingNumber::kMost + 16);
}

TEST(IgtlSource, ConnectsAgainAndGoesOn) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0)), message_of(of_fanlight(1))}));
  ASSERT_EQ(rig.next(2).size(), 2U);
  rig.scanner.hang_up();
  std::thread again([&] {
    EXPECT_TRUE(rig.scanner.accept());
    // The scanner counts again.
    EXPECT_TRUE(rig.scanner.send(message_of(of_fanlight(0))));
  });
  const auto frames = rig.next(1);
  again.join();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].stamp.after_interruption);
  EXPECT_GT(frames[0].stamp.sequence, 1U);
  EXPECT_EQ(rig.counters().connections_lost.value(), 1U);
  EXPECT_EQ(rig.counters().connections_made.value(), 2U);
  EXPECT_EQ(rig.status().state, ProbeStatus::State::kAbsent);
}

TEST(IgtlSource, ConnectsAgainWhereTheBytesAreNoMessage) {
  for (const bool lies : {false, true}) {
    Rig rig;
    ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
    ASSERT_EQ(rig.next(1).size(), 1U);
    Bytes wrong(58, 0x41);
    if (lies) {
      wrong = message_of(of_fanlight(1));
      wrong[42] = 0x70;  // a length of 2^62
    }
    ASSERT_TRUE(rig.scanner.send(wrong));
    std::thread again([&] {
      EXPECT_TRUE(rig.scanner.accept());
      EXPECT_TRUE(rig.scanner.send(message_of(of_fanlight(2))));
    });
    EXPECT_EQ(rig.next(1).size(), 1U);
    again.join();
    EXPECT_EQ(rig.counters().places_lost.value(), 1U);
  }
}

TEST(IgtlSource, GivesAScannerUpThatIsSilent) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}, "", {.silence_s = 0.3}));
  ASSERT_EQ(rig.next(1).size(), 1U);
  Bytes half = message_of(of_fanlight(1));
  half.resize(half.size() / 2);
  ASSERT_TRUE(rig.scanner.send(half));
  std::thread again([&] {
    EXPECT_TRUE(rig.scanner.accept());
    EXPECT_TRUE(rig.scanner.send(message_of(of_fanlight(2))));
  });
  EXPECT_EQ(rig.next(1).size(), 1U);
  again.join();
  EXPECT_EQ(rig.counters().silences.value(), 1U);
}

TEST(IgtlSource, ReadsSlowBytes) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
  std::thread slow([&] {
    const Bytes message = message_of(of_fanlight(1));
    for (std::size_t at = 0; at < message.size(); at += 10) {
      const std::size_t end = std::min(message.size(), at + 10);
      EXPECT_TRUE(rig.scanner.send(std::span(message).subspan(at, end - at)));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  EXPECT_EQ(rig.next(2).size(), 2U);
  slow.join();
}

TEST(IgtlSource, PutsSubVolumesTogether) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
  const SentImage sent = of_fanlight(1);
  igtl::ImageBody body = body_of(sent);
  body.part_size = {kColumns, 6, 1};
  ASSERT_TRUE(rig.scanner.send(message_of(sent, body, Bytes(body.part_bytes(), 5))));
  body.part_offset = {0, 6, 0};
  ASSERT_TRUE(rig.scanner.send(message_of(sent, body, Bytes(body.part_bytes(), 9))));
  const auto frames = rig.next(2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].pixels[0], 5);
  EXPECT_EQ(frames[1].pixels.back(), 9);
  EXPECT_EQ(frames[1].stamp.sequence, 1U);
  body.part_offset = {0, 3, 0};
  ASSERT_TRUE(rig.scanner.send(message_of(sent, body, Bytes(body.part_bytes(), 9))));
  ASSERT_TRUE(rig.scanner.send(message_of(of_fanlight(2))));
  EXPECT_EQ(rig.next(1).size(), 1U);
  EXPECT_EQ(rig.counters().images_cut.value(), 1U);
}

TEST(IgtlSource, ShowsPixelsOf16BitThroughAWindow) {
  Rig rig;
  std::vector<Bytes> first;
  for (std::uint32_t i = 0; i < 64; ++i) {
    SentImage sent;
    sent.pose = SentFan{}.pose(angle_deg(i, kFrames));
    igtl::ImageBody body = body_of(sent);
    body.scalar = igtl::ScalarType::kUint16;
    body.big_endian = true;
    Bytes pixels(body.part_bytes());
    for (std::size_t at = 0; at < pixels.size() / 2; ++at) {
      const auto value = static_cast<std::uint16_t>(at % 2 == 0 ? 1000 : 3000);
      pixels[2 * at] = static_cast<std::uint8_t>(value >> 8);
      pixels[2 * at + 1] = static_cast<std::uint8_t>(value);
    }
    first.push_back(message_of(sent, body, pixels));
  }
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  const auto frames = rig.next(1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].pixels[0], 0);
  EXPECT_EQ(frames[0].pixels[1], 255);
  EXPECT_TRUE(std::ranges::any_of(rig.source->description().notes, [](const std::string& note) {
    return note.find("values from 1000 to 3000") != std::string::npos;
  }));
}

TEST(IgtlSource, LearnsAgainWhereThePixelsChange) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
  ASSERT_EQ(rig.next(1).size(), 1U);
  SentImage deeper = of_fanlight(1);
  for (auto& [name, value] : deeper.metadata)
    if (name == "FanlightPixelHeightMm") value = "0.75";
  ASSERT_TRUE(rig.scanner.send(message_of(deeper)));
  const auto frames = rig.next(1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].stamp.geometry_revision, 1U);
  EXPECT_EQ(rig.source->description().geometry.pixel_height_mm, 0.75);
  // A larger image finds no room in the ring.
  SentImage larger = of_fanlight(2);
  larger.columns = 64;
  ASSERT_TRUE(rig.scanner.send(message_of(larger)));
  const auto misfit = rig.next(1);
  ASSERT_EQ(misfit.size(), 1U);
  EXPECT_EQ(misfit[0].fault, FrameFault::kMisfit);
}

// Prints the rate; acquisition/RESULTS.md has it.
TEST(IgtlSource, LosesNoFrameHoweverFastTheyCome) {
  constexpr std::uint32_t kCount = 2000;
  constexpr std::uint16_t kSide = 256;
  Rig rig;
  RecordingFacts large = facts();
  large.geometry.columns = large.geometry.rows = kSide;
  const auto message = [&large](std::uint32_t index) {
    SentImage sent = of_fanlight(index);
    sent.columns = sent.rows = kSide;
    for (const auto& field : fanlight_fields(large))
      for (auto& known : sent.metadata)
        if (known.first == field.first) known.second = field.second;
    return message_of(sent);
  };
  ASSERT_TRUE(rig.open({message(0)})) << rig.error.message;
  // Written before, so that the reading is measured alone.
  std::vector<Bytes> messages;
  for (std::uint32_t i = 1; i < kCount; ++i) messages.push_back(message(i));
  std::size_t bytes = 0;
  for (const Bytes& each : messages) bytes += each.size();
  std::thread sender([&] {
    for (const Bytes& each : messages) ASSERT_TRUE(rig.scanner.send(each));
  });
  const std::int64_t begun_ns = now_ns();
  const auto frames = rig.next(kCount);
  const double seconds = static_cast<double>(now_ns() - begun_ns) * 1e-9;
  sender.join();
  ASSERT_EQ(frames.size(), kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) EXPECT_EQ(frames[i].stamp.sequence, i);
  fmt::print("{:.0f} MB in {:.2f} s: {:.0f} MB/s\n", static_cast<double>(bytes) * 1e-6, seconds,
             static_cast<double>(bytes) * 1e-6 / seconds);
}

TEST(IgtlSource, SaysThatThereAreNoViewers) {
  Rig rig;
  IgtlSource::Config config{.address = *IgtlAddress::parse("127.0.0.1:1"), .wait_s = 0.3};
  const auto opened = IgtlSource::create(config, rig.link);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_NE(opened.error().message.find("igtl:127.0.0.1:1 cannot be reached"), std::string::npos)
      << opened.error().message;
  EXPECT_GE(rig.counters().connections_failed.value(), 1U);
}

TEST(IgtlSource, SaysWhatCameInPlaceOfImages) {
  Rig rig;
  EXPECT_FALSE(rig.open({transform_of_plus(0)}, "", {.learn_s = 0.5}));
  EXPECT_NE(rig.error.message.find("received: TRANSFORM"), std::string::npos) << rig.error.message;
  Rig colours;
  SentImage sent;
  igtl::ImageBody body = body_of(sent);
  body.components = 3;
  EXPECT_FALSE(colours.open({message_of(sent, body, Bytes(body.part_bytes()))}, "", {.learn_s = 0.5}));
  EXPECT_NE(colours.error.message.find("a pixel has 3 numbers"), std::string::npos) << colours.error.message;
}

TEST(IgtlSource, TakesTheImagesOfOneDevice) {
  Rig rig;
  SentImage other = of_fanlight(0);
  other.device = "Other_Reference";
  other.grey = 77;
  ASSERT_TRUE(rig.open({message_of(other), message_of(of_fanlight(0))}, ",image=Image_Reference"));
  const auto frames = rig.next(1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].pixels[0], 0);
  EXPECT_EQ(rig.counters().messages_ignored.value(), 1U);
}

}  // namespace igtl_source_tests
}  // namespace fanlight::test
