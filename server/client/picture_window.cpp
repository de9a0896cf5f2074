// SPDX-License-Identifier: Apache-2.0
#include "server/client/picture_window.hpp"

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

constexpr int kFirstWidth = 1024;
constexpr int kFirstHeight = 768;
constexpr int kBarHeight = 44;
constexpr int kHintHeight = 30;
constexpr SDL_Color kText{235, 238, 240, 255};
constexpr SDL_Color kQuiet{150, 160, 168, 255};
constexpr SDL_Color kRefused{255, 190, 120, 255};

/// The colours of the page: each word has its own, and its own sign.
SDL_Color colour_of(DisplayState::Word word) {
  switch (word) {
    case DisplayState::Word::kLive:
      return {90, 210, 130, 255};
    case DisplayState::Word::kDelayed:
      return {255, 193, 70, 255};
    case DisplayState::Word::kFrozen:
      return {110, 185, 255, 255};
    case DisplayState::Word::kReplay:
      return {200, 160, 255, 255};
    case DisplayState::Word::kLost:
      return {255, 100, 90, 255};
    case DisplayState::Word::kWaiting:
      break;
  }
  return kQuiet;
}

Error sdl_error(const char* what) {
  return {ErrorCode::kUnavailable, fmt::format("{}: {}", what, SDL_GetError())};
}

/// The file of the system's usual sans-serif font; empty where there is none.
std::string font_file() {
  const std::unique_ptr<FcConfig, decltype(&FcConfigDestroy)> config(FcInitLoadConfigAndFonts(),
                                                                     &FcConfigDestroy);
  const std::unique_ptr<FcPattern, decltype(&FcPatternDestroy)> wanted(
      FcNameParse(reinterpret_cast<const FcChar8*>("sans-serif")), &FcPatternDestroy);
  if (!config || !wanted) return "";
  FcConfigSubstitute(config.get(), wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result{};
  const std::unique_ptr<FcPattern, decltype(&FcPatternDestroy)> found(
      FcFontMatch(config.get(), wanted.get(), &result), &FcPatternDestroy);
  FcChar8* file = nullptr;
  if (!found || FcPatternGetString(found.get(), FC_FILE, 0, &file) != FcResultMatch) return "";
  return reinterpret_cast<const char*>(file);
}

}  // namespace

Result<std::unique_ptr<PictureWindow>> PictureWindow::open(const std::string& name, bool full_screen) {
  std::unique_ptr<PictureWindow> window(new PictureWindow());
  if (auto started = window->start(name, full_screen); !started) return started.error();
  return window;
}

Result<void> PictureWindow::start(const std::string& name, bool full_screen) {
  SDL_SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "0");
  SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "linear");
  if (SDL_Init(SDL_INIT_VIDEO) != 0)
    return sdl_error(
        "there is no screen to open a window on, expected a desktop (DISPLAY or WAYLAND_DISPLAY)");
  if (TTF_Init() != 0) return sdl_error("the library of fonts does not start");
  has_fonts_ = true;
  auto bold = open_font(20);
  auto small = open_font(13);
  if (!bold) return bold.error();
  if (!small) return small.error();
  bold_ = *bold;
  small_ = *small;
  TTF_SetFontStyle(bold_, TTF_STYLE_BOLD);
  // A scanner's own screen may have no window manager, which would make the window as large as the screen.
  SDL_Rect place{SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, kFirstWidth, kFirstHeight};
  if (full_screen) SDL_GetDisplayBounds(0, &place);
  const Uint32 flags =
      full_screen ? SDL_WINDOW_FULLSCREEN_DESKTOP | SDL_WINDOW_BORDERLESS : SDL_WINDOW_RESIZABLE;
  window_ = SDL_CreateWindow(name.c_str(), place.x, place.y, place.w, place.h, flags);
  if (window_ == nullptr) return sdl_error("the window does not open");
  renderer_ = SDL_CreateRenderer(window_, -1, 0);
  if (renderer_ == nullptr) return sdl_error("the window cannot be drawn in");
  return {};
}

Result<TTF_Font*> PictureWindow::open_font(int points) {
  const std::string file = font_file();
  TTF_Font* const font = file.empty() ? nullptr : TTF_OpenFont(file.c_str(), points);
  if (font != nullptr) return font;
  return Error{ErrorCode::kUnavailable,
               "there is no font for text, expected one such as Debian's fonts-dejavu-core"};
}

PictureWindow::~PictureWindow() {
  if (texture_ != nullptr) SDL_DestroyTexture(texture_);
  if (renderer_ != nullptr) SDL_DestroyRenderer(renderer_);
  if (window_ != nullptr) SDL_DestroyWindow(window_);
  for (TTF_Font* const font : {bold_, small_}) {
    if (font != nullptr) TTF_CloseFont(font);
  }
  if (has_fonts_) TTF_Quit();
  SDL_Quit();
}

Result<void> PictureWindow::take_jpeg(const std::string& jpeg) {
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), &tjDestroy);
  const auto* const bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
  int width = 0;
  int height = 0;
  int sampling = 0;
  int space = 0;
  constexpr int kMostPixels = 16384;
  const bool known = decoder && tjDecompressHeader3(decoder.get(), bytes, jpeg.size(), &width, &height,
                                                    &sampling, &space) == 0;
  if (!known || std::max(width, height) > kMostPixels)
    return Error{ErrorCode::kInvalidArgument, "the server sent a picture that is no JPEG, expected one"};
  if (texture_ == nullptr || width != width_ || height != height_) {
    forget_picture();
    texture_ =
        SDL_CreateTexture(renderer_, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STREAMING, width, height);
    if (texture_ == nullptr) return sdl_error("there is no room for the picture");
    width_ = width;
    height_ = height;
  }
  void* pixels = nullptr;
  int pitch = 0;
  if (SDL_LockTexture(texture_, nullptr, &pixels, &pitch) != 0)
    return sdl_error("the picture cannot be drawn");
  const int decoded = tjDecompress2(decoder.get(), bytes, jpeg.size(), static_cast<unsigned char*>(pixels),
                                    width, pitch, height, TJPF_RGBA, 0);
  SDL_UnlockTexture(texture_);
  if (decoded == 0) return {};
  forget_picture();  // half of it may be drawn
  return Error{ErrorCode::kInvalidArgument, "the server sent a damaged picture"};
}

void PictureWindow::forget_picture() {
  if (texture_ != nullptr) SDL_DestroyTexture(texture_);
  texture_ = nullptr;
}

int PictureWindow::draw_text(TTF_Font* font, const std::string& text, int x, int y, SDL_Color colour,
                             bool right) {
  if (text.empty()) return 0;
  SDL_Surface* const drawn = TTF_RenderUTF8_Blended(font, text.c_str(), colour);
  if (drawn == nullptr) return 0;
  SDL_Texture* const texture = SDL_CreateTextureFromSurface(renderer_, drawn);
  const SDL_Rect to{right ? x - drawn->w : x, y - drawn->h / 2, drawn->w, drawn->h};
  SDL_FreeSurface(drawn);
  SDL_RenderCopy(renderer_, texture, nullptr, &to);
  SDL_DestroyTexture(texture);
  return to.w;
}

/// A disc for a live picture, two bars for a frozen one, a cross for a lost one, else a triangle: the word
/// does not depend on its colour.
void PictureWindow::draw_sign(DisplayState::Word word, int x, int y, int size) {
  const SDL_Color colour = colour_of(word);
  SDL_SetRenderDrawColor(renderer_, colour.r, colour.g, colour.b, 255);
  for (int row = -size; row <= size; ++row) {
    const auto line = [&](int from, int to) {
      SDL_RenderDrawLine(renderer_, x + from, y + row, x + to, y + row);
    };
    switch (word) {
      case DisplayState::Word::kLive: {
        const int half = static_cast<int>(std::sqrt(size * size - row * row));
        line(-half, half);
        break;
      }
      case DisplayState::Word::kFrozen:
        line(-size + 1, -3);
        line(3, size - 1);
        break;
      case DisplayState::Word::kLost:
        line(row - 2, row + 2);
        line(-row - 2, -row + 2);
        break;
      default:
        line(-size, size - std::abs(2 * row));
        break;
    }
  }
}

void PictureWindow::draw(const Texts& texts) {
  int width = 0;
  int height = 0;
  SDL_GetRendererOutputSize(renderer_, &width, &height);
  SDL_SetRenderDrawColor(renderer_, 0, 0, 0, 255);
  SDL_RenderClear(renderer_);
  const int room = std::max(1, height - kBarHeight - kHintHeight);
  if (texture_ != nullptr) {
    const double scale = std::min(static_cast<double>(width) / width_, static_cast<double>(room) / height_);
    shown_.w = static_cast<int>(std::lround(width_ * scale));
    shown_.h = static_cast<int>(std::lround(height_ * scale));
    shown_.x = (width - shown_.w) / 2;
    shown_.y = kBarHeight + (room - shown_.h) / 2;
    const Uint8 light = texts.condition.word == DisplayState::Word::kLost ? 110 : 255;
    SDL_SetTextureColorMod(texture_, light, light, light);
    SDL_RenderCopy(renderer_, texture_, nullptr, &shown_);
  }
  const SDL_Rect bar{0, 0, width, kBarHeight};
  SDL_SetRenderDrawColor(renderer_, 24, 29, 33, 255);
  SDL_RenderFillRect(renderer_, &bar);
  constexpr int kMargin = 14;
  const int middle = kBarHeight / 2;
  draw_sign(texts.condition.word, kMargin + 9, middle, 9);
  int x = kMargin + 30;
  x += draw_text(bold_, texts.condition.text, x, middle, colour_of(texts.condition.word)) + 18;
  x += draw_text(small_, texts.on_bar, x, middle, kText) + 18;
  draw_text(small_, texts.condition.reason, x, middle, kText);
  const int title = draw_text(small_, texts.title, width - kMargin, middle, kQuiet, true);
  draw_text(small_, texts.reach, width - kMargin - title - 18, middle, kText, true);
  draw_text(small_, texts.hint, kMargin, height - kHintHeight / 2, texts.hint_is_refusal ? kRefused : kQuiet);
  SDL_RenderPresent(renderer_);
}

SDL_FPoint PictureWindow::picture_point(int x, int y, double width, double height) const {
  if (shown_.w == 0) return {};
  return {static_cast<float>((x - shown_.x) * width / shown_.w),
          static_cast<float>((y - shown_.y) * height / shown_.h)};
}

double PictureWindow::pixels_per_point(double height) const {
  return shown_.h == 0 ? 1 : height / shown_.h;
}

PictureSize PictureWindow::pixel_size() const {
  int width = 0;
  int height = 0;
  SDL_GetRendererOutputSize(renderer_, &width, &height);
  return {.width = static_cast<std::uint32_t>(std::max(width, 1)),
          .height = static_cast<std::uint32_t>(std::max(1, height - kBarHeight - kHintHeight))};
}

void PictureWindow::leave_full_screen() {
  SDL_SetWindowFullscreen(window_, 0);
}

void PictureWindow::toggle_full_screen() {
  const bool is_full = (SDL_GetWindowFlags(window_) & SDL_WINDOW_FULLSCREEN_DESKTOP) != 0;
  SDL_SetWindowFullscreen(window_, is_full ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP);
}

}  // namespace fanlight
