// SPDX-License-Identifier: Apache-2.0
// The bytes of the RTP stream: payloads, RTCP, SEI messages, descriptions and keys.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "server/rtp/h264_payloads.hpp"
#include "server/rtp/rtcp.hpp"
#include "server/rtp/rtp_clock.hpp"
#include "server/rtp/rtp_packet.hpp"
#include "server/rtp/sdp.hpp"
#include "server/rtp/srtp_context.hpp"
#include "server/rtp/user_data_sei.hpp"
#include "tests/rtp/rtp_receiver.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace rtp_bytes_tests {

using Bytes = std::vector<std::uint8_t>;

/// A unit of this kind whose other bytes are random.
Bytes random_unit(std::mt19937& random, std::uint8_t head, std::size_t bytes) {
  Bytes unit(bytes, 1);
  for (std::uint8_t& byte : unit) byte = static_cast<std::uint8_t>(1 + random() % 255);  // no start code
  unit.front() = head;
  return unit;
}

TEST(RtpPacket, HasTheHeaderOfRfc3550) {
  Bytes bytes;
  put_rtp_header(
      bytes, {.payload_type = 96, .marker = true, .sequence = 0x1234, .timestamp = 0x89abcdef, .source = 7});
  EXPECT_EQ(bytes, (Bytes{0x80, 0x80 | 96, 0x12, 0x34, 0x89, 0xab, 0xcd, 0xef, 0, 0, 0, 7}));
  EXPECT_EQ(bytes.size(), kRtpHeaderBytes);
}

TEST(RtpClock, GoesOnWithTimeWhateverThePicturesAge) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  constexpr std::int64_t kHourNs = 3600 * kSecondNs;
  // Seven hours are more than half the range of 32 bits, fourteen more than all of it.
  for (const std::int64_t hours : {1, 7, 14}) {
    RtpClock clock(0xffff'fff0, 100 * kHourNs);  // about to wrap
    const std::uint32_t old = clock.next((100 - hours) * kHourNs);
    EXPECT_EQ(old, clock.at(100 * kHourNs) + 1) << hours << " h old";
    EXPECT_EQ(clock.next((100 - hours) * kHourNs), old + 1) << "once more";
    const std::int64_t later_ns = 100 * kHourNs + kSecondNs / 2;
    EXPECT_EQ(clock.next(later_ns) - old, 45'000U - 1);
    EXPECT_EQ(clock.next(later_ns + hours * kHourNs), clock.at(later_ns + hours * kHourNs));
  }
  EXPECT_EQ(RtpClock(7, 0).at(-kSecondNs), 7U - 90'000U);  // soon after the machine's start
}

TEST(NalUnits, AreFoundBetweenStartCodesOfBothLengths) {
  const Bytes stream = {0, 0, 0, 1, 0x67, 5, 6, 0, 0, 1, 0x68, 7, 0, 0, 0, 0, 1, 0x65, 0, 8, 0, 0, 0};
  const auto units = nal_units(stream);
  ASSERT_EQ(units.size(), 3U);
  EXPECT_TRUE(std::ranges::equal(units[0], Bytes{0x67, 5, 6}));
  EXPECT_TRUE(std::ranges::equal(units[1], Bytes{0x68, 7}));
  EXPECT_TRUE(std::ranges::equal(units[2], Bytes{0x65, 0, 8}));
  EXPECT_EQ(nal_kind(units[0]), NalKind::kSequenceSet);
  EXPECT_EQ(nal_kind(units[2]), NalKind::kKeySlice);
  EXPECT_TRUE(nal_units(Bytes{1, 2, 3}).empty());
  EXPECT_TRUE(nal_units({}).empty());
}

TEST(H264Payloads, AreUnpackedToTheSameUnits) {
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    const std::size_t most_bytes = 64 + random() % 1400;
    std::vector<Bytes> units;
    std::vector<std::span<const std::uint8_t>> spans;
    for (std::size_t count = 1 + random() % 5; count > 0; --count)
      units.push_back(random_unit(random, 0x65, 1 + random() % (random() % 2 == 0 ? 40 : 6000)));
    spans.assign(units.begin(), units.end());
    const auto payloads = h264_payloads(spans, most_bytes);
    for (const Bytes& payload : payloads) ASSERT_LE(payload.size(), most_bytes);
    ASSERT_EQ(unpacked(payloads), units) << "round " << round;
  }
}

TEST(H264Payloads, ShareAPacketWhereTheyAreSmallAndAreCutWhereTheyAreLarge) {
  const Bytes sequence = {0x67, 1, 2};
  const Bytes picture = {0x68, 3};
  const Bytes slice(100, 0x41);
  const std::vector<std::span<const std::uint8_t>> units = {sequence, picture, slice};
  const auto payloads = h264_payloads(units, 64);
  ASSERT_EQ(payloads.size(), 3U);
  EXPECT_EQ(payloads[0], (Bytes{0x60 | 24, 0, 3, 0x67, 1, 2, 0, 2, 0x68, 3}));
  EXPECT_EQ(payloads[1][0], 0x40 | 28);
  EXPECT_EQ(payloads[1][1], 0x80 | 1);  // the first part
  EXPECT_EQ(payloads[2][1], 0x40 | 1);  // the last one
  EXPECT_EQ(payloads[1].size() + payloads[2].size(), 99 + 4U);
}

TEST(UserDataSei, HoldsAnyBytesWithoutAStartCode) {
  std::mt19937 random(2);
  for (int round = 0; round < 300; ++round) {
    std::string data(random() % 1200, '\0');
    for (char& letter : data) letter = static_cast<char>(random() % 4);  // what needs escapes most
    const Bytes unit = user_data_sei(data);
    EXPECT_EQ(nal_kind(unit), NalKind::kSei);
    for (std::size_t at = 0; at + 3 <= unit.size(); ++at)
      ASSERT_FALSE(unit[at] == 0 && unit[at + 1] == 0 && unit[at + 2] <= 2) << "round " << round;
    EXPECT_NE(unit.back(), 0);
    const auto read = read_user_data_sei(unit);
    ASSERT_TRUE(read);
    ASSERT_EQ(*read, data) << "round " << round;
  }
}

TEST(UserDataSei, IsReadOnlyWhereItIsWholeAndOurs) {
  Bytes unit = user_data_sei("{}");
  for (std::size_t bytes = 0; bytes + 2 < unit.size(); ++bytes)
    EXPECT_FALSE(read_user_data_sei(std::span(unit).first(bytes)));
  unit[5] ^= 1;  // of the UUID
  EXPECT_FALSE(read_user_data_sei(unit));
  EXPECT_FALSE(read_user_data_sei(Bytes{0x65, 1, 2, 3}));
}

TEST(Rtcp, ReportsAsRfc3550Says) {
  const Bytes bytes = rtcp_packet({.source = 0x01020304,
                                   .ntp = 0x1112131415161718,
                                   .timestamp = 0x21222324,
                                   .packets = 5,
                                   .bytes = 0x31323334},
                                  "abc", true);
  EXPECT_EQ(bytes, (Bytes{0x80, 200,  0,    6,    1,    2,    3,    4, 0x11, 0x12, 0x13, 0x14, 0x15,
                          0x16, 0x17, 0x18, 0x21, 0x22, 0x23, 0x24, 0, 0,    0,    5,    0x31, 0x32,
                          0x33, 0x34, 0x81, 202,  0,    3,    1,    2, 3,    4,    1,    3,    'a',
                          'b',  'c',  0,    0,    0,    0x81, 203,  0, 1,    1,    2,    3,    4}));
  // Names of every length end with zero bytes at a whole word.
  for (std::size_t letters = 0; letters < 9; ++letters) {
    const Bytes named = rtcp_packet({}, std::string(letters, 'x'), false);
    EXPECT_EQ(named.size() % 4, 0U);
    EXPECT_EQ(named.back(), 0);
    EXPECT_TRUE(parse_rtcp(named, 1));
  }
}

TEST(Rtcp, CountsTimeFrom1900) {
  EXPECT_EQ(ntp_time(0), 2'208'988'800ULL << 32);
  EXPECT_EQ(ntp_time(1'500'000'000), (2'208'988'801ULL << 32) | 0x80000000);
  EXPECT_LT(ntp_time(1'999'999'999), 2'208'988'802ULL << 32);
}

TEST(Rtcp, ReadsReportsAndWishesOfReceivers) {
  const Bytes report = {0x81, 201, 0, 7, 0,  0,    0,    9,     // from 9
                        0,    0,   0, 4, 64, 0xff, 0xff, 0xfe,  // about 4: a quarter lost, -2 in all
                        0,    0,   0, 0, 0,  0,    0,    90,    // jitter
                        1,    2,   3, 4, 0,  0,    0x80, 0};
  const auto read = parse_rtcp(report, 4);
  ASSERT_TRUE(read);
  ASSERT_TRUE(read->report);
  EXPECT_EQ(read->report->lost_share, 0.25);
  EXPECT_EQ(read->report->lost, -2);
  EXPECT_EQ(read->report->jitter, 90U);
  EXPECT_EQ(read->report->last_report, 0x01020304U);
  EXPECT_EQ(read->report->since_last_report, 0x8000U);
  EXPECT_FALSE(read->key_wanted);
  EXPECT_FALSE(parse_rtcp(report, 5)->report);  // about another source

  const Bytes loss = {0x81, 206, 0, 2, 0, 0, 0, 9, 0, 0, 0, 4};
  EXPECT_TRUE(parse_rtcp(loss, 4)->key_wanted);
  const Bytes intra = {0x84, 206, 0, 4, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 4, 1, 0, 0, 0};
  EXPECT_TRUE(parse_rtcp(intra, 4)->key_wanted);
  const Bytes again = {0x81, 205, 0, 3, 0, 0, 0, 9, 0, 0, 0, 4, 0x12, 0x34, 0, 5};
  EXPECT_EQ(parse_rtcp(again, 4)->packets_wanted, 3U);
  const Bytes leaves = {0x81, 203, 0, 1, 0, 0, 0, 9};
  EXPECT_TRUE(parse_rtcp(leaves, 4)->ends);
  Bytes compound = report;
  compound.insert(compound.end(), loss.begin(), loss.end());
  EXPECT_TRUE(parse_rtcp(compound, 4)->report && parse_rtcp(compound, 4)->key_wanted);
}

TEST(Rtcp, RefusesWhatIsNone) {
  const std::vector<Bytes> wrong = {{},
                                    {0x81},
                                    {0x41, 201, 0, 0},              // version 1
                                    {0x80, 96, 0, 0},               // RTP
                                    {0x80, 201, 0, 1},              // longer than what came
                                    {0x81, 201, 0, 1, 0, 0, 0, 9},  // without its report
                                    {0x81, 206, 0, 1, 0, 0, 0, 9},  // without a source
                                    {0xa0, 203, 0, 1, 0, 0, 0, 9},  // padding of 9 in 4 bytes
                                    {0xa0, 203, 0, 1, 0, 0, 0, 0},  // padding of none
                                    {0x80, 203, 0, 0, 0x80}};       // ends within a head
  for (const Bytes& packet : wrong) {
    const auto read = parse_rtcp(packet, 4);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::kBadInput);
  }
}

TEST(Rtcp, TakesAHundredThousandMutatedPackets) {
  std::mt19937 random(3);
  const Bytes whole = rtcp_packet({.source = 4}, "somebody", true);
  const std::vector<Bytes> seeds = {whole,
                                    {0x81, 206, 0, 2, 0, 0, 0, 9, 0, 0, 0, 4},
                                    {0x81, 205, 0, 3, 0, 0, 0, 9, 0, 0, 0, 4, 0x12, 0x34, 0, 5}};
  int read = 0;
  int refused = 0;
  for (int round = 0; round < 100'000; ++round) {
    Bytes packet = seeds[random() % seeds.size()];
    for (std::size_t changes = 1 + random() % 4; changes > 0; --changes)
      packet[random() % packet.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0)
      packet.erase(packet.begin() + static_cast<std::ptrdiff_t>(random() % packet.size()), packet.end());
    ++(parse_rtcp(packet, 4) ? read : refused);
  }
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(Sdp, SaysWhatAReceiverNeeds) {
  const Bytes sequence = {0x67, 0x42, 0xc0, 0x1f};
  const Bytes picture = {0x68, 0xce};
  RtpDescription description{.title = "Room 1\r\nm=audio 1 RTP/AVP 0",
                             .from = "10.0.0.1",
                             .to = "10.0.0.2",
                             .port = 5004,
                             .source = 7,
                             .session = 42,
                             .name = "x",
                             .sequence_set = sequence,
                             .picture_set = picture};
  EXPECT_EQ(
      sdp(description),
      "v=0\r\no=- 42 1 IN IP4 10.0.0.1\r\ns=Room 1  m=audio 1 RTP/AVP 0\r\nc=IN IP4 10.0.0.2\r\nt=0 0\r\n"
      "m=video 5004 RTP/AVPF 96\r\na=rtpmap:96 H264/90000\r\n"
      "a=fmtp:96 packetization-mode=1;profile-level-id=42C01F;sprop-parameter-sets=Z0LAHw==,aM4=\r\n"
      "a=rtcp:5005\r\na=rtcp-fb:96 nack pli\r\na=rtcp-fb:96 ccm fir\r\na=ssrc:7 cname:x\r\n");
  const Bytes key(kSrtpKeyBytes, 1);
  description.srtp_key = key;
  const std::string secret = sdp(description);
  EXPECT_NE(secret.find("m=video 5004 RTP/SAVPF 96"), std::string::npos);
  EXPECT_NE(
      secret.find("a=crypto:1 AES_CM_128_HMAC_SHA1_80 inline:AQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEB\r\n"),
      std::string::npos);
}

TEST(SrtpContext, IsOpenedByWhoHasTheKeyAlone) {
  const Bytes key(kSrtpKeyBytes, 7);
  auto sender = SrtpContext::create(key);
  ASSERT_TRUE(sender);
  Bytes packet;
  put_rtp_header(packet, {.payload_type = 96, .sequence = 1, .timestamp = 2, .source = 3});
  packet.insert(packet.end(), 50, 0x55);
  const Bytes plain = packet;
  ASSERT_TRUE((*sender)->protect_rtp(packet));
  EXPECT_EQ(packet.size(), plain.size() + 10);  // of HMAC_SHA1_80
  EXPECT_FALSE(std::equal(plain.begin() + kRtpHeaderBytes, plain.end(), packet.begin() + kRtpHeaderBytes));

  Bytes report = rtcp_packet({.source = 3}, "x", false);
  const Bytes plain_report = report;
  ASSERT_TRUE((*sender)->protect_rtcp(report));
  EXPECT_NE(report, plain_report);
  auto outsider = SrtpContext::create(Bytes(kSrtpKeyBytes, 8));
  EXPECT_FALSE((*outsider)->unprotect_rtcp(report));
  auto receiver = SrtpContext::create(key);
  Bytes opened = report;
  ASSERT_TRUE((*receiver)->unprotect_rtcp(opened));
  EXPECT_EQ(opened, plain_report);
  Bytes replayed = report;
  EXPECT_FALSE((*receiver)->unprotect_rtcp(replayed));
  EXPECT_EQ(replayed, report);
  EXPECT_FALSE(SrtpContext::create({1, 2, 3}));
}

TEST(SrtpKey, IsReadFromBase64) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "key";
  const auto written = [&](const std::string& text) {
    std::ofstream(file) << text;
    std::filesystem::permissions(file, std::filesystem::perms{0640});
    return read_srtp_key(file);
  };
  EXPECT_EQ(*written("AQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEB\n"), Bytes(kSrtpKeyBytes, 1));
  for (const char* wrong :
       {"", "AQEB", "AQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQ==", "!QEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEB"})
    EXPECT_EQ(written(wrong).error().code, ErrorCode::kBadInput) << wrong;
  EXPECT_EQ(written(std::string(100'000, 'A')).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(read_srtp_key(folder.path() / "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_srtp_key("/dev/zero").error().code, ErrorCode::kNotFound);
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_srtp_key(folder.path() / "pipe").error().code, ErrorCode::kNotFound) << "without waiting";
}

TEST(SrtpKey, IsRefusedWhereOthersMayReadOrWriteIt) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "key";
  std::ofstream(file) << "AQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEB\n";
  for (const auto& [mode, good] :
       {std::pair{0600, true}, {0400, true}, {0440, true}, {0644, false}, {0660, false}, {0606, false}}) {
    std::filesystem::permissions(file, std::filesystem::perms(mode));
    EXPECT_EQ(bool(read_srtp_key(file)), good) << std::oct << mode;
  }
}

}  // namespace rtp_bytes_tests
}  // namespace fanlight::test
