// SPDX-License-Identifier: Apache-2.0
#include "server/stream/shared_page.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <string_view>

#include "proto/base/version.hpp"
#include "server/codec/reduced_picture.hpp"
#include "server/state/scene_message.hpp"
#include "server/stream/picture_message.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kPlace = "<!--surfaces-->";
constexpr double kBase64 = 4.0 / 3;

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // with the zero that OpenSSL writes behind it
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

/// What a reader needs of a picture: no times, and nothing of the source.
void describe_shared(v1::Picture& to, const Picture& picture, std::size_t number) {
  v1::Picture whole;
  describe(whole, picture);
  to.set_picture_id(number);
  to.set_volume_id(number);
  to.set_width(picture.width);
  to.set_height(picture.height);
  // A film runs at its own rate.
  to.set_capture_time_ns(picture.stamp.volume.last_capture_time_ns);
  *to.mutable_view() = whole.view();
}

}  // namespace

SharedPage::SharedPage(std::string_view page, const std::string& title, const Scene& scene) : page_(page) {
  surfaces_.set_title(title);
  surfaces_.set_made_by("Fanlight " + std::string(version()));
  *surfaces_.mutable_scene() = scene_message(scene);
  v1::Hello hello;
  add_scene_fields(hello);
  *surfaces_.mutable_fields() = hello.fields();
  for (v1::SceneField& field : *surfaces_.mutable_fields()) field.clear_help();
  bytes_ = page_.size() + static_cast<std::size_t>(kBase64 * static_cast<double>(surfaces_.ByteSizeLong()));
}

Result<void> SharedPage::add(const Picture& picture) {
  const SurfacePart& part = picture.stamp.view.part;
  if (part.width != picture.width || part.height != picture.height) {
    return Error{ErrorCode::kInvalidArgument,
                 "the picture shows more than a surface, or none, expected the mode surface or depth"};
  }
  if (part.seen_through) {
    return Error{ErrorCode::kInvalidArgument,
                 "the surface is shown as glass, which a shared page cannot draw, expected glass.amount 0"};
  }
  v1::Picture& added = *surfaces_.add_pictures();
  describe_shared(added, picture, static_cast<std::size_t>(surfaces_.pictures_size()));
  if (surfaces_.pictures_size() > 1) {
    added.set_capture_time_ns(added.capture_time_ns() - first_capture_ns_);
  } else {
    first_capture_ns_ = added.capture_time_ns();
    added.set_capture_time_ns(0);
  }
  if (auto packed = coder_.encode(picture, *added.mutable_surface()); !packed) return packed;
  bytes_ += static_cast<std::size_t>(kBase64 * static_cast<double>(added.ByteSizeLong()));
  if (bytes_ <= kMostBytes) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("the file has {:.1f} MB with {} surfaces, expected {:.0f} MB at most: fewer volumes "
                  "(--count), or a smaller --size",
                  1e-6 * static_cast<double>(bytes_), surfaces_.pictures_size(), 1e-6 * kMostBytes)};
}

Result<void> SharedPage::add_within(const Picture& picture, PictureSize usual) {
  constexpr std::uint32_t kMostFactor = 2;
  if (picture.height <= kMostFactor * usual.height) return add(picture);
  return add(reduced(picture, usual));
}

std::string SharedPage::html() const {
  std::string html(page_);
  const auto at = html.find(kPlace);
  if (at == std::string::npos) return html;  // a page that was not built
  const std::string data = base64(surfaces_.SerializeAsString());
  html.replace(at, kPlace.size(),
               fmt::format("<script type=\"text/plain\" id=\"surfaces\">{}</script>", data));
  return html;
}

}  // namespace fanlight
