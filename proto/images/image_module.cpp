// SPDX-License-Identifier: Apache-2.0
// libfanlight-images.so, which image_library() loads.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "proto/base/version.hpp"
#include "proto/images/image_library.hpp"

namespace fanlight {

namespace {

class OpenedImage : public ImageReader {
 public:
  explicit OpenedImage(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}

  ImageShape shape() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    const bool bytes = spec.format == OIIO::TypeDesc::UINT8 || spec.format == OIIO::TypeDesc::INT8;
    return {.width = spec.width,
            .height = spec.height,
            .depth = spec.depth,
            .channels = spec.nchannels,
            .bytes_per_value = bytes ? 1U : 2U};
  }

  Result<void> read(unsigned bytes_per_value, std::span<std::uint8_t> values) override {
    const OIIO::TypeDesc type = bytes_per_value == 1 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16;
    if (input_->read_image(0, 0, 0, input_->spec().nchannels, type, values.data())) return {};
    return Error{ErrorCode::kBadInput, input_->geterror()};
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

OIIO::ImageSpec spec_of(const ImageToWrite& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels,
                       image.floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  if (image.channels == 1) {
    spec.channelnames = {"Z"};
    spec.z_channel = 0;
  }
  for (const auto& [name, value] : image.attributes) {
    if (const auto* text = std::get_if<std::string>(&value)) spec.attribute(name, *text);
    if (const auto* number = std::get_if<float>(&value)) spec.attribute(name, *number);
    if (const auto* matrix = std::get_if<std::array<float, 16>>(&value))
      spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 16), matrix->data());
  }
  return spec;
}

class Library : public ImageLibrary {
 public:
  Result<std::unique_ptr<ImageReader>> open(const std::string& path) override {
    auto input = OIIO::ImageInput::open(path);
    // OpenImageIO keeps a message that is not fetched for a later failure.
    if (!input) return Error{ErrorCode::kUnsupported, OIIO::geterror()};
    return std::unique_ptr<ImageReader>(std::make_unique<OpenedImage>(std::move(input)));
  }

  bool writes(const std::string& name) override {
    if (OIIO::ImageOutput::create(name)) return true;
    (void)OIIO::geterror();
    return false;
  }

  /// In memory: OpenImageIO reports no error of a full disk where it writes to a file itself.
  Result<std::vector<std::uint8_t>> encode(const std::string& name, const ImageToWrite& image) override {
    const auto output = OIIO::ImageOutput::create(name);
    if (!output) return Error{ErrorCode::kUnavailable, OIIO::geterror()};
    OIIO::Filesystem::IOVecOutput encoded;
    if (!output->supports("ioproxy") || !output->set_ioproxy(&encoded)) {
      return Error{ErrorCode::kUnavailable,
                   "the format " + std::string(output->format_name()) + " is not supported"};
    }
    const OIIO::ImageSpec spec = spec_of(image);
    if (!output->open(name, spec) || !output->write_image(spec.format, image.pixels, image.pixel_bytes) ||
        !output->close())
      return Error{ErrorCode::kUnavailable, output->geterror()};
    return std::move(encoded.buffer());
  }
};

}  // namespace

}  // namespace fanlight

extern "C" {

[[gnu::visibility("default")]] const char* fanlight_images_version() {
  return fanlight::version();
}

[[gnu::visibility("default")]] fanlight::ImageLibrary* fanlight_images_open() {
  static fanlight::Library library;
  return &library;
}
}
