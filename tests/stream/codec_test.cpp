// SPDX-License-Identifier: Apache-2.0
// The codecs, the scaling of pictures and the settings of a stream.
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "server/codec/h264_coder.hpp"
#include "server/codec/jpeg_coder.hpp"
#include "server/codec/png_coder.hpp"
#include "server/codec/stream_settings.hpp"
#include "tests/stream/h264_reader.hpp"

namespace fanlight::test {
namespace {

/// A picture of slowly changing colours, height x width x 4 bytes; `phase` moves them from picture to
/// picture.
Bytes waves(std::uint32_t width, std::uint32_t height, int phase) {
  Bytes rgba;
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      const double x = 0.03 * column + 0.2 * phase;
      const double y = 0.02 * row;
      for (const double level : {std::sin(x), std::cos(y), std::sin(x + y)})
        rgba.push_back(static_cast<std::uint8_t>(128 + 100 * level));
      rgba.push_back(255);
    }
  }
  return rgba;
}

double mean_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  if (a.size() != b.size() || a.empty()) return 255;
  double sum = 0;
  for (std::size_t at = 0; at < a.size(); ++at) sum += std::abs(a[at] - b[at]);
  return sum / static_cast<double>(a.size());
}

/// Luma of ITU-R BT.601, 16 to 235, as the coder computes it from RGB.
Bytes luma_of(const Bytes& rgba) {
  Bytes luma;
  for (std::size_t at = 0; at < rgba.size(); at += 4) {
    luma.push_back(static_cast<std::uint8_t>(
        16 + (65.481 * rgba[at] + 128.553 * rgba[at + 1] + 24.966 * rgba[at + 2]) / 255));
  }
  return luma;
}

TEST(Codec, PngKeepsEveryLevel) {
  const Bytes rgba = waves(321, 200, 0);
  PngCoder coder;
  const auto code = coder.encode({.width = 321, .height = 200, .rgba = rgba}, false);
  ASSERT_TRUE(code);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&image, code->bytes.data(), code->bytes.size()));
  image.format = PNG_FORMAT_RGBA;
  Bytes back(PNG_IMAGE_SIZE(image));
  ASSERT_TRUE(png_image_finish_read(&image, nullptr, back.data(), 0, nullptr));
  EXPECT_EQ(back, rgba);
}

TEST(Codec, H264KeepsThePicturesAndMakesKeyPicturesOnRequest) {
  H264Coder coder(4000, 10);
  H264Reader reader;
  H264Reader late;
  for (int picture = 0; picture < 12; ++picture) {
    const Bytes rgba = waves(320, 240, picture);
    const auto code = coder.encode({.width = 320, .height = 240, .rgba = rgba}, picture == 7);
    ASSERT_TRUE(code) << code.error().message;
    EXPECT_EQ(code->key, picture == 0 || picture == 7) << picture;
    const Bytes luma = reader.luma(code->bytes);
    EXPECT_LT(mean_difference(luma, luma_of(rgba)), 4) << picture;
    if (picture >= 7) {
      EXPECT_EQ(late.luma(code->bytes), luma)
          << "a decoder that starts with a key picture gets the same pixels";
    }
  }
}

TEST(Codec, H264BeginsANewStreamWithAnotherSize) {
  H264Coder coder(1000, 0);
  H264Reader reader;
  for (const std::uint32_t side : {64U, 128U, 32U}) {
    const Bytes rgba = waves(side, side, 0);
    const auto code = coder.encode({.width = side, .height = side, .rgba = rgba}, false);
    ASSERT_TRUE(code) << code.error().message;
    EXPECT_TRUE(code->key);
    EXPECT_EQ(reader.luma(code->bytes).size(), std::size_t{side} * side);
  }
}

TEST(Codec, ScalesToTheLargestSizeThatFits) {
  PictureScaler scaler;
  const Bytes rgba = waves(640, 480, 0);
  const Pixels full{.width = 640, .height = 480, .rgba = rgba};
  const auto fitted = [&](StreamSettings settings) { return scaler.fitted(full, settings); };
  EXPECT_EQ(fitted({.most_width = 320}).height, 240U);
  EXPECT_EQ(fitted({.most_width = 320, .most_height = 120}).width, 160U);
  EXPECT_EQ(fitted({.most_width = 4000, .most_height = 4000}).width, 640U) << "never larger";
  const Pixels odd = fitted({.codec = StreamSettings::Codec::kH264, .most_width = 101});
  EXPECT_EQ(odd.width % 2 + odd.height % 2, 0U);
  const Pixels half = fitted({.most_width = 320});
  EXPECT_NEAR(half.rgba[4 * (100 * 320 + 50)], rgba[4 * (200 * 640 + 100)], 4);
}

TEST(Codec, EncodesAllAllowedSettings) {
  struct Size {
    std::uint32_t width;
    std::uint32_t height;
  };
  for (const Size size : {Size{1, 1}, Size{16, 900}, Size{641, 479}}) {
    const Bytes rgba = waves(size.width, size.height, 0);
    const Pixels pixels{.width = size.width, .height = size.height, .rgba = rgba};
    for (const std::uint32_t side : {0U, 16U, 17U, 4096U}) {
      for (const int kbps : {50, 4000, 200'000}) {
        for (const double rate_hz : {0.1, 0.0, 240.0}) {
          for (const auto codec :
               {StreamSettings::Codec::kJpeg, StreamSettings::Codec::kPng, StreamSettings::Codec::kH264}) {
            const StreamSettings settings{.codec = codec,
                                          .bit_rate_kbps = kbps,
                                          .most_width = side,
                                          .most_height = side,
                                          .rate_hz = rate_hz};
            auto coder = make_coder(settings);
            ASSERT_TRUE(coder);
            PictureScaler scaler;
            for (int picture = 0; picture < 3; ++picture) {
              const auto code = (*coder)->encode(scaler.fitted(pixels, settings), false);
              EXPECT_TRUE(code) << code.error().message << ", asked for " << side << " pixels, " << kbps
                                << " kbit/s, " << rate_hz << " Hz of " << size.width << " x " << size.height;
            }
          }
        }
      }
    }
  }
}

TEST(StreamSettings, AreCheckedAndCompleted) {
  const auto parsed = [](auto set) {
    v1::StreamRequest request;
    set(request);
    return parse_stream_request(request, 85);
  };
  EXPECT_EQ(parsed([](auto&) {})->quality, 85);
  EXPECT_EQ(parsed([](auto& request) { request.set_bit_rate_kbps(800); })->quality, 0);
  EXPECT_EQ(parsed([](auto& request) { request.set_codec(v1::StreamRequest::H264); })->bit_rate_kbps, 4000);
  for (const auto& [field, refused] :
       {std::pair("quality", parsed([](auto& request) { request.set_quality(101); })),
        std::pair("bit_rate_kbps", parsed([](auto& request) { request.set_bit_rate_kbps(1); })),
        std::pair("width", parsed([](auto& request) { request.set_width(3); })),
        std::pair("height", parsed([](auto& request) { request.set_height(9999999); })),
        std::pair("rate_hz", parsed([](auto& request) { request.set_rate_hz(-1); })),
        std::pair("rate_hz", parsed([](auto& request) { request.set_rate_hz(NAN); })),
        std::pair("codec", parsed([](auto& request) {
                    request.set_codec(static_cast<v1::StreamRequest::Codec>(9));
                  }))}) {
    ASSERT_FALSE(refused) << field;
    EXPECT_TRUE(refused.error().message.starts_with(field)) << refused.error().message;
  }
}

TEST(StreamSettings, EqualRatesTakeTheSamePictures) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  for (const double rate_hz : {1.0, 3.0, 10.0, 24.0}) {
    int due = 0;
    for (int picture = 1; picture <= 300; ++picture) {
      due += picture_due(rate_hz, (picture - 1) * kSecondNs / 30, picture * kSecondNs / 30) ? 1 : 0;
    }
    EXPECT_NEAR(due, 10 * rate_hz, 1) << rate_hz;
  }
  EXPECT_TRUE(picture_due(0, 5, 5));
}

TEST(JpegCoder, FollowsABitRate) {
  // 800 kbit a second at 100 pictures a second: 1 kB a picture, where quality 75 makes several kB.
  std::int64_t now_ns = 100'000'000'000;
  const auto coder = JpegCoder::with_bit_rate(800, [&now_ns] { return now_ns; });
  const Bytes rgba = waves(320, 240, 0);
  std::size_t bytes = 0;
  for (int picture = 0; picture < 100; ++picture) {
    bytes = coder->encode({.width = 320, .height = 240, .rgba = rgba}, false)->bytes.size();
    now_ns += 10'000'000;
  }
  JpegCoder fixed(75);
  EXPECT_LT(bytes, fixed.encode({.width = 320, .height = 240, .rgba = rgba}, false)->bytes.size());
  EXPECT_LT(coder->quality(), 75);
  // After a pause the rate is unknown: the quality stays.
  const int quality = coder->quality();
  now_ns += 11'000'000'000;
  ASSERT_TRUE(coder->encode({.width = 320, .height = 240, .rgba = rgba}, false));
  EXPECT_EQ(coder->quality(), quality);
}

}  // namespace
}  // namespace fanlight::test
