// Streams: what each codec makes of a picture, what a session may ask for, and who shares what.
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>
#include <wels/codec_api.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "server/h264_coder.hpp"
#include "server/jpeg_coder.hpp"
#include "server/png_coder.hpp"
#include "server/stream_settings.hpp"
#include "tests/support/fake_house.hpp"
#include "tests/support/stream_client.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;
using Bytes = std::vector<std::uint8_t>;

/// Colours that change slowly, and differ from picture to picture.
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

/// Decodes H.264 to its luma.
class FilmReader {
 public:
  FilmReader() {
    WelsCreateDecoder(&decoder_);
    SDecodingParam parameters{};
    parameters.sVideoProperty.eVideoBsType = VIDEO_BITSTREAM_AVC;
    decoder_->Initialize(&parameters);
  }
  ~FilmReader() {
    decoder_->Uninitialize();
    WelsDestroyDecoder(decoder_);
  }
  FilmReader(const FilmReader&) = delete;
  FilmReader& operator=(const FilmReader&) = delete;

  /// Empty where it made no picture of the bytes.
  Bytes luma(std::span<const std::uint8_t> bytes) {
    std::uint8_t* planes[3] = {};
    SBufferInfo info{};
    if (decoder_->DecodeFrameNoDelay(bytes.data(), static_cast<int>(bytes.size()), planes, &info) !=
        dsErrorFree)
      return {};
    if (info.iBufferStatus != 1) return {};
    Bytes picture;
    const auto& format = info.UsrData.sSystemBuffer;
    for (int row = 0; row < format.iHeight; ++row) {
      const std::uint8_t* const from = planes[0] + static_cast<std::ptrdiff_t>(row) * format.iStride[0];
      picture.insert(picture.end(), from, from + format.iWidth);
    }
    return picture;
  }

 private:
  ISVCDecoder* decoder_ = nullptr;
};

/// As ITU-R BT.601 has it, 16 to 235, which is what the coder makes of RGB.
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

TEST(Codec, AFilmShowsItsPicturesAndBeginsAnewWhenAsked) {
  H264Coder coder(4000, 10);
  FilmReader reader;
  FilmReader late;
  for (int picture = 0; picture < 12; ++picture) {
    const Bytes rgba = waves(320, 240, picture);
    const auto code = coder.encode({.width = 320, .height = 240, .rgba = rgba}, picture == 7);
    ASSERT_TRUE(code) << code.error().message;
    EXPECT_EQ(code->key, picture == 0 || picture == 7) << picture;
    const Bytes luma = reader.luma(code->bytes);
    EXPECT_LT(mean_difference(luma, luma_of(rgba)), 4) << picture;
    if (picture >= 7) {
      EXPECT_EQ(late.luma(code->bytes), luma) << "who comes with a key picture sees the same";
    }
  }
}

TEST(Codec, AFilmTakesAnotherSize) {
  H264Coder coder(1000, 0);
  FilmReader reader;
  for (const std::uint32_t side : {64U, 128U, 32U}) {
    const Bytes rgba = waves(side, side, 0);
    const auto code = coder.encode({.width = side, .height = side, .rgba = rgba}, false);
    ASSERT_TRUE(code) << code.error().message;
    EXPECT_TRUE(code->key);
    EXPECT_EQ(reader.luma(code->bytes).size(), std::size_t{side} * side);
  }
}

TEST(Codec, ScalesToWhatFits) {
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

TEST(Codec, WhateverMayBeAskedForCanBeEncoded) {
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

TEST(StreamSettings, AreCheckedAndFilledIn) {
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

v1::StreamReply ask(StreamClient& client, const v1::StreamRequest& request) {
  v1::ClientMessage message;
  *message.mutable_stream() = request;
  client.send(message);
  return client.next(Body::kStreamReply).stream_reply();
}

TEST(Stream, GivesEachSessionWhatItAskedFor) {
  FakeHouse house;
  StreamClient png(house.endpoint());
  StreamClient film(house.endpoint());
  StreamClient small(house.endpoint());
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::PNG);
  EXPECT_EQ(ask(png, request).in_force().codec(), v1::StreamRequest::PNG);
  request.set_codec(v1::StreamRequest::H264);
  EXPECT_EQ(ask(film, request).in_force().bit_rate_kbps(), 4000U);
  request.set_codec(v1::StreamRequest::JPEG);
  request.set_width(32);
  ask(small, request);
  house.show(1, 128);
  EXPECT_EQ(png.next(Body::kPicture).picture().png().substr(1, 3), "PNG");
  const auto picture = film.next(Body::kPicture).picture();
  EXPECT_TRUE(picture.key_picture());
  EXPECT_EQ(picture.h264().substr(0, 4), std::string("\0\0\0\1", 4));
  EXPECT_EQ(small.next(Body::kPicture).picture().width(), 32U);
  request.set_width(1);
  EXPECT_TRUE(ask(small, request).has_refused());
}

TEST(Stream, SharesOneEncodingAmongThoseWhoAskAlike) {
  FakeHouse house;
  std::vector<std::unique_ptr<StreamClient>> clients;
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::PNG);
  for (int count = 0; count < 10; ++count) {
    clients.push_back(std::make_unique<StreamClient>(house.endpoint()));
    request.set_rate_hz(count % 2 == 0 ? 0 : 200);
    ask(*clients.back(), request);
  }
  const auto before = house.counters().pictures_encoded.value();
  house.show(1, 128);
  for (const auto& client : clients) client->next(Body::kPicture);
  EXPECT_EQ(house.counters().pictures_encoded.value(), before + 1);
}

TEST(Stream, ALateViewerOfAFilmBeginsWithAKeyPicture) {
  FakeHouse house;
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::H264);
  StreamClient first(house.endpoint());
  ask(first, request);
  FilmReader first_reader;
  FilmReader second_reader;
  const auto luma = [](FilmReader& reader, const v1::Picture& picture) {
    return reader.luma({reinterpret_cast<const std::uint8_t*>(picture.h264().data()), picture.h264().size()});
  };
  for (std::uint64_t id = 1; id <= 3; ++id) {
    house.show(id, static_cast<std::uint8_t>(60 * id));
    EXPECT_FALSE(luma(first_reader, first.next(Body::kPicture).picture()).empty());
  }
  StreamClient second(house.endpoint());
  second.next(Body::kPicture);  // a JPEG, before it has asked
  ask(second, request);
  const auto begun = second.next(Body::kPicture).picture();
  EXPECT_TRUE(begun.key_picture());
  EXPECT_EQ(begun.picture_id(), 3U);
  EXPECT_FALSE(luma(second_reader, begun).empty());
  EXPECT_FALSE(luma(first_reader, first.next(Body::kPicture).picture()).empty())
      << "shared with who was there";
  house.show(4, 10);
  const Bytes seen = luma(first_reader, first.next(Body::kPicture).picture());
  EXPECT_EQ(luma(second_reader, second.next(Body::kPicture).picture()), seen);
  EXPECT_FALSE(seen.empty());
}

TEST(Stream, OneWhoAsksOverAndOverCostsTheOthersNothing) {
  FakeHouse house;
  StreamClient victim(house.endpoint());
  StreamClient asker(house.endpoint());
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::H264);
  ask(victim, request);
  house.show(1, 50);
  victim.next(Body::kPicture);
  const auto before = house.counters().pictures_encoded.value();
  int refused = 0;
  for (int round = 0; round < 100; ++round) {
    request.set_codec(round % 2 == 0 ? v1::StreamRequest::H264 : v1::StreamRequest::PNG);
    refused += ask(asker, request).has_refused() ? 1 : 0;
    ask(asker, request);
  }
  EXPECT_GT(refused, 40);
  EXPECT_LT(house.counters().pictures_encoded.value() - before, 20U);
}

TEST(Stream, EncodesInSoManyWaysAndNoMore) {
  FakeHouse house;
  house.show(1, 50);
  std::vector<std::unique_ptr<StreamClient>> clients;
  int refused = 0;
  for (std::uint32_t quality = 1; quality <= 30; ++quality) {
    clients.push_back(std::make_unique<StreamClient>(house.endpoint()));
    v1::StreamRequest request;
    request.set_quality(quality);
    refused += ask(*clients.back(), request).has_refused() ? 1 : 0;
  }
  EXPECT_GT(refused, 10);
  EXPECT_LT(refused, 20);
  house.show(2, 60);
  for (const auto& client : clients) {
    while (client->next(Body::kPicture).picture().picture_id() != 2) {
    }
  }
}

TEST(Stream, MoreMessagesThanASecondHasWaitForTheNext) {
  FakeHouse house;
  StreamClient client(house.endpoint());
  v1::ClientMessage message;
  message.mutable_clock_request()->set_client_time_ms(1);
  constexpr int kMessages = 1200;
  std::jthread writer([&] {
    for (int sent = 0; sent < kMessages; ++sent) client.send(message);
  });
  for (int answered = 0; answered < kMessages; ++answered) client.next(Body::kClockReply);
}

TEST(Stream, TellsDepthsAndWhereTheyLie) {
  FakeHouse house;
  StreamClient client(house.endpoint());
  v1::ClientMessage question;
  question.mutable_depth()->set_request_id(3);
  for (const auto& [column, row] : {std::pair(10U, 20U), std::pair(11U, 20U), std::pair(9999U, 1U)}) {
    auto& pixel = *question.mutable_depth()->add_pixels();
    pixel.set_column(column);
    pixel.set_row(row);
  }
  client.send(question);
  EXPECT_TRUE(client.next(Body::kDepthReply).depth_reply().has_refused()) << "before the first picture";
  house.show_depths(7, [](std::uint32_t column, std::uint32_t row) {
    return column == 11 ? -1.0F : 50.0F + static_cast<float>(row);
  });
  v1::StreamRequest request;
  request.set_with_depth(true);
  ask(client, request);
  v1::Picture picture;
  while (picture.depth().empty()) picture = client.next(Body::kPicture).picture();
  std::vector<std::uint16_t> units(std::size_t{FakeHouse::kWidth} * FakeHouse::kHeight);
  uLongf bytes = units.size() * 2;
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(units.data()), &bytes,
                       reinterpret_cast<const Bytef*>(picture.depth().data()), picture.depth().size()),
            Z_OK);
  EXPECT_EQ(bytes, units.size() * 2);
  EXPECT_NEAR(units[20 * FakeHouse::kWidth + 10] * picture.depth_unit_mm(), 70, 0.01);
  EXPECT_EQ(units[20 * FakeHouse::kWidth + 11], 65535);

  client.send(question);
  const auto reply = client.next(Body::kDepthReply).depth_reply();
  EXPECT_EQ(reply.picture_id(), 7U);
  ASSERT_EQ(reply.points_size(), 3);
  EXPECT_NEAR(reply.points(0).depth_mm(), 70, 1e-6);
  // The view of show_depths(): half a millimetre a pixel from (5, 6) on, looking along y.
  EXPECT_NEAR(reply.points(0).x_mm(), 0.5 * (10 - 5), 1e-6);
  EXPECT_NEAR(reply.points(0).y_mm(), 70, 1e-6);
  EXPECT_NEAR(reply.points(0).z_mm(), -0.5 * (20 - 6), 1e-6);
  EXPECT_FALSE(reply.points(1).surface());
  EXPECT_FALSE(reply.points(2).surface());
  for (int pixel = 0; pixel < 2000; ++pixel) question.mutable_depth()->add_pixels();
  client.send(question);
  EXPECT_TRUE(client.next(Body::kDepthReply).depth_reply().has_refused());
}

TEST(JpegCoder, FollowsABitRate) {
  // 800 kbit a second at about 100 pictures a second: 1 kB each, where quality 75 makes several.
  const auto coder = JpegCoder::with_bit_rate(800);
  const Bytes rgba = waves(320, 240, 0);
  std::size_t bytes = 0;
  for (int picture = 0; picture < 100; ++picture) {
    bytes = coder->encode({.width = 320, .height = 240, .rgba = rgba}, false)->bytes.size();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  JpegCoder fixed(75);
  EXPECT_LT(bytes, fixed.encode({.width = 320, .height = 240, .rgba = rgba}, false)->bytes.size());
  EXPECT_LT(coder->quality(), 75);
}

}  // namespace
}  // namespace fanlight::test
